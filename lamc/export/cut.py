"""Cut files: each layer of a laminate, or a sheet of creases, in real size, as DXF and SVG.

In: a mechanism with the design that it was split from, or one whose bodies are facets of a sheet. Out: two drawings of
each layer, README.md, and cut.json with areas and masses. Bodies that the cuts leave are found by splitting what is
cut, and compared with those that are simulated. Never: draws supports, which take a CAD program.
"""

import json
import math
import shlex
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import shapely
from shapely import STRtree
from shapely.geometry import LineString, MultiPolygon, Polygon

from lamc.basics.brief import counted
from lamc.basics.errors import ExportError, UnsupportedError
from lamc.codegen.names import identifier
from lamc.design.linking import millimetres
from lamc.export.creased import CreasedSheet
from lamc.export.cuts.creases import lines_of_sheet
from lamc.export.cuts.dxf import dxf_bytes
from lamc.export.cuts.kerf import clash_of, lines_of, narrow, offset
from lamc.export.cuts.lines import ROLES, CutLine, bounds_of, open_line, rings_of
from lamc.export.cuts.options import CASTELLATED, DRAWN, PERFORATED, style_of
from lamc.export.cuts.perforated import dashes_of
from lamc.export.cuts.plan import SAME, Plan, mass_of, plan_of
from lamc.export.cuts.readme import readme
from lamc.export.cuts.sheet import Stock, stock_of
from lamc.export.cuts.svg import svg_text
from lamc.export.options import ExportOptions, named
from lamc.records.design import Design
from lamc.records.drawing import STRAY, Mend
from lamc.records.mechanism import Mechanism
from lamc.records.scene import Scene

REPORT = "cut.json"
SUPPORTS = "no supports are drawn: bridges that hold parts in their sheets are added in CAD"
_BORDERS = ("border", "hole")


def next_step(folder: str, files: Mapping[str, bytes], options: ExportOptions) -> str:
    """Where to look first."""
    return f"open {shlex.quote(f'{folder}/README.md')}: layers, colours, what to cut in which order"


def files(mechanism: Mechanism, scene: Scene, options: ExportOptions) -> dict[str, bytes]:
    """Drawings of every layer. Raises ExportError and UnsupportedError for what cannot be cut so."""
    if mechanism.design is not None:
        return _laminate(mechanism.design, options)
    return _sheet(mechanism, options)


def notes(files: Mapping[str, bytes]) -> list[str]:
    """What the command line prints of an export: areas, masses, how they compare, notes."""
    data = json.loads(files[REPORT])
    lines = [
        f"{'layers' if k == 0 else '':<10}{each['layer']}: {counted(each['parts'], 'part')}, "
        f"{1e6 * each['area']:.6g} mm2, {1e3 * each['mass']:.6g} g of {each['material']}"
        for k, each in enumerate(data["layers"])
    ]
    return [*lines, f"bodies    {data['comparison']}", *(f"note      {note}" for note in data["notes"])]


def _not_here(mends: Sequence[Mend]) -> list[str]:
    """A note of lines that were drawn, and are of no part."""
    strays = [mend for mend in mends if mend.what == STRAY]
    if not strays:
        return []
    are = (
        f"{len(strays)} lines that bound nothing are" if len(strays) > 1 else "a line that bounds nothing is"
    )
    where = f"{'one of them ' if len(strays) > 1 else ''}at {millimetres(strays[0].at)}, {strays[0].source}"
    return [f"{are} not in these files, {where}: a slit that ends amid a facet is added in CAD"]


def _laminate(design: Design, options: ExportOptions) -> dict[str, bytes]:
    plan = plan_of(design, options.hinge_style, options.hinge_width, options.kerf)
    notes = [*plan.notes, *_not_here(design.mends)]
    drawn: list[list[CutLine]] = []
    for layer in plan.layers:
        lines, about_kerf = lines_of(layer, options.kerf) if layer.parts.geoms else ([], [])
        drawn.append(lines)
        notes += about_kerf if lines else [f"layer {layer.layer.name!r} has no parts, and no file"]
    stock = _stock([line for lines in drawn for line in lines], options)
    width = len(str(len(plan.layers)))
    made: dict[str, bytes] = {}
    rows = []
    for k, (layer, lines) in enumerate(zip(plan.layers, drawn, strict=True)):
        stem = f"{k + 1:0{width}d}_{identifier(layer.layer.name)}"
        if lines:
            about = f"layer {k + 1} of {len(plan.layers)} from below: {layer.layer.name}"
            made |= _drawings(stem, design.name, about, lines, stock)
        rows.append(
            {
                "layer": layer.layer.name,
                "file": stem if lines else None,
                "material": layer.layer.material.name,
                "thickness": layer.layer.thickness,
                "parts": len(layer.parts.geoms),
                "area": math.fsum(part.area for part in layer.parts.geoms),
                "mass": mass_of(layer),
            }
        )
    return made | _report(
        design.name, "laminate", rows, _bodies(plan), _comparison(plan), notes, stock, options
    )


