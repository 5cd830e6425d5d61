"""Damaged copies of design files that are YAML still, so that the damage reaches the readers behind it.

In: the nodes of a file and dice. Out: text with one to three changes: numbers moved by decades, entries drawn hundreds
of times, outlines turned into combs, values and branches swapped, repeated, taken out or replaced by what does not fit.
"""

import json
import random
import re
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field

from lamc.readers.inert import ListNode, MapNode, Node, ScalarNode
from lamc.readers.nodes import STANDARD_TAGS

MOST = 40_000  # values of a mutant: what a file of some 500 kB holds
ODD = (
    "0",
    "-1",
    "1e-300",
    "1e300",
    ".nan",
    "-.inf",
    "~",
    "x",
    "90 deg",
    "[]",
    "{}",
    "[1, [2]]",
    "true",
    "union",
)
_PLAIN = re.compile(r"[\w.+^*/ -]*[\w.]\Z")
_NUMBER = re.compile(r"[-+]?(\.\d+|\d+(\.\d*)?)([eE][-+]?\d+)?")


@dataclass
class Branch:
    """A value that may be changed. kind: "scalar", "list" or "map", whose keys and values stand in turn in `items`."""

    kind: str
    tag: str
    text: str = ""
    plain: bool = True
    items: "list[Branch]" = field(default_factory=list)

    def copy(self) -> "Branch":
        return Branch(self.kind, self.tag, self.text, self.plain, [item.copy() for item in self.items])

    def walk(self) -> "Iterator[Branch]":
        yield self
        for item in self.items:
            yield from item.walk()

    @property
    def is_number(self) -> bool:
        return self.kind == "scalar" and self.plain and _NUMBER.match(self.text) is not None


def branch_of(node: Node) -> Branch:
    if isinstance(node, ScalarNode):
        return Branch("scalar", node.tag, node.text, node.plain)
    if isinstance(node, ListNode):
        return Branch("list", node.tag, items=[branch_of(item) for item in node.items])
    assert isinstance(node, MapNode)
    return Branch("map", node.tag, items=[branch_of(each) for pair in node.pairs for each in pair])


def written(branch: Branch) -> str:
    """The branch in YAML's flow style, an entry a line."""
    tag = ""
    if branch.tag not in STANDARD_TAGS:
        tag = f"{branch.tag} " if branch.tag[0] == "!" else f"!<tag:yaml.org,2002:{branch.tag}> "
    if branch.kind == "scalar":
        bare = branch.plain and (_PLAIN.match(branch.text) or branch.text in (*ODD, ""))
        return tag + ((branch.text or "~") if bare else json.dumps(branch.text))
    entries = [written(item) for item in branch.items]
    if branch.kind == "list":
        return tag + "[" + ",\n".join(entries) + "]"
    pairs = (f"? {key}\n: {value}" for key, value in zip(entries[::2], entries[1::2], strict=True))
    return tag + "{" + ",\n".join(pairs) + "}"


def mutant(root: Node, dice: random.Random) -> str:
    """The file's text with one to three changes."""
    branch = branch_of(root)
    for _ in range(dice.randint(1, 3)):
        before = branch.copy()
        dice.choice(_CHANGES)(branch, dice)
        if sum(1 for _ in branch.walk()) > MOST:
            branch = before
    return written(branch)


def _moved(branch: Branch, dice: random.Random, change: Callable[[], float]) -> None:
    found = _NUMBER.match(branch.text)
    assert found is not None
    branch.text = repr(float(found[0]) * change()) + branch.text[found.end() :]


def _by_decades(root: Branch, dice: random.Random) -> None:
    numbers = [each for each in root.walk() if each.is_number]
    if numbers:
        _moved(dice.choice(numbers), dice, lambda: 10.0 ** dice.randint(-6, 6))


