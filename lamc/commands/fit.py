"""`lamc fit`: finds numbers of a model from recordings, and writes them as a scene.

In: a `FitOrder`. Out: files in a folder, a summary, an exit code.
"""

import json
import time
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any

from lamc.basics.errors import LamcError, SimulationError
from lamc.basics.files import write_text
from lamc.basics.numbers import duration
from lamc.basics.times import Times
from lamc.basics.yaml_text import dump
from lamc.commands.inputs import SceneChanges, Source, changed_scene, folder_name, load_source, output_folder
from lamc.commands.pairs import split_pair
from lamc.commands.quick_imports import quick_imports
from lamc.commands.terminal import Progress, Terminal, plain
from lamc.fitting.answer import Fit
from lamc.fitting.compared import Compared
from lamc.fitting.fit import answered
from lamc.fitting.mapped import Asked, own_names, recording_of
from lamc.fitting.simulators import Simulators
from lamc.readers.recordings import read_recording
from lamc.readers.scene_writer import scene_data
from lamc.records.mechanism import Mechanism
from lamc.records.recording import Recording
from lamc.records.scene import Scene
from lamc.report.fit_text import candidates_data, candidates_text, fit_data, fit_summary
from lamc.report.look import Look

SCENE = "scene.yaml"


@dataclass(frozen=True)
class FitOrder:
    """What `lamc fit` was asked for."""

    source: Source
    changes: SceneChanges
    data: tuple[str, ...]
    maps: tuple[str, ...]  # NAME=WHAT
    free: tuple[str, ...]  # NAME or NAME=RANGE
    hold_out: tuple[str, ...]
    start: str
    frame: str | None
    unit: str | None
    loss: str
    starts: int
    seed: int
    pictures: bool
    film: bool
    look: Look
    design: tuple[str, ...]  # candidates
    out: str | None


def fit(order: FitOrder, terminal: Terminal) -> int:
    """Fits, writes, reports. Returns 0, or 3 if it did not converge."""
    times = Times()
    began = time.monotonic()
    with terminal.progress() as progress:
        times.observer = progress.stage
        loaded = load_source(order.source, times, progress, of_run=True)
        with times.stage("compile"):
            simulators = Simulators(loaded.record, _scene(order.changes), order.source.options)
        free = _free(order.free)
        asked = _asked(order, own_names(free))
        with times.stage("read"):
            names = _names((*order.data, *(path for path in order.hold_out if path not in order.data)))
            found = {path: _recording(path, names[path], order, asked, simulators) for path in names}
            kept = [path for path in order.data if path not in order.hold_out]
            if not order.data:
                raise LamcError("name recordings with --data FILE: CSV, or exports of Tracker or Motive")
            if not kept:
                raise LamcError("all recordings are held back; name one with --data that is not")
        with times.stage("fit"):
            shared = {name: given for name, given in free.items() if name not in own_names(free)}
            answer = answered(
                simulators,
                [found[path][0] for path in kept],
                shared,
                loaded.settings,
                order.loss,
                order.starts,
                order.seed,
            )
            held = [answer.held_back(found[path][0]) for path in order.hold_out]
            more = answer.candidates(order.design) if order.design else ()
        with output_folder(order.out, f"{folder_name(loaded.name)}_fit") as folder, times.stage("write"):
            files = _write(answer, held, folder, loaded.name, order)
            files += _filmed(answer, folder, order, progress)
    unread = sorted({column for path in names for column in found[path][1]})
    left = f"not read   {', '.join(unread[:12])}\n\n" if unread else ""
    sets = "".join(f" --set {name}={value!r}" for name, value in answer.dimensions.items())
    way = f"run it     lamc run {loaded.path or f'--example {loaded.name}'}{sets} --scene {folder / SCENE}"
    terminal.say(
        f"design     {loaded.name}\n{fit_summary(answer, held)}\n\n{candidates_text(more)}{left}{way}\nfiles   "
        f"   {folder}: "
        f"{', '.join(files)}\n"
        f"time       {duration(time.monotonic() - began)}"
    )
    terminal.result(
        {
            "ok": answer.converged,
            "design": loaded.name,
            **fit_data(answer, held),
            "candidates": candidates_data(more),
            "folder": str(folder),
            "files": files,
        }
    )
    if not answer.converged:
        terminal.error(f"not converged: {answer.message}")
        return SimulationError.exit_code
    return 0


def _recording(
    path: str, name: str, order: FitOrder, asked: Asked, simulators: Simulators
) -> tuple[Recording, tuple[str, ...]]:
    clock = next((column for column, what in asked.maps.items() if what == "t"), None)
    return recording_of(read_recording(path, clock, order.unit or ""), name, simulators.usual, asked)