def _bodies(plan: Plan) -> list[dict[str, Any]]:
    return [
        {"name": b.name, "mass": plan.left.body(b.name).mass, "simulated": b.mass} for b in plan.drawn.bodies
    ]


def _comparison(plan: Plan) -> str:
    worst = plan.largest_difference
    if worst <= SAME:
        return (
            f"{len(plan.drawn.bodies)} bodies that the cuts leave are those that are simulated: masses, centres and "
            f"inertias differ by {worst:.1g} at most, relative"
        )
    shares = [
        (plan.left.body(b.name).mass / b.mass - 1.0, b.name)
        for b in plan.drawn.bodies
        if b.mass and not b.fixed
    ]
    share, name = max(shares, key=lambda item: abs(item[0]), default=(0.0, ""))
    return (
        f"not those that are simulated, by {100 * worst:.3g} % at most; of masses {name!r} differs most, by "
        f"{100 * share:+.3g} %: --hinge-style gap --hinge-width drawn cuts what is simulated"
    )


def _sheet(mechanism: Mechanism, options: ExportOptions) -> dict[str, bytes]:
    sheet = CreasedSheet(mechanism, "cut files hold layers, or a sheet of")
    if sheet.faults:
        raise UnsupportedError(
            f"this is no sheet of creases, and its drawing of layers is not here: {'; '.join(sheet.faults)}; export "
            "the design"
        )
    style, pitch = style_of(options.hinge_style, named("hinge_style"))
    if style == CASTELLATED or options.hinge_width != DRAWN:
        field = "hinge_style" if style == CASTELLATED else "hinge_width"
        raise ExportError(
            f"{named(field)} is of boards beside hinges; this is a sheet of creases: leave it out"
        )
    lines = lines_of_sheet(sheet, is_cut=True)
    rims = [line for line in lines if line.pen.name in _BORDERS]
    area = _area(rims)
    notes = _not_here(mechanism.mends)
    pieces = MultiPolygon(_pieces(rims))
    parts = _parts(pieces, lines)
    if options.kerf:
        grown = _compensated(pieces, options.kerf)
        lines = [line for line in lines if line.pen.name not in _BORDERS]
        lines += rings_of(list(grown.geoms), ROLES["border"], ROLES["hole"])
        notes += narrow("sheet", pieces, grown, options.kerf)
        cuts = sum(line.pen.name == "cut" for line in lines)
        if cuts:
            notes.append(
                f"{cuts} cut{'s are' if cuts > 1 else ' is'} cut once, along the line, and no kerf is allowed for "
                f"there: what lies beside loses {1e6 * options.kerf / 2:.4g} um; where a part is to be exact, draw its "
                "rim as an outline or a hole"
            )
    if mechanism.facet_creases:
        notes.append(
            f"facets bend as they are: the {len(mechanism.facet_creases)} lines along which they do are not drawn"
        )
    if style == PERFORATED:
        lines = _perforated(lines, pitch, options.kerf)
        notes.append("creases are cut as dashes: the drawing does not read back as a device")
    stock = _stock(lines, options)
    stem = identifier(mechanism.name)
    made = _drawings(stem, mechanism.name, "a sheet of creases", lines, stock)
    card = sheet.card
    rows = [
        {
            "layer": mechanism.name,
            "file": stem,
            "material": "card" if card is None else f"card of {card.density:g} kg/m3",
            "thickness": None if card is None else card.thickness,
            "parts": parts,
            "area": area,
            "mass": math.fsum(body.mass for body in mechanism.bodies),
        }
    ]
    facets = math.fsum(s.polygon.area for b in mechanism.bodies for s in b.outline)
    gap = abs(area / facets - 1.0)
    if not gap <= SAME:
        raise UnsupportedError(f"outlines enclose {area:g} m2, and facets have {facets:g} m2: facets overlap")
    comparison = f"the outline encloses the area of all facets, to {gap:.1g}, relative"
    bodies = [{"name": b.name, "mass": b.mass, "simulated": b.mass} for b in mechanism.bodies]
    return made | _report(mechanism.name, "sheet", rows, bodies, comparison, notes, stock, options)


