"""What is cut of each layer of a laminate, and whether the device that it leaves is the design's.

In: a design, a style of hinges. Out: parts of each layer, m, and lines. Boards are cut along hinges as `split` cuts
them, so that what is made is what was simulated; the layer that bends stays whole there. Never: moves or mends a part.

Castellated hinges: Sreetharan, Whitney, Strauss & Wood, Monolithic fabrication of millimeter-scale machines (2012).
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import shapely
from shapely.geometry import LineString, MultiPolygon, Polygon
from shapely.geometry.base import BaseGeometry

from lamc.basics.brief import counted
from lamc.basics.errors import DesignError, ExportError
from lamc.design.cutting import SLIT, as_multipolygon
from lamc.design.split import split, split_steps
from lamc.design.steps import Hinge, SplitSteps
from lamc.export.cuts.options import CASTELLATED, DRAWN, GAP, PERFORATED, style_of
from lamc.export.cuts.perforated import dashes_of
from lamc.records.design import Design, Layer
from lamc.records.mechanism import Body, Mechanism
from lamc.records.network import listed_names

SAME = 1e-9  # of areas, masses, places and inertias: what is left is the design's
_CLEAR = 0.75  # kerfs from a tab to the hinge line: two tabs that face each other are more than a kerf apart
_BESIDE = 2.0  # gaps from a hinge line: a board beside it begins nearer
_BARE = 1e-3  # of a gap's strip: less of a board in it is round-off of its edges


@dataclass(frozen=True, eq=False)
class CutLayer:
    """One layer as it is cut, before kerf; m.

    parts  what is left of it
    lines  what is cut as a line: perforations
    creases  what is scored: hinge lines of a layer that bends by itself, without boards beside it
    slits  hinge lines that are cut through this layer, with half the width of each
    """

    layer: Layer
    parts: MultiPolygon
    lines: tuple[LineString, ...]
    slits: tuple[tuple[LineString, float], ...]
    creases: tuple[LineString, ...] = ()


@dataclass(frozen=True, eq=False)
class Plan:
    """All layers, bottom to top; bodies as they are simulated and as they are cut, by name; what is told."""

    layers: tuple[CutLayer, ...]
    drawn: Mechanism
    left: Mechanism
    notes: tuple[str, ...]

    @property
    def largest_difference(self) -> float:
        """Of bodies' masses, centres and inertias, of the design's own."""
        return max(
            (difference(self.left.body(body.name), body, self.drawn.size) for body in self.drawn.bodies),
            default=0.0,
        )


def plan_of(design: Design, style_text: str = "gap", width: str | float = DRAWN, kerf: float = 0.0) -> Plan:
    """The cuts of a design. kerf: m, which tabs leave room for.

    Raises ExportError where what is left is no device of the same bodies, or with hinges as they are drawn is not the
    design's, and as `split` does."""
    style, pitch = style_of(style_text, "the style of hinges")
    steps = split_steps(design)
    notes = list(steps.notes)
    if style == CASTELLATED and width == DRAWN:
        width = GAP
    if not isinstance(width, str):
        _check_width(steps, width)
    layers = tuple(_cut(steps, k, style, (pitch, kerf), width) for k in range(len(design.layers)))
    left = _left(design, layers, steps.mechanism)
    plan = Plan(layers, steps.mechanism, left, tuple(notes + _notes(steps, layers, style, width)))
    if width == DRAWN and not plan.largest_difference <= SAME:
        raise ExportError(
            f"bodies that the cuts leave differ from the design's by {plan.largest_difference:.2g}: lamc's own fault; "
            "please report it with the design"
        )
    return plan


def _check_width(steps: SplitSteps, width: float) -> None:
    """Raises ExportError where boards would stay in the slit that is simulated."""
    for hinge in steps.hinges:
        simulated = 2.0 * SLIT * hinge.properties.width
        if width < simulated * (1.0 - SAME) and _reaches(hinge, 0.5 * simulated, steps.design):
            raise ExportError(
                f"--hinge-width {1e3 * width:g} mm is narrower than the slit of {1e3 * simulated:g} mm that is "
                f"simulated at hinge {hinge.name!r}: bodies would be larger than those; make it wider, leave it out, "
                "or draw a narrower gap"
            )


