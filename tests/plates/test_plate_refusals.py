"""What a plate problem refuses, and what it warns of: each message names the offender, the value and the way out."""

import re
from typing import Any

import numpy as np
import pytest
from shapely.geometry import LineString, Point, Polygon

from lamc import plate
from lamc.basics.errors import DesignError, UnsupportedError
from tests.support.plates import case, cross_ply, isotropic, jittered, turned

BOUNDARY = "boundary"
SQUARE = plate.grid(1.0, 1.0, 4, 4)
LEFT, RIGHT = LineString([(0, 0), (0, 1)]), LineString([(1, 0), (1, 1)])
FAR = LineString([(5, 0), (5, 1)])


def problem(**given: Any) -> plate.Problem:
    """A clamped square with what is `given` instead."""
    start: dict[str, Any] = {"mesh": SQUARE, "laminate": isotropic(), "supports": [plate.Clamped(BOUNDARY)]}
    return plate.Problem(**{**start, **given})


REFUSED = [
    ({"mesh": "grid"}, "the mesh of a Problem is 'grid'; make one by plate.grid or plate.mesh"),
    ({"laminate": 3.0}, "the laminate of a Problem is 3.0; it must be a Laminate, or one by region"),
    ({"laminate": {"wing": isotropic()}}, "for region 'wing', which the mesh does not have; it has ''"),
    ({"laminate": {}}, "region '' of the mesh has no laminate; give one"),
    ({"laminate": {"": 1.0}}, "the laminate of region '' is 1.0; it must be a Laminate"),
    ({"element": "dkq"}, "there is no element 'dkq'; did you mean 'dkt'?"),
    ({"element": 7}, "the element is 7; it must be an Element, or the name of one"),
    ({"element": "bfs"}, "element 'bfs' is for quadrilaterals, and the mesh has triangles"),
    ({"supports": plate.Clamped(BOUNDARY)}, "supports of a Problem are a single Clamped; put it into a list"),
    ({"supports": [BOUNDARY]}, "supports of a Problem hold 'boundary'; each must be one of Support, Clamped"),
    (
        {"supports": [plate.Clamped(FAR)]},
        r"the Clamped support at the line from \(5, 0\) to \(5, 1\) touches no node .* 4 m away",
    ),
    (
        {"supports": [plate.Support(Point(0.1, 0), ("w",))]},
        "touches no node of the mesh; the nearest is 0.1 m away",
    ),
    (
        {"supports": [plate.Support(LEFT, ("w_xy",))]},
        r"'w_xy', which element 'dkt' does not have \(it has w, w_x, w_y\)",
    ),
    (
        {"supports": [plate.Symmetry(Point(0, 0))]},
        "the Symmetry support at .* lies along no edge of the mesh",
    ),
    (
        {"supports": [plate.Support(Point(0.125, 0), ("w",))], "element": "dkt+lst"},
        r"a Support holds 'w' at \(0.125, 0\), and none of the 1 nodes there has it: .* at corners of cells only",
    ),
    (
        {"supports": [plate.Hinged(Point(0, 0), 1.0)]},
        "the Hinged support at .* lies along no edge of the mesh",
    ),
    (
        {"loads": [plate.Pressure(1.0, region="wing")]},
        "acts on region 'wing', which the mesh does not have; it has ''",
    ),
    (
        {"loads": [plate.EdgeLoad(FAR, 1.0)]},
        "the EdgeLoad at the line from .* lies along no edge of the mesh",
    ),
    ({"loads": ["wind"]}, "loads of a Problem hold 'wind'; each must be one of PointLoad"),
    (
        {"loads": [plate.Pressure(1.0)], "element": "cst"},
        "a Pressure acts across the plate, and element 'cst' has no",
    ),
    ({"cases": [plate.Pressure(1.0)]}, "cases of a Problem are .* they must be loads by name"),
    ({"cases": {"": []}}, "a case of a Problem has the name ''"),
    ({"tolerance": -1.0}, "the tolerance of a Problem is -1.0; it must be finite and at least 0"),
    (
        {"loads": [plate.ElectricField((1.0, 2.0))]},
        "an ElectricField has 2 fields, and the laminate of region '' has 1",
    ),
]


