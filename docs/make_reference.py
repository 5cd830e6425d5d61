"""Pages of the site that lamc writes about itself: what files may say, effects, the public names of Python.

In: lamc's own schemas, effects and `__all__`. Out: text in Markdown and pictures, by path within the site; `make docs`
takes them (`docs/site_hook.py`). Writes no file of its own.
"""

import tempfile
from collections.abc import Iterator
from importlib import import_module
from pathlib import Path
from types import FunctionType

import lamc
from lamc import plate
from lamc.design.split import split_steps
from lamc.effects.registry import by_name
from lamc.readers.load import load_text
from lamc.readers.schema_names import Part, called, parts
from lamc.report.schema_text import field_rows
from lamc.report.split_picture import draw_split

FILES = ("design", "mechanism", "scene", "scenes", "plate")
DRAWN = "reference/design.png"
NAMES = ("reference/format.md", "reference/effects.md", "reference/api.md", "reference/plates.md")


def pages() -> dict[str, str | bytes]:
    """Text of each of `NAMES`, and the bytes of their pictures."""
    known = parts()
    return {
        "reference/format.md": _format([part for part in known.values() if not part.is_effect]),
        "reference/effects.md": _effects([part for part in known.values() if part.is_effect]),
        "reference/api.md": _names("Python", "lamc", lamc.__all__),
        "reference/plates.md": _names("Python: plates", "lamc.plate", plate.__all__),
        DRAWN: _drawing(known["design"].example),
    }


def _format(known: list[Part]) -> str:
    intro = (
        "# What files may say\n\n"
        "The same as `lamc schema NAME` shows. Numbers without a unit are SI, and lengths count in the file's `units`; "
        "`3 N*mm/deg` brings its own. JSON Schema for editors: `lamc schema --out schemas`.\n"
    )
    drawn = "\n![What is cut, and which bodies are left](design.png)\n\n*`lamc split` draws the example.*\n"
    sections = [
        f"\n## {part.name}\n\n{part.said}\n\n{_table(part)}\n{_example(part)}{drawn if part.name == 'design' else ''}"
        for part in sorted(known, key=lambda part: part.name not in FILES)
    ]
    return intro + "".join(sections)


def _effects(known: list[Part]) -> str:
    kinds = by_name()
    sections = [
        f"\n## {part.name}\n\n{part.summary}: `lamc.{kinds[part.name].__name__}`. {kinds[part.name].source}\n\n"
        f"```text\n{part.said}\n```\n\n{_table(part)}\n{_example(part)}"
        for part in known
    ]
    return "# Effects, field by field\n\nThe same as `lamc effects NAME` shows.\n" + "".join(sections)


def _table(part: Part) -> str:
    rows = [row for row in field_rows(part.definition, called) if row.name]
    if not rows:
        return ""
    lines = ["| field | type | unit | default | meaning |", "|---|---|---|---|---|"]
    for row in rows:
        cells = (f"`{row.name}`", row.type, row.unit, row.default, row.meaning)
        lines.append("| " + " | ".join(_escaped(cell) for cell in cells) + " |")
    return "\n".join(lines) + "\n"


def _escaped(text: str) -> str:
    for sign in ("|", "*", "<", "["):
        text = text.replace(sign, f"\\{sign}")
    return text


def _example(part: Part) -> str:
    return f"\n```yaml\n{part.example}\n```\n" if part.example else ""


def _names(title: str, module: str, names: list[str]) -> str:
    return f"# {title}\n\n" + "\n".join(_entries(module, names))


def _entries(module: str, names: list[str]) -> Iterator[str]:
    """Where each is defined: `lamc.export` is a package, too."""
    for name in sorted(names, key=str.lower):
        if not name.startswith("_"):
            thing = getattr(import_module(module), name)
            own = isinstance(thing, type | FunctionType) and thing.__name__ == name
            yield f"::: {thing.__module__}.{name}\n" if own else f"::: {module}.{name}\n"


def _drawing(text: str) -> bytes:
    """The picture of `lamc split`."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "design.png")
        draw_split(split_steps(load_text(text, "flap")), path)  # type: ignore[arg-type]
        return path.read_bytes()
