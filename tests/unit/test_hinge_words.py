"""A hinge has a gap; its old name and numbers without their unit are told; units are taken wherever a number is."""

import math
import re
import warnings
from pathlib import Path

import pytest

import lamc
from lamc.commands.pairs import pairs_of
from lamc.readers.load import load_text

FLAP = """\
name: flap
units: mm
materials:
  card: {density: 700, rigid: true}
  film: {density: 1390, flexible: true, E1: 4.9 GPa, poisson: 0.38}
layers:
  - {name: low, material: card, thickness: 0.3 mm}
  - {name: hinge, material: film, thickness: 25 um}
  - {name: high, material: card, thickness: 0.3 mm}
shapes:
  - {rect: [0, 0, 40, 20]}
hinges:
  - {name: fold, line: [[15, 0], [15, 20]], gap: 0.4, stiffness: 0.5 N*mm/rad, damping: 1e-6}
fixed:
  - {rect: [0, 0, 5, 20]}
"""


def test_the_old_width_is_half_the_gap_and_warns_once_with_the_new_name() -> None:
    old = FLAP.replace("gap: 0.4", "width: 0.2")
    with pytest.warns(lamc.DesignWarning, match=r"old.yaml:13:52: hinges\[0\]: .*write gap: 0.4 mm") as told:
        design = load_text(old, "old.yaml")
    assert len(told) == 1
    assert design == load_text(FLAP, "old.yaml")


def test_a_design_with_gaps_warns_of_nothing() -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        design = load_text(FLAP, "new.yaml")
    assert isinstance(design, lamc.Design)
    (hinge,) = design.hinges
    assert (hinge.gap, hinge.width) == (4e-4, 2e-4)


@pytest.mark.parametrize(
    ("said", "message"),
    [
        ("", "needs its gap, the length of bare film"),
        ("gap: 0.4, width: 0.2", "width is the old name of half the gap; keep gap alone"),
    ],
)
def test_a_hinge_has_one_gap(said: str, message: str) -> None:
    with pytest.raises(lamc.DesignError, match=rf"a.yaml:13:5: hinges\[0\]: .*{message}"):
        load_text(FLAP.replace("gap: 0.4", said).replace(", ,", ","), "a.yaml")


def test_a_stiffness_from_the_material_is_that_of_the_film_over_the_gap() -> None:
    design = load_text(FLAP.replace("0.5 N*mm/rad", "from-material"), "flap.yaml")
    assert isinstance(design, lamc.Design)
    # A strip longer along the hinge than across bends as a plate: E t³ b / (12 (1 - ν²) gap).
    plate = 4.9e9 * (25e-6) ** 3 * 20e-3 / (12 * (1 - 0.38**2) * 0.4e-3)
    # 1e-9: the road goes through A, B, D of the film and their inverse, a few dozen roundings.
    assert lamc.split(design).joint("fold").stiffness == pytest.approx(plate, rel=1e-9)


def test_a_film_without_a_modulus_has_no_stiffness_and_the_line_says_so() -> None:
    text = FLAP.replace("0.5 N*mm/rad", "from-material").replace(", E1: 4.9 GPa, poisson: 0.38", "")
    with pytest.raises(lamc.DesignError, match=r"a.yaml:13:\d+: hinges\[0\].stiffness: .*film"):
        load_text(text, "a.yaml")


@pytest.mark.parametrize(("angle", "told"), [("30", 1), ("6.2", 0), ("720 deg", 0), ("30 rad", 0), ("-7", 1)])
def test_a_bare_start_angle_of_more_than_a_turn_warns_with_its_line(angle: str, told: int) -> None:
    with warnings.catch_warnings(record=True) as found:
        warnings.simplefilter("always")
        load_text(f"{FLAP}scene:\n  angles: {{fold: {angle}}}\n", "a.yaml")
    assert len(found) == told
    if told:
        assert "a.yaml:17:18: the initial angle of joint 'fold' is" in str(found[0].message)
        assert f"write '{angle} deg'" in str(found[0].message)


def test_a_scene_in_python_takes_text_with_units() -> None:
    scene = lamc.Scene(
        angles={"fold": "30 deg"}, rates={"fold": "90 deg/s"}, duration="500 ms", closure_tolerance="10 um"
    )
    assert scene.angles == {"fold": math.radians(30)}
    assert scene.rates == {"fold": math.pi / 2}
    assert (scene.duration, scene.closure_tolerance) == (0.5, 1e-5)
    assert lamc.OutputPoint("tip", "a", ("10 mm", 0, 0)).point == (0.01, 0.0, 0.0)  # type: ignore[arg-type]
    with pytest.warns(lamc.DesignWarning, match="4.77 turns; .* write '30 deg' for degrees"):
        lamc.Scene(angles={"fold": 30})
    with pytest.raises(
        lamc.DesignError, match="initial angle of joint 'fold' is '3 mm'; 'mm' is not a unit of angle"
    ):
        lamc.Scene(angles={"fold": "3 mm"})


def test_bodies_joints_inputs_and_torques_take_text_with_units() -> None:
    body = lamc.Body(
        "a", mass="12 mg", com=("1 mm", 0, 0), inertia=((1e-9, 0, 0), (0, 1e-9, 0), (0, 0, 1e-9))
    )  # type: ignore[arg-type]
    assert (body.mass, body.com[0]) == (12e-6, 1e-3)
    joint = lamc.Joint(
        "h", "g", "a", stiffness="3 N*mm/deg", rest_angle="90 deg", limits=("-90 deg", "45 deg")
    )  # type: ignore[arg-type]
    assert joint.stiffness == pytest.approx(3e-3 * 180 / math.pi, rel=1e-15)
    assert joint.limits == (-math.pi / 2, math.pi / 4)
    assert lamc.Input("5 N*mm", unit="N*m").default == 5e-3
    assert lamc.Input("5 N*mm") == lamc.Input(5e-3, "N*m")
    assert lamc.Torque({"h": "0.1 N*mm"}).torques == {"h": 1e-4}


