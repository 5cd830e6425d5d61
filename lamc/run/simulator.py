"""The `Simulator`: a compiled mechanism, ready to run.

In: a mechanism, a scene and the module that `build` made of them. Out: `Result`s, accelerations, energies.
It never changes; runs share nothing but the compiled code.
"""

import logging
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import numpy.typing as npt

from lamc.basics.checks import checked_flag
from lamc.basics.errors import UnsupportedError, warn
from lamc.basics.moved import superseded
from lamc.basics.once import lazy
from lamc.basics.places import located_at
from lamc.basics.progress import part_told
from lamc.basics.seen import Viewable
from lamc.loops.rank import LoopCount
from lamc.loops.texts import elsewhere_note, pushed_note
from lamc.mechanism.plan import plan
from lamc.records.effect import Effect, notes_of
from lamc.records.mechanism import Mechanism
from lamc.records.scene import Scene, own_scene
from lamc.run.accuracy import checked_accuracy, reach
from lamc.run.arguments import check_names, checked_rate
from lamc.run.defaults import ATOL, DURATION, RTOL
from lamc.run.differentiating import Made, with_derivatives
from lamc.run.evaluations import NO_PARAMETERS
from lamc.run.extended import Modules
from lamc.run.folded import fold_over
from lamc.run.following import with_series
from lamc.run.model import CompiledModule, DesignNumbers, Motion
from lamc.run.operating_points import OperatingPoints
from lamc.run.outputs import check_outputs
from lamc.run.parameters import checked_parameters, with_limits
from lamc.run.remaking import Recipe, Telling, remade_simulator
from lamc.run.request import Progress, Request, checked_request
from lamc.run.result import Result
from lamc.run.running import Running
from lamc.run.sensitivities import differentiated
from lamc.run.start_checks import check_run, check_start
from lamc.run.taping import check_taped, tape_of
from lamc.run.topology import changes

if TYPE_CHECKING:  # what a compiled module from the cache does without
    from lamc.mechanics.equations import Equations
    from lamc.records.design import Design
    from lamc.records.series import Series
    from lamc.run.ensemble import Ensemble
    from lamc.symbolic.program import Program

logger = logging.getLogger("lamc")
_T = TypeVar("_T")


