"""Drawn shapes of native designs: outlines to regions, regions to sheets.

In: the schema's models. Out: polygons, m. Never: reads a file.
"""

from collections.abc import Sequence
from itertools import groupby
from typing import TypeAlias

import shapely
from shapely.geometry import MultiPolygon, Polygon

from lamc.basics.errors import DesignError
from lamc.design import shapes
from lamc.design.work import Account
from lamc.readers.schema import OutlineModel

Region: TypeAlias = Polygon | MultiPolygon


def sheet_of_regions(entries: Sequence[tuple[Region, bool]], layer: str, account: Account) -> MultiPolygon:
    """Shapes in order, True for those that are cut from what was drawn before them. Raises DesignError where they are
    too much work to overlay."""
    account.overlay([region for region, _ in entries], f"the outlines in layer {layer!r}")
    sheet = MultiPolygon()
    for cut, run in groupby(entries, key=lambda entry: entry[1]):
        joined = shapely.union_all([region for region, _ in run])  # in one go: one by one costs the square
        sheet = shapes.areas(sheet.difference(joined) if cut else shapely.union_all([sheet, joined]))
    return sheet


def drawn(shape: OutlineModel) -> Polygon:
    if shape.rect is not None:
        return shapes.rectangle(*shape.rect)
    if shape.circle is not None:
        return shapes.circle(*shape.circle.center, shape.circle.radius)
    if shape.polygon is None:
        raise DesignError("the shape has no outline")
    return shapes.polygon(shape.polygon, shape.holes)
