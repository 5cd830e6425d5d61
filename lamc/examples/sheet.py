"""A creased sheet, drawn: text of a native design from points, facets and what each crease rests at.

In: a `CreasePattern`. Out: YAML, the same to the byte for the same numbers. Never: reads or writes files, simulates.

Facets are of card on both sides of a film, which bends where the card leaves a gap. Creases are where two facets have a
side in common, and the rim is what is left. A line is drawn so that the facet farther from the fixed one, the joint's
child, lies to its left: a valley has a positive angle, a mountain a negative one.
"""

import math
import textwrap
from collections import deque
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass

Point = tuple[float, float]
Side = tuple[int, int]

GAP = 1.0  # mm, left open in the card along a crease
FILM = 0.00324  # N*mm/rad for each mm of crease: E t^3 / (12 L), 25 um of film over the gap

# Card, film and card: what all sheets of the gallery are made of
LAMINATE = """\
materials:
  card: {density: 700 kg/m^3, E1: 3 GPa, E2: 3 GPa, poisson: 0.3, rigid: true}
  film: {density: 1.42 g/cm^3, E1: 2.5 GPa, E2: 2.5 GPa, poisson: 0.34, flexible: true}

layers: # from the bottom up
  - {name: lower, material: card, thickness: 0.3}
  - {name: film, material: film, thickness: 25 um}
  - {name: upper, material: card, thickness: 0.3}
"""

_HEAD = """\
# {summary}
kind: design
name: {name}
story: >
{story}
units: mm

"""


@dataclass(frozen=True)
class CreasePattern:
    """points: mm; facets: corners of each by index, counterclockwise, the first one fixed; rest: the kind of the crease
    along a side, the first letter of its name, and its rest angle, rad, positive for a valley; names: of facets."""

    points: Sequence[Point]
    facets: Sequence[Sequence[int]]
    rest: Callable[[int, int], tuple[str, float]]
    names: Sequence[str]


@dataclass(frozen=True)
class Crease:
    """A side of two facets, drawn from start to end, both indices of points."""

    name: str
    start: int
    end: int
    rest: float  # rad


def sheet(
    name: str, summary: str, story: str, pattern: CreasePattern, angles: Mapping[str, float], extra: str = ""
) -> str:
    """The design of a pattern that starts with `angles`, degrees; `extra` is text of its own."""
    creases = creases_of(pattern)
    told = textwrap.fill(story, 118, initial_indent="  ", subsequent_indent="  ")
    start = ", ".join(f"{crease}: {angle:.15g} deg" for crease, angle in angles.items())
    return "\n".join(
        [
            _HEAD.format(name=name, summary=summary, story=told) + LAMINATE,
            _shapes(pattern),
            _hinges(pattern, creases),
            f"fixed:\n  - {{circle: {{center: {_flow(_middle(pattern, 0))}, radius: 2}}}}\n",
            "bodies:\n"
            + "".join(f"  {n}: {_flow(_middle(pattern, k))}\n" for k, n in enumerate(pattern.names)),
            *([extra] if extra else []),
            f"scene: # no weight\n  effects: [hinge_stiffness, rest_angle, hinge_damping]\n  angles: {{{start}}}\n",
        ]
    )


def creases_of(pattern: CreasePattern) -> list[Crease]:
    """Creases in the order of facets and their sides, numbered by kind."""
    beside: dict[Side, int] = {side: k for k, facet in enumerate(pattern.facets) for side in _sides(facet)}
    depth = _depths(pattern, beside)
    creases: list[Crease] = []
    counts: dict[str, int] = {}
    for k, facet in enumerate(pattern.facets):
        for a, b in _sides(facet):
            other = beside.get((b, a))
            if other is None or other < k:
                continue
            kind, rest = pattern.rest(a, b)
            counts[kind] = counts.get(kind, 0) + 1
            # A facet lies to the left of its own sides.
            child_is_other = (depth[other], pattern.names[other]) > (depth[k], pattern.names[k])
            start, end = (b, a) if child_is_other else (a, b)
            creases.append(Crease(f"{kind}{counts[kind]}", start, end, rest))
    return creases


