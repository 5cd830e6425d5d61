"""Loops against another formulation: closure by products of exponentials along short cycles, in the angles of all
hinges. It knows neither the tree nor its frames."""

from collections import Counter
from pathlib import Path

import numpy as np
import pytest

import lamc
from lamc.examples.miura import miura
from lamc.mechanism.plan import plan
from lamc.readers.load import load_text
from lamc.records.mechanism import Mechanism
from lamc.symbolic.evaluate import evaluate
from lamc.symbolic.program import Space
from lamc.symbolic.staging import Store
from tests.support.ctools import needs_cc
from tests.support.cycle_closure import CycleClosure, close_cycle
from tests.support.short_cycles import Edge, Kind, short_cycles, shortest_basis

EXAMPLES = Path(lamc.__file__).parent / "examples"
LOOPS = (
    "bricard",
    "five_bar",
    "folding_box",
    "four_bar",
    "sarrus",
    "six_bar",
    "two_loops",
    "vertex",
    "waterbomb",
)


def mechanism_of(name: str) -> Mechanism:
    design = load_text(miura(3, 3), "miura") if name == "miura" else lamc.load(EXAMPLES / f"{name}.yaml")
    return design if isinstance(design, Mechanism) else lamc.split(design)


@pytest.mark.parametrize(
    ("name", "kinds"),
    [
        ("four_bar", {(Kind.PLANAR, 4): 1}),
        ("six_bar", {(Kind.PLANAR, 4): 2}),
        ("bricard", {(Kind.SPATIAL, 6): 1}),
        ("waterbomb", {(Kind.SPHERICAL, 6): 1}),
        ("folding_box", {(Kind.SPHERICAL, 5): 4}),
        ("miura", {(Kind.SPHERICAL, 4): 4}),
    ],
)
def test_cycles_are_those_that_the_drawing_shows(name: str, kinds: dict[tuple[Kind, int], int]) -> None:
    cycles = short_cycles(plan(mechanism_of(name)))
    assert Counter((cycle.kind, len(cycle.joints)) for cycle in cycles) == kinds


def test_a_basis_is_as_short_as_can_be() -> None:
    """A square net of 4 × 4 nodes has nine faces; a ring of 20 with a chord across has cycles of 11."""
    net = [Edge(4 * i + j, 4 * i + j + 1) for i in range(4) for j in range(3)]
    net += [Edge(4 * i + j, 4 * i + j + 4) for i in range(3) for j in range(4)]
    assert [len(ring) for ring in shortest_basis(net, range(len(net)))] == [4] * 9
    ring = [Edge(k, (k + 1) % 20) for k in range(20)] + [Edge(0, 10)]
    assert [len(way) for way in shortest_basis(ring, range(21))] == [11, 11]


@needs_cc
@pytest.mark.parametrize("name", [*LOOPS, "miura"])
@pytest.mark.quick("five_bar", "four_bar", "sarrus", "six_bar", "two_loops", "vertex", "waterbomb")
def test_positions_rates_and_accelerations_close_the_cycles(name: str) -> None:
    mechanism = mechanism_of(name)
    sim = lamc.compile(mechanism)
    tree = plan(mechanism)
    joints = [link.joint for link in tree.links] + [cut.joint for cut in tree.cuts]
    store = Store()
    q = [store.symbol(f"q{i}", Space.ANGLE, i) for i in range(len(joints))]
    u = [store.symbol(f"u{i}", Space.RATE, i) for i in range(len(joints))]
    closed = [close_cycle(store, cycle, joints, mechanism.size, q, u) for cycle in short_cycles(tree)]
    result = sim.run(0.4, rtol=1e-10, atol=1e-12, t_eval=[0.1, 0.2, 0.3, 0.4])
    angles = np.column_stack([result.angle(joint.name) for joint in joints])
    rates = np.column_stack([result.rate(joint.name) for joint in joints])
    tree_accelerations = result.motion.accelerations(result.t, np.hstack([result.q, result.u]))
    for row in range(len(result.t)):
        values = dict(zip((*q, *u), (*angles[row], *rates[row]), strict=True))
        residual, jacobian, bias = numbers(closed, store, values)
        # Round-off of a projection on other equations of the same closure; rates are some rad/s, accelerations 1e3.
        assert np.abs(residual).max() < 1e-12
        assert np.abs(jacobian @ rates[row]).max() < 1e-11 * max(1.0, np.abs(rates[row]).max())
        known = jacobian[:, : len(tree.links)] @ tree_accelerations[row] + bias
        at_cuts = jacobian[:, len(tree.links) :]
        missed = known - at_cuts @ np.linalg.lstsq(at_cuts, known, rcond=None)[0]
        assert np.abs(missed).max() < 1e-10 * max(1.0, np.abs(tree_accelerations[row]).max())
        values_of = np.linalg.svd(jacobian, compute_uv=False)
        assert int((values_of > 1e-9 * values_of[0]).sum()) == sim.loops.rank


def numbers(
    closed: list[CycleClosure], store: Store, values: dict[object, float]
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Residual (m,), Jacobian (m, n) and bias (m,) of all cycles."""
    width = len(values) // 2
    residual = evaluate(store, [v for each in closed for v in each.residual], values)  # type: ignore[arg-type]
    bias = evaluate(store, [v for each in closed for v in each.bias], values)  # type: ignore[arg-type]
    rows = [row for each in closed for row in each.jacobian]
    jacobian = np.zeros((len(rows), width))
    for k, row in enumerate(rows):
        entries = evaluate(store, [entry for _, entry in row], values)  # type: ignore[arg-type]
        jacobian[k, [joint for joint, _ in row]] = entries
    return np.array(residual), jacobian, np.array(bias)
