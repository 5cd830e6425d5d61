"""Effects as numbers: scene effects in, gravity and hinge torques at a state out.

An independent reading of the effects, written from their physical meaning and sharing nothing with their
symbolic form. It dispatches on `effect.name`; an effect that it does not know is refused, never skipped.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from lamc.errors import DesignError, UnsupportedError
from lamc.mechanism.records import Joint, Mechanism
from lamc.reference.expression import Formula, parse

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
    torques      (index of the joint, formula in t, angle and rate, N·m)
    energies     names of the energies these loads store, in the order of the scene
    """

    gravity: Array
    stiffness: Array
    preload: Array
    rest_energy: Array
    damping: Array
    applied: Array
    torques: tuple[tuple[int, Formula], ...]
    energies: tuple[str, ...]

    def hinge_torques(self, t: float, q: Array, u: Array) -> Array:
        """Torque on each joint's child about the joint's axis, shape (n,), N·m; positive opens the fold."""
        torque = self.preload + self.applied - self.stiffness * q - self.damping * u
        for k, formula in self.torques:
            torque[k] += formula({"t": t, "angle": float(q[k]), "rate": float(u[k])})
        return torque

    def stored(self, q: Array, masses: Array, centres_world: Array) -> dict[str, float]:
        """Stored energy by effect, J; centres_world has shape (m, 3), m."""
        values = {
            "gravity": -float(masses @ (centres_world @ self.gravity)),
            "hinge_stiffness": float(0.5 * self.stiffness @ (q * q)),
            "rest_angle": float(self.rest_energy.sum() - self.preload @ q),
        }
        return {name: values[name] for name in self.energies}


def numeric_loads(mechanism: Mechanism, effects: Iterable[Any], joints: Sequence[str]) -> NumericLoads:
    """The loads of `effects` on `mechanism`, arrays in the order of `joints`.

    Raises UnsupportedError for an effect this table does not know, and DesignError for a torque on a joint
    that is not there or with a formula outside the permitted language.
    """
    records = [mechanism.joint(name) for name in joints]
    n = len(records)
    gravity = np.zeros(3)
    stiffness, preload, rest_energy, damping, applied = np.zeros((5, n))
    torques: list[tuple[int, Formula]] = []
    energies = []
    for effect in effects:
        match effect.name:
            case "gravity":
                gravity = np.array(effect.acceleration, dtype=np.float64)
                energies.append("gravity")
            case "hinge_stiffness":
                stiffness = np.array([j.stiffness for j in records])
                energies.append("hinge_stiffness")
            case "hinge_damping":
                damping = np.array([j.damping for j in records])
            case "rest_angle":
                preload = np.array([j.stiffness * j.rest_angle for j in records])
                rest_energy = np.array([0.5 * j.stiffness * j.rest_angle**2 for j in records])
                energies.append("rest_angle")
            case "torque":
                for k, torque in _torques(effect.torques, records):
                    if isinstance(torque, str):
                        torques.append((k, parse(torque)))
                    else:
                        applied[k] += torque
            case other:
                raise UnsupportedError(
                    f"the independent voice cannot check the effect {other!r}: it has no numeric meaning "
                    "for it; leave the effect out of the scene to check the rest"
                )
    return NumericLoads(
        gravity, stiffness, preload, rest_energy, damping, applied, tuple(torques), tuple(energies)
    )


def _torques(torques: Mapping[str, float | str], joints: Sequence[Joint]) -> list[tuple[int, float | str]]:
    index = {joint.name: k for k, joint in enumerate(joints)}
    found: list[tuple[int, float | str]] = []
    for name in sorted(torques):
        if name not in index:
            raise DesignError(f"the scene puts a torque on joint {name!r}, which the mechanism does not have")
        found.append((index[name], torques[name]))
    return found