@pytest.mark.parametrize(("given", "words"), REFUSED)
def test_a_problem_that_does_not_fit_together_is_refused(given: dict[str, Any], words: str) -> None:
    with pytest.raises(DesignError, match=words):
        problem(**given)


RECORDS = [
    (
        lambda: plate.Clamped("edge"),
        "a Clamped support is at 'edge'; it must be 'boundary' or a shapely geometry",
    ),
    (lambda: plate.Clamped(Polygon()), "is at an empty geometry"),
    (lambda: plate.Clamped(Polygon([(0, 0), (1, 1), (1, 0), (0, 1)])), "a geometry that is not valid"),
    (
        lambda: plate.SimplySupported(LEFT, "firm"),
        "the kind of a SimplySupported edge is 'firm'; it must be 'hard'",
    ),
    (lambda: plate.Support(LEFT, "w"), r"dofs of a Support are 'w'; put names into a tuple: \('w',\)"),
    (lambda: plate.Support(LEFT, ()), "dofs of a Support are empty"),
    (lambda: plate.Support(LEFT, ("thx",)), "a Support holds 'thx'; it can hold u, v, w, w_x, w_y, w_xy"),
    (lambda: plate.Support(LEFT, ("w",), np.nan), "the value of a Support is nan; it must be finite"),
    (
        lambda: plate.Hinged(LEFT, -1.0),
        "the stiffness of a Hinged support is -1.0; it must be finite and at least 0",
    ),
    (lambda: plate.PointLoad((0, 0, 0), 1.0), r"the place of a PointLoad has shape \(3,\)"),
    (lambda: plate.PointLoad((0, 0), (1.0, 2.0)), r"the force of a PointLoad has shape \(2,\)"),
    (
        lambda: plate.PointLoad((0, 0), "1 N"),
        "the force of a PointLoad along z is '1 N'; it must be a number",
    ),
    (lambda: plate.EdgeMoment(LEFT, np.inf), "the moment of an EdgeMoment is inf"),
    (lambda: plate.Pressure("q"), "the intensity of a Pressure is 'q'; it must be a number"),
    (lambda: plate.SelfWeight(-9.81), "the acceleration of SelfWeight has shape"),
    (lambda: plate.Temperature(1.0, region=3), "the region of a Temperature has the name 3"),
]


@pytest.mark.parametrize(("make", "words"), RECORDS)
def test_a_record_that_makes_no_sense_is_refused(make: Any, words: str) -> None:
    with pytest.raises(DesignError, match=words):
        make()


SOLVED = [
    (plate.PointLoad((1.2, 0.5), 1.0), r"a PointLoad is at \(1.2, 0.5\), which is 0.2 m outside the plate"),
    (
        plate.EdgeMoment(LineString([(0.5, 0), (0.5, 1)]), 1.0),
        r"acts along an inner edge at \(0.5, 0.\d+\), where both",
    ),
    (
        plate.Pressure(lambda x, y: x[:2]),
        r"a function that gives an array of shape \(2,\) for x and y of shape \(25,\)",
    ),
    (
        plate.Pressure(lambda x, y: 1.0 / x),
        r"the intensity of a Pressure is a function that gives inf at \(0, 0\)",
    ),
    (plate.Pressure(lambda x, y: int(x)), "is a function that fails: TypeError"),
    (plate.Pressure(lambda x: x), "is a function that fails: TypeError"),
    (plate.Pressure(lambda x, y: x * 1j), "is a function that fails: TypeError: its values are complex"),
]


@pytest.mark.parametrize(("load", "words"), SOLVED)
@pytest.mark.filterwarnings("ignore:divide by zero")
def test_a_load_that_cannot_act_is_refused(load: Any, words: str) -> None:
    with pytest.raises(DesignError, match=words):
        plate.solve(problem(loads=[load]))


def test_a_constant_function_is_a_constant() -> None:
    one = plate.solve(problem(loads=[plate.Pressure(2.0)]))
    for function in (lambda x, y: 2.0, lambda x, y: 2.0 + 0.0 * x):
        other = plate.solve(problem(loads=[plate.Pressure(function)]))
        # Round-off of sums over points of quadrature, which a number does without.
        np.testing.assert_allclose(other.values, one.values, rtol=0.0, atol=1e-13 * np.abs(one.values).max())


