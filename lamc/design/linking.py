"""Linking: from contacts to joints, and the refusal of what is no mechanism.

In: hinges with the bodies that they touch. Out: connections, each with parent and child. Every hinge joins
exactly two bodies, every body reaches the world, and none of that is mended in silence: what does not fit is
a TopologyError that names hinge, bodies, place and way out.
"""

from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass

from shapely.geometry import LineString

from lamc.basics.errors import TopologyError
from lamc.basics.groups import root, unite
from lamc.design.bodies import Group
from lamc.design.check_design import known
from lamc.design.contact import SHORTEST, Contact
from lamc.design.cutting import SLIT
from lamc.design.steps import Connection, Hinge

_DOUBLED = 0.5  # of the shorter of two lines, beside the other: more than crossings and ends have


@dataclass(frozen=True)
class Site:
    """A body as linking sees it: its name, and its pieces, which tell whether the world holds it and where it lies."""

    name: str
    group: Group

    @property
    def fixed(self) -> bool:
        return self.group.fixed

    def __str__(self) -> str:
        return f"{self.name!r} at {millimetres(self.group.at)}"


def link(
    hinges: Sequence[Hinge], contacts: Sequence[Contact], sites: Sequence[Site], layers: Sequence[str]
) -> tuple[Connection, ...]:
    """Connections in the order of `hinges`; `layers` are the layers' names. Raises TopologyError."""
    pairs = [_pair(h, c, hinges, sites, layers) for h, c in zip(hinges, contacts, strict=True)]
    _refuse_locked_pairs(hinges, pairs, sites)
    depth = _depths(pairs, sites)
    lost = [site for site, d in zip(sites, depth, strict=True) if d is None]
    if lost:
        shown = ", ".join(map(str, lost[:4])) + (f" and {len(lost) - 4} more" if len(lost) > 4 else "")
        noun = "body has" if len(lost) == 1 else "bodies have"
        count = _pieces(pairs, [d is None for d in depth])
        pieces = f" (in {count} {'piece' if count == 1 else 'pieces'})" if len(lost) > 1 else ""
        raise TopologyError(
            f"{len(lost)} {noun} no path to the world: {shown}{pieces}; join each piece by a hinge line to the rest, "
            "draw the fixed region over it, or take it out of the drawing"
        )

    def rank(body: int) -> tuple[int, str]:
        return depth[body] or 0, sites[body].name

    connections = []
    for hinge, pair in zip(hinges, pairs, strict=True):
        parent, child = sorted(pair, key=rank)
        connections.append(Connection(hinge, sites[parent].name, sites[child].name))
    return tuple(connections)


def millimetres(point: tuple[float, float]) -> str:
    return f"({point[0] * 1e3:.6g}, {point[1] * 1e3:.6g}) mm"


def _pair(
    hinge: Hinge, contact: Contact, hinges: Sequence[Hinge], sites: Sequence[Site], layers: Sequence[str]
) -> tuple[int, int]:
    bodies = contact.bodies
    if contact.strays:
        cut = [repr(sites[b].name) for b in sorted({b for _, strays in contact.strays for b in strays})]
        where = [repr(layers[i]) for i, _ in contact.strays]
        raise TopologyError(
            f"{_label(hinge)} runs through {_plural('layer', where)} too, where it cuts {', '.join(cut)}, which "
            f"it does not join; a hinge joins the bodies in its flexible layer, {layers[hinge.properties.layer]!r}: "
            "list the layers of that sheet alone as the hinge's layers",
            known(hinge.place),
        )
    if len(bodies) == 2:
        first, second = bodies
        if sites[first].fixed and sites[second].fixed:
            raise TopologyError(
                f"{_label(hinge)} joins {sites[first].name!r} and {sites[second].name!r}, which are "
                "both fixed, so "
                "it cannot turn: keep the fixed region to one side of it, or take the hinge out",
                known(hinge.place),
            )
        return first, second
    names = ", ".join(repr(sites[b].name) for b in bodies)
    count = f"{len(bodies)} {'body' if len(bodies) == 1 else 'bodies'}" + (f" ({names})" if names else "")
    wide = hinge.properties.gap > hinge.line.length and contact.free_length > 0.0
    check = (
        f". Its gap, {hinge.properties.gap * 1e3:.3g} mm, is longer than its line: check it first"
        if wide
        else ""
    )
    raise TopologyError(
        f"{_label(hinge)} touches {count}; a hinge needs exactly 2: {_way_out(hinge, contact, hinges, layers)}{check}",
        known(hinge.place),
    )


