"""`lamc export`: the simulator of a design, or the finite elements of a plate, as files for other programs.

In: an `ExportOrder`. Out: a folder, and a list of what is in it. What is written is the business of `lamc.export`.
"""

from dataclasses import dataclass
from pathlib import Path

from lamc.commands.export_plate import edge_length, files_of_plate, is_plate_source
from lamc.commands.export_plate import load as load_plate
from lamc.commands.inputs import SceneChanges, Source, changed_scene, folder_name, load_source, mechanism_of
from lamc.commands.terminal import Progress, Terminal
from lamc.errors import ExportError
from lamc.export import TARGETS, Files
from lamc.export.folder import Origin, write_folder
from lamc.export.options import ExportOptions
from lamc.pipeline import Times
from lamc.places import told_at
from lamc.run.request import did_you_mean


@dataclass(frozen=True)
class ExportOrder:
    """What `lamc export` was asked for."""

    source: Source
    changes: SceneChanges
    target: str  # of `lamc.export.TARGETS`, or "list"
    prefix: str | None
    real_time: bool
    libm: bool
    precision: str
    single_header: bool
    integrator: str
    fmi: int | None
    step: float | None  # s
    size: str | None  # of the edges of a plate's mesh
    lossy: bool
    inputs: str  # hinges, none, or names with commas between
    force: bool
    out: str | None

    @property
    def options(self) -> ExportOptions:
        """Raises ExportError for values that make none."""
        return ExportOptions(
            prefix=self.prefix,
            integrator=self.integrator,
            real_time=self.real_time,
            libm=self.libm,
            precision=self.precision,
            single_header=self.single_header,
            fmi=self.fmi,
            step=self.step,
            edge_length=edge_length(self.size),
            lossy=self.lossy,
            inputs=self.inputs
            if self.inputs in ("hinges", "none")
            else tuple(name.strip() for name in self.inputs.split(",")),
        )


def export(order: ExportOrder, terminal: Terminal) -> int:
    """Writes the folder, and says what it holds."""
    if order.target == "list":
        return _list_targets(terminal)
    if order.target not in TARGETS:
        raise ExportError(
            f"--to: no target is named {order.target[:40]!r}; {did_you_mean(order.target, list(TARGETS))}"
        )
    options = order.options
    times = Times()
    with terminal.progress() as progress:
        times.observer = progress.stage
        if is_plate_source(order.source):
            made = _plate(order, options, times)
        else:
            made = _mechanism(order, options, times, progress)
        folder_of = folder_name(f"{made.name[:50]}_{order.target}")
        folder = Path(order.out) if order.out is not None else Path("out") / folder_of
        written = write_folder(folder, made.files, Origin(made.name, order.target), force=order.force)
    files, effects = made.files, made.effects
    sizes = {path: len(files[path]) for path in sorted(files)}
    lines = [f"folder    {folder}"]
    lines += [
        f"{'files' if k == 0 else '':<10}{path:<32} {_size(n)}" for k, (path, n) in enumerate(sizes.items())
    ]
    if effects is not None:
        left_out = "; README.md lists what of them is left out" if options.lossy else ""
        lines += [f"effects   {', '.join(effects) or 'none'}{left_out}"]
    step = TARGETS[order.target].step(str(folder), files, options)
    lines += [f"next      {step}"]
    terminal.say("\n".join(lines))
    data = {
        "ok": True,
        "design": made.name,
        "target": order.target,
        "folder": str(folder),
        "files": list(written),
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


def _mechanism(order: ExportOrder, options: ExportOptions, times: Times, progress: Progress) -> _Made:
    loaded = load_source(order.source, times, progress)
    mechanism = mechanism_of(loaded, times, progress)
    scene, _ = changed_scene(mechanism, order.changes)
    with told_at(scene.places), times.stage("export"):
        target = TARGETS[order.target]
        files = target.files(mechanism, scene, options)
        return _Made(loaded.name, files, target.effects(mechanism, scene, options))


def _plate(order: ExportOrder, options: ExportOptions, times: Times) -> _Made:
    with times.stage("load"):
        plate = load_plate(order.source)
    with times.stage("export"):
        return _Made(plate.name, files_of_plate(plate, order.target, order.changes, options), None)


def _list_targets(terminal: Terminal) -> int:
    terminal.say("\n".join(f"{name:<7} {target.summary}" for name, target in TARGETS.items()))
    terminal.result({"ok": True, "targets": {name: target.summary for name, target in TARGETS.items()}})
    return 0


def _size(count: int) -> str:
    return f"{count / 1000:8.1f} kB"
