"""Plates as shows: surfaces that bend under their loads and swing in their modes, coloured by what the reader chooses.

In: a report of `lamc plate`, solutions, modes, or a problem that nobody solved. Out: a `Show`. Displacements have 16
bits, colours 8, as many as can be told apart. Never: solves.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import matplotlib as mpl
import numpy as np

from lamc.basics.checks import Array
from lamc.plates.answers.corner_fields import CornerFields, corner_fields
from lamc.plates.answers.modes import PlateModes
from lamc.plates.answers.shapes import Shapes
from lamc.plates.answers.solution import Solution
from lamc.plates.meshing.mesh import Mesh
from lamc.plates.problem import Problem
from lamc.report.plate_contours import shown_range
from lamc.report.plate_records import PlateReport
from lamc.report.plate_solid import ONE_SIGN, TWO_SIGNS, box, colours_of, rounded
from lamc.view.document import Show

_TALL = 0.16  # of the plate's size: the largest displacement as it is drawn at first
_PERIOD = 3.0  # s of a showing: a load comes and goes, or a mode swings once
_LEVELS = 65535
_COLOURS = 255
_MANY, _COARSE = (
    4000,
    4,
)  # cells; of more, every fourth colour is used, which the eye does not miss and pages do
_SAME = 1e-9  # of the largest value: a field that varies by less is one number
_AXES = ("x", "y", "xy")
_VIEW = {"azimuth": -24.0, "elevation": 32.0}


@dataclass(frozen=True, eq=False)
class Field:
    """What colours a surface. values: (points,) or, where it may jump between cells, (cells, corners), SI; signed: a
    quantity that has a sign."""

    name: str
    unit: str
    values: Array
    signed: bool = True


@dataclass(frozen=True, eq=False)
class Shape:
    """A way in which the plate moves.

    moved  (points, 3), m; swings: whether it swings about the flat plate, as a mode, or goes one way, as under a load
    """

    name: str
    moved: Array
    fields: Sequence[Field]
    swings: bool = False


def report_show(report: PlateReport, *, label: str = "") -> Show:
    """All that `lamc plate` found: cases, modes and buckling shapes."""
    shapes = [_case(case.solution, case.name or "under its loads", case.fields) for case in report.cases]
    shapes += [] if report.modes is None else _modes(report.modes)
    for name, found in report.buckling.items():
        of = f" of {name}" if name else ""
        shapes += [
            _of_vector(found, k, f"buckles{of} at {factor:.4g} times its loads", swings=False)
            for k, factor in enumerate(found.factors)
        ]
    notes = [note for case in report.cases for note in case.notes]
    return _show(report.file.name, report.problem, shapes, label, tuple(notes))


def solution_show(solution: Solution, *, label: str = "") -> Show:
    """One case."""
    shape = _case(solution, "under its loads", corner_fields(solution))
    return _show("plate", solution.problem, [shape], label, solution.report.notes)


def solutions_show(solutions: Mapping[str, Solution], *, label: str = "") -> Show:
    """Cases by name; one at least."""
    shapes = [_case(each, name or "under its loads", corner_fields(each)) for name, each in solutions.items()]
    notes = tuple(note for each in solutions.values() for note in each.report.notes)
    return _show("plate", next(iter(solutions.values())).problem, shapes, label, notes)


def problem_show(problem: Problem, *, label: str = "") -> Show:
    """The mesh at rest, coloured by thickness; nothing is solved."""
    mesh = problem.mesh
    thickness = np.array([laminate.thickness for laminate in problem.laminates])[mesh.regions]
    field = Field("thickness", "m", np.repeat(thickness[:, None], mesh.corner_count, axis=1), False)
    still = Shape("at rest", np.zeros((len(mesh.points), 3)), [field])
    return _show("plate", problem, [still], label, ("Nothing is solved yet.",))


def _case(solution: Solution, name: str, fields: CornerFields) -> Shape:
    """A case with the fields of `lamc plate`."""
    moved = _at_points(solution.problem, solution.values)
    found = [Field("deflection", "m", moved[:, 2])] if solution.problem.dofs.element.bends else []
    if solution.problem.dofs.element.stretches:
        found += [Field(f"displacement {axis}", "m", moved[:, k]) for k, axis in enumerate("uv")]
    found.append(Field("stress of plies (von Mises)", "Pa", fields.stress, False))
    if fields.tsai_wu is not None:
        found.append(Field("Tsai-Wu index", "1", fields.tsai_wu, False))
    for letter, unit, values in (("M", "N", fields.moments), ("N", "N/m", fields.forces)):
        if values is not None:
            found += [Field(f"{letter}_{axis}", unit, values[..., k]) for k, axis in enumerate(_AXES)]
    return Shape(name, moved, found)


def _modes(modes: PlateModes) -> list[Shape]:
    return [
        _of_vector(modes, k, f"mode {k + 1}: {frequency:.5g} Hz", swings=True)
        for k, frequency in enumerate(modes.frequencies)
    ]


def _of_vector(shapes: Shapes, k: int, name: str, *, swings: bool) -> Shape:
    moved = _at_points(shapes.problem, shapes.vectors[:, k])
    largest = float(np.abs(moved).max()) or 1.0
    along = int(np.abs(moved).max(axis=0).argmax())
    return Shape(
        name, moved / largest, [Field("shape, of its largest", "1", moved[:, along] / largest)], swings
    )


def _at_points(problem: Problem, vector: Array) -> Array:
    """(u, v, w) at the mesh's points, (points, 3), m; zero for what the element has not."""
    count = len(problem.mesh.points)
    moved = np.zeros((count, 3))
    for k, name in enumerate("uvw"):
        if name in problem.dofs.names:
            numbers = problem.dofs.of(name)[:count]
            moved[:, k] = np.where(numbers >= 0, vector[np.maximum(numbers, 0)], 0.0)
    return moved


