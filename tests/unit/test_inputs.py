"""Inputs of scenes: numbers from outside in expressions, as parameters of the model."""

import json
import re
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any, ClassVar

import numpy as np
import pytest
import sympy as sp
from click.testing import CliRunner
from hypothesis import given, settings
from hypothesis import strategies as st

import lamc
from lamc import Input
from lamc.basics.errors import DesignError, DesignErrors, ExpressionError, LamcError
from lamc.basics.si_units import measured, si_unit
from lamc.cli import main
from lamc.effects import BaseMotion, Gravity, LinearMotor, PiezoBender, Torque
from lamc.mechanics.loads import Loads
from lamc.mechanics.lower import lower
from lamc.pipeline import equations_of
from lamc.readers.load_scene import scene_of_text
from lamc.readers.scene_writer import scene_data
from lamc.readers.schema import json_schema
from lamc.records.effect import Effect
from lamc.records.mechanism import Body, Joint, Mechanism
from lamc.records.scene import Scene
from lamc.reference.check import check
from lamc.reference.interpreter import Interpreter
from lamc.symbolic.program import Program
from tests.support.ctools import needs_cc
from tests.support.every_effect import BIMORPH, mechanism
from tests.support.quick import tries

DRIVEN = Torque({"h1": "drive*sin(3*t) + bias"})
INPUTS = {"drive": Input(0.3, "N*m", "amplitude"), "bias": Input(unit="N·m")}


def program(*effects: Effect, **inputs: Input) -> Program:
    return lower(equations_of(mechanism(), effects, inputs=inputs))


# ---- what they do -------------------------------------------------------------------------------------------------


def test_an_input_is_a_parameter_with_its_unit_and_its_meaning() -> None:
    found = {p.name: p for p in program(DRIVEN, **INPUTS).parameters if p.is_input}
    assert list(found) == ["bias", "drive"]
    assert (found["drive"].default, found["drive"].unit, found["drive"].meaning) == (0.3, "N·m", "amplitude")
    assert (found["bias"].default, found["bias"].unit) == (0.0, "N·m")


@needs_cc
@pytest.mark.parametrize("drive", [0.3, -1.7])
def test_a_model_told_a_number_moves_as_one_in_which_it_is_written(drive: float) -> None:
    scene = Scene(effects=(Gravity(), DRIVEN), inputs=INPUTS)
    t = np.linspace(0.0, 1.0, 21)
    reported = lamc.compile(mechanism(), scene).run(1.0, t_eval=t, parameters={"drive": drive, "bias": 0.1})
    written = Scene(effects=(Gravity(), Torque({"h1": f"{drive}*sin(3*t) + 0.1"})))
    expected = lamc.compile(mechanism(), written).run(1.0, t_eval=t)
    # at most the order of two products differs: round-off that a second of this motion does not multiply by 1000
    assert np.abs(reported.q - expected.q).max() <= 1e-12


@needs_cc
def test_a_base_told_place_speed_and_acceleration_is_there_and_its_acceleration_is_gravity() -> None:
    """x = p + v (t - t0) + a (t - t0)²/2: the rate and the acceleration are exact, so that in the base's own frame the
    mechanism swings as under a gravity that is tilted by -a (Einstein's lift)."""
    inputs = {
        "p": Input(0.02, "m"),
        "v": Input(0.3, "m/s"),
        "a": Input(2.5, "m/s^2"),
        "t0": Input(0.1, "s"),
    }
    reported = BaseMotion(displacement=("p + v*(t - t0) + a*(t - t0)^2/2", 0.0, 0.0))
    t = np.linspace(0.0, 1.0, 11)
    start = {"h1": 0.4, "h2": -0.2}
    moved = lamc.compile(mechanism(), Scene(effects=(Gravity(), reported), angles=start, inputs=inputs))
    lifted = moved.run(1.0, t_eval=t, rtol=1e-11, atol=1e-13)
    tilted = lamc.compile(mechanism(), Scene(effects=(Gravity((-2.5, 0.0, -9.81)),), angles=start))
    expected = tilted.run(1.0, t_eval=t, rtol=1e-11, atol=1e-13)
    # rtol times some hundred steps, on both sides
    assert np.abs(lifted.q - expected.q).max() <= 1e-8
    where = lifted.pose("ground")[0][:, 0]
    assert where == pytest.approx(-0.5 + 0.02 + 0.3 * (t - 0.1) + 1.25 * (t - 0.1) ** 2, abs=1e-14)
    assert set(moved.inputs) == set(inputs)


