"""Joint definitions: both forms say the same, and what lamc writes reads back as it was."""

from pathlib import Path

import numpy as np
import pytest

from lamc import examples
from lamc.basics.errors import DesignError, LamcError, TopologyError
from lamc.design.split import split, split_steps
from lamc.readers.joints_writer import write_joints, write_split
from lamc.readers.load import load
from lamc.records.design import Design
from lamc.records.mechanism import Body, Joint, Mechanism

# Both forms carry the same digits, in m and in mm: round-off of the division and of the polygon moments.
SAME = 1e-12


def mechanism(path: Path) -> Mechanism:
    record = load(path)
    assert isinstance(record, Mechanism)
    return record


def assert_same(a: Mechanism, b: Mechanism, *, names: bool = True) -> None:
    assert len(a.bodies) == len(b.bodies)
    assert len(a.joints) == len(b.joints)
    for x, y in zip(a.bodies, b.bodies, strict=True):
        assert x.fixed == y.fixed
        assert x.name == y.name or not names
        np.testing.assert_allclose(x.mass, y.mass, rtol=SAME)
        np.testing.assert_allclose(x.com, y.com, rtol=0.0, atol=SAME)
        np.testing.assert_allclose(x.inertia, y.inertia, rtol=0.0, atol=SAME * np.abs(x.inertia).max())
    for j, k in zip(a.joints, b.joints, strict=True):
        assert (j.name, j.parent, j.child) == (k.name, k.parent, k.child) or not names
        np.testing.assert_allclose(j.point, k.point, rtol=0.0, atol=SAME)
        np.testing.assert_allclose(j.axis, k.axis, rtol=0.0, atol=SAME)
        np.testing.assert_allclose(
            [j.stiffness, j.damping, j.rest_angle, *j.limits],
            [k.stiffness, k.damping, k.rest_angle, *k.limits],
            rtol=SAME,
        )


def test_flaps_has_the_masses_of_its_plates(shared: Path) -> None:
    flaps = mechanism(shared / "designs" / "flaps.joints")
    # by hand: length x 12 mm x (2 x 0.5 mm x 1800 kg/m³) and the film, 50 um of 1420 kg/m³
    rigid = np.array([39.6, 29.8, 39.8]) * 12e-6 * 1e-3 * 1800
    film = np.array([39.96, 29.98, 39.98]) * 12e-6 * 50e-6 * 1420
    np.testing.assert_allclose([b.mass for b in flaps.bodies], rigid + film * 1.0, rtol=SAME)
    assert [b.fixed for b in flaps.bodies] == [True, False, False]


def test_flaps_has_the_hinges_of_its_file(shared: Path) -> None:
    left, right = mechanism(shared / "designs" / "flaps.joints").joints
    np.testing.assert_allclose(left.point, [-0.02, 0.006, 0.000525], rtol=0.0, atol=SAME)
    np.testing.assert_array_equal(left.axis, [0, 1, 0])
    assert (left.parent, left.child) == ("ground", "link_1")
    assert left.rest_angle == pytest.approx(np.pi / 12, rel=SAME)
    assert left.limits == pytest.approx((-2 * np.pi / 3, 2 * np.pi / 3), rel=SAME)
    assert right.limits == (-np.pi, np.pi)
    assert (right.parent, right.child, right.stiffness, right.damping) == ("ground", "link_2", 0.004, 2e-6)


def test_both_forms_give_one_mechanism(shared: Path) -> None:
    assert_same(
        mechanism(shared / "designs" / "flaps.joints"), mechanism(shared / "designs" / "flaps_old.joints")
    )


def test_the_order_of_bodies_and_ids_does_not_matter(shared: Path, tmp_path: Path) -> None:
    text = (shared / "designs" / "flaps.joints").read_text()
    head, first, second, third, tail = split_bodies(text)
    swapped = tmp_path / "swapped.joints"
    swapped.write_text(head + third + first + second + tail)
    assert_same(mechanism(shared / "designs" / "flaps.joints"), mechanism(swapped))
    renamed = tmp_path / "renamed.joints"
    renamed.write_text(text.replace("1001", "9009").replace("1003", "4"))
    assert_same(mechanism(shared / "designs" / "flaps.joints"), mechanism(renamed))


def split_bodies(text: str) -> tuple[str, str, str, str, str]:
    head, *bodies = text.split("- id: 100")
    last, tail = bodies[2].split("connections:")
    parts = [f"- id: 100{part}" for part in (*bodies[:2], last)]
    return head, parts[0], parts[1], parts[2], "connections:" + tail


def test_the_example_by_hand_is_the_same_device(shared: Path) -> None:
    record = load(examples.path("flaps"))
    assert isinstance(record, Design)
    assert_same(split(record), mechanism(shared / "designs" / "flaps.joints"), names=False)


