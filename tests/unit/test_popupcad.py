"""popupCAD's own designs: the paper's pendulum, every shape and operation, and what is refused by name."""

import json
import math
from pathlib import Path

import numpy as np
import pytest

from lamc.basics.errors import DesignError, LamcError, UnsupportedError
from lamc.design.split import split
from lamc.readers.inert import compose
from lamc.readers.load import load
from lamc.readers.popupcad import read_design
from lamc.records.design import Design, Material

RECT = "!!python/object:popupcad.filetypes.genericshapes.GenericTwoPointRect"
POLY = "!!python/object:popupcad.filetypes.genericshapes.GenericPoly"
CIRCLE = "!!python/object:popupcad.filetypes.genericshapes.GenericCircle"
LINE = "!!python/object:popupcad.filetypes.genericshapes.GenericLine"
POLYLINE = "!!python/object:popupcad.filetypes.genericshapes.GenericPolyline"
OPERATION = "!!python/object:popupcad.manufacturing"

PLATE = f"{RECT} {{construction: false, exterior: [[1, 0, 0], [2, 40, 10]], id: 1}}"
HINGE = f"{LINE} {{construction: false, exterior: [[1, 20, 0], [2, 20, 10]], id: 2}}"
HELD = f"{RECT} {{construction: false, exterior: [[1, 0, 0], [2, 5, 10]], id: 3}}"


def sketch_operation(number: int, sketch: int, layers: str = "[11, 12]") -> str:
    return (
        f"- {OPERATION}.simplesketchoperation.SimpleSketchOp\n  {{customname: 'op {number}', id: {number}, "
        f"layer_links: {layers}, operation_links: {{}}, sketch_links: {{sketch: [{sketch}]}}}}\n"
    )


def laminate_operation(number: int, function: str, unary: str, binary: str) -> str:
    return (
        f"- {OPERATION}.laminateoperation2.LaminateOperation2\n  {{customname: 'op {number}', id: {number}, "
        f"function: {function}, operation_links: {{unary: {unary}, binary: {binary}}}}}\n"
    )


def buffer_operation(number: int, parent: int, values: str) -> str:
    return (
        f"- {OPERATION}.bufferop3.BufferOperation3\n  {{customname: 'op {number}', id: {number}, "
        f"operation_links: {{parent: [[{parent}, 0]]}}, values: {values}}}\n"
    )


def cad(
    operations: str = "",
    parent: int = 1,
    sketches: str = "",
    joint: str = "JointOperation3",
    limits: str = "",
) -> str:
    """A design of two layers whose joint operation rests on operation `parent`."""
    return f"""\
!!python/object:popupcad.filetypes.design.Design
_layerdef: !!python/object:popupcad.filetypes.layerdef.LayerDef
  layers:
  - !!python/object:popupcad.filetypes.material2.Material2
    {{E1: 1, E2: 1, poisson: 0.5, density: 2, id: 11, is_adhesive: false, is_conductive: false,
     is_rigid: true, name: sheet, thickness: 0.5}}
  - !!python/object:popupcad.filetypes.material2.Material2
    {{E1: 2.0e+9, E2: 3.0e+9, poisson: 0.3, density: 1000, id: 12, is_adhesive: false, is_conductive: false,
     is_rigid: false, name: sheet, thickness: 0.05}}
operations:
{sketch_operation(1, 101)}{operations}{sketch_operation(2, 103)}- {OPERATION}.joint_operation3.{joint}
  customname: hinges
  id: 99
  joint_defs:
  - !!python/object:popupcad.manufacturing.joint_operation3.JointDef
    {{sketch: 102, joint_layer: 12, sublaminate_layers: [12, 11], width: 0.2, stiffness: 3.0e-3,
     damping: 1.0e-6, preload_angle: 30{limits}}}
  operation_links: {{parent: [[{parent}, 0]], fixed: [[2, 0]]}}
sketches:
  101: !!python/object:popupcad.filetypes.sketch.Sketch {{operationgeometry: [{PLATE}]}}
  102: !!python/object:popupcad.filetypes.sketch.Sketch {{operationgeometry: [{HINGE}]}}
  103: !!python/object:popupcad.filetypes.sketch.Sketch {{operationgeometry: [{HELD}]}}
{sketches}"""


def sketch(number: int, *shapes: str) -> str:
    drawn = ", ".join(shapes)
    return f"  {number}: !!python/object:popupcad.filetypes.sketch.Sketch {{operationgeometry: [{drawn}]}}\n"


def read(text: str) -> Design:
    return read_design(compose(text, "given.cad"), {})


def areas(design: Design) -> list[float]:
    """Area of each layer, mm²."""
    return [layer.geometry.area * 1e6 for layer in design.layers]