def rim(pattern: CreasePattern) -> list[int]:
    """Points along the outer edge, counterclockwise."""
    taken = {side for facet in pattern.facets for side in _sides(facet)}
    following = {a: b for a, b in sorted(taken) if (b, a) not in taken}
    first = min(following)
    ring = [first]
    while following[ring[-1]] != first:
        ring.append(following[ring[-1]])
    assert len(ring) == len(following), "a pattern is one sheet without holes"
    return ring


def _sides(facet: Sequence[int]) -> list[Side]:
    return list(zip(facet, [*facet[1:], facet[0]], strict=True))


def _depths(pattern: CreasePattern, beside: Mapping[Side, int]) -> list[int]:
    """Creases between each facet and the first one."""
    depth = {0: 0}
    queue = deque([0])
    while queue:
        k = queue.popleft()
        for a, b in _sides(pattern.facets[k]):
            other = beside.get((b, a))
            if other is not None and other not in depth:
                depth[other] = depth[k] + 1
                queue.append(other)
    return [depth[k] for k in range(len(pattern.facets))]


def _shapes(pattern: CreasePattern) -> str:
    lines = [
        "shapes:",
        f"  - {{polygon: {_listed(pattern.points[k] for k in rim(pattern))}, layers: film}}",
        "  # card, facet by facet",
    ]
    for facet in pattern.facets:
        corners = _inset([pattern.points[k] for k in facet], 0.5 * GAP)
        lines.append(f"  - {{polygon: {_listed(corners)}, layers: [lower, upper]}}")
    return "\n".join(lines) + "\n"


def _hinges(pattern: CreasePattern, creases: Sequence[Crease]) -> str:
    lines = [
        f"# Film of 25 um bends over the gap of 1 mm: E t^3 / (12 L) is {FILM:g} N*mm/rad for each mm of crease.",
        "hinges:",
    ]
    for crease in creases:
        start, end = pattern.points[crease.start], pattern.points[crease.end]
        lines.append(
            f"  - {{name: {crease.name}, line: {_listed([start, end])}, gap: {GAP:g}, stiffness: "
            f"{FILM * math.dist(start, end):.3g} N*mm/rad, damping: 2e-6 N*m*s/rad, rest_angle: "
            f"{math.degrees(crease.rest):.9g} deg}}"
        )
    return "\n".join(lines) + "\n"


def _middle(pattern: CreasePattern, index: int) -> Point:
    corners = [pattern.points[k] for k in pattern.facets[index]]
    return sum(x for x, _ in corners) / len(corners), sum(y for _, y in corners) / len(corners)


def _inset(corners: Sequence[Point], distance: float) -> list[Point]:
    """A convex polygon, counterclockwise, shrunk by a distance, mm."""
    lines = []
    for (x0, y0), (x1, y1) in zip(corners, [*corners[1:], corners[0]], strict=True):
        length = math.hypot(x1 - x0, y1 - y0)
        nx, ny = (y0 - y1) / length, (x1 - x0) / length  # to the left: inwards
        lines.append((nx, ny, nx * x0 + ny * y0 + distance))
    shrunk = []
    for (ax, ay, ac), (bx, by, bc) in zip([lines[-1], *lines[:-1]], lines, strict=True):
        area = ax * by - ay * bx
        shrunk.append(((ac * by - bc * ay) / area, (ax * bc - bx * ac) / area))
    return shrunk


def _flow(values: Sequence[float]) -> str:
    return "[" + ", ".join(f"{value:.12g}" for value in values) + "]"


def _listed(points: Iterable[Point]) -> str:
    return "[" + ", ".join(_flow(point) for point in points) + "]"
