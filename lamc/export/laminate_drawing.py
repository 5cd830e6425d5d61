"""A laminate as one drawing, and a native design that takes its shapes and hinge lines from it.

In: a design, how lines are written. Out: the drawing's lines, each shape and each group of hinge lines on a layer of
its own; the design's text; what is read back otherwise, in words. Never: moves a place by more than 1e-12 m.
"""

import warnings
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import groupby
from typing import Any

import numpy as np
import shapely
from shapely.geometry import MultiPolygon

from lamc.basics.errors import DesignError, DesignWarning
from lamc.basics.yaml_text import dump
from lamc.design.cutting import material_size
from lamc.export.cuts.lines import CutLine, Pen, bounds_of
from lamc.readers.load import load_text
from lamc.readers.native_writer import design_data
from lamc.records.design import Design
from lamc.records.network import listed_names

_DRAWN, _GREY = ("#000000", 7), ("#808080", 8)  # as `Pen` has them; other colours say how creases fold
_SAME = 1e-9  # of the size: digits of the file, and of millimetres
_GRID = 1e-12  # m: what is no wider was left by an overlay's round-off, and draws nothing

Entry = dict[str, Any]


@dataclass(frozen=True)
class Manifest:
    """text: of the native design; lines: what its drawing holds, m."""

    text: str
    lines: Sequence[CutLine]


def manifest_of(design: Design, file: str, *, paged: bool, parted: bool = False) -> Manifest:
    """The design with its shapes and hinge lines in a drawing of that name.

    paged   places of the drawing count from the upper left corner of its page, as in SVG
    parted  each hinge line has a layer of its own, as lines that overlap must, and shapes are without the spikes of no
            width that overlays leave where an oblique cut ends at a rim: coordinates are rounded to 1e-12 m

    Raises DesignError for what no native design holds."""
    data, drawn = design_data(_without_spikes(design) if parted else design), _Drawn(file, parted)
    data["shapes"] = drawn.regions(data["shapes"], "body", _DRAWN)
    if "hinges" in data:
        data["hinges"] = drawn.hinges(data["hinges"])
    if "fixed" in data:
        data["fixed"] = drawn.regions(data["fixed"], "outline", _GREY)
    if paged:
        low, high = bounds_of(drawn.lines)
        for taken in drawn.taken:
            taken["at"] = [float(low[0]), float(high[1])]
    return Manifest(dump(data), drawn.lines)


def _without_spikes(design: Design) -> Design:
    layers = [replace(layer, geometry=_rounded(layer.geometry)) for layer in design.layers]
    return replace(design, layers=tuple(layers), fixed=tuple(_rounded(held) for held in design.fixed))


def _rounded(region: MultiPolygon) -> MultiPolygon:
    found = shapely.set_precision(region, _GRID)
    return found if isinstance(found, MultiPolygon) else MultiPolygon([] if found.is_empty else [found])


class _Drawn:
    """The layers of a drawing as they are drawn. taken: entries of the design that say which; lines: what is drawn."""

    def __init__(self, file: str, parted: bool) -> None:
        self.file, self.parted = file, parted
        self.taken: list[Entry] = []
        self.lines: list[CutLine] = []

    def regions(self, entries: Sequence[Entry], name: str, ink: tuple[str, int]) -> list[Entry]:
        """Entries of polygons, those of the same layers as one shape of the drawing."""
        made = []
        for layers, alike in groupby(entries, key=lambda entry: entry["layers"]):
            pen = self._pen(name, ink, "all layers" if isinstance(layers, str) else ", ".join(layers))
            for entry in alike:
                rings = map(np.array, (*entry.get("holes", ()), entry["polygon"]))
                self.lines += [
                    CutLine(ring, True, pen) for ring in rings if np.ptp(ring, axis=0).max() > _GRID
                ]
            made.append({"shape": self._layer(pen), "layers": layers})
        return made

    def hinges(self, entries: Sequence[Entry]) -> list[Entry]:
        """Entries of hinge lines, those in one layer that are in the order in which they are read."""
        made: list[Entry] = []
        for entry in entries:
            lines, name = entry.get("lines") or [entry["line"]], entry.get("name", "")
            rest = {key: value for key, value in entry.items() if key not in ("line", "lines", "name")}
            in_order = not self.parted and lines == sorted(lines, key=lambda line: (min(line), max(line)))
            groups = [lines] if in_order else [[line] for line in lines]
            for number, group in enumerate(groups, 1):
                own = f"{name}_{number}" if name and len(lines) > len(group) else name
                pen = self._pen("hinge", _GREY, own)
                self.lines += [CutLine(np.array(line), False, pen) for line in group]
                made.append(({"name": own} if own else {}) | {"lines": self._layer(pen)} | rest)
        return made

    def _pen(self, name: str, ink: tuple[str, int], about: str) -> Pen:
        """Of a layer of its own: 3_body. Readers know what its lines are for by the word behind the number."""
        return Pen(f"{len(self.taken) + 1}_{name}", *ink, about)

    def _layer(self, pen: Pen) -> Entry:
        """Lines meet to the last digit: healing would close slits."""
        entry = {"file": self.file, "layer": pen.name, "units": "mm", "heal": 0}
        self.taken.append(entry)
        return entry


# --- read back ----------------------------------------------------------------------------------------------------


def misreadings(design: Design, manifest: Manifest, drawing: bytes, file: str) -> list[str]:
    """What lamc reads otherwise in the two files, in words; nothing where it is the same design."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DesignWarning)
        try:
            found = load_text(manifest.text, f"{file}.yaml", drawings={file: drawing})
        except DesignError as error:
            return [error.message.splitlines()[0]]
    assert isinstance(found, Design)  # as it was written
    return _unlike(design, found)


def _unlike(drawn: Design, found: Design) -> list[str]:
    lost = [
        f"layer {one.name!r} would have another shape"
        for one, two in zip(drawn.layers, found.layers, strict=True)
        if not _alike(one.geometry, two.geometry)
    ]
    lost += [
        f"something else of layer {layer.name!r} would be held"
        for layer, one, two in zip(drawn.layers, drawn.fixed, found.fixed, strict=True)
        if not _alike(one, two)
    ]
    tolerance = _SAME * material_size(drawn.layers)
    ours, theirs = (
        [(line, hinges) for hinges in design.hinges for line in hinges.lines] for design in (drawn, found)
    )
    if len(ours) != len(theirs):
        return [*lost, f"of {len(ours)} hinge lines {len(theirs)} would be read"]
    astray = [
        line.name or f"the {k}th"
        for k, ((line, hinges), (other, read)) in enumerate(zip(ours, theirs, strict=True), 1)
        if np.abs(np.subtract(line.line, other.line)).max() > tolerance
        or line.name != other.name
        or replace(hinges, lines=()) != replace(read, lines=())
    ]
    return lost + ([f"hinge lines would be others: {listed_names(astray)}"] if astray else [])


def _alike(one: MultiPolygon, other: MultiPolygon) -> bool:
    """Whether no edge is off by more than the grid and the round-off of millimetres, which is less."""
    return bool(shapely.symmetric_difference(one, other).area <= 2.0 * _GRID * one.length)
