"""How much work the drawing of a plate file is, counted before it is done.

In: a validated file. Out: nothing, or DesignErrors at the place that draws most. Never: overlays, meshes, clocks.
"""

from collections.abc import Iterator
from typing import Any

import numpy as np
import shapely
from pydantic import BaseModel
from shapely.geometry import LineString
from shapely.geometry.base import BaseGeometry

from lamc.basics.errors import DesignError
from lamc.design.work import Account
from lamc.readers.checking import Path, Problems
from lamc.readers.plates.problem_schema import PlateFileModel

MOST_PLACES = (
    500  # supports, loads, hinges, regions, holes, …: each is looked for among all nodes of the mesh
)
_CIRCLE = 32  # sides for a quarter


def check_work(model: PlateFileModel, problems: Problems) -> None:
    """Raises DesignErrors where a plate has too many places, or its outlines and lines cross too often."""
    shape = model.geometry
    counts: dict[Path, int] = {
        ("geometry", "holes"): len(shape.holes),
        ("geometry", "follow"): len(shape.follow),
        ("cases",): sum(len(loads) for loads in model.cases.values()),
    }
    for name in ("regions", "hinges", "supports", "foundation", "loads", "outputs"):
        counts[(name,)] = len(getattr(model, name))
    if sum(counts.values()) > MOST_PLACES:
        problems.add(
            max(counts, key=lambda path: counts[path]),
            f"with these the plate has {sum(counts.values())} holes, regions, supports, hinges, loads and outputs; at "
            f"most {MOST_PLACES} are looked for on a mesh: join neighbours, or describe what repeats by a laminate of "
            "its own",
        )
        problems.raise_if_any()
    drawn = list(_drawn(model, ()))
    largest = max(drawn, key=lambda each: shapely.get_num_coordinates(each[1]), default=((),))[0]
    try:
        Account().overlay([shape for _, shape in drawn], "the outlines and lines of the plate")
    except DesignError as error:
        problems.add(largest, error.message)
    problems.raise_if_any()


def _drawn(value: Any, path: Path) -> Iterator[tuple[Path, BaseGeometry]]:
    """What is drawn at `path` and within it, as lines; what is no shape at all is left to those who draw it."""
    if isinstance(value, BaseModel):
        for name in type(value).model_fields:
            part = getattr(value, name)
            shape = _line(name, part)
            if shape is not None:
                yield path, shape
            else:
                yield from _drawn(part, (*path, name))
    elif isinstance(value, list | tuple):
        for index, part in enumerate(value):
            yield from _drawn(part, (*path, index))
    elif isinstance(value, dict):
        for name, part in value.items():
            yield from _drawn(part, (*path, name))


def _line(name: str, value: Any) -> BaseGeometry | None:
    if value is None or name not in ("rect", "polygon", "line", "circle", "point", "wkt"):
        return None
    if name == "wkt":
        shape = shapely.from_wkt(value, on_invalid="ignore")
        return None if shape is None else shapely.boundary(shape)
    if name == "circle":
        return shapely.boundary(shapely.Point(value.center).buffer(value.radius, quad_segs=_CIRCLE))
    corners = np.array(value, dtype=float).reshape(-1, 2)
    if name == "rect":
        (x0, y0), (x1, y1) = corners
        corners = np.array([[x0, y0], [x1, y0], [x1, y1], [x0, y1]])
    if name == "point" or len(corners) < 2 or not np.isfinite(corners).all():
        return shapely.Point(0.0, 0.0)
    return LineString(corners if name == "line" else np.concatenate([corners, corners[:1]]))
