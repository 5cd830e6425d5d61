"""The strips of hinges: where they are, and how stiff in all directions.

In: a mechanism, some of its joints, and what a scene gives for each. Out: a strip for each joint, from the drawing that
the mechanism was split from, from the scene, or from both. The plate half of lamc is imported when it is needed.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, fields
from typing import TYPE_CHECKING

import numpy as np

from lamc.basics.checks import Array
from lamc.basics.errors import DesignError
from lamc.records.mechanism import Joint, Mechanism

if TYPE_CHECKING:
    from lamc.plates.designs.hinges import FlexibleStrip
    from lamc.plates.laminates.laminate import Laminate
    from lamc.records.design import Design


@dataclass(frozen=True)
class Given:
    """What a scene says of one strip; None: what the drawing says."""

    width: float | None  # m, from link to link
    length: float | None  # m, along the hinge line
    thickness: float | None  # m
    E: float | None  # Pa
    nu: float | None

    @property
    def missing(self) -> list[str]:
        return [f.name for f in fields(self) if getattr(self, f.name) is None]


@dataclass(frozen=True, eq=False)
class Strip:
    """A joint's strip: its middle, m, world, drawn, and its stiffness (6, 6) there in its axes (x across, z along)."""

    joint: str
    point: Array
    stiffness: Array


def strips_of(
    mechanism: Mechanism, joints: Sequence[Joint], given: Callable[[str], Given]
) -> tuple[Strip, ...]:
    """One for each of `joints`, in their order. Raises DesignError where one is not known."""
    lacking = {joint.name: told for joint in joints if (told := given(joint.name)).missing}
    drawn = _drawn(mechanism, lacking)
    return tuple(_strip(joint, given(joint.name), drawn.get(joint.name)) for joint in joints)


def _drawn(mechanism: Mechanism, lacking: dict[str, Given]) -> "dict[str, FlexibleStrip]":
    """The strips of a drawing, of the joints that a scene does not say all about."""
    if not lacking:
        return {}
    design = mechanism.design
    if design is None:
        name, told = next(iter(lacking.items()))
        raise DesignError(
            f"the strip of hinge {name!r} is not known, as mechanism {mechanism.name!r} comes from no drawing: give "
            f"{', '.join(told.missing)} to twist_compliance, or run the design itself"
        )
    from lamc.plates.laminates.materials import Material

    placeholder = Material.isotropic(1.0, 0.0, 0.0)  # never used: E and nu of the scene take its place
    return _strips_drawn(design, lacking, placeholder)


def _strips_drawn(
    design: "Design", lacking: dict[str, Given], placeholder: object
) -> "dict[str, FlexibleStrip]":
    from lamc.design.cutting import holes_per_layer
    from lamc.design.split import named_hinges
    from lamc.plates.designs.hinges import flexible_strip
    from lamc.plates.designs.materials import plate_materials

    every = named_hinges(design)
    hinges = [hinge for hinge in every if hinge.name in lacking]
    undrawn = sorted(set(lacking) - {hinge.name for hinge in hinges})
    if undrawn:
        raise DesignError(
            f"hinge {undrawn[0]!r} is no strip of the drawing but a facet that bends (facet_creases): name the joints "
            f"of twist_compliance, or give it {', '.join(lacking[undrawn[0]].missing)}"
        )
    told = {hinge.name: lacking[hinge.name] for hinge in hinges}
    asked = sorted({h.properties.layer for h in hinges if told[h.name].E is None or told[h.name].nu is None})
    try:
        known = plate_materials(design, asked)
    except DesignError as error:
        raise DesignError(f"{error.message}; twist_compliance takes E and nu of the strips, too") from error
    every_known = {design.layers[h.properties.layer].material.name: placeholder for h in hinges} | known
    holes = holes_per_layer(every, len(design.layers))
    return {
        h.name: flexible_strip(design, h, holes[h.properties.layer], every_known)  # type: ignore[arg-type]
        for h in hinges
    }


def _strip(joint: Joint, given: Given, drawn: "FlexibleStrip | None") -> Strip:
    """Raises DesignError for sizes and moduli whose stiffness no float holds."""
    try:
        return _clamped(joint, given, drawn)
    except ArithmeticError as error:
        raise DesignError(
            f"the strip of hinge {joint.name!r} has a stiffness that no float holds ({error}): check its width, "
            "length, thickness and moduli, m and Pa"
        ) from error


def _clamped(joint: Joint, given: Given, drawn: "FlexibleStrip | None") -> Strip:
    from lamc.plates.answers.strip_stiffness import about, strip_stiffness

    laminate, width = _laminate(given, drawn), given.width if drawn is None else given.width or drawn.width
    assert width is not None
    if drawn is None or given.length is not None:
        assert given.length is not None
        return Strip(joint.name, joint.point, strip_stiffness(laminate, width, given.length).matrix)
    lengths = np.array([part.length for part in drawn.parts])
    middles = np.array([np.mean(np.array(part.coords), axis=0) for part in drawn.parts])
    # Along the axis, from the joint's point, which lies on the line.
    places = (middles - joint.point[:2]) @ joint.axis[:2]
    middle = float(lengths @ places / lengths.sum())
    stiffness = np.zeros((6, 6))
    for length, place in zip(lengths, places, strict=True):
        if length > 0.0:
            stiffness += about(strip_stiffness(laminate, width, length).matrix, float(place) - middle)
    return Strip(joint.name, joint.point + middle * joint.axis, stiffness)


def _laminate(given: Given, drawn: "FlexibleStrip | None") -> "Laminate":
    """Of the drawing, with what the scene gives in place of its own."""
    from lamc.plates.laminates.laminate import Laminate
    from lamc.plates.laminates.materials import Material
    from lamc.plates.laminates.plies import Ply

    if drawn is None:
        assert given.E is not None
        assert given.nu is not None
        assert given.thickness is not None
        return Laminate([Ply(Material.isotropic(given.E, given.nu, 0.0), given.thickness)])
    (ply,) = drawn.laminate.plies
    material, angle = ply.material, ply.angle
    if given.E is not None or given.nu is not None:
        E = material.E1 if given.E is None else given.E
        nu = material.nu12 if given.nu is None else given.nu
        material, angle = Material.isotropic(E, nu, material.density), 0.0
    return Laminate([Ply(material, given.thickness or ply.thickness, angle)])
