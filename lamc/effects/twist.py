"""Hinges that also give way across their axis: the strip that bends, as a short plate between its links."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Annotated, ClassVar

import numpy as np
from pydantic import Field

from lamc.basics.checks import Array, did_you_mean
from lamc.basics.errors import DesignError, about
from lamc.basics.fields import Names, Vector
from lamc.basics.quantity_fields import Unit
from lamc.effects.hinge_strips import Given, strips_of
from lamc.effects.registered import RegisteredEffect
from lamc.mechanics.arrangement import CROSS_FREEDOMS, CompliantHinge
from lamc.mechanics.arranging import Arranging
from lamc.mechanics.loads import Loads
from lamc.records.mechanism import Joint

Amount = float | Mapping[str, float] | None
_SIZES = ("width", "length", "thickness", "E", "nu")
_ALONG = 1e-6  # sine of the angle between a hinge and the normal below which it is along it


@dataclass(frozen=True)
class TwistCompliance(RegisteredEffect):
    """Hinges twist, stretch and shear: potential ½ pᵀ K p in five more directions, p small, besides the hinge's angle.

    x runs across the hinge, y along the normal, z along the hinge line; the axes ride on the parent. A hinge that was
    split from a design knows its strip; what is given here takes the place of what the design says, for all hinges
    alike or by joint name. A hinge of a mechanism by hand needs all five. K is that of a plate clamped to rigid links,
    about the strip's middle; strips in several pieces add up. The stiffness of the angle stays with HingeStiffness.

    A hinge that closes a loop is held by its strip alone then, so that loops close that would not fit rigidly; it needs
    all five freedoms. Strips are stiff: motions across take 1e-4 to 1e-6 s, which implicit integrators step over
    ("auto" finds out whether it pays: what rings undamped has to be followed). Sources: those of
    `lamc.plates.answers.strip_stiffness`.

    Raises DesignError for joints that are not there, hinges whose strip is not known, and hinges along the normal.
    """

    joints: Annotated[Names | None, Field(description="names of those that yield; left out: all")] = None
    width: Annotated[Amount, Unit("m", "of the strip from link to link; of a design: its gap", gt=0.0)] = None
    length: Annotated[
        Amount,
        Unit("m", "along the hinge line; of a design: what is left of the line, piece by piece", gt=0.0),
    ] = None
    thickness: Annotated[Amount, Unit("m", "of what bends; of a design: of the flexible layer", gt=0.0)] = (
        None
    )
    E: Annotated[
        Amount, Unit("Pa", "Young's modulus of an isotropic strip; of a design: its material", gt=0.0)
    ] = None
    nu: Annotated[Amount, Unit("1", "its Poisson's ratio; of a design: its material", gt=-1.0, lt=1.0)] = None
    freedoms: Annotated[
        Names,
        Field(
            description="directions that yield, of twist_x, twist_y, slide_x, slide_y, slide_z; others stay rigid"
        ),
    ] = CROSS_FREEDOMS
    retardation: Annotated[
        float, Unit("s", "damping is this time times the stiffness (Kelvin and Voigt)", ge=0.0)
    ] = 0.0
    normal: Annotated[Vector, Unit("1", "of the plates at the hinges, drawn, world axes")] = (0.0, 0.0, 1.0)

    name: ClassVar[str] = "twist_compliance"
    summary: ClassVar[str] = "Hinges that yield across their axis"
    example: ClassVar[str] = "twist_compliance: {joints: [knee], retardation: 1e-5}"
    source: ClassVar[str] = "½ pᵀ K p of a clamped strip, Timoshenko & Gere 1961, 5.3"
    absent: ClassVar[str] = "hinges turn about their axes only"

    def __post_init__(self) -> None:
        super().__post_init__()
        for freedom in self.freedoms:
            if freedom not in CROSS_FREEDOMS:
                with about(("freedoms",)):
                    raise DesignError(
                        f"twist_compliance has no freedom {freedom!r}; {did_you_mean(freedom, CROSS_FREEDOMS)}"
                    )
        if not 0.0 < math.hypot(*self.normal) < math.inf:
            with about(("normal",)):
                raise DesignError(
                    f"the normal of twist_compliance is {list(self.normal)}; it must have a direction and a length"
                )

    @property
    def conservative(self) -> bool:
        """Nothing is lost where nothing retards."""
        return not self.retardation

    def claims(self) -> tuple[str, ...]:
        return ("compliance across hinges",)

    def arrange(self, arranging: Arranging) -> None:
        """Makes the hinges yield, in the order of the mechanism's joints."""
        joints = {joint.name: joint for joint in arranging.tree.mechanism.joints}
        reported = (n for field in _SIZES if isinstance(m := getattr(self, field), Mapping) for n in m)
        for name in (*(self.joints or ()), *reported):
            if name not in joints:
                raise DesignError(
                    f"twist_compliance: no joint is named {name!r}; {did_you_mean(name, sorted(joints))}"
                )
        chosen = [j for j in joints.values() if self.joints is None or j.name in self.joints]
        for strip in strips_of(arranging.tree.mechanism, chosen, self._given):
            joint = joints[strip.joint]
            stiffness = strip.stiffness.copy()
            stiffness[2, :] = stiffness[:, 2] = 0.0
            arranging.compliant_hinge(
                CompliantHinge(
                    joint.name,
                    point=strip.point,
                    axes=self._axes(joint),
                    stiffness=stiffness,
                    damping=self.retardation * stiffness,
                    freedoms=self.freedoms,
                )
            )

    def contribute(self, loads: Loads) -> None:
        """Nothing: the stiffness of what `arrange` adds comes with it."""

    def alternatives(self) -> Mapping[str, "TwistCompliance"]:
        """Only turning or only sliding, where both yield."""
        kinds = {
            f"only {kind}": tuple(f for f in self.freedoms if f.startswith(kind))
            for kind in ("twist", "slide")
        }
        return {
            text: replace(self, freedoms=kept)
            for text, kept in kinds.items()
            if 0 < len(kept) < len(self.freedoms)
        }

    def _given(self, joint: str) -> Given:
        values = {}
        for field in _SIZES:
            amount = getattr(self, field)
            values[field] = amount.get(joint) if isinstance(amount, Mapping) else amount
        return Given(**values)

    def _axes(self, joint: Joint) -> Array:
        """Columns x, y, z: y the normal, as near as a right angle to the hinge allows."""
        z, normal = joint.axis, np.array(self.normal) / math.hypot(*self.normal)
        x = np.cross(normal, z)
        if float(np.linalg.norm(x)) < _ALONG:
            raise DesignError(
                f"joint {joint.name!r} runs along the normal {self.normal} of twist_compliance; give the normal of the "
                "plates that it joins"
            )
        x = x / np.linalg.norm(x)
        return np.column_stack([x, np.cross(z, x), z])