def _way_out(hinge: Hinge, contact: Contact, hinges: Sequence[Hinge], layers: Sequence[str]) -> str:
    if contact.free_length <= SHORTEST * hinge.properties.width:
        neighbours = _neighbours(hinge, hinges)
        beside = [h for h in neighbours if _shared(hinge, h) > _DOUBLED * _shorter(hinge, h)]
        near = [repr(h.name) for h in beside or neighbours][:4]
        if not near:
            return (
                f"it is {hinge.line.length * 1e3:.3g} mm long and its gap {hinge.properties.gap * 1e3:.3g} mm, which "
                "leaves nothing to bend; make it longer, or lower the gap"
            )
        doubled = ""
        if beside:
            length = 1e3 * max(_shared(hinge, h) for h in beside)
            doubled = (
                f"; over {length:.3g} mm they are within half a gap: keep one where a crease is drawn twice"
            )
        return (
            f"the holes where it meets {_plural('hinge', near)} swallow it; move them apart, make it "
            f"longer, or lower the gap{doubled}"
        )
    bodies = contact.bodies
    if len(bodies) == 0:
        return "it lies outside the device; move it onto the material, or take it out"
    if len(bodies) == 1:
        if contact.left and contact.right and contact.bridges:
            bridges = [repr(layers[i]) for i in contact.bridges]
            return (
                f"material of {_plural('layer', bridges)} lies across it and holds its two sides together; open it "
                "there"
            )
        if contact.left and contact.right:
            return (
                "it does not cut the body apart; lengthen it to the material's edges, or close the cuts there"
            )
        side = "left" if contact.left else "right"
        return f"there is material on its {side} only; move it, or draw the missing body"
    crossed = [repr(h.name) for h in hinges if h is not hinge and h.line.crosses(hinge.line)][:4]
    if crossed:
        return f"it crosses {_plural('hinge', crossed)}; draw it as separate lines that end at the crossing"
    return "draw one line for each pair of bodies"


def _refuse_locked_pairs(
    hinges: Sequence[Hinge], pairs: Sequence[tuple[int, int]], sites: Sequence[Site]
) -> None:
    """Two hinges between the same two bodies turn only if they lie on one line (a door has two hinges)."""
    first_of: dict[tuple[int, int], Hinge] = {}
    for hinge, pair in zip(hinges, pairs, strict=True):
        first = first_of.setdefault(pair, hinge)
        if first is hinge or _on_one_line(first, hinge):
            continue
        raise TopologyError(
            f"{_label(hinge)} and hinge {first.name!r} both join {sites[pair[0]].name!r} and "
            f"{sites[pair[1]].name!r} but do not lie on one line, so neither can turn: take one out, or "
            "separate the bodies",
            known(hinge.place),
        )


def _on_one_line(a: Hinge, b: Hinge) -> bool:
    """Within half a slit: what the drawing cannot tell from one line."""
    if a.z != b.z:
        return False
    longer, shorter = sorted((a.line, b.line), key=lambda line: -line.length)
    (x0, y0), (x1, y1) = longer.coords
    reach = SLIT * max(a.properties.width, b.properties.width)
    return all(
        abs((x - x0) * (y1 - y0) - (y - y0) * (x1 - x0)) <= reach * longer.length for x, y in shorter.coords
    )


def _depths(pairs: Sequence[tuple[int, int]], sites: Sequence[Site]) -> list[int | None]:
    """Least number of hinges from each body to a fixed one; None where there is no path."""
    neighbours: list[list[int]] = [[] for _ in sites]
    for a, b in pairs:
        neighbours[a].append(b)
        neighbours[b].append(a)
    depth: list[int | None] = [0 if site.fixed else None for site in sites]
    queue = deque((i, 0) for i, site in enumerate(sites) if site.fixed)
    while queue:
        body, steps = queue.popleft()
        for other in neighbours[body]:
            if depth[other] is None:
                depth[other] = steps + 1
                queue.append((other, steps + 1))
    return depth


def _pieces(pairs: Sequence[tuple[int, int]], chosen: Sequence[bool]) -> int:
    """How many pieces the chosen bodies are in, by the hinges between them."""
    head = list(range(len(chosen)))
    for a, b in pairs:
        unite(head, a, b)
    return len({root(head, body) for body, is_chosen in enumerate(chosen) if is_chosen})


def _neighbours(hinge: Hinge, hinges: Sequence[Hinge]) -> list[Hinge]:
    def strip(h: Hinge) -> float:
        return h.properties.width

    return [
        h
        for h in hinges
        if h is not hinge
        and set(h.layers) & set(hinge.layers)
        and h.line.distance(hinge.line) < strip(h) + strip(hinge)
    ]


def _shared(hinge: Hinge, other: Hinge) -> float:
    """How much of the shorter line lies within half a gap of the other, m."""
    shorter, longer = sorted((hinge.line, other.line), key=lambda line: line.length)
    width = max(hinge.properties.width, other.properties.width)
    return float(shorter.intersection(longer.buffer(width)).length)


def _shorter(hinge: Hinge, other: Hinge) -> float:
    return float(min(hinge.line.length, other.line.length))


def _plural(noun: str, names: Sequence[str]) -> str:
    return f"{noun}{'s' if len(names) > 1 else ''} {', '.join(names)}"


def _label(hinge: Hinge) -> str:
    middle: LineString = hinge.line.interpolate(0.5, normalized=True)
    return f"hinge {hinge.name!r} at {millimetres((middle.x, middle.y))}"
