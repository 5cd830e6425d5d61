"""Checks of single values, shared by all records that a user can make by hand.

In: a value of any type, and what to call it. Out: the value in its proper type, or a DesignError of one line that
names the value and the rule. Never: knows what the value is for.
"""

import difflib
import math
from collections.abc import Iterable, Mapping, Sequence
from typing import Any, TypeGuard, TypeVar

import numpy as np
import numpy.typing as npt

from lamc.basics.errors import DesignError
from lamc.basics.units import ANGLE, Quantity, to_si

Array = npt.NDArray[np.float64]
Item = TypeVar("Item")

MAX_NAME_LENGTH = 200
_MOST_SHOWN = 80  # characters of a value that a message repeats


def shown(value: object) -> str:
    """`value` as a message shows it: its repr, shortened, or its type where it has none."""
    try:
        text = repr(value)
    except ValueError:  # an integer of more digits than Python prints
        return f"<{type(value).__name__}>"
    return text if len(text) <= _MOST_SHOWN else f"{text[:_MOST_SHOWN]}…"


def nearest_name(word: str, known: Sequence[str]) -> str | None:
    """The name that an unknown word is in other letters, or nearly; None where none is near."""
    same = [name for name in known if name.lower() == word.lower()]
    return next(iter(same or difflib.get_close_matches(word, known, n=1, cutoff=0.6)), None)


def did_you_mean(word: str, known: Sequence[str]) -> str:
    """A hint that ends a message about an unknown word."""
    known = list(dict.fromkeys(known))
    near = nearest_name(word, known)
    if near is not None:
        return f"did you mean {near!r}?"
    listed = ", ".join(known[:12]) + (", …" if len(known) > 12 else "")
    return f"known are {listed}" if known else "none are known here"


def checked_kind(value: object, kind: type[Item], what: str, way_out: str) -> Item:
    """`value`, if it is one of `kind`, or DesignError with the way to get one."""
    if not isinstance(value, kind):
        raise DesignError(f"{what} is {shown(value)}; it must be a {kind.__name__}: {way_out}")
    return value


def checked_name(name: object, what: str) -> str:
    """`name` as a usable name, or DesignError."""
    if not isinstance(name, str) or not name.strip():
        raise DesignError(f"{what} has the name {shown(name)}; a name is a string that is not empty")
    if len(name) > MAX_NAME_LENGTH:
        raise DesignError(
            f"{what} {name[:24] + '…'!r} has a name of {len(name)} characters; at most {MAX_NAME_LENGTH} are allowed"
        )
    if not name.isprintable():
        raise DesignError(f"{what} {name!r} has characters in its name that do not print; rename it")
    return name


def checked_array(
    value: object, shape: tuple[int, ...], what: str, quantity: Quantity | None = None
) -> Array:
    """`value` as a read-only array of finite floats of the given shape, or DesignError. With a quantity, entries may be
    text with a unit."""
    if quantity is not None and is_list(value) and any(isinstance(each, str) for each in value):
        value = [_in_si(each, what, quantity) for each in value]
    try:
        array = np.array(value, dtype=np.float64)
    except (TypeError, ValueError, OverflowError) as error:
        raise DesignError(f"{what} is {shown(value)}; it must hold {shape} numbers") from error
    if array.shape != shape:
        raise DesignError(f"{what} has shape {array.shape}; it must have shape {shape}")
    if not np.isfinite(array).all():
        raise DesignError(f"{what} is {array.tolist()}; every number must be finite")
    array.flags.writeable = False
    return array


def checked_number(
    value: object, what: str, *, minimum: float = -math.inf, quantity: Quantity | None = None
) -> float:
    """`value` as a finite float, at least `minimum`, or DesignError: True is 1 to Python, and must not pass for it.
    With a quantity it may be text with a unit, "3 N*mm/deg"."""
    if quantity is not None:
        value = _in_si(value, what, quantity)
    if isinstance(value, bool | np.bool_):
        raise DesignError(f"{what} is {shown(value)}; it must be a number")
    try:
        number = float(value)  # type: ignore[arg-type]
    except (TypeError, ValueError) as error:
        raise DesignError(f"{what} is {shown(value)}; it must be a number") from error
    except OverflowError as error:
        raise DesignError(f"{what} is {shown(value)}, which no float holds; it must be finite") from error
    if not math.isfinite(number) or number < minimum:
        rule = "finite" if minimum == -math.inf else f"finite and at least {minimum:g}"
        raise DesignError(f"{what} is {number!r}; it must be {rule}")
    return number


def _in_si(value: object, what: str, quantity: Quantity) -> object:
    """Text with a unit as a number, SI; anything else as it is."""
    if not isinstance(value, str):
        return value
    try:
        return to_si(value, quantity)
    except DesignError as error:
        raise DesignError(f"{what} is {shown(value)}; {error.message}") from error


def is_list(value: object) -> TypeGuard[Sequence[Any]]:
    """True for sequences, and arrays with an axis; text is none."""
    if isinstance(value, np.ndarray):
        return value.ndim > 0
    return isinstance(value, Sequence) and not isinstance(value, str | bytes)


def checked_flag(value: object, what: str) -> bool:
    """`value` as a bool, or DesignError: "no" is true to Python, and must not pass for it."""
    if not isinstance(value, bool | np.bool_):
        raise DesignError(f"{what} is {shown(value)}; it must be True or False")
    return bool(value)


def checked_range(value: object, what: str) -> tuple[float, float]:
    """`value` as (lower, upper), finite and in this order, rad; or DesignError."""
    try:
        ends = () if isinstance(value, str) else tuple(value)  # type: ignore[arg-type]
    except TypeError:
        ends = ()
    if len(ends) != 2:
        raise DesignError(
            f"the limits of {what} are {shown(value)}; they must be two angles (lower, upper), rad"
        )
    lower = _checked_limit(ends[0], f"the lower limit of {what}")
    upper = _checked_limit(ends[1], f"the upper limit of {what}")
    if lower >= upper:
        raise DesignError(
            f"the limits of {what} are ({lower:g}, {upper:g}) rad; the lower must be below the upper"
        )
    return lower, upper


def _checked_limit(value: object, what: str) -> float:
    if isinstance(value, float) and math.isinf(value):
        raise DesignError(f"{what} is {value!r}; it must be finite: leave limits out where there are none")
    return checked_number(value, what, quantity=ANGLE)


def checked_records(values: Iterable[Item], kind: type[Item], name: str, where: str) -> tuple[Item, ...]:
    """`values` as a tuple of records of one kind, or DesignError; `name` is the argument's, `where` the owner's."""
    what, one = f"{name} of {where}", kind.__name__
    if isinstance(values, kind):
        raise DesignError(f"{what} is a single {one}; put it into a tuple: {name}=({one.lower()},)")
    if isinstance(values, Mapping | str | bytes):
        raise DesignError(f"{what} is a {type(values).__name__}; it must be a tuple of {one} records")
    try:
        items = tuple(values)
    except TypeError as error:
        raise DesignError(f"{what} is {shown(values)}; it must be a tuple of {one} records") from error
    for item in items:
        if not isinstance(item, kind):
            raise DesignError(f"{what} holds {shown(item)}; each must be a {one}")
    return items