def test_the_papers_pendulum_has_the_masses_and_inertia_of_the_reference(shared: Path) -> None:
    cases = json.loads((shared / "reference" / "dynamics.json").read_text())["cases"]
    case = next(c for c in cases if c["id"] == "popupcad_pendulum")
    record = load(shared / "designs" / "popupcad" / "pendulum.cad")
    assert isinstance(record, Design)
    mechanism = split(record)
    moving = sorted((b for b in mechanism.bodies if not b.fixed), key=lambda b: float(b.com[0]))
    # the drawing's gaps are exact to 1e-16 m, so masses are good to round-off
    np.testing.assert_allclose([b.mass for b in moving], case["masses"], rtol=0, atol=1e-12)
    first = moving[0].inertia[1, 1]
    np.testing.assert_allclose(first, case["inertia_com_about_hinge_direction"][0], rtol=0, atol=1e-12)
    joints = sorted(mechanism.joints, key=lambda j: float(j.point[0]))
    assert [tuple(j.axis) for j in joints] == [(0, 1, 0), (0, 1, 0), (0, -1, 0)]
    assert [(j.stiffness, j.damping, j.rest_angle) for j in joints] == [(100.0, 10.0, 0.0)] * 3


def test_millimetres_and_degrees_become_si() -> None:
    design = read(cad(limits=", limit_negative: -120, limit_positive: 180"))
    assert [layer.thickness for layer in design.layers] == [0.0005, 5e-05]
    hinge = design.hinges[0]
    assert (hinge.width, hinge.stiffness, hinge.damping) == (0.0002, 0.003, 1e-06)
    assert hinge.rest_angle == math.radians(30)
    assert hinge.limits == (math.radians(-120), math.pi)
    assert (hinge.layer, hinge.sublaminate) == (1, (0, 1))
    assert hinge.lines[0].line == ((0.02, 0.0), (0.02, 0.01))
    assert areas(design) == pytest.approx([400, 400], rel=1e-12)  # round-off


def test_layers_that_share_a_name_are_told_apart() -> None:
    assert [layer.name for layer in read(cad()).layers] == ["sheet", "sheet_2"]


def test_placeholder_moduli_are_unknown_and_measured_ones_are_kept() -> None:
    sheet, film = (layer.material for layer in read(cad()).layers)
    assert (sheet.E1, sheet.E2, sheet.poisson) == (None, None, None)
    assert (film.E1, film.E2, film.poisson) == (2e9, 3e9, 0.3)


def test_a_file_without_the_flexible_flag_has_it_where_no_other_is_set() -> None:
    sheet, film = (layer.material for layer in read(cad()).layers)
    assert (sheet.is_rigid, sheet.is_flexible) == (True, False)
    assert (film.is_rigid, film.is_flexible) == (False, True)


def test_materials_can_be_replaced_by_name(tmp_path: Path) -> None:
    file = tmp_path / "design.cad"
    file.write_text(cad())
    design = load(file, materials={"sheet": Material("sheet", 1800.0, 70e9, 70e9, 0.3, is_rigid=True)})
    assert isinstance(design, Design)
    assert [layer.material.density for layer in design.layers] == [1800.0, 1800.0]


def test_the_older_joint_operation_has_no_limits() -> None:
    hinge = read(cad(joint="JointOperation2")).hinges[0]
    assert hinge.limits == (-math.pi, math.pi)


@pytest.mark.parametrize(
    ("function", "expected"),
    [("difference", 300.0), ("intersection", 100.0), ("union", 500.0), ("symmetric_difference", 400.0)],
)
def test_laminate_operations_combine_each_layer(function: str, expected: float) -> None:
    # the plate, 40 x 10, and a block of 20 x 10 that overlaps it by 10 x 10
    block = f"{POLY} {{construction: false, exterior: [[1, 30, 0], [2, 50, 0], [3, 50, 10], [4, 30, 10]]}}"
    unary = "[[1, 0], [3, 0]]" if function in ("union", "intersection") else "[[1, 0]]"
    operations = sketch_operation(3, 104, "[11]") + laminate_operation(4, function, unary, "[[3, 0]]")
    design = read(cad(operations, 4, sketch(104, block)))
    other = {"intersection": 0.0}.get(function, 400.0)  # the second layer has no block
    assert areas(design) == pytest.approx([expected, other], rel=1e-12)  # round-off


def test_a_buffered_line_cuts_a_strip() -> None:
    operations = (
        sketch_operation(3, 102, "[11]")
        + buffer_operation(4, 3, "[0.2, 1.0]")
        + laminate_operation(5, "difference", "[[1, 0]]", "[[4, 0]]")
    )
    # a strip of 0.4 x 10; the caps lie outside the plate
    assert areas(read(cad(operations, 5))) == pytest.approx([396, 400], rel=1e-12)  # round-off


def test_a_negative_buffer_shrinks_areas() -> None:
    assert areas(read(cad(buffer_operation(3, 1, "[-1, 4]"), 3))) == pytest.approx([38 * 8] * 2, rel=1e-12)


