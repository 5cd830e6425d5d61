"""One field of a bent plate on Matplotlib axes: `solution.plot("w")`.

In: a `Solution`, the name of a field, axes. Out: the axes, or a PNG, SVG or PDF file. Never: solves.
"""

import os
from typing import Any

from matplotlib.axes import Axes

from lamc.basics.checks import did_you_mean, shown
from lamc.basics.errors import RequestError
from lamc.plates.answers.corner_fields import corner_fields
from lamc.plates.answers.solution import Solution
from lamc.report.drawn import on_axes
from lamc.report.plate_contours import Field, draw_contours
from lamc.report.plate_marks import draw_supports, scale_of
from lamc.report.plate_solid import box
from lamc.report.plates import frame_plate

_UNKNOWNS = {"u": "m", "v": "m", "w": "m", "w_x": "", "w_y": ""}
_NAMES = {
    "u": "displacement u",
    "v": "displacement v",
    "w": "deflection w",
    "w_x": "slope w_x",
    "w_y": "slope w_y",
}
_PARTS = ("x", "y", "xy")
_WIDTH = 6.4  # inches


def field_of(solution: Solution, name: str) -> Field:
    """A field by name: an unknown, M_x, M_y, M_xy, N_x, N_y, N_xy, "stress" or "tsai_wu". Raises RequestError with the
    names there are."""
    own = [each for each in _UNKNOWNS if each in solution.problem.dofs.names]
    if name in own:
        values = solution.at_nodes(name)[: len(solution.problem.mesh.points)]
        return Field(_NAMES[name], _UNKNOWNS[name], values)
    found: dict[str, Field] = {}
    if name not in _UNKNOWNS:
        fields = corner_fields(solution)
        for letter, unit, resultants in (("M", "N·m/m", fields.moments), ("N", "N/m", fields.forces)):
            if resultants is not None:
                for k, part in enumerate(_PARTS):
                    found[f"{letter}_{part}"] = Field(f"${letter}_{{{part}}}$", unit, resultants[..., k])
        found["stress"] = Field("largest von Mises stress of all plies", "Pa", fields.stress, signed=False)
        if fields.tsai_wu is not None:
            found["tsai_wu"] = Field("largest Tsai-Wu index, 1 at failure", "", fields.tsai_wu, signed=False)
    if name not in found:
        raise RequestError(
            f"this solution has no field {shown(name)}; {did_you_mean(str(name), [*own, *found] or list(_UNKNOWNS))}"
        )
    return found[name]


def plot(
    solution: Solution,
    name: str = "w",
    *,
    axes: Axes | None = None,
    path: str | os.PathLike[str] | None = None,
) -> Axes:
    """`Solution.plot`."""
    problem = solution.problem
    mesh, scale = problem.mesh, scale_of(problem.size)
    field = field_of(solution, name)
    width, height = box(mesh)

    def draw(axis: Axes) -> None:
        figure: Any = axis.figure
        draw_contours(figure, axis, mesh, field, scale)
        draw_supports(axis, problem, scale)
        frame_plate(axis, mesh, scale)

    return on_axes((_WIDTH + 1.2, min(max(_WIDTH * height / width, 1.2), 7.0) + 1.0), axes, path, draw)