def test_parameters_of_a_run_take_text_with_units() -> None:
    sim = lamc.compile(load_text(FLAP, "flap.yaml"))
    by_text = sim.run(0.01, parameters={"fold.stiffness": "0.7 N*mm/rad", "link_1.mass": "0.3 g"})
    by_number = sim.run(0.01, parameters={"fold.stiffness": 0.7e-3, "link_1.mass": 0.3e-3})
    assert (by_text.q == by_number.q).all()
    assert sim.run("10 ms").t[-1] == 0.01
    with pytest.raises(lamc.RequestError, match="t_end is '3 mm'; it must be a number"):
        sim.run("3 mm")
    with pytest.raises(
        lamc.RequestError, match=r"'fold.stiffness': 'mm' is not a unit of \w+; expected N\*m/rad"
    ):
        sim.run(0.01, parameters={"fold.stiffness": "3 mm"})


def test_files_that_are_not_utf_8_say_so_and_how_to_save_them(tmp_path: Path) -> None:
    file = tmp_path / "a.yaml"
    file.write_bytes(FLAP.replace("name: flap", "name: Fläche").encode("latin-1"))
    with pytest.raises(lamc.DesignError, match=r"a.yaml:1: .*not UTF-8.*save it as UTF-8"):
        lamc.load(file)


def test_pairs_divide_at_the_last_sign() -> None:
    assert pairs_of(["a=b=0.4 mm"], "--set", "1") == {"a=b": "0.4 mm"}


@pytest.mark.parametrize("said", ["rest_angle: 10", "limits: [-10, 10]", "limits: [-1, 7]"])
def test_bare_angles_of_a_hinge_beyond_a_turn_warn_at_their_place(said: str) -> None:
    with pytest.warns(
        lamc.DesignWarning, match=rf"a.yaml:13:\d+: hinges\[0\].{said.split(':')[0]} is .* turns"
    ):
        load_text(FLAP.replace("damping: 1e-6", said), "a.yaml")


def test_a_hinge_wider_than_its_plate_is_told() -> None:
    design = load_text(FLAP.replace("gap: 0.4", "gap: 40"), "a.yaml")
    assert isinstance(design, lamc.Design)
    with pytest.warns(
        lamc.DesignWarning, match=r"a.yaml:13:24: hinge 'fold' is wider than its plate: .* 15 mm from"
    ):
        lamc.split(design)
    wider = load_text(FLAP.replace("gap: 0.4", "gap: 100"), "a.yaml")
    assert isinstance(wider, lamc.Design)
    with pytest.raises(lamc.TopologyError, match="Its gap, 100 mm, is longer than its line: check it first"):
        lamc.split(wider)


def test_a_fold_that_passes_half_a_turn_is_told_with_its_time_unless_something_stops_it() -> None:
    """Under a constant torque alone angle = T t² / 2 J: ±180° are passed at sqrt(2 π J / T)."""
    design = load_text(FLAP.replace(", stiffness: 0.5 N*mm/rad, damping: 1e-6", ""), "a.yaml")
    mechanism = lamc.split(design)  # type: ignore[arg-type]
    arm = next(body for body in mechanism.bodies if not body.fixed)
    hinge = mechanism.joint("fold")
    away = arm.com - hinge.point
    inertia = arm.inertia[1, 1] + arm.mass * (away[0] ** 2 + away[2] ** 2)
    torque = 1e-4
    scene = lamc.Scene(effects=(lamc.Torque({"fold": torque}),))
    result = lamc.compile(mechanism, scene).run(0.2, t_eval=[k * 1e-3 for k in range(201)])
    (note,) = result.notes
    told = float(re.findall(r"hinge 'fold' at t = (\S+) s went through ±180°", note)[0])
    # Between two rows 1e-3 s apart the crossing is interpolated: (1e-3)²/8 of the acceleration, over the rate, is 3e-6.
    assert told == pytest.approx(math.sqrt(2.0 * math.pi * inertia / torque), abs=1e-5)
    stopped = lamc.Scene(effects=(lamc.Torque({"fold": torque}), lamc.JointLimits(flat_fold=True)))
    assert lamc.compile(mechanism, stopped).run(0.2).notes == ()


def test_numbers_that_numpy_shows_are_told_by_their_cause() -> None:
    with pytest.raises(
        lamc.DesignError, match=r"'np.float64\(40.0\)' is how Python shows a number of numpy's"
    ):
        load_text(FLAP.replace("0, 40, 20", "0, np.float64(40.0), 20"), "a.yaml")


def test_a_drawing_of_metres_without_a_unit_is_told() -> None:
    with pytest.warns(lamc.DesignWarning, match=r"a.yaml:1:1: .* metres, .* 44.7 m wide: write units: mm"):
        load_text(FLAP.replace("units: mm\n", ""), "a.yaml")


def test_a_key_without_its_colon_is_told_as_such() -> None:
    with pytest.raises(lamc.DesignError, match="a line above has a key without ': ' behind it"):
        load_text(FLAP.replace("units: mm", "units mm"), "a.yaml")


def test_a_name_with_underscores_keeps_them_in_messages() -> None:
    with pytest.raises(lamc.DesignError, match="not a unit of torque of 'right_root'"):
        lamc.Torque({"right_root": "1 N"})
