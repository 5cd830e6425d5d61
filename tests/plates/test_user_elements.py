"""Elements that a user writes from shape functions; refusals of those that cannot work."""

from fractions import Fraction

import numpy as np
import pytest
import sympy as sp

from lamc import plate
from lamc.basics.errors import DesignError
from lamc.plates.dofs import Dofs
from lamc.plates.elements import derive, eta, side, x1, xi
from lamc.plates.elements.definition import CORNERS
from lamc.plates.meshing.mesh import Mesh
from tests.support.staged_elements import (
    StagedElement,
    cells,
    relative,
    sections,
    staged,
)


def square_functions() -> list[sp.Expr]:
    return [(1 + a * xi) * (1 + b * eta) / 4 for a, b in CORNERS["square"]]


def test_element_of_a_user_is_the_one_of_the_library() -> None:
    N = square_functions()
    mine = plate.Element("mine", "square", plate.corners("square", ("u", "v")), u=N, v=N)
    found = StagedElement(mine).stiffness(cells("q4"), sections("q4"))
    np.testing.assert_array_equal(found, staged("q4").stiffness(cells("q4"), sections("q4")))


def test_symbols_are_known_by_name() -> None:
    """Whoever makes his own xi and eta, without saying that they are real, gets the same element."""
    a, b = sp.symbols("xi eta")
    N = [f.subs({xi: a, eta: b}) for f in square_functions()]
    mine = plate.Element("mine", "square", plate.corners("square", ("u", "v")), u=N, v=N)
    assert mine.u[::2] == tuple(square_functions())


def adini_clough_melosh() -> plate.Element:
    """The rectangle of 12 unknowns, w complete to cubics, from its nodal conditions.

    A. Adini, R. W. Clough, NSF report G7337, 1961; R. J. Melosh, J. Aerospace Sci. 28, 1961.
    """
    powers = [(0, 0), (1, 0), (0, 1), (2, 0), (1, 1), (0, 2), (3, 0), (2, 1), (1, 2), (0, 3), (3, 1), (1, 3)]
    monomials = sp.Matrix([xi**i * eta**j for i, j in powers])
    rows = [
        [f.subs({xi: a, eta: b}) for f in g]
        for a, b in CORNERS["square"]
        for g in (monomials, monomials.diff(xi), monomials.diff(eta))
    ]
    N = sp.Matrix(rows).T.inv() * monomials
    scale = [1, side("x", 2, 1) / 2, side("y", 4, 1) / 2]
    w = [scale[k % 3] * N[k] for k in range(12)]
    return plate.Element("acm", "square", plate.corners("square", ("w", "w_x", "w_y")), w=w)


def test_element_of_a_user_that_bends_has_the_stiffness_in_print() -> None:
    """O. C. Zienkiewicz, Y. K. Cheung, Proc. Inst. Civ. Eng. 28, 1964: the first entry, with p = a / b, is
    (4 (p² + 1/p²) + (14 - 4 ν) / 5) D / (a b)."""
    a, b, nu = 1.4, 0.9, 0.3
    corners = np.array([[[0.0, 0.0], [a, 0.0], [a, b], [0.0, b]]])
    section = np.array([[1.0, nu, 0.0, 1.0, 0.0, 0.5 * (1.0 - nu)]])
    own = StagedElement(adini_clough_melosh())
    expected = (4.0 * (a * a / b / b + b * b / a / a) + (14.0 - 4.0 * nu) / 5.0) / (a * b)
    assert own.stiffness(corners, section)[0, 0, 0] == pytest.approx(expected, rel=1e-14)
    # It stretches when told so.
    both = plate.combine(own.element, plate.element("q4"))
    assert both.name == "acm+q4"
    assert len(both.dofs) == 20


def test_library_is_told_apart_by_raw_coordinates_as_by_sides() -> None:
    """x2 - x1 and x21 are the same; so is what comes of them, up to round-off."""
    bciz = plate.element("bciz")
    raw = {
        side(axis, i, j): sp.Symbol(f"{axis}{i}", real=True) - sp.Symbol(f"{axis}{j}", real=True)
        for axis in "xy"
        for i in (1, 2, 3)
        for j in (1, 2, 3)
        if i != j
    }
    mine = plate.Element("mine", "triangle", bciz.nodes, w=[f.xreplace(raw) for f in bciz.w])
    found = StagedElement(mine).stiffness(cells("bciz"), sections("bciz"))
    assert relative(found, staged("bciz").stiffness(cells("bciz"), sections("bciz"))) < 1e-14


