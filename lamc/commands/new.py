"""`lamc new`: a project to start from.

In: a folder that is not there or is empty, a kind. Out: design.yaml, scene.yaml and README.md in it. Never: replaces a
file, or puts one beside others.
"""

import shlex
import shutil
from importlib.resources import files
from pathlib import Path

from lamc.basics.checks import checked_name
from lamc.basics.errors import LamcError
from lamc.basics.files import fresh_folder
from lamc.basics.yaml_text import scalar
from lamc.commands.terminal import Terminal
from lamc.export.markdown import markdown

WHAT = {
    "laminate": "A laminate of boards and film with two hinges",
    "sheet": "A sheet of card with two creases",
    "mechanism": "Two bodies and two hinges, without a drawing",
}
NEXT = {
    "laminate": (
        "lamc run design.yaml --film  # simulate it; pictures, tables and a film",
        "lamc view design.yaml --scene scene.yaml:driven  # a page that shows it move",
        "lamc export design.yaml --to cut --kerf '0.1 mm'  # drawings for a laser cutter",
    ),
    "sheet": (
        "lamc run design.yaml --film  # simulate it; pictures, tables and a film",
        "lamc view design.yaml --scene scene.yaml:opened  # a page that shows it move",
        "lamc export design.yaml --to cut --hinge-style perforated  # drawings for a laser cutter",
    ),
    "mechanism": (
        "lamc run design.yaml --film  # simulate it; pictures, tables and a film",
        "lamc view design.yaml --scene scene.yaml:driven  # a page that shows it move",
        "lamc export design.yaml --scene scene.yaml:driven  # its simulator in C, for other programs",
    ),
}
_FILES = ("design.yaml", "scene.yaml")


def new(folder: str, kind: str, terminal: Terminal) -> int:
    """Writes the project, and says what comes next. Raises LamcError for a folder that holds anything."""
    path = Path(folder)
    name = checked_name(path.resolve().name, "the project, which is named after its folder,")
    contents = project(name, kind)
    _write(path, contents)
    commands = [line.partition("  #")[0] for line in NEXT[kind]]
    lines = [f"folder    {path}", f"files     {', '.join(contents)}"]
    lines += [f"{'next' if k == 0 else '':<10}{line}" for k, line in enumerate(_from(path, commands))]
    terminal.say("\n".join(lines))
    terminal.result(
        {"ok": True, "folder": str(path), "kind": kind, "files": list(contents), "next": commands}
    )
    return 0


def project(name: str, kind: str) -> dict[str, str]:
    """Texts of the files, by name."""
    source = files("lamc.examples").joinpath("projects")
    made = {
        file: source.joinpath(kind, file).read_text(encoding="utf-8").replace("@NAME@", scalar(name))
        for file in _FILES
    }
    readme = source.joinpath("README.md").read_text(encoding="utf-8")
    said = {"@TITLE@": markdown(name), "@WHAT@": WHAT[kind], "@COMMANDS@": "\n".join(NEXT[kind])}
    for mark, text in said.items():
        readme = readme.replace(mark, text)
    return made | {"README.md": readme}


def _from(path: Path, commands: list[str]) -> list[str]:
    """Commands for a shell that stands where the folder was named."""
    return [f"cd {shlex.quote(str(path))}", *commands] if path.resolve() != Path.cwd() else commands


def _write(path: Path, contents: dict[str, str]) -> None:
    """All files at once: the folder appears in one rename where it was not there.

    Raises LamcError for one that holds anything, and for what the system refuses."""
    if path.exists() and not path.is_dir():
        raise LamcError(f"{str(path)!r} is a file; name a folder")
    try:
        if path.is_dir() and any(path.iterdir()):
            raise LamcError(f"the folder {str(path)!r} is not empty; name one that is not there yet")
        path.parent.mkdir(parents=True, exist_ok=True)
        staged = fresh_folder(path.parent, ".lamc-new-")
        try:
            for name, text in contents.items():
                (staged / name).write_text(text, encoding="utf-8", newline="\n")
            if path.is_dir():
                for name in contents:
                    (staged / name).rename(path / name)  # into an empty folder, which may be the present one
            else:
                staged.rename(path)
        finally:
            shutil.rmtree(staged, ignore_errors=True)
    except (OSError, ValueError) as error:  # a null character in the path is a ValueError
        reported = getattr(error, "strerror", None) or error
        raise LamcError(f"the folder {str(path)!r} cannot be written: {reported}; name another") from error
