"""Series: numbers over time, such as a command or a sensor's recording, which an input of a scene follows.

In: times and values, and what holds between and beyond them. Out: checked arrays that cannot change, and the piecewise
polynomial that C looks up. Never: reads a file; knows what the numbers mean.
"""

import hashlib
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np
import numpy.typing as npt

from lamc.basics.checks import did_you_mean, shown
from lamc.basics.errors import DesignError

Array = npt.NDArray[np.float64]

HOLDS = {"previous": 0, "linear": 1, "cubic": 3}  # with the degree of their polynomials
BEYOND = ("refuse", "hold")
MOST_ROWS = 10_000_000
ORDERS = 4  # a value and its first three derivatives: what the equations may read of a series


@dataclass(frozen=True, eq=False)
class Pieces:
    """A piecewise polynomial as C looks it up.

    t           (m,), s, strictly ascending: where rows begin; the first counts before it too, the last behind it
    rows        (m, degree + 1): coefficients by rising power of the time since the row began
    begin, end  s: outside, there is no value; infinite where the first and the last value hold on
    """

    t: Array
    rows: Array
    begin: float
    end: float

    def values(self, t: npt.ArrayLike, order: int = 0) -> Array:
        """The derivative of that order at times t; where a row begins, that of this row. NaN where there is none."""
        times = np.asarray(t, dtype=np.float64)
        row = np.maximum(np.searchsorted(self.t, times, side="right") - 1, 0)
        found = self._at(row, times - self.t[row], order)
        return np.where((times >= self.begin) & (times <= self.end), found, np.nan)

    def jumps(self, order: int) -> Array:
        """By how much the derivative of that order changes where rows begin, (m - 1,), but for the first."""
        left = np.arange(len(self.t) - 1)
        return self._at(left + 1, np.zeros(len(left)), order) - self._at(left, np.diff(self.t), order)

    def _at(self, row: npt.NDArray[np.int64], after: Array, order: int) -> Array:
        total = np.zeros(np.shape(after))
        for power in range(self.rows.shape[1] - 1, order - 1, -1):
            factor = float(np.prod(np.arange(power, power - order, -1))) if order else 1.0
            total = total * after + factor * self.rows[row, power]
        return total


@dataclass(frozen=True, eq=False, repr=False)
class Series:
    """Values over time.

    t       (n,), s, strictly ascending
    values  (n,), in the unit of the input that follows them
    hold    what is between them: "previous" (each value until the next: the command of a digital controller), "linear",
            or "cubic" (the spline whose second derivative is continuous; not-a-knot ends, as in scipy and MATLAB; what
            is differentiated twice, such as the motion of a base, needs it)
    beyond  before the first time and after the last: "refuse" a run that reaches there, or "hold" the first and the
            last value; a cubic then begins and ends with no slope

    A run ends a step at each time where the value, or a derivative that counts, changes by more than its tolerance can
    see; see "Inputs over time" in the guide.

    Raises DesignError for times that run backwards or repeat, for NaN, and for what are no two rows of one length.
    """

    t: Array
    values: Array
    hold: str = "linear"
    beyond: str = "refuse"
    source: str = field(default="", compare=False)  # the file that it was read from, as it was said there

    def __post_init__(self) -> None:
        _check_word(self.hold, HOLDS, "hold")
        _check_word(self.beyond, BEYOND, "beyond")
        t, values = _numbers(self.t, "t"), _numbers(self.values, "values")
        if len(t) != len(values):
            raise DesignError(
                f"a series has {len(t)} times and {len(values)} values; each time needs one value"
            )
        least = 1 if self.beyond == "hold" else 2
        if len(t) < least:
            raise DesignError(f"a series has {len(t)} rows; give {least} at least")
        if len(t) > MOST_ROWS:
            raise DesignError(f"a series has {len(t)} rows; at most {MOST_ROWS} are taken: thin it out")
        if (back := first_not_after(t)) is not None:
            raise DesignError(f"t[{back}] = {t[back]:.9g} s of a series {disorder(t, back)}")
        object.__setattr__(self, "t", t)
        object.__setattr__(self, "values", values)

    @classmethod
    def constant(cls, value: float) -> "Series":
        """The series that has this value at all times."""
        return cls(np.zeros(1), np.array([value]), "previous", "hold")

    def __repr__(self) -> str:
        said = f", from {self.source!r}" if self.source else ""
        beyond = ", hold beyond" if self.beyond == "hold" else ""
        return f"<Series of {len(self.t)} rows, {self.t[0]:g} … {self.t[-1]:g} s, {self.hold}{beyond}{said}>"

    def __eq__(self, other: object) -> bool:
        return self.digest == other.digest if isinstance(other, Series) else NotImplemented

    def __hash__(self) -> int:
        return hash(self.digest)

    def __getstate__(self) -> dict[str, Any]:
        return {name: getattr(self, name) for name in ("t", "values", "hold", "beyond", "source")}

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__dict__.update(state)
        for name in ("t", "values"):
            self.__dict__[name].flags.writeable = False

    @cached_property
    def digest(self) -> str:
        """Of times, values and what holds between and beyond them, hexadecimal."""
        text = hashlib.sha256(f"{self.hold} {self.beyond} {len(self.t)}\n".encode())
        text.update(self.t.tobytes())
        text.update(self.values.tobytes())
        return text.hexdigest()

    @property
    def degree(self) -> int:
        """Of the polynomials between the times."""
        return HOLDS[self.hold]

    @property
    def smoothness(self) -> int:
        """The highest derivative that is finite everywhere."""
        return 2 if self.hold == "cubic" and self.beyond == "hold" else self.degree

    @cached_property
    def pieces(self) -> Pieces:
        """The polynomials, as C looks them up."""
        t, rows = self.t, _rows(self)
        if self.beyond == "refuse":
            kept = t if self.hold == "previous" else t[:-1]
            return _frozen(kept, rows, float(t[0]), float(t[-1]))
        ends = np.zeros((2, rows.shape[1]))
        ends[:, 0] = self.values[[0, -1]]
        inner = rows[: len(t) - 1]  # of "previous" the last row is the end already
        times = np.concatenate([[t[0] - 1.0], t])
        return _frozen(times, np.concatenate([ends[:1], inner, ends[1:]]), -np.inf, np.inf)

    def at(self, t: npt.ArrayLike, order: int = 0) -> Array:
        """The value, or its derivative of that order by time, at times t (…), s; NaN where there is none."""
        return self.pieces.values(t, order)


