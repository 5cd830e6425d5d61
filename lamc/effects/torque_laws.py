"""Laws of a hinge's restoring torque: a polynomial, an expression, an energy or a table, as functions of the angle.

In: a law as plain data. Out: the staged torque and the energy that it stores, exactly its antiderivative. Never: knows
where the angle comes from, or an effect.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar, Protocol

import numpy as np

from lamc.basics.checks import checked_flag, checked_number, did_you_mean, shown
from lamc.basics.errors import DesignError, ExpressionError
from lamc.basics.readonly import ReadOnlyDict
from lamc.basics.units import ANGLE, Quantity
from lamc.effects.table_file import MAX_ROWS, Rows, read_table
from lamc.mechanics.loads import Loads
from lamc.symbolic.antiderivative import antiderivative
from lamc.symbolic.derivative import derivative
from lamc.symbolic.expression import stage
from lamc.symbolic.piecewise import Piecewise, monotone, spline
from lamc.symbolic.program import Space
from lamc.symbolic.scalars import Scalar, Value
from lamc.symbolic.staging import Store
from lamc.symbolic.substitution import substitute

TORQUE = Quantity("torque", "N*m", "2 N*mm")
MAX_DEGREE = 16
MAX_LOCATED = 50  # each is a guard, which every step evaluates
_ASIDE = 1e-6  # of the next interval
WIDEST_ANGLE = 4.0 * math.pi  # rad; a table that reaches farther is in degrees, in all likelihood
BETWEEN = ("spline", "monotone")
KEYS = ("table", "file", "between", "located", "energy")

LawData = str | tuple[float, ...] | Mapping[str, object]


class Law(Protocol):
    """One hinge's law. `data` is what the law is made from, in its one canonical form."""

    @property
    def data(self) -> LawData: ...

    def staged(self, loads: Loads, joint: str, angle: Value) -> tuple[Scalar, Scalar]:
        """Torque, N·m, that turns the hinge back, and energy, J, zero where the angle is; angle from the rest, rad."""
        ...


@dataclass(frozen=True)
class Polynomial:
    """T = k₁ θ + k₂ θ² + …, k in N·m/radⁿ, each a parameter."""

    coefficients: tuple[float, ...]

    @property
    def data(self) -> LawData:
        return self.coefficients

    def staged(self, loads: Loads, joint: str, angle: Value) -> tuple[Scalar, Scalar]:
        torque: Scalar = 0
        energy: Scalar = 0
        for power, value in reversed([*enumerate(self.coefficients, start=1)]):  # by Horner's rule
            k: Scalar = 0
            if value:
                unit = "N·m/rad" if power == 1 else f"N·m/rad^{power}"
                k = loads.parameter(
                    f"{joint}.stiffness_{power}", value, unit, f"of angle^{power} in the hinge's torque"
                )
            torque, energy = torque * angle + k, energy * angle + k / (power + 1)
        return torque * angle, energy * (angle * angle)


@dataclass(frozen=True)
class Formula:
    """T(angle) by an expression; its energy by the rules of `antiderivative`."""

    text: str

    @property
    def data(self) -> LawData:
        return self.text

    def staged(self, loads: Loads, joint: str, angle: Value) -> tuple[Scalar, Scalar]:
        factor = _factor(loads, joint)
        torque, energy = self.of(angle)
        return factor * torque, factor * energy

    def of(self, angle: Value) -> tuple[Scalar, Scalar]:
        torque = stage(self.text, {"angle": angle})
        energy = antiderivative(torque, angle)
        if energy is None:
            raise ExpressionError(
                f"expression {self.text!r} has no antiderivative that lamc knows; give the energy, J, of which it is "
                "the derivative: {energy: …}"
            )
        return torque, _from_rest(self.text, energy, angle)


