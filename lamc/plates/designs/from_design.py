"""A body of a laminate design as a plate: regions of equal stack, and the edges at which hinges hold it.

In: a design (or the steps of its splitting) and the name of a body, or of several. Out: polygons by region, a laminate
for each about one common reference surface, the hinge lines on its edge. Never: meshes, supports, loads.

Splitting cuts a slit along every hinge line, which no one cuts in a device; what becomes of it is the caller's choice:

    "none"    the body as it was cut, its edges half a slit from the hinge lines
    "lines"   without what bends: its edges are where its stiff layers end, a hinge width from the line at most, to be
              supported there, and a rotational spring has the stiffness of the strip; between two bodies of the plate
              both reach up to the line, which is a `HingeLine` with that spring
    "strips"  with the whole strip of the flexible layer, one hinge width to both sides of the line, as a soft region of
              its own; its far edge is where the neighbour begins. Several bodies hang together by their strips.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
import shapely
from shapely.geometry import MultiPolygon, Polygon
from shapely.geometry.base import BaseGeometry

from lamc.basics.checks import checked_number, did_you_mean, shown
from lamc.basics.errors import DesignError
from lamc.basics.readonly import ReadOnlyDict
from lamc.design.cutting import material_size
from lamc.design.split import split_steps
from lamc.design.steps import Connection, SplitBody, SplitSteps
from lamc.plates.designs.hinge_edges import HingeEdge, PlateHinge
from lamc.plates.designs.inner_lines import is_strip, line_of, strip_name, without_strips
from lamc.plates.designs.materials import plate_materials, ply_angle
from lamc.plates.designs.overlay import (
    Overlay,
    Stack,
    areas_of,
    default_tolerance,
    is_sliver,
    overlay,
    polygons_of,
    stack_name,
)
from lamc.plates.hinge_lines import HingeLine
from lamc.plates.laminates.laminate import Laminate
from lamc.plates.laminates.materials import Material
from lamc.plates.laminates.plies import Ply
from lamc.plates.meshing.checks import place
from lamc.plates.meshing.mesh import Mesh
from lamc.plates.meshing.mesher import mesh
from lamc.records.design import Design

HINGES = ("none", "lines", "strips")
EVERY = "all"  # instead of names: every body
# Cells across a strip: a body that twists bends it both ways within its width, and one row of cells makes the second
# mode of a flap 18 % low, two 2.2 %, four 0.4 %, eight 0.1 %.
ROWS = 4
_USUAL = 40  # cells along the longer side, where no size is given, as in files


@dataclass(frozen=True, eq=False)
class DesignPlate:
    """A body as a plate, world axes x and y.

    regions    disjoint polygons by name, m; the name says the layers, or "hinge h1" for a strip
    laminates  for each region, all about the same reference surface
    hinges     those to bodies outside, by joint
    lines      those between bodies of the plate, by joint, where they are taken as lines; for `Problem(…, hinges=…)`
    fixed      what the world holds, m; empty for a body that moves
    height     m, of the reference surface above the bottom of the design
    notes      one line for each thing that was done and that the drawing did not ask for
    """

    name: str
    regions: Mapping[str, Polygon | MultiPolygon]
    laminates: Mapping[str, Laminate]
    hinges: Mapping[str, HingeEdge]
    lines: Mapping[str, HingeLine]
    fixed: BaseGeometry
    height: float
    notes: tuple[str, ...]

    @property
    def outline(self) -> BaseGeometry:
        """All regions together, m."""
        return shapely.union_all(list(self.regions.values()))

    @property
    def sizes(self) -> dict[str, float]:
        """Of the cells of strips, by region, m: so that there are four rows across each."""
        found = {name: strip for name, strip in self.regions.items() if is_strip(name)}
        return {name: 2.0 * strip.area / strip.length / ROWS for name, strip in found.items()}

    def mesh(self, size: float | None = None, *, sizes: Mapping[str, float] | None = None) -> Mesh:
        """Triangles with edges of about `size` m, None: a fortieth of the longer side; those of strips are smaller, as
        `sizes` says, and `sizes` by region replaces that. Follows `lines` too. Raises DesignError as `plate.mesh`."""
        outline = self.outline
        x0, y0, x1, y1 = outline.bounds
        general = max(x1 - x0, y1 - y0) / _USUAL if size is None else size
        strips = {name: min(own, general) for name, own in self.sizes.items()}
        followed = [shapely.intersection(line.where, outline) for line in self.lines.values()]
        return mesh(
            outline,
            general,
            regions=dict(self.regions),
            sizes=strips | dict(sizes or {}),
            follow=[part for line in followed for part in shapely.get_parts(line) if part.length > 0.0],
        )


def plate_of(
    design: Design | SplitSteps,
    body: str | Sequence[str],
    *,
    hinges: str = "none",
    materials: Mapping[str, Material] | None = None,
    height: float | None = None,
    tolerance: float | None = None,
) -> DesignPlate:
    """The plate that a body of a design is, or several bodies together; "all" of them.

    hinges     "none", "lines" or "strips", as above
    materials  replace the design's own of the same name: better known, with strengths, or in place of placeholders
    height     m, of the reference surface above the bottom of the design; None: the middle of the largest region
    tolerance  m, what is narrower is given to its neighbour; None: 1e-6 of the drawing, at most 1/50 of a hinge width

    Raises DesignError for an unknown body or choice, for bodies above one another, for materials without moduli, where
    nothing is left, and as `split` does.
    """
    if hinges not in HINGES:
        raise DesignError(f"hinges is {shown(hinges)}; it must be one of {', '.join(HINGES)}")
    if isinstance(design, Design) and design.facet_creases is not None:
        design = replace(design, facet_creases=None)  # a plate bends everywhere
    steps = design if isinstance(design, SplitSteps) else split_steps(design)
    bodies = _chosen(steps, body)
    layers = steps.design.layers
    narrowest = min(hinge.properties.width for hinge in steps.hinges)
    if tolerance is None:
        tolerance = default_tolerance(material_size(layers), narrowest)
    elif checked_number(tolerance, "the tolerance of a plate") <= 0.0:
        raise DesignError(f"the tolerance of a plate is {tolerance:g} m; it must be positive")
    _check_one_sheet(bodies, tolerance)
    joined = [PlateHinge(steps, c, bodies) for c in steps.connections if _inside(c, bodies)]
    inner = [each for each in joined if not each.neighbour] if hinges == "lines" else []
    areas = [MultiPolygon([p for part in bodies for p in part.polygons[k]]) for k in range(len(layers))]
    for each in joined:
        areas[each.layer] = each.changed(areas[each.layer], hinges)
    bending = joined if hinges == "strips" else inner
    found = overlay([*areas, *(each.strip() for each in bending)], tolerance)
    stacks = _named(found, bending, [layer.name for layer in layers])
    stacks = without_strips(stacks, inner)
    if not stacks:
        raise DesignError(
            f"nothing is left of {', '.join(repr(part.name) for part in bodies)} with hinges={hinges!r} that is wider "
            f'than {tolerance * 1e3:.3g} mm; take the hinges as strips: hinges="strips"'
        )
    regions = {name: _simplest(region) for name, (_, region) in stacks.items()}
    used = sorted({k for stack, _ in stacks.values() for k in stack})
    plies = plate_materials(steps.design, used, materials)
    if height is None:
        height = _middle_of_largest(steps.design, stacks)
    outline = shapely.union_all(list(regions.values()))
    lines = {
        each.name: line_of(
            each,
            regions,
            steps.design,
            lambda used: plate_materials(steps.design, used, materials),
            tolerance,
        )
        for each in inner
    }
    held = shapely.union_all(
        [
            shapely.intersection(steps.design.fixed[k], areas[k])
            for k in range(len(layers))
            if areas[k].area > 0.0
        ]
    )
    return DesignPlate(
        name="+".join(part.name for part in bodies),
        regions=ReadOnlyDict(regions),
        laminates=ReadOnlyDict(
            {name: _laminate(steps.design, stack, plies, height) for name, (stack, _) in stacks.items()}
        ),
        hinges=ReadOnlyDict(
            {e.name: e.edge(hinges, areas[e.layer], tolerance) for e in joined if e.neighbour}
        ),
        lines=ReadOnlyDict({name: line for name, (line, _) in lines.items()}),
        fixed=shapely.intersection(held, outline) if any(part.fixed for part in bodies) else MultiPolygon(),
        height=height,
        notes=(
            *_notes(found, stacks, steps.design, tolerance),
            *(note for _, note in lines.values() if note),
        ),
    )


def _chosen(steps: SplitSteps, body: str | Sequence[str]) -> tuple[SplitBody, ...]:
    names = (body,) if isinstance(body, str) else tuple(body)
    known = [part.name for part in steps.bodies]
    if names == (EVERY,) and EVERY not in known:
        return steps.bodies
    for name in names:
        if name not in known:
            raise DesignError(
                f"design {steps.design.name!r} has no body {shown(name)}; {did_you_mean(str(name), known)}"
            )
    if not names:
        raise DesignError(f"no body of design {steps.design.name!r} is named; {did_you_mean('', known)}")
    return tuple(part for part in steps.bodies if part.name in names)


def _check_one_sheet(bodies: Sequence[SplitBody], tolerance: float) -> None:
    """Raises DesignError where two bodies cover the same place: what lies above one another unjoined is no plate."""
    covered = [areas_of(shapely.union_all([p for sheet in part.polygons for p in sheet])) for part in bodies]
    pairs = shapely.STRtree(covered).query(covered, predicate="intersects").T
    for one, other in sorted((int(i), int(k)) for i, k in pairs if i < k):
        shared = [
            p
            for p in polygons_of(shapely.intersection(covered[one], covered[other]))
            if not is_sliver(p, tolerance)
        ]
        if shared:
            at = place(np.array(shared[0].representative_point().coords[0]))
            raise DesignError(
                f"bodies {bodies[one].name!r} and {bodies[other].name!r} lie above one another at {at}, and nothing "
                "joins them there; a plate is one sheet: name bodies that lie side by side, or one alone"
            )


def _inside(connection: Connection, bodies: Sequence[SplitBody]) -> bool:
    return any(part.name in (connection.parent, connection.child) for part in bodies)


def _named(
    found: Overlay, joined: Sequence[PlateHinge], names: Sequence[str]
) -> dict[str, tuple[Stack, MultiPolygon]]:
    """Regions by name, with their layers; a strip of its flexible layer alone has the hinge's name."""
    count = len(names)
    parts: dict[tuple[Stack, str], list[Polygon]] = {}
    for stack, region in found.regions.items():
        layers = tuple(k for k in stack if k < count)
        strip = [joined[k - count] for k in stack if k >= count]
        title = strip_name(strip[0].name) if strip and layers == (strip[0].layer,) else ""
        parts.setdefault((layers, title), []).extend(region.geoms)
    present = sorted({k for layers, _ in parts for k in layers})
    return {
        title or stack_name(layers, names, present): (
            layers,
            MultiPolygon(polygons_of(shapely.union_all(each))),
        )
        for (layers, title), each in sorted(parts.items(), key=lambda item: item[0])
    }


