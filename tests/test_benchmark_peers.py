"""The peers that benchmarks compare with are right: a peer that is fast and wrong would prove nothing."""

import ctypes
import shutil

import numpy as np
import pytest

from benchmarks.devices import CROSSED, SCENE, plates
from benchmarks.peers import hand, kane_lambdify
from lamc.reference.newton_euler import NewtonEuler
from lamc.reference.sympy_kane import kane
from tests.mechanisms import ALL_PASSIVE, random_state, random_tree


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


def test_lambdified_forms_agree_with_newton_euler() -> None:
    mechanism = plates(3, CROSSED)
    model = kane(mechanism, SCENE.effects or ())
    q, u = random_state(3, seed=1)
    expected = NewtonEuler(mechanism, SCENE.effects or ()).acceleration(q, u)
    peers = [kane_lambdify.build(model), *(kane_lambdify.build_textbook(model, cse) for cse in (False, True))]
    for peer in peers:
        found = peer.acceleration(q, u, 0.0)
        assert np.abs(found - expected).max() < 1e-12 * np.abs(expected).max()  # round-off of some 1e3 terms
