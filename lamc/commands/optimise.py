"""`lamc optimise`: finds parameters of a design for which a measure is least, and writes how it got there.

In: an `OptimiseOrder`. Out: files in a folder, a summary, an exit code. What was run is kept where it was interrupted.
"""

import time
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from lamc.basics.errors import LamcError, SimulationError
from lamc.basics.numbers import duration
from lamc.basics.times import Times
from lamc.commands.inputs import (
    Loaded,
    SceneChanges,
    Source,
    folder_name,
    load_source,
    output_folder,
    scene_of,
)
from lamc.commands.pairs import pairs_of
from lamc.commands.quick_imports import quick_imports
from lamc.commands.terminal import INTERRUPTED, Terminal
from lamc.readers.study_file import StudyFile, is_study, load_study
from lamc.report.look import Look
from lamc.report.optimum_text import optimum_summary
from lamc.studies.bench import RunOptions
from lamc.studies.making import AS_EVER
from lamc.studies.optimise import ATOL, RTOL
from lamc.studies.optimum import Best
from lamc.studies.search import search_of
from lamc.studies.storage import MANIFEST, ROWS
from lamc.studies.table import need_xarray


@dataclass(frozen=True)
class OptimiseOrder:
    """What `lamc optimise` was asked for; None and () where nothing was."""

    source: Source
    changes: SceneChanges
    vary: tuple[str, ...]  # NAME=RANGE
    minimise: tuple[str, ...]
    subject_to: tuple[str, ...]
    method: str | None
    start: tuple[str, ...]  # NAME=VALUE
    starts: int | None
    seed: int | None
    max_runs: int | None
    run: RunOptions
    resume: bool
    to: tuple[str, ...]
    pictures: bool
    look: Look
    out: str | None
    workers: int | None = None


@dataclass(frozen=True)
class _Asked:
    """What is asked for in all: by options, and by the study file, over which options go."""

    source: Source
    changes: SceneChanges
    vary: Mapping[str, object]
    minimise: tuple[str, ...]
    subject_to: tuple[str, ...]
    method: str
    start: Mapping[str, float | str]
    starts: int
    seed: int
    max_runs: int
    run: RunOptions
    file: StudyFile | None = None


def optimise(order: OptimiseOrder, terminal: Terminal) -> int:
    """Searches, writes, reports. Returns 0, 3 if it did not converge, 130 after Ctrl-C."""
    if "netcdf" in order.to:
        need_xarray()  # before hours of work
    times = Times()
    began = time.monotonic()
    with terminal.progress() as progress:
        times.observer = progress.stage
        asked = _asked(order)
        try:
            loaded = load_source(asked.source, times, progress, of_run=True)
            goals = asked.minimise[0] if len(asked.minimise) == 1 else list(asked.minimise)
            with times.stage("compile"):
                search = search_of(
                    loaded.record,
                    asked.vary,
                    goals or "",
                    asked.subject_to,
                    scene_of(asked.changes),
                    run=replace(asked.run, parameters=loaded.settings),
                    options=asked.source.options,
                ).asked(asked.method, asked.start, asked.starts, asked.seed, asked.max_runs)
        except LamcError as error:
            if asked.file is None:
                raise
            raise asked.file.located(error) from error
        with output_folder(order.out, f"{folder_name(loaded.name)}_optimise") as folder:
            with times.stage("optimise"):
                workers = search.workers(order.workers)
                best = search.run(folder, workers, resume=order.resume, progress=progress.part)
            with times.stage("write"):
                files = [MANIFEST, ROWS, *_write(best, folder, order)]
    spent = duration(time.monotonic() - began)
    terminal.say(
        f"design    {loaded.name}\n{optimum_summary(best)}\n\nfiles     {folder}: {', '.join(files)}\ntime      {spent}"
    )
    terminal.result(_data(best, loaded) | {"folder": str(folder), "files": files})
    if best.interrupted:
        terminal.error(f"interrupted; go on with --resume --out {folder}")
        return INTERRUPTED
    if not best.converged:
        terminal.error(f"not converged: {best.message}")
        return SimulationError.exit_code
    return 0


