"""A piezoelectric bender between two bodies: clamped to one, it pushes a point of the other."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated, ClassVar

import numpy as np
from pydantic import Field

from lamc.basics.errors import DesignError, about
from lamc.basics.fields import Name, Vector
from lamc.basics.quantity_fields import Unit
from lamc.effects.bender_plies import LaminateField
from lamc.effects.drives import Drive, checked_drive
from lamc.effects.registered import RegisteredEffect
from lamc.mechanics.loads import Hinge, Loads
from lamc.records.mechanism import Joint
from lamc.symbolic.algebra import cross, dot
from lamc.symbolic.expression import stage
from lamc.symbolic.scalars import Scalar

_SQUARE = 1e-6  # rad, by which the normal may miss the right angle to the strip
_VOLTAGE = "the voltage of a piezo bender"
_ROUND_OFF = 1e-9  # of the free strains, below which a bending strain is none


@dataclass(frozen=True)
class BenderLine:
    """Force at the tip, N, along the normal: force_per_volt · V - stiffness · deflection."""

    stiffness: float  # N/m
    force_per_volt: float  # N/V, held at deflection 0
    deflection_per_volt: float  # m/V, of the free tip


@dataclass(frozen=True)
class PiezoBender(RegisteredEffect):
    """A straight strip of laminate, clamped on body_a at `root`, whose tip pushes body_b at `tip` along the normal.

    The strip is a slender beam, free to bend across: with the laminate's stiffness about its neutral surface
    D* = D - B A⁻¹ B, free curvature κ = D*⁻¹ (M_p - B A⁻¹ N_p) and EI = width / (D*⁻¹)_xx. Its tip bends by
    -κ_x L (L/2 + extension) along the normal, and gives way to a force by (L³/3 + L² e + L e²) / EI. Deflection is
    counted along the normal, which moves with body_a, so slides along the strip cost nothing; it is taken to be small
    beside the length. The strip has no mass: give it to the bodies.

    Across a hinge line at a distance b from the tip its bending moment κ_x EI turns the hinge, against a stiffness of
    EI (12 b² - 12 L b + 4 L²) / L³, a beam's with both ends clamped; in the middle that is EI / L.

    Stored is ½ k (deflection - free deflection)²; what the drive supplies is the force times the rate of the free
    deflection. Sources: J. G. Smits, W. Choi, IEEE Trans. UFFC 38 (1991) 256-270 (bimorphs); R. J. Wood, E. Steltz,
    R. S. Fearing, Sensors and Actuators A 119 (2005) 476-488 (laminates). Several may act in one scene.

    Raises DesignError for a normal along the strip, ends that meet, and polarities that move nothing.
    """

    body_a: Annotated[Name, Field(description="the body of the first end")]
    root: Annotated[Vector, Unit("m", "end of the strip in the drawn configuration, world axes")]
    body_b: Annotated[Name, Field(description="the body of the other end")]
    tip: Annotated[Vector, Unit("m", "other end of the strip, which is straight there")]
    normal: Annotated[
        Vector,
        Unit(
            "1",
            "from the lowest ply to the highest, and of positive deflection; at right angles to the strip",
        ),
    ]
    width: Annotated[float, Unit("m", "the same from root to tip", gt=0.0)]
    laminate: Annotated[
        LaminateField,
        Field(description="with piezoelectric plies, bottom to top; fibres at 0° run along the strip"),
    ]
    polarity: Annotated[
        tuple[float, ...],
        Unit(
            "1",
            "per ply: field along the normal times the ply's thickness, over the voltage. (1, -1) is a bimorph of two "
            "plies, poled alike, with an electrode between them; 0 stands for plies without electrodes",
        ),
    ]
    voltage: Annotated[
        float | str,
        Unit(
            "V",
            "a number is a parameter of the simulator, text an expression in t (s) and inputs of the scene",
        ),
    ]
    extension: Annotated[
        float, Unit("m", "the stiff end of the strip next to the tip, without laminate", ge=0.0)
    ] = 0.0
    hinge: Annotated[
        Name | None,
        Field(
            description="the joint between the two bodies, for a strip that is laid across it and clamped on both: it "
            "bends the hinge, by a torque; none for a strip whose tip pushes body_b and slides on it"
        ),
    ] = None

    name: ClassVar[str] = "piezo_bender"
    summary: ClassVar[str] = "Piezoelectric benders"
    example: ClassVar[str] = (
        "piezo_bender: {body_a: frame, root: [0, 0, 0], body_b: arm, tip: [12 mm, 0, 0], normal: [0, 0, "
        "1], width: 4 mm, laminate: [{material: PZT-5H, thickness: 127 um}, {material: PZT-5H, "
        "thickness: 127 um}], polarity: [1, -1], voltage: 100*sin(2*pi*10*t)}"
    )
    source: ClassVar[str] = "F = f V - k d, Smits & Choi 1991; Wood, Steltz & Fearing 2005"
    repeatable: ClassVar[bool] = True
    absent: ClassVar[str] = "no bender is called for"

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.body_a == self.body_b:
            raise DesignError(
                f"a piezo bender has both ends on body {self.body_a!r}; it must join two bodies"
            )
        for drive in self.drives():
            checked_drive(drive)
        plies = len(self.laminate.plies)
        if len(self.polarity) != plies:
            with about(("polarity",)):
                raise DesignError(
                    f"polarity of a piezo bender is {list(self.polarity)}; it must hold {plies} numbers, one per ply"
                )
        self._check_shape()

    def _check_shape(self) -> None:
        along, normal = np.subtract(self.tip, self.root), np.array(self.normal)
        length, size = math.hypot(*along), math.hypot(*self.normal)
        if not length > self.extension:
            raise DesignError(
                f"a piezo bender is {length:g} m from root to tip, and its stiff end {self.extension:g} m; there must "
                "be a bending length between them"
            )
        if not 0.0 < size < math.inf or abs(float(along @ (normal / size))) > _SQUARE * length:
            raise DesignError(
                f"the normal {self.normal} of a piezo bender is not at right angles to the strip, which runs along "
                f"{tuple((along / length).round(6).tolist())}; give the direction in which its tip deflects"
            )
        if self.hinge is not None and self.extension:
            raise DesignError(
                f"a piezo bender across hinge {self.hinge!r} has an extension, and it is clamped where "
                "the laminate ends: set the extension to 0"
            )
        try:
            line = self.line
        except (ArithmeticError, np.linalg.LinAlgError):
            line = BenderLine(math.inf, math.inf, math.inf)
        if not (math.isfinite(line.force_per_volt) and 0.0 < line.stiffness < math.inf):
            raise DesignError("a piezo bender's stiffness is out of range; lengths are in m and moduli in Pa")
        plies = zip(self.polarity, self.laminate.plies, strict=True)
        strain = max(abs(p / y.thickness) * max(abs(y.material.d31), abs(y.material.d32)) for p, y in plies)
        bent = abs(line.deflection_per_volt) * self.laminate.thickness / (0.5 * length * length)
        if bent <= _ROUND_OFF * strain:
            raise DesignError(
                "a piezo bender does not bend under voltage: give its laminate plies with d31 and d32, and polarity "
                "such as (1, -1), by which they do not cancel"
            )

    @property
    def _section(self) -> tuple[float, float]:
        """Free curvature along the strip, 1/(m·V), and bending stiffness, N·m²."""
        laminate = self.laminate
        per_volt = [p / ply.thickness for p, ply in zip(self.polarity, laminate.plies, strict=True)]
        pushed = laminate.expansion(fields=per_volt)
        neutral = np.linalg.solve(laminate.A, laminate.B).T  # B A⁻¹
        flexibility = np.linalg.inv(laminate.D - neutral @ laminate.B)
        curvature = float((flexibility @ (pushed.moment - neutral @ pushed.force))[0])  # 1/(m·V)
        return curvature, self.width / float(flexibility[0, 0])

    @property
    def line(self) -> BenderLine:
        """Stiffness, blocked force and free deflection of the tip, from the laminate and the shape."""
        curvature, rigidity = self._section
        stiff = self.extension
        length = math.dist(self.tip, self.root) - stiff
        deflection = -curvature * length * (0.5 * length + stiff)
        stiffness = rigidity / (length * (length * length / 3.0 + length * stiff + stiff * stiff))
        return BenderLine(stiffness, stiffness * deflection, deflection)

    def across(self, joint: Joint) -> tuple[float, float]:
        """Stiffness, N·m/rad, and torque on the joint's child per volt, N·m/V, of a strip laid across the hinge.

        Raises DesignError where the hinge line does not cross the strip, or joins other bodies.
        """
        what = f"a piezo bender across hinge {joint.name!r}"
        if {joint.parent, joint.child} != {self.body_a, self.body_b}:
            raise DesignError(
                f"{what} is clamped on {self.body_a!r} and {self.body_b!r}, and the hinge joins {joint.parent!r} and "
                f"{joint.child!r}; name these"
            )
        length = math.dist(self.tip, self.root)
        along = np.subtract(self.tip, self.root) / length
        sense = float(np.cross(np.divide(self.normal, math.hypot(*self.normal)), along) @ joint.axis)
        rest = float(np.subtract(self.tip, joint.point) @ along)
        if abs(abs(sense) - 1.0) > _SQUARE or not -_SQUARE * length <= rest <= (1.0 + _SQUARE) * length:
            raise DesignError(
                f"{what} is not crossed by the hinge line at right angles between root and tip; turn or move the strip"
            )
        curvature, rigidity = self._section
        stiffness = rigidity * (12.0 * rest * rest - 12.0 * length * rest + 4.0 * length * length) / length**3
        side = math.copysign(1.0, sense) if joint.parent == self.body_a else -math.copysign(1.0, sense)
        return stiffness, side * curvature * rigidity

    def contribute(self, loads: Loads) -> None:
        loads.check_apart("the piezo bender", self.body_a, self.body_b)
        label = self._label(loads.parameter_names)
        voltage: Scalar
        if isinstance(self.voltage, str):
            voltage = stage(self.voltage, {"t": loads.time, **loads.inputs})
        else:
            voltage = loads.parameter(f"{label}.voltage", self.voltage, "V", "voltage of the bender")
        if self.hinge is None:
            self._push(loads, label, voltage)
        else:
            self._fold(loads, loads.hinge(self.hinge), label, voltage)

    def _fold(self, loads: Loads, hinge: Hinge, label: str, voltage: Scalar) -> None:
        stiffness, per_volt = self.across(hinge.joint)
        k = loads.parameter(
            f"{label}.stiffness", stiffness, "N·m/rad", "stiffness that the bender gives its hinge"
        )
        gain = loads.parameter(f"{label}.torque_per_volt", per_volt, "N·m/V", "torque of the bender per volt")
        beyond = hinge.angle - gain / k * voltage
        loads.stored_energy(0.5 * (k * (beyond * beyond)))
        loads.hinge_torque(hinge.joint.name, -(k * beyond))

    def _push(self, loads: Loads, label: str, voltage: Scalar) -> None:
        line = self.line
        size = math.hypot(*self.normal)
        drawn = [x / size for x in self.normal]
        rows = loads.rotation(self.body_a)
        normal = (dot(rows[0], drawn), dot(rows[1], drawn), dot(rows[2], drawn))
        ends = [loads.position(body, self.tip) for body in (self.body_a, self.body_b)]
        apart = (ends[1][0] - ends[0][0], ends[1][1] - ends[0][1], ends[1][2] - ends[0][2])
        k = loads.parameter(f"{label}.stiffness", line.stiffness, "N/m", "stiffness of the bender's tip")
        gain = loads.parameter(
            f"{label}.force_per_volt", line.force_per_volt, "N/V", "blocked force of the bender per volt"
        )
        beyond = dot(normal, apart) - gain / k * voltage  # deflection less the free one
        loads.stored_energy(0.5 * (k * (beyond * beyond)))
        push = -(k * beyond)
        force = (push * normal[0], push * normal[1], push * normal[2])
        back = (-force[0], -force[1], -force[2])
        loads.force(self.body_b, self.tip, force)
        loads.force(self.body_a, self.tip, back)
        # Both forces act where the tip of body_b is; the normal rides on the frame of body_a.
        loads.moment(self.body_a, cross(apart, back), on_frame=True)

    @property
    def conservative(self) -> bool:
        """Under a voltage that does not change it is."""
        return not isinstance(self.voltage, str)

    def drives(self) -> tuple[Drive, ...]:
        """The voltage where it is an expression."""
        return (Drive(_VOLTAGE, self.voltage, field=("voltage",)),) if isinstance(self.voltage, str) else ()

    def _label(self, taken: Sequence[str]) -> str:
        """What the bender's parameters begin with; a second one between the same bodies is number 2."""
        label = f"piezo_bender.{self.body_a}.{self.body_b}"
        count = sum(name.startswith(f"{label}.") and name.endswith(".stiffness") for name in taken)
        return f"{label}.{count + 1}" if count else label