def test_a_point_outside_is_named_with_its_distance() -> None:
    solution = plate.solve(problem(loads=[plate.Pressure(1.0)]))
    with pytest.raises(
        DesignError, match=r"at \(0.5, -0.25\), which is 0.25 m outside the plate, and 1 more points"
    ):
        solution.deflection([0.5, 0.5, 2.0], [0.5, -0.25, 2.0])
    # Nearer than the tolerance it is taken at the edge.
    assert float(solution.deflection(0.5, -1e-7)) == 0.0
    with pytest.raises(DesignError, match="x and y must be numbers, or arrays of one shape"):
        solution.deflection([0.1, 0.2], [0.1, 0.2, 0.3])
    with pytest.raises(
        DesignError, match="a node has no unknown 'u'; with element 'dkt' there are w, w_x, w_y"
    ):
        solution.at_nodes("u")


def test_what_a_membrane_does_not_have_is_refused() -> None:
    solution = plate.solve(problem(element="cst", loads=[plate.PointLoad((0.5, 0.5), (1.0, 0.0, 0.0))]))
    assert solution.displacement(0.5, 0.5)[2] == 0.0
    with pytest.raises(UnsupportedError, match="element 'cst' has no deflection: it only stretches"):
        solution.deflection(0.5, 0.5)
    with pytest.raises(UnsupportedError, match="element 'cst' has no moments"):
        solution.moments(0.5, 0.5)


def test_membranes_are_added_where_they_are_needed() -> None:
    def chosen(**given: Any) -> str:
        return problem(**given).dofs.element.name

    pulled = plate.EdgeLoad(RIGHT, (1.0, 0.0, 0.0))
    assert chosen(loads=[plate.Pressure(1.0), plate.SelfWeight()]) == "dkt"
    assert chosen(laminate=cross_ply((0.0, 90.0))) == "dkt+cst"
    assert chosen(laminate=cross_ply((0.0, 90.0, 90.0, 0.0))) == "dkt"
    assert chosen(loads=[pulled]) == chosen(cases={"pulled": [pulled]}) == "dkt+cst"
    assert chosen(loads=[plate.SelfWeight((1.0, 0.0, 0.0))], element="specht") == "specht+cst"
    assert chosen(loads=[plate.Temperature(1.0)]) == "dkt"  # no expansion
    assert chosen(loads=[plate.Temperature(1.0)], laminate=isotropic(alpha=1e-6)) == "dkt+cst"
    assert chosen(supports=[plate.Support(LEFT, ("u",))]) == "dkt+cst"
    assert chosen(supports=[plate.Support(LEFT, ("u",))], element="dkt+lst") == "dkt+lst"
    squares = plate.grid(1.0, 1.0, 2, 2, "squares")
    assert chosen(mesh=squares, element="bfs", loads=[pulled]) == "bfs+q4"


def test_a_model_that_only_bends_refuses_what_pulls() -> None:
    model = plate.FactoredPlate(problem())
    with pytest.raises(DesignError, match="acts in the plane, and element 'dkt' of the model only bends"):
        model.solve([plate.EdgeLoad(RIGHT, (1.0, 0.0, 0.0))])
    with pytest.raises(
        DesignError, match=r"call for element 'dkt\+cst', and the model has 'dkt'; make a new Problem"
    ):
        model.with_laminates(cross_ply((0.0, 90.0)))


def test_solvers_that_are_not_there_are_named() -> None:
    with pytest.raises(
        DesignError, match="the solver is 'umfpack'; it must be one of auto, cholmod, pardiso, superlu"
    ):
        plate.solve(problem(), "umfpack")


# --- rigid motion ---


def free(*supports: Any, mesh: plate.Mesh = SQUARE, **given: Any) -> str:
    """What the error says of a plate with these supports under pressure."""
    with pytest.raises(DesignError) as caught:
        plate.solve(problem(mesh=mesh, supports=supports, **{"loads": [plate.Pressure(2.0)], **given}))
    return str(caught.value)


@pytest.mark.slow
def test_a_free_plate_names_its_rigid_motions(shared: Any) -> None:
    message = free()
    assert "piece 1 of 1 at (0.5, 0.5) may turn about x, may turn about y, may rise;" in message
    assert message.count("may ") == case(shared, "free_plate")["expected"]
    assert "leave a force (0, 0, 2) N and a moment (0, 0, 0) N·m about its centre: add supports" in message
    coupled = free(laminate=cross_ply((0.0, 90.0)))
    assert coupled.count("may ") == 6
    assert "may turn in its plane, may slide along x, may slide along y" in coupled


