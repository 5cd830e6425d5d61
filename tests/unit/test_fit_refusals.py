"""What makes no fit is refused by name, with the way out."""

from pathlib import Path

import numpy as np
import pytest

import lamc

T = np.linspace(0.0, 1.0, 51)
ZERO = np.zeros(51)


@pytest.fixture(scope="module")
def design() -> lamc.Design:
    design = lamc.load(Path(__file__).parents[2] / "lamc/examples/pendulum.yaml")
    assert isinstance(design, lamc.Design)
    return design


def moved(**columns: object) -> lamc.Recording:
    return lamc.Recording(T, {"h1": 0.1 * np.sin(T)}, **columns)  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("times", "values", "message"),
    [
        ([0.0, 0.2, 0.1], [0.0, 0.0, 0.0], "time runs backwards in .*from 0.2 to 0.1 s at row 3"),
        ([0.0, 0.2, 0.2], [0.0, 0.0, 0.0], "time stands still"),
        ([0.0, np.nan, 0.2], [0.0, 0.0, 0.0], "row 2 is no finite number"),
        ([0.0, 0.1], [0.0, 0.0, 0.0], "'h1' .* has 3 values, and there are 2 times"),
        ([0.0, 0.1], [0.0, np.inf], "infinite at 0.1 s; gaps are NaN"),
        ([0.0], [0.0], "two or more are needed"),
    ],
)
def test_recordings_that_do_not_fit(times: list[float], values: list[float], message: str) -> None:
    with pytest.raises(lamc.RequestError, match=message):
        lamc.Recording(times, {"h1": values})  # type: ignore[arg-type, dict-item]


@pytest.mark.parametrize(
    ("recording", "free", "message"),
    [
        (moved(), {"h1.stiffnes": None}, "did you mean 'h1.stiffness'"),
        (moved(), {}, "nothing is free"),
        (moved(), {"h1.stiffness": (200.0, 300.0)}, "begins at 100 N·m/rad, outside of its bounds 200 … 300"),
        (moved(), {"h1.stiffness": (3.0, 2.0)}, "runs backwards"),
        (moved(), {"h1.stiffness": (-3.0, 200.0)}, "may not be -3"),
        (moved(), {"h1.stiffness": "many"}, "'h1.stiffness'.*is no range"),
        (moved(), {"link_1.inertia_xx": None}, "'link_1.inertia_xx' changes nothing that was recorded"),
        (moved(parameters={"h1.stiffness": 3.0}), {"h1.stiffness": None}, "it is free; say one of them"),
        (moved(angles={"h9": 0.1}), {"h1.stiffness": None}, "no hinge is named so"),
        (moved(delay=lamc.Free()), {"h1.stiffness": None}, "needs bounds on either side"),
        (
            lamc.Recording(T, {"h7": ZERO}),
            {"h1.stiffness": None},
            "column 'h7', which is nothing of this model",
        ),
        (
            lamc.Recording(T, {"m.x": ZERO}, markers={"m": "link_9@(1,0,0)"}),
            {"h1.stiffness": None},
            "on 'link_9', and there is no such body; did you mean 'link_",
        ),
        (
            lamc.Recording(T, {"m.x": ZERO + 240.0}, markers={"m": "link_1@(1,0,0)"}),
            {"h1.stiffness": None},
            "is this mm or pixels",
        ),
        (
            lamc.Recording(T, {"m.x": ZERO}, markers={"m": "link_1@(3e4,0,0)"}),
            {"h1.stiffness": None},
            r"marker 'm' of .* sits 3e\+04 m from the middle of 'link_1', and the whole device is .* are these mm\?",
        ),
        (
            lamc.Recording(T, {"m.z": ZERO}, markers={"m": "link_1@(1,0,0)"}, camera=lamc.Camera(("x", "z"))),
            {"h1.stiffness": None},
            "its camera tells x and y only",
        ),
        (
            lamc.Recording([0.1, 0.2], {"h1": [0.0, 0.1]}),
            ["h1.stiffness", "h2.stiffness"],
            "there are 2 data, and 2 unknowns",
        ),
        # Of several numbers the first had been taken without a word.
        (
            lamc.Recording(T, {"h1": ZERO}, angles={"h1": "0,5"}),
            {"h1.stiffness": None},
            r"angles.h1': '0,5' is not one number; decimals have a point",
        ),
        (
            lamc.Recording(T, {"h1": ZERO}, gain={"h1": "1,05"}),
            {"h1.stiffness": None},
            r"h1.gain': '1,05' is not one number",
        ),
        (
            lamc.Recording(T, {"h1": ZERO}, delay="0,01"),
            {"h1.stiffness": None},
            r"delay': '0,01' is not one number",
        ),
        (
            lamc.Recording(T, {"h1": ZERO}),
            {"h1.stiffness": "1,5:2,5"},
            r"'h1.stiffness': '1,5' is not one number",
        ),
        (lamc.Recording(T + 50.0, {"h1": ZERO}), ["h1.stiffness"], "begins at 50 s of its clock.*subtract"),
    ],
)
def test_fits_that_cannot_be(
    design: lamc.Design, recording: lamc.Recording, free: object, message: str
) -> None:
    with pytest.raises(lamc.RequestError, match=message):
        lamc.fit(design, recording, free)  # type: ignore[arg-type]


@pytest.mark.parametrize("segments", [0, -1, 2.5, "6", True, 10**9])
def test_segments_are_a_whole_number(design: lamc.Design, segments: object) -> None:
    with pytest.raises(lamc.RequestError, match=r"segments is .*must be a whole number from 1, one run, to"):
        lamc.fit(design, moved(), ["h1.stiffness"], segments=segments)  # type: ignore[arg-type]


def test_an_effect_that_does_not_act_is_named() -> None:
    ground = lamc.Body(name="ground", fixed=True)
    flap = lamc.Body(name="flap", mass=2e-3, com=(0.0, 0.0, -0.02), inertia=np.diag([4e-7, 4e-7, 1e-8]))
    hinge = lamc.Joint(name="h", parent="ground", child="flap", axis=(0.0, 1.0, 0.0))
    mechanism = lamc.Mechanism(name="flap", bodies=(ground, flap), joints=(hinge,))
    recording = lamc.Recording(T, {"h": 0.1 * np.cos(T)}, angles={"h": 0.1})
    with pytest.raises(lamc.RequestError, match=r"the scene has no hinge_damping.*--with hinge_damping"):
        lamc.fit(mechanism, recording, ["h.damping"])


def test_markers_and_cameras_that_are_none() -> None:
    with pytest.raises(lamc.RequestError, match="write BODY@"):
        lamc.Recording(T, {"m.x": ZERO}, markers={"m": "link_1"})
    with pytest.raises(lamc.RequestError, match="left-handed"):
        lamc.Camera(("x", "z", "y"))
    with pytest.raises(lamc.RequestError, match="each must be another"):
        lamc.Camera(("x", "-x"))
    with pytest.raises(lamc.RequestError, match="outside of its bounds"):
        lamc.Free(1.0, 2.0, start=3.0)
    with pytest.raises(lamc.RequestError, match="standard deviation"):
        lamc.Free(prior=(1.0, 0.0))
