"""The quick scanner of design files against ruamel.yaml's own: the same events, places and refusals on every text."""

import random
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from ruamel.yaml import YAML
from ruamel.yaml.error import YAMLError

import lamc
from lamc.readers.popupcad_old_keys import ScannerOfOldKeys
from lamc.readers.quick_yaml import quick_yaml

EXAMPLES = sorted(
    path for path in (Path(lamc.__file__).parent / "examples").rglob("*") if path.suffix in (".yaml", ".cad")
)
ODD = [
    "",
    "\ufeffa: 1",
    "a: b c\n\n  d\n\n\n  e # told\n# f\ng: 2",
    "a: b\n---\nc: d\n...\ne: f\n",
    "a: b\n--- c\n",
    "- -1\n- -a\n-\n  - .5\n- ...x\n.a: 1",
    ".5: 1\n...\n",
    "{a: 1, b:c, ? d : e, ?f: g, 'h':i, \"j\":k, l}",
    "%YAML 1.1\n---\n[a?b, ?c, a:b, no, a: b]\n",
    "%YAML 1.1\n---\n{a?b: c, d}\n",
    "%YAML 1.2\n---\n[a?b, ?c, a::b, :d]\n",
    "? a\n: b\n? [c, d]\n: e\n",
    "a: |\n  b\n   c\n\nd: >-\n  e\n  f\n",
    "a: 'b\n\n  c'\nd: \"e\\\n  f \\x41\"",
    "a:\tb\n\tc: d\n",
    "[a,\tb,\n\t# told\n c]",
    "a: b\r\nc: d e\r\n  f\rg: h\u2028i: j\x85k: l\u2029",
    "a: &b [1, 2]\nc: *b\n*b: 3\nd: *b\n",
    "a: !python/object:b.c {d: !e f}\ng: !!str 1\n",
    "a: b: c\n",
    "a\nb: c\n",
    "a: b\n c: d\n  - e\n",
    "[a, b\nc: d\n",
    "@a\n",
    "a: %b\n`c: d",
    "a" * 1100 + ": b\n",
    "[" + "a" * 1100 + ": b]\n",
    "a b  c   : d\u00e9 \ufeffe f\n",
    "- a\n-b\n- - c\n  -\n",
    "&a b: c\n&d\ne: f\n",
    "a:b:c: d:e\nf: http://g#h #i\n",
    "a: \x07b",
    "a:  \n\n  \n b\n\n",
]
PIECES = [
    "\n",
    "  ",
    "\n  ",
    ": ",
    ":",
    "- ",
    "-",
    "#",
    " # x\n",
    ",",
    "[",
    "]",
    "{",
    "}",
    "?",
    "? ",
    "'",
    '"',
    "---\n",
    "...\n",
]
PIECES += [
    "\t",
    "\r\n",
    "\u2028",
    "\x85",
    "\ufeff",
    "*a",
    "&a ",
    "!t ",
    "|\n",
    ">\n",
    "%YAML 1.1\n",
    "\u00e9",
    "a",
    "\n\n",
]


def _reported(yaml: YAML, text: str) -> list[Any]:
    """All that the reader above is reported: of every event its class, values and places, then the error, if any."""
    reported: list[Any] = []
    try:
        for event in yaml.parse(text):
            values = [
                str(getattr(event, name, None)) for name in ("anchor", "tag", "value", "style", "flow_style")
            ]
            places = [(mark.index, mark.line, mark.column) for mark in (event.start_mark, event.end_mark)]
            implicit = getattr(event, "implicit", None), getattr(event, "explicit", None)
            reported.append((type(event).__name__, *values, implicit, places))
    except YAMLError as error:
        reported.append((type(error).__name__, str(error)))
    except (AssertionError, NotImplementedError, ValueError, AttributeError, TypeError) as error:
        reported.append((type(error).__name__, str(error)))
    return reported


def _usual() -> YAML:
    yaml = YAML(typ="safe", pure=True)
    yaml.Scanner = ScannerOfOldKeys
    return yaml


def _damaged(text: str, count: int) -> Iterator[str]:
    chance = random.Random(7)
    for _ in range(count):
        at = chance.randrange(max(len(text) - 400, 1))
        part = text[at : at + 400]  # short ones, so that most are read to their end
        for _ in range(chance.randrange(1, 5)):
            place = chance.randrange(len(part) + 1)
            part = part[:place] + chance.choice(PIECES) + part[place + chance.randrange(3) :]
        yield part


@pytest.mark.parametrize("path", EXAMPLES, ids=lambda path: path.name)
def test_examples_are_read_as_ruamel_reads_them(path: Path) -> None:
    text = path.read_text(encoding="utf-8")
    assert _reported(quick_yaml(), text) == _reported(_usual(), text)


@pytest.mark.parametrize("text", ODD, ids=range(len(ODD)))
def test_odd_texts_are_read_as_ruamel_reads_them(text: str) -> None:
    assert _reported(quick_yaml(), text) == _reported(_usual(), text)


@pytest.mark.parametrize("path", EXAMPLES, ids=lambda path: path.name)
def test_damaged_texts_are_read_as_ruamel_reads_them(path: Path) -> None:
    for text in _damaged(path.read_text(encoding="utf-8"), 20):
        assert _reported(quick_yaml(), text) == _reported(_usual(), text), text


def test_random_texts_are_read_as_ruamel_reads_them() -> None:
    chance = random.Random(11)
    for _ in range(1500):
        text = "".join(
            chance.choice([*PIECES, "b", "c d", "1.5", "-2"]) for _ in range(chance.randrange(1, 14))
        )
        assert _reported(quick_yaml(), text) == _reported(_usual(), text), repr(text)
