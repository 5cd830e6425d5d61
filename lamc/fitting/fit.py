"""`lamc.fit`: numbers of a model from what was measured on the device.

In: as its docstring says. Out: a `Fit`. It arranges: what is unknown (`setting`), what the model says of it
(`predictions`), least squares (`solve`), and what is known of the answer (`uncertainty`).
"""

from collections.abc import Callable, Mapping, Sequence

import numpy as np

from lamc.basics.checks import is_list, shown
from lamc.basics.errors import RequestError
from lamc.basics.places import located_at
from lamc.basics.threads import on_one_thread
from lamc.codegen.options import CompileOptions
from lamc.fitting.answer import Fit
from lamc.fitting.cameras import placed
from lamc.fitting.compared import beyond_a_turn, compared_of, remarks
from lamc.fitting.exact import Exact
from lamc.fitting.losses import LOSSES
from lamc.fitting.objective import Objective, first_sigmas
from lamc.fitting.predictions import Predictor
from lamc.fitting.setting import setting_of
from lamc.fitting.shooting import growth, shoot
from lamc.fitting.simulators import Simulators
from lamc.fitting.solve import Solved, elsewhere, is_lost, is_poor, left_over, solve
from lamc.fitting.uncertainty import account_of, correlated
from lamc.records.mechanism import Mechanism
from lamc.records.recording import Recording
from lamc.records.scene import Scene
from lamc.records.series import Series
from lamc.run.evaluations import NO_PARAMETERS
from lamc.run.parameters import with_limits
from lamc.run.request import did_you_mean
from lamc.run.start_checks import check_run, check_start
from lamc.studies.making import scene_of
from lamc.studies.targets import Made, Studied, family_of

FORGETS = 100.0  # times as large as at the start: a change of it
_MANY = 10.0  # times the data's variance: these hardly vary
_POOR = 0.5  # share of the data's variance: a model that does not describe them


def fit(
    design: Studied | Callable[..., Made],
    data: Recording | Sequence[Recording],
    free: Mapping[str, object] | Sequence[str],
    scene: Scene | Callable[[Mechanism], Scene] | str | None = None,
    *,
    parameters: Mapping[str, float | str] = NO_PARAMETERS,
    loss: str = "linear",
    starts: int = 4,
    seed: int = 0,
    segments: int | None = None,
    integrator: str = "auto",
    options: CompileOptions | None = None,
) -> Fit:
    """Finds the numbers of a model with which its runs are nearest to recordings.

    design   Design, Mechanism or Family; or a function of dimensions, with defaults, that gives one
    data     a Recording, or several; each with its own start, delay, gains, camera
    free     name → range, in SI or text: (1e-4, 1e-1), "log:1e-4:1e-1", "3 N*mm/rad ± 0.5 N*mm/rad" (a prior), None (no
             bounds, and a positive number within 1e8 times either way), or lamc.Free(…); or names alone. Parameters of
             the model ("h1.stiffness") and dimensions of the design. Positive numbers whose range spans a decade are
             sought by their logarithms
    scene    a Scene, or the name of one of the design's; None: the design's own
    parameters  of the model in all recordings, given
    loss     "linear": least squares; "soft_l1", "huber", "cauchy", "arctan": outliers count less
    starts   how many at most, where the first leaves more than a tenth of the data's variance; seed: of the others

    segments pieces of each recording, each with a start of its own, that meet in the end (multiple shooting): for
             motion that forgets its start; 1: none; None: where the motion asks for it and one run finds no way

    Returns a Fit, which may not be what it seems: `Fit.converged`, `Fit.notes` and `Fit.unidentifiable` tell. Raises
    RequestError for what makes no fit: unknown names, fewer data than unknowns, a number that changes nothing that was
    recorded; DesignError for what cannot be simulated; SimulationError if the run fails from where the fit begins.
    """
    family = family_of(design)
    simulators = Simulators(family, scene_of(family, scene), options)
    return answered(simulators, data, free, parameters, loss, starts, seed, integrator, segments)


@on_one_thread
def answered(
    simulators: Simulators,
    data: Recording | Sequence[Recording],
    free: Mapping[str, object] | Sequence[str],
    parameters: Mapping[str, float | str],
    loss: str,
    starts: int,
    seed: int,
    integrator: str = "auto",
    segments: int | None = None,
) -> Fit:
    """The fit of a design that is compiled, as of `fit`."""
    recordings = _checked(data, loss, starts, segments)
    setting = setting_of(simulators, recordings, _ranges(free), parameters)
    runs = Exact(integrator)
    check_starts(Predictor(setting, runs))
    predictor = placed(Predictor(setting, runs))
    objective = Objective(predictor, first_sigmas(predictor))
    if segments == 1:
        return answer(predictor, solve(objective, loss, starts, seed), loss)
    if segments is not None:
        begin = setting.unknowns.within(setting.unknowns.start)
        found, _ = shoot(objective, begin, segments)
        return answer(found.objective.predictor, found, loss)
    return answer(*_as_asked(objective, loss, starts, seed), loss)


