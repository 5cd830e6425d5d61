"""Facets that bend: each moving facet of four corners or more becomes triangles with hinges along its diagonals.

In: bodies and connections of a splitting, and what a design says of its facet creases. Out: the same with more of
both, and notes. Never: takes material away; the parts share a facet's area, and its mass, exactly.

A diagonal bends as in bar-and-hinge models (E. T. Filipov, K. Liu, T. Tachi, M. Schenk, G. H. Paulino, "Bar and hinge
models for scalable analysis of origami", Int. J. Solids Struct. 124, 2017, 26): k = C B (D/t)^(1/3) with the facet's
bending stiffness B = E t³/(12 (1 - ν²)), its short diagonal D and C = 0.55 - 0.42 (α₁ + α₂)/π, α the corners that the
diagonal cuts off. It was fitted to thin parallelograms whose edges are held straight by folds. For small rotations and
free edges, thin-plate theory has B (1 - ν) for a square, and no size.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import shapely
from shapely.geometry import LineString, MultiPolygon, Polygon

from lamc.basics.errors import DesignError
from lamc.design.bodies import largest
from lamc.design.facet_corners import corners_of, shortest_diagonals, triangle_corners
from lamc.design.steps import Connection, Hinge, SplitBody
from lamc.records.design import Design, FacetCreases, HingeLine, HingeSet
from lamc.records.mechanism import Array

_COVERS = 0.5  # of a facet: a layer with less of it is a patch and does not bend as one with the rest


@dataclass(frozen=True, eq=False)
class Bent:
    """Bodies with facets in parts, the hinges about them as before and then those between them, and notes."""

    bodies: tuple[SplitBody, ...]
    connections: tuple[Connection, ...]
    notes: tuple[str, ...]


@dataclass(frozen=True, eq=False)
class _Facet:
    """A body in parts: each with its corners (n, 2), and the hinges between them."""

    parts: tuple[SplitBody, ...]
    corners: tuple[Array, ...]
    inner: tuple[Connection, ...]

    def at(self, hinge: Hinge) -> str:
        """The part at whose rim a hinge lies."""
        middle = hinge.line.interpolate(0.5, normalized=True)
        distances = [Polygon(corners).exterior.distance(middle) for corners in self.corners]
        return self.parts[int(np.argmin(distances))].name


def bend_facets(
    design: Design, bodies: Sequence[SplitBody], connections: Sequence[Connection], asked: FacetCreases
) -> Bent:
    """The bodies and hinges with every facet that can bend in parts.

    Raises DesignError where a stiffness is to come from materials that have no moduli.
    """
    about: dict[str, list[Hinge]] = {body.name: [] for body in bodies}
    for connection in connections:
        about[connection.parent].append(connection.hinge)
        about[connection.child].append(connection.hinge)
    facets: dict[str, _Facet] = {}
    left: dict[str, list[str]] = {}
    for body in bodies:
        made = _facet(design, body, about[body.name], asked)
        if isinstance(made, _Facet):
            facets[body.name] = made
        else:
            left.setdefault(made, []).append(body.name)
    return _put_together(bodies, connections, facets, left)


def _put_together(
    bodies: Sequence[SplitBody],
    connections: Sequence[Connection],
    facets: dict[str, _Facet],
    left: dict[str, list[str]],
) -> Bent:
    def part(name: str, hinge: Hinge) -> str:
        return facets[name].at(hinge) if name in facets else name

    # Parent and child stay as they were: angles count from the one to the other.
    every = [Connection(c.hinge, part(c.parent, c.hinge), part(c.child, c.hinge)) for c in connections]
    made: list[SplitBody] = []
    for body in bodies:
        made += facets[body.name].parts if body.name in facets else [body]
    for facet in facets.values():
        every += facet.inner
    return Bent(tuple(made), tuple(every), _notes(facets, left))


def _notes(facets: dict[str, _Facet], left: dict[str, list[str]]) -> tuple[str, ...]:
    creases = [connection.hinge for facet in facets.values() for connection in facet.inner]
    if not creases:
        told = "facet_creases: no facet has four corners or more and may bend, so none is parted"
    else:
        sample = next(iter(facets.values()))
        ends = [f"{each(crease.properties.stiffness for crease in creases):.3g}" for each in (min, max)]
        told = (
            f"facet_creases: {len(facets)} {'facet bends' if len(facets) == 1 else 'facets bend'} along {len(creases)} "
            f"{'diagonal' if len(creases) == 1 else 'diagonals'} of {' to '.join(dict.fromkeys(ends))} N·m/rad; parts "
            f"and hinges are named as {', '.join(repr(p.name) for p in sample.parts)} and "
            f"{sample.inner[0].hinge.name!r}"
        )
    whole = [f"{len(names)} {why}" for why, names in sorted(left.items())]
    return (told + (f"; left whole: {', '.join(whole)}" if whole else ""),)


def _facet(design: Design, body: SplitBody, hinges: Sequence[Hinge], asked: FacetCreases) -> "_Facet | str":
    """The facet in parts, or why it is left whole."""
    if body.fixed:
        return "fixed"
    if len({hinge.z for hinge in hinges}) != 1:
        return "between hinges of several layers"
    width = max(hinge.properties.width for hinge in hinges)
    flexible = hinges[0].properties.layer
    outline = largest(body.polygons[flexible] or [p for layer in body.polygons for p in layer])
    corners = corners_of(outline, [hinge.line for hinge in hinges], width)
    if corners is None:
        return "of no convex polygon"
    diagonals = shortest_diagonals(corners)
    if not diagonals:
        return "of three corners"
    return _parted(design, body, corners, diagonals, hinges[0], asked)


def _parted(
    design: Design,
    body: SplitBody,
    corners: Array,
    diagonals: Sequence[tuple[int, int]],
    sample: Hinge,
    asked: FacetCreases,
) -> "_Facet | str":
    pieces: list[tuple[list[int], tuple[tuple[Polygon, ...], ...]]] = [
        (list(range(len(corners))), body.polygons)
    ]
    for pair in diagonals:
        which = next(k for k, (ring, _) in enumerate(pieces) if set(pair) <= set(ring))
        ring, polygons = pieces.pop(which)
        i, j = (ring.index(end) for end in pair)
        for side, rest in ((1.0, ring[: i + 1] + ring[j:]), (-1.0, ring[i : j + 1])):
            pieces.append((rest, _half(polygons, corners[pair[0]], corners[pair[1]], side)))
    pieces.sort(key=lambda piece: tuple(corners[piece[0]].mean(axis=0).tolist()))
    if not all(any(polygons) for _, polygons in pieces):
        return "with a part that holds no material"
    parts = tuple(
        SplitBody(f"{body.name}_t{k}", False, polygons) for k, (_, polygons) in enumerate(pieces, start=1)
    )
    inner = []
    for number, pair in enumerate(diagonals, start=1):
        cut_off = triangle_corners(len(corners), diagonals, pair)
        stiffness = asked.stiffness
        if stiffness is None:
            stiffness = bending_stiffness(design, body, corners[list(pair)], corners[cut_off])
        crease = _crease(
            f"{body.name}_d{number}", corners[list(pair)], sample, body, stiffness, asked.damping
        )
        first, second = (
            part.name for part, (ring, _) in zip(parts, pieces, strict=True) if set(pair) <= set(ring)
        )
        inner.append(Connection(crease, first, second))
    return _Facet(parts, tuple(corners[ring] for ring, _ in pieces), tuple(inner))


def _half(
    polygons: tuple[tuple[Polygon, ...], ...], start: Array, end: Array, side: float
) -> tuple[tuple[Polygon, ...], ...]:
    """What lies to the left (+1) or to the right (-1) of the line from start to end, by layer."""
    shape = MultiPolygon([p for layer in polygons for p in layer])
    reach = 2.0 * (math.dist(shape.bounds[:2], shape.bounds[2:]) + math.dist(start, end))
    along = (end - start) / np.linalg.norm(end - start)
    across = side * np.array([-along[1], along[0]])
    a, b = start - reach * along, start + reach * along
    plane = shapely.polygons([a, b, b + reach * across, a + reach * across])
    cut = [
        shapely.get_parts(shapely.intersection(np.array(layer, dtype=object), plane)) for layer in polygons
    ]
    return tuple(
        tuple(sorted((p for p in layer if isinstance(p, Polygon) and p.area > 0.0), key=lambda p: p.bounds))
        for layer in cut
    )


def _crease(
    name: str, ends: Array, sample: Hinge, body: SplitBody, stiffness: float, damping: float
) -> Hinge:
    start, end = sorted((float(x), float(y)) for x, y in ends)
    layers = tuple(k for k, layer in enumerate(body.polygons) if layer)
    drawn = HingeSet(
        (HingeLine((start, end), name),),
        sample.properties.width,
        sample.properties.layer,
        layers,
        stiffness,
        damping,
    )
    return replace(sample, name=name, line=LineString([start, end]), properties=drawn, layers=layers)


def bending_stiffness(design: Design, body: SplitBody, ends: Array, cut_off: Array) -> float:
    """N·m/rad, of a facet along the diagonal between `ends` (2, 2), m, that cuts off two corners (2, 2).

    Raises DesignError where a layer has no moduli, or those of wood.
    """
    thickness, bending = _laminate(design, body)
    angles = 0.0
    for corner in cut_off:
        (ax, ay), (bx, by) = ends - corner
        angles += abs(math.atan2(ax * by - ay * bx, ax * bx + ay * by))
    factor = 0.55 - 0.42 * min(
        angles / math.pi, 1.0
    )  # fitted to parallelograms: they have less than two right angles
    return float(factor * bending * (math.dist(*ends) / thickness) ** (1.0 / 3.0))


def _laminate(design: Design, body: SplitBody) -> tuple[float, float]:
    """Thickness, m, and bending stiffness, N·m, of the layers that a facet is made of, about their neutral surface."""
    areas = [math.fsum(p.area for p in layer) for layer in body.polygons]
    bonded = [k for k, area in enumerate(areas) if area > _COVERS * max(areas)]
    first, second, third = 0.0, 0.0, 0.0
    for k in bonded:
        material, place = design.layers[k].material, design.places.of("layers", k)
        if material.E1 is None or material.poisson is None:
            raise DesignError(
                f"facet_creases takes the stiffness from materials, and {material.name!r} has no modulus or Poisson's "
                "ratio: give it E1, E2 and poisson, or facet_creases a stiffness in N*m/rad",
                place,
            )
        if material.E2 is not None and abs(material.E2 - material.E1) > 1e-6 * material.E1:
            raise DesignError(
                f"facet_creases takes the stiffness of isotropic materials, and {material.name!r} has moduli of "
                f"{material.E1:g} and {material.E2:g} Pa: give facet_creases a stiffness in N*m/rad",
                place,
            )
        modulus = material.E1 / (1.0 - material.poisson**2)
        low, high = design.z[k], design.z[k + 1]
        first += modulus * (high - low)
        second += modulus * (high**2 - low**2) / 2.0
        third += modulus * (high**3 - low**3) / 3.0
    thickness = math.fsum(design.layers[k].thickness for k in bonded)
    return thickness, third - second**2 / first
