"""Drawn shapes of native designs: outlines to regions, regions to sheets.

In: the schema's models. Out: polygons, m. Never: reads a file.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import groupby
from typing import TypeAlias

import shapely
from shapely.geometry import MultiPolygon, Polygon

from lamc.basics.errors import DesignError
from lamc.design import shapes
from lamc.design.work import Account
from lamc.readers.checking import Path
from lamc.readers.kept_model import KeptModel
from lamc.readers.native_drawings import Drawings
from lamc.readers.schema import OutlineModel
from lamc.records.effect import Effect

_EMPTY = MultiPolygon()
Region: TypeAlias = Polygon | MultiPolygon
Entries: TypeAlias = Sequence[tuple[Region, bool]]


@dataclass(eq=False)
class Kept:
    """What a design's file is read for once, however often with other parameters; and what was made last, each with
    what it was made of, which is made again only where that is another.

    effects  those that follow from no parameter, by where they stand
    model    what the file said
    """

    drawings: Drawings
    regions: dict[Path, tuple[OutlineModel, Region]] = field(default_factory=dict)
    sheets: dict[Path, tuple[Entries, MultiPolygon]] = field(default_factory=dict)
    effects: dict[Path, Effect] = field(default_factory=dict)
    model: KeptModel = field(default_factory=KeptModel)

    def __getstate__(self) -> dict[str, object]:
        """What is quickly made again stays behind."""
        again = {"regions": {}, "sheets": {}, "model": KeptModel()}
        return {"drawings": self.drawings, "effects": self.effects, **again}

    def region(self, path: Path, shape: OutlineModel) -> Region:
        """What is drawn at `path`. Raises DesignError for what encloses nothing."""
        before = self.regions.get(path)
        if before is not None and (before[0] is shape or before[0] == shape):
            return before[1]
        region = drawn(shape)
        self.regions[path] = shape, region
        return region

    def sheet(self, path: Path, entries: Entries, layer: str, account: Account) -> MultiPolygon:
        """As `sheet_of_regions`."""
        before = self.sheets.get(path)
        if before is not None and _same(before[0], entries):
            return before[1]
        sheet = sheet_of_regions(entries, layer, account)
        self.sheets[path] = entries, sheet
        return sheet


def _same(one: Entries, other: Entries) -> bool:
    """Whether the regions are the same objects, for the same purpose."""
    return len(one) == len(other) and all(
        a[0] is b[0] and a[1] == b[1] for a, b in zip(one, other, strict=True)
    )


def sheet_of_regions(entries: Entries, layer: str, account: Account) -> MultiPolygon:
    """Shapes in order, True for those that are cut from what was drawn before them. Raises DesignError where they are
    too much work to overlay."""
    account.overlay([region for region, _ in entries], f"the outlines in layer {layer!r}")
    sheet = _EMPTY
    for cut, run in groupby(entries, key=lambda entry: entry[1]):
        joined = shapely.union_all([region for region, _ in run])  # in one go: one by one costs the square
        if cut:
            joined = shapely.difference(sheet, joined)
        elif not sheet.is_empty:
            joined = shapely.union_all([sheet, joined])
        sheet = shapes.areas(joined)
    return sheet


def drawn(shape: OutlineModel) -> Polygon:
    if shape.rect is not None:
        return shapes.rectangle(*shape.rect)
    if shape.circle is not None:
        return shapes.circle(*shape.circle.center, shape.circle.radius)
    if shape.polygon is None:
        raise DesignError("the shape has no outline")
    return shapes.polygon(shape.polygon, shape.holes)
