"""`split`: from a laminate design to rigid bodies and hinges (Aukes and Wood, section 3.1 and Figure 1).

In: a Design. Out: a Mechanism, or with `split_steps` every intermediate result too. Holes are cut where hinge
lines meet, slits along the lines; pieces that hang together through neighbouring layers are bodies; those
that meet the fixed region are fixed; each hinge line must join exactly two bodies. Nothing depends on the
order in which layers' polygons, hinge lines or sets are given. It reads no files and writes none.
"""

from collections.abc import Callable, Sequence

import numpy as np
import shapely
from shapely.geometry import Polygon

from lamc.basics.checks import shown
from lamc.basics.errors import DesignError, TopologyError
from lamc.design.bodies import Group, find_groups
from lamc.design.check_design import check_design
from lamc.design.contact import contacts, layer_indices
from lamc.design.cutting import SLIT, cut_layers, holes_per_layer, material_size, slits_per_layer
from lamc.design.facet_creases import bend_facets
from lamc.design.linking import Site, link, millimetres
from lamc.design.mass import body_properties, properties_of
from lamc.design.naming import BodyMark, JointMark, body_order, joint_order, name_bodies, name_joints
from lamc.design.steps import Connection, Hinge, Scrap, SplitBody, SplitSteps
from lamc.design.wide_gaps import warn_of_wide_gaps
from lamc.records.design import BodyName, Design
from lamc.records.mechanism import Array, Body, Joint, Mechanism, Slab

Progress = Callable[[str, float], None]

# A piece smaller than this many squares of the narrowest hinge width is a scrap, not a body: holes and slits
# leave such crumbs between them where lines meet at an angle, and no hinge could hold one.
SCRAP = 1.0


def split(design: Design, progress: Progress | None = None) -> Mechanism:
    """The rigid bodies and hinges of a design, SI, world axes, drawn configuration.

    progress  called with what is being done and the part that is done (0 to 1)

    Raises DesignError for a malformed design and TopologyError where it makes no mechanism.
    """
    return split_steps(design, progress).mechanism


def split_steps(design: Design, progress: Progress | None = None) -> SplitSteps:
    """What `split` does, with every step's result. Same arguments and errors."""
    if isinstance(design, Mechanism):
        raise DesignError(f"{design.name!r} is a Mechanism already; use it as it is, only a Design is split")
    if not isinstance(design, Design):
        raise DesignError(f"the design is {shown(design)}; split takes the Design that lamc.load gives")
    try:
        return _steps(design, progress or _silent)
    except DesignError as error:
        place = design.places.of()
        if error.place is not None or place is None:
            raise
        raise type(error)(error.message, place) from error


def _steps(design: Design, tell: Progress) -> SplitSteps:
    tell("checking the drawing", 0.0)
    check_design(design)
    hinges = named_hinges(design)
    tell("cutting", 0.1)
    count = len(design.layers)
    holes = holes_per_layer(hinges, count, design.places.of("hinges"))
    slits = slits_per_layer(hinges, count)
    cut = cut_layers(design.layers, holes, slits)
    tell("finding bodies", 0.4)
    groups = find_groups(cut, design.fixed, material_size(design.layers))
    kept, scraps = _without_scraps(groups, min(h.properties.width for h in hinges))
    if not any(group.fixed for group in kept):
        raise TopologyError(
            f"the fixed region of design {design.name!r} meets no body, so nothing holds it; draw it "
            "over the body that the world holds",
            design.places.of("fixed"),
        )
    tell("weighing bodies", 0.6)
    bodies, parts = _named_bodies(design, kept)
    tell("joining bodies", 0.8)
    layers = layer_indices([p.polygons for p in parts], count)
    sites = [Site(p.name, Group(p.polygons, p.fixed)) for p in parts]
    touched = contacts(hinges, holes, layers)
    connections = link(hinges, touched, sites, [layer.name for layer in design.layers])
    warn_of_wide_gaps(connections, parts)
    notes: tuple[str, ...] = ()
    if design.facet_creases is not None:
        bent = bend_facets(design, parts, connections, design.facet_creases)
        whole = {body.name: body for body in bodies}
        bodies = tuple(
            whole.get(p.name) or _body(p.name, p.fixed, _plates(design, p.polygons)) for p in bent.bodies
        )
        parts, connections, notes = bent.bodies, bent.connections, bent.notes
    joints = tuple(_joint(connection) for connection in connections)
    mechanism = Mechanism(
        bodies,
        joints,
        design.name,
        design.scene,
        design.story,
        design.scenes,
        design.contact_points,
        design=design,
        facet_creases=tuple(joint.name for joint in joints[len(hinges) :]),
        mends=design.mends,
    )
    tell("done", 1.0)
    return SplitSteps(design, holes, slits, cut, parts, connections, scraps, mechanism, notes)