@dataclass(frozen=True)
class Energy:
    """T = dW/dangle of an expression for the energy W, J."""

    text: str

    @property
    def data(self) -> LawData:
        return ReadOnlyDict({"energy": self.text})

    def staged(self, loads: Loads, joint: str, angle: Value) -> tuple[Scalar, Scalar]:
        factor = _factor(loads, joint)
        torque, energy = self.of(angle)
        return factor * torque, factor * energy

    def of(self, angle: Value) -> tuple[Scalar, Scalar]:
        energy = stage(self.text, {"angle": angle})
        return derivative(energy, {angle: 1}), _from_rest(self.text, energy, angle)


@dataclass(frozen=True)
class Table:
    """A curve through points (angle, rad; torque, N·m); straight on outside them.

    located  points are events, at which steps end; otherwise integrators step over what is not smooth there
    """

    points: Rows
    between: str = "spline"
    located: bool = False

    curves: ClassVar = {"spline": spline, "monotone": monotone}

    @property
    def data(self) -> LawData:
        return ReadOnlyDict({"table": self.points, "between": self.between, "located": self.located})

    def potential(self) -> Piecewise:
        """The energy, J; the torque is its derivative."""
        angles, torques = zip(*self.points, strict=True)
        return self.curves[self.between](angles, torques).integral()

    @property
    def _passed(self) -> list[float]:
        """Where steps end, rad. A hinge comes to rest at angle 0, and on an event it would come to rest for ever: that
        one lies beside it, by so little that the curve's second derivative does not show."""
        angles = [angle for angle, _ in self.points]
        steps = zip(angles, [*angles[1:], angles[-1] + 1.0], strict=True)
        return [a if a else _ASIDE * (following - a) for a, following in steps]

    def staged(self, loads: Loads, joint: str, angle: Value) -> tuple[Scalar, Scalar]:
        factor, potential, store = _factor(loads, joint), self.potential(), angle.store
        if self.located:
            for number, at in enumerate(self._passed, start=1):
                loads.switch(f"{joint} passes point {number} of its table", angle - at)
        return factor * store.table(potential, angle, 1), factor * store.table(potential, angle)


def _factor(loads: Loads, joint: str) -> Scalar:
    return loads.parameter(f"{joint}.stiffness_factor", 1.0, "1", "what the hinge's torque is multiplied by")


def _from_rest(text: str, energy: Scalar, angle: Value) -> Scalar:
    """The energy less that at rest."""
    (rest,) = substitute([energy], {angle: 0})
    if isinstance(rest, Value) or not math.isfinite(rest):
        raise ExpressionError(f"expression {text!r} has no finite energy at angle 0, where the hinge rests")
    return energy - rest


def law_of(data: object, what: str, folder: Path | None = None) -> Law:
    """The law that plain data describes: coefficients, text, or a map.

    what    e.g. "the stiffness of hinge 'h1'"
    folder  where the names of files count from; None: the current folder

    Raises DesignError and ExpressionError for what is no law.
    """
    law: Law
    if isinstance(data, str):
        law = Formula(data)
    elif isinstance(data, Mapping):
        law = _of_map(data, what, folder)
    else:
        return Polynomial(_coefficients(data, what))
    if isinstance(law, Formula | Energy):
        angle = Store().symbol("angle", Space.ANGLE, 0)
        try:
            law.of(angle)
        except ExpressionError as error:
            raise ExpressionError(f"{what}: {error.message}") from error
        except (ArithmeticError, ValueError) as error:
            raise ExpressionError(f"{what}: expression {law.text!r} has no finite value ({error})") from error
    return law


