"""Plate problems that ship with lamc, each with a story.

In: a name, such as "square". Out: an `Example`, the text of an editable file. Never: loads or solves one.
"""

import re
from pathlib import Path

from lamc import examples
from lamc.basics.errors import DesignError
from lamc.examples import Example, first_line
from lamc.run.request import did_you_mean

_FOLDER = Path(__file__).resolve().parent
_DESIGN = re.compile(r"design: \.\./(\w+)\.yaml")  # of the gallery, one folder up


def names() -> tuple[str, ...]:
    """Names of all examples, sorted."""
    return tuple(sorted(file.stem for file in _FOLDER.glob("*.yaml")))


def find(name: str) -> Example:
    """The example of that name. Raises DesignError with the nearest names, and says so where a design has this one."""
    if name not in names():
        if name.partition(":")[0] in examples.names():
            raise DesignError(
                f"{name[:60]!r} is an example of a design, not of a plate; write its file by `lamc examples "
                f"{name[:60]} --copy DIR` and solve one of its bodies: lamc plate DIR/FILE --body NAME"
            )
        raise DesignError(f"there is no plate example {name[:60]!r}; {did_you_mean(name, names())}")
    path = _FOLDER / f"{name}.yaml"
    text = path.read_text(encoding="utf-8")
    return Example(name, path.name, text, path, first_line(text))


def designs(example: Example) -> tuple[Example, ...]:
    """The designs that an example is about."""
    return tuple(examples.find(name) for name in _DESIGN.findall(example.text))


def beside(text: str) -> str:
    """The text of an example as it reads where its designs lie beside it."""
    return _DESIGN.sub(r"design: \1.yaml", text)