@pytest.mark.slow
@needs_cc
def test_three_cross_checks_agree_on_inputs() -> None:
    """With defaults that are not zero: Newton and Euler read the expressions by a parser of their own."""
    motor = LinearMotor("h2", "battery*sin(t)", torque_constant=0.1, resistance=2.0)
    inputs = {**INPUTS, "battery": Input(6.0, "V")}
    assert check(lamc.compile(mechanism(), Scene(effects=(Gravity(), DRIVEN, motor), inputs=inputs))).passed
    moved = BaseMotion(displacement=(0.0, "push*sin(t)^2", 0.0), angle="turn*t")
    scene = Scene(
        effects=(Gravity(), DRIVEN, moved),
        inputs={**INPUTS, "push": Input(0.2, "m"), "turn": Input(0.7, "rad/s")},
    )
    assert check(lamc.compile(mechanism(), scene)).passed


@needs_cc
def test_a_motors_energy_balance_know_the_voltage_that_was_told() -> None:
    motor = LinearMotor("h1", "battery*cos(2*t)", torque_constant=0.2, resistance=1.5)
    sim = lamc.compile(mechanism(), Scene(effects=(motor,), inputs={"battery": Input(unit="V")}))
    result = sim.run(0.5, parameters={"battery": 9.0})
    energy_balance = motor.energy_balance(result)
    assert energy_balance.voltage == pytest.approx(9.0 * np.cos(2.0 * result.t), abs=1e-14)
    assert result.powers["linear_motor"] == pytest.approx(
        energy_balance.mechanical, abs=1e-12
    )  # round-off of some W


def test_a_bender_takes_its_voltage_from_outside() -> None:
    def bender(voltage: float | str) -> PiezoBender:
        ends = ("a", (0.1, 0.0, 0.0), "b", (1.2, 0.0, 0.0), (0, 0, 1), 0.1)
        return PiezoBender(*ends, BIMORPH, (1, -1), voltage)  # type: ignore[arg-type]

    cross_checks = [
        Interpreter(program(bender("wave*2"), wave=Input(unit="V"))),
        Interpreter(program(bender(100.0))),
    ]
    q, u = np.array([0.1, -0.2]), np.array([0.3, 0.1])
    found = cross_checks[0].acceleration(0.0, q, u, cross_checks[0].constants({"wave": 50.0}))
    assert found == pytest.approx(
        cross_checks[1].acceleration(0.0, q, u, cross_checks[1].constants()), rel=1e-12
    )


@dataclass(frozen=True)
class Push:
    """A user's own effect: a torque that is the input `push` times a cosine."""

    name: ClassVar[str] = "push"
    summary: ClassVar[str] = "Push from outside"

    def inputs(self) -> tuple[str, ...]:
        return ("push",)

    def contribute(self, loads: Loads) -> None:
        loads.hinge_torque("h1", sp.Symbol("push") * sp.cos(sp.Symbol("q_h1")))


def test_an_effect_of_ones_own_reads_inputs_in_sympy() -> None:
    made = program(Push(), push=Input(unit="N*m"))
    twin = program(Torque({"h1": "0.7*cos(angle)"}))
    cross_check, other = Interpreter(made), Interpreter(twin)
    q, u = np.array([0.4, 0.2]), np.array([1.0, -1.0])
    found = cross_check.acceleration(0.0, q, u, cross_check.constants({"push": 0.7}))
    assert found == pytest.approx(other.acceleration(0.0, q, u, other.constants()), rel=1e-13)
    with pytest.raises(
        DesignError, match="effect 'push' reads the input 'push', which the scene does not have"
    ):
        Scene(effects=(Push(),))


def test_operations_by_effect_add_up_with_inputs() -> None:
    equations = equations_of(mechanism(), (Gravity(), DRIVEN), inputs=INPUTS)
    counts = equations.operations_by_effect
    assert sum(c.flops for c in counts.values()) == equations.operations.flops
    assert counts["torque"].flops > 0


@needs_cc
def test_the_cache_knows_inputs_by_name_default_and_unit() -> None:
    """A module of another default must not be taken for this one's."""
    finals = []
    for default in (0.3, 0.4):
        scene = Scene(effects=(DRIVEN,), inputs={**INPUTS, "drive": Input(default, "N*m")})
        finals.append(lamc.compile(mechanism(), scene).run(0.2).q[-1, 0])
    assert finals[1] == pytest.approx(finals[0] * 4.0 / 3.0, rel=0.05)  # nearly linear so near to the start
    named = lamc.compile(
        mechanism(), Scene(effects=(DRIVEN,), inputs={**INPUTS, "drive": Input(0.3, "N*m", "else")})
    )
    assert {p.meaning for p in named.program.parameters if p.name == "drive"} == {"else"}