class Simulator(Running, OperatingPoints, Viewable):
    """A compiled mechanism in its scene. Made by `lamc.compile`.

    mechanism, scene  what it was made from
    effects           the effects that act, in order
    equations         the symbolic equations; derived when first asked for if the compiled code came from
                      the cache
    program           the program that the C was printed from
    source_dir        the folder with the generated C
    parameters        name → default of every number that can change without recompiling, read-only
    parameter_units   name → unit
    joints, bodies    names: joints in the order of q and u; all bodies, fixed ones too
    coordinates, rates  names and units of all of q and u: the joints, then what effects add
    """

    def __init__(
        self,
        mechanism: Mechanism,
        scene: Scene,
        effects: Sequence[Effect],
        equations: "Equations | Callable[[], Equations]",
        program: "Program | Callable[[], Program]",
        module: CompiledModule,
        numbers: DesignNumbers | None = None,
        loops: LoopCount | None = None,
        recipe: Recipe | None = None,
        modules: Modules | None = None,
    ) -> None:
        """`equations` and `program` may be functions without arguments, called when they are first asked for.
        numbers: of the design; None: those that the C was printed with.
        loops: what the mechanism's loops come to; None: counted when it is first asked for.
        recipe: what it can be made from again, in another process; None: it cannot be pickled.
        modules: makes modules with more than the model; None: there are none to be had.

        Raises RequestError if the scene starts a joint that is not there.
        """
        super().__init__(module, recipe, numbers, modules, mechanism, scene, effects, loops)
        self._equations = equations
        self._program = program
        known = (*self.joints, *(joint.name for joint in mechanism.joints))
        check_names(scene, tuple(dict.fromkeys(known)))
        names = [c.name for c in self.coordinates]
        check_outputs(scene, names, self.bodies, self._bending, mechanism.apart)

    def __repr__(self) -> str:
        return f"<Simulator of {self._model.name!r}: {len(self.joints)} joints, {len(self.bodies)} bodies>"

    def __reduce__(self) -> tuple[Any, ...]:
        return super().__reduce__() if self._recipe is None else (remade_simulator, (self._recipe,))

    @property
    def structure(self) -> str:
        """Digest of the equations without the numbers of the design; simulators of one structure share their code."""
        return self._model.structure

    def with_design(self, design: "Design | Mechanism", scene: Scene | None = None) -> "Simulator":
        """A simulator of another drawing, such as `design.with_parameters(length=0.05)`: of one of the same topology
        within milliseconds, by the same compiled code.

        Where the topology is another, or numbers vanish that did not, it is derived and compiled anew: a DesignWarning
        says so, and `structure` differs.

        scene: None: this one's; where that is one of the design's own, the new design's of that name

        Raises as `lamc.compile` does; UnsupportedError where this simulator was made by hand.
        """
        if self._recipe is None:
            raise UnsupportedError("this simulator was made by hand; use lamc.compile(design)")
        if scene is None:
            name = own_scene(self.mechanism, self.scene)
            if name is not None:
                scene = design.scenes.get(name) if name else design.scene
                if scene is None:
                    which = f"scene {name!r}" if name else "scene of its own"
                    warn(
                        f"the new drawing of {design.name!r} has no {which}: this simulator's is taken as it is"
                    )
            scene = scene or self.scene
        made = self._recipe.in_passing().simulator(design, scene)
        if made.structure != self.structure:
            what = changes(self.mechanism, made.mechanism)
            text = f"{made!r} is compiled anew, as its topology is not that of {self!r}: {what}"
            warn(text)
        return made

    @property
    def bodies(self) -> tuple[str, ...]:
        return tuple(body.name for body in self.mechanism.bodies)

    @property
    def source_dir(self) -> Path:
        return self._module.source_dir

    @lazy
    def notes(self) -> tuple[str, ...]:
        """Where effects may be wrong in this mechanism, in their own words, which branch a singular start takes that
        the scene does not choose, and that a start is not on the way from the drawing; found when asked for."""
        notes = notes_of(self.effects, plan(self.mechanism)) if self.effects else ()
        pushed = self.pushed_branch
        if pushed is not None:
            notes = (*notes, pushed_note(pushed, self.branches))
        return (*notes, elsewhere_note(self._rigid_scene.angles)) if self._is_elsewhere() else notes

    @lazy
    def inputs(self) -> tuple[str, ...]:
        """Names of the parameters that come from outside while an exported model runs."""
        return tuple(parameter.name for parameter in self.program.parameters if parameter.is_input)

    @lazy
    def equations(self) -> "Equations":
        return _settled(self._equations)

    @lazy
    def program(self) -> "Program":
        return _settled(self._program)

    def run(
        self,
        t_end: float | str | None = None,
        rtol: float | None = None,
        atol: float | None = None,
        t_eval: npt.ArrayLike | None = None,
        integrator: str = "auto",
        parameters: Mapping[str, float | str] = NO_PARAMETERS,
        *,
        max_steps: int = 1_000_000,
        max_step: float | str | None = None,
        progress: Progress | bool | None = None,
        baumgarte: float | None = None,
        energy_balance: bool = False,
        accuracy: float | None = None,
        sensitivities: Sequence[str] = (),
        series: "Mapping[str, Series] | None" = None,
        taped: bool = False,
        until_folded: bool = False,
        max_work: float | None = None,
        books: bool | None = None,
    ) -> Result:
        """Runs from the scene's angles and rates at t = 0 to t_end.

        t_end       s, or text such as "500 ms"; None: the scene's duration, or 10 s
        rtol, atol  tolerance of one step: root mean square over angles and rates of error / (atol + rtol |y|);
                    None: 1e-9 and 1e-11
        t_eval      times of the rows, s, ascending, within 0 … t_end; None: a row at the start and after
                    every step
        integrator  in C: one of `lamc.run.methods`, such as "dop853" (explicit) or "radau5" (implicit, for stiff
                    hinges), or "auto": explicit, and implicit where that goes faster; or "scipy:LSODA", …
        parameters  values by name, in the units of `parameter_units`, or text with a unit, "3 N*mm/deg"; the others
                    keep their defaults
        max_steps   steps tried before the run gives up
        max_step    longest step, s; None: no limit. Give one where a torque acts for a short time only
        progress    called with (t, t_end) now and then; True: a bar, in notebooks too
        baumgarte   rate, 1/s, at which loops that drift apart are pulled together (Baumgarte's stabilisation, for
                    comparison, and for a fixed cost per step: with rtol=1, atol=1e6 and a max_step all steps but
                    the first are of that length); None: each step is projected on closure, with nothing to choose
        energy_balance  whether the work of each effect is kept along the run, for `Result.work` and
                    `Result.energy_balance`. The first time that takes a compile of its own; the motion is the same to
                    the last bit, and `Result.nfev` counts what the energy balance takes as well
        accuracy    error of the scene's outputs (None: of all coordinates) that is wanted at all rows, relative to the
                    range of each over the run, instead of rtol and atol. From 1e-4 on two runs whose outputs differ
                    by less are enough, which is less work than a run at the default tolerances; else short probes
                    choose the integrator, and runs at falling tolerances follow until three of them bear it out: three
                    to five times the work of the last. The tightest is the result, with `Result.error_estimate` and
                    `Result.accuracy`. Without t_eval there are 1001 rows, evenly spread. If it cannot be reached, the
                    message says so, and what was
        sensitivities  names of parameters, of dimensions of the design, "angles.JOINT" and "rates.JOINT" of the start:
                    the run is differentiated by them, for `Result.sensitivity`. The derivatives are those of what the
                    run computes, at the steps that it takes, which are the same to the last bit with and without. The
                    first time a list takes a compile of its own
        series      what inputs follow in this run, by name, in place of the scene's series; nothing is compiled for it
        taped       whether the steps are kept, for `Result.gradient`, derivatives of a measure by any number of
                    parameters. The first time that takes a compile of its own; the motion is the same to the last bit,
                    but where steps are too long for derivatives of modes that do not move: there it is run once more
                    with shorter ones (`Result.stats`), or by an implicit method
        until_folded  whether the run of a sheet ends, with `Status.FOLDED`, where it has come to be folded flat, all
                    hinges at 0°, or at ±180° and beyond, to 1°; or where one of a loop is 30° beyond ±180°: nothing
                    keeps facets from passing through one another there. Asked after each step, so that long steps end
                    beyond. Of no effect on devices without loops, with bodies that have no plate, or with parallel axes
                    only; nor on runs to an accuracy, differentiated or taped
        max_work    of loops, before the run gives up: operations, of which a core does some 1e9 in a second. They are
                    counted, so that it gives up at the same step on every machine; None: no limit. Near singular
                    positions a step may be ten times the work of others. scipy's integrators do not heed it,
                    nor do runs to an accuracy
        books       the old name of energy_balance

        A run that does not reach its end is no exception: the Result says so (`success`, `status`,
        `message`), keeps every row up to there and adds the last state reached; so does Ctrl-C.
        Raises RequestError for arguments that make no run, and DesignError for limits that leave the start outside.
        """
        if books is not None:
            superseded("run(books=...)", "run(energy_balance=...)")
            energy_balance = books
        until_folded = checked_flag(until_folded, "until_folded")
        wanted = None if accuracy is None else checked_accuracy(accuracy, rtol, atol)
        parameters = with_series(parameters, series, self._model.series, self.parameters)
        with part_told("run", progress) as told:
            asked = (t_end, rtol, atol, t_eval, max_steps, max_step, told)
            request = self._request(*asked, energy_balance=energy_balance, max_work=max_work)
            if wanted is not None:
                request = replace(request, most_work=math.inf)  # of all its runs together, there is none
            if until_folded and self.cut_joints and not (taped or sensitivities or wanted is not None):
                request = replace(request, until=fold_over(self.mechanism, self._rings, self.joints))
            rate = checked_rate(baumgarte, has_loops=bool(self.cut_joints))
            found = differentiated(self, sensitivities, parameters, rate)
            motion = (
                self.telling.motion(parameters, rate) if energy_balance else self._motion(parameters, rate)
            )
            self._check_run(parameters, motion, request.t_end)
            telling = Telling(self, self._recipe, parameters, rate)
            if taped:
                check_taped(integrator, energy_balance or wanted is not None or found is not None, rate)
                tape = tape_of(self, parameters)
                return self._integrated(integrator, replace(request, tape=tape), motion, telling)[0]

            made: list[Made] = []

            def run(name: str, asked: Request) -> tuple[Result, float]:
                result, effort = self._integrated(name, asked, motion, telling)
                made.append(Made(result, name, asked))
                return result, effort

            if found is not None and wanted is None and not energy_balance:
                along = replace(request, along=found.along)
                return self._integrated(integrator, along, motion, telling, found)[0]
            if wanted is None:
                result = run(integrator, request)[0]
            else:
                result = reach(wanted, integrator, motion, request, run, self.scene)
            if found is None:
                return result
            plain = self._motion(parameters, rate)
            return with_derivatives(
                result,
                made,
                found,
                lambda name, asked: self._integrated(name, asked, plain, telling, found)[0],
            )

    def _request(
        self,
        t_end: float | str | None,
        rtol: float | None,
        atol: float | None,
        t_eval: npt.ArrayLike | None,
        max_steps: int,
        max_step: float | str | None,
        progress: Progress | None,
        *,
        energy_balance: bool = False,
        max_work: float | None = None,
    ) -> Request:
        """What `run` and `ensemble` are asked for, checked."""
        if t_end is None:
            t_end = self.scene.duration or DURATION
        tolerances = (RTOL if rtol is None else rtol, ATOL if atol is None else atol)
        return checked_request(
            self.start, t_end, *tolerances, t_eval, max_steps, max_step, progress, energy_balance, max_work
        )

    def _check_run(self, parameters: Mapping[str, float | str], motion: Motion, t_end: float) -> None:
        """Whether effects can do what is asked for, at the line of the scene that says so."""
        with located_at(self.scene.places):
            motion.following.check_run(t_end)
            plain = {name: each for name, each in parameters.items() if name not in self._model.series}
            limited = with_limits(self.mechanism, checked_parameters(plain, self.parameter_units))
            if limited is not self.mechanism:
                check_start(self.effects, limited, motion, self.start)
            check_run(self.effects, self.mechanism, motion, self.start, t_end)

    def ensemble(
        self,
        t_end: float | str | None = None,
        rtol: float | None = None,
        atol: float | None = None,
        t_eval: npt.ArrayLike | None = None,
        integrator: str = "auto",
        parameters: Mapping[str, npt.ArrayLike] = NO_PARAMETERS,
        angles: Mapping[str, npt.ArrayLike] = NO_PARAMETERS,
        rates: Mapping[str, npt.ArrayLike] = NO_PARAMETERS,
        *,
        max_steps: int = 1_000_000,
        max_step: float | str | None = None,
        progress: Progress | bool | None = None,
        threads: int | None = None,
        side_by_side: bool = True,
    ) -> "Ensemble":
        """Many runs at once, each with values of its own, several side by side on each processor. Every instance is the
        run that `run` makes with its values, to the last bit where the compiler contracts nothing.

        parameters  by name, in the units of `parameter_units`: an array with a value for each instance, or one number,
                    or text with a unit, for all; the others keep their defaults
        angles, rates  at the start, by joint, rad and rad/s, likewise, in place of the scene's; loops are closed around
                    them as `start` is, which takes milliseconds for an instance
        t_eval      times of the rows, s, as for `run`; None: the start and t_end. All rows are kept in memory
        progress    called with (instances begun, instances) now and then; True: a bar
        threads     None: one for each processor
        side_by_side  False: one run after the other on each thread, for comparison

        t_end, rtol, atol, integrator, max_steps and max_step as for `run`; of integrators lamc's own. Implicit ones,
        and mechanisms with loops of more than ten hinges, run one after the other on each thread; `Ensemble.stats` says
        so. An instance that fails is one with its `status`, and NaN in the rows that it did not reach; Ctrl-C keeps
        what there is. The first call compiles code for this very machine.

        Raises RequestError for arguments that make no ensemble, BuildError where the compiler fails."""
        from lamc.run.ensembles import ensemble_of

        with part_told("ensemble", progress) as told:
            request = self._request(t_end, rtol, atol, t_eval, max_steps, max_step, told)
            given = (parameters, angles, rates)
            return ensemble_of(self, request, integrator, given, threads, side_by_side=side_by_side)

    def integrated(
        self, motion: Motion, parameters: Mapping[str, float | str], request: Request, integrator: str
    ) -> Result:
        """A run of `motion`, which has these parameters, from a start of its own. Checks nothing."""
        return self._integrated(integrator, request, motion, Telling(self, self._recipe, parameters, 0.0))[0]


def _settled(value: _T | Callable[[], _T]) -> _T:
    """The value, or what it gives when it is a function without arguments."""
    return value() if callable(value) else value
