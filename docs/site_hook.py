"""For `make docs`: pages at the root of the repository become pages of the site, and links still lead there.

In: what mkdocs found in docs/. Out: the same with the pages of `AT_ROOT`, README.md as the home. Writes no file.
"""

import re
from pathlib import Path

from mkdocs.config.defaults import MkDocsConfig
from mkdocs.structure.files import File, Files

ROOT = Path(__file__).resolve().parent.parent
AT_ROOT = {
    name: name for name in ("ARCHITECTURE.md", "CHANGELOG.md", "CODE_OF_CONDUCT.md", "CONTRIBUTING.md")
}
AT_ROOT["README.md"] = "index.md"


def on_files(files: Files, config: MkDocsConfig) -> Files:
    """Adds the pages at the root, their links to docs/ taken from within it."""
    for source, page in AT_ROOT.items():
        text = (ROOT / source).read_text(encoding="utf-8")
        text = re.sub(r'(\]\(|src=")docs/', r"\1", text).replace("](README.md", "](index.md")
        files.append(File.generated(config, page, content=text))
    return files


def on_page_markdown(markdown: str, page: object, config: MkDocsConfig, files: Files) -> str:
    """Links from docs/ to the root, such as ../../ARCHITECTURE.md, lead to the page of the site."""
    depth = str(page.file.src_uri).count("/")  # type: ignore[attr-defined]
    names = "|".join(re.escape(name) for name in AT_ROOT)
    return re.sub(
        rf"\]\({'../' * (depth + 1)}({names})", lambda m: f"]({'../' * depth}{AT_ROOT[m[1]]}", markdown
    )
