"""Bodies that bend: a few shapes of each body's own plate, by finite elements."""

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import TYPE_CHECKING, Annotated, ClassVar

import numpy as np
from pydantic import Field

from lamc.basics.checks import Array
from lamc.basics.errors import DesignError, LamcError
from lamc.basics.fields import Flag, Name, Names, Whole
from lamc.basics.quantity_fields import Unit
from lamc.effects.bender_plies import LaminateField
from lamc.effects.flexible_plates import BodyPlate, body_plate
from lamc.effects.registered import RegisteredEffect
from lamc.mechanics.arranging import Arranging
from lamc.mechanics.flexible import FlexibleBody
from lamc.mechanics.loads import Loads
from lamc.mechanism.tree import Tree

if TYPE_CHECKING:
    from lamc.plates.answers.reduction import Reduction

_MOST = 50  # modes of one body
_CELLS = 5  # across a plate as wide as its area over half its border, if no size is given
_KEPT = 64  # reductions that are remembered
_FORMS = (1, 3, 6)  # modes of other forms
_STRAIGHT = 0.05  # relative: modes that are higher by more, as an edge stays straight, are reported
_UP = np.array([0.0, 0.0, 1.0])


@dataclass(frozen=True)
class FlexibleLinks(RegisteredEffect):
    """Bodies bend in the lowest modes of their own plates, clamped along the hinge on the way to the fixed bodies.

    A body's frame rides on its hinge (floating frame), and its deflection n Σ φ_k η_k along the plate's normal is small
    beside it; η_k is in m, φ_k at most 1. The plate is the body without what bends at its hinges, whose mass stays with
    the frame. A neighbour is joined along an edge that stays straight; its own stiffness does not keep the edge so. The
    edge at the hinge on the way in stays straight too: twisting modes of wide bodies on soft hinges are too high, which
    `Simulator.notes` tells with the measure.

    Left out is what is of second order in η: a link that turns is not stiffened by centrifugal forces, nor softened by
    pressure along its plane (geometric stiffness). Turning at ω, that is right while ω is small beside the first mode.

    Modes make the equations stiff: implicit integrators pay ("auto" finds out). Sources: A. A. Shabana, Dynamics of
    Multibody Systems, 4th ed. 2013, chapters 5 and 6; those of `lamc.plates.answers.reduction`.

    Raises DesignError for bodies that are not there, are fixed, or of which no laminate is known.
    """

    bodies: Annotated[
        Names | None, Field(description="names of those that bend; left out: all that move")
    ] = None
    modes: Annotated[Whole, Field(ge=1, le=_MOST, description="natural modes of each")] = 3
    damping_ratio: Annotated[float, Unit("1", "of critical, of every mode", ge=0.0)] = 0.01
    size: Annotated[
        float | None,
        Unit("m", "of the finite elements; left out: a fifth of the plate's width, or thereabouts", gt=0.0),
    ] = None
    refinement: Annotated[
        float,
        Unit("1", "cells are smaller by that: 2 halves them, whether their size is given or not", gt=0.0),
    ] = 1.0
    element: Annotated[Name, Field(description="of lamc.plate.ELEMENTS")] = "dkt"
    static: Annotated[
        Flag,
        Field(
            description="besides, the shapes under a uniform acceleration and under force and moments at the other "
            "hinges, so that statics is that of the elements: one, and three for each other hinge; they count on as "
            "modes"
        ),
    ] = True
    laminate: Annotated[
        LaminateField | None,
        Field(description="of bodies that come from no drawing, all over their outline; left out: as drawn"),
    ] = None

    name: ClassVar[str] = "flexible_links"
    summary: ClassVar[str] = "Bodies that bend"
    example: ClassVar[str] = "flexible_links: {bodies: [arm], modes: 2}"
    source: ClassVar[str] = "½ ηᵀ K η, modes of the plate in a floating frame, Shabana 2013, ch. 5"
    absent: ClassVar[str] = "bodies are rigid"

    @property
    def conservative(self) -> bool:
        """Nothing is lost by modes that are not damped."""
        return not self.damping_ratio

    def claims(self) -> tuple[str, ...]:
        return ("bending of bodies",)

    def arrange(self, arranging: Arranging) -> None:
        """Lets the bodies bend, in the tree's order. Their plates are reduced once in a process."""
        tree = arranging.tree
        for name, plate, reduced in self.reductions(tree):
            arranging.flexible_body(
                flexible_body(name, reduced, tree.mechanism.body(name).com, plate.height, self.damping_ratio)
            )

    def reductions(self, tree: Tree) -> "Iterator[tuple[str, BodyPlate, Reduction]]":
        """Names of the bodies that bend, their plates, and the shapes of these."""
        for name in self.bodies or [link.body.name for link in tree.links]:
            plate = body_plate(tree, name, self.laminate)
            try:
                reduced = _reduced(_Asked(plate, self))
            except LamcError as error:
                raise DesignError(
                    f"flexible_links: the plate of body {name!r} cannot be reduced to modes, so leave the body out: "
                    f"{error.message}"
                ) from error
            yield name, plate, reduced

    def notes(self, tree: Tree) -> tuple[str, ...]:
        """A sentence for each body whose modes are too high as its edge stays straight at its hinge: by more than 5 %,
        with the body alone on that hinge."""
        from lamc.plates.answers.straight_edges import straight_modes

        inboard = {link.body.name: link.joint for link in tree.links}
        reported = []
        for name, plate, reduced in self.reductions(tree):
            hinge = inboard[name]
            found = straight_modes(reduced, plate.clamped, hinge.stiffness)
            worst = max(range(len(found)), key=lambda k: found[k].excess)
            if found[worst].excess > _STRAIGHT:
                here, free = (omega / (2.0 * math.pi) for omega in (found[worst].omega, found[worst].free))
                reported.append(
                    f"flexible_links: the edge of body {name!r} stays straight at hinge {hinge.name!r}, and on a hinge "
                    f"so soft it would bend: alone on it, mode {worst + 1} of the body is at {here:.4g} Hz in place of "
                    f"{free:.4g} Hz, {100.0 * found[worst].excess:.2g} % too high; take motion that twists it for as "
                    "uncertain as that, or hinge it as narrow strips"
                )
        return tuple(reported)

    def bandwidth(self, tree: Tree) -> float:
        """The highest natural mode that a body has, clamped at its hinge: shapes of statics beside these have
        frequencies of no plate's."""
        return min(
            (float(reduced.omega[reduced.natural - 1]) for _, _, reduced in self.reductions(tree)),
            default=math.inf,
        )

    def contribute(self, loads: Loads) -> None:
        """Nothing: the stiffness of what `arrange` adds comes with it."""

    def alternatives(self) -> Mapping[str, "FlexibleLinks"]:
        """With fewer and with more modes, and on meshes with cells of twice and of half the size."""
        counts = {f"{count} mode{'s' if count > 1 else ''}": count for count in _FORMS if count != self.modes}
        return {
            **{text: replace(self, modes=count) for text, count in counts.items()},
            "coarser mesh": replace(self, refinement=0.5 * self.refinement),
            "finer mesh": replace(self, refinement=2.0 * self.refinement),
        }