def _simplest(region: MultiPolygon) -> Polygon | MultiPolygon:
    return region.geoms[0] if len(region.geoms) == 1 else region


def _middle_of_largest(design: Design, stacks: Mapping[str, tuple[Stack, MultiPolygon]]) -> float:
    stack, _ = max(stacks.values(), key=lambda item: item[1].area)
    return (design.z[stack[0]] + design.z[stack[-1] + 1]) / 2


def _laminate(design: Design, stack: Stack, materials: Mapping[str, Material], height: float) -> Laminate:
    z = design.z
    plies: list[Ply] = []
    top = z[stack[0]]
    for k in stack:
        layer = design.layers[k]
        gap = z[k] - top if k - 1 not in stack and plies else 0.0
        plies.append(Ply(materials[layer.material.name], layer.thickness, ply_angle(layer), gap))
        top = z[k + 1]
    return Laminate(plies, height - (z[stack[0]] + top) / 2)


def _notes(
    found: Overlay, stacks: Mapping[str, tuple[Stack, MultiPolygon]], design: Design, tolerance: float
) -> tuple[str, ...]:
    notes = []
    if found.slivers:
        notes.append(
            f"{found.slivers} slivers narrower than {tolerance * 1e3:.3g} mm, {found.moved * 1e6:.3g} mm² in all, were "
            "given to their neighbours"
        )
    for name, (stack, _) in stacks.items():
        if stack[-1] - stack[0] + 1 != len(stack):
            empty = [design.layers[k].name for k in range(stack[0], stack[-1]) if k not in stack]
            notes.append(
                f"region {name!r} is empty in {', '.join(map(repr, empty))}: its sheets count as held at their distance"
            )
    return tuple(notes)