# ---- domains ------------------------------------------------------------------------------------------------------


@needs_cc
def test_a_drive_without_a_value_at_the_runs_inputs_is_refused() -> None:
    scene = Scene(
        effects=(Torque({"h1": "sqrt(level - t)/gain"}),), inputs={"level": Input(1.0), "gain": Input()}
    )
    sim = lamc.compile(mechanism(), scene)
    with pytest.raises(ExpressionError, match=r"no value at the start with .* gain = 0: division by zero"):
        sim.run(0.5)
    assert sim.run(0.5, parameters={"gain": 2.0}).success
    with pytest.raises(ExpressionError, match=r"no value at t = 1.0\d* s, level = 1, gain = 2, within"):
        sim.run(1.5, parameters={"gain": 2.0})


def test_an_expression_without_a_value_for_any_input_is_refused_when_it_is_made() -> None:
    with pytest.raises(ExpressionError, match=r"acos of -inf to -2"):
        Torque({"h1": "acos(-2 - abs(level))"})


# ---- names and units ----------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("t", "is named 't', which is the time; choose another name, such as 't_in'"),
        ("angle", "the angle of the driven joint"),
        ("rate", "the rate of the driven joint"),
        ("pi", "3.14159"),
        ("sin", "a function"),
        ("pow", "a function"),
        ("lambda", "a word of Python"),
        ("z12", "a quantity of the staged equations"),
        ("M_0_1", "a quantity of the staged equations"),
        ("h1.torque", "a name is of letters a to z, digits and _"),
        ("1st", "begins with a letter"),
        ("_x", "begins with a letter"),
        ("ä", "a name is of letters"),
        ("a" * 41, "at most 40 characters"),
        ("", "a name is of letters"),
        (3, "a name is of letters"),
    ],
)
def test_names_that_inputs_cannot_have_are_refused(name: Any, words: str) -> None:
    with pytest.raises(DesignError, match=re.escape(words)) as caught:
        Scene(inputs={name: Input()})
    assert "\n" not in str(caught.value)


def test_a_name_that_the_model_has_is_refused() -> None:
    drive = {"q_h1": Input()}
    with pytest.raises(DesignError, match="'q_h1', as the equations name the motion of 'h1'; choose"):
        equations_of(mechanism(), (Torque({"h1": "q_h1"}),), inputs=drive)

    @dataclass(frozen=True)
    class Own:
        name: ClassVar[str] = "own"
        summary: ClassVar[str] = "a parameter named as an input is"

        def contribute(self, loads: Loads) -> None:
            loads.hinge_torque("h2", loads.parameter("drive", 0.3, "N·m", "own"))

    with pytest.raises(
        DesignError, match=r"input 'drive' is there already, with 0.3 N·m \(amplitude\); choose"
    ):
        equations_of(mechanism(), (DRIVEN, Own()), inputs=INPUTS)


def test_names_in_expressions_that_are_no_inputs_are_refused_with_their_column() -> None:
    words = (
        r"the torque of joint 'h1': .*column 18: 'bias' is not known; known are .*drive.*the scene's inputs"
    )
    with pytest.raises(ExpressionError, match=words):
        Scene(added=(DRIVEN,), inputs={"drive": Input()})
    with pytest.raises(ExpressionError, match="'bias' is not known"):
        equations_of(mechanism(), (DRIVEN,), inputs={"drive": Input()})  # without a scene too
    with pytest.raises(ExpressionError, match="'angle' is not known"):
        BaseMotion(angle="angle")


