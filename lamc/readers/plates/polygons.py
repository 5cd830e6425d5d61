"""Polygons of a plate file: outlines with holes, and well-known text.

In: shapely geometries, text. Out: polygons, m. Never: places in the file; who asks knows these.
"""

from collections.abc import Sequence

import numpy as np
import shapely
from shapely.geometry import Polygon
from shapely.geometry.base import BaseGeometry

from lamc.basics.errors import DesignError
from lamc.design import shapes


def cut(outer: BaseGeometry, holes: Sequence[BaseGeometry | None]) -> BaseGeometry:
    """The outline without its holes; one that reaches beyond the outline is a notch. Raises DesignError where a hole
    does not overlap the outline, or nothing is left."""
    left = outer
    for hole in holes:
        if hole is None:
            continue
        if not left.intersection(hole).area > 0.0:
            raise DesignError("a hole lies outside the plate, or inside another hole; leave it out")
        left = left.difference(hole)
    if not left.area > 0.0:
        raise DesignError("the holes take the whole plate away; make them smaller")
    return left


def polygon_of_wkt(text: str, step: float) -> BaseGeometry:
    """A polygon from well-known text; one step of its coordinates is `step` m. Raises DesignError."""
    try:
        shape = shapely.from_wkt(text)
    except (shapely.errors.ShapelyError, ValueError) as error:
        raise DesignError(
            f"the text is no geometry; write such as 'POLYGON ((0 0, 2 0, 2 1, 0 0))': {str(error)[:80]}"
        ) from error
    if not isinstance(shape, Polygon) or shape.is_empty:
        kind = "nothing" if shape is None or shape.is_empty else f"a {shape.geom_type}"
        raise DesignError(f"the text holds {kind}; it must be a POLYGON")
    rings = [
        [(float(x) * step, float(y) * step) for x, y in np.asarray(ring.coords)[:, :2]]
        for ring in (shape.exterior, *shape.interiors)
    ]
    return shapes.polygon(rings[0], rings[1:])
