"""The inputs that scenes in files declare: numbers from outside, such as `drive: 0 N*mm`.

In: plain data by name, with its place, and the effects of the scene. Out: `Input`s in SI; every problem is noted at its
place. A series is read from a CSV file beside it, or stands there row by row. No effect is known here by name.
"""

from collections.abc import Mapping, Sequence

from lamc.basics.checks import did_you_mean, shown
from lamc.basics.errors import DesignError
from lamc.basics.si_units import measured
from lamc.readers.checking import Path, Problems
from lamc.readers.numbers import Numbers
from lamc.readers.series_input import is_series, series_input
from lamc.records.effect import Effect
from lamc.records.inputs import (
    Input,
    check_inputs,
    check_name,
    check_read,
    check_smooth,
    inputs_of,
    is_of_effect,
)

_FIELDS = ("default", "unit", "meaning")


def read_inputs(
    said: Mapping[str, tuple[object, Path]],
    own: Path,
    effects: Sequence[tuple[Effect | None, Path]],
    problems: Problems,
    numbers: Numbers | None = None,
) -> dict[str, Input] | None:
    """The inputs of one scene; None after noting what is wrong with them, or with names in expressions.

    said     each with its place, those of scenes that this one is like among them, which are left out where no effect
             of this one reads them
    own      where the scene stands
    effects  None: one that could not be made; then nothing is said to be unread
    numbers  reads expressions in parameters of the design; None: there are none
    """
    whole = all(effect is not None for effect, _ in effects)
    made = [(effect, path) for effect, path in effects if effect is not None]
    read = {name for effect, _ in made for name in inputs_of(effect)}
    kept = {
        n: v for n, v in said.items() if n in read or (whole and v[1][: len(own)] == own) or is_of_effect(n)
    }
    inputs: dict[str, Input] = {}
    fine = True
    for name, (value, path) in kept.items():
        found = problems.attempt(path, lambda n=name, v=value, p=path: _made(n, v, p, problems, numbers))  # type: ignore[misc]
        if found is not None:
            inputs[name] = found
        fine = fine and found is not None
    for name, each in inputs.items():
        for effect, _ in made:
            smooth = problems.attempt(kept[name][1], lambda e=effect, n=name, i=each: _smooth(e, n, i))  # type: ignore[misc]
            fine = fine and smooth is not None
    for effect, path in made:
        known = problems.attempt(path, lambda e=effect: _known(e, kept))  # type: ignore[misc]
        fine = fine and known is not None
    for name in kept:
        unread = problems.attempt(kept[name][1], lambda n=name: _read(n, read))  # type: ignore[misc]
        fine = fine and unread is not None
    return inputs if fine else None


def _made(name: str, value: object, path: Path, problems: Problems, numbers: Numbers | None) -> Input:
    if not is_series(value):
        return input_of(name, value, numbers)
    check_name(name, of_effect=True)
    return series_input(value, problems.folder, lambda key: problems.place((*path, key)))


def input_of(name: str, value: object, numbers: Numbers | None = None) -> Input:
    """The input of a file's data: a number, text with a unit, or a map of default, unit and meaning.

    Raises DesignError for a name that it cannot have, and for data that does not fit.
    """
    check_name(name)
    fields = value if isinstance(value, Mapping) else {"default": value}
    for key in fields:
        if key not in _FIELDS:
            raise DesignError(f"an input has no field {shown(key)}; {did_you_mean(str(key), _FIELDS)}")
    default, unit, meaning = (
        fields.get(key, other) for key, other in zip(_FIELDS, (0.0, "", ""), strict=True)
    )
    if isinstance(default, bool) or not isinstance(default, int | float | str) or not isinstance(unit, str):
        raise DesignError(
            f"an input is {shown(value)}; give its default with its unit, such as 0 N*mm, or a map of default, "
            "unit and meaning"
        )
    if isinstance(default, str) and numbers is not None and numbers.takes(default):
        number, own = numbers.measured(default)
    else:
        number, own = measured(default if isinstance(default, str) else repr(default))
    if unit and own == "1":
        number, own = measured(f"{number!r} {unit}")
    elif unit and measured(f"1 {unit}")[1] != own:
        raise DesignError(
            f"the default {default!r} of an input is no number in its unit {unit!r}; say the unit once"
        )
    return Input(number, own, meaning)  # type: ignore[arg-type]  # refuses what is no text


def _known(effect: Effect, names: Mapping[str, object]) -> bool:
    check_inputs(effect, names)
    return True


def _smooth(effect: Effect, name: str, each: Input) -> bool:
    check_smooth(effect, {name: each})
    return True


def _read(name: str, read: set[str]) -> bool:
    if name not in read and not is_of_effect(name):
        check_read((name,), ())
    return True
