"""The files of `lamc plate`: fields for other programs, and pictures.

In: a `PlateReport` and a folder. Out: files, written whole or not at all, and their names. Names of cases and regions
reach a file's name only as letters, digits and "._-".
"""

import json
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from lamc.basics.checks import Array
from lamc.basics.numbers import shown_number
from lamc.commands.inputs import folder_name
from lamc.commands.terminal import Progress
from lamc.readers.plates.field_files import write_table, write_vtu
from lamc.report.laminate_picture import draw_stack
from lamc.report.plate_contours import Field
from lamc.report.plate_records import MODES, CaseReport, PlateReport, buckling_key
from lamc.report.plate_shape_text import off_text
from lamc.report.plates import draw_deflection, draw_fields, draw_mesh, draw_modes

SUMMARY = "summary.json"
_AXES = ("x", "y", "xy")
_MADE = (
    "deflection",
    "displacement",
    "moments",
    "forces",
    "stress",
    "mesh",
    "stack",
    "modes",
    "buckling",
    "fields",
)
_ENDS = (".png", ".csv", ".vtu", ".json")


def write_files(report: PlateReport, folder: Path, *, pictures: bool, progress: Progress) -> Iterator[str]:
    """Every file but summary.json, one after the other, by name. Raises LamcError where one cannot be written."""
    with report.times.stage("write"):
        yield from _write_fields(report, folder)
    if not pictures:
        return
    with report.times.stage("draw"):
        title = report.file.name
        everything = report.cases[0].solution.loads if len(report.cases) == 1 else report.problem.loads
        yield draw_mesh(report.problem, folder / "mesh.png", title, everything).name
        yield from _draw_stacks(report, folder)
        for number, case in enumerate(report.cases):
            yield from _draw_case(report, case, folder)
            progress.part(number + 1, len(report.cases) + 1)
        yield from _draw_shapes(report, folder)


def own_files(folder: Path) -> set[str]:
    """Files of an earlier run in this folder, by its summary; only names that lamc itself gives."""
    try:
        summary_data = json.loads((folder / SUMMARY).read_text(encoding="utf-8"))
        listed = [str(name) for name in summary_data["files"]] if "lamc_version" in summary_data else []
    except (OSError, ValueError, KeyError, TypeError):
        return set()
    return {
        name
        for name in listed
        if name == folder_name(name) and name.startswith(_MADE) and name.endswith(_ENDS)
    }


def _named(stem: str, name: str, end: str, taken: set[str]) -> str:
    """A file's name with that of a case or region in it, different from all that are taken."""
    base = f"{stem}_{folder_name(name)}" if name else stem
    found, number = f"{base}{end}", 2
    while found in taken:
        found, number = f"{base}_{number}{end}", number + 1
    taken.add(found)
    return found


def _write_fields(report: PlateReport, folder: Path) -> Iterator[str]:
    mesh = report.problem.mesh
    columns: dict[str, Array] = {}
    of_points: dict[str, Array] = {}
    of_cells: dict[str, Array] = {"region": mesh.regions.astype(np.int64)}
    for case in report.cases:
        before = f"{case.name}: " if case.name else ""
        unknowns = _at_points(case)
        for name, (unit, values) in unknowns.items():
            columns[f"{before}{name} [{unit or '-'}]"] = values
        moved = [unknowns[n][1] if n in unknowns else np.zeros(len(mesh.points)) for n in "uvw"]
        of_points[f"{before}displacement"] = np.column_stack(moved)
        for name, found in (("moments", case.fields.moments), ("forces", case.fields.forces)):
            if found is not None:
                of_cells[f"{before}{name}"] = found.mean(axis=1)
        of_cells[f"{before}stress"] = case.fields.stress.max(axis=1)
        of_cells[f"{before}error energy"] = case.estimate.cells
    if report.modes is not None:
        for k, shape in enumerate(report.modes.shapes.T[:, : len(mesh.points)]):
            none = np.zeros(len(mesh.points))
            of_points[f"mode {k + 1}"] = np.column_stack([none, none, np.nan_to_num(shape)])
    yield write_table(mesh, columns, folder / "fields.csv").name
    yield write_vtu(mesh, of_points, of_cells, folder / "fields.vtu").name


