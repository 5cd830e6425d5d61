"""Frequencies, damping and shapes against closed forms and against runs."""

import math
import pickle
from itertools import pairwise

import numpy as np
import pytest
import scipy.linalg

import lamc
from lamc import Body, Gravity, HingeDamping, HingeStiffness, Joint, Mechanism, Scene
from lamc.commands.examples import mechanism_of_example
from lamc.examples import find
from tests.support.ctools import needs_cc
from tests.support.floating import with_base
from tests.support.mechanisms import chain

pytestmark = needs_cc

Z = (0.0, 0.0, 1.0)
G = 9.81
EXACT = 1e-11  # relative: eigenvalues of exact derivatives, with room for round-off of a few operations


def oscillator(stiffness: float, damping: float, *, hangs: bool = False) -> lamc.Simulator:
    """I q'' + c q' + k q = 0 with I = 0.19 kg·m²."""
    body = Body("bar", 2.0, (0.3, 0.0, 0.0), np.diag([1e-3, 1e-2, 1e-2]))
    pin = Joint("pin", "wall", "bar", axis=Z, stiffness=stiffness, damping=damping)
    gravity = (Gravity((-G, 0.0, 0.0)),) if not hangs else (Gravity((G, 0.0, 0.0)),)
    effects = (HingeStiffness(), HingeDamping()) if stiffness else gravity
    return lamc.compile(Mechanism((Body("wall", fixed=True), body), (pin,)), Scene(effects=effects))


def test_a_damped_hinge_has_the_frequency_and_the_damping_ratio_of_its_equation() -> None:
    k, c, inertia = 5.0, 0.1, 0.19
    (mode,) = oscillator(k, c).modes().modes
    assert mode.kind == "vibration"
    assert mode.angular_frequency == pytest.approx(math.sqrt(k / inertia), rel=EXACT)
    assert mode.frequency == pytest.approx(math.sqrt(k / inertia) / (2.0 * math.pi), rel=EXACT)
    ratio = c / (2.0 * math.sqrt(k * inertia))
    assert mode.damping == pytest.approx(ratio, rel=EXACT)
    assert mode.damped_frequency == pytest.approx(mode.frequency * math.sqrt(1.0 - ratio**2), rel=EXACT)
    assert oscillator(k, c).modes(damping=False)[0].damping == 0.0


def test_more_than_critical_damping_gives_two_decays() -> None:
    k, c, inertia = 5.0, 4.0, 0.19
    found = oscillator(k, c).modes()
    assert [mode.kind for mode in found.modes] == ["decay", "decay"]
    roots = np.sort(np.roots([inertia, c, k]).real)[::-1]
    assert [mode.eigenvalue.real for mode in found.modes] == pytest.approx(roots, rel=EXACT)


def test_what_stands_on_its_head_grows() -> None:
    sim = oscillator(0.0, 0.0)
    (mode,) = sim.modes(sim.equilibrium({"pin": 0.1})).modes
    assert mode.kind == "growth"
    assert mode.eigenvalue == pytest.approx(math.sqrt(2.0 * G * 0.3 / 0.19), rel=EXACT)
    (hanging,) = oscillator(0.0, 0.0, hangs=True).modes().modes
    assert hanging.angular_frequency == pytest.approx(math.sqrt(2.0 * G * 0.3 / 0.19), rel=EXACT)


def test_a_double_pendulum_has_the_modes_of_its_mass_and_stiffness_matrices() -> None:
    """Two points on rods: relative angles, M and K of the textbook."""
    l1, l2, m1, m2, small = 0.4, 0.3, 0.5, 0.2, 1e-5
    bodies = (
        Body("wall", fixed=True),
        Body("upper", m1, (0.0, -l1, 0.0), small * np.eye(3)),
        Body("lower", m2, (0.0, -l1 - l2, 0.0), small * np.eye(3)),
    )
    joints = (
        Joint("top", "wall", "upper", axis=Z),
        Joint("elbow", "upper", "lower", point=(0.0, -l1, 0.0), axis=Z),
    )
    sim = lamc.compile(Mechanism(bodies, joints), Scene(effects=(Gravity((0.0, -G, 0.0)),)))
    inner = m2 * l2**2 + small
    outer = m1 * l1**2 + small + m2 * (l1 + l2) ** 2 + small
    coupled = m2 * l2 * (l1 + l2) + small
    mass = np.array([[outer, coupled], [coupled, inner]])
    stiffness = G * np.array([[m1 * l1 + m2 * (l1 + l2), m2 * l2], [m2 * l2, m2 * l2]])
    squares, vectors = scipy.linalg.eigh(stiffness, mass)
    found = sim.modes()
    assert found.angular_frequencies == pytest.approx(np.sqrt(squares), rel=EXACT)
    for mode, vector in zip(found.modes, vectors.T, strict=True):
        most = vector[np.abs(vector).argmax()]
        assert mode.shape == pytest.approx(vector / most, abs=1e-10)
        assert mode.is_standing
        assert max(abs(value) for value in mode.amplitudes.values()) == 1.0


