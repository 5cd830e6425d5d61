"""Inputs of a scene: named numbers that come from outside while a model runs, such as the command of a controller.

In: default, unit and meaning of each, by name. Out: checked records. They may stand in the expressions of drives.
One is constant within a run and a parameter of the model, or it follows a series. Effects tell which they read; what
does not fit is refused by name. Never: knows an effect by name, or a file.
"""

import keyword
import re
from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass
from typing import Any

from lamc.basics.checks import checked_kind, checked_number, shown
from lamc.basics.errors import DesignError, ExpressionError, about
from lamc.basics.given import GivenNumber
from lamc.basics.readonly import ReadOnlyDict
from lamc.basics.si_units import in_unit, measured, si_unit
from lamc.records.effect import hooked
from lamc.records.series import Series
from lamc.symbolic.functions import FUNCTIONS

LONGEST_NAME = 40
LONGEST_OF_EFFECT = 250  # a name of a joint, and what the effect adds
SECOND = 2  # order of what a prescribed motion is differentiated to
MOST = 1000
_NAME = re.compile(r"[A-Za-z][A-Za-z0-9_]*\Z")
_STAGED = re.compile(
    r"z[0-9]+|mode_[0-9]+|series_[0-9]+|tick_[0-9]+|held_[0-9]+_[0-9]+|(?:M|J|f|phi|gamma)(?:_[0-9]+)+"
)  # what `Equations` calls its own
_MEANS = {
    "t": "the time",
    "angle": "the angle of the driven joint",
    "rate": "the rate of the driven joint",
    "pi": "3.14159…",
}


@dataclass(frozen=True)
class Input:
    """A number from outside.

    default  its value until set otherwise, in `unit`; or text with its own, "3 N*mm"
    unit     SI, such as "N*m"; "1" for a plain number
    meaning  what it is, in a few words
    series   values over time, in `unit`, that it follows; it has no default then. Another recording compiles nothing
             anew: see `Simulator.run`

    Raises DesignError for a default that is no finite number and a unit that is not SI.
    """

    default: GivenNumber = 0.0  # type: ignore[assignment]
    unit: str = "1"
    meaning: str = ""
    series: Series | None = None

    def __post_init__(self) -> None:
        if not isinstance(self.unit, str) or not isinstance(self.meaning, str):
            raise DesignError(
                f"an input has unit {shown(self.unit)} and meaning {shown(self.meaning)}; both must be text"
            )
        if self.series is not None:
            checked_kind(
                self.series, Series, "the series of an input", "make one with lamc.Series(t, values)"
            )
            if self.default != 0.0:
                raise DesignError(
                    f"an input has a series and the default {shown(self.default)}; it follows the series: leave the "
                    "default out"
                )
        unit = si_unit(self.unit)
        if unit.factor != 1.0:
            raise DesignError(
                f"the unit of an input is {self.unit!r}; inputs are in SI units: give {unit.text!r}, and the default "
                f"times {unit.factor:g}"
            )
        default: float | str = self.default
        said = unit.text
        if isinstance(default, str):
            default, said = (
                measured(default)
                if said == "1"
                else (in_unit(default, said, "the default of an input"), said)
            )
        object.__setattr__(self, "default", checked_number(default, "the default of an input"))
        object.__setattr__(self, "unit", said)
        object.__setattr__(self, "meaning", " ".join(self.meaning.split()))


NO_INPUTS: Mapping[str, Input] = ReadOnlyDict({})


def checked_inputs(inputs: object) -> Mapping[str, Input]:
    """Inputs by name, sorted, as a mapping that cannot change. Raises DesignError for what are none."""
    if not isinstance(inputs, Mapping):
        raise DesignError(
            f"inputs of a scene is {shown(inputs)}; it must map names to lamc.Input(…), as in "
            "{'drive': Input(unit='V')}"
        )
    if len(inputs) > MOST:
        raise DesignError(f"the scene has {len(inputs)} inputs; at most {MOST} are taken")
    for name, each in inputs.items():
        check_name(name, of_effect=isinstance(each, Input) and each.series is not None)
        if not isinstance(each, Input):
            raise DesignError(f"input {name!r} of a scene is {shown(each)}; make one with lamc.Input(…)")
    return ReadOnlyDict({name: inputs[name] for name in sorted(inputs)})


