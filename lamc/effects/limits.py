"""Limits of the joint angles: one-sided springs with dampers, or impacts. The limits come from the joints."""

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, ClassVar

from pydantic import Field

from lamc.basics.errors import DesignError, about
from lamc.basics.fields import Flag
from lamc.basics.quantity_fields import Unit
from lamc.effects.registered import RegisteredEffect
from lamc.mechanics.loads import Hinge, Loads
from lamc.mechanism.limits import outside_limits
from lamc.records.effect import Effect
from lamc.records.mechanism import FREE_LIMITS, Joint, Mechanism
from lamc.symbolic.scalars import Scalar

if TYPE_CHECKING:
    from lamc.effects.engine_loads import EngineLoads

STANDARD_GRAVITY = 9.81  # m/s², for the stiffness of a stop of which the scene says nothing
STOP_STIFFNESS = (
    100.0  # times the torque of the mechanism's weight at arm's length: it then yields 0.6° at most
)
STOP_DAMPING_RATIO = 0.3  # of critical damping with the mechanism's inertia: a dull stop


@dataclass(frozen=True)
class JointLimits(RegisteredEffect):
    """Keeps joint angles within the joints' limits (lower, upper), rad.

    Either a torque -k (q - limit) - c u on the joint while it is beyond its limit, or impacts at the limit that reverse
    the joint's rate and multiply it by the restitution. Integrators stop where limits are reached and left.
    """

    stiffness: Annotated[
        float | None,
        Unit(
            "N*m/rad",
            "with neither stiffness nor restitution: 100 times the mechanism's weight times its size",
            gt=0.0,
        ),
    ] = None
    damping: Annotated[
        float | None,
        Unit("N*m*s/rad", "while beyond the limit; left out with the stiffness: 0.3 of critical", ge=0.0),
    ] = None
    restitution: Annotated[
        float | None,
        Unit(
            "1",
            "above 0, at most 1. A joint that comes to rest on its limit bounces without end: use a stiffness",
            ge=0.0,
            le=1.0,
        ),
    ] = None
    flat_fold: Annotated[
        Flag,
        Field(
            description="true: limits of ±180° count too, where one face lies flat on the other; false: they do not, "
            "since a joint without limits has these and may turn round and round"
        ),
    ] = False

    name: ClassVar[str] = "joint_limits"
    summary: ClassVar[str] = "Limits of the joints"
    example: ClassVar[str] = "joint_limits: {stiffness: 2 N*mm/deg, flat_fold: true}"
    source: ClassVar[str] = "T = -k (q - limit) - c u beyond the limit; or Newton's law of impact"

    def __post_init__(self) -> None:
        super().__post_init__()
        with about(("restitution",)):
            if self.restitution == 0.0:
                raise DesignError(
                    "the restitution of joint limits is 0; it must be above 0: for a stop without bounce give a "
                    "stiffness and a damping"
                )
        if self.restitution is not None and (self.stiffness is not None or self.damping is not None):
            with about(("restitution",)):
                raise DesignError(
                    "joint limits have a restitution and a stiffness or damping; a limit either bounces or yields: "
                    "give one"
                )

    @property
    def conservative(self) -> bool:
        """With a stiffness and no damper, or a restitution of 1. The stops of a scene that says nothing are damped."""
        if self.restitution is not None:
            return self.restitution == 1.0
        return self.stiffness is not None and not self.damping

    def contribute(self, loads: Loads) -> None:
        found = False
        for hinge in loads.hinges():
            for side, limit in _limits(hinge.joint, flat_fold=self.flat_fold):
                found = True
                self._hold(loads, hinge, side, limit)
        if not found:
            raise DesignError(
                "joint_limits is called for, but no joint has limits narrower than ±180°; give joints limits, ask for "
                "flat_fold, or leave the effect out"
            )

    def carry_over(self, engine: "EngineLoads") -> None:
        """Stops; engines have none that strike."""
        if self.restitution is not None:
            engine.lose(
                f"the restitution of joint limits, {self.restitution:g} (stops that yield take their place)"
            )
        stiffness, damping = self._stop(engine.mechanism)
        for joint in engine.mechanism.joints:
            ends = dict(_limits(joint, flat_fold=self.flat_fold))
            if ends:
                engine.hinge_stop(joint.name, ends.get(-1), ends.get(1), stiffness, damping)

    def check_start(self, mechanism: Mechanism, angles: Mapping[str, float]) -> None:
        """Refuses a start beyond a limit: a stop would fling the joint back, and an impact would never come."""
        reported = outside_limits(mechanism, angles)
        if reported:
            raise DesignError(
                f"{'; '.join(reported)}: start within them, widen them, or leave {self.name} out of the scene"
            )

    def _hold(self, loads: Loads, hinge: Hinge, side: int, limit: float) -> None:
        """One limit: side -1 for the lower one, 1 for the upper one."""
        label = f"{hinge.joint.name}.{'lower' if side < 0 else 'upper'}_limit"
        bound = loads.parameter(label, limit, "rad", "limit of the joint's angle")
        beyond = hinge.angle - bound if side > 0 else bound - hinge.angle
        title = f"{'lower' if side < 0 else 'upper'} limit of {hinge.joint.name}"
        if self.restitution is not None:
            rebound = loads.parameter(
                "joint_limits.restitution",
                self.restitution,
                "1",
                "rate after an impact on a limit over that before",
            )
            loads.impact(title, beyond, rebound)
            return
        stiffness, damping = self._stop(loads.mechanism)
        k = loads.parameter("joint_limits.stiffness", stiffness, "N·m/rad", "stiffness of the stops")
        touching = loads.switch(title, beyond)
        torque: Scalar = k * beyond
        if damping:
            c = loads.parameter("joint_limits.damping", damping, "N·m·s/rad", "damping of the stops")
            torque = torque + side * (c * hinge.rate)
        loads.hinge_torque(hinge.joint.name, -side * (touching * torque))
        loads.stored_energy(0.5 * (touching * (k * (beyond * beyond))))

    def _stop(self, mechanism: Mechanism) -> tuple[float, float]:
        """Stiffness, N·m/rad, and damping, N·m·s/rad."""
        mass = math.fsum(body.mass for body in mechanism.bodies if not body.fixed)
        stiffness = self.stiffness
        if stiffness is None:
            stiffness = STOP_STIFFNESS * mass * STANDARD_GRAVITY * mechanism.size
            critical = 2.0 * math.sqrt(stiffness * mass * mechanism.size**2)
            return stiffness, STOP_DAMPING_RATIO * critical if self.damping is None else self.damping
        return stiffness, self.damping or 0.0

    @classmethod
    def default_for(cls, mechanism: Mechanism) -> tuple[Effect | None, str]:
        count = sum(1 for j in mechanism.joints if j.is_limited)
        return (
            (
                cls(),
                f"{count} {'joint has limits' if count == 1 else 'joints have limits'} narrower than ±180°",
            )
            if count
            else (None, "no joint has limits narrower than ±180°")
        )


def _limits(joint: Joint, *, flat_fold: bool) -> Iterator[tuple[int, float]]:
    """(side, limit) of the limits that act; side -1 for the lower one, 1 for the upper one."""
    for side, limit, free in ((-1, joint.limits[0], FREE_LIMITS[0]), (1, joint.limits[1], FREE_LIMITS[1])):
        narrower = abs(limit) < abs(free) - 1e-12
        if narrower or flat_fold:
            yield side, limit
