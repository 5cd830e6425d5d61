"""What does nothing is said to do nothing: plates that cannot move, loads that supports take, lines off the plate."""

import numpy as np
import pytest
from shapely.geometry import LineString, MultiPoint, Point, box

from lamc import plate
from lamc.basics.errors import DesignError
from lamc.plates.loads import LoadRecord
from lamc.plates.supports import SupportRecord
from tests.support.plates import isotropic

SQUARE = plate.grid(1.0, 1.0, 4, 4)
ALL, LEFT, RIGHT = box(-1, -1, 2, 2), LineString([(0, 0), (0, 1)]), LineString([(1, 0), (1, 1)])
DENSE = isotropic(density=1000.0)


def notes(*loads: LoadRecord, supports: list[SupportRecord] | None = None) -> tuple[str, ...]:
    chosen = [plate.Clamped("boundary")] if supports is None else supports
    return plate.solve(plate.Problem(SQUARE, isotropic(), supports=chosen, loads=loads)).report.notes


# --- nothing can move ---


@pytest.mark.parametrize("cells", [1, 2, 6])
def test_a_plate_that_is_held_everywhere_stays_and_its_supports_take_the_load(cells: int) -> None:
    mesh = plate.grid(1.0, 1.0, cells, cells)
    problem = plate.Problem(
        mesh,
        isotropic(),
        supports=[plate.Clamped(ALL)],
        loads=[plate.Pressure(3.0), plate.PointLoad((0, 0), 2.0)],
    )
    solution = plate.solve(problem)
    assert not solution.values.any()
    (reaction,) = solution.reactions
    assert reaction.force == pytest.approx(
        [0.0, 0.0, -5.0], rel=1e-12
    )  # 3 Pa on 1 m², and 2 N: sums of 50 terms
    assert "the supports hold every unknown of the plate, so nothing can move" in solution.report.notes[0]


def test_a_field_that_is_prescribed_everywhere_is_the_answer() -> None:
    # w = x²/2 at all nodes: the elements bend with κ_x = -1, and M_x = D κ_x.
    held = [
        plate.Support(ALL, ("w",), lambda x, y: 0.5 * x * x),
        plate.Support(ALL, ("w_x",), lambda x, y: x),
        plate.Support(ALL, ("w_y",), 0.0),
    ]
    solution = plate.solve(plate.Problem(SQUARE, isotropic(nu=0.0), supports=held))
    assert solution.moments(0.3, 0.4) == pytest.approx(
        [-1.0, 0.0, 0.0], abs=1e-12
    )  # DKT is exact for a parabola
    assert "nothing can move" in solution.report.notes[0]


def test_a_plate_that_is_held_everywhere_has_no_modes_and_does_not_buckle() -> None:
    held = plate.Problem(SQUARE, DENSE, supports=[plate.Clamped(ALL)])
    with pytest.raises(
        DesignError, match=r"the supports hold every unknown of the plate, so there is nothing"
    ):
        plate.modes(held)
    with pytest.raises(DesignError, match="the supports hold every unknown of the plate"):
        plate.buckling(held, forces=(-1.0, 0.0, 0.0))
    flat = [plate.Support(ALL, ("w", "w_x", "w_y")), plate.Support(LEFT, ("u", "v"))]
    with pytest.raises(
        DesignError, match="the supports hold every deflection of the plate, so nothing buckles"
    ):
        plate.buckling(plate.Problem(SQUARE, DENSE, supports=flat), forces=(-1.0, 0.0, 0.0))


# --- nothing acts ---


def test_a_plate_without_loads_is_told_so() -> None:
    assert notes() == ("no load acts and no support prescribes a displacement, so everything is zero",)
    moved = [plate.Clamped(LEFT), plate.Support(RIGHT, ("w",), 1e-3)]
    assert notes(supports=moved) == ()


def test_a_load_on_held_nodes_alone_is_told_so() -> None:
    found = notes(plate.PointLoad((0.5, 1.0), 1.0), plate.Pressure(1.0), plate.EdgeLoad(LEFT, 2.0))
    assert len(found) == 2
    assert found[0].startswith("the PointLoad at (0.5, 1) acts on nothing but what supports hold")
    assert found[1].startswith(
        "the EdgeLoad at the line from (0, 0) to (0, 1) acts on nothing but what supports hold"
    )


