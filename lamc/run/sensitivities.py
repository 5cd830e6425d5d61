"""Derivatives of a run by parameters of the scene, dimensions of the design and its start.

In: a simulator, names, values of parameters. Out: a model that carries derivatives, and what a run is to be
differentiated by. Never: integrates.

Names are those of `Simulator.parameters`, of `Design.parameters`, "angles.JOINT" and "rates.JOINT". Derivatives of the
equations are exact. How a drawing's numbers, and a start that loops close, follow from a dimension is known by
differences of order 4, within declared bounds, of what splitting and closing give, some 1e-10 of them; where two steps
of differences disagree, as a vanishing edge makes them, the name is refused.
"""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from lamc.basics.checks import did_you_mean
from lamc.basics.errors import RequestError
from lamc.mechanics.tangents import PACE, Columns, parameter_key
from lamc.run.derivatives import ANGLES, RATES, NoDerivative, Sensitivities, Shifted
from lamc.run.model import Model, Motion
from lamc.run.request import BETWEEN_STEPS, UNFOLLOWED, Along, Array
from lamc.run.start_slopes import STEP, Beside, agreed, beside, slope_of_start
from lamc.symbolic.staging import DrawnKey

if TYPE_CHECKING:
    from lamc.records.design import Design
    from lamc.records.mechanism import Mechanism
    from lamc.run.simulator import Simulator

Keys = tuple[DrawnKey, ...]
WHY = {
    1: "several events fall on one instant, and another value takes them in another order",
    2: "a limit is touched and not passed",
    3: "loops lose equations at a singular position",
    4: "derivatives grow beyond all numbers, or change faster than a step of the run can be parted for (a stiff "
    "integrator, or max_step, follows them)",
    BETWEEN_STEPS: "a switch falls between two steps of scipy's integrator; lamc's own end steps at switches",
    UNFOLLOWED: "a step of scipy's integrator could not be followed; take one of lamc's own",
}


@dataclass(frozen=True, eq=False)
class Differentiated:
    """A motion that carries derivatives. order: which column of the run belongs to which name."""

    motion: Motion
    along: Along
    names: tuple[str, ...]
    order: tuple[int, ...]
    shifted: Callable[[str], tuple[Shifted, ...]]
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
    asked = checked_names(simulator, names)
    if not asked:
        return None
    columns = Columns(
        tuple(n for n in asked if n in simulator.parameters),
        tuple(n for n in asked if _is_dimension(simulator, n)),
    )
    starts = tuple(name for name in asked if name not in columns.names)
    model, keys = simulator.with_columns(columns)
    paces = {
        name: pace_of(simulator, name, lambda each: each.with_columns(columns)) for name in columns.dimensions
    }
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
        start[:, k] = paces[name].start if name in paces else slope_of_start(simulator, name)
    order = [(*columns.names, *starts).index(name) for name in asked]
    shifted = _Shifts(simulator, dict(parameters), {name: pace.beside for name, pace in paces.items()})
    along = Along(motion.parameters, directions, np.ascontiguousarray(start))
    values = dict(zip(model.parameters, motion.parameters.tolist(), strict=False))
    values |= {name: _source(simulator).parameters[name].default for name in columns.dimensions}
    sizes = tuple(abs(values.get(name, 1.0)) or 1.0 for name in asked)
    return Differentiated(motion, along, asked, tuple(order), shifted, sizes)


def checked_names(simulator: "Simulator", names: object, word: str = "sensitivities") -> tuple[str, ...]:
    """Names by which a run is differentiated; word: what the caller knows them by. Raises RequestError."""
    asked = tuple(names) if isinstance(names, Iterable) and not isinstance(names, str) else None
    if asked is None or not all(isinstance(name, str) for name in asked):
        raise RequestError(f"{word} is {names!r}; it must be a list of names, such as ['h1.stiffness']")
    starts = [f"{prefix}{joint}" for joint in simulator.joints for prefix in (ANGLES, RATES)]
    for name in asked:
        if name not in simulator.parameters and name not in starts and not _is_dimension(simulator, name):
            known = [*simulator.parameters, *_dimensions(simulator), *starts]
            raise RequestError(f"no run is differentiated by {name!r}; {did_you_mean(name, known)}")
    if len(set(asked)) < len(asked):
        raise RequestError(f"{word} is {list(asked)!r}; every name may stand there once")
    return asked


def _source(simulator: "Simulator") -> "Design | Mechanism":
    """What has dimensions: the drawing, or a mechanism made without one."""
    return simulator.mechanism.design or simulator.mechanism


def _dimensions(simulator: "Simulator") -> tuple[str, ...]:
    return tuple(_source(simulator).parameters)


def _is_dimension(simulator: "Simulator", name: str) -> bool:
    return name not in simulator.parameters and name in _dimensions(simulator)


# ---- Dimensions ------------------------------------------------------------------------------------------------------


@dataclass(frozen=True, eq=False)
class Pace:
    """How a design follows from a dimension.

    inputs   (inputs,): derivatives of what `setup` is given
    start    (nq + nu,): of the start
    beside   where differences looked
    """

    inputs: Array
    start: Array
    beside: Beside


def _beside(simulator: "Simulator", name: str) -> Beside:
    """Where differences by a dimension look: within its declared bounds, where drawings are."""
    told = _source(simulator).parameters[name]
    return beside(told.default, told.minimum, told.maximum)


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


def pace_of(simulator: "Simulator", name: str, modelled: "Callable[[Simulator], tuple[Model, Keys]]") -> Pace:
    """How a design follows from a dimension. modelled: the model with derivatives of a simulator, and the keys of its
    numbers of the drawing."""
    at = _beside(simulator, name)
    model, keys = modelled(simulator)
    count = len(model.parameters) + len(keys)

    def numbers(way: float) -> Array:
        other = _at(simulator, name, way)
        made, there = modelled(other)
        if there != keys:
            raise RequestError(f"there is no derivative by {name!r}: beside its value other numbers count")
        return np.concatenate([made.defaults, made.geometry, other.start])

    found = agreed(numbers, at, name)
    return Pace(found[:count], found[count:], at)


def drawn_beside(simulator: "Simulator", name: str) -> "Iterator[tuple[float, Mechanism]]":
    """Drawings with other values of a dimension, and their parts in a difference."""
    at = _beside(simulator, name)
    for place, weight in zip(at.places, at.weights, strict=True):
        yield weight / at.step, _at(simulator, name, place * at.step).mechanism


def _motion(
    model: Model,
    columns: Columns,
    keys: Keys,
    parameters: Mapping[str, float | str],
    paces: Mapping[str, Pace],
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
    dimensions: Mapping[str, Beside]

    def __call__(self, name: str) -> tuple[Shifted, ...]:
        simulator = self.simulator
        if name in self.dimensions:
            at = self.dimensions[name]
            sims = [_at(simulator, name, place * at.step) for place in at.places]
            made = [(each.mechanism, each.model.motion(self.parameters)) for each in sims]
        else:
            motion, k = simulator.model.motion(self.parameters), simulator.model.parameters.index(name)
            value = float(motion.parameters[k])
            at = Beside(STEP * abs(value) if value else STEP)
            made = []
            for place in at.places:
                moved = motion.parameters.copy()
                moved[k] += place * at.step
                made.append(
                    (simulator.mechanism, Motion(simulator.model, moved, 0.0, motion.following.series))
                )
        return tuple(Shifted(w / at.step, *each) for w, each in zip(at.weights, made, strict=True))
