"""`lamc export`: the simulator of a design, or the finite elements of a plate, as files for other programs.

In: an `ExportOrder`. Out: a folder, and a list of what is in it. What is written is the business of `lamc.export`.
"""

from dataclasses import dataclass
from pathlib import Path

from lamc.basics.errors import ExportError
from lamc.basics.places import located_at
from lamc.basics.times import Times
from lamc.commands.export_plate import check_example, files_of_plate, is_plate_source
from lamc.commands.export_plate import load as load_plate
from lamc.commands.inputs import SceneChanges, Source, changed_scene, folder_name, load_source, mechanism_of
from lamc.commands.terminal import Progress, Terminal
from lamc.export import TARGETS, Files
from lamc.export.folder import Origin, write_folder
from lamc.export.options import ExportOptions
from lamc.run.request import did_you_mean


@dataclass(frozen=True)
class ExportOrder:
    """What `lamc export` was asked for."""

    source: Source
    changes: SceneChanges
    target: str  # of `lamc.export.TARGETS`, or "list"
    options: ExportOptions
    force: bool
    out: str | None


def inputs_of(text: str) -> str | tuple[str, ...]:
    """What --inputs says: hinges, none, or names with commas between."""
    return text if text in ("hinges", "none") else tuple(name.strip() for name in text.split(","))


def export(order: ExportOrder, terminal: Terminal) -> int:
    """Writes the folder, and says what it holds."""
    if order.target == "list":
        return _list_targets(terminal)
    if order.target not in TARGETS:
        raise ExportError(
            f"--to: no target is named {order.target[:40]!r}; {did_you_mean(order.target, list(TARGETS))}"
        )
    times = Times()
    with terminal.progress() as progress:
        times.observer = progress.stage
        made = _plate(order, times) if is_plate_source(order.source) else _mechanism(order, times, progress)
        folder_of = f"{folder_name(made.name[:50])}_{order.target}"
        folder = Path(order.out) if order.out is not None else Path("out") / folder_of
        written = write_folder(folder, made.files, Origin(made.name, order.target), force=order.force)
    files, effects = made.files, made.effects
    sizes = {path: len(files[path]) for path in sorted(files)}
    lines = [f"folder    {folder}"]
    lines += [
        f"{'files' if k == 0 else '':<10}{path:<32} {_size(n)}" for k, (path, n) in enumerate(sizes.items())
    ]
    told = TARGETS[order.target].notes(files)
    lines += told
    if effects is not None:
        is_listed = order.options.lossy and "README.md" in files
        left_out = "; README.md lists what of them is left out" if is_listed else ""
        lines += [f"effects   {', '.join(effects) or 'none'}{left_out}"]
    step = TARGETS[order.target].making.next_step(str(folder), files, order.options)
    lines += [f"next      {step}"]
    terminal.say("\n".join(lines))
    data = {
        "ok": True,
        "design": made.name,
        "target": order.target,
        "folder": str(folder),
        "files": list(written),
        "told": [" ".join(line.split()) for line in told],
        "next": step,
    }
    terminal.result({**data, "bytes": sizes, **({} if effects is None else {"effects": effects})})
    return 0


@dataclass(frozen=True)
class _Made:
    """Files of an export; `effects` None: there is nothing that moves."""

    name: str
    files: Files
    effects: list[str] | None


def _mechanism(order: ExportOrder, times: Times, progress: Progress) -> _Made:
    check_example(order.source)
    loaded = load_source(order.source, times, progress)
    mechanism = mechanism_of(loaded, times, progress)
    if order.changes != SceneChanges() and not TARGETS[order.target].moves:
        raise ExportError(
            f"nothing moves in an export to {order.target!r}: leave out the scene, and changes of it"
        )
    scene, _ = changed_scene(mechanism, order.changes)
    with located_at(scene.places), times.stage("export"):
        target = TARGETS[order.target]
        files = target.files(mechanism, scene, order.options)
        return _Made(loaded.name, files, target.effects(mechanism, scene, order.options))


def _plate(order: ExportOrder, times: Times) -> _Made:
    with times.stage("load"):
        plate = load_plate(order.source)
    with times.stage("export"):
        return _Made(plate.name, files_of_plate(plate, order.target, order.changes, order.options), None)


def _list_targets(terminal: Terminal) -> int:
    terminal.say("\n".join(f"{name:<7} {target.summary}" for name, target in TARGETS.items()))
    terminal.result({"ok": True, "targets": {name: target.summary for name, target in TARGETS.items()}})
    return 0


def _size(count: int) -> str:
    return f"{count / 1000:8.1f} kB"
