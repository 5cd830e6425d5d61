"""FOLD files of devices: frames keep every facet's size and every angle, and read back as the same device."""

import json
import math
import warnings
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import lamc
from lamc import examples
from lamc.basics.errors import DesignWarning, ExportError, UnsupportedError
from lamc.export.fold import flat_bytes
from lamc.records.mechanism import Mechanism
from tests.support import fold_corpus as corpus


def load(path: Path) -> Mechanism:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DesignWarning)
        made = lamc.load(path)
    assert isinstance(made, Mechanism)
    return made


def cut_net() -> corpus.Data:
    data = corpus.box_net()
    hinge = data["edges_assignment"].index("V")
    data["edges_assignment"][hinge], data["edges_foldAngle"][hinge] = "C", None
    return data


def joined_net() -> corpus.Data:
    data = corpus.box_net()
    hinge = data["edges_assignment"].index("V")
    data["edges_assignment"][hinge], data["edges_foldAngle"][hinge] = "F", None
    return data


SHEETS = [
    lambda: corpus.miura(3, 3),
    corpus.waterbomb,
    lambda: corpus.yoshimura(3, 4),
    corpus.box_net,
    cut_net,
    joined_net,
    lambda: corpus.folded_pair(0.7),
]
EXPORTED = ["miura", "waterbomb", "yoshimura", "net", "cut", "joined", "folded"]


def exported(folder: Path, made: Mechanism) -> tuple[Path, lamc.Result]:
    scene = made.scene or lamc.Scene()
    result = lamc.compile(made, scene).run(t_end=0.5, t_eval=np.linspace(0.0, 0.5, 6))
    written = lamc.export(result, "fold", out=folder / "out")
    (file,) = written.glob("*.fold")
    return file, result


@pytest.mark.parametrize("make", SHEETS, ids=EXPORTED)
@pytest.mark.quick("miura", "net", "cut", others="campaign")
def test_what_is_read_back_is_the_same_device(tmp_path: Path, make: Callable[[], corpus.Data]) -> None:
    made = load(corpus.write(tmp_path / "sheet.fold", make()))
    file, _ = exported(tmp_path, made)
    with warnings.catch_warnings():
        warnings.simplefilter("error")  # nothing is assumed: the file says it all
        back = lamc.load(file)
    assert isinstance(back, Mechanism)
    assert {b.name: b.fixed for b in back.bodies} == {b.name: b.fixed for b in made.bodies}
    assert {j.name for j in back.joints} == {j.name for j in made.joints}
    for body in made.bodies:
        same = back.body(body.name)
        # Sums over corners that begin at another corner differ in their last digits.
        assert same.mass == pytest.approx(body.mass, rel=1e-12)
        np.testing.assert_allclose(same.com, body.com, rtol=0.0, atol=1e-12)
        np.testing.assert_allclose(
            same.inertia, body.inertia, rtol=0.0, atol=1e-12 * np.abs(body.inertia).max()
        )
    for joint in made.joints:
        other = back.joint(joint.name)
        assert (other.parent, other.child) == (joint.parent, joint.child)
        for name in ("stiffness", "damping", "rest_angle"):
            assert getattr(other, name) == getattr(joint, name)
        np.testing.assert_allclose(other.axis, joint.axis, rtol=0.0, atol=1e-12)
        np.testing.assert_allclose(np.cross(other.point - joint.point, joint.axis), 0.0, rtol=0.0, atol=1e-12)


@pytest.mark.quick("cut", "net", "folded", "miura", "joined")
@pytest.mark.parametrize("make", SHEETS, ids=EXPORTED)
def test_frames_are_the_motion(tmp_path: Path, make: Callable[[], corpus.Data]) -> None:
    made = load(corpus.write(tmp_path / "sheet.fold", make()))
    file, result = exported(tmp_path, made)
    data: dict[str, Any] = json.loads(file.read_text(encoding="utf-8"))
    assert len(data["file_frames"]) == 6
    flat = np.array(data["vertices_coords"])
    ends = np.array(data["edges_vertices"])
    lengths = np.linalg.norm(flat[ends[:, 1]] - flat[ends[:, 0]], axis=1)
    for frame in data["file_frames"]:
        folded = np.array(frame["vertices_coords"])
        now = np.linalg.norm(folded[ends[:, 1]] - folded[ends[:, 0]], axis=1)
        # Closure holds to some 1e-12 of the size, 1e-9 near singular positions.
        np.testing.assert_allclose(now, lengths, rtol=0.0, atol=1e-8 * lengths.max())
    # A frame alone is a folded sheet: its reader finds the angles from places, not from edges_foldAngle.
    last = {**data, **data["file_frames"][-1], "frame_inherit": False, "file_frames": []}
    bare = {key: value for key, value in last.items() if key not in ("lamc:edges_hinge", "edges_foldAngle")}
    found = load(corpus.write(tmp_path / "last.fold", bare))
    if any(abs(result.angle(j.name)[-1]) > 1e-3 for j in made.joints):
        assert found.scene is not None
        names = {f"E{k}": each["name"] for k, each in enumerate(data["lamc:edges_hinge"]) if each}
        for edge, angle in found.scene.angles.items():
            turned = math.remainder(float(result.angle(names[edge])[-1]), 2.0 * math.pi)
            assert angle == pytest.approx(turned, abs=1e-6)  # arcs of nearly flat folds lose half the digits