def check_name(name: object, *, of_effect: bool = False) -> None:
    """Raises DesignError for a name that no input can have. of_effect: it may be what an effect calls
    its input, such as knee.torque."""
    if of_effect and isinstance(name, str) and is_of_effect(name) and len(name) <= LONGEST_OF_EFFECT:
        return
    if not isinstance(name, str) or _NAME.match(name) is None or len(name) > LONGEST_NAME:
        raise DesignError(
            f"an input is named {shown(name)}; a name is of letters a to z, digits and _, begins with a letter, and "
            f"has at most {LONGEST_NAME} characters"
        )
    taken = _MEANS.get(name)
    if name in FUNCTIONS:
        taken = "a function"
    elif keyword.iskeyword(name):
        taken = "a word of Python"
    elif _STAGED.fullmatch(name):
        taken = "a quantity of the staged equations"
    if taken is not None:
        raise DesignError(
            f"an input is named {name!r}, which is {taken}; choose another name, such as {name + '_in'!r}"
        )


def is_of_effect(name: str) -> bool:
    """Whether a name is one that only effects give to their inputs, such as knee.torque."""
    return "." in name and name.isprintable()


def inputs_of(effect: Any) -> tuple[str, ...]:
    """Names of the inputs that an effect reads, sorted: in its drives, and those it tells by inputs()."""
    effect = hooked(effect)
    return tuple(sorted({*effect.inputs(), *(name for drive in effect.drives() for name in drive.inputs())}))


def check_inputs(effect: object, known: Collection[str]) -> None:
    """Raises ExpressionError for a name in a drive of `effect` that is no input of the scene, whose names are `known`,
    and DesignError for one that the effect tells."""
    for drive in hooked(effect).drives():
        with about(effect, *drive.field):
            for name, column in drive.inputs().items():
                if name not in known:
                    listed = ", ".join((*drive.names, *sorted(known), *FUNCTIONS))
                    raise ExpressionError(
                        f"{drive.what}: expression {drive.text!r}, column {column}: {name!r} is not known; known are "
                        f"{listed}; a number from outside is declared in the scene's inputs"
                    )
    with about(effect):
        for name in inputs_of(effect):
            if name not in known:
                raise DesignError(
                    f"effect {getattr(effect, 'name', effect)!r} reads the input {name!r}, which the scene does not "
                    "have; declare it in the scene's inputs"
                )


def check_smooth(effect: object, inputs: Mapping[str, Input]) -> None:
    """Raises DesignError for a drive of `effect` that is differentiated twice, and holds a series that cannot be."""
    for drive in hooked(effect).drives():
        for name in drive.inputs() if drive.smooth else ():
            series = inputs[name].series if name in inputs else None
            if series is not None and series.smoothness < SECOND:
                with about(("inputs", name)):
                    raise DesignError(rough(name, series, SECOND, drive.what))


def rough(name: str, series: Series, order: int, what: str) -> str:
    """That `what` needs a derivative that the series does not have, and the way out."""
    jumps = "jumps" if series.hold == "previous" else "has kinks"
    derivative = "rate" if order == 1 else "acceleration"
    return (
        f"the input {name!r} holds {series.hold!r} between its rows, so it {jumps}, and {what} needs its {derivative}, "
        "which is infinite there; take hold: cubic"
    )


def check_read(inputs: Iterable[str], effects: Iterable[object]) -> None:
    """Raises DesignError for an input of the scene that none of its effects reads."""
    read = {name for effect in effects for name in inputs_of(effect)}
    for name in inputs:
        if name not in read and not is_of_effect(name):
            with about(("inputs", name)):
                raise DesignError(
                    f"the scene's input {name!r} is read by none of its effects; take it away, or write it into the "
                    "expression of one"
                )