def _of_map(data: Mapping[object, object], what: str, folder: Path | None) -> Law:
    for key in data:
        if key not in KEYS:
            raise DesignError(f"{what} has no field {shown(key)}; {did_you_mean(str(key), KEYS)}")
    sources = [key for key in ("table", "file", "energy") if key in data]
    if len(sources) != 1 or ("energy" in data and len(data) > 1):
        raise DesignError(
            f"{what} gives {' and '.join(map(str, data)) or 'nothing'}; give one of table, file and energy, and with a "
            "table or file, if wished, between and located"
        )
    if "energy" in data:
        if not isinstance(data["energy"], str):
            raise DesignError(
                f"{what}: the energy is {shown(data['energy'])}; give an expression in angle, J"
            )
        return Energy(data["energy"])
    between = data.get("between", BETWEEN[0])
    if between not in BETWEEN:
        raise DesignError(
            f"{what}: between points there is {shown(between)}; give 'spline', or 'monotone', which does not overshoot "
            "(straight lines would have kinks, at which integrators lose their order)"
        )
    rows = data["table"] if "table" in data else _read(data["file"], what, folder)
    points = checked_rows(rows, what)
    few = len(points) <= MAX_LOCATED
    located = checked_flag(data.get("located", few and between != "spline"), f"located of {what}")
    if located and not few:
        raise DesignError(
            f"{what}: {len(points)} points cannot be located; at most {MAX_LOCATED} can: leave located out, "
            "or give fewer"
        )
    table = Table(points, str(between), located)
    _check_curve(table, what)
    return table


def _read(name: object, what: str, folder: Path | None) -> Rows:
    if not isinstance(name, str | Path) or not str(name).strip():
        raise DesignError(f"{what}: the file is {shown(name)}; give the name of a CSV file")
    return read_table((folder or Path()) / name, (ANGLE, TORQUE))


def checked_rows(rows: object, what: str) -> Rows:
    """`rows` as (angle, torque) in rad and N·m. Raises DesignError unless they are finite and angles ascend."""
    try:
        array = np.array(rows, dtype=np.float64)
    except (TypeError, ValueError, OverflowError) as error:
        raise DesignError(
            f"{what}: the table is {shown(rows)}; give rows of two numbers, angle (rad) and torque (N·m)"
        ) from error
    if array.ndim != 2 or array.shape[1] != 2 or not 2 <= len(array) <= MAX_ROWS:
        raise DesignError(
            f"{what}: the table has shape {array.shape}; give 2 to {MAX_ROWS} rows of angle (rad) and torque (N·m)"
        )
    if not np.isfinite(array).all():
        row = int(np.flatnonzero(~np.isfinite(array).all(axis=1))[0])
        raise DesignError(f"{what}: row {row + 1} of the table is {array[row].tolist()}; it must be finite")
    falls = np.flatnonzero(np.diff(array[:, 0]) <= 0.0)
    if len(falls):
        before, after = array[falls[0] : falls[0] + 2, 0]
        raise DesignError(
            f"{what}: angle {after:g} rad follows {before:g} rad in row {falls[0] + 2} of the table; angles must "
            "ascend: sort the rows, and leave one of those with equal angles"
        )
    if np.abs(array[:, 0]).max() > WIDEST_ANGLE:
        raise DesignError(
            f"{what}: the table reaches {np.abs(array[:, 0]).max():g} rad, more than two turns; bare angles are "
            "radians: give the unit, in a file in its heading: angle [deg], torque [N*mm]"
        )
    return tuple((float(a), float(t)) for a, t in array + 0.0)  # -0.0 becomes 0.0: equal tables print alike


def _check_curve(table: Table, what: str) -> None:
    """Raises DesignError where points are so close or torques so large that the curve overflows."""
    try:
        finite = all(math.isfinite(c) for row in table.potential().pieces for c in row)
    except (ArithmeticError, ValueError):
        finite = False
    if not finite:
        raise DesignError(
            f"{what}: the curve through the table's points is not finite; set them farther apart"
        )


def _coefficients(data: object, what: str) -> tuple[float, ...]:
    values = data if isinstance(data, Sequence | np.ndarray) and not isinstance(data, bytes) else (data,)
    if not 1 <= len(values) <= MAX_DEGREE:
        raise DesignError(
            f"{what} has {len(values)} coefficients; give 1 to {MAX_DEGREE}, of angle, angle², …, N·m/rad, N·m/rad², …"
        )
    numbers = tuple(
        checked_number(value, f"coefficient {power} of {what}") + 0.0
        for power, value in enumerate(values, start=1)
    )
    if not any(numbers):
        raise DesignError(f"{what} has coefficients that are all 0; leave the hinge out")
    return numbers
