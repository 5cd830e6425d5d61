"""Plans: which points a study visits, by number.

In: axes by name, and how they are combined: as a grid, as samples, as a table of points. Out: a `Grid`, which is never
written out, or `Points`. Samples follow from their seed, so that the same plan gives the same points.
Saltelli's plan serves Sobol' indices (Saltelli et al. 2010, Comput. Phys. Commun. 181, 259-270, table 2).
"""

import csv
import hashlib
import io
import math
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from types import MappingProxyType
from typing import Any

import numpy as np

from lamc.basics.checks import did_you_mean, is_list, shown
from lamc.basics.errors import DesignError, Place, RequestError
from lamc.basics.files import read_bytes
from lamc.run.request import Array
from lamc.studies.axes import Axis, Listed, Span, Spread, number_of

METHODS = ("lhs", "sobol", "halton", "random", "saltelli")
MOST_SAMPLES = 10_000_000  # that are held in memory
_MOST_BYTES = 500_000_000


@dataclass(frozen=True)
class Grid:
    """All combinations of the axes; the last changes fastest."""

    axes: Mapping[str, Span | Listed]

    @property
    def names(self) -> tuple[str, ...]:
        return tuple(self.axes)

    @property
    def shape(self) -> tuple[int, ...]:
        return tuple(len(axis) for axis in self.axes.values())

    @property
    def count(self) -> int:
        return math.prod(self.shape)

    def point(self, index: int) -> tuple[float, ...]:
        values = []
        for axis in reversed(tuple(self.axes.values())):
            index, k = divmod(index, len(axis))
            values.append(axis.value(k))
        return tuple(reversed(values))

    def order(self, slow: Collection[str]) -> Iterator[int]:
        """All numbers of points, such that the names `slow` change as seldom as can be."""
        strides = [math.prod(self.shape[k + 1 :]) for k in range(len(self.shape))]
        steps = {
            name: range(0, stride * length, stride)
            for name, stride, length in zip(self.names, strides, self.shape, strict=True)
        }
        outer = [steps[name] for name in self.names if name in slow]
        inner = [steps[name] for name in self.names if name not in slow]
        for first in _combined(outer):
            yield from (first + second for second in _combined(inner))

    def data(self) -> dict[str, Any]:
        """The plan in JSON's own types."""
        return {"kind": "grid", "axes": {name: _axis_data(axis) for name, axis in self.axes.items()}}


@dataclass(frozen=True, eq=False)
class Points:
    """Points one by one. values: (n, names); how: what they come from, in JSON's own types."""

    names: tuple[str, ...]
    values: Array
    how: Mapping[str, Any] = field(default_factory=dict)

    @property
    def count(self) -> int:
        return len(self.values)

    def point(self, index: int) -> tuple[float, ...]:
        return tuple(self.values[index].tolist())

    def order(self, slow: Collection[str]) -> Iterator[int]:
        """As of `Grid`."""
        columns = [self.values[:, k] for k, name in enumerate(self.names) if name in slow]
        if not columns:
            return iter(range(self.count))
        return iter(np.lexsort(columns).tolist())

    def data(self) -> dict[str, Any]:
        return {"kind": "points", **self.how}


Plan = Grid | Points


def _combined(steps: Sequence[range]) -> Iterator[int]:
    """Sums of one of each; without what `itertools.product` does first, which is to hold every range as a tuple."""
    if not steps:
        yield 0
        return
    if len(steps) == 1:
        yield from steps[0]
        return
    for first in steps[0]:
        yield from (first + rest for rest in _combined(steps[1:]))


def _axis_data(axis: Axis) -> Any:
    if isinstance(axis, Listed):
        return list(axis.values)
    if isinstance(axis, Span):
        return {"from": axis.start, "to": axis.stop, "count": axis.count, "log": axis.log}
    return {axis.kind: list(axis.numbers)}


def grid_of(axes: Mapping[str, Axis]) -> Grid:
    """The grid of axes. Raises RequestError for an axis without a count."""
    found: dict[str, Span | Listed] = {}
    for name, axis in axes.items():
        if isinstance(axis, Spread) or (isinstance(axis, Span) and axis.count == 0):
            what = "a distribution" if isinstance(axis, Spread) else "a range without a count"
            raise RequestError(
                f"vary {name!r}: {what} makes no grid; write FROM:TO:COUNT, or ask for samples: --sample lhs:200"
            )
        found[name] = axis
    return Grid(found)


def sampled(axes: Mapping[str, Axis], method: str, count: int, seed: int) -> Points:
    """`count` samples of the axes. Of "saltelli" they are two sets of samples and, for each name, the first set
    with the column of this name from the second: count (names + 2) points. Raises RequestError."""
    if method not in METHODS:
        raise RequestError(f"no way to sample is named {method!r}; {did_you_mean(method, METHODS)}")
    if isinstance(seed, bool) or not isinstance(seed, int) or seed < 0:
        raise RequestError(f"the seed is {shown(seed)}; it must be a whole number, 0 or more")
    size = count * (len(axes) + 2) if method == "saltelli" else count
    if not 1 <= size <= MOST_SAMPLES:
        raise RequestError(f"{size} samples are asked for; 1 to {MOST_SAMPLES} can be drawn")
    if method in ("sobol", "saltelli") and count & (count - 1):
        raise RequestError(
            f"{count} samples of Sobol's sequence are unbalanced; take a power of 2, {2 ** count.bit_length()}"
        )
    unit = _unit_samples(method, len(axes), count, seed)
    columns = [_quantiles(name, axis, unit[:, k]) for k, (name, axis) in enumerate(axes.items())]
    if method == "saltelli":
        second = [_quantiles(n, axis, unit[:, len(axes) + k]) for k, (n, axis) in enumerate(axes.items())]
        mixed = [np.column_stack([*columns[:k], second[k], *columns[k + 1 :]]) for k in range(len(axes))]
        values = np.vstack([np.column_stack(columns), np.column_stack(second), *mixed])
    else:
        values = np.column_stack(columns)
    how = {
        "sample": method,
        "count": count,
        "seed": seed,
        "axes": {n: _axis_data(a) for n, a in axes.items()},
    }
    return _points(tuple(axes), values, how)


