"""Templates lay out text: what they say is computed in Python (STYLE: no arithmetic, no methods, no search in text)."""

from pathlib import Path

import jinja2
import pytest
from jinja2 import nodes

from lamc.basics.resources import data_dir

FOLDER = data_dir("templates")
TEMPLATES = sorted(path.relative_to(FOLDER) for path in FOLDER.rglob("*.j2"))
ARITHMETIC = (
    nodes.Add, nodes.Sub, nodes.Mul, nodes.Div, nodes.FloorDiv, nodes.Mod, nodes.Pow, nodes.Neg, nodes.Pos
)  # fmt: skip


def computed(text: str) -> list[str]:
    """What a template does beyond laying out, with its line."""
    tree = jinja2.Environment().parse(text)
    found = [(n.lineno, type(n).__name__) for n in tree.find_all(ARITHMETIC)]
    found += [(n.lineno, "method") for n in tree.find_all(nodes.Call) if isinstance(n.node, nodes.Getattr)]
    for compared in tree.find_all(nodes.Compare):
        searched = [each.expr for each in compared.ops if each.op in ("in", "notin")]
        found += [(compared.lineno, "search") for each in searched if not isinstance(each, nodes.Name)]
    return [f"line {line}: {what}" for line, what in sorted(found)]


@pytest.mark.parametrize("path", TEMPLATES, ids=str)
def test_a_template_lays_out_and_computes_nothing(path: Path) -> None:
    assert computed((FOLDER / path).read_text(encoding="utf-8")) == []


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("{{ 2 * counts.cuts }}", "Mul"),
        ("{% for x in y[n + 1:] %}{% endfor %}", "Add"),
        ("{{ reals.index('t') }}", "method"),
        ("{% if 'i[' in lines | join %}{% endif %}", "search"),
    ],
)
def test_what_computes_is_found(text: str, expected: str) -> None:
    assert computed(text) == [f"line 1: {expected}"]
