"""`lamc sweep`: runs a design at many points, and writes a table of what was measured, and its picture.

In: a `SweepOrder`. Out: files in a folder, a summary, an exit code. What was computed is kept where it was interrupted.
"""

import time
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

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
from lamc.examples import study_files
from lamc.readers.study_file import StudyFile, is_study, load_study
from lamc.report.look import Look
from lamc.report.study_text import study_summary
from lamc.studies.bench import MISSING, OK, RunOptions
from lamc.studies.making import AS_EVER, study_of
from lamc.studies.statistics import indices
from lamc.studies.storage import MANIFEST, ROWS
from lamc.studies.table import Table, need_xarray, need_zarr

KINDS = ("csv", "netcdf", "zarr")


@dataclass(frozen=True)
class SweepOrder:
    """What `lamc sweep` was asked for."""

    source: Source
    changes: SceneChanges
    vary: tuple[str, ...]  # NAME=RANGE
    measures: tuple[str, ...]  # EXPRESSION or NAME=EXPRESSION
    points: str | None  # a CSV file
    sample: str | None  # METHOD:COUNT
    seed: int | None
    run: RunOptions
    workers: int | None
    scheduler: str | None
    resume: bool
    yes: bool
    to: tuple[str, ...]
    pictures: bool
    look: Look
    out: str | None


def sweep(order: SweepOrder, terminal: Terminal) -> int:
    """Runs, writes, reports. Returns 0, 3 if no point went well, 130 after Ctrl-C."""
    for kind, need in (("netcdf", need_xarray), ("zarr", need_zarr)):
        if kind in order.to:
            need()  # before hours of work
    times = Times()
    began = time.monotonic()
    with terminal.progress() as progress:
        times.observer = progress.stage
        asked = _asked(order)
        try:
            loaded = load_source(asked.source, times, progress, of_run=True)
            with times.stage("compile"):
                study = study_of(
                    loaded.record,
                    asked.vary,
                    asked.measures,
                    scene_of(asked.changes),
                    sample=asked.sample,
                    seed=asked.seed,
                    points=asked.points,
                    run=replace(asked.run, parameters=loaded.settings),
                    options=asked.source.options,
                )
        except LamcError as error:
            if asked.file is None:
                raise
            raise asked.file.located(error) from error
        workers = study.workers(order.workers)
        if not order.yes:
            study.check_size(workers)
        with output_folder(order.out, f"{folder_name(loaded.name)}_sweep") as folder, times.stage("sweep"):
            table = study.run(
                folder, workers, resume=order.resume, progress=progress.part, scheduler=order.scheduler
            )
        with times.stage("write"):
            files = [MANIFEST, ROWS, *_write(table, folder, order)]
    tally = table.tally()
    terminal.say(
        f"{study_summary(table)}\n\nfiles     {folder}: {', '.join(files)}\n"
        f"time      {duration(time.monotonic() - began)}, {_who(order, workers)}"
    )
    terminal.result(_data(table, loaded) | {"folder": str(folder), "files": files})
    if MISSING in tally:
        terminal.error(
            f"interrupted; {tally[MISSING]} points are missing: go on with --resume --out {folder}"
        )
        return INTERRUPTED
    if OK not in tally:
        terminal.error("no point went well; table.csv has the reasons")
        return SimulationError.exit_code
    return 0


def study_path(study: str, file: str | None, example: str | None) -> str:
    """The file of a study that ships. Raises LamcError where a design or another study is named too."""
    if file is not None or example is not None:
        raise LamcError(f"--study {study} names its design; leave out {file or f'--example {example}'}")
    return str(study_files.path(study))


def copy_study(study: str | None, folder: str, terminal: Terminal) -> int:
    """Writes the files of a study that ships. Returns 0."""
    if study is None:
        raise LamcError(f"--copy needs --study NAME: {', '.join(study_files.names())}")
    made = study_files.copied(study, Path(folder))
    terminal.say(f"files     {folder}: {', '.join(path.name for path in made)}")
    terminal.result({"files": [str(path) for path in made]})
    return 0