def _scattered(branch: Branch, dice: random.Random) -> Branch:
    """A copy, each coordinate a little elsewhere; whole numbers, as of ids, stay."""
    made = branch.copy()
    for each in made.walk():
        if each.is_number and not (each.text.isdigit() and len(each.text) > 3):
            _moved(each, dice, lambda: dice.uniform(0.2, 1.8))
    return made


def _repeated(root: Branch, dice: random.Random) -> None:
    lists = [each for each in root.walk() if each.kind == "list" and each.items]
    if lists:
        chosen = dice.choice(lists)
        at = dice.randrange(len(chosen.items))
        count = dice.choice((2, 20, 200, 2000))
        chosen.items[at : at + 1] = [_scattered(chosen.items[at], dice) for _ in range(count)]


def _renamed(root: Branch, dice: random.Random) -> None:
    maps = [each for each in root.walk() if each.kind == "map" and each.items]
    if maps:
        chosen = dice.choice(maps)
        at = 2 * dice.randrange(len(chosen.items) // 2)
        for k in range(dice.choice((1, 50, 500))):
            key = chosen.items[at].copy()
            key.text += f"_{k}"
            chosen.items += [key, _scattered(chosen.items[at + 1], dice)]


def _point(branch: Branch) -> Branch | None:
    """The list that holds x and y as its last two numbers; None where there is none."""
    lists = [each for each in branch.walk() if each.kind == "list"]
    return next(
        (each for each in lists if len(each.items) >= 2 and all(i.is_number for i in each.items)), None
    )


def _combed(root: Branch, dice: random.Random) -> None:
    """An outline or a line becomes a comb of hundreds of teeth within its bounds, standing or lying."""
    lists = [each for each in root.walk() if each.kind == "list" and len(each.items) > 1]
    lists = [each for each in lists if all(_point(item) for item in each.items)]
    if not lists:
        return
    chosen = dice.choice(lists)
    model = chosen.items[0]
    ends = [[float(_NUMBER.match(i.text)[0]) for i in _point(p).items[-2:]] for p in chosen.items]  # type: ignore[index, union-attr]
    (x0, x1), (y0, y1) = ((min(c), max(c)) for c in zip(*ends, strict=True))
    teeth, lying = dice.choice((10, 100, 1000)), dice.random() < 0.5
    points = [(0.0, 0.0)]
    for k in range(teeth):
        points += [((k + a) / teeth, y) for a, y in ((0.0, 1.0), (0.5, 1.0), (0.5, 0.01), (1.0, 0.01))]
    chosen.items = []
    for u, v in (*points, (1.0, 0.0)):
        made = model.copy()
        pair = _point(made)
        assert pair is not None
        u, v = (v, u) if lying else (u, v)
        pair.items[-2].text, pair.items[-1].text = repr(x0 + u * (x1 - x0)), repr(y0 + v * (y1 - y0))
        chosen.items.append(made)


def _swapped(root: Branch, dice: random.Random) -> None:
    every = [each for each in root.walk() if each is not root]
    if every:
        _become(dice.choice(every), dice.choice(every).copy())


def _replaced(root: Branch, dice: random.Random) -> None:
    _become(dice.choice([*root.walk()]), Branch("scalar", "", dice.choice(ODD)))


def _taken_out(root: Branch, dice: random.Random) -> None:
    holders = [each for each in root.walk() if each.items]
    if holders:
        chosen = dice.choice(holders)
        step = 2 if chosen.kind == "map" else 1
        at = step * dice.randrange(len(chosen.items) // step)
        del chosen.items[at : at + step]


def _become(branch: Branch, other: Branch) -> None:
    branch.kind, branch.tag, branch.text, branch.plain = other.kind, other.tag, other.text, other.plain
    branch.items = other.items


_CHANGES = (
    _by_decades,
    _by_decades,
    _repeated,
    _repeated,
    _renamed,
    _combed,
    _combed,
    _swapped,
    _replaced,
    _taken_out,
)
