"""Small laminate designs for tests, built by hand from the records, with answers known from geometry."""

import math
from collections.abc import Sequence

from shapely.geometry import MultiPolygon, Polygon, box
from shapely.geometry.base import BaseGeometry

from lamc.records.design import Design, HingeLine, HingeSet, Layer, Line, Material

MM = 1e-3
RIGID = Material("fibreglass", 1800.0, is_rigid=True)
GLUE = Material("adhesive", 1100.0, is_adhesive=True)
FLEX = Material("polyimide", 1420.0, is_flexible=True)


def multi(geometry: BaseGeometry) -> MultiPolygon:
    return geometry if isinstance(geometry, MultiPolygon) else MultiPolygon([geometry])


def sheet(
    outline: BaseGeometry,
    lines: Sequence[Line | HingeLine],
    fixed: BaseGeometry,
    *,
    width: float = 0.2 * MM,
    layers: Sequence[Layer] | None = None,
    flexible: int = 0,
    name: str = "sheet",
    **properties: float,
) -> Design:
    """One outline in 0.1 mm of polyimide (or in the given layers), one hinge set, one fixed region."""
    layers = layers or [Layer("flex", FLEX, 0.1 * MM, multi(outline))]
    drawn = tuple(line if isinstance(line, HingeLine) else HingeLine(line) for line in lines)
    hinges = HingeSet(drawn, width, flexible, tuple(range(len(layers))), **properties)  # type: ignore[arg-type]
    return Design(name, tuple(layers), (hinges,), (multi(fixed),) * len(layers))


def pendulum() -> Design:
    """The paper's triple pendulum as in popupCAD's pendulum.cad, by hand: density 1, layers of 0.2 m."""
    width = 1e-5
    lines: list[Line] = [((0, 0), (0, 1)), ((1, 0), (1, 1)), ((2, 1), (2, 0))]
    plate = box(-1, 0, 3, 1)
    opened = plate
    for (x, _), _ in lines:
        opened = opened.difference(box(x - width, -1, x + width, 2))
    kinds = ("rigid", "adhesive", "flexible", "adhesive", "rigid")
    layers = [
        Layer(kind, Material(kind, 1.0), 0.2, multi(plate if kind == "flexible" else opened))
        for kind in kinds
    ]
    held = box(-1.0952, -0.1623, -0.8873, 1.1561)
    return sheet(
        plate,
        lines,
        held,
        width=width,
        layers=layers,
        flexible=2,
        name="pendulum",
        stiffness=100.0,
        damping=10.0,
    )


def flaps() -> Design:
    """The device of flaps.joints before it was cut: two rigid layers open by 0.2 mm around a flexible one."""
    plate = box(-0.05, 0.0, 0.06, 0.012)
    opened = plate
    for x in (-0.02, 0.02):
        opened = opened.difference(box(x - 0.2 * MM, -1, x + 0.2 * MM, 1))
    layers = (
        Layer("rigid_low", RIGID, 0.5 * MM, multi(opened)),
        Layer("flex", FLEX, 0.05 * MM, multi(plate)),
        Layer("rigid_high", RIGID, 0.5 * MM, multi(opened)),
    )
    left = HingeSet(
        (HingeLine(((-0.02, 0.0), (-0.02, 0.012))),),
        0.2 * MM,
        1,
        (0, 1, 2),
        stiffness=0.004,
        damping=2e-6,
        rest_angle=math.radians(15),
        limits=(math.radians(-120), math.radians(120)),
    )
    right = HingeSet((HingeLine(((0.02, 0.0), (0.02, 0.012))),), 0.2 * MM, 1, (0, 1, 2), 0.004, 2e-6)
    held = multi(box(-0.01, 0.004, 0.01, 0.008))
    return Design("flaps", layers, (left, right), (held, MultiPolygon(), MultiPolygon()))


def vertex(angles: Sequence[float] = (0, 90, 180, 270), radius: float = 10 * MM) -> Design:
    """Creases from the middle of a disc-like plate to its edge, at the given angles in degrees."""
    rotation = [math.radians(a) for a in angles]
    lines: list[Line] = [
        ((0.0, 0.0), (1.2 * radius * math.cos(a), 1.2 * radius * math.sin(a))) for a in rotation
    ]
    disc = Polygon(
        [
            (radius * math.cos(2 * math.pi * i / 48), radius * math.sin(2 * math.pi * i / 48))
            for i in range(48)
        ]
    )
    middle = (rotation[0] + rotation[1]) / 2
    x, y = 0.8 * radius * math.cos(middle), 0.8 * radius * math.sin(middle)
    return sheet(disc, lines, box(x - MM / 2, y - MM / 2, x + MM / 2, y + MM / 2), name="vertex")


def miura(rows: int = 3, columns: int = 3, a: float = 10 * MM, lean: float = 3 * MM) -> Design:
    """Miura-ori of parallelogram facets: every crease a line of its own; the lower left facet is fixed."""

    def corner(row: int, column: int) -> tuple[float, float]:
        return column * a + (lean if row % 2 else 0.0), row * a

    lines: list[Line] = []
    for row in range(rows):
        lines += [(corner(row, c), corner(row + 1, c)) for c in range(1, columns)]
    for row in range(1, rows):
        lines += [(corner(row, c), corner(row, c + 1)) for c in range(columns)]
    left = [corner(row, 0) for row in range(rows + 1)]
    right = [corner(row, columns) for row in range(rows, -1, -1)]
    return sheet(
        Polygon(left + right), lines, box(4 * MM, 3 * MM, 6 * MM, 5 * MM), name="miura", stiffness=1e-3
    )


def strip(lengths: Sequence[float], height: float = 5 * MM) -> Design:
    """A strip cut into plates of the given lengths by hinge lines across it; the first is fixed."""
    lines: list[Line] = []
    x = 0.0
    for length in lengths[:-1]:
        x += length
        lines.append(((x, 0.0), (x, height)))
    total = sum(lengths)
    return sheet(box(0, 0, total, height), lines, box(-1, 1 * MM, lengths[0] / 2, 2 * MM), name="strip")