def _cut(steps: SplitSteps, k: int, style: str, sizes: tuple[float, float], width: str | float) -> CutLayer:
    """sizes: pitch and kerf, m."""
    design = steps.design
    layer = design.layers[k]
    bent = [h for h in steps.hinges if h.properties.layer == k]
    through = [h for h in steps.hinges if k in h.layers and h.properties.layer != k]
    halves = [_half_width(h, width) for h in through]
    if width == DRAWN and not bent:
        parts = steps.cut[k]  # to the last digit
    else:
        slits = shapely.union_all(_grown(through, halves))
        parts = as_multipolygon(shapely.difference(layer.geometry, shapely.union(steps.holes[k], slits)))
    shapely.prepare(parts)
    if style == CASTELLATED:
        tabs = [tab for h, half in zip(through, halves, strict=True) for tab in _tabs(h, half, sizes, parts)]
        kept = shapely.union_all([steps.holes[k], *_grown(through, [SLIT * half for half in halves])])
        parts = as_multipolygon(shapely.union(parts, shapely.difference(shapely.union_all(tabs), kept)))
    lines = [dash for h in bent for dash in _dashes(h, sizes, parts)] if style == PERFORATED else []
    drawn = tuple((h.line, half) for h, half in zip(through, halves, strict=True))
    alone = [h for h in bent if style != PERFORATED and _bends_alone(h, design)]
    creases = tuple(piece for h in alone for piece in _within(h.line, parts))
    return CutLayer(layer, parts, tuple(lines), drawn, creases)


def _half_width(hinge: Hinge, width: str | float) -> float:
    if width == DRAWN:
        return SLIT * hinge.properties.width
    return hinge.properties.width if width == GAP else 0.5 * float(width)


def _grown(hinges: Sequence[Hinge], halves: Sequence[float]) -> list[BaseGeometry]:
    """Strips with round ends, as `split` grows them."""
    return [shapely.buffer(h.line, half, quad_segs=8) for h, half in zip(hinges, halves, strict=True)]


def _left(design: Design, layers: Sequence[CutLayer], drawn: Mechanism) -> Mechanism:
    """The device that is released: the same hinges in what is left of each layer."""
    cut = tuple(replace(design.layers[k], geometry=each.parts) for k, each in enumerate(layers))
    try:
        left = split(replace(design, layers=cut))
    except DesignError as error:
        raise ExportError(
            f"cut so, the design is no device: {error.message}; narrow --hinge-width"
        ) from error
    names = [sorted(b.name for b in m.bodies) for m in (drawn, left)]
    if names[0] != names[1]:
        raise ExportError(
            f"cut so, the device has the bodies {listed_names(names[1])}, and the design has "
            f"{listed_names(names[0])}; narrow --hinge-width"
        )
    return left


def difference(left: Body, drawn: Body, size: float) -> float:
    """How far two bodies are from each other in mass, centre and inertia, relative; size: m, of the device."""
    scale = float(np.abs(drawn.inertia).max()) or 1.0
    return max(
        abs(left.mass - drawn.mass) / (drawn.mass or 1.0),
        float(np.abs(left.com - drawn.com).max()) / size,
        float(np.abs(left.inertia - drawn.inertia).max()) / scale,
    )


def _notes(steps: SplitSteps, layers: Sequence[CutLayer], style: str, width: str | float) -> list[str]:
    found = []
    covered = [h.name for h in steps.hinges if _is_covered(h, steps.design, layers)]
    if covered and style != CASTELLATED:
        as_cut = (
            "as they are simulated, a tenth of the gap wide; --hinge-width gap cuts them by the gap"
            if isinstance(width, str)
            else f"{1e3 * width:g} mm wide, as --hinge-width says"
        )
        found.append(f"boards reach into the gap of {listed_names(covered)}: they are cut {as_cut}")
    open_wide = [] if isinstance(width, str) else _open_wider(steps, 0.5 * width)
    if open_wide:
        found.append(
            f"boards beside {listed_names(open_wide)} are drawn farther apart than --hinge-width says: it cuts nothing "
            "there"
        )
    if style == CASTELLATED:
        found.append(
            "tabs reach to the hinge line by turns, so that the film bends over half of the gap: a hinge is about "
            "twice as stiff as one that is cut straight"
        )
    if style == PERFORATED:
        found.append(
            "perforations take half of the film along each hinge, and about half of its stiffness: what is drawn is "
            "not changed"
        )
    scored = sum(len(layer.creases) for layer in layers)
    if scored:
        found.append(
            f"creases of layers without boards beside are drawn to be scored ({counted(scored, 'line')}): their "
            "stiffness is that of the design, however they are scored"
        )
    if steps.design.facet_creases is not None:
        found.append("facets bend as they are: their creases are not cut")
    return found