def test_every_shape_is_read_with_holes_and_without_construction() -> None:
    shapes = (
        f"{POLY} {{construction: false, exterior: [[1, 0, 0], [2, 9, 0], [3, 9, 9], [4, 0, 9]], "
        "interiors: [[[1, 1, 1], [2, 2, 1], [3, 2, 2], [4, 1, 2]]]}",
        f"{CIRCLE} {{exterior: [!ShapeVertex_1 [1, 50, 50], !ShapeVertex_1 [2, 53, 54]], id: 4}}",
        f"{RECT} {{construction: true, exterior: [[1, 90, 0], [2, 99, 9]]}}",
        f"{POLYLINE} {{construction: false, exterior: [[1, 0, 90], [2, 9, 90], [3, 9, 99]]}}",
        "!DrawnPoint_1 [7, 80, 80, false]",
    )
    design = read(cad(sketch_operation(3, 104), 3, sketch(104, *shapes)))
    # 9 x 9 less a hole of 1 x 1, and a circle of radius 5; lines and points have no area
    assert areas(design) == pytest.approx([80 + 25 * math.pi] * 2, rel=1e-12)  # round-off


def test_hinge_lines_that_cross_are_four_hinges() -> None:
    text = cad().replace("  102:", "  109:") + sketch(
        102,
        f"{LINE} {{construction: false, exterior: [[1, 20, 0], [2, 20, 10]]}}",
        f"{LINE} {{construction: false, exterior: [[1, 40, 5], [2, 0, 5]]}}",
    )
    lines = [item.line for item in read(text).hinges[0].lines]
    assert lines == [
        ((0.02, 0.0), (0.02, 0.005)),
        ((0.02, 0.005), (0.02, 0.01)),
        ((0.04, 0.005), (0.02, 0.005)),
        ((0.02, 0.005), (0.0, 0.005)),
    ]


def test_a_bent_polyline_is_one_hinge_per_straight_run() -> None:
    shape = f"{POLYLINE} {{construction: false, exterior: [[1, 0, 0], [2, 4, 0], [3, 8, 0], [4, 8, 5]]}}"
    text = cad().replace("  102:", "  109:") + sketch(102, shape)
    assert [h.line for h in read(text).hinges[0].lines] == [
        ((0.0, 0.0), (0.008, 0.0)),
        ((0.008, 0.0), (0.008, 0.005)),
    ]


UNKNOWN = f"- {OPERATION}.cutop.CutOperation {{customname: 'cut', id: 7, operation_links: {{}}}}\n"
CODE = (
    "- !!python/object:popupcad.manufacturing.code_exec_op.CodeExecOp\n"
    "  {customname: '', id: 8, operation_links: {}, code: 'import os'}\n"
)


def test_an_unknown_operation_matters_only_on_the_path_to_the_hinges() -> None:
    assert areas(read(cad(UNKNOWN))) == pytest.approx([400, 400], rel=1e-12)
    with pytest.raises(UnsupportedError, match=r"'cut', an operation of kind 'CutOperation'"):
        read(cad(UNKNOWN, 7))


def test_stored_code_is_refused_wherever_it_stands() -> None:
    with pytest.raises(UnsupportedError, match="code_exec_op"):
        read(cad(CODE))


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("thickness: 0.5", "thickness: -1", "the thickness of layer 'sheet' is -1.0"),
        ("thickness: 0.5", "thickness: .nan", "finite"),
        ("density: 2", "density: -2", "the density of material 'sheet' is -2.0"),
        ("stiffness: 3.0e-3", "stiffness: -1", "the stiffness is -1.0"),
        ("width: 0.2", "width: 0", "the hinge width is 0.0"),
        ("width: 0.2", "width: wide", "the hinge width is not a number"),
        ("sketch: 102", "sketch: 999", "no sketch '999'"),
        ("joint_layer: 12", "joint_layer: 7", "no layer with id '7'"),
        ("fixed: [[2, 0]]", "fixed: [[77, 0]]", "'77', which is missing"),
        ("fixed: [[2, 0]]", "fixed: [[99, 0]]", "refers to one that comes after it"),
        ("fixed: [[2, 0]]", "fixed: [[2, 3]]", "output 3"),
        ("[2, 40, 10]", "[2, 0, 10]", "encloses no area"),
        ("GenericTwoPointRect", "GenericSpline", "GenericSpline"),
        ("GenericLine", "GenericTwoPointRect", "encloses no area"),
        ("joint_operation3.JointOperation3", "joint_operation3.Other", "0 joint operations"),
        ("[2, 20, 10]", "[2, 20, .inf]", "finite"),
    ],
)
def test_damage_is_one_line_with_its_place(old: str, new: str, said: str) -> None:
    text = cad()
    assert old in text
    with pytest.raises(LamcError) as caught:
        read(text.replace(old, new, 1))
    assert said in str(caught.value)
    assert str(caught.value).startswith("given.cad:")
    assert "\n" not in str(caught.value)


def test_a_buffer_as_fine_as_memory_allows_is_refused() -> None:
    with pytest.raises(DesignError, match="resolution"):
        read(cad(buffer_operation(3, 1, "[1, 1.0e+9]"), 3))
