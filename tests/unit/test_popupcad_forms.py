"""What popupCAD files hold beside what the newest popupCAD writes: forms of their day, read as inert data."""

import base64
import re
import struct
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from lamc.basics.errors import DesignError, LamcError
from lamc.design.split import split, split_steps
from lamc.readers.inert import ListNode, MapNode, ScalarNode, compose
from lamc.readers.load import load
from lamc.readers.objects import number
from lamc.readers.popupcad import read_design
from lamc.readers.popupcad_sketch import vertex
from lamc.records.design import Design
from lamc.records.mechanism import Mechanism
from tests.support.quick import tries
from tests.unit.test_popupcad import areas, cad, read

SCALAR = "!!python/object/apply:numpy.core.multiarray.scalar"
DTYPE = "!!python/object/apply:numpy.dtype"


def numpy_text(
    value: float, letters: str = "f8", order: str = "<", form: str = "<d", core: str = "core"
) -> str:
    """One number as PyYAML dumps a numpy scalar, in flow style."""
    data = base64.b64encode(struct.pack(form, value)).decode()
    state = f"!!python/tuple [3, '{order}', null, null, null, -1, -1, 0]"
    tag = SCALAR.replace("core", core)
    return f"{tag} [{DTYPE} {{args: [{letters}, 0, 1], state: {state}}}, !!binary {data}]"


# ---- Aliases as keys -------------------------------------------------------------------------------------------------


def test_an_alias_as_a_key_needs_no_space_before_its_colon(shared: Path, tmp_path: Path) -> None:
    text = (shared / "designs" / "flaps_old.joints").read_text()
    file = tmp_path / "flaps_old.joints"
    file.write_text(re.sub(r"(\*\w+) :", r"\1:", text))
    assert file.read_text() != text
    old, new = (load(path) for path in (shared / "designs" / "flaps_old.joints", file))
    assert isinstance(old, Mechanism)
    assert isinstance(new, Mechanism)
    assert [(b.name, b.mass, b.com.tolist()) for b in old.bodies] == [
        (b.name, b.mass, b.com.tolist()) for b in new.bodies
    ]


@pytest.mark.parametrize(
    ("text", "keys"),
    [
        ("a: &id003 x\nb:\n  *id003: 0.65\n", ["x"]),
        ("a: &id003 x\nb: {*id003: 0.65}\n", ["x"]),
        ("a: &id003 x\nb:\n  *id003 : 0.65\n", ["x"]),
        ("a: &id003: x\nb:\n  *id003: : 0.65\n", ["x"]),  # YAML 1.2: the name has the colon
        ("a: &i x\nc: &i: y\nb:\n  *i: : 1\n", ["y"]),
        ("a: &i x\nc: &j y\nb:\n  *i: 1\n  *j:\n  - 2\n", ["x", "y"]),
    ],
)
def test_keys_that_are_aliases(text: str, keys: list[str]) -> None:
    node = compose(text)
    assert isinstance(node, MapNode)
    held = node.get("b")
    assert isinstance(held, MapNode)
    assert [k.text for k, _ in held.pairs if isinstance(k, ScalarNode)] == keys


def test_an_alias_of_no_anchor_is_an_error_still() -> None:
    with pytest.raises(DesignError):
        compose("a: &id003 x\nb:\n  *id004: 0.65\n")


# ---- Numbers ---------------------------------------------------------------------------------------------------------


@settings(max_examples=tries(60))
@given(st.floats(-1e9, 1e9))
def test_numpy_scalars_are_numbers_to_the_last_bit(value: float) -> None:
    for core in ("core", "_core"):
        node = compose(f"- {numpy_text(value, core=core)}")
        assert isinstance(node, ListNode)
        assert number(node.items[0], "x") == value
    big = compose(f"- {numpy_text(value, order='>', form='>d')}")
    assert isinstance(big, ListNode)
    assert number(big.items[0], "x") == value


def test_numpy_scalars_of_other_types_and_shared_types() -> None:
    text = (
        f"- {SCALAR}\n  - &t {DTYPE} {{args: [f8, 0, 1], state: !!python/tuple [3, <, null]}}\n"
        f"  - !!binary |\n    AAAAAAAA4D8=\n- {SCALAR} [*t, !!binary AAAAAAAA8D8=]\n"
        f"- {SCALAR} [{DTYPE} [i4, false, true], !!binary BwAAAA==]\n- {numpy_text(0.25, 'f4', '<', '<f')}\n"
    )
    node = compose(text)
    assert isinstance(node, ListNode)
    assert [number(item, "x") for item in node.items] == [0.5, 1.0, 7, 0.25]


