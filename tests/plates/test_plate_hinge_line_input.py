"""Hinge lines that cannot be: each refused by name; and any line through a square, which can."""

from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from shapely.geometry import LineString, MultiLineString, Point, box

from lamc import plate
from lamc.basics.errors import DesignError, UnsupportedError
from tests.support.plates import assert_refused, isotropic
from tests.support.quick import tries

SQUARE = box(0, 0, 1, 1)
LEFT, RIGHT = LineString([(0, 0), (0, 1)]), LineString([(1, 0), (1, 1)])
MIDDLE = LineString([(0.5, 0), (0.5, 1)])


def problem(*hinges: plate.HingeLine, element: str = "dkt", **more: object) -> plate.Problem:
    mesh = plate.grid(1.0, 1.0, 8, 8, "squares" if element in ("bfs", "q4", "q8") else "union-jack")
    return plate.Problem(mesh, isotropic(density=1.0), element, hinges=hinges, **more)  # type: ignore[arg-type]


def on(*points: tuple[float, float], k: float = 0.0, name: str = "") -> Callable[[], plate.Problem]:
    return lambda: problem(plate.HingeLine(LineString(points), k, name))


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (on((0.5, 0), (0.5, 1), k=-1.0), "stiffness of a HingeLine is -1"),
        (on((0.5, 0), (0.5, 1), k=np.nan), "stiffness of a HingeLine"),
        (on((0.5, 0), (0.5, 1), name="a\nb"), "do not print"),
        (on((0.5, 0.5), (0.5, 0.5)), "has no length"),
        (on((0.5, 0), (0.5, np.nan)), "geometry that is not valid"),
        (lambda: plate.HingeLine(LineString()), "empty geometry"),
        (lambda: plate.HingeLine(Point(0.5, 0.5)), "must be a shapely LineString inside"),
        (lambda: plate.HingeLine(SQUARE), "must be a shapely LineString inside"),
        (lambda: plate.HingeLine("boundary"), "must be a shapely LineString inside"),  # type: ignore[arg-type]
        (on((2.5, 0), (2.5, 1), name="h"), "the HingeLine 'h' at the line .* lies along no edge"),
        (on((0, 0), (1, 0)), "runs along the edge of the plate at"),
        (on((0, 1), (0, 0), (0.5, 0.5)), "runs along the edge of the plate at"),
        (on((0.3, 0), (0.3, 1)), "lies along no edge of the mesh"),
        (on((0.5, 0), (0.5, 0.5), (0.6, 0.9)), "leaves the edges of the mesh at"),
        (on((0.5, 0), (0.5, 0.55)), r"ends at \(0.5, 0.55\), within an edge of the mesh"),
        (lambda: problem(MIDDLE), "hinges of a Problem .* HingeLine"),  # type: ignore[arg-type]
        (
            lambda: problem(
                plate.HingeLine(LineString([(0.5, 0), (0.5, 0.75)]), name="one"),
                plate.HingeLine(LineString([(0.5, 1), (0.5, 0.5)]), name="two"),
            ),
            r"'two' at .* lies upon the HingeLine 'one' at .* \(0.5, 0\.\d+\)",
        ),
        (
            lambda: problem(
                plate.HingeLine(LineString([(0.25, 0), (0.25, 1)]), name="fold"),
                plate.HingeLine(LineString([(0.75, 0), (0.75, 1)]), name="fold"),
            ),
            r"'fold' at the line from \(0\.75.* has the name of the one at the line from \(0\.25.*MultiLineString",
        ),
    ],
)
def test_impossible_lines_are_named(make: Callable[[], object], message: str) -> None:
    assert_refused(make, message)


@pytest.mark.parametrize(("x", "y"), [("a", 0.2), ([0.5, 0.5], [0.1, 0.2, 0.3]), (None, [{}])])
def test_a_rotation_is_of_points(x: object, y: object) -> None:
    load = plate.EdgeLoad(RIGHT, 1.0)
    held = problem(plate.HingeLine(MIDDLE, 1.0), supports=[plate.Clamped(LEFT)], loads=[load])
    with pytest.raises(DesignError, match="x and y must be numbers, or arrays of one shape"):
        plate.solve(held).hinge_rotation(x, y)  # type: ignore[arg-type]


def test_a_membrane_does_not_fold() -> None:
    with pytest.raises(DesignError, match="lets the plate fold, and element 'cst' only stretches"):
        problem(plate.HingeLine(MIDDLE), element="cst")