@pytest.mark.parametrize(
    ("supports", "words"),
    [
        ([plate.Support(LEFT, ("w",))], "may turn about y (the line x = 0);"),
        (
            [plate.Support(Point(0, 0), ("w",))],
            "may turn about x (the line y = 0), may turn about y (the line x = 0);",
        ),
        (
            [plate.Support(Point(0, 0), ("w",)), plate.Support(Point(1, 1), ("w",))],
            "may turn about the line through (0.5, 0.5) along (0.707, 0.707);",
        ),
        ([plate.Symmetry(LEFT)], "may turn about x, may rise;"),
        ([plate.Support(Point(0, 0), ("w", "w_x"))], "may turn about x (the line y = 0);"),
    ],
)
def test_motions_that_supports_leave_are_named(supports: list[Any], words: str) -> None:
    assert words in free(*supports, loads=[plate.PointLoad((0.9, 0.2), 1.0)])


def test_three_supports_in_one_line_hold_no_plate() -> None:
    mesh = turned(SQUARE, 30.0)
    on_line = [plate.Support(Point(*mesh.points[k]), ("w",)) for k in (0, 2, 4)]
    assert "may turn about the line through" in free(*on_line, mesh=mesh)


def pair(gap: float) -> plate.Mesh:
    """Two squares beside each other, and a third one further on."""
    parts = [plate.grid(1.0, 1.0, 2, 2, origin=(k * (1.0 + gap), 0.0)) for k in range(3)]
    points = np.concatenate([part.points for part in parts])
    cells = np.concatenate([part.cells + 9 * k for k, part in enumerate(parts)])
    return plate.Mesh(points, cells)


@pytest.mark.parametrize("gap", [0.5, 0.0])
def test_pieces_that_do_not_hang_together_are_named(gap: float) -> None:
    # With no gap their edges coincide, but no node is common: the plate is cut there.
    held = plate.Clamped(LEFT)
    message = free(held, mesh=pair(gap))
    assert f"piece 2 of 3 at ({1.5 + gap:g}, 0.5) may turn about x" in message
    assert f"piece 3 of 3 at ({2.5 + 2 * gap:g}, 0.5) may turn about x" in message
    assert "piece 1 of 3" not in message


def test_a_free_piece_beside_a_held_one_may_be_loaded_in_balance() -> None:
    mesh = pair(0.5)
    lift = [plate.PointLoad((1.75, 0.5), 2.0), *(plate.PointLoad((x, 0.5), -1.0) for x in (1.5, 2.0))]
    solution = plate.solve(
        problem(mesh=mesh, supports=[plate.Clamped(LEFT)], loads=[plate.EdgeLoad(LEFT, 1.0), *lift])
    )
    assert "piece 2 of 3 at (2, 0.5) may turn about x" in solution.report.free
    w = solution.at_nodes("w")
    assert np.abs(w[9:18].mean()) < 1e-12 * np.abs(w[9:18]).max()  # no rigid motion: it neither rises
    middle = mesh.points[9:18] - mesh.points[9:18].mean(axis=0)
    assert np.abs(w[9:18] @ middle).max() < 1e-12 * np.abs(w[9:18]).max()  # nor turns
    assert not w[18:].any()


def test_a_nearly_balanced_load_is_not_balanced() -> None:
    loads = [
        plate.PointLoad((0.2, 0.5), 1.0),
        plate.PointLoad((0.8, 0.5), 1.0),
        plate.PointLoad((0.5, 0.5), -2.000001),
    ]
    assert "leave a force (0, 0, -1e-06) N" in free(loads=loads)
    balanced = [*loads[:2], plate.PointLoad((0.5, 0.5), -2.0)]
    solution = plate.solve(problem(supports=[], loads=balanced))
    assert float(solution.deflection(0.2, 0.5)) > float(solution.deflection(0.5, 0.5))


