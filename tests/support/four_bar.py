"""The shipped four-bar as it is without parameters: each expression as the number that it is."""

import re

from lamc.examples import find

SIZES = {"arm_length": "40", "link_length": "48", "gap": "2"}  # mm, the defaults


def written_out() -> str:
    """Its text, whose corners are plain numbers; the design that it tells is the same."""
    text = re.sub(r"(?m)^parameters:.*\n(?:  .*\n)*", "", find("four_bar").text)
    for name, size in SIZES.items():
        text = re.sub(rf"(?<!^    ){name}\b(?!:)", size, text)
    return re.sub(r"\[([-+*/. \d]+(?:, [-+*/. \d]+)+)\]", _numbers, text)


def _numbers(found: re.Match[str]) -> str:
    return "[" + ", ".join(f"{_value(term):g}" for term in found[1].split(", ")) + "]"


def _value(term: str) -> float:
    """Of a sum of numbers and halves, such as 6 + 48 - 2/2."""
    total = 0.0
    for sign, number, divisor in re.findall(r"([-+]?)\s*([\d.]+)(?:/([\d.]+))?", term):
        total += float(f"{sign}{number}") / float(divisor or 1)
    return total
