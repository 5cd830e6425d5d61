"""A servo on a hinge: a position command turned into torque by gains, within what its motor can give."""

from dataclasses import dataclass
from typing import Annotated, ClassVar

from pydantic import Field

from lamc.basics.errors import DesignError, about
from lamc.basics.fields import Name
from lamc.basics.quantity_fields import Unit
from lamc.effects.drives import Drive, checked_drive
from lamc.effects.registered import RegisteredEffect
from lamc.mechanics.arranging import Arranging
from lamc.mechanics.gears import gear_inertia, gear_of, reflected_inertia
from lamc.mechanics.loads import Loads
from lamc.mechanism.tree import Tree
from lamc.symbolic.expression import stage
from lamc.symbolic.scalars import Scalar, call


@dataclass(frozen=True)
class Servo(RegisteredEffect):
    """Torque on a joint's child about its axis: T = stiffness (command - angle) - damping rate, within ±T_max(rate).

    The command is the name of an input, an expression in t (s) and inputs, or a number, which is a parameter of the
    simulator. The damping is on the rate of the joint, not of the error, as servos measure it.

    With a stall torque T₀ and a no-load speed ω₀ the supply limits the torque as a motor's line does: it is at most
    T₀ (1 - rate/ω₀), and at least -T₀ (1 + rate/ω₀), in all quadrants. Driven backwards, against its torque, the servo
    holds up to T₀ (1 + |rate|/ω₀), as the voltage that turning induces adds to the supply's; driven beyond its no-load
    speed it brakes, whatever its command. With a stall torque alone the torque is within ±T₀ at any rate.

    With backlash the gear's output turns by itself, a coordinate `JOINT.gear` with the gear's inertia; the controller
    measures that, and its motor drives it. Between gear and joint is a play, `backlash` from flank to flank, in the
    middle of which a run starts; beyond it the flanks push each other by gear_stiffness and gear_damping (Nordin &
    Gutman, Automatica 38, 2002, section 2).

    With a period the controller samples angle, rate and command at t = 0 and each multiple of the period, and the
    torque that it asks for is held in between (zero-order hold, without delay); what the motor can give follows its
    rate at all times. Samples are events. Outside a run, and in powers by rows, a state counts as sampled there.

    Corners of the limits, edges of the dead band and flanks are events, at which steps end. What is not given leaves no
    trace. One servo may act on a joint, and several in a scene.
    """

    joint: Annotated[Name, Field(description="the hinge that it drives")]
    command: Annotated[float | str, Unit("rad", "where the joint is to go; positive opens the fold")]
    stiffness: Annotated[float, Unit("N*m/rad", "torque per error, at the joint", ge=0.0)]
    damping: Annotated[float, Unit("N*m*s/rad", "torque per rate, at the joint", ge=0.0)] = 0.0
    stall_torque: Annotated[
        float | None, Unit("N*m", "T₀, at the joint; left out: nothing limits the torque", gt=0.0)
    ] = None
    no_load_speed: Annotated[
        float | None,
        Unit("rad/s", "ω₀, of the joint; left out: the stall torque is the limit at any rate", gt=0.0),
    ] = None
    backlash: Annotated[
        float,
        Unit(
            "rad",
            "play between gear and joint, from flank to flank; asks for the gear's inertia and stiffness",
            ge=0.0,
        ),
    ] = 0.0
    period: Annotated[
        float | None, Unit("s", "sample time of the controller; left out: it acts at all times", gt=0.0)
    ] = None
    dead_band: Annotated[
        float,
        Unit(
            "rad",
            "an error up to this asks for no torque, and a larger one for that of what is beyond",
            ge=0.0,
        ),
    ] = 0.0
    gear_inertia: Annotated[
        float,
        Unit(
            "kg*m^2",
            "of rotor and gear as the joint feels it: that of the rotor times the square of the gear ratio",
            ge=0.0,
        ),
    ] = 0.0
    gear_stiffness: Annotated[
        float | None, Unit("N*m/rad", "of the flanks on each other, at the joint; with backlash only", gt=0.0)
    ] = None
    gear_damping: Annotated[
        float, Unit("N*m*s/rad", "of the flanks while they touch, at the joint; with backlash only", ge=0.0)
    ] = 0.0

    name: ClassVar[str] = "servo"
    summary: ClassVar[str] = "Servos on hinges"
    example: ClassVar[str] = (
        "servo: {joint: hip, command: 0.35*sin(2*pi*t), stiffness: 20 N*mm/rad, damping: 0.2 N*mm*s/rad, "
        "stall_torque: 10 N*mm, no_load_speed: 60}"
    )
    source: ClassVar[str] = "T = k (command - q) - c u, |T + T0 u / w0| <= T0"
    repeatable: ClassVar[bool] = True
    conservative: ClassVar[bool] = False
    absent: ClassVar[str] = "no servo is called for"

    def __post_init__(self) -> None:
        super().__post_init__()
        for drive in self.drives():
            checked_drive(drive)
        if self.no_load_speed is not None and self.stall_torque is None:
            with about(("no_load_speed",)):
                raise DesignError(
                    f"the servo on joint {self.joint!r} has a no_load_speed and no stall_torque; the line of its "
                    "torque over rate needs both: give the stall_torque, or leave no_load_speed out"
                )
        self._check_gear()

    def _check_gear(self) -> None:
        """Raises DesignError for a play without what stands on either side of it, and the other way round."""
        given = {
            name: bool(getattr(self, name)) for name in ("gear_inertia", "gear_stiffness", "gear_damping")
        }
        missing = [name for name in ("gear_inertia", "gear_stiffness") if self.backlash and not given[name]]
        idle = [name for name in ("gear_stiffness", "gear_damping") if given[name] and not self.backlash]
        if missing:
            with about(("backlash",)):
                raise DesignError(
                    f"the servo on joint {self.joint!r} has backlash, and its gear no {' and no '.join(missing)}; "
                    "within the play the gear turns by itself, and beyond it pushes: give both, or leave backlash out"
                )
        if idle:
            with about((idle[0],)):
                raise DesignError(
                    f"the servo on joint {self.joint!r} has a {idle[0]} and no backlash; without play its gear is "
                    f"stiff: give backlash, or leave {idle[0]} out"
                )

    def claims(self) -> tuple[str, ...]:
        return (f"servo of joint {self.joint!r}",)

    def drives(self) -> tuple[Drive, ...]:
        """The command, if it is an expression."""
        if not isinstance(self.command, str):
            return ()
        return (Drive(f"the command of the servo on joint {self.joint!r}", self.command, field=("command",)),)

    def arrange(self, arranging: Arranging) -> None:
        """A gear's inertia asks for the general form of the equations, and its play for a coordinate."""
        if self.gear_inertia:
            arranging.inverse_dynamics()
        if self.backlash:
            arranging.gear(self.joint)

    def notes(self, tree: Tree) -> tuple[str, ...]:
        """Of a controller that samples: where its samples are not those of the run."""
        if self.period is None:
            return ()
        return (
            f"the servo on joint {self.joint!r} holds its torque between samples along a run, in the energy balance "
            "too; accelerations and powers of single states, rows of a result among them, are as if sampled there",
        )

    def contribute(self, loads: Loads) -> None:
        hinge = loads.hinge(self.joint)
        if not self.backlash:
            loads.hinge_torque(self.joint, self._driven(loads, hinge.angle, hinge.rate))
            if self.gear_inertia:
                reflected_inertia(loads, self.joint, self._inertia(loads))
            return
        gear = gear_of(loads, self.joint)
        loads.generalised_force(gear.place, self._driven(loads, gear.angle, gear.rate))
        gear_inertia(loads, gear.place, self._inertia(loads))
        push = self._push(loads, gear.angle - hinge.angle, gear.rate - hinge.rate)
        loads.generalised_force(gear.place, -push)
        loads.hinge_torque(self.joint, push)

    def _inertia(self, loads: Loads) -> Scalar:
        return self._parameter(loads, "gear_inertia", "kg·m²", "of rotor and gear, at the joint")

    def _push(self, loads: Loads, ahead: Scalar, opening: Scalar) -> Scalar:
        """Torque of the flanks on the joint, N·m, where the gear is ahead by an angle, rad, that grows, rad/s."""
        play = self._parameter(loads, "backlash", "rad", "play between gear and joint")
        stiffness = self._parameter(loads, "gear_stiffness", "N·m/rad", "of the gear's flanks")
        pushes = loads.switch(f"gear of {self.joint} pushes forwards", ahead - 0.5 * play)
        pulls = loads.switch(f"gear of {self.joint} pushes back", -0.5 * play - ahead)
        beyond = pushes * (ahead - 0.5 * play) + pulls * (ahead + 0.5 * play)
        loads.stored_energy(0.5 * (stiffness * (beyond * beyond)))
        push = stiffness * beyond
        if self.gear_damping:
            damping = self._parameter(
                loads, "gear_damping", "N·m·s/rad", "of the gear's flanks while they touch"
            )
            push = push + (pushes + pulls) * (damping * opening)
        return push

    def _driven(self, loads: Loads, angle: Scalar, rate: Scalar) -> Scalar:
        """Torque of the motor, N·m, by what the controller measures."""
        stiffness = self._parameter(loads, "stiffness", "N·m/rad", "torque of the servo per error")
        error, seen = self._error(loads, angle)
        # What a guard holds must not depend on other guards' modes: `seen` is the same error without them.
        torque, demand = stiffness * error, stiffness * seen
        if self.damping:
            damping = self._parameter(loads, "damping", "N·m·s/rad", "torque of the servo per rate")
            torque, demand = torque - damping * rate, demand - damping * rate
        if self.period is not None:
            period = self._parameter(loads, "period", "s", "sample time of the controller")
            torque = demand = loads.clock(f"servo of {self.joint} samples", period).hold(demand)
        return self._within(loads, rate, torque, demand)

    def _error(self, loads: Loads, angle: Scalar) -> tuple[Scalar, Scalar]:
        """Beyond the dead band, rad: by the modes of its edges, and without."""
        error = self._commanded(loads) - angle
        if not self.dead_band:
            return error, error
        band = self._parameter(loads, "dead_band", "rad", "error that asks for no torque")
        beyond = call("max", error - band, 0.0) + call("min", error + band, 0.0)
        if self.period is not None:  # a sample has no corners
            return beyond, beyond
        above = loads.switch(f"error of {self.joint} above its dead band", error - band)
        below = loads.switch(f"error of {self.joint} below its dead band", -error - band)
        return above * (error - band) + below * (error + band), beyond

    def _commanded(self, loads: Loads) -> Scalar:
        if isinstance(self.command, str):
            return stage(self.command, {"t": loads.time, **loads.inputs})
        return self._parameter(loads, "command", "rad", "where the servo is to go")

    def _within(self, loads: Loads, rate: Scalar, torque: Scalar, demand: Scalar) -> Scalar:
        """The torque within what the motor can give; `demand`: the torque, without modes."""
        if self.stall_torque is None:
            return torque
        most = self._parameter(loads, "stall_torque", "N·m", "torque of the servo at rest, at most")
        lost: Scalar = 0
        if self.no_load_speed is not None:
            speed = self._parameter(loads, "no_load_speed", "rad/s", "of the servo without a load")
            lost = most / speed * rate
        upper, lower = most - lost, -most - lost
        above = loads.switch(f"servo of {self.joint} at its upper limit", demand - upper)
        below = loads.switch(f"servo of {self.joint} at its lower limit", lower - demand)
        return torque + above * (upper - torque) + below * (lower - torque)

    def _parameter(self, loads: Loads, field: str, unit: str, meaning: str) -> Scalar:
        return loads.parameter(f"{self.joint}.servo.{field}", getattr(self, field), unit, meaning)