def test_stretching_without_supports_in_the_plane_is_accepted() -> None:
    # Pulled at both ends with N_x = 2 N/m: ε_x = N_x / (E h), ε_y = -ν ε_x, whatever the plate's place.
    laminate = isotropic(nu=0.25)
    E, h = 12.0 * (1 - 0.25**2) / 1e-9, 1e-3
    pulls = [plate.EdgeLoad(LEFT, (-2.0, 0.0, 0.0)), plate.EdgeLoad(RIGHT, (2.0, 0.0, 0.0))]
    solution = plate.solve(
        plate.Problem(jittered(SQUARE), laminate, supports=[plate.SimplySupported(BOUNDARY)], loads=pulls)
    )
    exact = 2.0 / (E * h) * np.array([1.0, -0.25, 0.0])
    assert solution.strain(0.4, 0.3) == pytest.approx(exact, rel=1e-10, abs=1e-14 * exact[0])
    assert solution.forces(0.4, 0.3) == pytest.approx([2.0, 0.0, 0.0], abs=1e-9)


def test_parts_that_meet_in_a_point_are_refused() -> None:
    # They were solved as if clamped to each other there, over a width of nothing.
    points = np.array([[0, 0], [1, 0], [1, 1], [0, 1], [2, 1], [2, 2], [1, 2.0]])
    mesh = plate.Mesh(points, np.array([[0, 1, 2], [0, 2, 3], [2, 4, 5], [2, 5, 6]]))
    with pytest.raises(DesignError, match=r"touch at the single point \(1, 1\) m.*a node of its own"):
        problem(mesh=mesh, supports=[plate.Clamped(LEFT)])
    apart = plate.Mesh(
        np.concatenate([points, [[1, 1.0]]]), np.array([[0, 1, 2], [0, 2, 3], [7, 4, 5], [7, 5, 6]])
    )
    problem(mesh=apart, supports=[plate.Clamped(LEFT)])


# --- warnings ---


def notes(**given: Any) -> str:
    return " | ".join(plate.solve(problem(**{"loads": [plate.Pressure(1.0)], **given})).report.notes)


@pytest.mark.quick("union-jack")
@pytest.mark.parametrize("pattern", ["criss-cross", "union-jack"])
def test_bciz_off_its_meshes_is_warned_of(pattern: str) -> None:
    mesh = plate.grid(1.0, 1.0, 4, 4, pattern)
    assert f"about 3.2 % too flexible on this {pattern} mesh" in notes(mesh=mesh, element="bciz")
    assert notes(mesh=mesh) == ""


def test_bciz_on_its_own_meshes_is_not_warned_of() -> None:
    assert notes(element="bciz") == ""
    assert notes(element="bciz", mesh=turned(SQUARE, 20.0)) == ""  # the geometry counts, not the name
    assert "1.6 to 2.4 % where they are not" in notes(element="bciz", mesh=jittered(SQUARE))
    uneven = plate.grid_of_lines(np.array([0.0, 0.1, 0.5, 1.0]), np.linspace(0.0, 1.0, 4))
    assert "lines have three directions" in notes(element="bciz", mesh=uneven)


def test_bciz_is_as_far_off_as_the_warning_says(shared: Any) -> None:
    known = dict(
        zip(
            ("one-diagonal", "criss-cross", "union-jack"),
            case(shared, "bciz_limit")["expected"],
            strict=False,
        )
    )
    exact = case(shared, "cccc_unif")["expected"]
    for pattern, bias in known.items():
        values = []
        for n in (16, 32):
            mesh = plate.grid(1.0, 1.0, n, n, pattern)
            solution = plate.solve(problem(mesh=mesh, element="bciz", loads=[plate.Pressure(1.0)]))
            values.append(float(solution.deflection(0.5, 0.5)))
        limit = (4.0 * values[1] - values[0]) / 3.0 / exact - 1.0
        assert limit == pytest.approx(bias, rel=0.1, abs=1e-3)  # the table's own tolerance


@pytest.mark.slow
def test_slivers_with_specht_are_warned_of() -> None:
    thin = plate.grid(1.0, 1.0, 2, 200)
    assert "element 'specht' on cells up to 100 times as long as high" in notes(mesh=thin, element="specht")
    assert notes(mesh=plate.grid(1.0, 1.0, 2, 40)) == ""


