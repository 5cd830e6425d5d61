"""`lamc run`: simulates a design and writes results and pictures, and a film where one is asked for.

In: a `RunOrder`. Out: files in a folder, a summary, an exit code. What was computed is written also where the run was
interrupted or failed.
"""

import json
import warnings
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

from lamc.basics._version import __version__
from lamc.basics.errors import DesignWarning, LamcError, SimulationError
from lamc.basics.files import write_text
from lamc.basics.renewal import digests, renewed
from lamc.basics.times import Times
from lamc.commands.dimensions import declared, given, of_run
from lamc.commands.inputs import (
    Loaded,
    SceneChanges,
    Source,
    changed_scene,
    load_source,
    mechanism_of,
    output_folder,
)
from lamc.commands.pairs import share_of
from lamc.commands.quick_imports import quick_imports
from lamc.commands.run_folder import MANIFEST, own_manifest, run_folder
from lamc.commands.terminal import INTERRUPTED, Progress, Terminal, plain
from lamc.effects.registry import Choice
from lamc.pipeline import compile as compile_design
from lamc.records.design import Design
from lamc.records.effect import conserves
from lamc.report.look import FORMATS, Look
from lamc.report.loops_text import loops_data
from lamc.report.parameters_text import parameters_data
from lamc.report.run_text import RunReport, energy_drift, summary
from lamc.run.defaults import MAX_STEPS
from lamc.run.files import energy_balance_data, write_csv, write_npz
from lamc.run.length import Length, Ran, length_of
from lamc.run.outputs import outputs_of
from lamc.run.request import Status
from lamc.run.result import Result
from lamc.run.simulator import Simulator

FILES = (
    *("results.npz", "results.csv", MANIFEST),
    *(f"{name}.{kind}" for name in ("angles_energy", "folded") for kind in FORMATS),
    *("animation.mp4", "animation.gif"),
)

_DRAWINGS = (".fold", ".svg", ".dxf")  # for which --facets is
# How runs of rigid facets end that fit badly: their equations part, or no step is short enough.
_APART = (Status.CLOSURE_LOST, Status.STEP_UNDERFLOW, Status.RANK_LOST)
_LIMIT_NUMBERS = 100_000_000  # that can be asked for: 0.8 GB for the table alone


@dataclass(frozen=True)
class RunOrder:
    """What `lamc run` was asked for."""

    source: Source
    changes: SceneChanges
    t_end: float | None  # s; None: see `length_of`
    accuracy: str | None  # 1e-3 or "0.1 %"; None: rtol and atol say
    rtol: float | None
    atol: float | None
    integrator: str
    points: int | None  # rows; 0: one after every step; None: `Length.rows`
    max_steps: int | None  # None: see `length_of`
    film: bool
    pictures: bool
    look: Look
    energy_balance: bool
    verbose: bool  # whether absent effects have a line each
    out: str | None


def run(order: RunOrder, terminal: Terminal) -> int:
    """Runs, writes, reports. Returns 0, 3 for a run that failed, 130 after Ctrl-C."""
    times = Times()
    with terminal.progress() as progress:
        times.observer = progress.stage
        _check_points(order.points, 0)
        loaded = load_source(order.source, times, progress, of_run=True)
        out, remark = run_folder(order.out, loaded, order.changes.scene)
        with output_folder(out, loaded.name) as folder:
            made, apart = _of_facets(order, _made(order, loaded, times, progress), times, progress)
            report = _report(made, times, order.changes.scene, tuple(r for r in (remark, apart) if r))
            files, interrupted = _write_all(order, report, folder, times, progress)
    terminal.say(summary(report, folder, files, verbose=order.verbose))
    terminal.result(_data(report) | {"folder": str(folder), "files": files})
    return _ending(made.result, folder, terminal, interrupted=interrupted, is_enough=bool(made.enough))


@dataclass(frozen=True)
class _Made:
    """A run, of what, and why it is enough where it ended before its time. facets: of a sheet, where they are others
    than the options say."""

    loaded: Loaded
    simulator: Simulator
    account: tuple[Choice, ...]
    result: Result
    enough: str
    facets: str | None = None


def _made(order: RunOrder, loaded: Loaded, times: Times, progress: Progress) -> _Made:
    mechanism = mechanism_of(loaded, times, progress)
    scene, account = changed_scene(mechanism, order.changes)
    simulator = compile_design(mechanism, scene, order.source.options, times)
    length = length_of(order.t_end, _steps(order), simulator)
    _check_points(order.points, len(simulator.start))
    parameters = of_run(loaded.settings, simulator.parameter_units, list(loaded.record.parameters))
    with times.stage("run"):
        ran = _simulate(order, length, simulator, dict(parameters), progress)
    return _Made(loaded, simulator, account, ran.result, ran.remark)


