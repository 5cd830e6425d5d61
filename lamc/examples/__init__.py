"""Designs that ship with lamc, each a native file with a word on what it shows."""

from pathlib import Path

from lamc.errors import LamcError

_FOLDER = Path(__file__).resolve().parent


def names() -> tuple[str, ...]:
    """Names of the examples, sorted."""
    return tuple(sorted(file.stem for file in _FOLDER.glob("*.yaml")))


def path(name: str) -> Path:
    """The example's file. Raises LamcError with the names there are."""
    if name not in names():
        raise LamcError(f"there is no example {name!r}; the examples are {', '.join(names())}")
    return _FOLDER / f"{name}.yaml"
