"""What a name of a study is given: angles without a unit that are more than a turn are told."""

import warnings

import numpy as np
import pytest

from lamc.basics.errors import DesignWarning
from lamc.studies.axes import axis_of


@pytest.mark.parametrize(
    "given",
    ["20:60:3", "20,60", "60", 60.0, [20.0, 60.0], np.array([20.0, 60.0]), "log:1:60:3", "uniform(20, 60)"],
)
def test_degrees_without_their_unit_are_told(given: object) -> None:
    with pytest.warns(DesignWarning, match=r"'angles\.h1' is given is 60 rad, 9\.55 turns"):
        axis_of("angles.h1", given, "rad")


@pytest.mark.parametrize(
    ("given", "unit"),
    [
        ("20deg:60deg:3", "rad"),
        ("1000 deg", "rad"),
        ("normal(700 deg, 1 deg)", "rad"),
        ("-3:3:9", "rad"),
        (["20 deg", "1000 deg"], "rad"),
        ("20:60:3", "rad/s"),
        ("20:60:3", "m"),
    ],
)
def test_others_are_not(given: object, unit: str) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        axis_of("x", given, unit)
