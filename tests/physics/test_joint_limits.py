"""Limits of joint angles against independently computed motion: a stop that yields, and one that bounces."""

import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import lamc
from lamc import Body, Gravity, Joint, JointLimits, Mechanism, Scene
from lamc.basics.errors import DesignError, RequestError
from tests.support.ctools import needs_cc

pytestmark = needs_cc

LOWER = -0.2  # rad
SWITCHES, IMPACTS = "contact_switch_times", "impact_times"


@pytest.fixture(scope="module")
def cases(shared: Path) -> dict[str, Any]:
    text = (shared / "reference" / "dynamics.json").read_text(encoding="utf-8")
    return {case["id"]: case for case in json.loads(text)["cases"]}


def plate() -> Mechanism:
    """0.1 m and 0.01 kg, hinged at its upper edge, drawn hanging; no upper limit that it could reach."""
    length, mass = 0.1, 0.01
    moment = mass * length**2 / 12
    body = Body("plate", mass, (0.0, -length / 2, 0.0), np.diag([moment, moment, moment]))
    hinge = Joint("h", "wall", "plate", axis=(0.0, 0.0, 1.0), limits=(LOWER, 10.0))
    return Mechanism((Body("wall", fixed=True), body), (hinge,))


def released(limits: JointLimits, angle: float = math.pi / 2) -> lamc.Simulator:
    scene = Scene(effects=(Gravity((0.0, -9.81, 0.0)), limits), angles={"h": angle})
    return lamc.compile(plate(), scene)


@pytest.mark.parametrize(
    ("case_id", "limits", "times"),
    [
        ("joint_limit_penalty_elastic", JointLimits(stiffness=50.0, damping=0.0), SWITCHES),
        ("joint_limit_restitution", JointLimits(restitution=0.6), IMPACTS),
    ],
)
@pytest.mark.parametrize("integrator", ["auto", "rk45"])
def test_a_plate_swings_against_its_stop_as_computed_independently(
    cases: dict[str, Any], case_id: str, limits: JointLimits, times: str, integrator: str
) -> None:
    case = cases[case_id]
    rows = case["expected"]["states"]
    result = released(limits).run(
        t_end=rows[-1]["t"], rtol=1e-11, atol=1e-13, t_eval=[row["t"] for row in rows], integrator=integrator
    )
    assert result.success, result.message
    tol = case["tol"]
    np.testing.assert_allclose(result.angle("h"), [row["theta"] for row in rows], rtol=0, atol=tol)
    # The tolerance is for angles; rates reach 17 rad/s where angles reach 1.6 rad.
    np.testing.assert_allclose(result.rate("h"), [row["thetadot"] for row in rows], rtol=0, atol=10 * tol)
    expected = [t for t in case["expected"][times] if t <= rows[-1]["t"]]
    # An angle of 1e-8 rad is passed in 1e-8 s at the lowest rate of these passages, 1 rad/s.
    np.testing.assert_allclose([event.t for event in result.events], expected, rtol=0, atol=tol)


def test_a_start_beyond_a_limit_is_refused() -> None:
    sim = released(JointLimits(stiffness=50.0), angle=LOWER - 0.1)
    with pytest.raises(DesignError, match=r"joint 'h' starts at -0\.3 rad, outside its limits \(-0\.2, 10\)"):
        sim.run(t_end=0.1)


def test_a_start_on_a_limit_is_accepted() -> None:
    assert released(JointLimits(stiffness=50.0), angle=LOWER).run(t_end=0.1).success


@pytest.mark.parametrize("restitution", [2.0, 0.0, -1.0])
def test_a_run_cannot_change_the_restitution_to_what_nature_forbids(restitution: float) -> None:
    sim = released(JointLimits(restitution=0.5))
    with pytest.raises(RequestError, match=r"a restitution must be above zero and at most 1"):
        sim.run(t_end=0.1, parameters={"joint_limits.restitution": restitution})


@pytest.mark.parametrize("limits", [JointLimits(stiffness=50.0), JointLimits(restitution=0.5)])
def test_a_run_cannot_move_a_limit_beyond_the_start(limits: JointLimits) -> None:
    sim = released(limits)
    with pytest.raises(DesignError, match=r"joint 'h' starts at 1\.571 rad, outside its limits \(2, 10\)"):
        sim.run(t_end=0.1, parameters={"h.lower_limit": 2.0})
    with pytest.raises(RequestError, match=r"\(11, 10\) rad; the lower must be below the upper"):
        sim.run(t_end=0.1, parameters={"h.lower_limit": 11.0})
    result = sim.run(t_end=0.5, parameters={"h.lower_limit": 0.5})
    assert result.angle("h")[result.t == result.events[0].t] == pytest.approx(0.5, abs=1e-9)
