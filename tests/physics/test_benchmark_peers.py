"""The peers that benchmarks compare with are right: a peer that is fast and wrong would prove nothing."""

import ctypes
import json
import shutil
from pathlib import Path

import numpy as np
import pytest

import lamc
from benchmarks.devices import CROSSED, SCENE, plates
from benchmarks.hard_cases import undamped
from benchmarks.meshers import ANGLE, Case, cases, measured
from benchmarks.peers import ccx_peer, closed_triple, hand, kane_lambdify
from lamc import plate
from lamc.reference.newton_euler import NewtonEuler
from lamc.reference.sympy_kane import kane
from tests.support.ctools import needs_cc
from tests.support.mechanisms import ALL_PASSIVE, random_state, random_tree


@pytest.fixture(scope="module")
def library(tmp_path_factory: pytest.TempPathFactory) -> ctypes.CDLL:
    if shutil.which("cc") is None:
        pytest.skip("there is no C compiler named cc")
    return hand.compile_library(tmp_path_factory.mktemp("hand"))


@pytest.mark.parametrize(("kind", "planar"), [("parallel", True), ("parallel", False), ("space", False)])
def test_hand_written_recursion_agrees_with_newton_euler(
    library: ctypes.CDLL, kind: str, planar: bool
) -> None:
    for n in (1, 2, 7, 20):
        mechanism = random_tree(n, seed=n, kind=kind)
        joints = tuple(j.name for j in mechanism.joints)
        peer = hand.HandRecursion(library, mechanism, ALL_PASSIVE, joints, planar)
        q, u = random_state(n, seed=n)
        expected = NewtonEuler(mechanism, ALL_PASSIVE, joints).acceleration(q, u)
        # 1e-11: two solutions of systems with condition numbers up to some 1e4
        assert np.abs(peer.acceleration(q, u) - expected).max() < 1e-11 * np.abs(expected).max()


def test_hand_written_integrator_folds_the_papers_plates_as_published(library: ctypes.CDLL) -> None:
    peer = hand.HandRecursion(library, plates(3), SCENE.effects or (), ("h0", "h1", "h2"))
    angles, _ = peer.run(np.zeros(3), np.zeros(3), 0.5, 1e-11, 1e-13)
    # 1e-9: the limit the published values are given for
    assert np.abs(angles - [0.3479767274690896, 0.1416890662362707, 0.03314863340808915]).max() < 1e-9


@needs_cc
@pytest.mark.parametrize("textbook", [False, True])
def test_closed_form_of_the_triple_pendulum_agrees_with_newton_euler(tmp_path: Path, textbook: bool) -> None:
    peer = closed_triple.ClosedTriple(tmp_path, textbook=textbook)
    cross_check = NewtonEuler(plates(3), SCENE.effects or (), ("h0", "h1", "h2"))
    q, u = random_state(3, seed=5)
    expected = cross_check.acceleration(q, u)
    # 1e-12: round-off of some 50 operations, times the condition of M, below 100
    assert np.abs(peer.accelerations(q[None], u[None])[0] - expected).max() < 1e-12 * np.abs(expected).max()
    angles, steps = peer.run(0.5, 1e-11, 1e-13)
    # 1e-9: the limit the published values are given for
    assert np.abs(angles[:3] - [0.3479767274690896, 0.1416890662362707, 0.03314863340808915]).max() < 1e-9
    assert steps > 100


def test_casadi_and_cvodes_fold_the_papers_plates_as_published() -> None:
    pytest.importorskip("casadi")
    from benchmarks.peers import casadi_peer

    angles = casadi_peer.CasadiTriple(casadi_peer.BDF).angles(np.array([0.5]), 1e-11, 1e-13)[0]
    # 1e-8: what CVODES' BDF makes of a tolerance of 1e-11 in some thousand steps
    assert np.abs(angles - [0.3479767274690896, 0.1416890662362707, 0.03314863340808915]).max() < 1e-8


