"""Motions of a base that jump, or whose rate does, are refused; smooth ones pass, however they are written."""

import numpy as np
import pytest

import lamc
from lamc.export import files_of
from lamc.readers.load_scene import scene_of_text
from lamc.symbolic.kinks import first_kink
from tests.support.ctools import needs_cc
from tests.support.mechanisms import chain

INSTANTS = 1001


@pytest.mark.parametrize(
    ("text", "t_end", "t", "jump", "order"),
    [
        ("0.5*min(t, 0.05)", 0.2, 0.05, 0.5, 1),  # a ramp that stops dead
        ("abs(t - 0.05)", 0.1, 0.05, 2.0, 1),
        ("abs(sin(2*pi*50*t))", 10.0, 0.01, 200.0 * np.pi, 1),  # its kinks are 1000 even instants apart
        ("sqrt((t - 0.05)^2)", 0.1, 0.05, 2.0, 1),  # a kink without a name, and no rate in it
        ("asin(sin(t))", 9.0, np.pi / 2, 2.0, 1),  # the rate is 0/0 in round-off nearby
        ("sign(t - 0.033)", 0.1, 0.033, 2.0, 0),
    ],
)
def test_kinks_are_found_with_their_size(text: str, t_end: float, t: float, jump: float, order: int) -> None:
    found = first_kink(text, {}, t_end, INSTANTS)
    assert found is not None
    assert found.order == order
    # 1e-7 s is beyond what is left of an interval; near 0/0 the rate is known to 1e-2 only, as its cosine is 1e-8 there
    assert found.t == pytest.approx(t, abs=1e-7)
    assert found.jump == pytest.approx(jump, rel=1e-2)


@pytest.mark.parametrize(
    ("text", "t_end"),
    [
        ("0.01*sin(2*pi*50*t)", 10.0),
        ("max(0, t - 0.05)^2", 0.1),  # only its acceleration jumps, as a force does
        ("abs(t - 0.05)*(t - 0.05)", 0.1),
        ("abs(sin(2*pi*50*t))^2", 10.0),
        ("abs(sin(2*pi*5000*t))^3", 10.0),
        ("sqrt((t - 0.05)^2 + 1e-8)", 0.1),
        ("sqrt(sin(t)^2 + cos(t)^2)", 10.0),  # its rate is round-off
        ("abs(t)", 1.0),
        ("abs(t - 1)", 1.0),  # at the end, and never after
        ("t^2.5", 3.0),
    ],
)
def test_what_is_smooth_passes(text: str, t_end: float) -> None:
    assert first_kink(text, {}, t_end, INSTANTS) is None


def test_an_input_moves_the_kink_out_of_the_run() -> None:
    assert first_kink("max(0, t - late)", {"late": 0.5}, 1.0, INSTANTS) is not None
    assert first_kink("max(0, t - late)", {"late": 2.0}, 1.0, INSTANTS) is None


@needs_cc
def test_a_base_that_stops_dead_is_refused_and_not_simulated_without_the_blow() -> None:
    ramp = lamc.BaseMotion(displacement=("0.5*min(t, 0.05)", 0, 0))
    sim = lamc.compile(chain(1), lamc.Scene(effects=(ramp,)))
    with pytest.raises(
        lamc.ExpressionError,
        match=r"x displacement of base_motion: .* kink at t = 0\.05 s, .* its rate jumps by 0\.5",
    ):
        sim.run(t_end=0.2)
    assert sim.run(t_end=0.04).success


@needs_cc
@pytest.mark.parametrize("to", ["c", "fmu", "wasm", "wheel"])
def test_exports_refuse_such_a_base_in_the_words_of_a_run(to: str) -> None:
    text = "effects:\n  - base_motion: {displacement: ['0.5*min(t, 0.05)', 0, 0]}\nduration: 0.2\n"
    scene = scene_of_text(text, "scene.yaml")
    with pytest.raises(lamc.ExpressionError) as of_a_run:
        lamc.compile(chain(1), scene).run(t_end=0.2)
    with pytest.raises(lamc.ExpressionError) as of_an_export:
        files_of(chain(1), to, scene)
    assert str(of_an_export.value) == str(of_a_run.value)
    assert "scene.yaml:2" in str(of_an_export.value)


@pytest.mark.slow
@needs_cc
def test_exports_say_until_when_a_base_is_known_to_move_smoothly() -> None:
    ramp = lamc.BaseMotion(displacement=("0.5*min(t, 0.05)", 0, 0))
    files = files_of(chain(1), "c", lamc.Scene(effects=(ramp,), duration=0.04))
    assert b"no jump and no kink until t = 0.04 s" in files["chain1.h"]
    assert b"kink" not in files_of(chain(1), "c", lamc.Scene())["chain1.h"]
