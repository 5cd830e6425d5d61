"""The validation case of the popupCAD papers, from popupCAD's own file to hinge angles."""

import json

import numpy as np
import pytest

import lamc
from tests.support.paths import FIXTURES


@pytest.fixture(scope="module")
def expected() -> dict[str, object]:
    cases = json.loads((FIXTURES / "reference" / "dynamics.json").read_text())["cases"]
    return next(c for c in cases if c["id"] == "popupcad_pendulum")


def test_popupcad_pendulum_swings_as_computed_from_its_geometry_alone(expected: dict[str, object]) -> None:
    sim = lamc.compile(lamc.load(FIXTURES / "designs" / "popupcad" / "pendulum.cad"))
    rows = expected["expected"]
    assert isinstance(rows, list)
    result = sim.run(t_end=10.0, rtol=1e-11, atol=1e-13, t_eval=[row["t"] for row in rows])
    assert result.success
    # The reference counts angles positive where the far link goes down; the third line is drawn the other way.
    angles = result.q * np.array([1.0, 1.0, -1.0])
    assert (
        np.abs(angles - [row["angle"] for row in rows]).max() < 1e-12
    )  # some ten times rtol; the reference states 1e-9


def test_popupcad_pendulum_weighs_what_its_polygons_say(expected: dict[str, object]) -> None:
    mechanism = lamc.split(lamc.load(FIXTURES / "designs" / "popupcad" / "pendulum.cad"))
    masses = [b.mass for b in mechanism.bodies if not b.fixed]
    assert np.allclose(masses, expected["masses"], rtol=0.0, atol=1e-12)  # the limit for masses
