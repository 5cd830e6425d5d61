"""Bodies that bend: a few shapes of each body's own plate, by finite elements."""

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from lamc.basics.checks import Array, checked_flag, checked_name, checked_number, shown
from lamc.basics.errors import DesignError
from lamc.effects.bender_plies import laminate_of
from lamc.effects.data import record
from lamc.effects.flexible_plates import BodyPlate, body_plate
from lamc.effects.registered import RegisteredEffect
from lamc.mechanics.arrangement import Arranging
from lamc.mechanics.flexible import FlexibleBody
from lamc.mechanics.loads import Loads
from lamc.mechanism.tree import Tree

if TYPE_CHECKING:
    from lamc.plates.answers.reduction import Reduction
    from lamc.plates.laminates.laminate import Laminate
else:
    Laminate = Any  # whose import takes a while; `lamc schema` asks for type hints at run time

_MOST = 50  # modes of one body
_CELLS = 5  # across a plate as wide as its area over half its border, if no size is given
_KEPT = 64  # reductions that are remembered
_FORMS = (1, 3, 6)  # modes of other forms
_STRAIGHT = 0.05  # relative: modes that are higher by more, as an edge stays straight, are told
_UP = np.array([0.0, 0.0, 1.0])


@dataclass(frozen=True)
class FlexibleLinks(RegisteredEffect):
    """Bodies bend in the lowest modes of their own plates, clamped along the hinge on the way to the fixed bodies.

    bodies         names of those that bend; None: all that move
    modes          natural modes of each
    damping_ratio  of critical, of every mode
    size           m, of the finite elements; None: a fifth of the plate's width, or thereabouts
    element        of `lamc.plate.ELEMENTS`
    refinement     cells are smaller by that: 2 halves them, whether their size is given or not
    static         besides, the shapes under a uniform acceleration and under force and moments at the other hinges, so
                   that statics is that of the elements: one, and three for each other hinge; they count on as modes
    laminate       of bodies that come from no drawing, all over their outline; None: as drawn

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

    bodies: tuple[str, ...] | None = None
    modes: int = 3
    damping_ratio: float = 0.01
    size: float | None = None
    refinement: float = 1.0
    element: str = "dkt"
    static: bool = True
    laminate: "Laminate | None" = None

    name: ClassVar[str] = "flexible_links"
    summary: ClassVar[str] = "Bodies that bend"
    source: ClassVar[str] = "½ ηᵀ K η, modes of the plate in a floating frame, Shabana 2013, ch. 5"
    units: ClassVar[Mapping[str, str]] = {"damping_ratio": "1", "size": "m", "refinement": "1"}
    absent: ClassVar[str] = "bodies are rigid"

    def __post_init__(self) -> None:
        if self.bodies is not None:
            names = self.bodies
            if isinstance(names, str) or not isinstance(names, Sequence) or not names:
                raise DesignError(
                    f"bodies of flexible_links are {shown(names)}; give a list of names, or leave it out"
                )
            checked = tuple(checked_name(name, "a body of flexible_links") for name in names)
            for name in checked:
                if checked.count(name) > 1:
                    raise DesignError(f"bodies of flexible_links have {name!r} twice; once is enough")
            object.__setattr__(self, "bodies", checked)
        whole = isinstance(self.modes, int) and not isinstance(self.modes, bool)
        if not whole or not 1 <= self.modes <= _MOST:
            raise DesignError(
                f"modes of flexible_links is {shown(self.modes)}; give a whole number from 1 to {_MOST}, or leave the "
                "effect out for rigid bodies"
            )
        ratio = checked_number(self.damping_ratio, "the damping_ratio of flexible_links", minimum=0.0)
        object.__setattr__(self, "damping_ratio", ratio)
        if self.size is not None:
            size = checked_number(self.size, "the size of flexible_links", minimum=0.0)
            if size == 0.0:
                raise DesignError(
                    "the size of flexible_links is 0 m; give the length of an edge of its cells"
                )
            object.__setattr__(self, "size", size)
        refinement = checked_number(self.refinement, "the refinement of flexible_links", minimum=0.0)
        if refinement == 0.0:
            raise DesignError("the refinement of flexible_links is 0; give 2 for cells of half the size")
        object.__setattr__(self, "refinement", refinement)
        checked_name(self.element, "the element of flexible_links")
        checked_flag(self.static, "static of flexible_links")
        if self.laminate is not None:
            laminate = laminate_of(self.laminate, "the laminate of flexible_links")
            object.__setattr__(self, "laminate", laminate)

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
            yield name, plate, _reduced(_Asked(plate, self))

    def notes(self, tree: Tree) -> tuple[str, ...]:
        """A sentence for each body whose modes are too high as its edge stays straight at its hinge: by more than 5 %,
        with the body alone on that hinge."""
        from lamc.plates.answers.straight_edges import straight_modes

        inboard = {link.body.name: link.joint for link in tree.links}
        told = []
        for name, plate, reduced in self.reductions(tree):
            hinge = inboard[name]
            found = straight_modes(reduced, plate.clamped, hinge.stiffness)
            worst = max(range(len(found)), key=lambda k: found[k].excess)
            if found[worst].excess > _STRAIGHT:
                here, free = (omega / (2.0 * math.pi) for omega in (found[worst].omega, found[worst].free))
                told.append(
                    f"flexible_links: the edge of body {name!r} stays straight at hinge {hinge.name!r}, and on a hinge "
                    f"so soft it would bend: alone on it, mode {worst + 1} of the body is at {here:.4g} Hz in place of "
                    f"{free:.4g} Hz, {100.0 * found[worst].excess:.2g} % too high; take motion that twists it for as "
                    "uncertain as that, or hinge it as narrow strips"
                )
        return tuple(told)

    def contribute(self, loads: Loads) -> None:
        """Nothing: the stiffness of what `arrange` adds comes with it."""

    def alternatives(self) -> Mapping[str, "FlexibleLinks"]:
        """With fewer and with more modes, and on meshes with cells of twice and of half the size."""
        counts = {f"{count} mode{'s' if count > 1 else ''}": count for count in _FORMS if count != self.modes}
        return {
            **{words: replace(self, modes=count) for words, count in counts.items()},
            "coarser mesh": replace(self, refinement=0.5 * self.refinement),
            "finer mesh": replace(self, refinement=2.0 * self.refinement),
        }

    @classmethod
    def from_data(cls, value: object, where: str) -> "FlexibleLinks":
        """From a scene file: a map of the fields above; the laminate is a list of plies, as for piezo_bender."""
        if isinstance(value, Mapping) and value.get("laminate") is not None:
            value = {**value, "laminate": laminate_of(value["laminate"], "the laminate", where)}
        return record(cls, value, where)


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
        regions = tuple((n, plate.regions[n].wkb, repr(plate.laminates[n])) for n in plate.regions)
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