@pytest.mark.parametrize("aspect", [100, 400])
@pytest.mark.quick("100", others="campaign")
def test_what_slivers_cost_is_as_the_warnings_say(shared: Any, aspect: int) -> None:
    exact = case(shared, "ssss_unif")["expected"]

    def share(element: str, rows: int) -> tuple[float, str]:
        mesh = plate.grid(1.0, 1.0, 4, rows)
        held = [plate.SimplySupported("boundary")]
        solved = plate.solve(problem(mesh=mesh, element=element, supports=held, loads=[plate.Pressure(1.0)]))
        return float(solved.deflection(0.5, 0.5)) / exact, " | ".join(solved.report.notes)

    bciz, said = share("bciz", 4 * aspect)
    found = re.search(r"'bciz' on cells up to (\d+) times .* gives (0\.\d+) of the deflection", said)
    assert found is not None
    assert int(found[1]) == aspect
    assert bciz == pytest.approx(float(found[2]), abs=0.02)  # two digits, between entries of a table
    dkt, said = share("dkt", 4 * aspect)
    assert "4 % off with four along each side" in said
    assert dkt == pytest.approx(1.04, abs=0.005)  # the note's digits
    assert share("dkt", 4)[0] == pytest.approx(dkt, abs=0.01)  # squares do no better


@pytest.mark.quick("0.0008-4", "bottom-8", "0.0008-8")
@pytest.mark.parametrize("cells", [4, 8])
@pytest.mark.parametrize("reference", ["bottom", 0.8e-3])
def test_a_reference_off_the_middle_costs_what_the_warning_says(cells: int, reference: str | float) -> None:
    # With u and v free along w = 0, the reference surface makes no difference to the plate itself.
    sheet = plate.Material(E1=70e9, E2=70e9, nu12=0.3, G12=70e9 / 2.6, density=2700.0)
    held = [
        plate.SimplySupported("boundary"),
        plate.Support(Point(0, 0), ("u", "v")),
        plate.Support(Point(1, 0), ("v",)),
    ]

    def middle_of(surface: str | float, element: str) -> tuple[float, str]:
        made = plate.Laminate([plate.Ply(sheet, 1e-3)], surface)
        mesh = plate.grid(1.0, 1.0, cells, cells)
        given = {"mesh": mesh, "laminate": made, "element": element, "supports": held}
        solved = plate.solve(problem(loads=[plate.Pressure(1.0)], **given))
        return float(solved.deflection(0.5, 0.5)), " | ".join(solved.report.notes)

    right, silent = middle_of("middle", "dkt")
    low, said = middle_of(reference, "dkt+cst")
    quadratic, silent_too = middle_of(reference, "dkt+lst")
    assert silent == silent_too == ""
    assert quadratic == pytest.approx(right, rel=1e-9)  # round-off at a condition of 1e7
    found = re.search(r"too stiff, by some ([\d.]+) % of the deflection.* take 'dkt\+lst'", said)
    assert found is not None
    assert 1.0 - low / right == pytest.approx(
        0.01 * float(found[1]), rel=0.45
    )  # one term in s h², s = 3 and 7.7


def test_weak_coupling_and_fine_meshes_go_without_a_warning() -> None:
    sheet = plate.Material(E1=70e9, E2=70e9, nu12=0.3, G12=70e9 / 2.6, density=2700.0)
    for height, cells in ((0.05e-3, 4), (0.5e-3, 20)):
        made = plate.Laminate([plate.Ply(sheet, 1e-3)], height)
        assert notes(mesh=plate.grid(1.0, 1.0, cells, cells), laminate=made) == ""


def test_thick_plates_are_warned_of() -> None:
    assert "shear through the thickness" in notes(laminate=isotropic(h=0.1))
    assert notes(laminate=isotropic(h=0.01)) == ""


def test_a_tolerance_can_reach_a_curve_that_the_mesh_does_not_follow() -> None:
    drawn, arc = (Point(0.5, 0.5).buffer(0.5, quad_segs=n) for n in (8, 64))
    mesh = plate.mesh(drawn, 0.2)
    with pytest.raises(DesignError, match="not followed by the mesh"):
        problem(mesh=mesh, supports=[plate.Clamped(arc.boundary)])
    sagitta = 0.5 * (1.0 - np.cos(np.pi / 32))
    held = problem(mesh=mesh, supports=[plate.Clamped(arc.boundary)], tolerance=1.01 * sagitta)
    assert len(held.places.edges_on(arc.boundary)) == 32