def test_a_design_runs_as_it_is_written(tmp_path: Path) -> None:
    made = load(corpus.write(tmp_path / "sheet.fold", corpus.box_net()))
    folder = lamc.export(made, "fold", scene=lamc.Scene(duration=0.5), out=tmp_path / "out")
    (file,) = folder.glob("*.fold")
    assert len(json.loads(file.read_text(encoding="utf-8"))["file_frames"]) == 61


def test_what_fold_cannot_hold_is_refused_or_left_out(tmp_path: Path) -> None:
    flaps = lamc.load(examples.path("flaps"))
    with pytest.raises(UnsupportedError, match="--lossy"):
        lamc.export(flaps, "fold", out=tmp_path / "a")
    with pytest.warns(DesignWarning, match=r"does not hold hinges without a common side .*: left, right"):
        folder = lamc.export(flaps, "fold", out=tmp_path / "b", scene=lamc.Scene(duration=0.1), lossy=True)
    assert len(list(folder.glob("*.fold"))) == 1
    made = load(corpus.write(tmp_path / "sheet.fold", corpus.box_net()))
    result = lamc.compile(made).run(t_end=0.1)
    with pytest.raises(ExportError, match="'fold' only"):
        lamc.export(result, "c", out=tmp_path / "c")


@pytest.mark.parametrize("make", [lambda: corpus.miura(3, 3), corpus.waterbomb], ids=["miura", "waterbomb"])
def test_a_folded_frame_of_six_digits_runs_from_where_it_is(
    tmp_path: Path, make: Callable[[], corpus.Data]
) -> None:
    """Angles measured between rounded corners close no loop; those nearby do."""
    file, result = exported(tmp_path, load(corpus.write(tmp_path / "sheet.fold", make())))
    data = json.loads(file.read_text(encoding="utf-8"))
    frame = {**data, **data["file_frames"][-1], "frame_inherit": False, "file_frames": []}
    frame["vertices_coords"] = np.round(frame["vertices_coords"], 6).tolist()  # m
    names = {f"E{k}": each["name"] for k, each in enumerate(data["lamc:edges_hinge"]) if each}
    plain = {k: v for k, v in frame.items() if not k.startswith("lamc:") and k != "edges_foldAngle"}
    folded = load(corpus.write(tmp_path / "folded.fold", plain))
    run = lamc.compile(folded).run(t_end=0.1)
    assert run.success
    for edge, name in names.items():
        # A micrometre on facets of 20 mm and more is some 1e-4 rad, twice that at nearly flat creases.
        assert run.angle(edge)[0] == pytest.approx(float(result.angle(name)[-1]), abs=1e-3)


def test_a_child_to_the_right_of_its_axis_keeps_its_fold(tmp_path: Path) -> None:
    """A positive angle lowers such a child: a mountain, which the reader turns about the reversed axis."""
    made = load(corpus.write(tmp_path / "sheet.fold", corpus.folded_pair(0.7)))
    joint = made.joints[0]
    turned = replace(joint, axis=-joint.axis, rest_angle=0.4, stiffness=1e-4)
    scene = lamc.Scene(angles={joint.name: 0.3})
    (tmp_path / "out.fold").write_bytes(flat_bytes(replace(made, joints=(turned,), scene=scene)))
    data = json.loads((tmp_path / "out.fold").read_text(encoding="utf-8"))
    assert data["edges_assignment"].count("M") == 1
    assert "V" not in data["edges_assignment"]
    back = load(tmp_path / "out.fold")
    (same,) = back.joints
    assert float(same.axis @ turned.axis) == pytest.approx(-1.0)
    assert same.rest_angle == pytest.approx(-turned.rest_angle)
    assert back.scene is not None
    assert back.scene.angles == {joint.name: pytest.approx(-0.3)}