def _as_asked(objective: Objective, loss: str, starts: int, seed: int) -> tuple[Predictor, Solved]:
    """By one run, or in pieces where the motion forgets its start and one run finds no way."""
    predictor = objective.predictor
    unknowns = predictor.setting.unknowns
    solved = solve(objective, loss, 1, seed)
    if (
        (is_poor(solved) or is_lost(solved))
        and loss == "linear"
        and max(growth(predictor, solved.inner)) > FORGETS
    ):
        try:
            found, _ = shoot(Objective(predictor, objective.sigmas), unknowns.within(unknowns.start), None)
        except RequestError:  # of a model whose states are not free, or too many rows
            found = solved
        meets = (
            found.converged or not solved.converged
        )  # else pieces are near to the data, and not to each other
        if meets and left_over(found.objective, found.inner) < left_over(solved.objective, solved.inner):
            return found.objective.predictor, found
    return predictor, elsewhere(solved, loss, starts, seed)


def check_starts(predictor: Predictor) -> None:
    """Shows the effects where runs begin. Raises DesignError for starts that they refuse, as outside of limits."""
    at = predictor.numbers(predictor.setting.unknowns.values(predictor.setting.unknowns.start))
    for which in range(len(predictor.setting.runs)):
        task = predictor.task(which, at, sloped=False)
        simulator, motion = task.simulator, task.simulator.model.motion(task.parameters)
        numbers = {name: float(v) for name, v in task.parameters.items() if not isinstance(v, Series)}
        with located_at(simulator.scene.places):
            limited = with_limits(simulator.mechanism, numbers)
            check_start(simulator.effects, limited, motion, task.y0)
            check_run(simulator.effects, simulator.mechanism, motion, task.y0, float(task.times[-1]))


def answer(predictor: Predictor, solved: Solved, loss: str) -> Fit:
    """The account of what was found."""
    setting, unknowns = predictor.setting, predictor.setting.unknowns
    if not np.isfinite(solved.cost):
        raise RequestError(f"no fit: {solved.message}")
    objective, inner = solved.objective, solved.inner
    found = objective.predictions(inner, sloped=True, fine=True)
    residual, jacobian = objective.residual(inner, found), objective.jacobian(inner, found)
    account = account_of(unknowns, inner, residual, jacobian, loss, predictor.runs.known_to)
    compared = compared_of(predictor, solved)
    values = dict(zip(unknowns.names, unknowns.values(inner).tolist(), strict=True))
    notes = [*setting.notes, *predictor.runs.notes, *solved.notes, *remarks(compared)]
    share = left_over(objective, inner)
    if share > _POOR:
        left = f"{share:.0%} of the data's variance" if share < _MANY else "far more than the data vary"
        notes.append(f"the model leaves {left}: it does not describe them")
        notes += beyond_a_turn(compared)
    notes += [
        f"{name} stands at its bound, {values[name]:g}; widen the range, or leave it there: intervals of the others "
        "allow for its being within"
        for name in account.at_bounds
    ]
    notes += [
        f"{a} and {b} are told together rather than each (correlation {r:+.3f})"
        for a, b, r in correlated(unknowns.names, account.correlations)
        if not any({a, b} <= set(each.names) for each in account.unidentifiable)
    ]
    return Fit(
        values=values,
        units={u.name: u.unit for u in unknowns.all},
        intervals=dict(
            zip(unknowns.names, ((float(a), float(b)) for a, b in account.intervals), strict=True)
        ),
        errors=dict(zip(unknowns.names, account.errors.tolist(), strict=True)),
        logarithms=tuple(u.name for u in unknowns.all if u.log),
        correlations=account.correlations,
        unidentifiable=account.unidentifiable,
        converged=solved.converged,
        message=solved.message,
        notes=tuple(notes),
        runs=predictor.runs.count,
        derivatives=predictor.runs.derivatives_by,
        compared=compared,
        setting=setting,
        predictor=predictor,
        solved=solved,
        account=account,
    )


def _checked(data: object, loss: str, starts: int, segments: int | None) -> list[Recording]:
    if isinstance(data, Recording):
        data = [data]
    if not is_list(data) or not len(data) or not all(isinstance(each, Recording) for each in data):
        raise RequestError(
            f"data is {shown(data)}; give recordings: data=[lamc.Recording(t, {{'h1': angles}})]"
        )
    if loss not in LOSSES:
        raise RequestError(f"no loss is named {shown(loss)}; {did_you_mean(str(loss), LOSSES)}")
    if isinstance(starts, bool) or not isinstance(starts, int) or not 1 <= starts <= 1000:
        raise RequestError(f"starts is {shown(starts)}; it must be a whole number from 1 to 1000")
    if segments is not None and (
        isinstance(segments, bool) or not isinstance(segments, int) or not 1 <= segments <= 1000
    ):
        raise RequestError(
            f"segments is {shown(segments)}; it must be a whole number from 1, one run, to 1000 pieces, or None: where "
            "the motion asks for them"
        )
    return list(data)


def _ranges(free: object) -> dict[str, object]:
    if isinstance(free, Mapping):
        return {str(name): given for name, given in free.items()}
    if is_list(free) and all(isinstance(each, str) for each in free):
        return dict.fromkeys(free)
    raise RequestError(
        f"free is {shown(free)}; it must map names to ranges, free={{'h1.stiffness': (1e-4, 1e-1)}}"
    )