def flexible_body(name: str, reduction: "Reduction", com: Array, height: float, ratio: float) -> FlexibleBody:
    """The record of a reduced plate at `height` m, world z; com: of the whole body, (3,), m."""
    first = reduction.first_moment + np.outer(reduction.moment, np.array([0.0, 0.0, height]) - com)

    def shape_at(point: Array) -> tuple[Array, Array]:
        values, slopes = reduction.shape_at(float(point[0]), float(point[1]))
        return values, np.column_stack([slopes, np.zeros(len(values))])

    return FlexibleBody(
        body=name,
        normal=_UP,
        moment=reduction.moment,
        first_moment=first,
        mass=reduction.mass,
        stiffness=reduction.stiffness,
        damping_ratios=np.full(len(reduction.moment), ratio),
        shape_at=shape_at,
    )


class _Asked:
    """A reduction that is asked for; two of the same content are one."""

    def __init__(self, plate: BodyPlate, by: FlexibleLinks) -> None:
        self.plate, self.modes, self.element, self.static = plate, by.modes, by.element, by.static
        self.size = (by.size or _usual_size(plate)) / by.refinement
        regions = tuple((n, plate.regions[n].wkb, plate.laminates[n]) for n in plate.regions)
        joined = tuple((a.point, a.edge.wkb if a.edge is not None else b"") for a in plate.attachments)
        self._content = (regions, plate.clamped.wkb, joined, self.modes, self.size, self.element, self.static)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, _Asked) and self._content == other._content

    def __hash__(self) -> int:
        return hash(self._content)


@lru_cache(maxsize=_KEPT)
def _reduced(asked: _Asked) -> "Reduction":
    from lamc.plates.answers.reduction import reduce_plate
    from lamc.plates.meshing.mesher import mesh
    from lamc.plates.problem import Problem
    from lamc.plates.supports import Clamped

    plate = asked.plate
    named = {name: region for name, region in plate.regions.items() if name}
    made = mesh(plate.outline, asked.size, regions=named or None, follow=[plate.clamped])
    problem = Problem(made, dict(plate.laminates), element=asked.element, supports=[Clamped(plate.clamped)])
    return reduce_plate(problem, asked.modes, plate.attachments, static=asked.static)


def _usual_size(plate: BodyPlate) -> float:
    outline = plate.outline
    width = 2.0 * float(outline.area) / float(outline.length)
    return float(f"{width / _CELLS:.2g}") if math.isfinite(width) and width > 0.0 else 1e-3
