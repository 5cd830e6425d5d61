"""Parameters on the command line: --set NAME=VALUE, of a design or of its run.

In: words as typed. Out: a design with those values, numbers of a run, or DesignErrors that name the option and the
nearest parameter.
"""

from collections.abc import Collection, Mapping, Sequence

from lamc.basics.checks import did_you_mean
from lamc.basics.errors import DesignError
from lamc.basics.readonly import ReadOnlyDict
from lamc.basics.si_units import in_unit
from lamc.commands.pairs import pairs_of
from lamc.records.design import Design
from lamc.records.mechanism import Mechanism
from lamc.records.parameters import DesignParameter, unknown_parameter

NONE: Mapping[str, float] = ReadOnlyDict({})


def dimensioned(
    record: Design | Mechanism, settings: Sequence[str], more: Mapping[str, float], *, of_run: bool
) -> tuple[Design | Mechanism, Mapping[str, str]]:
    """The record with its parameters as --set has them, and what is left for the run.

    more    further values, SI
    of_run  a name that is none of the design's may be one of its run; else it is refused
    """
    texts = pairs_of(settings, "--set", "0.01")
    if not texts and not more:
        return record, {}
    known, inputs = record.parameters, _inputs(record) if of_run else ()
    own, left = {}, {}
    for name, text in texts.items():
        if name not in known or name in inputs:
            left[name] = text
            continue
        try:
            own[name] = known[name].number(text, f"parameter {name!r}")
            known[name].check(own[name], f"parameter {name!r}")
        except DesignError as error:
            raise DesignError(f"{_said(name, text)}: {error.message}") from error
    if left and not of_run:
        name, text = next(iter(left.items()))
        raise DesignError(f"{_said(name, text)}: {unknown_parameter(name, known).message}")
    return record.with_parameters({**more, **own}), left


def of_run(texts: Mapping[str, str], units: Mapping[str, str], known: Sequence[str]) -> Mapping[str, float]:
    """Values of a run's parameters: numbers in their own units, of `units`, or text with a unit.

    known  names of the design's parameters, which may be meant by what is none
    """
    values = {}
    for name, text in texts.items():
        if name not in units:
            nearest = did_you_mean(name, [*units, *known])
            raise DesignError(f"{_said(name, text)}: no parameter is named {name!r}; {nearest}")
        try:
            values[name] = in_unit(text, units[name], "number")
        except DesignError as error:
            raise DesignError(f"{_said(name, text)}: {error.message}") from error
    return values


def declared(record: Design | Mechanism) -> Mapping[str, DesignParameter]:
    """Parameters that the file declares, or that were set; not those that every drawing has."""
    return record.origin.recipe.listed if record.origin is not None else {}


def given(record: Design | Mechanism) -> Mapping[str, float]:
    """Values that were set, SI, with which the design is made again."""
    return record.origin.recipe.given if record.origin is not None else {}


def _inputs(record: Design | Mechanism) -> Collection[str]:
    """Names of inputs of its scenes, which a run has had for longer than drawings have parameters; a file that declares
    a parameter of that name is refused."""
    scenes = [*record.scenes.values(), *([record.scene] if record.scene is not None else [])]
    return {name for scene in scenes for name in scene.inputs}


def _said(name: str, text: str) -> str:
    return f"--set {f'{name}={text}'!r}"