def _open_wider(steps: SplitSteps, half: float) -> list[str]:
    """Hinges along which no board, as it is drawn, reaches as near to the line as half of a width, m."""
    return [hinge.name for hinge in steps.hinges if not _reaches(hinge, half, steps.design)]


def _reaches(hinge: Hinge, half: float, design: Design) -> bool:
    strip = shapely.buffer(hinge.line, half, cap_style="flat")
    boards = [design.layers[k] for k in hinge.layers if k != hinge.properties.layer]
    return any(shapely.area(shapely.intersection(strip, b.geometry)) > _BARE * strip.area for b in boards)


def _bends_alone(hinge: Hinge, design: Design) -> bool:
    """Whether no board lies beside the line, whose edges would say where the layer bends."""
    beside = shapely.buffer(hinge.line, _BESIDE * hinge.properties.width, cap_style="flat")
    others = [layer for k, layer in enumerate(design.layers) if k != hinge.properties.layer]
    return not any(
        shapely.area(shapely.intersection(beside, o.geometry)) > _BARE * beside.area for o in others
    )


def _is_covered(hinge: Hinge, design: Design, layers: Sequence[CutLayer]) -> bool:
    """Whether something of a board is left over the film that shall bend, away from the ends of the line."""
    strip = shapely.buffer(hinge.line, hinge.properties.width, cap_style="flat")
    return any(
        shapely.area(shapely.intersection(strip, layers[k].parts)) > _BARE * strip.area
        for k in hinge.layers
        if k != hinge.properties.layer and not design.layers[k].material.is_flexible
    )


def _dashes(hinge: Hinge, sizes: tuple[float, float], parts: MultiPolygon) -> list[LineString]:
    """Cuts along each piece of the line where there is film, bridged between them and at both ends. sizes: pitch and
    kerf, m."""
    return [
        dash
        for piece in _within(hinge.line, parts)
        for dash in dashes_of(piece, *sizes, f"along hinge {hinge.name!r}")
    ]


def _within(line: LineString, parts: MultiPolygon) -> list[LineString]:
    """Pieces of a line that lie in the parts."""
    if shapely.covers(parts, line):  # quick once the parts are prepared; an overlay takes all of them
        return [line]
    pieces = shapely.get_parts(shapely.intersection(line, parts)) if shapely.intersects(parts, line) else []
    return [piece for piece in pieces if isinstance(piece, LineString) and piece.length > 0.0]


def _tabs(hinge: Hinge, half: float, sizes: tuple[float, float], parts: MultiPolygon) -> list[Polygon]:
    """Tabs of the boards on both sides by turns, from the edge of the gap to near the line: a tenth of half the gap
    from it, or as far as the kerf asks for. Where a board does not reach the gap there is none.

    Raises ExportError for a kerf that leaves no tab."""
    pitch, kerf = sizes
    (start, end), length = np.array(hinge.line.coords), hinge.line.length
    clear = max(SLIT * half, _CLEAR * kerf)
    count = max(2, round(length / pitch))
    if clear >= half or 2.0 * clear >= length / count:
        raise ExportError(
            f"between tabs of hinge {hinge.name!r} there is no room for the kerf of {1e3 * kerf:g} mm: the gap is "
            f"{2e3 * half:g} mm, the pitch {1e3 * length / count:g} mm; take longer tabs, or --hinge-style gap"
        )
    along = (end - start) / length
    across = np.array([-along[1], along[0]])
    overlap = 1e-6 * half  # into the board, so that both are one
    tabs = []
    for k in range(count):
        side = across * (1.0 if k % 2 else -1.0)
        ends = (length * k / count + clear, length * (k + 1) / count - clear)
        base = LineString([start + along * s + side * (half + overlap) for s in ends])
        for piece in _within(base, parts):
            if piece.length > overlap:
                a, b = np.array(piece.coords)[[0, -1]]
                inward = side * (half + overlap - clear)
                tabs.append(Polygon([a, b, b - inward, a - inward]))
    return tabs


def mass_of(layer: CutLayer) -> float:
    """kg, of what is cut of a layer, film at hinges included."""
    return layer.layer.material.density * layer.layer.thickness * math.fsum(p.area for p in layer.parts.geoms)