def test_a_spring_to_the_ground_along_a_hinge_line_is_ambiguous() -> None:
    line = plate.HingeLine(MIDDLE, 1.0)
    assert_refused(
        lambda: problem(line, supports=[plate.Hinged(MIDDLE, 2.0)]),
        "lies along a HingeLine, whose sides turn apart",
    )
    problem(line, supports=[plate.Hinged(MIDDLE)])


def test_a_held_line_parts_the_plate_in_two() -> None:
    """A free hinge line that is held, w = 0, is a simply supported edge of either half: each is a plate of its own."""
    y = np.linspace(0.1, 0.9, 5)
    both = plate.solve(
        problem(
            plate.HingeLine(MIDDLE),
            supports=[plate.SimplySupported("boundary"), plate.Hinged(MIDDLE)],
            loads=[plate.PointLoad((0.25, 0.4), 1.0)],
        )
    )
    half = plate.Problem(
        plate.grid(0.5, 1.0, 4, 8, "union-jack"),
        isotropic(),
        supports=[plate.SimplySupported("boundary")],
        loads=[plate.PointLoad((0.25, 0.4), 1.0)],
    )
    assert both.deflection(0.25, y) == pytest.approx(plate.solve(half).deflection(0.25, y), rel=1e-10)
    assert np.abs(both.deflection(0.75, y)).max() < 1e-15


def test_a_line_over_a_hole_hinges_what_is_left_and_says_so() -> None:
    holed = SQUARE.difference(box(0.4, 0.4, 0.6, 0.6))
    line = MIDDLE.intersection(holed)
    mesh = plate.mesh(holed, 0.1, follow=[line])
    made = {
        "supports": [plate.Clamped(LEFT), plate.Clamped(RIGHT)],
        "loads": [plate.Pressure(1.0)],
    }
    two = plate.solve(plate.Problem(mesh, isotropic(), hinges=[plate.HingeLine(line)], **made))  # type: ignore[arg-type]
    one = plate.solve(plate.Problem(mesh, isotropic(), hinges=[plate.HingeLine(MIDDLE)], **made))  # type: ignore[arg-type]
    assert isinstance(line, MultiLineString)
    assert (one.values == two.values).all()
    assert any("0.2 m lie off the plate" in note for note in one.report.notes)
    assert not any("off the plate" in note for note in two.report.notes)


def test_a_necked_plate_is_refused_where_a_line_passes_the_neck() -> None:
    points = [(0, 0), (1, 0), (1, 1), (0, 1), (2, 1), (2, 2), (1, 2)]
    cells = [(0, 1, 2), (0, 2, 3), (2, 4, 5), (2, 5, 6)]
    mesh = plate.Mesh(np.array(points, dtype=float), np.array(cells))
    with pytest.raises(
        DesignError, match=r"passes \(1, 1\) m, where parts of the plate touch at a point only"
    ):
        plate.Problem(mesh, isotropic(), hinges=[plate.HingeLine(LineString([(0, 0), (1, 1)]))])


def test_an_element_of_ones_own_without_slopes_is_refused() -> None:
    lines = [plate.HingeLine(MIDDLE)]
    mesh = plate.grid(1.0, 1.0, 2, 2)
    cst = plate.ELEMENTS["cst"]
    own = plate.Element("flat", cst.cell, tuple(plate.Node(n.at, ("w",)) for n in cst.nodes), w=cst.u[::2])
    with pytest.raises(UnsupportedError, match="needs an element with w, w_x and w_y at its corners"):
        plate.Problem(mesh, isotropic(), own, hinges=lines)


# --- mechanisms ------------------------------------------------------------------------------------------------------


def test_a_free_hinge_beyond_a_clamp_is_a_mechanism_that_is_named() -> None:
    line = plate.HingeLine(MIDDLE, name="knee")
    with pytest.raises(
        DesignError, match=r"mechanism: piece 1 of 1 .* may fold along the HingeLine 'knee'.*0\.375"
    ):
        plate.solve(
            problem(line, supports=[plate.Clamped(LEFT)], loads=[plate.Pressure(3.0)])
        )  # 3 (1/2)² / 2
    # A spring holds it, and so does a point beyond it.
    for held in (
        problem(plate.HingeLine(MIDDLE, 1e-9), supports=[plate.Clamped(LEFT)], loads=[plate.Pressure(1.0)]),
        problem(
            line,
            supports=[plate.Clamped(LEFT), plate.Support(Point(1, 0.5), ("w",))],
            loads=[plate.Pressure(1.0)],
        ),
    ):
        plate.solve(held)