def test_a_load_on_a_plate_that_floats_is_not_taken_for_one_on_supports() -> None:
    # Wherever the plate is pinned for the sake of the equations, no support is.
    pull = [
        plate.PointLoad((x, y), ((2 * x - 1), (2 * y - 1), 0.0)) for x, y in ((0, 0), (1, 1), (0, 1), (1, 0))
    ]
    assert notes(*pull, supports=[]) == ()
    # A half of the same load goes into a support, the other does not.
    assert (
        notes(plate.EdgeMoment(RIGHT, 1.0), supports=[plate.Clamped(LEFT), plate.Support(RIGHT, ("w",))])
        == ()
    )


@pytest.mark.parametrize(
    ("load", "words"),
    [
        (plate.ElectricField(1e5), "the ElectricField does nothing: no ply of the plate is piezoelectric"),
        (
            plate.Temperature(50.0),
            "the Temperature does nothing: no ply of the plate expands with temperature",
        ),
        (plate.Moisture(0.01), "the Moisture does nothing: no ply of the plate expands with moisture"),
        (plate.SelfWeight(), "the SelfWeight does nothing: no ply of the plate has a mass"),
    ],
)
def test_a_load_for_another_material_is_told_so(load: LoadRecord, words: str) -> None:
    (found,) = notes(load)
    assert found.startswith(words)
    whole = plate.Material.isotropic(E=1e9, nu=0.3, density=1.0, alpha=1e-6, beta=0.1)
    piezo = plate.Material(E1=1e9, E2=1e9, nu12=0.3, G12=4e8, density=1.0, d31=1e-10, alpha1=1e-6, beta1=0.1)
    laminate = plate.Laminate([plate.Ply(whole, 1e-3), plate.Ply(piezo, 1e-3)])  # one ply that has it does
    problem = plate.Problem(SQUARE, laminate, supports=[plate.Clamped(LEFT)], loads=[load])
    assert plate.solve(problem).report.notes == ()


# --- beside the plate ---


def test_lines_that_reach_beyond_the_plate_are_told_by_how_much() -> None:
    supports: list[SupportRecord] = [plate.Clamped(LineString([(0, -5), (0, 0.5)]))]
    along = plate.EdgeLoad(LineString([(1, 0), (1, 9)]), 1.0)
    solution = plate.solve(plate.Problem(SQUARE, isotropic(), supports=supports, loads=[along]))
    assert solution.reactions[0].force[2] == pytest.approx(-1.0, rel=1e-12)  # 1 N/m on the 1 m that is there
    support, load = solution.report.notes
    assert (
        "the Clamped support at the line from (0, -5) to (0, 0.5) is 5.5 m long, of which 5 m lie off"
        in support
    )
    assert "the EdgeLoad at the line from (1, 0) to (1, 9) is 9 m long, of which 8 m lie off" in load
    assert "only 1 m count" in load


def test_lines_through_a_hole_are_told_by_how_much() -> None:
    line = LineString([(0.5, 0), (0.5, 1)])
    hole = box(0.4, 0.4, 0.6, 0.6)
    frame = plate.mesh(box(0, 0, 1, 1) - hole, 0.1, follow=list((line - hole).geoms))
    cut = plate.Support(line, ("w",))
    held = [plate.Clamped(LEFT), cut]
    problem = plate.Problem(frame, isotropic(), supports=held, loads=[plate.Pressure(1.0)])
    (note,) = plate.solve(problem).report.notes
    assert "is 1 m long, of which 0.2 m lie off the plate" in note


def test_points_off_the_plate_are_counted() -> None:
    held = [plate.Clamped(LEFT), plate.Support(MultiPoint([(1, 0), (3, 3), (1, 1)]), ("w",))]
    (note,) = notes(plate.Pressure(1.0), supports=held)
    assert note == "the Support at (1, 0) and 2 more: 1 of the 3 points lie off the plate and hold nothing"


def test_places_that_fit_are_not_spoken_of() -> None:
    held = [
        plate.Clamped(LEFT),
        plate.Support(Point(1, 1), ("w",)),
        plate.Support(box(0.999, 0.999, 5, 5), ("w_x",)),  # a box around a node
    ]
    assert notes(plate.EdgeLoad(LineString([(0.25, 0), (0.6, 0)]), 1.0), supports=held) == ()


def test_what_recovered_strains_cost_is_paid_once() -> None:
    solution = plate.solve(
        plate.Problem(SQUARE, isotropic(), supports=[plate.Clamped("boundary")], loads=[plate.Pressure(1.0)])
    )
    assert solution.recovered_strains is solution.recovered_strains
    cells, xi = np.arange(3, dtype=np.int32), np.full((3, 2), 1 / 3)
    at = SQUARE.corners[:3].mean(axis=1)
    again = solution.recovered.curvature(at[:, 0], at[:, 1])
    assert again == pytest.approx(solution.recovered_strains.at(cells, xi), rel=1e-9, abs=1e-15)
