"""`lamc schema`: what lamc's files may say, as tables for people and as JSON Schema for editors.

In: the name of a part, or none; a folder. Out: text, the JSON Schema, or files of it.
"""

import json
import textwrap
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from lamc.basics.checks import did_you_mean
from lamc.basics.errors import LamcError
from lamc.basics.files import write_text
from lamc.commands.inputs import output_folder
from lamc.commands.terminal import print_out
from lamc.readers.schema import json_schema
from lamc.readers.schema_names import WHOLE, Part, called, definitions, parts
from lamc.report.schema_text import schema_table

_WIDTH = 112
_FILES = {
    "design": "Design",
    "mechanism": "Mechanism",
    "scene": "Scene",
    "scenes": "Scenes",
    "plate": "PlateProblem",
    "study": "Study",
}
ALL_FILE = "lamc.schema.json"


def schema(name: str | None, out: str | None, *, as_json: bool, listed: bool) -> int:
    """The table of a part with `name`, the list of parts with `listed`; else the JSON Schema of all files."""
    if out is not None:
        return _write(out)
    if name is not None:
        return _show(part_of(name), as_json=as_json)
    if listed:
        print_out(_overview())
        return 0
    print_out(json.dumps(json_schema(WHOLE), indent=2, ensure_ascii=True))
    return 0


def part_of(name: str) -> Part:
    """The part of that name: singular or plural, with - or _. Raises LamcError with the nearest name."""
    known = parts()
    wanted = name.strip().lower().replace("-", "_")
    last = wanted.rsplit(".", 1)[-1]  # of "design.hinges"
    for each in (wanted, wanted.removesuffix("s"), last, last.removesuffix("s")):
        if each in known:
            return known[each]
    if last in ("effect", "effects"):
        raise LamcError("`lamc effects` lists the effects, and `lamc effects NAME` shows the fields of one")
    raise LamcError(
        f"no part of lamc's files is named {name[:40]!r}; {did_you_mean(wanted, list(known))} "
        "`lamc schema --list` has them all, and `lamc effects` those that act in a scene"
    )


def part_text(part: Part) -> str:
    """What a part is, its table and an example."""
    whole = part.said if part.is_effect else textwrap.fill(" ".join(part.said.split()), _WIDTH)
    example = textwrap.indent(part.example, "  ")
    pieces = [f"{part.name}: {whole}" if whole else part.name]
    pieces += [schema_table(part.definition, called)] if _has_fields(part.definition) else []
    pieces += [f"example\n{example}"] if part.example else []
    return "\n\n".join(pieces)


def _has_fields(definition: Mapping[str, Any]) -> bool:
    """False for effects that take no value."""
    whole = next((each for each in definition.get("anyOf", ()) if "properties" in each), definition)
    return bool(whole.get("properties", True))


def _show(part: Part, *, as_json: bool) -> int:
    if not as_json:
        print_out(
            f"{part_text(part)}\n\nNumbers without a unit are SI, and lengths in the file's units; '3 N*mm/deg' brings "
            "its own."
        )
        return 0
    found = {"$schema": "https://json-schema.org/draft/2020-12/schema", **part.definition}
    print_out(json.dumps(found | {"$defs": definitions()}, indent=2, ensure_ascii=True))
    return 0


def _overview() -> str:
    known = parts()
    width = max(map(len, known))
    lines = []
    for title, chosen in (
        ("files", [known[name] for name in _FILES]),
        ("their parts", [part for part in known.values() if part.name not in _FILES and not part.is_effect]),
        ("effects", [part for part in known.values() if part.is_effect]),
    ):
        lines += [title, *(_line(part, width) for part in chosen), ""]
    lines += ["lamc schema NAME shows one with its fields, units and defaults; --json prints JSON Schema,"]
    lines += ["and --out DIR writes it for editors."]
    return "\n".join(lines)


def _line(part: Part, width: int) -> str:
    return f"  {part.name:<{width}}  {textwrap.shorten(part.summary, _WIDTH - width - 4, placeholder=' …')}"


def _write(out: str) -> int:
    """One file for each kind of file, and one for all, and how an editor finds them."""
    texts = {f"{name}.schema.json": json_schema({of: WHOLE[of]}) for name, of in _FILES.items()}
    texts[ALL_FILE] = json_schema(WHOLE)
    with output_folder(out, "schema") as folder:
        for file, data in texts.items():
            write_text(Path(folder) / file, json.dumps(data, indent=2, ensure_ascii=True) + "\n")
    print_out(
        f"files   {out}: {', '.join(texts)}\n\n"
        "Editors with a YAML language server (VS Code: Red Hat's extension) check and complete a file that begins\n\n"
        f"  # yaml-language-server: $schema={Path(out, ALL_FILE).as_posix()}\n\n(the path counts from the file)"
    )
    return 0
