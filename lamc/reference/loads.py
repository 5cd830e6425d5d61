"""Effects as numbers: scene effects in, gravity, hinge torques, forces of springs and contacts at a state out.

An independent reading of the effects, written from their physical meaning and sharing nothing with their
symbolic form. It dispatches on `effect.name`; an effect that it does not know is refused, never skipped.
"""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from lamc.basics.errors import DesignError, UnsupportedError
from lamc.records.mechanism import Joint, Mechanism
from lamc.reference import hinge_laws
from lamc.reference.bender import folding_bender, pushing_bender
from lamc.reference.cable import cable
from lamc.reference.contact import ground
from lamc.reference.expression import Formula, Values, parse
from lamc.reference.kinematics import Link, TreeState
from lamc.reference.point_loads import BodyState, PointLoad, Push, spring, wrenches
from lamc.reference.pouch import pouch
from lamc.reference.servo import LooseGear, loose_gear, place, servo
from lamc.reference.wing import FluidMass, wing_in_air

Array = npt.NDArray[np.float64]


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
    laws         (name of the effect, index of the joint, formula of the energy that goes with such a torque, J)
    at_points    what acts on points of bodies
    fluid        mass of the air that goes with bodies; only cross-checks that know it may take such loads
    reflected    (effect that books its energy, index of the joint, inertia that its rate feels besides, kg·m²), of
                 rotors behind gears; as for `fluid`
    gears        with play, of servos; as for `fluid`
    energies     names of the energies these loads store, in the order of the scene
    """

    gravity: Array
    stiffness: Array
    preload: Array
    rest_energy: Array
    damping: Array
    applied: Array
    torques: tuple[tuple[int, Formula], ...]
    laws: tuple[tuple[str, int, Formula], ...]
    at_points: tuple[PointLoad, ...]
    fluid: tuple[FluidMass, ...]
    reflected: tuple[tuple[str, int, float], ...]
    gears: tuple[LooseGear, ...]
    energies: tuple[str, ...]

    def hinge_torques(self, t: float, q: Array, u: Array) -> Array:
        """Torque on each joint's child about the joint's axis, shape (n,), N·m; positive opens the fold."""
        torque = self.preload + self.applied - self.stiffness * q - self.damping * u
        for k, formula in self.torques:
            torque[k] += formula({"t": t, "angle": float(q[k]), "rate": float(u[k])})
        return torque

    def point_wrenches(self, t: float, links: Sequence[Link], state: TreeState) -> tuple[Array, Array]:
        """Of what acts on points: forces, N, and moments about the centres of mass, N·m, on the bodies of the walk;
        both (n, 3), world."""
        return wrenches(self.at_points, t, links, state)

    def pushes(self, t: float, place: BodyState) -> Iterator[Push]:
        """Of what acts on points."""
        for load in self.at_points:
            yield from load.pushes(t, place)

    def stored(self, t: float, q: Array, moment: Array, place: BodyState) -> dict[str, float]:
        """Stored energy by effect, J, at angles q (n,); moment (3,): Σ m r of the bodies, kg·m, world."""
        values = dict.fromkeys(self.energies, 0.0) | {
            "gravity": -float(moment @ self.gravity),
            "hinge_stiffness": float(0.5 * self.stiffness @ (q * q)),
            "rest_angle": float(self.rest_energy.sum() - self.preload @ q),
        }
        for name, k, energy in self.laws:
            values[name] += energy({"t": t, "angle": float(q[k]), "rate": 0.0})
        for load in self.at_points:
            if load.effect:
                values[load.effect] += load.stored(t, place)
        return {name: values[name] for name in self.energies}


KNOWN = (
    "external_torque",
    "blade_element_drag",
    "cable",
    "gravity",
    "ground_contact",
    "hinge_damping",
    "hinge_stiffness",
    "joint_limits",
    "linear_motor",
    "nonlinear_stiffness",
    "piezo_bender",
    "pouch",
    "rest_angle",
    "servo",
    "spring",
    "torque",
)


def known_effects(effects: Iterable[Any], more: Iterable[str] = ()) -> tuple[tuple[Any, ...], str]:
    """The effects that have a numeric meaning, and the others in words: "the effect 'wind'", or nothing.

    more  names of effects that the cross-check knows besides loads
    """
    effects, names_known = tuple(effects), {*KNOWN, *more}
    known = tuple(effect for effect in effects if effect.name in names_known)
    names = sorted({repr(effect.name) for effect in effects if effect.name not in names_known})
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
    laws: list[tuple[str, int, Formula]] = []
    at_points: list[PointLoad] = []
    fluid: list[FluidMass] = []
    reflected: list[tuple[str, int, float]] = []
    gears: list[LooseGear] = []
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
            case "external_torque":
                pass  # zero; `inputs.told` puts torques that are reported in its place
            case "nonlinear_stiffness":
                more, stored = hinge_laws.laws(effect.laws, records)
                torques += more
                laws += [("nonlinear_stiffness", k, energy) for k, energy in stored]
                energies.append("nonlinear_stiffness")
            case "joint_limits":
                more, stored = hinge_laws.stops(mechanism, effect, records)
                torques += more
                laws += [("joint_limits", k, energy) for k, energy in stored]
                energies += ["joint_limits"] * bool(stored)
            case "linear_motor":
                torques.append(_motor(effect, records))
            case "pouch":
                torques.append(pouch(effect, records))
            case "servo" if effect.backlash:
                gears.append(loose_gear(effect, records))
                energies.append("servo")
            case "servo":
                torques.append((place(effect, records), servo(effect)))
                if effect.gear_inertia:
                    reflected.append(("servo", place(effect, records), effect.gear_inertia))
                    energies.append("servo")
            case "spring":
                at_points.append(spring(mechanism, effect))
                energies.append("spring")
            case "cable":
                at_points.append(cable(mechanism, effect))
                energies.append("cable")
            case "ground_contact":
                at_points.append(ground(mechanism, effect, moving))
                energies.append("ground_contact")
            case "piezo_bender" if effect.hinge is not None:
                k, torque_of, energy = folding_bender(effect, records)
                torques.append((k, torque_of))
                laws.append(("piezo_bender", k, energy))
                energies.append("piezo_bender")
            case "piezo_bender":
                at_points.append(pushing_bender(effect))
                energies.append("piezo_bender")
            case "blade_element_drag":
                air = wing_in_air(mechanism, effect)
                at_points.append(air)
                fluid += air.fluid
                energies += ["blade_element_drag"] * bool(air.fluid)
            case other:
                raise UnsupportedError(
                    f"the independent cross-check cannot check the effect {other!r}: it has no numeric meaning "
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
        tuple(laws),
        tuple(at_points),
        tuple(fluid),
        tuple(reflected),
        tuple(gears),
        tuple(dict.fromkeys(energies)),
    )


def rigid_loads(
    mechanism: Mechanism, effects: Iterable[Any], joints: Sequence[str], moving: Sequence[str] | None = None
) -> NumericLoads:
    """As `numeric_loads`, for cross-checks of rigid bodies in vacuum. Raises UnsupportedError for air that goes with
    one."""
    loads = numeric_loads(mechanism, effects, joints, moving)
    if loads.fluid:
        raise UnsupportedError(
            f"this cross-check has no mass of the air around body {loads.fluid[0].body!r}; take `Lagrange` of "
            "lamc.reference.lagrange, or set added_mass to false"
        )
    geared = [joints[k] for _, k, _ in loads.reflected] + [gear.joint for gear in loads.gears]
    if geared:
        raise UnsupportedError(
            f"this cross-check has no inertia of gears, such as that of joint {geared[0]!r}; take "
            "`Lagrange` of lamc.reference.lagrange, or set it to 0"
        )
    return loads


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


def _torques(torques: Mapping[str, float | str], joints: Sequence[Joint]) -> list[tuple[int, float | str]]:
    index = {joint.name: k for k, joint in enumerate(joints)}
    found: list[tuple[int, float | str]] = []
    for name in sorted(torques):
        if name not in index:
            raise DesignError(f"the scene puts a torque on joint {name!r}, which the mechanism does not have")
        found.append((index[name], torques[name]))
    return found
