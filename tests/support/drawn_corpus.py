"""Patterns of the FOLD corpus as drawings of lines, as an SVG or a DXF reader makes them."""

from typing import Any

import numpy as np

from lamc.records.drawing import Drawing, Role, Stroke

ROLES: dict[str, Role] = {
    "M": "mountain",
    "V": "valley",
    "B": "border",
    "C": "cut",
    "U": "undriven",
    "F": "flat",
}


def line(*points: Any, role: Role = "hinge", closed: bool = False, source: str = "", **more: Any) -> Stroke:
    """A stroke through places, mm."""
    return Stroke(1e-3 * np.array(points, dtype=float), closed, role, source=source, **more)


def drawing(*strokes: Stroke) -> Drawing:
    return Drawing("sheet", strokes, 1e-3, file="sheet.svg")


def square(x: float, y: float, width: float, role: Role = "border", source: str = "") -> Stroke:
    """Closed, from its lower left corner."""
    corners = ((x, y), (x + width, y), (x + width, y + width), (x, y + width))
    return line(*corners, role=role, closed=True, source=source)


def of_fold(data: Any, unit: float = 1e-3) -> list[Stroke]:
    """A stroke for each edge of a FOLD pattern; unit: m."""
    points = unit * np.array(data["vertices_coords"])[:, :2]
    angles = data.get("edges_foldAngle") or [None] * len(data["edges_vertices"])
    return [
        Stroke(
            points[list(edge)],
            False,
            ROLES[kind],
            None if angle is None else np.radians(angle),
            source=f"line e{k}",
        )
        for k, (edge, kind, angle) in enumerate(
            zip(data["edges_vertices"], data["edges_assignment"], angles, strict=True)
        )
    ]