def test_an_input_that_no_effect_reads_is_refused_by_name() -> None:
    with pytest.raises(
        DesignError, match="the scene's input 'spare' is read by none of its effects; take it away"
    ):
        Scene(added=(DRIVEN,), inputs={**INPUTS, "spare": Input()})
    scene = Scene(added=(DRIVEN,), inputs=INPUTS)
    with pytest.raises(DesignError, match="'bias' is read by none"):
        replace(scene, added=())
    assert not scene.acting((Gravity(),)).inputs
    assert set(scene.acting((Gravity(), DRIVEN)).inputs) == set(INPUTS)


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: Input(unit="N*mm"), "inputs are in SI units: give 'N·m', and the default times 0.001"),
        (lambda: Input(unit="furlongs per fortnight"), "furlongs"),
        (lambda: Input(unit="degC"), "cannot be used as a unit"),
        (lambda: Input(unit="m^9^9^9"), "is not a unit"),
        (lambda: Input(unit=3), "both must be text"),  # type: ignore[arg-type]
        (lambda: Input(float("nan")), "the default of an input"),
        (lambda: Input("3 bananas"), "bananas"),
        (lambda: Input("3 mm", "V"), "'mm' is not a unit of the default of an input"),
        (lambda: Scene(inputs=[1]), "it must map names to lamc.Input"),  # type: ignore[arg-type]
        (lambda: Scene(inputs={"x": 1.0}), r"input 'x' of a scene is 1.0; make one with lamc.Input"),  # type: ignore[dict-item]
    ],
)
def test_inputs_that_cannot_be_are_refused(make: Any, words: str) -> None:
    with pytest.raises(DesignError, match=words) as caught:
        make()
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("text", "value", "unit"),
    [
        ("3 N*mm", 3e-3, "N·m"),
        ("0.5", 0.5, "1"),
        ("-2e-3 V", -2e-3, "V"),
        ("19.8 mm", 0.0198, "m"),
        ("90 deg/s", np.pi / 2.0, "rad/s"),
        ("60 rpm", 2.0 * np.pi, "rad/s"),
        ("2 kV/mm", 2e6, "V/m"),
        ("1.6 g/cm^3", 1600.0, "kg/m³"),
        ("3 N*mm/deg", 3e-3 * 180.0 / np.pi, "N·m/rad"),
        ("50 percent", 0.5, "1"),
        ("4 Ω", 4.0, "Ω"),
        ("5 kHz", 5000.0, "Hz"),
        ("7 s^-1", 7.0, "1/s"),
    ],
)
def test_numbers_with_units_are_read_in_si(text: str, value: float, unit: str) -> None:
    found, name = measured(text)
    assert found == pytest.approx(value, rel=1e-15)
    assert name == unit
    assert si_unit(unit) == si_unit(name)
    assert si_unit(name).factor == 1.0


# ---- files --------------------------------------------------------------------------------------------------------

FILE = """\
scenes:
  driven:
    effects: {torque: {h1: "drive*sin(t) + 2*level"}}
    inputs:
      drive: 3 N*mm
      level: {default: 40, unit: N*mm, meaning: what the hinge is held against}
  still: {like: driven, effects: {torque: {h1: level}}}
  calm: {like: driven, effects: {gravity: }}
  louder: {like: driven, inputs: {drive: 1 N*m}}
"""


def scene(name: str, text: str = FILE) -> Scene:
    return scene_of_text(text, "s.yaml", name)


def test_scene_files_declare_inputs_in_any_unit() -> None:
    inputs = scene("driven").inputs
    assert inputs["drive"] == Input(3e-3, "N*m")
    assert inputs["level"] == Input(0.04, "N*m", "what the hinge is held against")


def test_a_scene_has_of_the_one_it_is_like_the_inputs_that_its_effects_read() -> None:
    assert set(scene("still").inputs) == {"level"}
    assert not scene("calm").inputs
    assert scene("louder").inputs == {**scene("driven").inputs, "drive": Input(1.0, "N*m")}


def test_scenes_with_inputs_are_written_and_read_again() -> None:
    for name in ("driven", "still", "calm", "louder"):
        made = scene(name)
        again = scene_of_text(json.dumps(scene_data(made)), "s.yaml")
        assert again == made
        assert json.dumps(scene_data(again)) == json.dumps(scene_data(made))


@pytest.mark.parametrize(
    ("said", "reported"),
    [
        ("inputs: {drive: 0 N*foo}", "is not a unit that lamc knows"),
        ("inputs: {t: 0}", "3:15: scene.inputs.t: an input is named 't', which is the time"),
        ("inputs: {h1.x: 0}", "scene.inputs.h1.x: an input is named 'h1.x'; a name is of letters"),
        ("inputs: {drive: {defualt: 0}}", "an input has no field 'defualt'; did you mean 'default'?"),
        ("inputs: {drive: true}", "scene.inputs.drive: an input is True; give"),
        ("inputs: {drive: [1]}", "scene.inputs.drive: an input is [1]; give its default with its unit"),
        ("inputs: {drive: {default: 1 N*m, unit: V}}", "is no number in its unit 'V'; say the unit once"),
        (
            "inputs: {drive: 0, spare: 1}",
            "3:29: scene.inputs.spare: the scene's input 'spare' is read by none",
        ),
        (
            "inputs: {}",
            "2:26: scene.effects.torque.h1: the torque of joint 'h1': expression 'drive*t', column 1",
        ),
        ("inputs: 3", "scene.inputs: "),
    ],
)
def test_inputs_of_files_that_cannot_be_are_refused_at_their_place(said: str, reported: str) -> None:
    text = f"scene:\n  effects: {{torque: {{h1: drive*t}}}}\n  {said}\n"
    with pytest.raises(DesignErrors) as caught:
        scene_of_text(text, "s.yaml")
    assert reported in str(caught.value)
    assert all(str(problem).startswith("s.yaml:") for problem in caught.value.problems)