def _unit_samples(method: str, names: int, count: int, seed: int) -> Array:
    """Samples (count, names) of the unit cube, open; two sets side by side of "saltelli"."""
    from scipy.stats import qmc

    if method == "random":
        drawn = np.random.default_rng(seed).random((count, names))
    elif method == "lhs":
        drawn = qmc.LatinHypercube(names, seed=seed).random(count)
    elif method == "halton":
        drawn = qmc.Halton(names, seed=seed).random(count)
    else:
        drawn = qmc.Sobol(names * (2 if method == "saltelli" else 1), seed=seed).random(count)
    least = np.finfo(float).eps  # a distribution without bounds has no quantile of 0 and of 1
    found: Array = np.clip(drawn, least, 1.0 - least)
    return found


def _quantiles(name: str, axis: Axis, parts: Array) -> Array:
    if isinstance(axis, Listed):
        raise RequestError(
            f"vary {name!r}: samples are drawn from a range, FROM:TO, or a distribution; a list makes a grid"
        )
    return axis.quantiles(parts)


def given_points(given: object, units: Mapping[str, str]) -> Points:
    """Points of columns by name, or of rows of a CSV file whose first line names the columns. Raises RequestError, and
    DesignError with the line of a file."""
    if isinstance(given, str | Path):
        return _from_csv(Path(given), units)
    if not isinstance(given, Mapping) or not given or not all(is_list(each) for each in given.values()):
        raise RequestError(
            f"points is {shown(given)}; it must be a CSV file, or map names to lists of equal length"
        )
    columns = []
    for name, values in given.items():
        _known(name, units)
        columns.append([number_of(name, each, units[name]) for each in values])
    if len({len(column) for column in columns}) != 1 or not columns[0]:
        raise RequestError(
            f"lists of points have lengths {[len(c) for c in columns]}; they must be equal, and not 0"
        )
    return _points(tuple(given), np.column_stack([np.array(c, dtype=np.float64) for c in columns]))


def _known(name: str, units: Mapping[str, str]) -> None:
    if name not in units:
        raise RequestError(
            f"nothing that can be varied is named {shown(name)}; {did_you_mean(str(name), list(units))}"
        )


def _points(names: tuple[str, ...], values: Array, how: Mapping[str, Any] = MappingProxyType({})) -> Points:
    digest = hashlib.sha256(np.ascontiguousarray(values).tobytes()).hexdigest()
    return Points(names, values, {**how, "names": list(names), "count": len(values), "sha256": digest})


def _from_csv(path: Path, units: Mapping[str, str]) -> Points:
    data = read_bytes(path, _MOST_BYTES)
    try:
        text = data.decode("utf-8-sig")
        between = _separator(text)
        lines = csv.reader(io.StringIO(text, newline=""), delimiter=between)
        rows = [(lines.line_num, row) for row in lines if any(cell.strip() for cell in row)]
    except (UnicodeDecodeError, csv.Error) as error:
        raise DesignError(f"this is no CSV in UTF-8: {error}", Place(str(path))) from error
    if len(rows) < 2:
        raise DesignError(
            "a file of points has a line of names and a line for each point", Place(str(path), 1)
        )
    heads = [_head(cell, units) for cell in rows[0][1]]
    names = tuple(name for name, _ in heads)
    try:
        for name in names:
            _known(name, units)
        if len(set(names)) != len(names):
            raise RequestError("a name stands twice in the first line")
    except RequestError as error:
        raise DesignError(error.message, Place(str(path), rows[0][0])) from error
    values = np.empty((len(rows) - 1, len(names)))
    for k, (line, cells) in enumerate(rows[1:]):
        if len(cells) != len(names):
            raise DesignError(f"{len(cells)} values stand under {len(names)} names", Place(str(path), line))
        for c, ((name, unit), given) in enumerate(zip(heads, cells, strict=True)):
            cell = given.replace(",", ".") if between == ";" else given  # decimal commas
            bare = unit and not any(ch.isalpha() and ch not in "eE" for ch in cell)
            try:
                values[k, c] = number_of(name, f"{cell} {unit}" if bare else cell, units[name])
            except RequestError as error:
                raise DesignError(error.message, Place(str(path), line, c + 1)) from error
    return _points(names, values)


def _separator(text: str) -> str:
    """What stands between the names of the first line: a comma, or a semicolon or tab where there are more of these."""
    first = next((line for line in text.splitlines() if line.strip()), "")
    return max(",;\t", key=first.count)


def _head(cell: str, known: Mapping[str, str]) -> tuple[str, str]:
    """Name and unit of "length (mm)" or "length[mm]"; the unit may be missing. known: names, which may end in a bracket
    themselves."""
    whole = cell.strip()
    for left, right in ("()", "[]"):
        name, bracket, unit = whole.rpartition(left)
        if name and bracket and unit.endswith(right) and whole not in known:
            return name.strip(), unit[:-1].strip()
    return whole, ""


def sample_words(text: str) -> tuple[str, int]:
    """Method and count of "lhs:200". Raises RequestError."""
    method, _, count = text.strip().partition(":")
    if not (count.isascii() and count.isdigit() and len(count) <= 15):
        raise RequestError(
            f"--sample {text!r}: write METHOD:COUNT, such as lhs:200; methods are {', '.join(METHODS)}"
        )
    return method, int(count)
