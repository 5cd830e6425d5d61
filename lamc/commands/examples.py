"""`lamc examples`: the designs that ship with lamc as a table, one of them with its story, or as a file to edit.

In: nothing, a name, or a name and a folder. Out: text or JSON, and the file that was asked for. It simulates
nothing and replaces no file.
"""

import os
import textwrap
from pathlib import Path
from typing import Any

from lamc import examples
from lamc.basics.errors import LamcError
from lamc.commands.schema import ALL_FILE
from lamc.commands.terminal import Terminal
from lamc.design.split import split
from lamc.examples import Example
from lamc.loops.rank import count_loops
from lamc.mechanism.plan import plan
from lamc.readers.load import load, load_text
from lamc.records.design import Design
from lamc.records.mechanism import Mechanism

_WIDTH = 100  # characters of a line of a story


def list_examples(terminal: Terminal) -> int:
    """A line for each example: name, loops, freedoms, what it is."""
    with terminal.progress() as progress:
        progress.stage("count loops")
        rows = [_facts(examples.find(name), name) for name in examples.names()]
    width = max(len(row["name"]) for row in rows)
    lines = [f"{'name':<{width}}  loops  freedoms  what it is"]
    lines += [f"{r['name']:<{width}}  {r['loops']:>5}  {r['freedoms']:>8}  {r['summary']}" for r in rows]
    lines += ["", "lamc examples NAME tells its story, lamc run --example NAME runs it,"]
    lines += ["and lamc examples NAME --copy DIR writes its file there, to edit."]
    lines += [
        f"Of any size: {'; '.join(f'NAME:{form}, {names}' for form, names in examples.forms().items())}."
    ]
    lines += ["Plates are listed by lamc plate --examples."]
    terminal.say("\n".join(lines))
    terminal.result({"ok": True, "examples": rows})
    return 0


def show_example(name: str, copy: str | None, terminal: Terminal) -> int:
    """One example's story, or with `copy`, its file written into that folder.

    Raises LamcError for a name that is not there, and where a file would be replaced or cannot be written.
    """
    example = examples.find(name)
    facts = _facts(example, example.name)
    written = copy_file(example, Path(copy)) if copy is not None else None
    where = example.path if example.path is not None else "made when it is asked for"
    parts = [
        f"{facts['name']}: {facts['summary']}",
        f"bodies {facts['bodies']}, hinges {facts['joints']}, loops {facts['loops']}, equations "
        f"{facts['equations']}, rank {facts['rank']}, freedoms {facts['freedoms']}",
        textwrap.fill(facts["story"], _WIDTH),
        f"file    {where}" if written is None else f"file    {written}",
        f"try     lamc run {written if written is not None else '--example ' + example.name}",
    ]
    terminal.say("\n\n".join(parts[:3]) + "\n\n" + "\n".join(parts[3:]))
    path = str(example.path) if example.path is not None else None
    terminal.result(
        {"ok": True, **facts, "path": path, "copy": str(written) if written is not None else None}
    )
    return 0


def mechanism_of_example(example: Example) -> Mechanism:
    """What the example holds, split if it is a design."""
    record = load(example.path) if example.path is not None else load_text(example.text, example.name)
    return split(record) if isinstance(record, Design) else record


def _facts(example: Example, name: str) -> dict[str, Any]:
    """What is told of an example, as plain data."""
    mechanism = mechanism_of_example(example)
    count = count_loops(plan(mechanism))
    return {
        "name": name,
        "summary": example.summary,
        "story": mechanism.story or example.story,
        "bodies": len(mechanism.bodies),
        "joints": len(mechanism.joints),
        "loops": count.loops,
        "equations": count.equations,
        "rank": count.rank,
        "freedoms": count.freedoms,
    }


def _for_editors(file_name: str, folder: Path) -> str:
    """The line by which editors find the schema, where `lamc schema --out` has put it beside the copy."""
    has_schema = file_name.endswith(".yaml") and (folder / ALL_FILE).is_file()
    return f"# yaml-language-server: $schema={ALL_FILE}\n" if has_schema else ""


def copy_file(example: Example, folder: Path) -> Path:
    """Writes the example's file into a folder, which is made if it is missing. Never replaces a file."""
    target = folder / example.file_name
    try:
        folder.mkdir(parents=True, exist_ok=True)
        # O_EXCL: two copies at once cannot both find the place free.
        handle = os.open(target, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o666)
    except FileExistsError as error:
        taken = target if folder.is_dir() else folder
        raise LamcError(
            f"{str(taken)!r} is there already and is not replaced; name another folder"
        ) from error
    except (OSError, ValueError) as error:
        reported = getattr(error, "strerror", None) or error
        raise LamcError(f"{str(target)!r} cannot be written: {reported}; name another folder") from error
    with os.fdopen(handle, "w", encoding="utf-8", newline="\n") as stream:
        stream.write(_for_editors(example.file_name, folder) + example.text)
    return target
