"""The gallery: designs that ship with lamc, each hard in its own way, each with a story.

In: a name, such as "pendulum", or "miura:4x5" for a design that is made to a size. Out: an `Example`, the text of an
editable file. Never: loads or simulates one.
"""

import re
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from lamc.basics.errors import DesignError
from lamc.examples.miura import miura
from lamc.examples.n_four_bar import n_four_bar
from lamc.examples.patterns import kresling, resch, waterbomb, yoshimura
from lamc.run.request import did_you_mean

_FOLDER = Path(__file__).resolve().parent
_MOST_FACETS = 1024  # a sheet of 32 x 32
_MOST_WINDOWS = 40  # beyond them, compiling takes minutes
# Files of others, which cannot hold a line and a story of ours.
_FOREIGN = {
    "pendulum.cad": (
        "popupCAD's own triple pendulum, as popupCAD saved it.",
        "The validation case of the popupCAD papers: one sheet of five layers, hinged along three lines, so that three "
        "square links of 1 m hang from a fixed end. Nothing about it is hard for a tree of hinges; it is the file that "
        "shows that a drawing made elsewhere runs as it is. Look at the third hinge: its line is drawn the other way "
        "round, so its angle counts the other way.",
    )
}


@dataclass(frozen=True)
class Example:
    """A design that ships with lamc.

    name       as it was asked for
    file_name  of the editable file
    text       what the file holds
    path       the file in the package; None for one that is made to a size
    summary    one line on what it is
    story      of a file that cannot hold one; else empty, and the design itself has it
    """

    name: str
    file_name: str
    text: str
    path: Path | None
    summary: str
    story: str = ""


@dataclass(frozen=True)
class _Generator:
    """A design made to a size. `make` takes the numbers of a name "NAME:SIZE" in the order of the pattern's groups."""

    pattern: str
    form: str  # of the size, for messages
    default: str
    make: Callable[..., str]
    least: int  # of the product of the numbers
    most: int
    what: str  # is counted by that product


_SHEET = r"(\d{1,4})x(\d{1,4})", "COLUMNSxROWS"
_GENERATORS = {
    "kresling": _Generator(*_SHEET, "3x3", kresling, 2, _MOST_FACETS // 2, "cells of two facets"),
    "miura": _Generator(*_SHEET, "3x3", miura, 2, _MOST_FACETS, "facets"),
    "n_four_bar": _Generator(r"(\d{1,4})", "N", "2", n_four_bar, 1, _MOST_WINDOWS, "windows"),
    "resch": _Generator(*_SHEET, "2x2", resch, 1, _MOST_FACETS // 8, "stars of six facets"),
    "waterbomb_sheet": _Generator(*_SHEET, "2x2", waterbomb, 1, _MOST_FACETS // 6, "cells of six facets"),
    "yoshimura": _Generator(*_SHEET, "3x3", yoshimura, 2, _MOST_FACETS // 2, "cells of two facets"),
}


def files() -> tuple[str, ...]:
    """Names of the examples that are files, sorted."""
    return tuple(sorted([*(file.stem for file in _FOLDER.glob("*.yaml")), *_FOREIGN]))


def names() -> tuple[str, ...]:
    """Names of all examples, sorted; those made to a size, without one."""
    return tuple(sorted([*files(), *_GENERATORS]))


def forms() -> dict[str, str]:
    """Forms of sizes, such as "COLUMNSxROWS", and the names of the examples that are made to one."""
    made = {generator.form for generator in _GENERATORS.values()}
    return {
        form: ", ".join(sorted(n for n, g in _GENERATORS.items() if g.form == form)) for form in sorted(made)
    }


def find(name: str) -> Example:
    """The example of that name. Raises DesignError with the nearest names, or for a size that makes no design."""
    stem, colon, size = name.partition(":")
    if stem in _GENERATORS:
        return _generated(stem, size if colon else _GENERATORS[stem].default)
    if colon and stem in files():
        sized = ", ".join(sorted(_GENERATORS))
        raise DesignError(f"the example {stem!r} has one size; only these are made to a size: {sized}")
    if name not in files():
        raise DesignError(f"there is no example {name[:60]!r}; {did_you_mean(name, names())}")
    path = _FOLDER / (name if name in _FOREIGN else f"{name}.yaml")
    text = path.read_text(encoding="utf-8")
    return Example(name, path.name, text, path, *_FOREIGN.get(name, (first_line(text),)))


def path(name: str) -> Path:
    """The file of an example in the package. Raises DesignError as `find` does, and for one made to a size."""
    example = find(name)
    if example.path is None:
        raise DesignError(
            f"the example {name!r} is made when it is asked for and has no file; write one with "
            f"`lamc examples {name} --copy DIR`"
        )
    return example.path


def _generated(stem: str, size: str) -> Example:
    generator = _GENERATORS[stem]
    match = re.fullmatch(generator.pattern, size, re.ASCII)
    if match is None:
        raise DesignError(
            f"{size[:40]!r} is no size of the example {stem!r}; write {stem}:{generator.form}, such as "
            f"{stem}:{generator.default}"
        )
    numbers = [int(text) for text in match.groups()]
    count = 1
    for number in numbers:
        count *= number
    if not generator.least <= count <= generator.most:
        raise DesignError(
            f"{stem}:{size} has {count} {generator.what}; it must have {generator.least} to {generator.most}"
        )
    shown = "x".join(str(number) for number in numbers)
    text = generator.make(*numbers)
    return Example(f"{stem}:{shown}", f"{stem}_{shown}.yaml", text, None, first_line(text))


def first_line(text: str) -> str:
    """The comment that opens a file of ours."""
    return text.partition("\n")[0].removeprefix("# ")
