"""Hinges that also give way across their axis: the strip that bends, as a short plate between its links."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np

from lamc.basics.checks import Array, checked_array, checked_name, checked_number, did_you_mean, shown
from lamc.basics.errors import DesignError
from lamc.basics.readonly import ReadOnlyDict
from lamc.effects.hinge_strips import Given, strips_of
from lamc.effects.registered import RegisteredEffect
from lamc.mechanics.arrangement import CROSS_FREEDOMS, Arranging, CompliantHinge
from lamc.mechanics.loads import Loads
from lamc.records.mechanism import Joint

Amount = float | Mapping[str, float] | None
_SIZES = ("width", "length", "thickness", "E", "nu")
_ALONG = 1e-6  # sine of the angle between a hinge and the normal below which it is along it


@dataclass(frozen=True)
class TwistCompliance(RegisteredEffect):
    """Hinges twist, stretch and shear: potential ½ pᵀ K p in five more directions, p small, besides the hinge's angle.

    joints      names of those that yield; None: all
    width       m, of the strip from link to link; of a design: twice its hinge width
    length      m, along the hinge line; of a design: what is left of the line, piece by piece
    thickness   m, of what bends; of a design: of the flexible layer
    E, nu       Young's modulus, Pa, and Poisson's ratio of an isotropic strip; of a design: its material
    freedoms    which directions yield, of twist_x, twist_y, slide_x, slide_y and slide_z; the others stay rigid
    retardation s: damping is this time times the stiffness (Kelvin and Voigt)
    normal      of the plates at the hinges, drawn, world axes

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

    joints: tuple[str, ...] | None = None
    width: Amount = None
    length: Amount = None
    thickness: Amount = None
    E: Amount = None
    nu: Amount = None
    freedoms: tuple[str, ...] = CROSS_FREEDOMS
    retardation: float = 0.0
    normal: tuple[float, float, float] = (0.0, 0.0, 1.0)

    name: ClassVar[str] = "twist_compliance"
    summary: ClassVar[str] = "Hinges that yield across their axis"
    source: ClassVar[str] = "½ pᵀ K p of a clamped strip, Timoshenko & Gere 1961, 5.3"
    units: ClassVar[Mapping[str, str]] = {
        "width": "m",
        "length": "m",
        "thickness": "m",
        "E": "Pa",
        "nu": "1",
        "retardation": "s",
        "normal": "1",
    }
    absent: ClassVar[str] = "hinges turn about their axes only"

    def __post_init__(self) -> None:
        if self.joints is not None:
            object.__setattr__(self, "joints", _names(self.joints, "joints"))
        for field in _SIZES:
            object.__setattr__(self, field, _amount(getattr(self, field), field))
        freedoms = _names(self.freedoms, "freedoms")
        for freedom in freedoms:
            if freedom not in CROSS_FREEDOMS:
                raise DesignError(
                    f"twist_compliance has no freedom {freedom!r}; {did_you_mean(freedom, CROSS_FREEDOMS)}"
                )
        object.__setattr__(self, "freedoms", freedoms)
        time = checked_number(self.retardation, "the retardation of twist_compliance", minimum=0.0)
        object.__setattr__(self, "retardation", time)
        normal = checked_array(self.normal, (3,), "the normal of twist_compliance")
        if not 0.0 < math.hypot(*normal) < math.inf:
            raise DesignError(
                f"the normal of twist_compliance is {normal.tolist()}; it must have a direction and a length"
            )
        object.__setattr__(self, "normal", tuple(float(v) + 0.0 for v in normal))

    def __hash__(self) -> int:
        amounts = (getattr(self, field) for field in _SIZES)
        flat = (tuple(a.items()) if isinstance(a, Mapping) else a for a in amounts)
        return hash((self.joints, *flat, self.freedoms, self.retardation, self.normal))

    @property
    def conservative(self) -> bool:
        """Nothing is lost where nothing retards."""
        return not self.retardation

    def claims(self) -> tuple[str, ...]:
        return ("compliance across hinges",)

    def arrange(self, arranging: Arranging) -> None:
        """Makes the hinges yield, in the order of the mechanism's joints."""
        joints = {joint.name: joint for joint in arranging.tree.mechanism.joints}
        told = (n for field in _SIZES if isinstance(m := getattr(self, field), Mapping) for n in m)
        for name in (*(self.joints or ()), *told):
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
            words: replace(self, freedoms=kept)
            for words, kept in kinds.items()
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


def _names(values: object, field: str) -> tuple[str, ...]:
    what = f"{field} of twist_compliance"
    if isinstance(values, str) or not isinstance(values, Sequence) or not values:
        raise DesignError(f"{what} are {shown(values)}; give a list of names, or leave it out")
    names = tuple(checked_name(name, f"an entry of {what}") for name in values)
    for name in names:
        if names.count(name) > 1:
            raise DesignError(f"{what} have {name!r} twice; once is enough")
    return names


def _amount(value: Amount, field: str) -> Amount:
    what = f"{field} of twist_compliance"
    if value is None:
        return None
    if isinstance(value, Mapping):
        return ReadOnlyDict(
            {
                checked_name(joint, f"a joint in {what}"): _number(v, f"{what} for {joint!r}", field)
                for joint, v in sorted(value.items(), key=lambda item: str(item[0]))
            }
        )
    return _number(value, what, field)


def _number(value: object, what: str, field: str) -> float:
    number = checked_number(value, what)
    if field == "nu":
        if not -1.0 < number < 1.0:
            raise DesignError(f"{what} is {number:g}; it must be between -1 and 1")
    elif number <= 0.0:
        raise DesignError(f"{what} is {number:g}; it must be above 0")
    return number