def named_hinges(design: Design) -> tuple[Hinge, ...]:
    """All hinge lines of a design with their names, ordered by geometry."""
    drawn = [(line, hinge_set) for hinge_set in design.hinges for line in hinge_set.lines]
    z = design.z
    heights = [(z[each.layer] + z[each.layer + 1]) / 2 for _, each in drawn]  # mid-planes
    marks = [
        JointMark(*(np.array([*end, height]) for end in line.line))
        for (line, _), height in zip(drawn, heights, strict=True)
    ]
    order = joint_order(marks)
    lines = shapely.linestrings(np.reshape([line.line for line, _ in drawn], (-1, 2, 2)))
    names = name_joints(marks, [line.name for line, _ in drawn], order)
    return tuple(
        Hinge(
            name=names[i],
            line=lines[i],
            z=heights[i],
            properties=drawn[i][1],
            layers=tuple(sorted({drawn[i][1].layer, *drawn[i][1].sublaminate})),
            place=drawn[i][0].place,
        )
        for i in order
    )


def _silent(_stage: str, _part: float) -> None:
    """For callers who do not listen."""


def _without_scraps(groups: Sequence[Group], width: float) -> tuple[tuple[Group, ...], tuple[Scrap, ...]]:
    """Groups that are bodies, and the rest. What the world holds is no scrap: it was drawn on purpose."""
    limit = SCRAP * width * width
    is_body = [g.fixed or g.area >= limit for g in groups]
    kept = tuple(g for g, fits in zip(groups, is_body, strict=True) if fits)
    scraps = (Scrap(g.polygons, g.area, g.at) for g, fits in zip(groups, is_body, strict=True) if not fits)
    return kept, tuple(sorted(scraps, key=lambda scrap: scrap.at))


def _named_bodies(design: Design, groups: Sequence[Group]) -> tuple[tuple[Body, ...], tuple[SplitBody, ...]]:
    """Bodies with masses and names, and their polygons by layer; both in the order of their geometry."""
    plates = [_plates(design, group.polygons) for group in groups]
    properties = properties_of(plates)
    marks = [BodyMark(g.fixed, p[1], p[0], p[2]) for g, p in zip(groups, properties, strict=True)]
    order = body_order(marks)
    names = name_bodies(marks, _drawn_names(design, groups), order)
    bodies, parts = [], []
    for i in order:
        if properties[i][0] == 0.0 and not groups[i].fixed:
            made_of = [k for k, polygons in enumerate(groups[i].polygons) if polygons]
            used = sorted(design.layers[k].name for k in made_of)
            raise DesignError(
                f"body {names[i]!r} at {millimetres(groups[i].at)} has zero mass: the density of "
                f"{', '.join(map(repr, used))} is 0 kg/m³; give the material a density, or fix the body",
                design.places.of("layers", made_of[0]),
            )
        bodies.append(_body(names[i], groups[i].fixed, plates[i], properties[i]))
        parts.append(SplitBody(names[i], groups[i].fixed, groups[i].polygons))
    return tuple(bodies), tuple(parts)


