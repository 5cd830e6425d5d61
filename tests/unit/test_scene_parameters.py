"""Parameters that a scene gives values: the model has them, its exports and its cross-checks too."""

from pathlib import Path

import numpy as np
import pytest

import lamc
from lamc.readers.scene_writer import scenes_data
from lamc.reference.check import check

PENDULUM = Path(__file__).parents[2] / "lamc/examples/pendulum.yaml"
VALUES = {"h1.stiffness": 120.0, "h2.damping": "0.2 N*m*s/deg", "link_1.mass": 1.5, "gravity.z": -1.62}
SI = {**VALUES, "h2.damping": 0.2 * 180.0 / np.pi}


@pytest.fixture(scope="module")
def design() -> lamc.Design:
    design = lamc.load(PENDULUM)
    assert isinstance(design, lamc.Design)
    return design


def test_a_scene_gives_parameters_values(design: lamc.Design) -> None:
    plain, said = lamc.compile(design), lamc.compile(design, lamc.Scene(parameters=VALUES))
    for name, value in SI.items():
        assert said.parameters[name] == pytest.approx(value, rel=1e-15)  # a unit's factor rounds once
    asked = plain.run(t_end=1.0, t_eval=[0.5, 1.0], parameters=dict(said.parameters))
    assert np.array_equal(said.run(t_end=1.0, t_eval=[0.5, 1.0]).q, asked.q)  # the same C, the same numbers
    assert said.structure == plain.structure  # nothing was compiled anew
    told = {p.name: p.default for p in said.program.parameters}
    assert told == dict(said.parameters)  # which exports print


def test_what_lies_in_the_mechanism_is_cross_checked(design: lamc.Design) -> None:
    values = {name: SI[name] for name in ("h1.stiffness", "h2.damping", "link_1.mass")}
    report = check(lamc.compile(design, lamc.Scene(parameters=values)), states=4, t_end=0.2)
    assert report.passed
    assert "Newton-Euler" in report.table()


def test_limits_of_a_scene_are_the_mechanism_s(design: lamc.Design) -> None:
    scene = lamc.Scene(parameters={"h1.lower_limit": "-20 deg", "h1.upper_limit": 0.5})
    limits = lamc.compile(design, scene).mechanism.joint("h1").limits
    assert limits == (pytest.approx(-np.pi / 9.0), 0.5)


def test_unknown_names_are_refused_at_their_line(tmp_path: Path, design: lamc.Design) -> None:
    path = tmp_path / "scene.yaml"
    path.write_text("kind: scene\nangles: {h1: 0.1}\nparameters:\n  h1.stiffnes: 3\n", encoding="utf-8")
    scene = lamc.load_scene(path)
    with pytest.raises(
        lamc.LamcError, match=r"scene.yaml:4.*no parameter is named 'h1.stiffnes'.*'h1.stiffness'"
    ):
        lamc.compile(design, scene)
    with pytest.raises(lamc.LamcError, match="stiffness"):
        lamc.compile(design, lamc.Scene(parameters={"h1.stiffness": -1.0}))


def test_scenes_with_parameters_are_written_and_read(tmp_path: Path) -> None:
    scene = lamc.Scene(parameters=VALUES)
    data = scenes_data(scene, {})
    assert data == {"scene": {"parameters": VALUES}}


def test_other_engines_refuse_what_they_are_not_told(design: lamc.Design, tmp_path: Path) -> None:
    scene = lamc.Scene(parameters={"gravity.z": -1.62})
    with pytest.raises(lamc.UnsupportedError, match=r"gravity\.z"):
        lamc.export(design, "mjcf", scene, out=tmp_path / "out")