def test_the_schema_tells_inputs() -> None:
    said = json_schema()["$defs"]["SceneModel"]["properties"]["inputs"]
    plain, whole, over_time = said["additionalProperties"]["anyOf"]
    assert plain == {"type": ["number", "string"], "x-unit": "of the input"}
    assert set(whole["properties"]) == {"default", "unit", "meaning"}
    assert {"csv", "column", "unit", "hold"} <= set(over_time["properties"])


LEAVES = st.one_of(
    st.none(),
    st.booleans(),
    st.integers(-10, 10),
    st.floats(),
    st.text(max_size=12),
    st.sampled_from(["3 N*mm", "1e999", "0 V", "9" * 500, "m^9^9", "3 degC", "1/s", "-", "drive"]),
)
NAMES = st.one_of(
    st.text(max_size=8), st.sampled_from(["drive", "bias", "t", "sin", "default", "unit", "meaning", "x y"])
)
VALUES = st.recursive(
    LEAVES, lambda inner: st.one_of(st.lists(inner, max_size=3), st.dictionaries(NAMES, inner, max_size=3))
)


@given(inputs=st.one_of(st.dictionaries(NAMES, VALUES, max_size=4), VALUES))
@settings(deadline=None, max_examples=tries(300))
def test_any_inputs_of_a_file_are_a_scene_or_errors_with_their_place(inputs: object) -> None:
    text = json.dumps({"scene": {"effects": {"torque": {"h1": "drive*t + bias"}}, "inputs": inputs}})
    reported, made = "", Scene()
    try:
        made = scene_of_text(text, "s.yaml")
    except LamcError as error:
        reported = str(error)
    assert all(line.startswith("s.yaml:") for line in reported.splitlines())
    if reported:
        return
    assert set(made.inputs) == {"bias", "drive"}
    assert scene_of_text(json.dumps(scene_data(made)), "s.yaml") == made


# ---- command line -------------------------------------------------------------------------------------------------

ARM = """\
kind: mechanism
bodies:
  - {name: wall, fixed: true}
  - {name: arm, mass: 2, com: [0.5, 0, 0], inertia: [[0.1, 0, 0], [0, 0.1, 0], [0, 0, 0.1]]}
joints:
  - {name: h, parent: wall, child: arm, point: [0, 0, 0], axis: [0, 0, 1]}
scene:
  effects: {torque: {h: drive}}
  inputs: {drive: {default: 0 N*mm, meaning: command of the controller}}
"""


@needs_cc
def test_a_run_is_told_its_inputs_by_set(tmp_path: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "arm.yaml").write_text(ARM, encoding="utf-8")
    options = ("--t-end", "1", "--json")
    done = CliRunner().invoke(main, ["run", "arm.yaml", *options, "--set", "drive=0.03"])
    assert done.exit_code == 0, done.output
    (angles,) = [np.load(path)["q"] for path in tmp_path.rglob("*.npz")]
    assert angles[-1, 0] == pytest.approx(0.5 * 0.03 / (0.1 + 2 * 0.25), abs=1e-12)  # ½ T/I t²; round-off
    wrong = CliRunner().invoke(main, ["run", "arm.yaml", *options, "--set", "dirve=0.03"])
    assert wrong.exit_code == 2
    assert "did you mean 'drive'" in wrong.output
    without = CliRunner().invoke(main, ["run", "arm.yaml", *options, "--without", "torque", "--out", "o"])
    assert without.exit_code == 0, without.output


def test_scenes_without_inputs_hold_none() -> None:
    inputs: Mapping[str, Input] = Scene().inputs
    assert not inputs
    assert "inputs" not in scene_data(Scene(angles={"h": 0.1}))
    bodies = (Body("ground", fixed=True), Body("link", 1.0, (0.5, 0, 0), np.diag([0.0, 0.1, 0.1])))
    plain = Mechanism(bodies, (Joint("h", "ground", "link"),))
    assert not any(p.is_input for p in equations_of(plain, (Gravity(),)).parameters)