def _of_facets(order: RunOrder, made: _Made, times: Times, progress: Progress) -> tuple[_Made, str]:
    """A run, or one of facets that bend in its place where rigid ones came apart that nobody asked for, or did not come
    off, and the other got farther; and what is told of that."""
    misfit, path = made.simulator.loops.misfit, made.loaded.path
    is_stuck = made.result.status == Status.STEP_LIMIT and not made.result.stats.accepted
    if (
        (made.result.status not in _APART and not is_stuck)
        or made.simulator.loops.accepted_gap == 0.0
        or misfit is None
    ):
        return made, ""
    asked = order.source.sheet.facets is not None or order.changes.branch is not None
    if asked or path is None or path.suffix.lower() not in _DRAWINGS:
        return made, ""
    try:
        bent = _made(order, _of_bending(order, times, progress), times, progress)
    except LamcError:
        return made, ""
    same = len(bent.simulator.mechanism.bodies) == len(made.simulator.mechanism.bodies)
    if same or bent.result.t[-1] <= made.result.t[-1]:
        return made, ""
    return replace(bent, facets="bend"), (
        f"rigid facets came apart at t = {made.result.t[-1]:.3g} s, as {misfit.text}: this is a run of facets that "
        "bend, which have more freedoms and may fold another way; --facets rigid has the other, and a drawing of more "
        "digits needs neither"
    )


def _of_bending(order: RunOrder, times: Times, progress: Progress) -> Loaded:
    """The same drawing; what was assumed of it has been told."""
    source = replace(order.source, sheet=replace(order.source.sheet, facets="bend"))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DesignWarning)
        return load_source(source, times, progress, of_run=True)


def _steps(order: RunOrder) -> int | None:
    """Tried at most; None: nobody says, and an early end is as good. An accuracy is asked for of the whole run."""
    return MAX_STEPS if order.max_steps is None and order.accuracy is not None else order.max_steps


def _check_points(points: int | None, size: int) -> None:
    """Raises LamcError for a number of rows that makes no table, or one that no memory should be asked for."""
    if points is None:
        return
    if points < 0 or points == 1:
        raise LamcError(f"--points is {points}; it must be 2 or more, or 0 for every step")
    most = _LIMIT_NUMBERS // (size + 2)
    if points > most:
        raise LamcError(
            f"--points is {points}; at most {most} rows are written, {_LIMIT_NUMBERS} numbers in all: ask for fewer"
        )


def _ending(result: Result, folder: Path, terminal: Terminal, *, interrupted: bool, is_enough: bool) -> int:
    """The exit code, and a word on stderr where it is not 0. is_enough: it ended where it was to, if not at its end."""
    if result.status == Status.CANCELLED:
        terminal.error(f"{result.message}; see {folder}")
        return INTERRUPTED
    if interrupted:
        terminal.error(f"interrupted while results were written; see {folder}")
        return INTERRUPTED
    if not result.success and not is_enough:
        terminal.error(f"{result.message}; what was computed until then is in {folder}")
        return SimulationError.exit_code
    return 0


def _simulate(
    order: RunOrder, length: Length, simulator: Simulator, parameters: dict[str, float], progress: Progress
) -> Ran:
    return length.run(
        simulator,
        length.rows(len(simulator.start)) if order.points is None else order.points,
        rtol=order.rtol,
        atol=order.atol,
        accuracy=None if order.accuracy is None else share_of(order.accuracy, "--accuracy"),
        integrator=order.integrator,
        parameters=parameters,
        progress=progress.part,
        energy_balance=order.energy_balance,
    )


def _report(made: _Made, times: Times, scene: str | None, remarks: tuple[str, ...]) -> RunReport:
    loaded, account, result = made.loaded, made.account, made.result
    conservative = all(conserves(c.effect, result.energies) for c in account if c.effect is not None)
    return RunReport(
        source=loaded.origin,
        source_digest=loaded.digest,
        beside=loaded.record.beside if isinstance(loaded.record, Design) else (),
        simulator=made.simulator,
        result=result,
        account=account,
        times=times,
        drift=energy_drift(result) if conservative else None,
        scene=scene,
        remarks=remarks,
        enough=made.enough,
        facets=made.facets,
        dimensions=declared(loaded.record),
        given=given(loaded.record),
    )


