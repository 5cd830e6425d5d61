"""What a fit is about: a design in a scene, recordings, unknowns, all checked before anything is fitted.

In: what `lamc.fit` is given. Out: a `Setting`. Raises RequestError of one line for names that are not there, for fewer
data than unknowns, and for starts outside of their bounds.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from lamc.basics.checks import did_you_mean, shown
from lamc.basics.errors import RequestError
from lamc.fitting.recorded import Run, run_of
from lamc.fitting.simulators import Simulators
from lamc.fitting.unknowns import Unknown, Unknowns, free_of, unknown
from lamc.records.recording import Free, Recording
from lamc.run.parameters import bounds, checked_parameters
from lamc.studies.targets import Target, targets_of


@dataclass(frozen=True, eq=False)
class Setting:
    """runs: of all recordings; unknowns; simulators of the design by its dimensions."""

    simulators: Simulators
    runs: tuple[Run, ...]
    unknowns: Unknowns
    notes: tuple[str, ...] = ()
    parameters: Mapping[str, float] = field(default_factory=dict)  # of all runs, given

    @property
    def count(self) -> int:
        """Numbers that were measured and are compared."""
        return sum(int(np.isfinite(run.measured).sum()) for run in self.runs)


def setting_of(
    simulators: Simulators,
    data: Sequence[Recording],
    free: Mapping[str, object],
    parameters: Mapping[str, float | str],
    *,
    held: bool = False,
) -> Setting:
    """All of a fit, checked. held: nothing need be free."""
    first = simulators.usual
    targets = targets_of(simulators.design, first)
    named = [replace(each, name=each.name or f"run{k + 1}") for k, each in enumerate(data)]
    _check_names([each.name for each in named])
    given = checked_parameters(parameters, first.parameter_units)
    unknowns = [_shared(name, range_, targets, simulators, given) for name, range_ in free.items()]
    runs = []
    notes: list[str] = []
    for recording in named:
        run, own = run_of(recording, first, {each.name for each in unknowns}, notes)
        runs.append(run)
        unknowns += [each for each in own if each.name not in {u.name for u in unknowns}]
    _refuse_centres(unknowns, runs)
    setting = Setting(simulators, tuple(runs), Unknowns(tuple(unknowns)), tuple(notes), given)
    if not unknowns and not held:
        raise RequestError(
            "nothing is free; name what is to be found: free={'h1.stiffness': (1e-4, 1e-1)}, --free h1.stiffness"
        )
    if setting.count <= len(unknowns):
        raise RequestError(
            f"there are {setting.count} data, and {len(unknowns)} unknowns ({', '.join(setting.unknowns.names[:8])}); "
            "record more, or free less"
        )
    return setting


def _refuse_centres(unknowns: Sequence[Unknown], runs: Sequence[Run]) -> None:
    """Raises RequestError for centres of mass that are free beside points: points are told from the drawn centre."""
    free = next((each.name for each in unknowns if each.kind == "parameter" and ".com_" in each.name), None)
    point = next(
        (s for run in runs for s in run.sight.signals if s.rpartition(".")[2] in ("x", "y", "z")), None
    )
    if free is not None and point is not None:
        raise RequestError(
            f"{free!r} is free, and {point!r} is a point of a body, which is placed by the centre as drawn; "
            "record angles, or "
            "free a dimension of the design"
        )


def _check_names(names: Sequence[str]) -> None:
    twice = next((name for name in names if list(names).count(name) > 1), None)
    if twice is not None:
        raise RequestError(
            f"two recordings are named {twice!r}; their unknowns would be one: name them apart"
        )


def _shared(
    name: str,
    given: object,
    targets: Mapping[str, Target],
    simulators: Simulators,
    parameters: Mapping[str, float],
) -> Unknown:
    """An unknown of all recordings: a parameter of the model, or a dimension of the design."""
    target = targets.get(name)
    if target is None or target.kind not in ("parameter", "dimension"):
        raise RequestError(_no_such(name, targets))
    if name in parameters:
        raise RequestError(f"{name!r} is free, and it is given {parameters[name]:g}; say one of them")
    free = free_of(given, name, target.unit)
    own = target.default
    if target.kind == "dimension":
        free = _declared(name, free, target)
        return unknown(
            name,
            "dimension",
            name,
            target.unit,
            free,
            own,
            size=abs(own or 1.0),
            positive=bool(own and own > 0.0),
        )
    limits = bounds(name)
    _check_possible(name, free, limits.least, limits.most)
    return unknown(
        name,
        "parameter",
        name,
        target.unit,
        free,
        own,
        size=abs(own or 0.0) or 1.0,
        positive=limits.least == 0.0,
    )


def _declared(name: str, free: Free, target: Target) -> Free:
    """What of a range the design lets a dimension be. Raises RequestError where that is nothing."""
    least = -math.inf if target.minimum is None else target.minimum
    most = math.inf if target.maximum is None else target.maximum
    unit = "" if target.unit == "1" else f" {target.unit}"
    declared = f"its declared bounds, {least:g}{unit} … {most:g}{unit}"
    if not (free.low < most and least < free.high):
        raise RequestError(
            f"{name!r}: the range {free.low:g}{unit} … {free.high:g}{unit} lies outside of {declared}; take one "
            "within them"
        )
    if free.start is not None and not least <= free.start <= most:
        raise RequestError(f"{name!r}: the start {free.start:g}{unit} lies outside of {declared}; move it")
    return replace(free, low=max(free.low, least), high=min(free.high, most))


def _check_possible(name: str, free: Free, least: float, most: float) -> None:
    for end, is_out in ((free.low, free.low < least), (free.high, free.high > most)):
        if is_out and math.isfinite(end):
            raise RequestError(f"{name!r} may not be {end:g}; it lies between {least:g} and {most:g}")


def _no_such(name: str, targets: Mapping[str, Target]) -> str:
    """Why a name cannot be free, and the way out."""
    known = [each.name for each in targets.values() if each.kind in ("parameter", "dimension")]
    joint, _, what = str(name).rpartition(".")
    effect = {"damping": "hinge_damping", "stiffness": "hinge_stiffness", "rest_angle": "rest_angle"}.get(
        what
    )
    if effect is not None and f"angles.{joint}" in targets:
        return (
            f"{name!r} cannot be free: the scene has no {effect}, so it is no parameter of the model; let it act: "
            f"Scene(added=(…,)), --with {effect}, or give the hinge a value in the design"
        )
    if str(name).startswith(("angles.", "rates.")):
        return f"{name!r} is of one recording: Recording(angles={{…: (low, high)}}), or start='estimated'"
    return f"nothing of this model that can be free is named {shown(name)}; {did_you_mean(str(name), known)}"
