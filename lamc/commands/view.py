"""`lamc view`: a page that shows designs in motion, plates, and finished runs.

In: a `ViewOrder`. Out: one file of HTML, and a line that names it. What a page holds is the business of `lamc.view`.
"""

from dataclasses import dataclass, replace
from pathlib import Path

from lamc.basics.errors import LamcError, SimulationError
from lamc.basics.files import checked_path
from lamc.basics.times import Times
from lamc.commands.dimensions import of_run
from lamc.commands.export_plate import check_example, is_plate_source
from lamc.commands.finished import finished_run
from lamc.commands.inputs import (
    Loaded,
    SceneChanges,
    Source,
    changed_scene,
    folder_name,
    load_source,
    mechanism_of,
)
from lamc.commands.plate_input import PlateSource
from lamc.commands.plate_input import load_source as load_plate
from lamc.commands.plate_work import answers
from lamc.commands.terminal import Progress, Terminal
from lamc.export.pages import compared, mechanism_show, open_page, result_show
from lamc.pipeline import compile as compile_design
from lamc.run.length import length_of
from lamc.run.result import Result
from lamc.view.document import MOST_BYTES, Show, write_page
from lamc.view.plates import report_show

RUN, PLATE, DEVICE = "run", "plate", "device"
_MOST_SHOWS = 12  # on one page


@dataclass(frozen=True)
class ViewOrder:
    """What `lamc view` was asked for."""

    sources: tuple[Source, ...]
    changes: SceneChanges
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
    unused = _unused(order)
    times = Times()
    with terminal.progress() as progress:
        times.observer = progress.stage
        labels = _labels(order.sources)
        shows = [
            _show(source, order, label, times, progress)
            for source, label in zip(order.sources, labels, strict=True)
        ]
        if len(shows) > 1:
            shows = [replace(s, notes=tuple(f"{s.data['label']}: {note}" for note in s.notes)) for s in shows]
        shows[0] = replace(shows[0], notes=(*unused, *shows[0].notes))
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


def _labels(sources: tuple[Source, ...]) -> list[str]:
    """What stands above each of several: names, or paths where these are alike; folders of runs often are."""
    if len(sources) == 1:
        return [""]
    names = [source.example or Path(source.file or "").name for source in sources]
    alike = [names.count(name) > 1 for name in names]
    return [s.file or n if twice else n for s, n, twice in zip(sources, names, alike, strict=True)]


def _kind(source: Source) -> str:
    """What is named. Raises LamcError for an example that is not there."""
    if source.file is not None and Path(source.file).is_dir():
        return RUN
    if is_plate_source(source):
        return PLATE
    check_example(source)
    return DEVICE


def _unused(order: ViewOrder) -> list[str]:
    """Notes on what options do not change. Raises LamcError where they change nothing on the page."""
    changes = order.changes
    options = {
        "--scene": changes.scene, "--with": changes.with_effects, "--without": changes.without_effects,
        "--angle": changes.angles, "--rate": changes.rates, "--branch": changes.branch,
        "--set": order.sources[0].settings, "--t-end": order.t_end,
    }  # fmt: skip
    given = [name for name, value in options.items() if value not in (None, (), [])]
    of_runs = [
        name for name in given if name != "--set"
    ]  # which may be of the design, and is refused if it is not
    if order.fold and of_runs:
        raise LamcError(
            f"{', '.join(of_runs)} with --fold: nothing runs, and folding begins as drawn; leave out one"
        )
    given += ["--fold"] if order.fold else []
    fixed = [source for source in order.sources if given and _kind(source) != DEVICE]
    notes = []
    for source in fixed:
        name = source.file or source.example
        what = f"{name} is {'a finished run' if _kind(source) == RUN else 'a plate'}"
        if len(fixed) == len(order.sources):
            raise LamcError(
                f"{', '.join(given)}: {what}, which this does not change; leave it out, or name a design"
            )
        notes.append(f"{what}: {', '.join(given)} changed nothing in it.")
    return notes


def _show(source: Source, order: ViewOrder, label: str, times: Times, progress: Progress) -> Show:
    budget = MOST_BYTES // len(order.sources)
    kind = _kind(source)
    if kind == RUN:
        result, notes = finished_run(Path(source.file or ""), source, times, progress)
        show = result_show(result, live=order.live, label=label, budget=budget)
        return replace(show, notes=(*show.notes, *notes))
    if kind == PLATE:
        file, origin = load_plate(PlateSource(source.file, source.example))
        return report_show(answers(file, origin, None, "auto", times), label=label)
    loaded = load_source(source, times, progress, of_run=not order.fold)
    if order.fold:
        return mechanism_show(mechanism_of(loaded, times, progress), label)
    result, remark = _run(loaded, source, order, times, progress)
    with times.stage("model"):
        show = result_show(result, live=order.live, label=label, budget=budget)
    return replace(show, failed="", notes=(*show.notes, remark)) if remark else show


def _run(
    loaded: Loaded, source: Source, order: ViewOrder, times: Times, progress: Progress
) -> tuple[Result, str]:
    """The run, and why it ended before its time where nobody says how long it is."""
    mechanism = mechanism_of(loaded, times, progress)
    scene, _ = changed_scene(mechanism, order.changes)
    simulator = compile_design(mechanism, scene, source.options, times)
    parameters = dict(of_run(loaded.settings, simulator.parameter_units, list(loaded.record.parameters)))
    length = length_of(order.t_end, None, simulator)
    if length.t_end <= 0.0:
        raise LamcError(
            f"--t-end is {length.t_end:g} s; it must be above zero, or leave the run out by --fold"
        )
    rows = length.rows(len(simulator.start))
    with times.stage("run"):
        ran = length.run(simulator, rows, parameters=parameters, progress=progress.part)
    return ran.result, ran.remark
