"""Style sheets in an SVG file: which declarations hold for an element.

In: texts of <style>. Out: declarations, property by property. Selectors are lists of names, classes and ids, one within
another; what else CSS has (states, attributes, @media) is left out and told. Never: fetches an @import.
"""

import re
from collections.abc import Iterator
from dataclasses import dataclass

from lamc.readers.drawings.svg_tree import Element
from lamc.readers.inert import Limits

GEOMETRY_OF = {  # by tag: what CSS gives as well (SVG 2, geometry properties)
    "svg": ("x", "y", "width", "height"),
    "rect": ("x", "y", "width", "height", "rx", "ry"),
    "circle": ("cx", "cy", "r"),
    "ellipse": ("cx", "cy", "rx", "ry"),
    "path": ("d",),
}
GEOMETRY = frozenset(name for names in GEOMETRY_OF.values() for name in names)
PROPERTIES = GEOMETRY | frozenset(
    (
        *("stroke", "stroke-opacity", "opacity", "fill", "color", "display", "visibility"),
        *("clip-path", "mask", "overflow", "transform", "transform-origin"),
    )
)
Declarations = dict[str, str]
Compounds = tuple[tuple[tuple[str, ...], bool], ...]

_COMMENT = re.compile(r"/\*.*?\*/|<!--|-->", re.DOTALL)
_COMPOUND = re.compile(r"(?:\*|[^\W\d][\w-]*)?(?:[.#][\w-]+)*\Z")
_PART = re.compile(r"[.#]?[\w-]+|\*")
_MOST_RULES = 10_000
_MOST_WITHIN = 20  # names of one selector


@dataclass(frozen=True)
class _Rule:
    """compounds: outermost first, each with its names, and whether it is the parent of the next one (">")."""

    compounds: Compounds
    rank: tuple[bool, tuple[int, int, int], int]  # important, specificity, order
    declarations: Declarations