def first_not_after(t: Array) -> int | None:
    """The first place whose time is not after the one before it."""
    back = np.flatnonzero(np.diff(t) <= 0.0)
    return int(back[0]) + 1 if len(back) else None


def disorder(t: Array, place: int) -> str:
    """What is wrong with the time at `place`, in words."""
    before = f"t[{place - 1}] = {t[place - 1]:.9g} s"
    if t[place] == t[place - 1]:
        return f"repeats {before}; two values at one time are a jump: take one of them away"
    return f"is before {before}; time must ascend: sort the rows, or take the earlier part away"


def _check_word(word: object, known: Any, what: str) -> None:
    if not isinstance(word, str) or word not in known:
        hint = did_you_mean(word, known) if isinstance(word, str) else f"there are {', '.join(known)}"
        raise DesignError(f"{what} of a series is {shown(word)}; {hint}")


def _numbers(given: object, what: str) -> Array:
    try:
        array = np.array(given, dtype=np.float64, order="C")
    except (TypeError, ValueError) as error:
        raise DesignError(f"{what} of a series is {shown(given)}; it must be a row of numbers") from error
    if array.ndim != 1:
        raise DesignError(f"{what} of a series has shape {array.shape}; it must be a row, (n,)")
    bad = np.flatnonzero(~np.isfinite(array))
    if len(bad):
        places = ", ".join(map(str, bad[:5])) + (", …" if len(bad) > 5 else "")
        raise DesignError(
            f"{what} of a series holds {array[bad[0]]} at {places} ({len(bad)} of {len(array)}); leave gaps out to "
            "have them bridged: keep = np.isfinite(values); lamc.Series(t[keep], values[keep])"
        )
    array.flags.writeable = False
    return array


def _rows(series: Series) -> Array:
    """Coefficients: of "previous" (n, 1), else (n - 1, degree + 1)."""
    t, values = series.t, series.values
    if series.hold == "previous":
        return values.reshape(-1, 1)
    if len(t) == 1:
        return np.zeros((0, series.degree + 1))
    if series.hold == "linear":
        return np.column_stack([values[:-1], np.diff(values) / np.diff(t)])
    from scipy.interpolate import CubicSpline  # a third of a second to load, and few series need it

    ends = "clamped" if series.beyond == "hold" else "not-a-knot"
    made: Array = CubicSpline(t, values, bc_type=ends).c[::-1].T
    return made


def _frozen(t: Array, rows: Array, begin: float, end: float) -> Pieces:
    t, rows = np.ascontiguousarray(t), np.ascontiguousarray(rows)
    t.flags.writeable = rows.flags.writeable = False
    return Pieces(t, rows, begin, end)
