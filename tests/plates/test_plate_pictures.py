"""Pictures and files of plates: what is drawn is what was given, where the plate is and nowhere else."""

import base64
import csv
import xml.etree.ElementTree as ET
from pathlib import Path

import numpy as np
import pytest
from matplotlib.figure import Figure
from PIL import Image
from shapely.geometry import LineString, Point, Polygon

from lamc.basics.errors import LamcError
from lamc.basics.numbers import prefixed, shown_number
from lamc.plates.laminates.laminate import Laminate
from lamc.plates.laminates.library import material
from lamc.plates.laminates.plies import Ply
from lamc.plates.loads import EdgeLoad, PointLoad, Pressure
from lamc.plates.meshing.grid import grid
from lamc.plates.meshing.mesh import Mesh
from lamc.plates.problem import Problem
from lamc.plates.supports import Clamped, SimplySupported, Support, Symmetry
from lamc.readers.plates.field_files import write_table, write_vtu
from lamc.report.plate_contours import Field, bands, triangulation
from lamc.report.plate_marks import scale_of
from lamc.report.plate_solid import bent, colours_of, rounded
from lamc.report.plates import draw_deflection, draw_fields, draw_mesh, draw_modes

SHEET = Laminate([Ply(material("steel"), 1e-3)])
METRE = scale_of(1.0)


def plate(nx: int = 12, ny: int = 6, pattern: str = "one-diagonal") -> Problem:
    """2 m by 1 m, its left edge clamped, with a region and a symmetry."""
    left, right = LineString([(0, 0), (0, 1)]), LineString([(2, 0), (2, 1)])
    regions = {"$soft_{a": Polygon([(0.5, 0), (1, 0), (1, 1), (0.5, 1)])}  # no mathematics to matplotlib
    mesh = grid(2.0, 1.0, nx, ny, pattern, regions=regions)
    loads = [EdgeLoad(right, (0.0, 0.0, 3.0)), PointLoad((1.0, 0.5), (0.0, 2.0, -5.0))]
    element = "q4" if pattern == "squares" else "dkt"
    supports = [
        Clamped(left),
        Symmetry(LineString([(0, 0), (2, 0)])),
        SimplySupported(LineString([(1.5, 1), (2, 1)])),
    ]
    if element == "q4":
        return Problem(mesh, SHEET, element=element, supports=[Clamped(left)])
    return Problem(mesh, SHEET, supports=supports, loads=loads)


def with_hole() -> Mesh:
    """3 by 3 squares with the middle one missing."""
    whole = grid(3.0, 3.0, 3, 3)
    middle = np.abs(whole.corners.mean(axis=1) - 1.5).max(axis=1) < 0.5
    return Mesh(whole.points, whole.cells[~middle])


def ink(path: Path) -> float:
    """Share of the picture that is not white."""
    with Image.open(path) as image:
        assert image.format == "PNG"
        return float((np.asarray(image.convert("RGB")) < 250).any(axis=2).mean())


def coloured(path: Path, x: float, y: float) -> tuple[int, int, int]:
    """Colour at a place of the picture, counted from its lower left corner, both 0 to 1."""
    with Image.open(path) as image:
        rgb = image.convert("RGB")
        found = rgb.getpixel((round(x * (rgb.width - 1)), round((1 - y) * (rgb.height - 1))))
        assert isinstance(found, tuple)
        return (int(found[0]), int(found[1]), int(found[2]))


@pytest.mark.parametrize("pattern", ["one-diagonal", "criss-cross", "squares"])
@pytest.mark.quick("squares", others="campaign")
def test_each_picture_is_drawn_of_triangles_and_of_quadrilaterals(tmp_path: Path, pattern: str) -> None:
    problem = plate(pattern=pattern)
    x, y = problem.mesh.points.T
    draw_mesh(problem, tmp_path / "mesh.png", "$a_{", problem.loads)
    draw_deflection(problem, 1e-3 * x**2, tmp_path / "w.png", "$a_{", problem.loads)
    jump = np.sin(problem.mesh.corners[..., 0]) + problem.mesh.regions[:, None]
    fields = [Field("M_x", "N", jump), Field("N_x", "N/m", x - 1.0)]
    draw_fields(problem, fields, tmp_path / "f.png", "$a_{")
    draw_modes(problem, np.column_stack([x, x * y, y]), ["$1", "2", "3"], tmp_path / "m.png", "$a_{")
    for name in ("mesh", "w", "f", "m"):
        assert ink(tmp_path / f"{name}.png") > 0.02


