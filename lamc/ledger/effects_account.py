"""The account of effects: what leaving one out changes in the outputs, and what having it costs.

In: the scene, the reference run, a setting. Out: an `Account`. Model error and discretisation error are kept apart: a
scene and its variant are both run at a tight tolerance, and the variant at one ten times looser as well, whose
difference says how much of a change may be the integrator's doing. No effect is known by name here: a variant that
cannot be simulated (an effect that others need) is a row with the reason.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

from lamc.basics.errors import LamcError
from lamc.effects.registry import EFFECTS, choose
from lamc.ledger.clock import Clock, OutOfTime, processor_seconds, shortest
from lamc.ledger.making import Made, Workshop, end_run, evaluation_ns
from lamc.ledger.outputs import Errors, errors
from lamc.ledger.records import Account, EffectRow, Sweep
from lamc.ledger.reference import Truth
from lamc.ledger.runners import Own, grid
from lamc.records.effect import Effect, hooked
from lamc.records.scene import Scene
from lamc.run.result import Result

_TIGHT = 1e-10  # rtol of the runs that show model errors
_LOOSER = 10.0
_REPEATS = 0.4  # s of further turns for all rows together

Told = Callable[[float, float], None]


@dataclass(frozen=True)
class Setting:
    """How the runs are made whose cost is reported."""

    integrator: str
    rtol: float


@dataclass(frozen=True, eq=False)
class _Variant:
    """A scene beside the ledger's own: without `effects`, with them if is_added, or with another form of them."""

    effects: tuple[str, ...]
    is_added: bool
    scene: Scene
    form: str = ""


@dataclass(frozen=True, eq=False)
class _Row:
    row: EffectRow
    job: Callable[[], Result] | None  # the run that is timed


