"""`lamc modes`: where a design rests, and the vibrations about it.

In: a `ModesOrder`. Out: modes.json, modes.csv and a picture in a folder, a table, an exit code.
"""

import csv
import io
import json
from dataclasses import dataclass
from typing import Any

from lamc.basics.errors import LamcError
from lamc.basics.files import write_text
from lamc.basics.renewal import renewed
from lamc.basics.times import Times
from lamc.commands.dimensions import of_run
from lamc.commands.inputs import (
    SceneChanges,
    Source,
    changed_scene,
    folder_name,
    load_source,
    mechanism_of,
    output_folder,
)
from lamc.commands.quick_imports import quick_imports
from lamc.commands.terminal import Terminal
from lamc.pipeline import compile as compile_design
from lamc.report.look import FORMATS, Look
from lamc.report.modes_text import modes_data, modes_table, modes_text
from lamc.run.vibration import Modes

DATA, TABLE = "modes.json", "modes.csv"
FILES = (DATA, TABLE, *(f"modes.{kind}" for kind in FORMATS))


@dataclass(frozen=True)
class ModesOrder:
    """What `lamc modes` was asked for."""

    source: Source
    changes: SceneChanges
    count: int
    stable: bool
    damping: bool
    at: float | None  # s, of loads that depend on time
    amplitude: float  # rad, of the pictures
    pictures: bool
    look: Look
    out: str | None


def modes(order: ModesOrder, terminal: Terminal) -> int:
    """Finds, writes, prints. Returns 0; SimulationError where there is no equilibrium."""
    if order.count < 1:
        raise LamcError(f"--count is {order.count}; it must be 1 or more")
    times = Times()
    with terminal.progress() as progress:
        times.observer = progress.stage
        loaded = load_source(order.source, times, progress, of_run=True)
        mechanism = mechanism_of(loaded, times, progress)
        scene, _ = changed_scene(mechanism, order.changes)
        simulator = compile_design(mechanism, scene, order.source.options, times)
        parameters = of_run(loaded.settings, simulator.parameter_units, list(loaded.record.parameters))
        with times.stage("modes"):
            point = simulator.equilibrium(parameters=parameters, t=order.at, stable=order.stable)
            found = simulator.modes(point, damping=order.damping)
        data = modes_data(found, simulator.model.name, loaded.origin)
        with (
            output_folder(order.out, f"{folder_name(loaded.name)}_modes") as folder,
            renewed(folder, DATA, lambda _: set(FILES)) as staged,
        ):
            files = [DATA, TABLE]
            write_text(staged / TABLE, _csv(found))
            if order.pictures:
                with quick_imports():
                    from lamc.report.modes_picture import draw_modes
                name = f"modes.{order.look.format}"
                draw_modes(found, staged / name, order.count, order.amplitude, order.look)
                files.append(name)
            write_text(staged / DATA, json.dumps(data, indent=1, ensure_ascii=False) + "\n")
    terminal.say(f"{modes_text(found, order.count)}\n\nfiles        {folder}: {', '.join(files)}")
    terminal.result({"ok": True, **data, "folder": str(folder), "files": files})
    return 0


def _csv(found: Modes) -> str:
    """All modes, a row each; numbers read back exactly."""
    text = io.StringIO()
    rows: list[list[Any]] = modes_table(found)
    csv.writer(text, lineterminator="\n").writerows(rows)
    return text.getvalue()
