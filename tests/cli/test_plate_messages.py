"""What a user reads who hands over the wrong thing: the argument, its value, the way out, and no round-off."""

import importlib.util
from collections.abc import Callable
from pathlib import Path

import pytest
from shapely.geometry import LineString, MultiLineString, Point, Polygon

from lamc import plate
from lamc.basics.checks import checked_number
from lamc.basics.errors import DesignError, UnsupportedError
from lamc.plates.supports import Where
from tests.support.plates import isotropic

SQUARE = plate.grid(1.0, 1.0, 4, 4)
LEFT = LineString([(0, 0), (0, 1)])
HELD = plate.Problem(
    SQUARE, isotropic(), supports=[plate.Clamped("boundary")], loads=[plate.PointLoad((0.5, 0.5), 1.0)]
)


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (
            lambda: plate.hinge_stiffness(None, 1.0, 1.0),
            "the laminate of a hinge is None; it must be a Laminate",
        ),
        (lambda: plate.solve(None), "the problem is None; it must be a Problem"),
        (lambda: plate.FactoredPlate(SQUARE), r"the problem is <Mesh.*; it must be a Problem"),
        (
            lambda: plate.mesh_report(None),
            "the mesh of a report is None; it must be a Mesh: make one by plate.grid",
        ),
        (lambda: plate.bciz_bias(None), "the mesh of a bias is None; it must be a Mesh"),
        (lambda: plate.refined(None), "the mesh to refine is None; it must be a Mesh"),
        (lambda: plate.jittered(None), "the mesh of a jitter is None; it must be a Mesh"),
        (
            lambda: plate.flexibility(None, [(0, 0)]),
            "the problem of a flexibility is None; it must be a Problem",
        ),
        (
            lambda: plate.flexibility(HELD, None),
            r"the points of a flexibility is None|the points of a flexibility",
        ),
        (lambda: plate.describe(None), "the element is None; it must be an Element, or the name of one"),
        (lambda: plate.combine("dkt", 3), "the element is 3; it must be an Element, or the name of one"),
        (lambda: plate.estimate_memory(None, 3), "the element is None; it must be an Element"),
        (
            lambda: plate.estimate_memory("dkt", "many"),
            "the number of cells is 'many'; it must be a whole number",
        ),
        (
            lambda: plate.solve(HELD).ply_states([0.1, 0.2], [0.1, 0.2]),
            "they are of one point, .*: ask point by point",
        ),
        (lambda: plate.solve(HELD).ply_states("a", 0.2), "x and y must be numbers"),
    ],
)
def test_arguments_of_another_kind_are_named(call: Callable[[], object], words: str) -> None:
    with pytest.raises(DesignError, match=words) as caught:
        call()
    assert "\n" not in str(caught.value)


def test_a_mesh_that_is_none_is_not_written(tmp_path: Path) -> None:
    with pytest.raises(DesignError, match=r"what is written to a.vtu is None; it must be a Mesh"):
        plate.write_mesh(tmp_path / "a.vtu", None)  # type: ignore[arg-type]
    assert not list(tmp_path.iterdir())


def test_names_do_wherever_elements_do() -> None:
    dkt, cst = plate.ELEMENTS["dkt"], plate.ELEMENTS["cst"]
    assert plate.describe("dkt") == plate.describe(dkt)
    assert plate.combine("dkt", "cst") == plate.combine(dkt, cst)
    assert plate.estimate_memory("dkt", 1000) == plate.estimate_memory(dkt, 1000)


@pytest.mark.parametrize(("solver", "package"), [("pardiso", "pypardiso"), ("cholmod", "sksparse")])
def test_a_solver_that_is_not_there_goes_by_the_name_that_was_given(solver: str, package: str) -> None:
    if importlib.util.find_spec(package) is not None:
        pytest.skip(f"{package} is installed here")
    with pytest.raises(UnsupportedError, match=f"solver '{solver}' cannot be used: .*pip install"):
        plate.solve(HELD, solver=solver)


def test_a_gradient_off_the_plate_speaks_of_the_gradient() -> None:
    with pytest.raises(DesignError, match=r"the point of a gradient of the deflection is at \(5, 5\)"):
        plate.gradient(plate.solve(HELD), of=("deflection", (5, 5)))


def test_what_loads_leave_is_free_of_round_off() -> None:
    mesh = plate.mesh(Polygon([(0, 0), (3, 0.1), (2.7, 2), (0.3, 1.7)]), 0.35)
    middle = 0.5 * (mesh.points.min(axis=0) + mesh.points.max(axis=0))
    loads = [plate.PointLoad(middle, 1.0)]  # through the centre: no moment but round-off
    with pytest.raises(
        DesignError, match=r"leave a force \(0, 0, 1\) N and a moment \(0, 0, 0\) N·m about its centre"
    ):
        plate.solve(plate.Problem(mesh, isotropic(), loads=loads))


@pytest.mark.parametrize(
    ("where", "words"),
    [
        (LineString([(5, 0), (5, 1)]), r"the Support at the line from \(5, 0\) to \(5, 1\) touches"),
        (
            LineString([(5, 0), (5, 1), (6, 1), (7, 7)]),
            r"from \(5, 0\) to \(7, 7\) by way of 2 more points touches",
        ),
        (
            MultiLineString([[(5, 0), (5, 1)], [(6, 0), (6, 1)]]),
            r"from \(5, 0\) to \(5, 1\) and 1 more touches",
        ),
        (Point(5, 5), r"the Support at \(5, 5\) touches"),
        (Polygon([(5, 5), (7, 5), (6, 8)]), r"the Support at the area between \(5, 5\) and \(7, 8\) touches"),
    ],
)
def test_places_are_reported_in_numbers_of_the_plane(where: Where, words: str) -> None:
    with pytest.raises(DesignError, match=words) as caught:
        plate.Problem(SQUARE, isotropic(), supports=[plate.Support(where, ("w",))])
    assert "Support support" not in str(caught.value)


def test_true_is_no_number() -> None:
    with pytest.raises(DesignError, match="E1 of a material is True; it must be a number"):
        plate.Material(E1=True, E2=1.0, nu12=0.3, G12=1.0, density=1.0)
    with pytest.raises(DesignError, match="the width is True"):
        checked_number(True, "the width")


def test_the_note_on_shear_has_no_unit() -> None:
    # Numbers in mm and N give MPa and no trouble, as long as no sentence takes them for metres.
    steel = plate.Material.isotropic(E=210e3, nu=0.3, density=7.8e-9)
    thick = plate.Laminate([plate.Ply(steel, 150.0)])
    problem = plate.Problem(
        plate.grid(2000.0, 2000.0, 2, 2),
        thick,
        supports=[plate.Clamped("boundary")],
        loads=[plate.Pressure(1.0)],
    )
    (note,) = plate.solve(problem).report.notes
    assert "shear through the thickness" in note
    assert "mm" not in note