def _body(
    name: str,
    fixed: bool,
    plates: Sequence[tuple[Slab, float]],
    properties: tuple[float, Array, Array] | None = None,
) -> Body:
    mass, com, inertia = properties or body_properties(plates)
    return Body(name, mass, com, inertia, fixed=fixed, outline=tuple(plate for plate, _ in plates))


def _plates(design: Design, polygons: Sequence[Sequence[Polygon]]) -> list[tuple[Slab, float]]:
    z = design.z
    return [
        (Slab(polygon, z[i], z[i + 1]), layer.material.density)
        for i, layer in enumerate(design.layers)
        for polygon in polygons[i]
    ]


def _drawn_names(design: Design, groups: Sequence[Group]) -> list[str | None]:
    """The drawing's name for each group, None where it has none."""
    names: list[str | None] = [None] * len(groups)
    named = sorted(design.body_names, key=lambda item: item.name)
    for given, inside in zip(named, _holders(named, groups), strict=True):
        at = millimetres((given.point.x, given.point.y))
        if len(inside) != 1:
            where = "" if given.layer is None else f" of layer {design.layers[given.layer].name!r}"
            # Sheets above one another: there may be no point that lies in one body alone.
            ask = ", or say in which layer: {at: [x, y], layer: …}" if given.layer is None and inside else ""
            raise DesignError(
                f"the point that names body {given.name!r}, {at}, lies in {len(inside)} bodies{where}; "
                f"move it into the one that it names{ask}",
                design.places.of("bodies", given.name),
            )
        if names[inside[0]] is not None:
            raise DesignError(
                f"{names[inside[0]]!r} and {given.name!r} name the same body, at {at}; keep one name, or part the "
                f"body: {_uncut(design, groups[inside[0]])}",
                design.places.of("bodies", given.name),
            )
        names[inside[0]] = given.name
    return names


def _uncut(design: Design, group: Group) -> str:
    """What would part a body in which two names stand: lines that end inside it, to be lengthened, or a missing one."""
    tips = []
    for hinge in named_hinges(design):
        a, b = np.array(hinge.line.coords)
        beyond = (b - a) * (2.0 * SLIT * hinge.properties.width / hinge.line.length)
        for end in (a - beyond, b + beyond):
            if any(shapely.contains_xy(p, *end) for i in hinge.layers for p in group.polygons[i]):
                tips.append(f"hinge {hinge.name!r} ends inside it at {millimetres((end[0], end[1]))}")
    return (
        f"{' and '.join(tips[:4])}; lengthen it"
        if tips
        else "draw the hinge line that is missing between them"
    )


def _holders(named: Sequence[BodyName], groups: Sequence[Group]) -> list[list[int]]:
    """For each point that names a body, the groups with a piece that holds it, in the layer asked for if there is
    one."""
    pieces = [
        (p, i, k) for i, group in enumerate(groups) for k, layer in enumerate(group.polygons) for p in layer
    ]
    tree = shapely.STRtree([polygon for polygon, _, _ in pieces])
    points = np.array([given.point for given in named], dtype=object)
    which, held_by = tree.query(points, predicate="within")
    inside: list[set[int]] = [set() for _ in named]
    for name, piece in zip(which.tolist(), held_by.tolist(), strict=True):
        _, group, layer = pieces[piece]
        if named[name].layer in (None, layer):
            inside[name].add(group)
    return [sorted(each) for each in inside]


def _joint(connection: Connection) -> Joint:
    hinge, drawn = connection.hinge, connection.hinge.properties
    (x0, y0), (x1, y1) = hinge.line.coords
    return Joint(
        hinge.name,
        connection.parent,
        connection.child,
        point=np.array([(x0 + x1) / 2, (y0 + y1) / 2, hinge.z]),
        axis=np.array([x1 - x0, y1 - y0, 0.0]),
        stiffness=drawn.stiffness,
        damping=drawn.damping,
        rest_angle=drawn.rest_angle,
        limits=drawn.limits,
    )