class Sheet:
    """The rules of one file's styles; `notes` tells what was left out."""

    def __init__(self, styles: tuple[Element, ...], limits: Limits) -> None:
        self.notes: list[str] = []
        self._rules: dict[str, list[_Rule]] = {}  # by the last name of their last part
        self._count, self._work = 0, 0
        self._named: dict[Element, frozenset[str]] = {}
        self._limits = limits
        for style in styles:
            if style.get("type", "text/css").strip().lower() not in ("text/css", ""):
                self.notes.append(f"{style.source} is no CSS and is not read")
                continue
            for prelude, body in self._blocks(style):
                self._add(style, prelude, body)

    def declarations(self, element: Element) -> Declarations:
        """What holds for an element by presentation attributes, rules and its own style, in CSS's order."""
        found = {name: value for name, value in element.attributes.items() if name in PROPERTIES - GEOMETRY}
        own, own_important = parsed(element.get("style")) if "style" in element.attributes else ({}, {})
        rules = sorted(self._matching(element), key=lambda rule: rule.rank)
        for rule in rules:
            if not rule.rank[0]:
                found |= rule.declarations
        found |= own
        for rule in rules:
            if rule.rank[0]:
                found |= rule.declarations
        return found | own_important

    def _matching(self, element: Element) -> Iterator[_Rule]:
        if not self._rules:
            return
        for name in _names(element):
            for rule in self._rules.get(name, ()):
                if self._matches(rule.compounds, element):
                    yield rule

    def _matches(self, compounds: Compounds, element: Element) -> bool:
        """Whether an element, and what it lies in, are as the selector says. The nearest ancestor that fits is taken,
        as for lists of descendants it may be; where parents are asked for too, all are tried."""
        self._work += 1
        if self._work > self._limits.nodes:
            raise element.error(
                f"the file's styles take more comparisons than the limit 'nodes' of {self._limits.nodes}; save it with "
                "styles as attributes"
            )
        if not self._is(element, compounds[-1][0]):
            return False
        outer, above = compounds[:-1], element.parent
        if not outer:
            return True
        if outer[-1][1]:
            return above is not None and self._matches((*outer[:-1], (outer[-1][0], False)), above)
        has_parents = any(parent for _, parent in outer)
        while above is not None:
            if self._matches(outer, above):
                return True
            if not has_parents and self._is(above, outer[-1][0]):
                return False
            above = above.parent
        return False

    def _is(self, element: Element, names: tuple[str, ...]) -> bool:
        own = self._named.get(element)
        if own is None:
            own = self._named[element] = frozenset(_names(element))
        return own.issuperset(names)

    def _blocks(self, style: Element) -> Iterator[tuple[str, str]]:
        """Selectors and declarations of each rule."""
        text = _COMMENT.sub(" ", style.text)
        at = 0
        while True:
            start = text.find("{", at)
            head = text[at : start if start >= 0 else len(text)]
            statements = head.split(";")
            for statement in statements[:-1]:
                if statement.strip().lower().startswith("@import"):
                    self.notes.append(
                        f"{style.source} imports a stylesheet, which is not fetched: put its text there"
                    )
            if start < 0:
                return
            prelude = statements[-1].strip()
            end = _closing(text, start) if prelude.startswith("@") else text.find("}", start)
            end = end if end >= 0 else len(text)
            if prelude.startswith("@"):
                word = prelude.split()[0][:30]
                if word.lower() not in ("@font-face", "@keyframes", "@-webkit-keyframes"):
                    self.notes.append(f"the rules of {word} in {style.source} are not read")
            else:
                yield prelude, text[start + 1 : end]
            at = end + 1

    def _add(self, style: Element, prelude: str, body: str) -> None:
        normal, important = parsed(body)
        if not normal and not important:
            return
        for selector in prelude.split(","):
            self._count += 1
            if self._count > _MOST_RULES:
                raise style.error(
                    f"the file has more than {_MOST_RULES} rules of style; save it with styles as attributes"
                )
            compounds = _compounds(selector)
            if compounds is None:
                shown = " ".join(selector.split())[:40]
                self.notes.append(
                    f"the selector {shown!r} of {style.source} is not read; lamc reads names, .classes and #ids"
                )
                continue
            parts = [part for names, _ in compounds for part in names]
            specificity = (
                sum(part[0] == "#" for part in parts),
                sum(part[0] == "." for part in parts),
                sum(part[0] not in "#.*" for part in parts),
            )
            for is_important, declarations in ((False, normal), (True, important)):
                if declarations:
                    rule = _Rule(compounds, (is_important, specificity, self._count), declarations)
                    self._rules.setdefault(compounds[-1][0][-1], []).append(rule)


def parsed(text: str) -> tuple[Declarations, Declarations]:
    """Declarations of those properties that matter here, and those that are marked !important."""
    normal: Declarations = {}
    important: Declarations = {}
    for declaration in _COMMENT.sub(" ", text).split(";"):
        name, _, value = declaration.partition(":")
        name, value = name.strip().lower(), value.strip()
        if name not in PROPERTIES or not value:
            continue
        if value.lower().endswith("important") and "!" in value:
            important[name] = value.rpartition("!")[0].strip()
        else:
            normal[name] = value
    return normal, important


def _closing(text: str, start: int) -> int:
    """Where the block that opens at `start` closes; -1 where it does not."""
    depth = 0
    for found in re.compile(r"[{}]").finditer(text, start):
        depth += 1 if found[0] == "{" else -1
        if depth == 0:
            return found.start()
    return -1


def _compounds(selector: str) -> Compounds | None:
    """A selector's parts; None for one of another kind."""
    words = selector.replace(">", " > ").split()
    found: list[tuple[tuple[str, ...], bool]] = []
    for word in words:
        if word == ">":
            if not found or found[-1][1]:
                return None
            found[-1] = (found[-1][0], True)
        elif not _COMPOUND.match(word):
            return None
        else:
            found.append((tuple(_PART.findall(word)), False))
    if not found or found[-1][1] or len(found) > _MOST_WITHIN:
        return None
    return tuple(found)


def _names(element: Element) -> list[str]:
    """What a selector can call an element by."""
    names = [*dict.fromkeys(f".{word}" for word in element.get("class").split()), element.tag, "*"]
    return [f"#{element.get('id')}", *names] if element.get("id") else names
