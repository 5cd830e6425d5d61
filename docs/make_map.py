"""Writes `docs/map.md`: every module of lamc in one line, taken from the module's own docstring.

`make map` writes it; `tests/docs/test_documents.py` holds the file against the modules. Raises ValueError for a module
without a docstring.
"""

import ast
import sys
import tomllib
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
MAP = ROOT / "docs" / "map.md"
OPENING = """# Map

Every module in a line, floor by floor from the ground up: a floor imports from those before it only. The lines are the
first paragraphs of the modules' docstrings; `make map` writes this page. [Architecture](../ARCHITECTURE.md) is the
short form, [Inside](inside.md) says how runtime, plates and exports hang together.
"""


def floors() -> list[str]:
    """Names below `lamc`, lowest first, as import-linter holds them; what it does not name comes last."""
    contracts = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["tool"]["importlinter"]
    (order,) = [contract["layers"] for contract in contracts["contracts"] if contract["type"] == "layers"]
    known = [name.removeprefix("lamc.") for name in reversed(order)]
    there = {path.stem for path in (ROOT / "lamc").iterdir() if path.suffix == ".py" or _is_package(path)}
    return [*known, *sorted(there - set(known))]


def _is_package(path: Path) -> bool:
    return (path / "__init__.py").is_file()


def line_of(path: Path) -> str:
    """The first paragraph of a module's docstring, in one line."""
    text = ast.get_docstring(ast.parse(path.read_text(encoding="utf-8")))
    if not text:
        raise ValueError(
            f"{path.relative_to(ROOT)} has no docstring; begin it with what goes in and what comes out"
        )
    return " ".join(text.split("\n\n")[0].split()).replace("|", "\\|")


def whole() -> str:
    """The text of the page."""
    parts = [OPENING]
    alone = []
    for floor in floors():
        package = ROOT / "lamc" / floor
        if not _is_package(package):
            alone.append(package.with_suffix(".py"))
            continue
        parts.append(
            f"\n## lamc/{floor}\n\n{line_of(package / '__init__.py')}\n\n| module | what it is |\n|---|---|\n"
        )
        parts += [
            _row(path, package) for path in sorted(package.rglob("*.py")) if path != package / "__init__.py"
        ]
    parts.append("\n## Modules that are no package\n\n| module | what it is |\n|---|---|\n")
    parts += [_row(path, ROOT / "lamc") for path in alone]
    return "".join(parts)


def _row(path: Path, package: Path) -> str:
    return f"| `{path.relative_to(package).as_posix()}` | {line_of(path)} |\n"


if __name__ == "__main__":
    if sys.argv[1:]:
        sys.exit("usage: python docs/make_map.py")
    MAP.write_text(whole(), encoding="utf-8")
