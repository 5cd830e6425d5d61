"""`lamc sweep`: runs a design at many points, and writes a table of what was measured, and its picture.

In: a `SweepOrder`. Out: files in a folder, a summary, an exit code. What was computed is kept where it was interrupted.
"""

import time
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from lamc.basics.errors import LamcError, SimulationError
from lamc.basics.numbers import duration
from lamc.commands.inputs import (
    Loaded,
    SceneChanges,
    Source,
    changed_scene,
    folder_name,
    load_source,
    output_folder,
)
from lamc.commands.pairs import pairs_of
from lamc.commands.quick_imports import quick_imports
from lamc.commands.terminal import INTERRUPTED, Terminal
from lamc.pipeline import Times
from lamc.records.design import Design
from lamc.records.mechanism import Mechanism
from lamc.records.scene import Scene
from lamc.report.look import Look
from lamc.report.study_text import study_summary
from lamc.studies.bench import MISSING, OK, RunOptions
from lamc.studies.storage import MANIFEST, ROWS
from lamc.studies.study import study_of, workers_of
from lamc.studies.table import Table, need_xarray

KINDS = ("csv", "netcdf", "zarr")


@dataclass(frozen=True)
class SweepOrder:
    """What `lamc sweep` was asked for."""

    source: Source
    changes: SceneChanges
    vary: tuple[str, ...]  # NAME=RANGE
    measures: tuple[str, ...]  # EXPRESSION or NAME=EXPRESSION
    settings: tuple[str, ...]  # NAME=NUMBER of parameters
    points: str | None  # a CSV file
    sample: str | None  # METHOD:COUNT
    seed: int
    run: RunOptions
    workers: int | None
    resume: bool
    yes: bool
    to: tuple[str, ...]
    pictures: bool
    look: Look
    out: str | None


def sweep(order: SweepOrder, terminal: Terminal) -> int:
    """Runs, writes, reports. Returns 0, 3 if no point went well, 130 after Ctrl-C."""
    if "netcdf" in order.to or "zarr" in order.to:
        need_xarray()  # before hours of work
    times = Times()
    began = time.monotonic()
    with terminal.progress() as progress:
        times.observer = progress.stage
        loaded = load_source(order.source, times, progress)
        record, run = _with_settings(loaded.record, order)
        with times.stage("compile"):
            study = study_of(
                record,
                pairs_of(order.vary, "--vary", "20mm:60mm:9"),
                _measures(order.measures),
                _scene(order.changes),
                sample=order.sample,
                seed=order.seed,
                points=order.points,
                run=run,
                options=order.source.options,
            )
        workers = workers_of(order.workers)
        if not order.yes:
            study.check_size(workers)
        with output_folder(order.out, f"{folder_name(loaded.name)}_sweep") as folder, times.stage("sweep"):
            table = study.run(folder, workers, resume=order.resume, progress=progress.part)
        with times.stage("write"):
            files = [MANIFEST, ROWS, *_write(table, folder, order)]
    tally = table.tally()
    terminal.say(
        f"{study_summary(table)}\n\nfiles     {folder}: {', '.join(files)}\n"
        f"time      {duration(time.monotonic() - began)}, {workers} process{'es' * (workers > 1)}"
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


def _with_settings(record: Design | Mechanism, order: SweepOrder) -> tuple[Design | Mechanism, RunOptions]:
    """The design with the dimensions that --set gives, and the runs with its other numbers."""
    given = pairs_of(order.settings, "--set", "0.01")
    dimensions = {name: value for name, value in given.items() if name in record.parameters}
    others = {name: value for name, value in given.items() if name not in dimensions}
    return (record.with_parameters(dimensions) if dimensions else record), replace(
        order.run, parameters=others
    )


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
    if not found:
        raise LamcError("nothing is measured; name a measure, such as --measure 'max(tip.z)'")
    return found


def _scene(changes: SceneChanges) -> Any:
    """What gives the scene of a mechanism; None: it is its own."""
    return None if changes == SceneChanges() else partial(_changed, changes=changes)


def _changed(mechanism: Mechanism, changes: SceneChanges) -> Scene:
    return changed_scene(mechanism, changes)[0]


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
    tally = table.tally()
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
            }
            for name, values in table.values.items()
        ],
    }