def test_a_loop_rings_at_its_frequency_and_dies_away_by_its_damping() -> None:
    """Crossings of a small free motion, against the mode; its amplitude changes the period by its square."""
    sim = lamc.compile(mechanism_of_example(find("four_bar")))
    point = sim.equilibrium()
    (mode,) = sim.modes(point).modes
    start = lamc.Scene(effects=sim.effects, angles={"arm": point.angles["arm"] + 1e-3})
    run = lamc.compile(sim.mechanism, start).run(2.0, rtol=1e-11, atol=1e-14, t_eval=np.linspace(0, 2, 20001))
    away = run.angle("arm") - point.angles["arm"]
    turned = np.flatnonzero(away[:-1] * away[1:] < 0.0)
    crossings = run.t[turned] - away[turned] * 1e-4 / (away[turned + 1] - away[turned])
    assert len(crossings) > 6
    assert 0.5 / np.diff(crossings).mean() == pytest.approx(mode.damped_frequency, rel=1e-5)
    peaks = [np.abs(away[a:b]).max() for a, b in pairwise(turned)]
    decrement = -np.diff(np.log(peaks)).mean() * 2.0
    told = 2.0 * math.pi * mode.damping / math.sqrt(1.0 - mode.damping**2)
    assert decrement == pytest.approx(told, rel=1e-3)


def test_free_directions_are_named_once() -> None:
    mechanism = with_base(chain(1, seed=2), 0.7, (0.1, 0.0, 0.0), np.diag([2e-3, 3e-3, 4e-3]))
    sim = lamc.compile(mechanism, Scene(effects=(lamc.FreeBase(), HingeStiffness(), HingeDamping())))
    for damping in (True, False):
        found = sim.modes(damping=damping)
        assert [mode.kind for mode in found.modes] == ["free"] * 6 + ["vibration"]
        assert math.isnan(found[0].damping)


@pytest.mark.parametrize("name", ["six_bar", "waterbomb", "miura:3x3"])
def test_a_cycle_of_a_mode_stays_closed(name: str) -> None:
    sim = lamc.compile(mechanism_of_example(find(name)))
    found = sim.modes()
    result = found.result(len(found) - 1, 0.3)
    assert result.constraint_error.max() < 1e-10  # m, of sizes of 0.1 m
    away = np.abs(result.q - found.point.q)
    assert 0.15 < away.max() < 0.6  # what moves most is not always independent
    assert result.q[0] == pytest.approx(result.q[-1], abs=1e-9)


def test_modes_that_are_not_there_are_refused() -> None:
    sim = oscillator(5.0, 0.1)
    with pytest.raises(lamc.RequestError, match="whole number"):
        sim.modes().result(3)
    with pytest.raises(lamc.RequestError, match="must be an equilibrium"):
        sim.modes({"pin": 0.0})  # type: ignore[arg-type]


def test_what_is_found_goes_to_another_process() -> None:
    sim = lamc.compile(mechanism_of_example(find("four_bar")))
    point = sim.equilibrium()
    found = sim.modes(point)
    assert point.angles  # made, and not pickled
    again, model, modes = pickle.loads(pickle.dumps((point, sim.linearise(point), found)))
    assert dict(again.angles) == dict(point.angles)
    assert np.array_equal(model.A, sim.linearise(again).A)
    assert np.array_equal(modes.frequencies, found.frequencies)
