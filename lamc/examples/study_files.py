"""Studies that ship with lamc: files of `lamc sweep`, each with a design of its own or one of the gallery.

In: a name, such as "leg". Out: its file; or a copy of it and of its design, to edit. Never: runs one.
"""

from pathlib import Path

from lamc.basics.checks import did_you_mean
from lamc.basics.errors import DesignError, LamcError

_FOLDER = Path(__file__).resolve().parent / "studies"
_END = "_study.yaml"


def names() -> tuple[str, ...]:
    """Names of all, sorted."""
    return tuple(sorted(path.name.removesuffix(_END) for path in _FOLDER.glob(f"*{_END}")))


def path(name: str) -> Path:
    """The file of a study. Raises DesignError with the nearest name."""
    if name not in names():
        raise DesignError(f"no study that ships is named {name[:40]!r}; {did_you_mean(name, names())}")
    return _FOLDER / f"{name}{_END}"


def copied(name: str, folder: Path) -> list[Path]:
    """Copies of a study and its design in a folder. Raises LamcError for a file that is there already."""
    files = [file for file in (path(name), _FOLDER / f"{name}.yaml") if file.exists()]
    made = [folder / file.name for file in files]
    for there in made:
        if there.exists():
            raise LamcError(f"{str(there)!r} is there already; name another folder with --copy")
    try:
        folder.mkdir(parents=True, exist_ok=True)
        for file, there in zip(files, made, strict=True):
            there.write_bytes(file.read_bytes())
    except OSError as error:
        raise LamcError(
            f"the folder {str(folder)!r} cannot be written to: {error.strerror or error}"
        ) from error
    return made