def bad_elements() -> dict[str, tuple[dict[str, object], str]]:
    N = square_functions()
    bubble = (1 - xi**2) * (1 - eta**2)
    inner = [N[0] + xi * bubble, *N[1:]]
    linear = [1 - xi - eta, xi, eta]
    bending = {"cell": "triangle", "nodes": plate.corners("triangle", ("w", "w_x", "w_y"))}
    return {
        "text": ({"u": ["xi", "eta", "1", "1"]}, "'xi' in u"),
        "too few": ({"u": N[:3]}, "3 shape functions for u"),
        "v missing": ({"v": ()}, "shape functions for u"),
        "nothing": ({"u": (), "v": ()}, "shape functions for nothing"),
        "wrong order": ({"u": N[::-1]}, "the shape function of u1 in u gives u1 = 0"),
        "not rigid": ({"u": inner}, "is strained when it shifts along x"),
        "unknown symbol": ({"u": [sp.Symbol("k") * N[0], *N[1:]]}, "unknown symbol k"),
        "no polynomial": ({"u": [sp.sin(xi) * N[0], *N[1:]]}, "no polynomial in xi and eta"),
        "place": ({"u": [x1 * N[0], *N[1:]]}, "changes as the cell is moved"),
        "quotient": ({"u": [N[0] / side("x", 2, 1), *N[1:]]}, "give it a symbol in `geometry`"),
        "infinite": ({"u": [sp.oo * N[0], *N[1:]]}, "must be finite"),
        "degree": ({"degree": -1}, "degree -1"),
        "cell": ({"cell": "hexagon"}, "cell 'hexagon'"),
        "no nodes": ({"nodes": ["here"]}, "holds 'here'"),
        "no bending": ({"u": (), "v": (), **bending}, "shape functions for nothing"),
        "tilt": (
            {"u": (), "v": (), "w": [f for L in linear for f in (L, 0, 0)], **bending},
            "the shape function of w1 in w gives w_x1",
        ),
        "slopes": (
            {"u": (), "v": (), "w": plate.element("bciz").w, "slopes": ([xi], [eta]), **bending},
            "slopes of [1, 1] shape functions",
        ),
        "amounts": (
            {
                "u": (),
                "v": (),
                "w": plate.element("bciz").w,
                **bending,
                "slopes": ([xi], [eta]),
                "amounts": [sp.Symbol("w1", real=True) ** 2],
            },
            "must be linear in the unknowns",
        ),
        "geometry": (
            {"geometry": {sp.Symbol("r"): 1 / sp.Symbol("unknown")}},
            "has the geometry r = 1/unknown: the expression uses 'unknown'",
        ),
        "amounts alone": (
            {"amounts": [sp.Symbol("u1", real=True)]},
            "only slopes are written in amounts",
        ),
        "membrane with w": ({"nodes": plate.corners("square", ("u", "v", "w"))}, "has unknowns for w"),
    }


@pytest.mark.parametrize("case", bad_elements())
def test_element_that_cannot_work_is_refused_by_name(case: str) -> None:
    N = square_functions()
    changes, message = bad_elements()[case]
    good = {"name": "mine", "cell": "square", "nodes": plate.corners("square", ("u", "v")), "u": N, "v": N}
    with pytest.raises(DesignError) as caught:
        derive(plate.Element(**(good | changes)))
    assert message in str(caught.value)
    assert "\n" not in str(caught.value)


def test_element_that_cannot_be_twisted_says_so() -> None:
    """A bubble that the corners do not see, driven by their deflections up, down, up, down: rigid motions do not call
    for it, constant twist does."""
    acm = adini_clough_melosh()
    assert "does not converge" not in plate.describe(acm)
    bubble = xi * eta * (1 - xi**2) * (1 - eta**2)
    signs = [sign * rest for sign in (1, -1, 1, -1) for rest in (1, 0, 0)]
    w = [f + sign * bubble for f, sign in zip(acm.w, signs, strict=True)]
    text = plate.describe(plate.Element("bent", "square", acm.nodes, w=w))
    assert "κ_xy cannot be constant over a cell: the element does not converge" in text


def test_names_that_are_no_elements_are_refused() -> None:
    for name, message in {
        "dtk": "did you mean 'dkt'",
        "hexagon": "there are bciz",
        "dkt+q4": "triangles and 'q4' for squares",
        "dkt+bciz": "stretches only",
        "cst+lst": "bends only",
        "dkt+cst+cst": "3 parts",
        "": "there is no element ''",
    }.items():
        with pytest.raises(DesignError, match=message.replace("+", r"\+")):
            plate.element(name)
    assert plate.element("CST+DKT").name == "dkt+cst"


def test_nodes_are_where_they_are_said_to_be() -> None:
    assert [node.at for node in plate.edges("square", ("u", "v"), (Fraction(1, 3), Fraction(2, 3)))][:3] == [
        (Fraction(-1, 3), -1),
        (Fraction(1, 3), -1),
        (1, Fraction(-1, 3)),
    ]
    with pytest.raises(DesignError, match="in this order"):
        plate.Node((0, 0), ("w_x", "w"))


def test_description_names_what_matters() -> None:
    text = plate.describe(plate.element("dkt"))
    for part in (
        "Batoz",
        "9 unknowns",
        "Shape functions of w_x",
        "Strains -(∂w_x/∂x",
        "stiffness",
        "531",
        "exact",
    ):
        assert part in text
    assert "3 × 3 Gauss points" in plate.describe(plate.element("q8"))
    assert "{" not in text


def test_rectangles_that_bend_refuse_other_cells() -> None:
    points = np.array([[0.0, 0.0], [2.0, 0.0], [2.0, 1.0], [0.0, 1.0]])
    rotated = points @ np.array([[0.8, 0.6], [-0.6, 0.8]])
    sheared = points + 0.1 * points[:, ::-1] * [1.0, 0.0]
    for name in ("bfs", "bfs+q4"):
        Dofs(Mesh(points, [[0, 1, 2, 3]]), plate.element(name))
        for bad, cell in ((rotated, [0, 1, 2, 3]), (points, [1, 2, 3, 0]), (sheared, [0, 1, 2, 3])):
            with pytest.raises(DesignError, match="rectangles with sides along x and y"):
                Dofs(Mesh(bad, [cell]), plate.element(name))
    Dofs(Mesh(rotated, [[0, 1, 2, 3]]), plate.element("q4"))
