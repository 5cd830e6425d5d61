"""Derivatives of a run by parameters of the scene, dimensions of the design and its start.

In: a simulator, names, values of parameters. Out: a model that carries derivatives, and what a run is to be
differentiated by; then the derivatives of anything that a result tells. Never: integrates.

Names are those of `Simulator.parameters`, of `Design.parameters`, "angles.JOINT" and "rates.JOINT". Derivatives of the
equations are exact. How a drawing's numbers, and a start that loops close, follow from a dimension is known by
differences of order 4 of what splitting and closing give, some 1e-10 of them; where two steps of differences disagree,
as a vanishing edge makes them, the name is refused.
"""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

import numpy as np

from lamc.basics.checks import did_you_mean
from lamc.basics.errors import LamcError, RequestError
from lamc.mechanics.tangents import PACE, Columns, parameter_key
from lamc.records.mechanism import Mechanism
from lamc.run.model import Model, Motion
from lamc.run.request import BETWEEN_STEPS, UNFOLLOWED, Along, Array
from lamc.symbolic.staging import DrawnKey

if TYPE_CHECKING:
    from lamc.records.design import Design
    from lamc.run.result import Result
    from lamc.run.simulator import Simulator

Keys = tuple[DrawnKey, ...]
ANGLES, RATES = "angles.", "rates."
STEP = 1e-3  # of a number, or of a radian: differences of order 4 then err by 1e-12 of it, and round-off by 1e-13
# Two steps agree to so much of the largest number where the numbers are smooth: closing loops knows a start to 1e-12 or
# so, which differences over 1e-3 make 1e-9.
AGREE = 1e-7
PLACES, WEIGHTS = (-2.0, -1.0, 1.0, 2.0), (1.0 / 12.0, -2.0 / 3.0, 2.0 / 3.0, -1.0 / 12.0)
HORIZON = (
    1e-2  # of a range: what a run at its tolerance may be off before its derivatives are of another motion
)
WHY = {
    1: "several events fall on one instant, and another value takes them in another order",
    2: "a limit is touched and not passed",
    3: "loops lose equations at a singular position",
    4: "derivatives grow beyond all numbers",
    BETWEEN_STEPS: "a switch falls between two steps of scipy's integrator; lamc's own end steps at switches",
    UNFOLLOWED: "a step of scipy's integrator could not be followed; take one of lamc's own",
}


@dataclass(frozen=True)
class NoDerivative:
    """From t, s, on there are no derivatives. reason: why, in words."""

    t: float
    reason: str


@dataclass(frozen=True, eq=False)
class Sensitivities:
    """Derivatives of the states of a run.

    names   p of them
    values  (m, nq + nu, p): of coordinates, then rates, at each row, by each name, in SI units; NaN where there are
            none
    lost    since when there are none; None: there are everywhere
    sizes   (p,): of the numbers themselves, SI; 1 where one is zero
    """

    names: tuple[str, ...]
    values: Array
    lost: NoDerivative | None = None
    sizes: tuple[float, ...] = ()
    _shifted: "Callable[[str], tuple[_Shifted, ...]] | None" = field(default=None, repr=False)

    def of(self, result: "Result", output: str, name: str) -> Array:
        """d output / d name at the rows, shape (m,), SI. Raises KeyError for names that are not there."""
        if name not in self.names:
            raise KeyError(f"the run was not differentiated by {name!r}; {did_you_mean(name, self.names)}")
        column = self.values[:, :, self.names.index(name)]
        nq = result.q.shape[1]
        if output in result.joints:
            return column[:, result.joints.index(output)]
        known = [c.name for c in result.coordinates]
        if output in known:
            return column[:, known.index(output)]
        joint = output.removesuffix(".rate")
        if joint in result.joints and joint != output:
            return column[:, nq + result.joints.index(joint)]
        return self._along(result, output, column) + self._beside(result, output, name)

    def horizon(self, result: "Result") -> tuple[float, str] | None:
        """Since when, s, and by which name, a change of a number by the tolerance of the run moves the state by more
        than a hundredth of its range: in chaotic motion, where derivatives tell no finite change. None: nowhere."""
        reach = HORIZON * np.ptp(result.y, axis=1)[None, :, None] / result.stats.rtol
        moved = np.abs(self.values) * np.array(self.sizes or (1.0,) * len(self.names))
        beyond = np.any(moved > np.where(reach > 0.0, reach, np.inf), axis=1)  # (m, p)
        rows = np.flatnonzero(beyond.any(axis=1))
        if not len(rows):
            return None
        return float(result.t[rows[0]]), self.names[int(np.argmax(beyond[rows[0]]))]

    def _along(self, result: "Result", output: str, column: Array) -> Array:
        """Of an output as a function of the state, by differences along the column, a hundredth of a radian at most."""
        reach = 1e-2 / np.maximum(np.nanmax(np.abs(column), axis=1, initial=0.0), 1e-300)
        moved = reach[:, None] * column
        nq, total = result.q.shape[1], np.zeros(len(result.t))
        for place, weight in zip((-3, -2, -1, 1, 2, 3), (-1, 9, -45, 45, -9, 1), strict=True):
            at = replace(
                result,
                q=result.q + place * moved[:, :nq],
                u=result.u + place * moved[:, nq:],
                sensitivities=None,
            )
            total += weight / 60.0 * at.quantity(output).values
        return np.where(np.isfinite(reach), total / reach, 0.0)

    def _beside(self, result: "Result", output: str, name: str) -> Array:
        """Of an output at a given state: points of bodies and loads follow from dimensions and parameters too."""
        if self._shifted is None or name.startswith((ANGLES, RATES)):
            return np.zeros(len(result.t))
        total = np.zeros(len(result.t))
        for each in self._shifted(name):
            at = replace(result, mechanism=each.mechanism, motion=each.motion, sensitivities=None)
            total += each.weight * at.quantity(output).values
        return total


