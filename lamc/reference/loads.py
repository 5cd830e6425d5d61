"""Effects as numbers: scene effects in, gravity, hinge torques, forces of springs and contacts at a state out.

An independent reading of the effects, written from their physical meaning and sharing nothing with their
symbolic form. It dispatches on `effect.name`; an effect that it does not know is refused, never skipped.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
import numpy.typing as npt

from lamc.errors import DesignError, UnsupportedError
from lamc.mechanism.records import Joint, Mechanism
from lamc.reference import hinge_laws
from lamc.reference.contact import Ground, ground
from lamc.reference.expression import Formula, Values, parse
from lamc.reference.kinematics import Link, Motion, cross

Array = npt.NDArray[np.float64]


@dataclass(frozen=True)
class PointSpring:
    """A spring between two points, each on a body (by name) and given as drawn, m."""

    bodies: tuple[str, str]
    points: tuple[Array, Array]
    stiffness: float  # N/m
    rest_length: float  # m
    damping: float  # N·s/m


@dataclass(frozen=True)
class NumericLoads:
    """What acts on a mechanism, for joints in a stated order (arrays of shape (n,) follow that order).

    gravity      acceleration, shape (3,), m/s², world axes; zero if there is none
    stiffness    N·m/rad, zero where hinge stiffness does not act
    preload      stiffness times rest angle, N·m, zero where the rest angle does not act
    rest_energy  ½ stiffness rest_angle², J: makes the energy of a hinge at its rest angle zero
    damping      N·m·s/rad, zero where damping does not act
    applied      constant torques, N·m
    torques      (index of the joint, formula in t, angle and rate, N·m), those of nonlinear stiffness among them
    springs      springs between points
    grounds      planes that points touch
    laws         (index of the joint, energy of its nonlinear stiffness, J)
    energies     names of the energies these loads store, in the order of the scene
    """

    gravity: Array
    stiffness: Array
    preload: Array
    rest_energy: Array
    damping: Array
    applied: Array
    torques: tuple[tuple[int, Formula], ...]
    springs: tuple[PointSpring, ...]
    grounds: tuple[Ground, ...]
    laws: tuple[tuple[int, Formula], ...]
    energies: tuple[str, ...]

    def hinge_torques(self, t: float, q: Array, u: Array) -> Array:
        """Torque on each joint's child about the joint's axis, shape (n,), N·m; positive opens the fold."""
        torque = self.preload + self.applied - self.stiffness * q - self.damping * u
        for k, formula in self.torques:
            torque[k] += formula({"t": t, "angle": float(q[k]), "rate": float(u[k])})
        return torque

    def point_wrenches(self, links: Sequence[Link], state: Motion) -> tuple[Array, Array]:
        """Of springs and contacts: forces, N, and moments about the centres of mass, N·m, on the bodies of the walk;
        both (n, 3), world."""
        forces, moments = np.zeros((2, len(links), 3))
        for spring in self.springs:
            ends = [_end(links, state, *end) for end in zip(spring.bodies, spring.points, strict=True)]
            (a, point_a, velocity_a), (b, point_b, velocity_b) = ends
            line = point_b - point_a
            length = float(np.linalg.norm(line))
            # A spring of no length has no direction; with a rest length that is no number, as in the C.
            direction = line / length if length > 0.0 or spring.rest_length else line
            stretch_rate = float((velocity_b - velocity_a) @ direction)
            pull = spring.stiffness * (length - spring.rest_length) + spring.damping * stretch_rate
            for place, point, force in ((a, point_a, pull * direction), (b, point_b, -pull * direction)):
                if place >= 0:
                    forces[place] += force
                    moments[place] += cross(point - state.centre[place], force)
        for plane in self.grounds:
            for place, point, force in plane.forces(partial(_end, links, state)):
                forces[place] += force
                moments[place] += cross(point - state.centre[place], force)
        return forces, moments

    def stored(self, q: Array, links: Sequence[Link], state: Motion) -> dict[str, float]:
        """Stored energy by effect, J, at angles q (n,) and the motion of the bodies there."""
        masses = np.array([link.body.mass for link in links])
        stretches = []
        for spring in self.springs:
            a, b = (_end(links, state, *end)[1] for end in zip(spring.bodies, spring.points, strict=True))
            stretches.append(float(np.linalg.norm(b - a)) - spring.rest_length)
        values = {
            "gravity": -float(masses @ (state.centre @ self.gravity)),
            "hinge_stiffness": float(0.5 * self.stiffness @ (q * q)),
            "rest_angle": float(self.rest_energy.sum() - self.preload @ q),
            "nonlinear_stiffness": sum(w({"angle": float(q[k])}) for k, w in self.laws),
            "spring": sum(0.5 * s.stiffness * x * x for s, x in zip(self.springs, stretches, strict=True)),
            "ground_contact": sum(g.stored(partial(_end, links, state)) for g in self.grounds),
        }
        return {name: values[name] for name in self.energies}


def _end(links: Sequence[Link], state: Motion, body: str, point: Array) -> tuple[int, Array, Array]:
    """Place in the walk (-1: fixed), world position, m, and velocity, m/s, of a point of a body given as drawn."""
    for i, link in enumerate(links):
        if link.body.name == body:
            arm = state.rotation[i] @ (point - link.body.com)
            return i, state.centre[i] + arm, state.velocity[i] + cross(state.spin[i], arm)
    return -1, point, np.zeros(3)


KNOWN = (
    "gravity",
    "ground_contact",
    "hinge_damping",
    "hinge_stiffness",
    "linear_motor",
    "nonlinear_stiffness",
    "rest_angle",
    "spring",
    "torque",
)


def told_apart(effects: Iterable[Any]) -> tuple[tuple[Any, ...], str]:
    """The effects that have a numeric meaning here, and the others in words: "the effect 'wind'", or nothing."""
    effects = tuple(effects)
    known = tuple(effect for effect in effects if effect.name in KNOWN)
    names = sorted({repr(effect.name) for effect in effects if effect.name not in KNOWN})
    return known, f"the effect{'s' if len(names) > 1 else ''} {', '.join(names)}" if names else ""


def numeric_loads(
    mechanism: Mechanism, effects: Iterable[Any], joints: Sequence[str], moving: Sequence[str] | None = None
) -> NumericLoads:
    """The loads of `effects` on `mechanism`, arrays in the order of `joints`.

    moving  names of the bodies that move; None: those that are not fixed

    Raises UnsupportedError for an effect this table does not know, and DesignError for a torque on a joint
    that is not there or with a formula outside the permitted language.
    """
    records = [mechanism.joint(name) for name in joints]
    n = len(records)
    gravity = np.zeros(3)
    stiffness, preload, rest_energy, damping, applied = np.zeros((5, n))
    torques: list[tuple[int, Formula]] = []
    springs: list[PointSpring] = []
    grounds: list[Ground] = []
    laws: list[tuple[int, Formula]] = []
    energies: list[str] = []
    effects = tuple(effects)
    linear = np.array([j.stiffness if j.name not in _bent(effects) else 0.0 for j in records])
    for effect in effects:
        match effect.name:
            case "gravity":
                gravity = np.array(effect.acceleration, dtype=np.float64)
                energies.append("gravity")
            case "hinge_stiffness":
                stiffness = linear
                energies.append("hinge_stiffness")
            case "hinge_damping":
                damping = np.array([j.damping for j in records])
            case "rest_angle":
                rest = np.array([j.rest_angle for j in records])
                preload, rest_energy = linear * rest, 0.5 * linear * rest**2
                energies.append("rest_angle")
            case "torque":
                for k, torque in _torques(effect.torques, records):
                    if isinstance(torque, str):
                        torques.append((k, parse(torque)))
                    else:
                        applied[k] += torque
            case "nonlinear_stiffness":
                more, laws = hinge_laws.laws(effect.laws, records)
                torques += more
                energies.append("nonlinear_stiffness")
            case "linear_motor":
                torques.append(_motor(effect, records))
            case "spring":
                springs.append(_spring(mechanism, effect))
                energies.append("spring")
            case "ground_contact":
                grounds.append(ground(mechanism, effect, moving))
                energies.append("ground_contact")
            case other:
                raise UnsupportedError(
                    f"the independent voice cannot check the effect {other!r}: it has no numeric meaning "
                    "for it; leave the effect out of the scene to check the rest"
                )
    return NumericLoads(
        gravity,
        stiffness,
        preload,
        rest_energy,
        damping,
        applied,
        tuple(torques),
        tuple(springs),
        tuple(grounds),
        tuple(laws),
        tuple(dict.fromkeys(energies)),
    )


def _motor(effect: Any, joints: Sequence[Joint]) -> tuple[int, Formula]:
    """Index of the joint and torque of a motor: current times torque constant, by Ohm's law."""
    names = [joint.name for joint in joints]
    if effect.joint not in names:
        raise DesignError(
            f"the scene puts a motor on joint {effect.joint!r}, which the mechanism does not have"
        )
    voltage = parse(effect.voltage) if isinstance(effect.voltage, str) else lambda _: float(effect.voltage)
    if effect.resistance is not None:
        constant, resistance = effect.torque_constant, effect.resistance
    else:
        constant = effect.nominal_voltage / effect.no_load_speed
        resistance = effect.nominal_voltage / (effect.stall_torque / constant)

    def torque(values: Values) -> float:
        induced = constant * effect.gear_ratio * values["rate"]
        return float(effect.gear_ratio * constant * (voltage(values) - induced) / resistance)

    return names.index(effect.joint), torque


def _bent(effects: Iterable[Any]) -> set[str]:
    """Names of the joints whose linear stiffness a nonlinear one replaces."""
    return {name for effect in effects if effect.name == "nonlinear_stiffness" for name in effect.laws}


def _spring(mechanism: Mechanism, effect: Any) -> PointSpring:
    """Raises DesignError for a body that the mechanism does not have."""
    known = {body.name for body in mechanism.bodies}
    for name in (effect.body_a, effect.body_b):
        if name not in known:
            raise DesignError(f"the scene puts a spring on body {name!r}, which the mechanism does not have")
    return PointSpring(
        (effect.body_a, effect.body_b),
        (np.array(effect.point_a, dtype=np.float64), np.array(effect.point_b, dtype=np.float64)),
        float(effect.stiffness),
        float(effect.rest_length),
        float(effect.damping),
    )


def _torques(torques: Mapping[str, float | str], joints: Sequence[Joint]) -> list[tuple[int, float | str]]:
    index = {joint.name: k for k, joint in enumerate(joints)}
    found: list[tuple[int, float | str]] = []
    for name in sorted(torques):
        if name not in index:
            raise DesignError(f"the scene puts a torque on joint {name!r}, which the mechanism does not have")
        found.append((index[name], torques[name]))
    return found