def _show(name: str, problem: Problem, shapes: Sequence[Shape], label: str, notes: tuple[str, ...]) -> Show:
    mesh = problem.mesh
    ends = mesh.edges[np.bincount(mesh.cell_edges.ravel(), minlength=len(mesh.edges)) == 1]
    data = {
        "kind": "plate",
        "label": label,
        "description": f"{name}, bent; the list beside it tells what is shown",
        "points": mesh.points.astype("f4").ravel(),
        "corners": mesh.cells.astype("u2" if len(mesh.points) < 1 << 16 else "u4").ravel(),
        "perCell": mesh.corner_count,
        "rim": ends.astype("u4").ravel(),
        "shapes": [_shape_data(mesh, shape) for shape in shapes],
        "maps": {each: _table(each) for each in (ONE_SIGN, TWO_SIGNS)},
        "duration": _PERIOD if any(np.any(shape.moved) for shape in shapes) else 0.0,
        "speed": 1.0,
        "view": _VIEW,
        "live": None,
    }
    wide, tall = (1e3 * side for side in box(mesh))
    kind = "triangles" if mesh.corner_count == 3 else "quadrilaterals"
    facts = f"{wide:.4g} × {tall:.4g} mm, {len(mesh.cells)} {kind}, element {problem.dofs.element.name}"
    return Show(name, facts, data, "", notes)


def _shape_data(mesh: Mesh, shape: Shape) -> dict[str, Any]:
    largest = float(np.abs(shape.moved).max())
    step = largest / (_LEVELS // 2) if largest > 0.0 else 1.0
    factor = _TALL * max(box(mesh)) / largest if largest > 0.0 else 1.0
    return {
        "name": shape.name,
        "step": step,
        "moved": np.rint(shape.moved / step).astype("i2").ravel(),
        "factor": rounded(factor),
        "swings": shape.swings,
        "fields": [_field_data(mesh, field) for field in shape.fields],
    }


def _field_data(mesh: Mesh, field: Field) -> dict[str, Any]:
    """Levels of colour, and the numbers at their ends; what is beyond them has the colour of the end."""
    values = np.asarray(field.values, dtype=float)
    low, high = shown_range(mesh, values)
    if not high - low > _SAME * max(abs(low), abs(high)):  # round-off would take all colours
        low = high = 0.5 * (low + high)
    colours, norm = colours_of(low, high, signed=field.signed)
    share = np.asarray(norm(np.clip(np.nan_to_num(values, nan=low), low, high)), dtype=float)
    step = _COARSE if values.ndim == 2 and len(mesh.cells) > _MANY else 1
    levels = step * np.rint(np.clip(share, 0.0, 1.0) * _COLOURS / step).clip(max=_COLOURS // step)
    return {
        "name": field.name,
        "unit": field.unit,
        "colours": colours,
        "low": float(norm.vmin or 0.0),
        "high": float(norm.vmax or 0.0),
        "least": float(np.nanmin(values)),
        "most": float(np.nanmax(values)),
        "levels": levels.astype("u1").ravel(),
        "jumps": values.ndim == 2,
    }


def _table(name: str) -> Array:
    """256 colours, (768,), of 8 bits."""
    found: Array = np.rint(mpl.colormaps[name](np.arange(256))[:, :3] * 255.0).astype("u1").ravel()
    return found