class Accounting:
    """Makes and measures the variants of one scene."""

    def __init__(
        self,
        workshop: Workshop,
        scene: Scene,
        effects: Sequence[Effect],
        truth: Truth,
        sweep: Sweep,
        clock: Clock,
    ) -> None:
        """scene, effects: the ledger's own, and what acts in it."""
        self._workshop, self._truth, self._sweep, self._clock = workshop, truth, sweep, clock
        self._scene, self._effects = (
            scene.acting(effects),
            tuple(effects),
        )
        self._waiting: list[_Variant] = []
        self._rows: list[_Row] = []  # the scene itself comes first, then a row for each of those that waited
        self._taken: _Row | None = None  # without all effects that do not matter together

    def account(self, setting: Setting, share: float, tell: Told) -> Account:
        """Every effect of the scene left out in turn, its other forms in its place, and every one added that the design
        asks for and the scene lacks; until `share` of the clock's budget is spent."""
        variants = self._waiting = self._variants()
        self._rows = [self._measure(_Variant((), False, self._scene), setting, share)]
        for k, variant in enumerate(variants):
            tell(float(k), float(len(variants)))
            self._rows.append(self._measure(variant, setting, share))
        self._rows = _repeated(self._rows)
        together = self._together([row.row for row in self._rows[1:]], setting, share)
        if together is not None and together.job is not None:
            base = self._rows[0]
            timed = _repeated([base, together])
            together = timed[1]
            seconds = min(base.row.seconds or 0.0, timed[0].row.seconds or 0.0)
            self._rows[0] = _Row(replace(base.row, seconds=seconds), None)
        self._taken = together
        found = self.so_far(setting)
        assert found is not None
        return found

    def so_far(self, setting: Setting) -> Account | None:
        """The account with what is measured of it, and a row with the reason for what is not; None where nothing is."""
        if not self._rows:
            return None
        base, *rows = (row.row for row in self._rows)
        for variant in self._waiting[len(rows) :]:
            rows.append(replace(_empty(variant), note="left out: interrupted"))
        together = self._taken.row if self._taken is not None else None
        return Account(setting.integrator, setting.rtol, base, tuple(rows), together)

    def _variants(self) -> list[_Variant]:
        kept = self._effects
        found = []
        for name in dict.fromkeys(effect.name for effect in kept):
            rest = tuple(effect for effect in kept if effect.name != name)
            found.append(_Variant((name,), False, self._scene.acting(rest)))
        for k, effect in enumerate(kept):
            for form, other in hooked(effect).alternatives().items():
                effects = (*kept[:k], other, *kept[k + 1 :])
                scene = self._scene.acting(effects)
                found.append(_Variant((effect.name,), False, scene, form))
        present = {choice.name for choice in choose(self._workshop.mechanism, self._scene) if choice.effect}
        for kind in EFFECTS:
            if kind.name not in present:
                asked, _ = kind.default_for(self._workshop.mechanism)
                if asked is not None:
                    found.append(_Variant((kind.name,), True, self._scene.acting((*kept, asked))))
        return found

    def _measure(self, variant: _Variant, setting: Setting, share: float) -> _Row:
        empty = _empty(variant)
        left = self._clock.left(share)
        if left <= 0.0:
            return _Row(replace(empty, note="left out: the budget is spent"), None)
        try:
            made = self._workshop.make(variant.scene)
            return self._filled(empty, made, setting, left)
        except LamcError as error:
            return _Row(replace(empty, note=error.message), None)
        except OutOfTime:
            return _Row(replace(empty, note="stopped: the budget is spent"), None)

    def _filled(self, empty: EffectRow, made: Made, setting: Setting, seconds: float) -> _Row:
        """The row of a variant that compiles."""
        known = replace(empty, operations=made.operations, compiling=made.seconds)
        times = grid(self._sweep.t_end, self._sweep.rows)
        runner = Own(self._truth.facts.integrator, made.simulator, times, ())
        traces = [runner.trace(rtol, self._clock, seconds) for rtol in (_TIGHT, _LOOSER * _TIGHT)]
        results = [trace.result for trace in traces if trace.result is not None]
        if len(results) < 2:
            note = next(trace.note for trace in traces if trace.result is None)
            return _Row(replace(known, note=note), None)
        tight, looser = results
        change = self._changes(tight)
        job = end_run(made.simulator, self._sweep.t_end, setting.rtol, setting.integrator)
        timed = job()
        if not timed.success:
            return _Row(replace(known, note=f"at the setting of the account: {timed.message}"), None)
        row = replace(
            known,
            succeeded=True,
            change=change.path,
            changes=change.by_output,
            discretisation=errors(looser, tight, self._truth.scales).path,
            evaluation=evaluation_ns(tight),
            steps=timed.stats.accepted,
            seconds=processor_seconds(job),
        )
        return _Row(row, job)

    def _changes(self, result: Result) -> Errors:
        """Differences from the scene's own motion."""
        return errors(result, self._truth.result, self._truth.scales)

    def _together(self, rows: Sequence[EffectRow], setting: Setting, share: float) -> _Row | None:
        """The scene without all effects that change less than the accuracy asked for. Changes may add up, so the one
        that changes most is taken back until they do not matter together."""
        idle = [
            row
            for row in rows
            if not row.is_added
            and not row.form
            and row.change is not None
            and row.change < self._sweep.accuracy
        ]
        idle.sort(key=lambda row: row.change or 0.0)
        while idle:
            names = tuple(sorted(name for row in idle for name in row.effects))
            rest = tuple(effect for effect in self._effects if effect.name not in names)
            found = self._measure(_Variant(names, False, self._scene.acting(rest)), setting, share)
            change = found.row.change
            if change is not None and change < self._sweep.accuracy:
                return found
            idle.pop()
        return None


def _empty(variant: _Variant) -> EffectRow:
    return EffectRow(variant.effects, variant.is_added, succeeded=False, form=variant.form)


def _repeated(rows: list[_Row]) -> list[_Row]:
    """The rows with the shortest of repeated runs, all in turns."""
    able = [k for k, row in enumerate(rows) if row.job is not None]
    jobs = [row.job for row in rows if row.job is not None]
    first = [rows[k].row.seconds or 0.0 for k in able]
    best = dict(zip(able, shortest(jobs, first, max(_REPEATS, 5.0 * sum(first))), strict=True))
    return [
        _Row(replace(row.row, seconds=best[k][0]), row.job) if k in best else row
        for k, row in enumerate(rows)
    ]