@dataclass(frozen=True, eq=False)
class _Shifted:
    """The same device with another value, and its part in a difference."""

    weight: float
    mechanism: Mechanism
    motion: Motion


@dataclass(frozen=True, eq=False)
class Differentiated:
    """A motion that carries derivatives. order: which column of the run belongs to which name."""

    motion: Motion
    along: Along
    names: tuple[str, ...]
    order: tuple[int, ...]
    shifted: Callable[[str], tuple[_Shifted, ...]]
    sizes: tuple[float, ...]

    def sensitivities(self, values: Array, lost: tuple[float, int, int] | None) -> Sensitivities:
        guards = self.motion.model.guards
        told = None
        if lost is not None:
            at, why, guard = lost
            told = NoDerivative(at, WHY[why] + (f" ({guards[guard]!r})" if guard >= 0 else ""))
        return Sensitivities(self.names, values[:, :, list(self.order)], told, self.sizes, self.shifted)


def differentiated(
    simulator: "Simulator",
    names: Sequence[str],
    parameters: Mapping[str, float | str],
    baumgarte: float = 0.0,
) -> Differentiated | None:
    """What `Simulator.run(sensitivities=names)` runs; None without names. Raises RequestError for names of nothing."""
    asked = _checked(simulator, names)
    if not asked:
        return None
    columns = Columns(
        tuple(n for n in asked if n in simulator.parameters),
        tuple(n for n in asked if _is_dimension(simulator, n)),
    )
    starts = tuple(name for name in asked if name not in columns.names)
    model, keys = simulator.with_columns(columns)
    paces = {name: _pace(simulator, model, columns, keys, name) for name in columns.dimensions}
    motion = _motion(model, columns, keys, parameters, paces, baumgarte)
    directions = np.zeros((max(len(columns.names), 1), max(len(motion.parameters), 1)))
    place = {name: k for k, name in enumerate(model.parameters)}
    given = {place[name] for name in parameters if name in place}
    for row, name in enumerate(columns.parameters):
        directions[row, place[name]] = 1.0
    for row, name in enumerate(columns.dimensions, len(columns.parameters)):
        directions[row] = paces[name].inputs
        directions[row, sorted(given)] = 0.0  # what is given does not follow from the drawing
    start = np.zeros((model.state_size, len(asked)))
    for k, name in enumerate((*columns.names, *starts)):
        start[:, k] = paces[name].start if name in paces else _of_start(simulator, name)
    order = [(*columns.names, *starts).index(name) for name in asked]
    shifted = _Shifts(simulator, dict(parameters), {name: pace.step for name, pace in paces.items()})
    along = Along(motion.parameters, directions, np.ascontiguousarray(start))
    values = dict(zip(model.parameters, motion.parameters.tolist(), strict=False))
    values |= {name: _source(simulator).parameters[name].default for name in columns.dimensions}
    sizes = tuple(abs(values.get(name, 1.0)) or 1.0 for name in asked)
    return Differentiated(motion, along, asked, tuple(order), shifted, sizes)


def _checked(simulator: "Simulator", names: object) -> tuple[str, ...]:
    asked = tuple(names) if isinstance(names, Iterable) and not isinstance(names, str) else None
    if asked is None or not all(isinstance(name, str) for name in asked):
        raise RequestError(
            f"sensitivities is {names!r}; it must be a list of names, such as ['h1.stiffness']"
        )
    starts = [f"{prefix}{joint}" for joint in simulator.joints for prefix in (ANGLES, RATES)]
    for name in asked:
        if name not in simulator.parameters and name not in starts and not _is_dimension(simulator, name):
            known = [*simulator.parameters, *_dimensions(simulator), *starts]
            raise RequestError(f"no run is differentiated by {name!r}; {did_you_mean(name, known)}")
    if len(set(asked)) < len(asked):
        raise RequestError(f"sensitivities is {list(asked)!r}; every name may stand there once")
    return asked


