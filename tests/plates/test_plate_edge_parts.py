"""Lines that begin and end within edges of the mesh: what acts along them is neither lost nor counted twice."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from shapely.geometry import LineString, MultiLineString, box

from lamc import plate
from lamc.basics.errors import DesignError
from lamc.plates.edge_parts import edge_parts_on
from tests.support.ctools import needs_cc
from tests.support.plate_meshes import held, sheet, sides, solved

pytestmark = needs_cc

MESH = plate.grid(1.0, 1.0, 5, 4)
LEFT = sides()["left"]


@settings(max_examples=8, deadline=None, derandomize=True)
@given(ends=st.tuples(st.floats(0.0, 1.0), st.floats(0.0, 1.0)).filter(lambda e: abs(e[0] - e[1]) > 1e-3))
def test_a_load_along_any_part_of_an_edge_is_carried_whole(ends: tuple[float, float]) -> None:
    """Force and moment of 3 N/m along x = 1 between two heights, by the reactions of a clamped side."""
    low, high = sorted(ends)
    line = LineString([(1.0, ends[0]), (1.0, ends[1])])
    solution = solved(MESH, sheet(), [plate.Clamped(LEFT)], [plate.EdgeLoad(line, 3.0)])
    reaction = solution.reactions[0]
    force = 3.0 * (high - low)
    assert float(reaction.force[2]) == pytest.approx(-force, abs=1e-9)
    moment = 0.5 * (low + high) * force  # about the x axis
    assert float(reaction.moment[0]) == pytest.approx(-moment, abs=1e-9)


def test_parts_of_one_line_add_up_to_it() -> None:
    whole = solved(MESH, sheet(), held("CFFF"), [plate.EdgeMoment(sides()["right"], 1.0)])
    cut = [LineString([(1.0, a), (1.0, b)]) for a, b in ((0.0, 0.13), (0.13, 0.62), (0.62, 1.0))]
    parts = solved(MESH, sheet(), held("CFFF"), [plate.EdgeMoment(line, 1.0) for line in cut])
    np.testing.assert_allclose(parts.values, whole.values, rtol=0, atol=1e-10 * np.abs(whole.values).max())


def test_a_line_drawn_twice_acts_once() -> None:
    problem = plate.Problem(MESH, sheet(), supports=held("CFFF"))
    line = MultiLineString([[(1.0, 0.1), (1.0, 0.7)], [(1.0, 0.9), (1.0, 0.4)]])
    parts = edge_parts_on(problem.places, line, "a line")
    assert float(np.sum(parts.ends[:, 1] - parts.ends[:, 0]) * 0.25) == pytest.approx(0.8, rel=1e-12)


def test_whole_edges_are_exactly_whole() -> None:
    mesh = plate.grid(0.3, 0.7, 7, 9, origin=(0.1, 0.2))
    problem = plate.Problem(mesh, sheet(), supports=[plate.Clamped("boundary")])
    outline = LineString([(0.1, 0.2), (0.4, 0.2), (0.4, 0.9), (0.1, 0.9), (0.1, 0.2)])
    parts = edge_parts_on(problem.places, outline, "a line")
    assert len(parts.edges) == 2 * (7 + 9)
    assert np.array_equal(parts.ends, np.tile([0.0, 1.0], (32, 1)))


@pytest.mark.parametrize(
    "line", [[(0.2, 0.0), (0.2, 0.5), (0.71, 0.93)], [(0.0, 0.5), (0.5, 0.5), (0.55, 0.45), (0.6, 0.5)]]
)
def test_a_line_that_leaves_the_edges_within_the_plate_is_refused(line: list[tuple[float, float]]) -> None:
    with pytest.raises(
        DesignError, match=r"leaves the edges of the mesh at \(0\.\d+, 0\.\d+\), inside the plate"
    ):
        solved(MESH, sheet(), held("CFFF"), [plate.EdgeLoad(LineString(line), 1.0)])


def test_a_line_may_reach_out_of_the_plate() -> None:
    line = LineString([(1.0, -2.0), (1.0, 5.0)])
    solution = solved(MESH, sheet(), held("CFFF"), [plate.EdgeLoad(line, 2.0)])
    assert float(solution.reactions[0].force[2]) == pytest.approx(-2.0, rel=1e-9)


def test_an_area_stands_for_the_boundary_in_it() -> None:
    """Inner edges depend on the mesh, and so would the load."""
    outside = plate.EdgeLoad(box(0.55, -0.1, 1.1, 1.1), 1.0)
    solution = solved(MESH, sheet(), held("CFFF"), [outside])
    assert float(solution.reactions[0].force[2]) == pytest.approx(-1.8, rel=1e-9)  # 1 m, and 0.4 m twice
    with pytest.raises(DesignError, match="an area without an edge of the plate's boundary in it"):
        solved(MESH, sheet(), held("CFFF"), [plate.EdgeLoad(box(0.3, 0.2, 0.9, 0.8), 1.0)])
