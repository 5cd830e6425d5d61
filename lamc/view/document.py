"""The page itself: parts of `templates/view/` and packed data as one HTML text.

In: shows as plain data. Out: HTML that needs no file beside it and no network. Names of a design stand in packed data,
in escaped text, and nowhere else: none is ever markup or code. Never: decides what is shown.
"""

import html
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path
from typing import Any

from lamc.basics._version import __version__
from lamc.basics.files import write_text
from lamc.basics.resources import data_dir
from lamc.codegen.emit import environment
from lamc.view.pack import packed

MOST_BYTES = 300_000  # of a page with ten seconds of an ordinary device
_CORE = (
    "unpack.js",
    "maths.js",
    "motion.js",
    "kinematics.js",
    "yaml.js",
)  # without a DOM: node runs them too
_SERVING = ("engine.js",)  # which a worker has too
_SIGHT = ("dom.js", "shaders.js", "camera.js", "gl.js", "flat.js", "stage.js", "curves.js", "sliders.js")
_SHOWS = ("device.js", "model.js", "plate.js", "page.js")


@dataclass(frozen=True, eq=False)
class Show:
    """One picture of a page with what belongs to it.

    data    plain data with arrays, for `templates/view/device.js` or `plate.js`
    engine  JavaScript that defines `simulatorOf`, of a model that is in the data; empty: none is
    notes   sentences below the picture
    failed  why a run ended before its time; empty: it did not
    """

    name: str
    facts: str
    data: Mapping[str, Any]
    engine: str = ""
    notes: tuple[str, ...] = field(default=())
    failed: str = ""


def page(shows: Sequence[Show], title: str | None = None) -> str:
    """The HTML."""
    engines: list[str] = []
    entries = []
    for show in shows:
        entry = dict(show.data)
        if show.engine:
            engines.append(show.engine)
            entry["live"] = {**entry["live"], "engine": len(engines) - 1}
        entries.append(entry)
    notes = dict.fromkeys(note for show in shows for note in show.notes)
    context = {
        "title": _text(title or " · ".join(dict.fromkeys(show.name for show in shows))),
        "facts": _text(shows[0].facts if len(shows) == 1 else ""),
        "notes": [_text(note) for note in notes],
        "version": __version__,
        "css": _joined("page.css"),
        "data": packed({"shows": entries}),
        "engines": [_lean(engine) for engine in engines],
        "serving": _joined(*_SERVING),
        "script": _joined(*_CORE, *_SIGHT, *_SHOWS),
    }
    return environment().get_template("view/page.html.j2").render(context)


def write_page(text: str, path: Path) -> Path:
    """Whole or not at all."""
    write_text(path, text)
    return path


def framed(text: str, height: int = 720) -> str:
    """The page in a frame of its own, which can neither reach the page around it nor the network's cookies: for
    notebooks."""
    source = html.escape(text, quote=True)
    style = f"width:100%;height:{height}px;border:0"
    return f'<iframe sandbox="allow-scripts" style="{style}" loading="lazy" srcdoc="{source}"></iframe>'


def core() -> str:
    """The parts of the page's JavaScript that need no browser."""
    return _joined(*_CORE, *_SERVING)


def _text(text: str) -> str:
    return html.escape("".join(ch if ch.isprintable() else " " for ch in text))


@cache
def _joined(*names: str) -> str:
    folder = data_dir("templates") / "view"
    return "\n".join(_lean((folder / name).read_text(encoding="utf-8")) for name in names)


def _lean(text: str) -> str:
    """Without comments that stand on lines of their own, and without the indentation: a page is read by browsers."""
    text = re.sub(r"^\s*/\*\*?.*?\*/\s*$", "", text, flags=re.DOTALL | re.MULTILINE)
    lines = (line.strip() for line in text.splitlines())
    return "\n".join(line for line in lines if line and not line.startswith("// "))