def _at_points(case: CaseReport) -> dict[str, tuple[str, Array]]:
    """Unknowns at the mesh's points, by name, with unit; those that points do not have are left out."""
    solution = case.solution
    count = len(solution.problem.mesh.points)
    units = {"u": "m", "v": "m", "w": "m", "w_x": "", "w_y": ""}
    found = {}
    for name, unit in units.items():
        if name in solution.problem.dofs.names:
            values = solution.at_nodes(name)[:count]
            if not np.isnan(values).all():
                found[name] = (unit, values)
    return found


def _draw_stacks(report: PlateReport, folder: Path) -> Iterator[str]:
    """A picture of each laminate that differs."""
    taken: set[str] = set()
    problem = report.problem
    for index, laminate in enumerate(problem.laminates):
        if any(laminate == other for other in problem.laminates[:index]):
            continue
        region = problem.mesh.region_names[index] if len(problem.laminates) > 1 else ""
        name = _named("stack", region, ".png", taken)
        yield draw_stack(laminate, folder / name, region or report.file.name).name


def _draw_case(report: PlateReport, case: CaseReport, folder: Path) -> Iterator[str]:
    problem, solution, fields = report.problem, case.solution, case.fields
    title = f"{report.file.name}: {case.name}" if case.name else report.file.name

    def path(stem: str) -> Path:
        return folder / (f"{stem}_{folder_name(case.name)}.png" if case.name else f"{stem}.png")

    unknowns = _at_points(case)
    if "w" in unknowns:
        drawn = draw_deflection(problem, unknowns["w"][1], path("deflection"), title, solution.loads)
        yield drawn.name
    if "u" in unknowns:
        plane = [Field(f"displacement {name}", "m", unknowns[name][1]) for name in ("u", "v")]
        yield draw_fields(problem, plane, path("displacement"), title).name
    for stem, letter, unit, values in (
        ("moments", "M", "N·m/m", fields.moments),
        ("forces", "N", "N/m", fields.forces),
    ):
        if values is not None:
            parts = [Field(f"${letter}_{{{a}}}$", unit, values[..., k]) for k, a in enumerate(_AXES)]
            yield draw_fields(problem, parts, path(stem), title).name
    stress = [Field("largest von Mises stress of all plies", "Pa", fields.stress, signed=False)]
    if fields.tsai_wu is not None and not np.isnan(fields.tsai_wu).any():
        stress.append(Field("largest Tsai-Wu index, 1 at failure", "", fields.tsai_wu, signed=False))
    yield draw_fields(problem, stress, path("stress"), title).name


def _draw_shapes(report: PlateReport, folder: Path) -> Iterator[str]:
    count = len(report.problem.mesh.points)
    if report.modes is not None:
        pairs = zip(report.modes.frequencies, report.shapes[MODES].errors, strict=True)
        summary_data = [
            f"{k + 1}: {shown_number(float(f), 'Hz', 4)}{off_text(float(error))}"
            for k, (f, error) in enumerate(pairs)
        ]
        shapes = np.nan_to_num(report.modes.shapes[:count])
        yield (
            draw_modes(
                report.problem, shapes, summary_data, folder / "modes.png", f"{report.file.name}: modes"
            ).name
        )
    taken: set[str] = set()
    for name, buckled in report.buckling.items():
        if len(buckled.factors):
            pairs = zip(buckled.factors, report.shapes[buckling_key(name)].errors, strict=False)
            summary_data = [
                f"{k + 1}: {factor:.5g} times the loads{off_text(float(error))}"
                for k, (factor, error) in enumerate(pairs)
            ]
            shapes = np.nan_to_num(buckled.shapes[:count, : len(summary_data)])
            title = f"{report.file.name}: buckling" + (f", {name}" if name else "")
            path = folder / _named("buckling", name, ".png", taken)
            yield draw_modes(report.problem, shapes, summary_data, path, title).name