@pytest.mark.parametrize(
    "text",
    [
        f"{SCALAR} [{DTYPE} [f8, 0, 1], !!binary AAAA]",  # too short
        f"{SCALAR} [{DTYPE} [f8, 0, 1], !!binary '****']",
        f"{SCALAR} [{DTYPE} [f8, 0, 1], AAAAAAAA8D8=]",  # no bytes
        f"{SCALAR} [{DTYPE} [O8, 0, 1], !!binary AAAAAAAA8D8=]",  # an object: pickled code
        f"{SCALAR} [{DTYPE} [f8, 0, 1]]",
        f"{SCALAR} [f8, !!binary AAAAAAAA8D8=]",
        f"{SCALAR} [{DTYPE} [f8, 0, 1], !!binary {'A' * 4000}]",
        f"{SCALAR} [{DTYPE} [f8, 0, 1], !!binary AAAAAAAA8H8=]",  # infinity
        f"{SCALAR} {{a: 1}}",
        "!!python/object/apply:os.system [echo, !!binary AAAAAAAA8D8=]",
    ],
)
def test_other_scalars_are_refused(text: str) -> None:
    node = compose(f"- {text}")
    assert isinstance(node, ListNode)
    with pytest.raises(DesignError):
        number(node.items[0], "the vertex's x")


# ---- Vertices --------------------------------------------------------------------------------------------------------

VERTEX = "!!python/object:popupcad.geometry.vertex.ShapeVertex"


@pytest.mark.parametrize(
    ("text", "scale"),
    [
        ("[7, 20.0, -5.0]", 1e-3),
        ("!ShapeVertex_1 [7, 20.0, -5.0]", 1e-3),
        ("!DrawnPoint_1 [7, 20.0, -5.0, false]", 1e-3),
        ("!ShapeVertex [7, 20.0, -5.0]", 1e-6),
        ("!DrawnPoint [7, 20.0, -5.0, false]", 1e-6),
        (f"{VERTEX} {{id: 7, _position: !!python/tuple [20.0, -5.0]}}", 1e-3),
        (f"{VERTEX} {{id: 7, _pos: !!python/tuple [20.0, -5.0], construction: true}}", 1e-6),
        (f"{VERTEX} {{id: 7, _pos: null, _Vertex__pos: !!python/tuple [20.0, -5.0]}}", 1e-6),
        (f"{VERTEX} {{id: 7, _BaseVertex__pos: [20.0, -5.0]}}", 1e-6),
    ],
)
def test_vertices_are_in_the_unit_of_their_class(text: str, scale: float) -> None:
    node = compose(f"- {text}")
    assert isinstance(node, ListNode)
    # one rounding in a product, one in a quotient
    np.testing.assert_allclose(vertex(node.items[0]), (20.0 * scale, -5.0 * scale), rtol=4e-16)


def test_a_design_of_old_vertices_is_the_design_of_new_ones() -> None:
    new = cad()
    old = re.sub(r"\[(\d), (\d+), (\d+)\]", r"!ShapeVertex [\1, \g<2>000, \g<3>000]", new)
    assert old != new
    assert areas(read(old)) == areas(read(new))
    assert split(read(old)).bodies[1].mass == split(read(new)).bodies[1].mass


# ---- Texts -----------------------------------------------------------------------------------------------------------

TEXT = "!!python/object:popupcad.graphics2d.text.GenericText"


@pytest.mark.parametrize(("words", "reported"), [("LAB", 1), ("''", 0), ("' '", 0)])
def test_a_text_is_left_out_and_told(words: str, reported: int) -> None:
    given_text = (
        f"{TEXT} {{exteriors: [], font: Courier New, fontsize: 16, id: 17, pos: [18, 1, 2], text: {words}}}"
    )
    design = read(cad().replace("{operationgeometry: [", f"{{operationgeometry: [{given_text}, ", 1))
    assert areas(design) == areas(read(cad()))
    assert len(design.notes) == reported
    assert all("LAB" in note and "given.cad:" in note for note in design.notes)
    assert split_steps(design).notes[:reported] == design.notes


# ---- Nothing but an error or a design --------------------------------------------------------------------------------

WORDS = st.sampled_from(
    [
        "[1, 2, 3]",
        "!ShapeVertex [1, 2, 3]",
        f"{VERTEX} {{_pos: [1, 2]}}",
        f"{TEXT} {{text: x}}",
        f"{TEXT} []",
        numpy_text(20.0),
        numpy_text(float("nan")),
        f"{SCALAR} []",
        "&a [1]",
        "*a",
        "null",
        "[]",
    ]
)


@settings(max_examples=tries(150), deadline=None)  # a first split costs more than others
@given(st.data())
def test_pieces_put_anywhere_give_a_design_or_an_error(data: st.DataObject) -> None:
    text = cad()
    places = [m.span() for m in re.finditer(r"\[\d+(, \d+)*\]|\b\d+\b", text)]
    start, end = data.draw(st.sampled_from(places))
    changed = text[:start] + data.draw(WORDS) + text[end:]
    try:
        design = read_design(compose(changed, "given.cad"), {})
    except LamcError:
        return
    assert isinstance(design, Design)


# ---- Laminates placed by lines ---------------------------------------------------------------------------------------

OPERATION = "!!python/object:popupcad.manufacturing"
HOW = "transformtype_x: scale, transformtype_y: scale, shift: 0, flip: false, scalex: 1.0, scaley: 1.0"


