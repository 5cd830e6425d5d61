"""The Miura-ori of any size, drawn: text of a native design.

In: how many facets. Out: YAML, the same to the byte for the same numbers. Never: reads or writes files, simulates.

Facet f{i}_{j} is the i-th along x and the j-th along y, from 0. Zigzag crease z{i}_{j} lies before facet f{i}_{j} along
x, and straight crease s{i}_{j} before it along y. Folded, all zigzag creases share one magnitude |z| and all straight
ones another, tan(|s|/2) = cos(ACUTE) tan(|z|/2), as flat-foldable vertices have it (T. Tachi, Generalization of
rigid-foldable quadrilateral-mesh origami, J. IASS 50, 2009, 173, in other letters).
"""

import math
import textwrap

from lamc.examples.sheet import LAMINATE

ALONG, ACROSS = 30.0, 25.0  # mm, sides of a facet along the straight creases and along the zigzag ones
ACUTE = math.radians(65.0)  # acute angle of a facet
GAP = 1.0  # mm, left open in the card along a crease
REST = math.radians(70.0)  # of the zigzag creases
START = 30.0  # degrees, of the first zigzag crease

_STORY = """\
The Miura-ori of {columns} by {rows} facets: one sheet of card, film and card, creased along straight lines and
zigzags. Every inner vertex is a spherical four-bar that folds with one freedom, and any number of them fold
together with that same one: {count} with {equations} equations, three about each vertex, of which {rank}
count. The rest are redundant, and a solver that takes them all locks up on round-off. As drawn it is flat and
singular, so the start gives the zigzag creases of one row, and the others follow. Look at results.csv: zigzag
creases share one magnitude and straight ones another, tan(s/2) = cos(65 deg) tan(z/2)."""
_STRIP = """\
A strip of {columns} by {rows} facets of the Miura-ori. It has no inner vertex, hence no loops: each crease folds by
itself. Look at miura:2x2 next: two facets in both directions make it rigid origami of one freedom."""

_HEAD = """\
# A Miura-ori of {columns} x {rows} facets: {count}, {freedoms}.
kind: design
name: miura_{columns}x{rows}
story: >
{story}
units: mm

"""


def miura(columns: int, rows: int) -> str:
    """The design of columns x rows facets, two or more in all, folded to `START` at its first zigzag crease."""
    loops = (columns - 1) * (rows - 1)
    first = "z1_0" if columns > 1 else "s0_1"
    counted = {0: "no loop", 1: "one loop"}.get(loops, f"{loops} loops")
    facts = {"count": counted, "columns": columns, "rows": rows, "equations": 3 * loops}
    joints = (columns - 1) * rows + columns * (rows - 1)
    freedoms = "one freedom" if loops else f"{joints} freedoms"
    story = (_STORY if loops else _STRIP).format(rank=joints - 1, **facts)
    story = textwrap.fill(story, 118, initial_indent="  ", subsequent_indent="  ")
    head = _HEAD.format(story=story, freedoms=freedoms, **facts) + LAMINATE
    parts = [head, _shapes(columns, rows)]
    parts.append(_hinges(columns, rows))
    parts.append(f"fixed:\n  - {{rect: {_flow(*_box(0, 0))}}}\n")
    parts.append(_bodies(columns, rows))
    folded = {f"z{i}_0": START if i % 2 else -START for i in range(1, columns)} or {first: START}
    angles = ", ".join(f"{name}: {angle:g} deg" for name, angle in folded.items())
    parts.append(f"scene:\n  angles: {{{angles}}}\n")
    return "\n".join(parts)


def _corner(i: int, j: int) -> tuple[float, float]:
    """Where the creases before facet f{i}_{j} meet, mm."""
    return i * ALONG + (j % 2) * ACROSS * math.cos(ACUTE), j * ACROSS * math.sin(ACUTE)


def _inside(i: int, j: int, u: float, v: float) -> tuple[float, float]:
    """A point of facet f{i}_{j}, mm: the parts u of its straight and v of its zigzag side."""
    (x, y), (x_up, y_up) = _corner(i, j), _corner(i, j + 1)
    return x + u * ALONG + v * (x_up - x), y + v * (y_up - y)


def _flow(*values: float) -> str:
    return "[" + ", ".join(f"{value:.15g}" for value in values) + "]"


def _points(points: list[tuple[float, float]]) -> str:
    return "[" + ", ".join(_flow(*point) for point in points) + "]"


def _box(i: int, j: int) -> tuple[float, float, float, float]:
    """A small rectangle in the middle of a facet, mm."""
    x, y = _inside(i, j, 0.5, 0.5)
    return x - 3.0, y - 3.0, x + 3.0, y + 3.0


def _shapes(columns: int, rows: int) -> str:
    left = [_corner(0, j) for j in range(rows + 1)]
    right = [_corner(columns, j) for j in range(rows, -1, -1)]
    lines = [
        "shapes:",
        f"  - {{polygon: {_points([*left, *right])}, layers: film}}",
        "  # card, facet by facet",
    ]
    # The inset on either side is half the gap, measured across the crease.
    u, v = (0.5 * GAP / math.sin(ACUTE) / side for side in (ALONG, ACROSS))
    for i in range(columns):
        for j in range(rows):
            corners = [_inside(i, j, a, b) for a, b in ((u, v), (1 - u, v), (1 - u, 1 - v), (u, 1 - v))]
            lines.append(f"  - {{polygon: {_points(corners)}, layers: [lower, upper]}}")
    return "\n".join(lines) + "\n"


def _hinges(columns: int, rows: int) -> str:
    lines = [
        "# Film of 25 um bends over the gap of 1 mm: E b t^3 / (12 L) is 0.081 N*mm/rad for 25 mm, 0.098 for 30 mm.",
        "# The sheet rests where its zigzag creases are folded by 70 degrees, mountains and valleys in turn.",
        "hinges:",
    ]
    straight_rest = 2.0 * math.atan(math.cos(ACUTE) * math.tan(0.5 * REST))
    for i in range(1, columns):
        for j in range(rows):
            rest = REST if i % 2 else -REST
            lines.append(_hinge(f"z{i}_{j}", [_corner(i, j), _corner(i, j + 1)], 0.081, rest))
    for i in range(columns):
        for j in range(1, rows):
            rest = straight_rest if (i + j) % 2 else -straight_rest
            lines.append(_hinge(f"s{i}_{j}", [_corner(i, j), _corner(i + 1, j)], 0.098, rest))
    return "\n".join(lines) + "\n"


def _hinge(name: str, line: list[tuple[float, float]], stiffness: float, rest: float) -> str:
    return (
        f"  - {{name: {name}, line: {_points(line)}, gap: {GAP:g}, stiffness: {stiffness:g} N*mm/rad, "
        f"damping: 2e-7 N*m*s/rad, rest_angle: {math.degrees(rest):.9g} deg}}"
    )


def _bodies(columns: int, rows: int) -> str:
    lines = ["bodies:"]
    for i in range(columns):
        lines += [f"  f{i}_{j}: {_flow(*_inside(i, j, 0.5, 0.5))}" for j in range(rows)]
    return "\n".join(lines) + "\n"
