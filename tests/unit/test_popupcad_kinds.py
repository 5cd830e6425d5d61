"""popupCAD's operations in the forms of its years, each against geometry computed by hand (areas in mm²)."""

import pytest

from lamc.basics.errors import DesignError, UnsupportedError
from tests.unit.test_popupcad import OPERATION, POLY, areas, cad, read, sketch, sketch_operation

BOTH = sketch_operation(5, 101, "[11]") + sketch_operation(6, 103, "[12]")  # 40 by 10 in 11, 5 by 10 in 12
JOINED = (
    f"- {OPERATION}.laminateoperation2.LaminateOperation2 "
    "{customname: j, id: 8, function: union, operation_links: {unary: [[5, 0], [6, 0]], binary: []}}\n"
)


def operation(kind: str, more: str) -> str:
    return f"- {OPERATION}.x.{kind} {{customname: '', id: 7, {more}}}\n"


def found(text: str, sketches: str = "") -> list[float]:
    return areas(read(cad(text, parent=7, sketches=sketches)))


NEW = "operation_links: {parent: [[8, 0]]}"
OLD = "operation_link1: 8, outputref: 0"


@pytest.mark.parametrize(("kind", "links"), [("LayerOp2", NEW), ("LayerOp", OLD)])
@pytest.mark.parametrize(
    ("function", "unary", "pair", "goal", "expected"),
    [
        ("union", [11, 12], [], [11], [400, 0]),
        ("intersection", [11, 12], [], [11, 12], [50, 50]),
        ("intersection", [11], [], [12], [0, 400]),
        ("difference", [11], [12], [12], [0, 350]),
        ("difference", [12], [11], [12], [0, 0]),
        ("symmetric_difference", [12], [11], [11, 12], [350, 350]),
    ],
)
def test_layers_of_one_laminate_are_combined(
    kind: str,
    links: str,
    function: str,
    unary: list[int],
    pair: list[int],
    goal: list[int],
    expected: list[int],
) -> None:
    more = f"function: {function}, unary_layer_links: {unary}, pair_layer_links: {pair}, output_layer_links: {goal}"
    # round-off of millimetres
    assert found(BOTH + JOINED + operation(kind, f"{links}, {more}")) == pytest.approx(expected, rel=1e-12)


def test_a_layer_operation_of_nothing_is_refused() -> None:
    more = "function: union, unary_layer_links: [], pair_layer_links: [], output_layer_links: [11]"
    with pytest.raises(DesignError, match="has no layer in 'unary_layer_links'"):
        found(BOTH + JOINED + operation("LayerOp2", f"{NEW}, {more}"))
    with pytest.raises(UnsupportedError, match="the layer function 'xor' is unknown"):
        found(BOTH + JOINED + operation("LayerOp2", f"{NEW}, {more.replace('union', 'xor')}"))


@pytest.mark.parametrize(("kind", "links"), [("ShiftFlip2", OLD), ("ShiftFlip3", NEW), ("ShiftFlip4", NEW)])
def test_layers_are_shifted_and_flipped_in_every_form(kind: str, links: str) -> None:
    for shift, flip, rotate, expected in (
        (1, "false", "false", [0, 400]),
        (-1, "false", "false", [50, 0]),
        (0, "true", "false", [50, 400]),
        (1, "false", "true", [50, 400]),
        (1, "true", "true", [400, 50]),
    ):
        more = f"{links}, shift: {shift}, flip: {flip}, rotate: {rotate}"
        assert found(BOTH + JOINED + operation(kind, more)) == pytest.approx(expected, rel=1e-12)


@pytest.mark.parametrize(
    ("function", "first", "second", "expected"),
    [
        ("union", "[[5, 0], [6, 0]]", "[]", [400, 50]),
        ("intersection", "[[8, 0], [5, 0]]", "[]", [400, 0]),
        ("difference", "[[1, 0]]", "[[6, 0]]", [400, 350]),
        ("symmetric_difference", "[[8, 0]]", "[[1, 0]]", [0, 350]),
    ],
)
def test_laminates_are_combined_in_the_first_form(
    function: str, first: str, second: str, expected: list[int]
) -> None:
    more = f"function: {function}, operation_links1: {first}, operation_links2: {second}"
    text = BOTH + JOINED + operation("LaminateOperation", more)
    assert found(text) == pytest.approx(expected, rel=1e-12, abs=1e-9)  # abs: of the plate's own corners


def test_a_buffer_in_its_older_form() -> None:
    # 40 by 10 grown by 1: 42 by 12 without its corners, of which a quarter circle of one segment leaves a half
    assert found(operation("BufferOperation2", "operation_link1: 1, outputref: 0, values: [1.0, 1]")) == (
        pytest.approx([502, 502], rel=1e-12)
    )
    with pytest.raises(UnsupportedError, match="output 1"):
        found(operation("BufferOperation2", "operation_link1: 1, outputref: 1, values: [1.0, 1]"))
    with pytest.raises(DesignError, match="'77', which is missing"):
        found(operation("BufferOperation2", "operation_link1: 77, outputref: 0, values: [1.0, 1]"))