def _write_all(
    order: RunOrder, report: RunReport, folder: Path, times: Times, progress: Progress
) -> tuple[list[str], bool]:
    """Writes every file in the place of an earlier run's. Returns their names, and whether Ctrl-C cut it short."""
    result = report.result
    files: list[str] = []
    interrupted = False
    with renewed(folder, MANIFEST, _own_files) as staged:
        try:
            with times.stage("write results"):
                files += [write_npz(result, staged / "results.npz", manifest=False).name]
                files += [write_csv(result, staged / "results.csv", manifest=False).name]
            if order.pictures and len(result.t):
                with times.stage("draw"):
                    files += _draw(result, staged, order.look)
            if order.film and len(result.t) > 1:  # of a run that failed, up to there
                with times.stage("animate"):
                    files += [_animate(result, staged, order.look, progress)]
        except KeyboardInterrupt:
            interrupted = True
        sums = digests(staged, files)
        files.append(MANIFEST)
        manifest = _data(report) | {"files": files, "sha256": sums, "interrupted": interrupted}
        write_text(staged / MANIFEST, json.dumps(plain(manifest), indent=2, ensure_ascii=False) + "\n")
    return files, interrupted


def _draw(result: Result, folder: Path, look: Look) -> list[str]:
    """Draws the pictures. Returns their names."""
    with quick_imports():  # matplotlib takes half as long to import as all the rest of a run
        from lamc.report.folded import draw_folded
        from lamc.report.plots import draw_angles_energy
    return [
        draw_angles_energy(result, folder / f"angles_energy.{look.format}").name,
        draw_folded(result, folder / f"folded.{look.format}", look).name,
    ]


def _animate(result: Result, folder: Path, look: Look, progress: Progress) -> str:
    with quick_imports():
        from lamc.report.animation import draw_animation
    return draw_animation(result, folder, lambda k, n: progress.part(k, n), look=look).name


def _own_files(folder: Path) -> set[str]:
    """Files of an earlier run in this folder, by its manifest; only names that lamc itself gives."""
    listed = own_manifest(folder).get("files", ())
    return {str(name) for name in listed if isinstance(listed, list)} & set(FILES)


def _data(report: RunReport) -> dict[str, Any]:
    """The report as plain data: the manifest, and the answer to --json."""
    result, mechanism, simulator = report.result, report.simulator.mechanism, report.simulator
    return {
        "ok": result.success or bool(report.enough),
        "complete": result.success,
        "design": mechanism.name,
        "lamc_version": __version__,
        "source": report.source,
        "source_sha256": report.source_digest,
        "beside_sha256": dict(report.beside),
        "program_digest": result.provenance.digest,
        "compiler": result.provenance.compiler,
        "flags": list(result.provenance.flags),
        "status": result.status.name.lower(),
        "message": result.message,
        "rows": len(result.t),
        "t_reached": float(result.t[-1]) if len(result.t) else 0.0,
        "bodies": [{"name": b.name, "fixed": b.fixed, "mass": b.mass} for b in mechanism.bodies],
        "joints": list(simulator.joints),
        "freedoms": simulator.freedoms,
        **({"facets": report.facets} if report.facets else {}),
        "loops": loops_data(simulator.loops, simulator.branches),
        "scene": report.scene,
        "scenes": list(mechanism.scenes),
        "outputs": [
            {"name": each.name, "unit": each.unit, "end": float(each.values[-1])}
            for each in outputs_of(result, simulator.scene)
            if len(each.values)
        ],
        "effects": [{"name": c.name, "in": c.effect is not None, "why": c.reason} for c in report.account],
        "angles": dict(simulator.scene.angles),
        "rates": dict(simulator.scene.rates),
        "branch": simulator.scene.branch,
        "design_parameters": parameters_data(report.dimensions),
        "design_parameters_set": dict(report.given),
        "parameters": dict(result.provenance.parameters),
        **({"series": dict(result.provenance.series)} if result.provenance.series else {}),
        "parameter_units": dict(simulator.parameter_units),
        "notes": list(report.notes),
        "stats": asdict(result.stats),
        "error_estimate": result.error_estimate,
        "accuracy": None if result.accuracy is None else asdict(result.accuracy),
        "seconds": dict(report.times.seconds),
        "from_cache": report.times.from_cache,
        "energy_drift": report.drift,
        "books": energy_balance_data(result),
    }