def _area(rims: Sequence[CutLine]) -> float:
    """m² within outlines, less holes. Raises UnsupportedError where a rim does not close."""
    loose = next((line for line in rims if not line.closed), None)
    if loose is not None:
        x, y = loose.points[0].tolist()
        raise UnsupportedError(
            f"two rims of the sheet meet at {millimetres((x, y))}, so that its outline is not one line: draw the "
            "window clear of the rim, or across it"
        )
    return math.fsum((-1.0 if line.pen.name == "hole" else 1.0) * Polygon(line.points).area for line in rims)


def _compensated(pieces: MultiPolygon, kerf: float) -> MultiPolygon:
    """Outlines outward by half of the kerf, holes inward. Raises ExportError where pieces would grow into one."""
    grown = offset(shapely.union_all(list(pieces.geoms)), 0.5 * kerf)
    clash = clash_of("pieces of the sheet", list(pieces.geoms), grown, kerf)
    if clash is not None:
        raise clash
    return grown


def _parts(pieces: MultiPolygon, lines: Sequence[CutLine]) -> int:
    """How many parts come loose: what is within outlines, parted by cuts from rim to rim."""
    cuts = [LineString(line.points) for line in lines if line.pen.name == "cut"]
    if not cuts:
        return len(pieces.geoms)
    every = shapely.union_all([shapely.boundary(pieces), *cuts])
    faces = shapely.get_parts(shapely.polygonize(shapely.get_parts(every)))
    shapely.prepare(pieces)
    return int(shapely.contains(pieces, shapely.point_on_surface(faces)).sum())


def _pieces(rims: Sequence[CutLine]) -> list[Polygon]:
    """What each outline encloses, less its holes; a piece in a hole is one by itself."""
    holes = [Polygon(line.points) for line in rims if line.pen.name == "hole"]
    tree, found = STRtree(holes), list[Polygon]()
    for line in rims:
        if line.pen.name == "border":
            whole = Polygon(line.points)
            within = [holes[k] for k in tree.query(whole, predicate="covers").tolist()]
            found += shapely.get_parts(shapely.difference(whole, shapely.union_all(within))).tolist()
    return found


def _perforated(lines: Sequence[CutLine], pitch: float, kerf: float) -> list[CutLine]:
    found: list[CutLine] = []
    for line in lines:
        if line.closed or line.pen.name in ("border", "cut", "flat"):
            found.append(line)
        else:
            dashes = dashes_of(LineString(line.points), pitch, kerf, _place(line))
            found += [open_line(dash, line.pen) for dash in dashes]
    return found


def _place(line: CutLine) -> str:
    x, y = line.points.mean(axis=0)
    return f"around {millimetres((x, y))}"


def _stock(lines: Sequence[CutLine], options: ExportOptions) -> Stock:
    low, high = bounds_of(lines)
    assert not isinstance(options.stock, str)
    return stock_of(low, high, options.stock, options.pins, options.kerf)


def _drawings(stem: str, name: str, about: str, lines: Sequence[CutLine], stock: Stock) -> dict[str, bytes]:
    placed = [replace(line, points=line.points + stock.shift) for line in lines] + list(stock.lines)
    ordered = sorted(placed, key=lambda line: line.pen.name)  # by layers, holes first; else as they come
    text = svg_text(ordered, f"{name}: {stem}", about, stock.page)
    return {f"{stem}.dxf": dxf_bytes(ordered), f"{stem}.svg": text.encode()}


def _report(
    name: str,
    kind: str,
    layers: list[dict[str, Any]],
    bodies: list[dict[str, Any]],
    comparison: str,
    notes: list[str],
    stock: Stock,
    options: ExportOptions,
) -> dict[str, bytes]:
    """README.md and cut.json: SI. kind: "laminate" or "sheet"."""
    data = {
        "design": name,
        "kind": kind,
        "layers": layers,
        "bodies": bodies,
        "comparison": comparison,
        "kerf": options.kerf,
        "hinge_style": options.hinge_style,
        "hinge_width": options.hinge_width,
        "shift": stock.shift.tolist(),
        "notes": [*notes, *([stock.note] if stock.note else []), SUPPORTS],
    }
    text = json.dumps(data, indent=1, ensure_ascii=False, allow_nan=False) + "\n"
    return {REPORT: text.encode(), "README.md": readme(data).encode()}