def _names(paths: tuple[str, ...]) -> dict[str, str]:
    """Names of recordings by path: those of the files, told apart."""
    if len(set(paths)) != len(paths):
        raise LamcError(f"--data names {max(paths, key=paths.count)!r} twice; once is enough")
    found: dict[str, str] = {}
    for path in paths:
        name = base = Path(path).stem or "run"
        count = 1
        while name in found.values():
            count += 1
            name = f"{base}_{count}"
        found[path] = name
    return found


def _free(texts: tuple[str, ...]) -> dict[str, object]:
    found: dict[str, object] = {}
    for text in texts:
        name, given = split_pair(text, "--free", "1e-4:1e-1") if "=" in text else (text, None)
        if name in found:
            raise LamcError(f"--free names {name!r} twice; keep one of them")
        found[name] = given
    return found


def _asked(order: FitOrder, own: Mapping[str, object]) -> Asked:
    maps: dict[str, str] = {}
    for text in order.maps:
        name, what = split_pair(text, "--map", "link_2@(30mm,0,0)")
        if name in maps:
            raise LamcError(f"--map gives {name!r} twice; keep one of them")
        maps[name] = what
    frame = tuple(each.strip() for each in order.frame.split(",")) if order.frame else None
    for name, given in own.items():
        if not given:
            raise LamcError(f"--free {name} needs a range: --free {name}=LOW:HIGH")
    return Asked(maps, {name: str(given) for name, given in own.items()}, order.start, frame)


def _scene(changes: SceneChanges) -> Any:
    """What gives the scene of a mechanism; None: it is its own."""
    return None if changes == SceneChanges() else partial(_changed, changes=changes)


def _changed(mechanism: Mechanism, changes: SceneChanges) -> Scene:
    return changed_scene(mechanism, changes)[0]


def _write(answer: Fit, held: list[Compared], folder: Path, name: str, order: FitOrder) -> list[str]:
    """Writes scene, numbers, pictures and the page. Returns their names."""
    write_text(folder / SCENE, scene_text(answer, name))
    write_text(
        folder / "fit.json", json.dumps(plain(fit_data(answer, held)), indent=2, ensure_ascii=False) + "\n"
    )
    files = [SCENE, "fit.json"]
    pictures: list[tuple[str, bytes]] = []
    if order.pictures:
        with quick_imports():
            from lamc.report.fit_pictures import draw_overlay, draw_residuals
        every = (*answer.compared, *(replace(each, name=f"{each.name}, held back") for each in held))
        for what, draw, file in (
            ("Recordings and model", draw_overlay, "overlay.png"),
            ("Residuals", draw_residuals, "residuals.png"),
        ):
            path = draw(every, folder / file)
            files.append(path.name)
            pictures.append((what, path.read_bytes()))
    from lamc.report.fit_page import fit_page

    write_text(folder / "fit.html", fit_page(f"{name}: fit", answer, held, pictures))
    return [*files, "fit.html"]


def _filmed(answer: Fit, folder: Path, order: FitOrder, progress: Progress) -> list[str]:
    """Films of all recordings, one each. Returns their names."""
    if not order.film:
        return []
    with quick_imports():
        from lamc.report.fit_film import draw_fit_film
    return [
        draw_fit_film(
            answer,
            which,
            folder,
            "overlay" if which == 0 else f"overlay_{which + 1}",
            lambda k, n: progress.part(k, n),
            look=order.look,
        ).name
        for which in range(len(answer.compared))
    ]


def scene_text(answer: Fit, name: str) -> str:
    """A scene file with the fitted numbers, for `lamc run --scene`."""
    lines = [f"# Numbers of {name!r} that `lamc fit` found; dimensions of the drawing go with --set."]
    lines += [f"#   {each} = {value!r}" for each, value in answer.dimensions.items()]
    runs = answer.setting.runs
    if len(runs) > 1:  # one scene has one start, and one number of each parameter
        for recording, of_kinds in answer.starts.items():
            for kind, unit, values in zip(("angles", "rates"), ("rad", "rad/s"), of_kinds, strict=True):
                lines += [f"# {recording} starts at {kind}.{j} = {v!r} {unit}" for j, v in values.items()]
        lines += [f"# {run.name} has {each} = {v!r}" for run in runs for each, v in run.own_numbers.items()]
    lines += [
        f"# {run.name} has {each} follow a series, which this scene does not."
        for run in runs
        for each in run.parameters
        if each not in run.own_numbers
    ]
    lines += [
        f"# {run.name} starts at {run.begin!r} s of its clock; a run by this scene starts at 0."
        for run in runs
        if run.begin
    ]
    lines += [f"# Not told by these data: {each}" for each in answer.unidentifiable]
    safe = ["".join(c if c.isprintable() else " " for c in line) for line in lines]
    return "\n".join(safe) + "\n" + dump({"kind": "scene", **scene_data(answer.scene)})