@pytest.mark.slow
def test_lambdified_forms_agree_with_newton_euler() -> None:
    mechanism = plates(3, CROSSED)
    model = kane(mechanism, SCENE.effects or ())
    q, u = random_state(3, seed=1)
    expected = NewtonEuler(mechanism, SCENE.effects or ()).acceleration(q, u)
    peers = [kane_lambdify.build(model), *(kane_lambdify.build_textbook(model, cse) for cse in (False, True))]
    for peer in peers:
        found = peer.acceleration(q, u, 0.0)
        assert np.abs(found - expected).max() < 1e-12 * np.abs(expected).max()  # round-off of some 1e3 terms


def test_mujoco_moves_the_four_bar_as_lamc_does(shared: Path) -> None:
    """Two engines that share nothing but the record: how far their constraints let them agree."""
    pytest.importorskip("mujoco")
    from benchmarks.peers import mujoco_peer

    text = (shared / "reference" / "dynamics.json").read_text(encoding="utf-8")
    (case,) = (c for c in json.loads(text)["cases"] if c["id"] == "fourbar_crank")
    mechanism, scene = undamped(case["spec"])
    sim = lamc.compile(mechanism, scene)
    start = sim.run(0.0, t_eval=[0.0])
    angles = {joint.name: float(start.angle(joint.name)[0]) for joint in mechanism.joints}
    rates = {joint.name: float(start.rate(joint.name)[0]) for joint in mechanism.joints}
    peer = mujoco_peer.MujocoPeer(mechanism, sim.cut_joints, case["spec"]["gravity"], mujoco_peer.STIFFEST)
    run = peer.run(angles, rates, 0.2, 2)
    result = sim.run(0.2, rtol=1e-10, atol=1e-12)
    # A constraint of two steps' time constant yields by some 1e-6 of the size, and its work by as much.
    assert run.gap < 1e-5 * mechanism.size
    assert np.abs(run.energy - run.energy[0]).max() < 1e-5 * result.energies["kinetic"].max()
    for name, angle in zip(peer.tree, run.angles, strict=True):
        assert angle == pytest.approx(result.angle(name)[-1], abs=1e-4)


def test_morley_triangles_of_scikit_fem_hold_the_energy_of_a_cylinder() -> None:
    """w = x²/2 has curvature one all over: wᵀKw is the area, 6; tilting and lifting cost nothing."""
    peer = pytest.importorskip("benchmarks.peers.skfem_peer")
    mesh = plate.grid(2.0, 3.0, 4, 5)
    made = peer.MorleyPlate(mesh.points, mesh.cells, 0.3)
    matrix = made.assemble()
    bent = made.basis.project(lambda x: x[0] ** 2 / 2)
    tilted = made.basis.project(lambda x: 1 + 2 * x[0] - x[1])
    # 1e-10: the projection onto the basis is solved with a condition of some 1e4
    assert bent @ matrix @ bent == pytest.approx(6.0, rel=1e-10)
    assert abs(tilted @ matrix @ tilted) < 1e-10


def test_calculix_bends_the_clamped_square(tmp_path: Path) -> None:
    """Within 3 % of the table on 20 by 20 squares, and nearer there than on 10 by 10."""
    if not ccx_peer.is_there():
        pytest.skip("CalculiX (ccx) is not installed")
    case = ccx_peer.Plate()
    errors = [abs(ccx_peer.run(case, squares, tmp_path)[1] / case.expected - 1) for squares in (10, 20)]
    assert errors[1] < 0.03
    assert errors[1] < errors[0]


@pytest.mark.parametrize("case", cases(), ids=lambda case: case.name)
def test_meshers_are_asked_to_fill_the_same_outlines(case: Case) -> None:
    """Whatever meshers are installed fill the outline with triangles, and lamc's keep their angle."""
    rows = measured(case, 0.1, 1)
    assert rows[0].mesher == "lamc"
    assert rows[0].least_angle >= ANGLE - 1e-9  # round-off of the angle
    assert all(abs(row.covered) < 1e-9 for row in rows)  # borders are straight: round-off of sums of areas
