"""`lamc plate --examples`, and `--copy`: the plates that ship with lamc as a list, or one of them as a file to edit.

In: nothing, or a name and a folder. Out: text or JSON, and the files. It solves nothing and replaces no file.
"""

import textwrap
from dataclasses import replace
from pathlib import Path

from lamc.basics.errors import LamcError
from lamc.commands.examples import copy_file
from lamc.commands.terminal import Terminal
from lamc.examples import plates
from lamc.readers.plates.problem_file import load_plate

_WIDTH = 100  # characters of a line of a story


def list_examples(terminal: Terminal) -> int:
    """A line for each example."""
    found = [plates.find(name) for name in plates.names()]
    width = max(len(example.name) for example in found)
    lines = [f"{example.name:<{width}}  {example.summary}" for example in found]
    lines += ["", "lamc plate --example NAME solves it; with --copy DIR it writes its file there, to edit."]
    terminal.say("\n".join(lines))
    terminal.result({"ok": True, "examples": [{"name": e.name, "summary": e.summary} for e in found]})
    return 0


def copy_example(name: str | None, folder: str, terminal: Terminal) -> int:
    """Writes an example's file into a folder, and beside it the design that it is about.

    Raises LamcError without a name, for one that is not there, and where a file would be replaced.
    """
    if name is None:
        raise LamcError("--copy needs the name of an example: lamc plate --example NAME --copy DIR")
    example = plates.find(name)
    written = [
        copy_file(replace(example, text=plates.beside(example.text)), Path(folder)),
        *(copy_file(design, Path(folder)) for design in plates.designs(example)),
    ]
    assert example.path is not None
    story = textwrap.fill(load_plate(example.path).story, _WIDTH)
    lines = [f"{example.name}: {example.summary}", "", story, ""]
    lines += [f"file    {path}" for path in written]
    terminal.say("\n".join([*lines, f"try     lamc plate {written[0]}"]))
    terminal.result(
        {"ok": True, "name": example.name, "story": story, "files": [str(path) for path in written]}
    )
    return 0