def _source(simulator: "Simulator") -> "Design | Mechanism":
    """What has dimensions: the drawing, or a mechanism made without one."""
    return simulator.mechanism.design or simulator.mechanism


def _dimensions(simulator: "Simulator") -> tuple[str, ...]:
    return tuple(_source(simulator).parameters)


def _is_dimension(simulator: "Simulator", name: str) -> bool:
    return name not in simulator.parameters and name in _dimensions(simulator)


# ---- Starts ----------------------------------------------------------------------------------------------------------


def _of_start(simulator: "Simulator", name: str) -> Array:
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
    return _agreed(start, STEP, name)


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


def _agreed(values: Callable[[float], Array], step: float, name: str) -> Array:
    """The derivative by differences of order 4. Raises RequestError where two steps disagree."""
    try:
        first, second = (
            sum(w * values(p * h) for p, w in zip(PLACES, WEIGHTS, strict=True)) / h
            for h in (step, 0.5 * step)
        )
    except LamcError as error:
        why = str(error).removeprefix(f"there is no derivative by {name!r}: ")
        raise RequestError(f"there is no derivative by {name!r}: {why}") from error
    size = max(float(np.max(np.abs(second), initial=0.0)), 1e-300)
    if not np.all(np.abs(first - second) <= AGREE * size):
        raise RequestError(
            f"there is no derivative by {name!r}: what follows from it jumps beside its value, by differences of "
            f"{step:.3g} and half of it"
        )
    result: Array = np.asarray(second)
    return result


# ---- Dimensions ------------------------------------------------------------------------------------------------------


@dataclass(frozen=True, eq=False)
class _Pace:
    """How a design follows from a dimension.

    inputs   (inputs,): derivatives of what `setup` is given
    start    (nq + nu,): of the start
    step     of the dimension, SI
    """

    inputs: Array
    start: Array
    step: float


def _at(simulator: "Simulator", name: str, way: float) -> "Simulator":
    """The simulator of the design with a dimension changed by `way`. Raises RequestError where it is another device."""
    design = _source(simulator)
    value = design.parameters[name].default + way
    other = simulator.with_design(design.with_parameters({name: value}))
    if other.structure != simulator.structure:
        raise RequestError(
            f"there is no derivative by {name!r}: beside {design.parameters[name].default:.9g} the design has another "
            "structure, as where an offset vanishes; take another value"
        )
    return other


def _pace(simulator: "Simulator", model: Model, columns: Columns, keys: Keys, name: str) -> _Pace:
    design = _source(simulator)
    value = design.parameters[name].default
    step = STEP * abs(value) if value else STEP
    count = len(model.parameters) + len(keys)

    def numbers(way: float) -> Array:
        other = _at(simulator, name, way)
        made, there = other.with_columns(columns)
        if there != keys:
            raise RequestError(f"there is no derivative by {name!r}: beside its value other numbers count")
        return np.concatenate([made.defaults, made.geometry, other.start])

    found = _agreed(numbers, step, name)
    return _Pace(found[:count], found[count:], step)


def _motion(
    model: Model,
    columns: Columns,
    keys: Keys,
    parameters: Mapping[str, float | str],
    paces: Mapping[str, _Pace],
    baumgarte: float,
) -> Motion:
    """The motion with these parameters, which also knows how fast the drawing's numbers move along each dimension."""
    motion = model.motion(parameters, baumgarte)
    if not paces:
        return motion
    inputs, first = motion.parameters.copy(), len(model.parameters)
    place = {parameter_key(name): k for k, name in enumerate(model.parameters)}
    place |= {key: first + k for k, key in enumerate(keys)}
    given = {parameter_key(name) for name in parameters}
    for key, k in place.items():
        if key[0] == PACE and key[2:] not in given:
            inputs[k] = paces[str(key[1])].inputs[place[key[2:]]]
    return Motion(model, inputs, baumgarte, motion.following.series)


@dataclass(frozen=True, eq=False)
class _Shifts:
    """Makes devices with other values of a name; it can be pickled where its simulator can."""

    simulator: "Simulator"
    parameters: Mapping[str, float | str]
    steps: Mapping[str, float]  # of dimensions

    def __call__(self, name: str) -> tuple[_Shifted, ...]:
        simulator = self.simulator
        if name in self.steps:
            step = self.steps[name]
            sims = [_at(simulator, name, place * step) for place in PLACES]
            made = [(each.mechanism, each.model.motion(self.parameters)) for each in sims]
        else:
            motion, k = simulator.model.motion(self.parameters), simulator.model.parameters.index(name)
            value = float(motion.parameters[k])
            step = STEP * abs(value) if value else STEP
            made = []
            for place in PLACES:
                moved = motion.parameters.copy()
                moved[k] += place * step
                made.append(
                    (simulator.mechanism, Motion(simulator.model, moved, 0.0, motion.following.series))
                )
        return tuple(_Shifted(w / step, *each) for w, each in zip(WEIGHTS, made, strict=True))
