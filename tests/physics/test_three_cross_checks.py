"""Generated C, interpreter and numeric cross-check on the same mechanisms, through the public API."""

import json
import math
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

import lamc
from lamc.effects import Gravity, Torque
from lamc.records.mechanism import Mechanism
from lamc.records.scene import Scene
from lamc.reference import check
from lamc.reference.interpreter import Interpreter
from lamc.reference.newton_euler import NewtonEuler
from tests.support.mechanisms import (
    ALL_PASSIVE,
    chain,
    from_reference,
    random_state,
    random_tree,
    trees,
    unit_plate_pendulum,
)
from tests.support.quick import tries

SCENE = Scene(effects=(*ALL_PASSIVE, Torque({"h0": "0.3*sin(2*pi*t) - 0.2*rate*abs(rate) + angle^2"})))


def compare(mechanism: Mechanism, seed: int) -> None:
    """The issue's limits: 1e-12 between C and interpreter, 1e-10 to the independent formulation."""
    sim = lamc.compile(mechanism, SCENE)
    interpreter = Interpreter(sim.program)
    newton = NewtonEuler(mechanism, sim.effects, sim.joints)
    constants = interpreter.constants()
    for k in range(3):
        q, u = random_state(len(sim.joints), seed + k)
        found = sim.acceleration(q, u, 0.3)
        size = np.abs(found).max()
        assert np.abs(found - interpreter.acceleration(0.3, q, u, constants)).max() <= 1e-12 * size
        assert np.abs(found - newton.acceleration(q, u, 0.3)).max() <= 1e-10 * size


@pytest.mark.slow
@settings(max_examples=tries(15), deadline=None, suppress_health_check=[HealthCheck.too_slow])
@given(mechanism=trees(30), seed=st.integers(0, 2**31))
def test_three_cross_checks_agree_on_random_trees(mechanism: Mechanism, seed: int) -> None:
    compare(mechanism, seed)


@pytest.mark.campaign
@settings(max_examples=300, deadline=None, suppress_health_check=[HealthCheck.too_slow])
@given(mechanism=trees(30), seed=st.integers(0, 2**31))
def test_three_cross_checks_agree_on_many_random_trees(mechanism: Mechanism, seed: int) -> None:
    compare(mechanism, seed)


@pytest.mark.parametrize(("kind", "n"), [("parallel", 45), ("laminate", 20)])
@pytest.mark.quick("laminate-20")
def test_three_cross_checks_agree_where_the_c_is_laid_out_in_loops(kind: str, n: int) -> None:
    compare(random_tree(n, seed=n, kind=kind), seed=1)


def test_check_of_a_compiled_mechanism_passes() -> None:
    report = check(lamc.compile(random_tree(5, seed=11, kind="mixed"), SCENE), states=5, t_end=0.3)
    assert report.passed, report.table()


def test_unit_plates_of_the_paper_fold_as_published() -> None:
    mechanism, scene = unit_plate_pendulum()
    sim = lamc.compile(mechanism, scene)
    result = sim.run(t_end=0.5, rtol=1e-11, atol=1e-13, t_eval=[0.5])
    expected = {"h0": 0.3479767274690896, "h1": 0.1416890662362707, "h2": 0.03314863340808915}
    for joint, angle in expected.items():
        assert abs(result.angle(joint)[0] - angle) < 1e-9  # the limit that the values are given for


@pytest.mark.parametrize(
    ("case", "last", "rtol", "accept"),
    [
        ("double_pendulum", 1.0, 1e-6, 1e-4),
        ("double_pendulum", 3.0, 1e-9, 1e-4),
        ("mass_ratio", 9.0, 1e-6, 1e-4),
        ("mass_ratio", 9.0, 1e-9, 1e-6),
        ("triple_stiff_e2", 9.0, 1e-6, 1e-4),
        ("triple_stiff_e2", 9.0, 1e-9, 1e-6),
    ],
)
def test_reference_cases_are_met_within_what_they_accept(
    shared: Path, case: str, last: float, rtol: float, accept: float
) -> None:
    cases = {c["id"]: c for c in json.loads((shared / "reference" / "dynamics.json").read_text())["cases"]}
    mechanism, scene = from_reference(cases[case]["spec"])
    rows = [
        (e, t) for e, t in zip(cases[case]["expected"], cases[case]["tol"], strict=True) if e["t"] <= last
    ]
    sim = lamc.compile(mechanism, scene)
    times = [float(e["t"]) for e, _ in rows]
    result = sim.run(t_end=times[-1], rtol=rtol, atol=1e-2 * rtol, t_eval=times)
    for k, (expected, tol) in enumerate(rows):
        for joint, angle in expected["theta"].items():
            difference = math.remainder(result.angle(joint)[k] - angle, 2 * math.pi)
            assert abs(difference) <= max(tol, accept)  # the file's own rule
    if rtol == 1e-9:
        drift = np.abs(result.energy - result.energy[0]).max()
        assert drift <= 1e-7 * np.abs(result.energy[0])  # the file's own rule


def test_undriven_undamped_chain_keeps_its_energy() -> None:
    mechanism = chain(3, "space", seed=5)
    scene = Scene(effects=(Gravity((0.0, 0.0, -9.81)),), angles={"h0": 1.0, "h2": -0.5})
    result = lamc.compile(mechanism, scene).run(
        t_end=100.0, rtol=1e-11, atol=1e-13, t_eval=np.linspace(0, 100, 201)
    )
    assert result.success
    kinetic_and_gravity = result.energy
    scale = np.abs(kinetic_and_gravity).max()
    assert np.abs(kinetic_and_gravity - kinetic_and_gravity[0]).max() < 1e-9 * scale  # the limit