def test_several_free_hinges_are_each_named() -> None:
    lines = [plate.HingeLine(LineString([(x, 0), (x, 1)]), name=f"h{x}") for x in (0.25, 0.5, 0.75)]
    with pytest.raises(DesignError) as caught:
        plate.solve(
            problem(
                *lines,
                supports=[plate.Clamped(LEFT), plate.Clamped(RIGHT)],
                loads=[plate.PointLoad((0.5, 0.3), 1.0)],
            )
        )
    # Three hinges between two clamps: one motion, of all three.
    assert all(f"'h{x}'" in str(caught.value) for x in (0.25, 0.5, 0.75))
    assert str(caught.value).count("may fold") == 1


def test_a_mechanism_under_a_load_in_balance_is_solved_as_it_floats() -> None:
    # On the line itself a load does no work when the plate folds. With ν = 0 the line stays straight: P L³ / 3 D.
    found = plate.solve(
        plate.Problem(
            plate.grid(1.0, 1.0, 8, 8, "squares"),
            isotropic(nu=0.0),
            "bfs",
            supports=[plate.Clamped(LEFT)],
            loads=[plate.EdgeLoad(MIDDLE, 1.0)],
            hinges=[plate.HingeLine(MIDDLE)],
        )
    )
    assert found.deflection(0.5, [0.0, 0.3, 1.0]) == pytest.approx(0.5**3 / 3, rel=1e-10)
    assert "fold along" in found.report.free


def test_a_free_plate_with_a_free_hinge_has_four_motions_and_then_modes() -> None:
    found = plate.modes(problem(plate.HingeLine(MIDDLE, name="h")), 6)
    assert len(found.rigid) == 4
    assert [name for name in found.rigid if name.startswith("fold")] == [
        "fold along the HingeLine 'h' at the line from (0.5, 0) to (0.5, 1)"
    ]
    assert (found.omega[:4] == 0.0).all()
    assert found.omega[4] > 1.0


# --- any line --------------------------------------------------------------------------------------------------------

_at = st.floats(0.03, 0.97)


@settings(max_examples=tries(25), deadline=None)
@given(a=_at, b=_at, sides=st.sampled_from(["ns", "ew", "corner"]), k=st.sampled_from([0.0, 1.0, 1e9]))
def test_any_line_through_a_square_is_a_hinge(a: float, b: float, sides: str, k: float) -> None:
    """The mesh follows it, energy balances close, and a free hinge leaves one motion of two rigid parts."""
    ends = {"ns": ((a, 0), (b, 1)), "ew": ((0, a), (1, b)), "corner": ((0, a), (b, 0))}[sides]
    line = LineString(ends)
    assume(line.length > 0.05)
    mesh = plate.mesh(SQUARE, 0.2, follow=[line])
    assert mesh.areas.sum() == pytest.approx(1.0, rel=1e-12)
    hinge = plate.HingeLine(line, k, "h")
    made = plate.Problem(
        mesh,
        isotropic(density=1.0),
        supports=[plate.SimplySupported("boundary")],
        loads=[plate.Pressure(1.0)],
        hinges=[hinge],
    )
    copies = len(made.dofs.points) - len(mesh.points)
    assert copies == len(made.hinge_edges[0]) + 1  # each node of the line is there twice, its ends too
    solution = plate.solve(made)
    force = sum(reaction.force for reaction in solution.reactions)
    assert force == pytest.approx([0, 0, -1.0], abs=1e-10)
    assert solution.strain_energy == pytest.approx(0.5 * solution.compliance, rel=1e-9)
    free = plate.Problem(mesh, isotropic(density=1.0), hinges=[plate.HingeLine(line, 0.0, "h")])
    modes = plate.modes(free, 5)
    assert sum(name.startswith("fold") for name in modes.rigid) == 1
    assert len(modes.rigid) == 4
    # Folding is exact: two planes that meet in the line, at every node.
    distance = _distance(mesh.points, line)
    shapes = modes.shapes[: len(mesh.points), :4]
    planes = np.column_stack([np.ones(len(distance)), mesh.points, np.maximum(distance, 0.0)])
    left = shapes - planes @ np.linalg.lstsq(planes, shapes, rcond=None)[0]
    assert np.abs(left).max() < 1e-8


def _distance(points: np.ndarray, line: LineString) -> np.ndarray:
    (x0, y0), (x1, y1) = line.coords
    return (points[:, 0] - x0) * (y1 - y0) - (points[:, 1] - y0) * (x1 - x0)