def _asked(order: OptimiseOrder) -> _Asked:
    """What the words come to. Raises LamcError for what is there twice over."""
    vary = pairs_of(order.vary, "--vary", "20mm:60mm")
    start = pairs_of(order.start, "--start", "30mm")
    path = order.source.file
    if path is None or not is_study(Path(path)):
        return _Asked(
            order.source,
            order.changes,
            vary,
            order.minimise,
            order.subject_to,
            order.method or "auto",
            start,
            5 if order.starts is None else order.starts,
            order.seed or 0,
            5000 if order.max_runs is None else order.max_runs,
            _tight(order.run),
        )
    if order.source.example is not None:
        raise LamcError(f"{path} is a study, which names its design; leave out --example")
    return _by_file(order, load_study(Path(path)), vary, start)


def _by_file(
    order: OptimiseOrder, file: StudyFile, vary: Mapping[str, str], start: Mapping[str, str]
) -> _Asked:
    said = file.said
    if not said.vary and not vary:
        raise LamcError(
            f"{file.path} names points, and an optimum is looked for in ranges: give it vary: {{…}}"
        )
    options = {name: value for name, value in vars(order.run).items() if value != getattr(AS_EVER, name)}
    settings = {**said.set, **pairs_of(order.source.settings, "--set", "0.01")}
    own = (said.minimise,) if isinstance(said.minimise, str) else tuple(said.minimise or ())
    return _Asked(
        source=replace(
            order.source,
            file=file.design,
            example=said.example,
            settings=tuple(f"{name}={value}" for name, value in settings.items()),
        ),
        changes=replace(order.changes, scene=order.changes.scene or file.scene),
        vary={**said.vary, **vary},
        minimise=order.minimise or own,
        subject_to=(*said.subject_to, *order.subject_to),
        method=order.method or said.method,
        start={**said.start, **start},
        starts=said.starts if order.starts is None else order.starts,
        seed=said.seed if order.seed is None else order.seed,
        max_runs=said.max_runs if order.max_runs is None else order.max_runs,
        run=_tight(replace(RunOptions(**(said.run.model_dump() if said.run is not None else {})), **options)),
        file=file,
    )


def _tight(run: RunOptions) -> RunOptions:
    """With the tolerances of an optimisation where nothing is said."""
    return replace(
        run, rtol=RTOL if run.rtol is None else run.rtol, atol=ATOL if run.atol is None else run.atol
    )


def _write(best: Best, folder: Path, order: OptimiseOrder) -> list[str]:
    """Writes the history and pictures. Returns their names."""
    made = []
    for kind in order.to:
        write, name = {
            "csv": (best.write_csv, "history.csv"),
            "netcdf": (best.write_netcdf, "history.nc"),
        }[kind]
        made.append(write(folder / name).name)
    if order.pictures:
        with quick_imports():
            from lamc.report.optimum_pictures import draw_optimum
        made.append(draw_optimum(best, folder / f"optimum.{order.look.format}").name)
    return made


def _data(best: Best, loaded: Loaded) -> dict[str, Any]:
    """The answer to --json."""
    return {
        "ok": best.converged,
        "design": loaded.name,
        "source": loaded.origin,
        "runs": best.runs,
        "method": best.method,
        "converged": best.converged,
        "message": best.message,
        "parameters": [
            {
                "name": name,
                "value": value,
                "unit": best.units[name],
                "known_to": best.known_to.get(name),
                "one_percent": best.moves.get(name),
            }
            for name, value in best.parameters.items()
        ],
        "goals": [
            {"text": goal.text, "value": value, "unit": goal.unit}
            for goal, value in zip(best.problem.goals, best.values, strict=True)
        ],
        "constraints": dict(best.constraints),
        "active": [{"what": what, "multiplier": force} for what, force in best.multipliers.items()],
        "curvature": best.curvature.tolist(),
        "front": None
        if best.on_front is None
        else [
            {"parameters": best.problem.space.values_at(t.point), "goals": list(t.goals)}
            for t in (best.problem.trials[k] for k in best.on_front)
        ],
    }
