"""`lamc split`: the bodies and joints of a design as tables, files and a picture.

In: a design, or a mechanism that is split already. Out: NAME.mechanism.yaml; NAME.joints and a picture where there are
polygons: split.png of a design, bodies.png of a mechanism. Hinges are as stiff as the file says, or as their material
makes them; then a table says where each stiffness comes from.
"""

from pathlib import Path
from typing import TYPE_CHECKING

from lamc.basics.errors import DesignError
from lamc.basics.renewal import renewed
from lamc.basics.times import Times
from lamc.commands.dimensions import declared
from lamc.commands.hinge_choice import account_of
from lamc.commands.inputs import Source, folder_name, load_source, output_folder
from lamc.commands.terminal import Progress, Terminal
from lamc.design.split import named_hinges, split_steps
from lamc.loops.at_start import drawn_loops, loops_of
from lamc.loops.work import SOON, check_work
from lamc.mechanism.plan import plan
from lamc.readers.joint_definition import drawn_layers, drawn_lines
from lamc.readers.joints_layers import layers_of
from lamc.readers.joints_writer import write_joints, write_split
from lamc.readers.load import load_definition
from lamc.readers.mechanism_file import write_mechanism
from lamc.records.design import Design
from lamc.records.mechanism import Mechanism
from lamc.report.bodies_picture import draw_bodies
from lamc.report.hinges_text import cut_data, cut_lines, hinge_data, hinge_table
from lamc.report.loops_text import branch_lines, loops_data, loops_line
from lamc.report.parameters_text import parameters_data, parameters_line
from lamc.report.split_picture import draw_split
from lamc.report.split_text import split_data, split_text

if TYPE_CHECKING:
    from lamc.plates.designs.hinges import MaterialHinge


def split(source: Source, out: str | None, terminal: Terminal) -> int:
    """Splits, writes, prints."""
    times = Times()
    notes: list[str] = []
    account: tuple[MaterialHinge, ...] = ()
    with terminal.progress() as progress:
        times.observer = progress.stage
        loaded = load_source(source, times, progress)
        name = folder_name(loaded.name)
        files: list[str] = []
        reported = f"{name}.mechanism.yaml"
        with output_folder(out, loaded.name) as folder, renewed(folder, reported, lambda _: set()) as staged:
            if isinstance(loaded.record, Design):
                progress.stage("hinges")
                account = account_of(loaded.record, source.hinges, notes)
                mechanism = _split_design(loaded.record, staged, name, files, notes, progress)
            else:
                mechanism = loaded.record
                _export_mechanism(mechanism, loaded.path, (folder, staged), name, files, notes)
            files.append(reported)
            write_mechanism(mechanism, staged / reported)
    text = split_text(mechanism, notes)
    parameters = declared(loaded.record)
    data = split_data(mechanism, notes)
    loops, data["loops"] = _loops(mechanism, large=source.options.large)
    drawn = named_hinges(loaded.record) if isinstance(loaded.record, Design) else ()
    hinges, cuts = hinge_table(account), cut_lines(drawn)
    data["parameters"] = parameters_data(parameters)
    data["cuts"] = cut_data(drawn)
    dimensions = f"parameters: {parameters_line(parameters)}" if parameters else ""
    if account:
        data["hinge_stiffness"] = hinge_data(account)
    terminal.say("\n\n".join(part for part in (text, dimensions, cuts, hinges, loops) if part))
    terminal.say(f"\nfiles   {folder}: {', '.join(files)}")
    terminal.result({"ok": True, "folder": str(folder), "files": files, **data})
    return 0


def _loops(mechanism: Mechanism, *, large: bool) -> tuple[str, dict[str, object] | None]:
    """What the loops come to, and the branches of a drawn position that is singular; nothing for a tree."""
    if len(mechanism.joints) <= sum(not body.fixed for body in mechanism.bodies):
        return "", None
    tolerance = mechanism.scene.closure_tolerance if mechanism.scene is not None else None
    try:
        check_work(mechanism, SOON, large=large)
        count, branches = drawn_loops(plan(mechanism), tolerance)
        if count.misfit is not None and mechanism.scene is not None and any(mechanism.scene.angles.values()):
            count = loops_of(
                plan(mechanism), mechanism.scene
            )  # drawn nearly flat, weak equations look like a misfit
    except DesignError as error:  # what was split is written all the same
        return f"note: the loops were not counted: {error.message}", None
    return "\n".join([loops_line(count), *branch_lines(branches, "as drawn")]), loops_data(count, branches)


def _split_design(
    design: Design, folder: Path, name: str, files: list[str], notes: list[str], progress: Progress
) -> Mechanism:
    progress.stage("split")
    steps = split_steps(design, lambda _name, part: progress.part(part, 1.0))
    notes += steps.notes
    try:
        write_split(steps, folder / f"{name}.joints")
        files.append(f"{name}.joints")
    except DesignError as error:  # the format cannot say it
        notes.append(f"no joint definition was written: {error.message}")
    progress.stage("draw")
    draw_split(steps, folder / "split.png")
    files.append("split.png")
    return steps.mechanism


def _export_mechanism(
    mechanism: Mechanism,
    source: Path | None,
    folders: tuple[Path, Path],
    name: str,
    files: list[str],
    notes: list[str],
) -> None:
    """The joint definition and the picture of a mechanism whose bodies have plates; else a note.

    folders: that of the results, and that in which they are made
    """
    if not any(body.outline for body in mechanism.bodies):
        notes.append("the file holds a mechanism already: no joint definition and no picture were made")
        return
    folder, staged = folders
    target = staged / f"{name}.joints"
    definition = load_definition(source) if source is not None else None
    lines = drawn_lines(definition) if definition is not None else {}
    try:
        if source is not None and (folder / target.name).resolve() == source.resolve():
            raise DesignError("it would replace the file that was read; name another folder with --out")
        layers = drawn_layers(definition) if definition is not None else layers_of(mechanism)
        write_joints(mechanism, layers, target, lines=lines)
        files.append(target.name)
        if definition is None:
            notes.append(
                "the file holds a mechanism already: the layers of the joint definition are those of its plates, "
                "and their densities follow from the masses"
            )
    except DesignError as error:  # the format cannot say it
        notes.append(f"no joint definition was written: {error.message}")
    draw_bodies(mechanism, lines, staged / "bodies.png")
    files.append("bodies.png")
