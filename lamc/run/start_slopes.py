"""Derivatives of a start: by an angle or a rate that the scene gives, with what the loops make of the others.

In: a simulator, a name. Out: how coordinates and rates of the start follow from it; the differences of order 4 that
know it, which dimensions of a design take too.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from lamc.basics.errors import LamcError, RequestError
from lamc.basics.threads import on_one_thread
from lamc.run.derivatives import ANGLES, RATES
from lamc.run.request import Array

if TYPE_CHECKING:
    from lamc.run.simulator import Simulator

STEP = 1e-3  # of a number, or of a radian: differences of order 4 then err by 1e-12 of it, and round-off by 1e-13
# Two steps agree to so much of the largest number where the numbers are smooth: closing loops knows a start to 1e-12 or
# so, which differences over 1e-3 make 1e-9.
AGREE = 1e-7
PLACES, WEIGHTS = (-2.0, -1.0, 1.0, 2.0), (1.0 / 12.0, -2.0 / 3.0, 2.0 / 3.0, -1.0 / 12.0)

# At a declared bound all points lie on one side of it: of order 4 as well, and err six times as much.
_FORWARD = (0.0, 1.0, 2.0, 3.0, 4.0), (-25.0 / 12.0, 4.0, -3.0, 4.0 / 3.0, -1.0 / 4.0)


@dataclass(frozen=True)
class Beside:
    """Where differences of order 4 by a number look: at places times the step from its value; weights are of these."""

    step: float
    places: tuple[float, ...] = PLACES
    weights: tuple[float, ...] = WEIGHTS


def beside(value: float, least: float | None, most: float | None) -> Beside:
    """Where differences look beside a value that lies between bounds: on either side where there is room, else on the
    side that has more of it, by a shorter step if it must be."""
    step = STEP * abs(value) if value else STEP
    below = np.inf if least is None else value - least
    above = np.inf if most is None else most - value
    if min(below, above) >= -PLACES[0] * step or max(below, above) <= 0.0:
        return Beside(step)
    places, weights = _FORWARD
    step = min(step, (1.0 - 1e-9) * max(below, above) / places[-1])  # a bound is not passed by round-off
    return Beside(step if above >= below else -step, places, weights)


@on_one_thread
def slope_of_start(simulator: "Simulator", name: str) -> Array:
    """Derivative of the start by a parameter of the scene, an angle or a rate."""
    if not name.startswith((ANGLES, RATES)):
        return np.zeros(len(simulator.start))
    what, joint = name.split(".", 1)
    first = 0 if what == "angles" else len(simulator.coordinates)
    given = dict(getattr(simulator.scene, what))

    def start(way: float) -> Array:
        moved = {**given, joint: float(simulator.start[first + simulator.joints.index(joint)]) + way}
        scene = simulator.scene
        return simulator.start_of(replace(scene, angles=moved) if first == 0 else replace(scene, rates=moved))

    if len({*given, joint}) > simulator.freedoms and simulator.cut_joints:
        return _held(simulator, joint, list(given), first)
    return agreed(start, Beside(STEP), name)


def _held(simulator: "Simulator", joint: str, given: Sequence[str], first: int) -> Array:
    """The same where the scene gives more angles than may be chosen: others that are given stay, the first of them that
    suffice, and the rest follow. first: where coordinates, or rates, begin in the state."""
    count, start = len(simulator.rates), simulator.start
    if np.any(start[len(simulator.coordinates) :]) or len(simulator.coordinates) != count:
        raise RequestError(
            f"there is no derivative by the start of {joint!r}: the scene gives more angles or rates than may be "
            "chosen, and they do not start at rest on a fixed base; give fewer"
        )
    jacobian = simulator.model.motion({}).closures(start[None, :])[0, simulator.model.closure_count :]
    _, _, rows = np.linalg.svd(jacobian.reshape(-1, count))
    free = rows[simulator.model.rank :].T  # (nu, freedoms)
    held: list[int] = []
    for name in (joint, *given):
        index = simulator.joints.index(name)
        if np.linalg.matrix_rank(free[[*held, index]], tol=1e-6) > len(held):  # directions are of length one
            held.append(index)
    if not held or held[0] != simulator.joints.index(joint) or len(held) < free.shape[1]:
        raise RequestError(
            f"there is no derivative by the start of {joint!r}: it does not say where the loops go"
        )
    along = free @ np.linalg.solve(free[held], np.eye(len(held))[0])
    result = np.zeros(len(start))
    result[first : first + count] = along
    return result


def _difference(values: Callable[[float], Array], at: Beside, step: float) -> Array:
    """The difference of order 4; exactly zero of what does not change: weights add up to zero but for round-off."""
    found = np.array([values(place * step) for place in at.places])
    result: Array = np.asarray(at.weights) @ (found - found[0]) / step
    return result


def agreed(values: Callable[[float], Array], at: Beside, name: str) -> Array:
    """The derivative by differences of order 4. Raises RequestError where two steps disagree."""
    try:
        first, second = (_difference(values, at, h) for h in (at.step, 0.5 * at.step))
    except LamcError as error:
        why = str(error).removeprefix(f"there is no derivative by {name!r}: ")
        raise RequestError(f"there is no derivative by {name!r}: {why}") from error
    size = max(float(np.max(np.abs(second), initial=0.0)), 1e-300)
    if not np.all(np.abs(first - second) <= AGREE * size):
        raise RequestError(
            f"there is no derivative by {name!r}: what follows from it jumps beside its value, by differences of "
            f"{abs(at.step):.3g} and half of it"
        )
    result: Array = np.asarray(second)
    return result