@pytest.mark.parametrize("name", examples.files())
def test_a_split_design_reads_back_as_it_was_written(name: str, tmp_path: Path) -> None:
    record = load(examples.path(name))
    if not isinstance(record, Design):
        pytest.skip("a mechanism, without layers")
    steps = split_steps(record)
    write_split(steps, tmp_path / "written.joints")
    assert_same(mechanism(tmp_path / "written.joints"), steps.mechanism)
    assert [p.name for p in tmp_path.iterdir()] == ["written.joints"]


def test_numbers_are_written_so_that_yaml_1_1_reads_them_too(tmp_path: Path) -> None:
    record = load(examples.path("shutter"))
    assert isinstance(record, Design)
    write_split(split_steps(record), tmp_path / "written.joints")
    text = (tmp_path / "written.joints").read_text()
    assert "damping: 1.0e-07" in text  # PyYAML takes 1e-07 for a string


def test_a_joint_written_without_its_line_keeps_point_and_axis(tmp_path: Path) -> None:
    record = load(examples.path("shutter"))
    assert isinstance(record, Design)
    given = split(record)
    write_joints(given, record.layers, tmp_path / "w.joints")
    assert_same(mechanism(tmp_path / "w.joints"), given)


def test_what_polygons_cannot_say_is_not_written(tmp_path: Path) -> None:
    record = load(examples.path("flaps"))
    assert isinstance(record, Design)
    given = split(record)
    heavy = [Body(b.name, b.mass * 2, b.com, b.inertia, b.fixed, b.outline) for b in given.bodies]
    with pytest.raises(DesignError, match="write a mechanism file"):
        write_joints(Mechanism(tuple(heavy), given.joints), record.layers, tmp_path / "w.joints")
    tilted = [Joint(j.name, j.parent, j.child, j.point, (0, 1, 1)) for j in given.joints]
    with pytest.raises(DesignError, match="not parallel"):
        write_joints(Mechanism(given.bodies, tuple(tilted)), record.layers, tmp_path / "w.joints")
    bare = [Body(b.name, b.mass, b.com, b.inertia, b.fixed) for b in given.bodies]
    with pytest.raises(DesignError, match="no outline"):
        write_joints(Mechanism(tuple(bare), given.joints), record.layers, tmp_path / "w.joints")
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("[1002, 1001]", "[1002]", "touches 1 bodies"),
        ("[1002, 1001]", "[1002, 1001, 1003]", "touches 3 bodies"),
        ("[1002, 1001]", "[1002, 7]", "'7', which the file does not have"),
        ("[1002, 1001]", "[1002, 1002]", "to itself"),
        ("- id: 1002", "- id: 1001", "two bodies have the id '1001'"),
        ("newtonian_ids:\n- 1001", "newtonian_ids:\n- 5", "fixed body '5'"),
        ("newtonian_ids:\n- 1001", "newtonian_ids: []", "no body is fixed"),
        ("density: 1800.0", "density: .nan", "the density"),
        ("thickness: 0.0005", "thickness: -0.0005", "the thickness"),
        ("stiffness: 0.004", "stiffness: -1", "the stiffness"),
        ("limit_neg: -120, limit_pos: 120", "limit_neg: 120, limit_pos: -120", "the limits"),
        ("POLYGON", "GEOMETRYCOLLECTION", "not a POLYGON"),
        ("POLYGON ((", "POLYGON ((nan ", "not well-known text"),
        ("[-0.02, 0.0]", "[-0.02, 0.012]", "two different ends"),
        ("connections:", "connection:", "has no 'connections'"),
        ("z_pos: 0.0005250000000000001", "z_pos: high", "z_pos is not a number"),
        (
            "name: rigid_low",
            "name: !!python/object:popupcad.manufacturing.code_exec_op.X {a: 1}",
            "code_exec_op",
        ),
    ],
)
def test_damage_is_one_line_with_its_place(
    shared: Path, tmp_path: Path, old: str, new: str, said: str
) -> None:
    text = (shared / "designs" / "flaps.joints").read_text()
    assert old in text
    file = tmp_path / "bad.joints"
    file.write_text(text.replace(old, new, 1))
    with pytest.raises(LamcError) as caught:
        load(file)
    assert said in str(caught.value)
    assert str(caught.value).startswith(str(file))
    assert "\n" not in str(caught.value)


def test_a_body_that_reaches_no_layer_is_refused(shared: Path, tmp_path: Path) -> None:
    text = (shared / "designs" / "flaps_old.joints").read_text()
    file = tmp_path / "bad.joints"
    file.write_text(
        text.replace("  - - *body0\n    - - *body0", "  - - *body0").replace(
            "- - *body1\n      - *body0", "- - *body1"
        )
    )
    with pytest.raises(TopologyError, match="touches 1 bodies"):
        load(file)