def line_sketch(number: int, *lines: str) -> str:
    tag = "!!python/object:popupcad.filetypes.genericshapes.GenericLine"
    drawn = ", ".join(f"{tag} {{construction: false, exterior: [{line}], id: 9}}" for line in lines)
    return f"  {number}: !!python/object:popupcad.filetypes.sketch.Sketch {{operationgeometry: [{drawn}]}}\n"


def transform(kind: str, more: str) -> str:
    return f"- {OPERATION}.x.{kind} {{customname: t, id: 7, {more}}}\n"


def internal(how: str = HOW) -> str:
    links = "operation_links: {from: [[1, 0]]}, sketch_links: {sketch_from: [201], sketch_to: [202]}"
    return transform("TransformInternal", f"{links}, {how}")


FROM, TO = line_sketch(201, "[1, 0, 0], [2, 10, 0]"), "[1, 5, 3], [2, 5, 23]"


def test_a_laminate_is_placed_by_a_line() -> None:
    """40 by 10 mm, scaled by two and turned by 90 degrees about where the line ends."""
    design = read(cad(internal(), parent=7, sketches=FROM + line_sketch(202, TO)))
    assert areas(design) == pytest.approx([1600.0, 1600.0], rel=1e-12)  # round-off of a turn
    # (x, y) -> (5 - 2 y, 3 + 2 x)
    assert design.layers[0].geometry.bounds == pytest.approx((-0.015, 0.003, 0.005, 0.083), abs=1e-15)
    own = HOW.replace("transformtype_y: scale", "transformtype_y: custom").replace(
        "scaley: 1.0", "scaley: -0.5"
    )
    mirrored = read(cad(internal(own), parent=7, sketches=FROM + line_sketch(202, TO)))
    assert mirrored.layers[0].geometry.bounds == pytest.approx((0.005, 0.003, 0.010, 0.083), abs=1e-15)


def test_layers_are_shifted_flipped_and_rotated() -> None:
    drawn = (
        f"- {OPERATION}.simplesketchoperation.SimpleSketchOp {{customname: o, id: 5, layer_links: [11], "
        "operation_links: {}, sketch_links: {sketch: [101]}}\n"
    )
    for shift, flip, rotate, expected in (
        (1, "false", "false", [0.0, 400.0]),
        (-1, "false", "false", [0.0, 0.0]),
        (0, "true", "false", [0.0, 400.0]),
        (1, "false", "true", [0.0, 400.0]),
        (1, "true", "true", [400.0, 0.0]),
    ):
        more = f"operation_links: {{parent: [[5, 0]]}}, shift: {shift}, flip: {flip}, rotate: {rotate}"
        found = areas(read(cad(drawn + transform("ShiftFlip3", more), parent=7)))
        assert found == pytest.approx(expected, rel=1e-12), (shift, flip, rotate)  # round-off of millimetres


def with_inner(kind: str, more: str) -> str:
    """A design that places operation 1 of a copy of itself, stored inside it."""
    inner = cad(
        f"- {OPERATION}.x.LocateOperation3 {{customname: l, id: 8, sketch_links: {{sketch: [201]}}}}\n",
        sketches=FROM,
    )
    indented = inner.replace("\n", "\n    ").rstrip()
    links = "design_links: {subdesign: [77]}, subopref: !!python/tuple [1, 0]"
    outer = cad(
        transform(kind, f"{links}, operation_links: {{}}, {more}, {HOW}"),
        parent=7,
        sketches=line_sketch(202, TO),
    )
    return f"{outer}subdesigns:\n  77: {indented}\n"


@pytest.mark.parametrize(
    ("kind", "more"),
    [
        ("TransformExternal", "sketch_links: {sketch_to: [202]}, sub_sketch_id: 201"),
        ("PlaceOperation8", "sketch_links: {place: [202]}"),
    ],
)
def test_a_laminate_of_a_design_inside_is_placed(kind: str, more: str) -> None:
    design = read(with_inner(kind, more))
    inside = read(cad(internal(), parent=7, sketches=FROM + line_sketch(202, TO)))
    assert areas(design) == areas(inside)
    with pytest.raises(DesignError, match="no design '78' is stored inside"):
        read(with_inner(kind, more).replace("subdesign: [77]", "subdesign: [78]"))


def test_placing_again_and_again_is_bounded() -> None:
    """Twelve transforms of ten lines each would make 10^12 plates."""
    lines = line_sketch(202, *(f"[1, {100 * k}, 0], [2, {100 * k + 10}, 0]" for k in range(10)))
    chain = internal() + "".join(
        internal()
        .replace("id: 7", f"id: {300 + k}")
        .replace("[[1, 0]]", f"[[{7 if k == 0 else 299 + k}, 0]]")
        for k in range(11)
    )
    far = lines.replace("100", "1")
    with pytest.raises(LamcError):
        read(
            cad(
                chain,
                parent=310,
                sketches=FROM + far.replace("[1, 0, 0], [2, 10, 0]", "[1, 0, 0], [2, 90, 0]"),
            )
        )
    with pytest.raises(DesignError, match="no length"):
        read(cad(internal(), parent=7, sketches=FROM + line_sketch(202, "[1, 5, 3], [2, 5, 3], [3, 6, 3]")))
