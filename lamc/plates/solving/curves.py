"""Curved edges that are drawn as polygons and held along: where the curve lies beside the nodes.

In: places, and which edges. Out: for nodes on curves the curve's direction and its distance. Never: what is held there.

A polygon held along its sides does not tend to the plate with a curved edge, however many sides it has: w = 0 on two
sides that meet makes both slopes vanish at the corner (I. Babuška, 1963; O. M. Sapondzhyan, 1952). Held is w on the
curve instead: with a node at the distance h inside, w + h w_n = 0 and no slope along the curve, which leaves an error
of the order h². The curve goes through the polygon's corners; along each side it is the cubic with the tangents that
circles through three corners have (for equal sides, that circle to the fourth order of the angle).

What is a curve: corners that turn the same way by 20° at most, next to each other, by turns and sides that differ by
less than a factor of three. Others are corners of a polygon that is meant; a regular one of 8 or more may not be.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from lamc.basics.checks import Array
from lamc.plates.locator import MeshLocator
from lamc.plates.meshing.mesh import Integers
from lamc.plates.supports import Where

_STRAIGHT, _CURVE = np.radians(0.01), np.radians(20.0)  # turns: less is a straight side, more a corner
_ALIKE = 3.0  # ratio of neighbouring turns, and of neighbouring sides, of one curve
_REGULAR, _ROUND = (
    1.05,
    8,
)  # ratio of turns, and of sides, of a polygon that may stand for a circle; corners at least


@dataclass(frozen=True, eq=False)
class CurveNodes:
    """Nodes on sides and corners of curves, ascending.

    along   (k, 2): unit vectors along the curve there; across (k, 2): a quarter turn to the left from it
    height  (k,): m, of the curve beside the node, along `across`; zero at corners
    """

    nodes: Integers
    along: Array
    across: Array
    height: Array


def curve_nodes(places: MeshLocator, wheres: Sequence[Where]) -> CurveNodes:
    """Of all edges on any of `wheres`; nodes of edges that are no curves are left out."""
    found: dict[int, tuple[Array, float]] = {}
    for chain in _chains_on(places, wheres):
        for node, along, height in _of_chain(places.dofs.mesh.points, chain):
            found[node] = (along, height)
    nodes = np.array(sorted(found), dtype=np.int32)
    along = np.array([found[node][0] for node in nodes.tolist()]).reshape(-1, 2)
    heights = np.array([found[node][1] for node in nodes.tolist()])
    return CurveNodes(nodes, along, np.stack([-along[:, 1], along[:, 0]], axis=1), heights)


def round_polygons(places: MeshLocator, wheres: Sequence[Where]) -> tuple[int, ...]:
    """Corners of closed lines on `wheres` that are regular polygons of eight or more, and no curves by their turns."""
    found = []
    for chain in _chains_on(places, wheres):
        if chain[0] != chain[-1]:
            continue
        at = places.dofs.mesh.points[chain]
        turning = _turnings(at, True)[:-1]
        corners = np.flatnonzero(np.abs(turning) > _STRAIGHT)
        if len(corners) < _ROUND or _curved(np.append(turning[corners], turning[corners[0]]), True).any():
            continue
        sides = np.linalg.norm(np.roll(at[corners], -1, axis=0) - at[corners], axis=1)
        one_way = turning[corners] * np.sign(turning[corners[0]])
        if one_way.max() < _REGULAR * one_way.min() and sides.max() < _REGULAR * sides.min():
            found.append(len(corners))
    return tuple(found)


def _chains_on(places: MeshLocator, wheres: Sequence[Where]) -> list[list[int]]:
    """Of all edges on any of `wheres`."""
    mesh = places.dofs.mesh
    edges = np.concatenate([np.zeros((0, 2), dtype=np.int32), *(places.edges_on(where) for where in wheres)])
    return _chains(mesh.edges[np.unique(mesh.cell_edges[edges[:, 0], edges[:, 1]])])


def _chains(pairs: Integers) -> list[list[int]]:
    """Nodes along lines without forks; rings end with the node that they begin with."""
    beside: dict[int, list[int]] = {}
    for a, b in pairs.tolist():
        beside.setdefault(a, []).append(b)
        beside.setdefault(b, []).append(a)
    left = {(a, b) for a, others in beside.items() for b in others}
    ends = [node for node in sorted(beside) if len(beside[node]) != 2]
    chains = []
    for start in [*ends, *sorted(beside)]:
        for following in beside[start]:
            if (start, following) not in left:
                continue
            chain = [start, following]
            left -= {(start, following), (following, start)}
            while len(beside[chain[-1]]) == 2 and chain[-1] != start:
                here = chain[-1]
                after = next((b for b in beside[here] if (here, b) in left), None)
                if after is None:
                    break
                chain.append(after)
                left -= {(here, after), (after, here)}
            chains.append(chain)
    return chains


def _of_chain(points: Array, chain: list[int]) -> list[tuple[int, Array, float]]:
    """Nodes of a chain that are on curves, with direction and height."""
    ring = chain[0] == chain[-1]
    at = points[chain]
    turning = _turnings(at, ring)
    corners = np.flatnonzero(np.abs(turning) > _STRAIGHT)
    if ring and len(corners):
        chain = [*chain[corners[0] : -1], *chain[: corners[0] + 1]]
        at = points[chain]
        turning = _turnings(at, ring)
        corners = np.append(np.flatnonzero(np.abs(turning[:-1]) > _STRAIGHT), len(chain) - 1)
    elif not ring:
        corners = np.unique([0, *corners, len(chain) - 1])
    if len(corners) < 3:
        return []
    sides = np.linalg.norm(np.diff(at[corners], axis=0), axis=1)
    start, end = _tangents(turning[corners], sides, ring)
    found = []
    for k in range(len(sides)):
        if np.isnan(start[k]):
            continue
        along = (at[corners[k + 1]] - at[corners[k]]) / sides[k]
        for j in range(corners[k], corners[k + 1] + 1):
            t = float((at[j] - at[corners[k]]) @ along) / sides[k]
            a, b = np.tan(start[k]), np.tan(end[k])
            height = sides[k] * t * (1.0 - t) * (a * (1.0 - t) - b * t)
            slope = a * (1.0 - t) * (1.0 - 3.0 * t) + b * t * (3.0 * t - 2.0)
            c, s = np.array([1.0, slope]) / np.hypot(1.0, slope)
            inside = corners[k] < j < corners[k + 1]
            direction = np.array([c * along[0] - s * along[1], s * along[0] + c * along[1]])
            found.append((chain[j], direction, float(height) if inside else 0.0))
    return found


def _turnings(at: Array, ring: bool) -> Array:
    """Angle by which the chain turns to the left at each node, shape (k,); zero at its ends."""
    step = np.diff(at, axis=0)
    before, after = step[:-1], step[1:]
    if ring:
        before, after = np.concatenate([step[-1:], step]), np.concatenate([step, step[:1]])
    cross = before[:, 0] * after[:, 1] - before[:, 1] * after[:, 0]
    turning = np.arctan2(cross, np.sum(before * after, axis=1))
    return np.asarray(turning if ring else np.concatenate([[0.0], turning, [0.0]]))


def _tangents(turning: Array, sides: Array, ring: bool) -> tuple[Array, Array]:
    """Angles of the curve's tangents to each side at its start and at its end, left positive; nan for what is no curve.

    turn  (s + 1,), at the corners; sides (s,), their lengths
    """
    before = np.roll(sides, 1) if ring else np.append(np.nan, sides[:-1])
    after = np.roll(sides, -1) if ring else np.append(sides[1:], np.nan)
    curved = _curved(turning, ring)
    alike = [_share(sides, before), _share(sides, after)]
    start = np.where(curved[:-1], -turning[:-1] * alike[0], np.nan)
    end = np.where(curved[1:], turning[1:] * alike[1], np.nan)
    # A side with a curve at one end only goes on as a circle, unless it is the straight side that the curve runs into.
    none = [np.isnan(start), np.isnan(end)]
    start = np.where(none[0] & (np.nan_to_num(end) != 0.0), -end, start)
    end = np.where(none[1] & (np.nan_to_num(start) != 0.0), -start, end)
    lost = np.isnan(start) | np.isnan(end)
    return np.where(lost, np.nan, start), np.where(lost, np.nan, end)


def _share(own: Array, other: Array) -> Array:
    """How much of the turn at a corner a side takes of the two that meet there: all, where the other is so much longer
    that it is straight."""
    with np.errstate(invalid="ignore"):
        ratio = other / own
        return np.asarray(
            np.where(ratio > _ALIKE, 1.0, np.where(ratio < 1.0 / _ALIKE, 0.0, 1.0 / (1.0 + ratio)))
        )


def _curved(turning: Array, ring: bool) -> Array:
    """Which corners are of a curve: small turns with one like it beside them."""
    size = np.abs(turning)
    small = (size > _STRAIGHT) & (size < _CURVE)
    with np.errstate(divide="ignore", invalid="ignore"):
        ratio = turning[1:] / turning[:-1]
    alike = small[1:] & small[:-1] & (ratio > 1.0 / _ALIKE) & (ratio < _ALIKE)
    first = alike[-1:] if ring else np.array([False])
    last = alike[:1] if ring else np.array([False])
    return np.asarray(small & (np.concatenate([first, alike]) | np.concatenate([alike, last])))
