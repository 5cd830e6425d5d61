"""A DC motor on a hinge: a torque that falls in a straight line with speed, driven by a voltage."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product
from typing import TYPE_CHECKING, Annotated, ClassVar

import numpy as np
from pydantic import Field

from lamc.basics.checks import Array
from lamc.basics.errors import DesignError, about
from lamc.basics.fields import Name
from lamc.basics.moved import superseded
from lamc.basics.quantity_fields import Unit
from lamc.effects.drives import Drive, checked_drive
from lamc.effects.registered import RegisteredEffect
from lamc.mechanics.arranging import Arranging
from lamc.mechanics.loads import Hinge, Loads
from lamc.records.mechanism import Joint
from lamc.symbolic.expression import stage
from lamc.symbolic.scalars import Scalar, Value

if TYPE_CHECKING:
    from lamc.run.result import Result

_LINE = ("stall_torque", "no_load_speed", "nominal_voltage")
_WINDING = ("torque_constant", "resistance")

_UNITS = {
    "stall_torque": "N·m",
    "no_load_speed": "rad/s",
    "nominal_voltage": "V",
    "torque_constant": "N·m/A",
    "resistance": "Ω",
}
_MEANINGS = {
    "stall_torque": "torque of the motor at rest at the nominal voltage",
    "no_load_speed": "speed of the motor without a load at the nominal voltage",
    "nominal_voltage": "voltage that the motor's line is given for",
    "torque_constant": "torque of the motor per current, and voltage per rad/s",
    "resistance": "resistance of the motor's winding",
}


@dataclass(frozen=True, eq=False)
class MotorBalance:
    """Where the power of a motor went, row by row, shape (m,): electrical = mechanical + heat."""

    voltage: Array  # V
    current: Array  # A
    torque: Array  # N·m, on the child about the joint's axis
    electrical: Array  # W, taken from the supply; negative where it is given back
    mechanical: Array  # W, given to the mechanism
    heat: Array  # W, in the winding; never negative


@dataclass(frozen=True)
class LinearMotor(RegisteredEffect):
    """Torque on a joint's child about its axis: T = n (T_stall V / V₀ - T_stall ω / ω₀), ω = n · the joint's rate.

    The voltage as a number is a parameter of the simulator; as a string it is an expression in t (s), angle (rad) and
    rate (rad/s) of the joint, and inputs of the scene. The motor is given by the line of its data sheet, stall_torque,
    no_load_speed and nominal_voltage; or by its winding, torque_constant and resistance, which is the same line with
    T_stall / V₀ = k / R and V₀ / ω₀ = k.

    The inductance of the winding is left out: currents follow in microseconds where joints take milliseconds.
    Several motors may act in one scene.
    """

    joint: Annotated[Name, Field(description="the hinge that it drives")]
    voltage: Annotated[float | str, Unit("V", "positive voltage opens the fold")]
    stall_torque: Annotated[
        float | None, Unit("N*m", "T_stall, of the motor at rest at the nominal voltage", gt=0.0)
    ] = None
    no_load_speed: Annotated[
        float | None, Unit("rad/s", "ω₀, where the torque is zero at the nominal voltage", gt=0.0)
    ] = None
    nominal_voltage: Annotated[float | None, Unit("V", "V₀", gt=0.0)] = None
    torque_constant: Annotated[
        float | None, Unit("N*m/A", "k, which is also the voltage per rad/s that turning induces", gt=0.0)
    ] = None
    resistance: Annotated[float | None, Unit("ohm", "R", gt=0.0)] = None
    gear_ratio: Annotated[
        float, Unit("1", "n, turns of the motor per turn of the joint; the gear has no losses")
    ] = 1.0
    rotor_inertia: Annotated[
        float,
        Unit(
            "kg*m^2",
            "J, of the rotor about its own axis, which the joint feels as n² J; for joints of a body that is fixed and "
            "stays so, since on a moving one the rotor is a gyroscope",
            ge=0.0,
        ),
    ] = 0.0

    name: ClassVar[str] = "linear_motor"
    summary: ClassVar[str] = "DC motors on hinges"
    example: ClassVar[str] = (
        "linear_motor: {joint: crank, voltage: 3*sin(2*pi*t), nominal_voltage: 3, stall_torque: 1 N*mm, "
        "no_load_speed: 60}"
    )
    source: ClassVar[str] = "T = k (V - k w) / R, Hughes & Drury, Electric Motors and Drives, ch. 3"
    repeatable: ClassVar[bool] = True
    conservative: ClassVar[bool] = False
    absent: ClassVar[str] = "no motor is called for"

    def __post_init__(self) -> None:
        super().__post_init__()
        for drive in self.drives():
            checked_drive(drive)
        given = [name for name in (*_LINE, *_WINDING) if getattr(self, name) is not None]
        if tuple(given) not in (_LINE, _WINDING):
            raise DesignError(
                f"the data of the motor on joint {self.joint!r} are {', '.join(given) or 'missing'}; give "
                f"{', '.join(_LINE[:2])} and {_LINE[2]}, or {_WINDING[0]} and {_WINDING[1]}"
            )
        if self.gear_ratio == 0.0:
            with about(("gear_ratio",)):
                raise DesignError(
                    f"the gear_ratio of the motor on joint {self.joint!r} is 0; it must not be: leave the motor out"
                )

    def arrange(self, arranging: Arranging) -> None:
        """A rotor's inertia asks for the general form of the equations."""
        if self.rotor_inertia:
            arranging.inverse_dynamics()

    def contribute(self, loads: Loads) -> None:
        hinge = loads.hinge(self.joint)
        label = _label(self.joint, loads.parameter_names)
        ratio = loads.parameter(
            f"{label}.gear_ratio", self.gear_ratio, "1", "turns of the motor per turn of the joint"
        )
        constants = [
            loads.parameter(f"{label}.{name}", getattr(self, name), _UNITS[name], _MEANINGS[name])
            for name in self._given
        ]
        k, resistance = winding(constants)
        gain, drag = k / resistance, k * k / resistance  # N·m/V, N·m·s/rad
        torque = ratio * (gain * self._voltage(loads, hinge, label) - drag * (ratio * hinge.rate))
        loads.hinge_torque(self.joint, torque)
        if self.rotor_inertia:
            rotor = loads.parameter(
                f"{label}.rotor_inertia", self.rotor_inertia, "kg·m²", "inertia of the motor's rotor"
            )
            self._accelerate_rotor(loads, hinge.joint, ratio * ratio * rotor)

    def _accelerate_rotor(self, loads: Loads, joint: Joint, inertia: Scalar) -> None:
        """The body that turns has the inertia about the joint's axis besides its own."""
        parent, child = (loads.mechanism.body(name) for name in (joint.parent, joint.child))
        what = f"the rotor_inertia of the motor on joint {self.joint!r}"
        if not parent.fixed and not child.fixed:
            raise DesignError(
                f"{what} turns between {parent.name!r} and {child.name!r}, which both move; it can act on joints of a "
                "fixed body: set it to 0, and give the rotor to the bodies' inertia"
            )
        if loads.placement.base is not None:
            raise DesignError(
                f"{what} needs fixed bodies that stay where they are, and the scene moves them: set it to 0"
            )
        axis = [float(x) for x in joint.axis]
        rows: list[list[Scalar]] = [[0] * 6 for _ in range(6)]
        for i, j in product(range(3), repeat=2):
            rows[3 + i][3 + j] = inertia * (axis[i] * axis[j])
        loads.added_inertia(child.name if parent.fixed else parent.name, tuple(joint.point), rows)

    def books(self, result: "Result", label: str = "") -> MotorBalance:
        """The old name of `energy_balance`."""
        superseded("LinearMotor.books", "LinearMotor.energy_balance")
        return self.energy_balance(result, label)

    def energy_balance(self, result: "Result", label: str = "") -> MotorBalance:
        """What the motor took, gave and lost along a run, with the parameters of that run.

        label  of the motor's parameters, e.g. "h1.motor.2" for the second motor on a joint; the first one's if empty
        """
        label = label or f"{self.joint}.motor"
        known = result.provenance.parameters
        constants = [known.get(f"{label}.{name}", getattr(self, name)) for name in self._given]
        ratio = known.get(f"{label}.gear_ratio", self.gear_ratio)
        angle, rate = result.angle(self.joint), result.rate(self.joint)
        if isinstance(self.voltage, str):
            rows = zip(result.t.tolist(), angle.tolist(), rate.tolist(), strict=True)
            inputs = {name: known[name] for drive in self.drives() for name in drive.inputs()}
            voltage = np.array(
                [_plain(stage(self.voltage, {"t": t, "angle": q, "rate": u, **inputs})) for t, q, u in rows]
            )
        else:
            voltage = np.full(len(result.t), known.get(f"{label}.voltage", self.voltage))
        k, resistance = (_plain(value) for value in winding(constants))
        current = (voltage - k * ratio * rate) / resistance
        torque = ratio * k * current
        return MotorBalance(
            voltage, current, torque, voltage * current, torque * rate, resistance * current**2
        )

    @property
    def _given(self) -> tuple[str, ...]:
        return _LINE if self.stall_torque is not None else _WINDING

    def _voltage(self, loads: Loads, hinge: Hinge, label: str) -> Scalar:
        if isinstance(self.voltage, str):
            return stage(
                self.voltage, {"t": loads.time, "angle": hinge.angle, "rate": hinge.rate, **loads.inputs}
            )
        return loads.parameter(f"{label}.voltage", self.voltage, "V", "voltage of the motor")

    def drives(self) -> tuple[Drive, ...]:
        """The voltage, if it is an expression."""
        what = f"the voltage of the motor on joint {self.joint!r}"
        if not isinstance(self.voltage, str):
            return ()
        return (Drive(what, self.voltage, self.joint, field=("voltage",)),)


def winding(constants: Sequence[Scalar]) -> tuple[Scalar, Scalar]:
    """k, N·m/A, and R, Ω, of the motor's own data: of the line (three numbers) or of the winding (two)."""
    if len(constants) == len(_WINDING):
        return constants[0], constants[1]
    stall, speed, nominal = constants
    k = nominal / speed
    return k, k * nominal / stall


def _plain(value: Scalar) -> float:
    """What is made of plain numbers is a plain number."""
    assert not isinstance(value, Value)
    return float(value)


def _label(joint: str, taken: Sequence[str]) -> str:
    """What the motor's parameters begin with; a second motor on the same joint is number 2."""
    label = f"{joint}.motor"
    count = sum(name.startswith(f"{label}.") and name.endswith(".gear_ratio") for name in taken)
    return f"{label}.{count + 1}" if count else label