@pytest.mark.parametrize(
    ("kind", "links"),
    [("Cleanup2", "operation_links: {parent: [[5, 0]]}"), ("Cleanup", "operation_link1: 5, outputref: 0")],
)
def test_a_cleanup_takes_slivers_away_and_closes_slits(kind: str, links: str) -> None:
    """A plate of 40 by 10, a sliver of 1 by 30 beside it, and a slit of 1 by 3 in the plate, far from its edges.

    Shrunk by 1 the sliver is gone; grown by 2 with quarter circles of one segment the corners are cut along the line at
    2 from both sides; shrunk by 1 the cut lies at √2 along the sides: each corner lacks a triangle of 1 mm². The slit
    is 3 wide after shrinking, and less than nothing after growing by 2 from both sides.
    """
    plate = (
        f"{POLY} {{construction: false, id: 21, exterior: [[1, 0, 0], [2, 40, 0], [3, 40, 10], [4, 0, 10]], "
        "interiors: [[[5, 20, 3.5], [6, 21, 3.5], [7, 21, 6.5], [8, 20, 6.5]]]}"
    )
    sliver = f"{POLY} {{construction: false, id: 22, exterior: [[1, 60, 0], [2, 61, 0], [3, 61, 30], [4, 60, 30]]}}"
    drawn = sketch(201, plate, sliver)
    assert found(
        sketch_operation(5, 201) + operation(kind, f"{links}, values: [1.0, 1.0]"), drawn
    ) == pytest.approx([396, 396], rel=1e-9)  # buffers place corners to a few 1e-16 m


@pytest.mark.parametrize(
    ("kind", "links"),
    [("Simplify2", "operation_links: {parent: [[5, 0]]}"), ("Simplify", "operation_link1: 5, outputref: 0")],
)
def test_a_simplification_leaves_out_corners_within_its_tolerance(kind: str, links: str) -> None:
    corners = "[[1, 0, 0], [2, 20, 0.005], [3, 40, 0], [4, 40, 10], [5, 0, 10]]"
    bent = f"{POLY} {{construction: false, id: 21, exterior: {corners}}}"
    for tolerance, expected in ((0.01, 400.0), (0.001, 399.9)):
        text = sketch_operation(5, 201) + operation(kind, f"{links}, values: [{tolerance}]")
        assert found(text, sketch(201, bent)) == pytest.approx([expected, expected], rel=1e-12)


def frozen(wrapped: bool) -> str:
    """A frozen laminate, as the newest popupCAD or an older one writes it: keyed by layers, in any order."""
    layer = "!!python/object:popupcad.filetypes.material2.Material2 {id: %d, name: sheet}"
    corners = "[[1, 0, 0], [2, %d, 0], [3, %d, 9], [4, 0, 9]]"
    square = f"{POLY} {{construction: false, id: 31, interiors: [], exterior: {corners}}}"
    keyed = (
        f"      ? {layer % 12}\n      : - {square % (3, 3)}\n        - {square % (5, 5)}\n"
        f"      ? {layer % 11}\n      : []\n      ? {layer % 13}\n      : - {square % (8, 8)}\n"
    )
    start = f"- {OPERATION}.freeze.Freeze\n  customname: f\n  id: 7\n  operation_link1: 999\n  outputref: 0\n"
    if wrapped:
        tag = "!!python/object:popupcad.filetypes.genericlaminate.GenericLaminate"
        return f"{start}  generic: {tag}\n    geoms:\n{keyed}"
    return f"{start}  generic:\n{keyed}"


@pytest.mark.parametrize("wrapped", [True, False])
def test_a_frozen_laminate_is_what_the_file_keeps(wrapped: bool) -> None:
    """Squares of 3 and 5 by 9 that overlap are 45 mm²; what it was frozen of is gone, and a layer that the design has
    no more is left out."""
    assert found(frozen(wrapped)) == pytest.approx([0, 45], rel=1e-12)
    with pytest.raises(DesignError, match="not a map from layers to shapes"):
        found(f"- {OPERATION}.freeze.Freeze {{customname: f, id: 7, generic: []}}\n")
    with pytest.raises(DesignError, match="no 'generic'"):
        found(f"- {OPERATION}.freeze.Freeze {{customname: f, id: 7}}\n")


@pytest.mark.parametrize("kind", ["SubOperation2", "Cleanup3", "CutOperation2", "PlaceOperation7"])
def test_other_operations_are_refused_by_name(kind: str) -> None:
    with pytest.raises(UnsupportedError, match=f"an operation of kind '{kind}'"):
        found(operation(kind, "operation_links: {}"))