def test_contours_cover_the_plate_and_leave_its_holes_empty() -> None:
    mesh = with_hole()
    drawn = triangulation(mesh, METRE)
    a, b, c = (np.column_stack([drawn.x, drawn.y])[drawn.triangles[:, k]] for k in range(3))
    u, v = b - a, c - a
    area = 0.5 * np.abs(u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0])
    assert area.sum() == pytest.approx(8.0, rel=1e-12)
    assert drawn.get_trifinder()(1.5, 1.5) == -1


def test_a_hole_stays_white_in_the_picture(tmp_path: Path) -> None:
    mesh = with_hole()
    problem = Problem(mesh, SHEET)
    path = draw_deflection(problem, np.ones(len(mesh.points)), tmp_path / "w.png", "hole")
    # The plan is the left part; its middle is the hole's, and to its left the plate is coloured.
    with Image.open(path) as image:
        rgb = np.asarray(image.convert("RGB"))
    left = rgb[:, : rgb.shape[1] * 2 // 5]
    grey = left.max(axis=2).astype(int) - left.min(axis=2)
    row = grey[rgb.shape[0] // 2] > 30  # coloured, not grey
    runs = np.flatnonzero(np.diff(np.concatenate([[0], row.astype(int), [0]])))
    widths = runs[1::2] - runs[::2]
    assert (widths > 40).sum() == 2  # plate, hole, plate


def test_peaks_beyond_the_colour_bar_are_no_white_holes(tmp_path: Path) -> None:
    """Two cells of 800 have values far beyond the others: the picture has no white pixel between the plate's edges."""
    mesh = grid(1.0, 1.0, 20, 20)
    peaks = np.tile(np.linspace(0.0, 1.0, len(mesh.cells))[:, None], 3)
    peaks[209], peaks[609] = 50.0, -50.0
    path = draw_fields(Problem(mesh, SHEET), [Field("M_x", "N", peaks)], tmp_path / "f.png", "peaks")
    with Image.open(path) as image:
        rgb = np.asarray(image.convert("RGB"))
    coloured = rgb.max(axis=2).astype(int) - rgb.min(axis=2) > 40
    rows = np.flatnonzero(coloured[:, : rgb.shape[1] // 2].sum(axis=1) > 100)
    columns = np.flatnonzero(coloured[rows.min() : rows.max()].sum(axis=0) > 100)
    inside = rgb[rows.min() + 3 : rows.max() - 3, columns.min() + 3 : columns.min() + 200]
    assert (inside.min(axis=2) < 250).all()


@pytest.mark.parametrize(("low", "high"), [(-12.6, 2.1), (-1.0, 1.0), (-0.03, 7.0), (-900.0, 120.0)])
def test_zero_is_the_middle_of_a_band_of_colour_and_has_a_number(low: float, high: float) -> None:
    """Moments that vanish are plus and minus a little from cell to cell: a border at zero would draw that."""
    levels, ticks = bands(low, high, about_zero=True)
    assert ticks is not None
    below, above = levels[levels < 0.0].max(), levels[levels > 0.0].min()
    assert below == pytest.approx(-above, rel=1e-12)
    assert 0.0 in ticks
    step = above - below  # half a band at each end may be peaks
    assert levels[0] == pytest.approx(low, abs=step)
    assert levels[-1] == pytest.approx(high, abs=step)


def test_the_legend_tells_regions_supports_and_loads_apart(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    kept: list[Figure] = []
    monkeypatch.setattr("lamc.report.plates.save", lambda figure, path: (kept.append(figure), path)[1])
    mesh = grid(2.0, 1.0, 12, 6, regions={"soft": Polygon([(0.5, 0), (1, 0), (1, 1), (0.5, 1)])})
    supports = [
        Support(Point(0.0, 0.0), dofs=("w", "w_x", "w_y")),
        Support(Point(2.0, 0.0), dofs=("w", "w_x")),
        Support(Point(0.0, 1.0), dofs=("w",)),
    ]
    problem = Problem(mesh, SHEET, supports=supports, loads=[Pressure(10.0)])
    draw_deflection(problem, mesh.points[:, 0] ** 2, tmp_path / "w.png", "w", problem.loads)
    (legend,) = kept[0].legends
    marks = {text.get_text(): line for text, line in zip(legend.get_texts(), legend.get_lines(), strict=True)}
    assert {"border of soft", "at rest", "pressure 10 Pa"} < set(marks)
    held = [line.get_marker() for name, line in marks.items() if name.startswith("held")]
    assert len(set(held)) == 3


def test_a_quantity_has_one_colour_map_and_zero_is_pale_where_it_has_a_sign() -> None:
    name, norm = colours_of(-1.0, 3.0, signed=True)
    assert name == "PuOr"
    assert norm(0.0) == pytest.approx(0.5)
    assert norm(-3.0) == pytest.approx(0.0)
    assert colours_of(0.0, 3.0, signed=True)[0] == colours_of(-3.0, -1.0, signed=True)[0] == "PuOr"
    assert colours_of(0.0, 3.0, signed=False)[0] == "viridis"
    assert colours_of(9.0, 10.0, signed=True)[1](9.0) > 0.5 > colours_of(-10.0, -9.0, signed=True)[1](-9.0)
    assert np.isfinite(colours_of(0.0, 0.0, signed=True)[1](0.0))  # a plate at rest


@pytest.mark.parametrize(("given", "round_"), [(1.0, 1.0), (4.99, 2.0), (5.0, 5.0), (99.0, 50.0), (0.3, 0.2)])
def test_deflections_are_enlarged_by_round_factors(given: float, round_: float) -> None:
    assert rounded(given) == pytest.approx(round_, rel=1e-12)


def test_a_large_mesh_is_seen_in_space_by_fewer_triangles_of_the_same_outline() -> None:
    mesh = grid(2.0, 1.0, 160, 80)
    figure = Figure()
    axis = figure.subplots()
    factor = bent(axis, mesh, np.zeros(len(mesh.points)))
    assert factor == 1.0
    faces = axis.collections[0].get_paths()
    assert 1000 < len(faces) < 13_000 < len(mesh.cells)
    seen = sum(abs(_area(path.vertices[:3])) for path in faces)
    whole = bent_area(grid(2.0, 1.0, 8, 4))
    assert seen == pytest.approx(whole, rel=0.05)  # a square is lost along the edge, 1/55 of the width


def bent_area(mesh: Mesh) -> float:
    axis = Figure().subplots()
    bent(axis, mesh, np.zeros(len(mesh.points)))
    return float(sum(abs(_area(path.vertices[:3])) for path in axis.collections[0].get_paths()))


def _area(corners: np.ndarray) -> float:
    (ax, ay), (bx, by), (cx, cy) = corners
    return 0.5 * float((bx - ax) * (cy - ay) - (cx - ax) * (by - ay))


def test_a_picture_that_cannot_be_written_is_one_error(tmp_path: Path) -> None:
    with pytest.raises(LamcError, match="cannot be written"):
        draw_mesh(plate(), tmp_path / "none" / "mesh.png", "x")


# --- numbers ------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("value", "unit", "text"),
    [
        (2.413e-4, "m", "241.3 µm"),
        (0.25, "m", "250 mm"),
        (0.0, "m", "0 m"),
        (-1e-3, "N", "-1 mN"),
        (2.1e11, "Pa", "210 GPa"),
        (0.004, "", "0.004"),
        (10.2, "1/m", "10.2 1/m"),
        (3e-15, "J", "0.003 pJ"),
    ],
)
def test_numbers_are_reported_in_the_unit_that_suits_them(value: float, unit: str, text: str) -> None:
    assert shown_number(value, unit) == text


def test_a_prefix_suits_the_largest_of_many_numbers() -> None:
    assert prefixed(-0.02, "N/m") == (1e-3, "mN/m")


def test_a_field_of_one_value_has_one_colour_and_one_tick(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A constant stress differs by its last bits from corner to corner: these are not to be seen."""
    kept: list[Figure] = []
    monkeypatch.setattr("lamc.report.plates.save", lambda figure, path: (kept.append(figure), path)[1])
    problem = plate()
    noise = 1.0 + 1e-15 * np.random.default_rng(2).integers(-9, 9, size=problem.mesh.cells.shape)
    draw_fields(
        problem,
        [Field("stress", "Pa", 147.8434411528e6 * noise, signed=False)],
        tmp_path / "s.png",
        "one value",
    )
    (figure,) = kept
    axis, bar = figure.axes
    (drawn,) = [each for each in axis.collections if each.get_array() is not None]
    colours = drawn.norm(np.unique(drawn.get_array()))
    assert len(colours) == 1
    assert [label.get_text() for label in bar.get_yticklabels()] == ["147.843"]


# --- files --------------------------------------------------------------------------------------------------------


def arrays_of(path: Path) -> dict[str, np.ndarray]:
    """The arrays of a VTU file by name, decoded as VTK's manual says."""
    kinds = {"Float64": "<f8", "Int64": "<i8", "UInt8": "u1"}
    found = {}
    for node in ET.parse(path).getroot().iter("DataArray"):
        raw = base64.b64decode(node.text or "")
        size = int.from_bytes(raw[:8], "little")
        assert len(raw) == 8 + size
        width = int(node.attrib["NumberOfComponents"])
        values = np.frombuffer(raw[8:], kinds[node.attrib["type"]])
        found[node.attrib["Name"]] = values.reshape(-1, width) if width > 1 else values
    return found


@pytest.mark.parametrize(("pattern", "kind"), [("union-jack", 5), ("squares", 9)])
def test_a_vtu_file_reads_back_to_the_last_bit(tmp_path: Path, pattern: str, kind: int) -> None:
    mesh = grid(0.3, 0.1, 3, 2, pattern)
    rng = np.random.default_rng(3)
    moved, stress = rng.normal(size=(len(mesh.points), 3)), rng.normal(size=len(mesh.cells))
    name = 'case <a> & "b": displacement'
    path = write_vtu(mesh, {name: moved}, {"stress": stress, "region": mesh.regions}, tmp_path / "f.vtu")
    read = arrays_of(path)
    assert np.array_equal(read["points"][:, :2], mesh.points)
    assert np.array_equal(read["points"][:, 2], np.zeros(len(mesh.points)))
    assert np.array_equal(read["connectivity"].reshape(mesh.cells.shape), mesh.cells)
    assert np.array_equal(np.diff(read["offsets"]), np.full(len(mesh.cells) - 1, mesh.corner_count))
    assert (read["types"] == kind).all()
    assert np.array_equal(read[name], moved)
    assert np.array_equal(read["stress"], stress)


def test_a_table_reads_back_to_the_last_bit(tmp_path: Path) -> None:
    mesh = grid(0.3, 0.1, 3, 2)
    values = np.random.default_rng(5).normal(size=len(mesh.points))
    path = write_table(mesh, {'a, "b": w [m]': values}, tmp_path / "f.csv")
    with path.open(encoding="utf-8", newline="") as stream:
        heads, *rows = csv.reader(stream)
    assert heads == ["x [m]", "y [m]", 'a, "b": w [m]']
    assert np.array_equal(np.array(rows, dtype=float), np.column_stack([mesh.points, values]))


def test_slivers_of_another_laminate_are_enlarged(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    kept: list[Figure] = []
    monkeypatch.setattr("lamc.report.plates.save", lambda figure, path: (kept.append(figure), path)[1])
    film = Polygon([(1.0, 0), (1.04, 0), (1.04, 1), (1.0, 1)])
    mesh = grid(2.0, 1.0, 50, 4, regions={"film": film})
    other = Laminate([Ply(SHEET.plies[0].material, 1e-5)])
    values = np.where(mesh.regions == mesh.region_names.index("film"), 7.0, 1.0)[:, None] * np.ones(3)
    field = Field("stress", "Pa", values, signed=False)
    draw_fields(Problem(mesh, {"film": other, "": SHEET}), [field], tmp_path / "f.png", "film")
    draw_fields(Problem(mesh, SHEET), [field], tmp_path / "f.png", "one laminate")
    (inset,) = [child for axis in kept[0].axes for child in axis.child_axes]
    assert inset.get_title() == "film: 7 to 7 Pa"
    assert not [child for axis in kept[1].axes for child in axis.child_axes]
