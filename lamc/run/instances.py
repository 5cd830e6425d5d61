"""What the instances of an ensemble start from: parameters, angles and rates, each a number or an array.

In: what a user passes, and how a simulator starts. Out: `Instances`, or a RequestError that names the argument, the
instance and the rule. Never: runs anything; fails for one instance whose start alone is no good, which is told with it.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import replace

import numpy as np
import numpy.typing as npt

from lamc.basics.checks import shown
from lamc.basics.errors import LamcError, RequestError
from lamc.basics.si_units import in_unit
from lamc.records.scene import Scene
from lamc.run.ensemble import Instances
from lamc.run.parameters import bounds, checked_parameters
from lamc.run.request import Array, did_you_mean

Values = Mapping[str, npt.ArrayLike]
Columns = Mapping[str, Array]


def columns(
    parameters: Values, angles: Values, rates: Values, units: Mapping[str, str], joints: Sequence[str]
) -> tuple[int, Columns, Columns, Columns]:
    """How many instances there are, and the three arguments by name, each (instances,) or (1,), checked.

    units  of the parameters, by name; joints: that angles and rates may name
    """
    given = {
        "parameters": _arrays(parameters, "parameters", "parameter", units),
        "angles": _arrays(angles, "angles", "joint", dict.fromkeys(joints, "rad")),
        "rates": _arrays(rates, "rates", "joint", dict.fromkeys(joints, "rad/s")),
    }
    lengths = {(what, name): len(v) for what, those in given.items() for name, v in those.items() if v.ndim}
    if len(set(lengths.values())) > 1:
        (first, n), *others = lengths.items()
        other, m = next(entry for entry in others if entry[1] != n)
        raise RequestError(
            f"{first[0]}[{first[1]!r}] has {n} values and {other[0]}[{other[1]!r}] has {m}; arrays must have one value "
            "for each instance, and a single number serves all"
        )
    count = next(iter(lengths.values()), 1)
    made = {what: {name: v.reshape(-1) for name, v in those.items()} for what, those in given.items()}
    for name, values in made["parameters"].items():
        _check_rule(name, values, units)
    return count, made["parameters"], made["angles"], made["rates"]


def _arrays(given: object, argument: str, kind: str, units: Mapping[str, str]) -> dict[str, Array]:
    """Arrays of no or one dimension by name."""
    if not isinstance(given, Mapping):
        raise RequestError(f"{argument} is {shown(given)}; it must map names to numbers or arrays of them")
    return {name: _array(name, value, argument, kind, units) for name, value in given.items()}


def _array(name: object, value: object, argument: str, kind: str, units: Mapping[str, str]) -> Array:
    if name not in units:
        raise RequestError(f"no {kind} is named {shown(name)}; {did_you_mean(str(name), units)}")
    assert isinstance(name, str)
    place = f"{argument}[{name!r}]"
    if isinstance(value, str):
        try:
            value = in_unit(value, units[name], "number")
        except LamcError as error:
            raise RequestError(f"{place}: {error}") from error
    try:
        array = np.array(value, dtype=np.float64)
    except (TypeError, ValueError, OverflowError) as error:
        raise RequestError(
            f"{place} is {shown(value)}; it must be a number or an array in {units[name]}"
        ) from error
    if array.dtype == bool or np.asarray(value).dtype == bool:
        raise RequestError(f"{place} holds truth values; it must be a number or an array in {units[name]}")
    if array.ndim > 1 or array.size == 0:
        raise RequestError(
            f"{place} has shape {array.shape}; it must be a number, or one-dimensional with a value for each "
            "instance"
        )
    bad = np.flatnonzero(~np.isfinite(array.reshape(-1)))
    if bad.size:
        raise RequestError(
            f"{place} is {float(array.reshape(-1)[bad[0]])!r} in instance {int(bad[0])}; it must be finite, in "
            f"{units[name]}"
        )
    return array


def _check_rule(name: str, values: Array, units: Mapping[str, str]) -> None:
    """Raises RequestError for the first value that the parameter cannot have."""
    least, is_open, most = bounds(name)
    bad = np.flatnonzero((values < least) | (values > most) | (is_open & (values == least)))
    if bad.size:
        try:
            checked_parameters({name: float(values[bad[0]])}, units)
        except RequestError as error:
            raise RequestError(f"instance {int(bad[0])}: {error}") from error


def made_instances(
    count: int,
    defaults: Mapping[str, float],
    drawing: Sequence[float],
    parameters: Columns,
    angles: Columns,
    rates: Columns,
    scene: Scene,
    start: Callable[[Scene], Array],
    check: Callable[[Mapping[str, float], Array], None] | None,
    plain: Sequence[str],
) -> Instances:
    """The instances of an ensemble.

    drawing  numbers of the drawing, which the model takes behind its parameters; of all instances
    start  initial state (nq + nu,) of a scene; raises DesignError
    check  raises DesignError for parameters and a start that an effect refuses; None: no effect asks for that
    plain  names of the joints where a state is their angles and rates as they are; empty: it follows from closure, or
           from more
    """
    table = np.array([[*defaults.values(), *drawing] or [0.0]])
    if parameters:
        table = np.repeat(table, count, axis=0)
        names = list(defaults)
        for name, values in parameters.items():
            table[:, names.index(name)] = values
    refusals: dict[int, str] = {}
    if not angles and not rates:
        starts = start(scene).reshape(1, -1)
    elif plain:
        starts = np.repeat(start(scene).reshape(1, -1), count, axis=0)
        for block, columns in ((0, angles), (len(plain), rates)):
            for name, values in columns.items():
                starts[:, block + plain.index(name)] = values
    else:
        starts = _starts(count, angles, rates, scene, start, refusals)
    for k in range(count if check is not None else 0):
        known = dict(zip(defaults, table[k % len(table)].tolist(), strict=False))
        with _noted(refusals, k):
            if k not in refusals and check is not None:
                check(known, starts[k % len(starts)])
    return Instances(count, table, starts, refusals)


def _starts(
    count: int,
    angles: Columns,
    rates: Columns,
    scene: Scene,
    start: Callable[[Scene], Array],
    refusals: dict[int, str],
) -> Array:
    """Starts (count, nq + nu), each found by itself; zeros where one is refused."""
    found: dict[int, Array] = {}
    for k in range(count):
        own = {name: float(v[k % len(v)]) for name, v in angles.items()}
        pace = {name: float(v[k % len(v)]) for name, v in rates.items()}
        with _noted(refusals, k):
            found[k] = start(replace(scene, angles={**scene.angles, **own}, rates={**scene.rates, **pace}))
    if not found:
        raise RequestError(f"no instance can start; the first: {refusals[0]}")
    size = len(next(iter(found.values())))
    return np.array([found.get(k, np.zeros(size)) for k in range(count)])


@contextmanager
def _noted(refusals: dict[int, str], instance: int) -> Iterator[None]:
    """An error within is the instance's own."""
    try:
        yield
    except LamcError as error:
        refusals[instance] = str(error)
