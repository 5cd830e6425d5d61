"""For `make docs`: pages from the root of the repository and pages that lamc writes about itself join the site.

In: what mkdocs found in docs/. Out: the same with the pages of `AT_ROOT`, README.md as the home, those of
`make_reference.py`, pages that run of the gallery, and equations as MathML, which browsers draw without a script.
Writes no file.
"""

import re
import runpy
from collections.abc import Mapping
from pathlib import Path

from latex2mathml.converter import convert
from mkdocs.config.defaults import MkDocsConfig
from mkdocs.structure.files import File, Files

ROOT = Path(__file__).resolve().parent.parent
AT_ROOT = {
    name: name for name in ("ARCHITECTURE.md", "CHANGELOG.md", "CODE_OF_CONDUCT.md", "CONTRIBUTING.md")
}
AT_ROOT["README.md"] = "index.md"
GALLERY, LIVE = "guide/gallery.md", "guide/live"
WITH_EQUATIONS = ("guide/theory.md",)
_EQUATION = re.compile(r"\$\$\s*(.+?)\s*\$\$|\$([^$\n]+)\$", re.DOTALL)
_ACCENT = re.compile(r"<mover><mi>([^<]+)</mi><mo[^>]*>&#x0*(2D9|A8|AF);</mo></mover>")
_COMBINING = {"2D9": "\u0307", "A8": "\u0308", "AF": "\u0304"}


def on_files(files: Files, config: MkDocsConfig) -> Files:
    """Adds the pages at the root, their links to docs/ taken from within it, and the reference."""
    for source, page in AT_ROOT.items():
        text = (ROOT / source).read_text(encoding="utf-8")
        text = re.sub(r'(\]\(|src=")docs/', r"\1", text).replace("](README.md", "](index.md")
        files.append(File.generated(config, page, content=text))
    for page, content in _made("make_reference.py", "pages").items():
        files.append(File.generated(config, page, content=content))
    for name, content in _made("make_live.py", "live_pages").items():
        files.append(File.generated(config, f"{LIVE}/{name}.html", content=content))
    return files


def _made(script: str, function: str) -> Mapping[str, str]:
    pages: Mapping[str, str] = runpy.run_path(str(ROOT / "docs" / script))[function]()
    return pages


def _live(match: re.Match[str]) -> str:
    """The names of a row of the gallery's table as links."""
    return re.sub(r"`([\w.]+)`", r"[`\1`](live/\1.html)", match[0])


def on_page_markdown(markdown: str, page: object, config: MkDocsConfig, files: Files) -> str:
    """Links from docs/ to the root, such as ../../ARCHITECTURE.md, lead to the page of the site."""
    uri = str(page.file.src_uri)  # type: ignore[attr-defined]
    depth = uri.count("/")
    names = "|".join(re.escape(name) for name in AT_ROOT)
    text = re.sub(
        rf"\]\({'../' * (depth + 1)}({names})", lambda m: f"]({'../' * depth}{AT_ROOT[m[1]]}", markdown
    )
    if uri == GALLERY:
        text = re.sub(r"^\| `[^|]+\|", _live, text, flags=re.MULTILINE)
        text = text.replace("| name |", "| name: a page that runs |")
    return _EQUATION.sub(_drawn, text) if uri in WITH_EQUATIONS else text


def _drawn(match: re.Match[str]) -> str:
    shown, inline = match.groups()
    if shown:
        return f"\n{_accented(convert(shown, display='block'))}\n"
    return f"<span>{_accented(convert(inline))}</span>"  # a line that begins with math would be a paragraph


def _accented(math: str) -> str:
    """Dots and bars as combining characters: browsers without a font for mathematics leave others out."""
    return _ACCENT.sub(lambda m: f"<mi>{m[1]}{_COMBINING[m[2]]}</mi>", math)
