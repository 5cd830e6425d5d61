"""Colours as drawings write them, in any of CSS's notations, and which of the six colours of creases they are near.

In: text. Out: red, green and blue, 0 to 255, and opacity. Never: takes what it cannot read for black.
"""

import colorsys
import math
import re
from functools import lru_cache

Colour = tuple[int, int, int]

FAMILIES: dict[str, Colour] = {
    "red": (255, 0, 0),
    "yellow": (255, 255, 0),
    "green": (0, 255, 0),
    "blue": (0, 0, 255),
    "magenta": (255, 0, 255),
    "black": (0, 0, 0),
}
# Hue, degrees: from, to. Red to the eye ends before orange at 30; printers' red is #ed1c24, green #00a651 (149), blue
# #0071bc (204), magenta #ec008c (324), yellow #fff200 (57), drawing programs' purple 300.
_HUES = {
    "red": (340.0, 20.0),
    "yellow": (45.0, 72.0),
    "green": (90.0, 155.0),
    "blue": (200.0, 265.0),
    "magenta": (285.0, 332.0),
}
_SATURATION, _VALUE = 0.5, 0.4  # at least; less is grey or pastel, brown or nearly black
_BLACK = 0.25  # of the brightest channel, at most: printers' black is #231f20, a dark grey #404040
_SAME = 5  # of 255: what converting colours between programs changes

_HEX = re.compile(r"#([0-9a-f]{3,4}|[0-9a-f]{6}|[0-9a-f]{8})\Z")
_NUMBER = r"[+-]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:e[+-]?[0-9]{1,3})?"
_CALL = re.compile(r"(rgba?|hsla?)\(([^()]*)\)\Z")
_PART = re.compile(rf"({_NUMBER})(%|deg|rad|turn|grad)?\Z")
_TURN = {"deg": 1 / 360, "": 1 / 360, "rad": 0.5 / math.pi, "turn": 1.0, "grad": 1 / 400}


@lru_cache(4096)
def colour_of(text: str) -> tuple[Colour, float] | None:
    """A colour and its opacity, 0 to 1; None for what is no colour, such as "none" or "url(#a)"."""
    word = text.strip().lower()
    if " icc-color(" in word:
        word = word.partition(" icc-color(")[0].strip()
    found = _HEX.match(word)
    if found:
        digits = found[1]
        pairs = [c + c for c in digits] if len(digits) < 6 else re.findall("..", digits)
        red, green, blue, alpha = ([int(pair, 16) for pair in pairs] + [255])[:4]
        return (red, green, blue), alpha / 255.0
    call = _CALL.match(word)
    if call:
        return _called(call[1][:3], call[2])
    if word == "transparent":
        return (0, 0, 0), 0.0
    from PIL.ImageColor import colormap  # CSS's names; files of other formats do without it

    named = colormap.get(word)
    if isinstance(
        named, tuple
    ):  # Pillow puts numbers in the place of the text of a name that it has looked up
        return (named[0], named[1], named[2]), 1.0
    return colour_of(named) if named is not None else None


@lru_cache(4096)
def shown_colour(colour: Colour) -> str:
    """ "#ff0000"."""
    return "#" + "".join(f"{channel:02x}" for channel in colour)


@lru_cache(4096)
def family_of(colour: Colour) -> tuple[str, bool] | None:
    """Which of the six colours it is or is near, and whether it is that colour itself."""
    for name, pure in FAMILIES.items():
        if max(abs(a - b) for a, b in zip(colour, pure, strict=True)) <= _SAME:
            return name, True
    hue, saturation, value = colorsys.rgb_to_hsv(*(channel / 255.0 for channel in colour))
    if value <= _BLACK:
        return "black", False
    if saturation < _SATURATION or value < _VALUE:
        return None
    for name, (low, high) in _HUES.items():
        if (360.0 * hue - low) % 360.0 <= (high - low) % 360.0:
            return name, False
    return None


def _called(function: str, inside: str) -> tuple[Colour, float] | None:
    """What rgb(…) or hsl(…) says, with commas or without."""
    words = inside.replace(",", " ").replace("/", " ").split()
    parts = [_PART.match(word) for word in words]
    if len(parts) not in (3, 4) or not all(parts):
        return None
    numbers = [(float(part[1]), part[2] or "") for part in parts if part]
    alpha = _share(*numbers[3], 1.0) if len(numbers) == 4 else 1.0
    if function == "rgb":
        channels = [_share(*number, 255.0) for number in numbers[:3]]
    else:
        (hue, unit), lightness, saturation = numbers[0], numbers[2][0] / 100.0, numbers[1][0] / 100.0
        turns = (hue * _TURN.get(unit, 1 / 360)) % 1.0
        channels = list(colorsys.hls_to_rgb(turns, _within(lightness), _within(saturation)))
    red, green, blue = (round(255.0 * channel) for channel in channels)
    return (red, green, blue), alpha


def _share(number: float, unit: str, whole: float) -> float:
    return _within(number / (100.0 if unit == "%" else whole))


def _within(number: float) -> float:
    return min(max(number, 0.0), 1.0)
