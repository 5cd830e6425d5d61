"""`lamc view`: a page that shows designs in motion, plates, and finished runs.

In: a `ViewOrder`. Out: one file of HTML, and a line that names it. What a page holds is the business of `lamc.view`.
"""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from lamc.basics.errors import LamcError, SimulationError
from lamc.basics.files import checked_path
from lamc.commands.export_plate import check_example, is_plate_source
from lamc.commands.finished import finished_run
from lamc.commands.inputs import (
    SceneChanges,
    Source,
    changed_scene,
    folder_name,
    load_source,
    mechanism_of,
    parameters_of,
)
from lamc.commands.plate_input import PlateSource
from lamc.commands.plate_input import load_source as load_plate
from lamc.commands.plate_work import answers
from lamc.commands.terminal import Progress, Terminal
from lamc.export.pages import compared, mechanism_show, open_page, result_show
from lamc.pipeline import Times
from lamc.pipeline import compile as compile_design
from lamc.records.mechanism import Mechanism
from lamc.run.defaults import DURATION, default_rows
from lamc.run.result import Result
from lamc.view.document import MOST_BYTES, Show, write_page
from lamc.view.plates import report_show

_MOST_SHOWS = 12  # on one page


@dataclass(frozen=True)
class ViewOrder:
    """What `lamc view` was asked for."""

    sources: tuple[Source, ...]
    changes: SceneChanges
    settings: tuple[str, ...]  # NAME=NUMBER of parameters
    t_end: float | None  # s
    fold: bool
    live: bool
    out: str | None
    open: bool


def view(order: ViewOrder, terminal: Terminal) -> int:
    """Writes the page. Returns 0, or 3 where a run did not reach its end."""
    if not order.sources:
        raise LamcError("name a FILE, the folder of a finished run, or an example with --example NAME")
    if len(order.sources) > _MOST_SHOWS:
        raise LamcError(f"{len(order.sources)} are named; a page shows at most {_MOST_SHOWS} side by side")
    times = Times()
    with terminal.progress() as progress:
        times.observer = progress.stage
        shows = [_show(source, order, times, progress) for source in order.sources]
        with times.stage("page"):
            title = " · ".join(dict.fromkeys(show.name for show in shows))
            text = compared(shows, title)
            path = write_page(text, _path(order, title))
    size = len(text.encode())
    lines = [f"page      {path} ({size / 1000:.0f} kB)"]
    lines += [f"note      {note}" for note in dict.fromkeys(note for show in shows for note in show.notes)]
    opened = order.open and open_page(path)
    if order.open and not opened:
        lines.append("note      no browser could be asked to open it: open the file by hand")
    terminal.say("\n".join(lines))
    notes = [note for show in shows for note in show.notes]
    live = [bool(show.engine) for show in shows]
    terminal.result(
        {
            "ok": not any(show.failed for show in shows),
            "page": str(path),
            "bytes": size,
            "live": live,
            "notes": notes,
        }
    )
    for show in shows:
        if show.failed:
            terminal.error(f"{show.name}: {show.failed}; what was computed until then is in {path}")
    return SimulationError.exit_code if any(show.failed for show in shows) else 0


def _path(order: ViewOrder, title: str) -> Path:
    if order.out is not None:
        path = checked_path(order.out)
        if path.is_dir():
            raise LamcError(
                f"--out {order.out!r} is a folder; name a file, such as {order.out.rstrip('/')}/view.html"
            )
        return path
    path = Path("out") / f"{folder_name(title)}.html"
    try:
        path.parent.mkdir(exist_ok=True)
    except OSError as error:
        raise LamcError(
            f"the folder 'out' cannot be made: {error.strerror}; name a file with --out"
        ) from error
    return path


def _show(source: Source, order: ViewOrder, times: Times, progress: Progress) -> Show:
    label = "" if len(order.sources) == 1 else source.example or Path(source.file or "").name
    budget = MOST_BYTES // len(order.sources)
    if source.file is not None and Path(source.file).is_dir():
        return result_show(
            finished_run(Path(source.file), source, times, progress), live=order.live, label=label
        )
    if is_plate_source(source):
        file, origin = load_plate(PlateSource(source.file, source.example))
        return report_show(answers(file, origin, None, "auto", times), label=label)
    check_example(source)
    loaded = load_source(source, times, progress)
    mechanism = mechanism_of(loaded, times, progress)
    if order.fold:
        return mechanism_show(mechanism, label)
    result = _run(mechanism, source, order, times, progress)
    with times.stage("model"):
        return result_show(result, live=order.live, label=label, budget=budget)


def _run(mechanism: Mechanism, source: Source, order: ViewOrder, times: Times, progress: Progress) -> Result:
    scene, _ = changed_scene(mechanism, order.changes)
    simulator = compile_design(mechanism, scene, source.options, times)
    parameters = dict(parameters_of(order.settings, simulator.parameter_units))
    end = order.t_end or scene.duration or DURATION
    rows = default_rows(end, len(simulator.start))
    with times.stage("run"):
        return simulator.run(
            end, t_eval=np.linspace(0.0, end, rows), parameters=parameters, progress=progress.part
        )