def _who(order: SweepOrder, workers: int) -> str:
    return (
        f"{workers} process{'es' * (workers > 1)}"
        if order.scheduler is None
        else f"cluster {order.scheduler}"
    )


@dataclass(frozen=True)
class _Asked:
    """What is asked for in all: by options, and by the study file, over which options go."""

    source: Source
    changes: SceneChanges
    vary: Mapping[str, object]
    measures: Mapping[str, str]
    points: str | None
    sample: str | None
    seed: int
    run: RunOptions
    file: StudyFile | None = None


def _asked(order: SweepOrder) -> _Asked:
    """What the words come to. Raises LamcError for what is there twice over."""
    vary, measures = pairs_of(order.vary, "--vary", "20mm:60mm:9"), _measures(order.measures)
    path = order.source.file
    if path is None or not is_study(Path(path)):
        given = (order.source, order.changes, vary, measures, order.points, order.sample)
        return _Asked(*given, order.seed or 0, order.run)
    if order.source.example is not None:
        raise LamcError(f"{path} is a study, which names its design; leave out --example")
    file = load_study(Path(path))
    said = file.said
    options = {name: value for name, value in vars(order.run).items() if value != getattr(AS_EVER, name)}
    settings = {**said.set, **pairs_of(order.source.settings, "--set", "0.01")}
    points = order.points or (None if vary else file.points)
    return _Asked(
        source=replace(order.source, file=file.design, example=said.example, settings=_pairs(settings)),
        changes=replace(order.changes, scene=order.changes.scene or file.scene),
        vary=vary if points is not None else {**said.vary, **vary},
        measures={**said.measure, **measures},
        points=points,
        sample=order.sample or said.sample,
        seed=said.seed if order.seed is None else order.seed,
        run=replace(RunOptions(**(said.run.model_dump() if said.run is not None else {})), **options),
        file=file,
    )


def _pairs(settings: Mapping[str, float | str]) -> tuple[str, ...]:
    """As --set has them."""
    return tuple(f"{name}={value}" for name, value in settings.items())


def _measures(texts: tuple[str, ...]) -> dict[str, str]:
    """By name; one without a name has its text as name."""
    found: dict[str, str] = {}
    for text in texts:
        name, sign, expression = text.partition("=")
        name, expression = (name.strip(), expression) if sign else (text.strip(), text)
        if name in found:
            raise LamcError(
                f"--measure gives {name[:40]!r} twice; keep one of them, or name it: NAME=EXPRESSION"
            )
        found[name] = expression
    return found


def _write(table: Table, folder: Path, order: SweepOrder) -> list[str]:
    """Writes tables and pictures. Returns their names."""
    made = []
    for kind in order.to:
        write, name = {
            "csv": (table.write_csv, "table.csv"),
            "netcdf": (table.write_netcdf, "table.nc"),
            "zarr": (table.write_zarr, "table.zarr"),
        }[kind]
        made.append(write(folder / name).name)
    with quick_imports():
        from lamc.report.study_pictures import MOST_POINTS, draw_study
    if order.pictures and table.count <= MOST_POINTS:
        made.append(draw_study(table, folder / f"study.{order.look.format}").name)
    return made


def _data(table: Table, loaded: Loaded) -> dict[str, Any]:
    """The answer to --json."""
    tally, shares = table.tally(), indices(table)
    return {
        "ok": OK in tally and MISSING not in tally,
        "design": table.design,
        "source": loaded.origin,
        "points": table.count,
        "statuses": tally,
        "varied": [{"name": name, "unit": table.units[name]} for name in table.plan.names],
        "measures": [
            {
                "name": name,
                "unit": table.units[name],
                "least": float(np.nanmin(values)) if np.isfinite(values).any() else None,
                "most": float(np.nanmax(values)) if np.isfinite(values).any() else None,
                **(
                    {"first_order": s.first.tolist(), "total": s.total.tolist()}
                    if (s := shares.get(name))
                    else {}
                ),
            }
            for name, values in table.values.items()
        ],
    }
