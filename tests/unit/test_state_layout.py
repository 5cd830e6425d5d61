"""Coordinates beyond the joints, through C, simulator and results: a base that floats, and one that is moved."""

import csv
import json
from pathlib import Path

import numpy as np
import pytest

import lamc
from lamc.basics.errors import RequestError
from lamc.reference.interpreter import Interpreter
from lamc.run.simulator import Simulator
from tests.support.every_effect import mechanism

METHODS = ("rk45", "dop853", "rodas5p", "radau5", "auto", "scipy:DOP853")
START = {"h1": 0.3, "h2": -0.4}  # rad


@pytest.fixture(scope="module")
def floating() -> Simulator:
    """Two links whose ground floats, thrown up with a spin."""
    base = lamc.FreeBase(velocity=(0.1, 0.2, 3.0), spin=(1.0, 2.0, 3.0))
    effects = (lamc.Gravity(), lamc.HingeStiffness(), base)
    return lamc.compile(mechanism(), lamc.Scene(effects=effects, angles=START, rates={"h2": 2.0}))


@pytest.fixture(scope="module")
def shaken() -> Simulator:
    effects = (lamc.Gravity(), lamc.BaseMotion(("0.1*sin(2*t)", 0.0, 0.0), angle="0.5*t"))
    return lamc.compile(mechanism(), lamc.Scene(effects=effects, angles=START))


def test_coordinates_have_names_and_units(floating: Simulator) -> None:
    names = [c.name for c in floating.coordinates]
    assert names == ["h1", "h2", *(f"base.{k}" for k in ("x", "y", "z", "qw", "qx", "qy", "qz"))]
    rates = [r.name for r in floating.rates]
    assert rates == ["h1", "h2", *(f"base.{k}" for k in ("vx", "vy", "vz", "wx", "wy", "wz"))]
    assert [c.unit for c in floating.coordinates][1:4] == ["rad", "m", "m"]
    assert [r.unit for r in floating.rates][1:6:4] == ["rad/s", "rad/s"]
    assert floating.joints == ("h1", "h2")
    assert floating.freedoms == 8
    ground = mechanism().body("ground").com
    assert floating.start == pytest.approx(
        [0.3, -0.4, *ground, 1, 0, 0, 0, 0, 2, 0.1, 0.2, 3, 1, 2, 3], abs=0
    )


@pytest.mark.parametrize("method", METHODS)
def test_the_centre_of_mass_of_what_floats_falls_freely(floating: Simulator, method: str) -> None:
    """A parabola, whatever goes on inside; momentum of all bodies by their poses."""
    result = floating.run(
        t_end=1.0, rtol=1e-9, atol=1e-11, integrator=method, t_eval=np.linspace(0.0, 1.0, 21)
    )
    bodies = mechanism().bodies
    whole = sum(b.mass for b in bodies)
    centre = sum(b.mass * result.pose(b.name)[0] for b in bodies) / whole
    first = np.polynomial.polynomial.polyfit(result.t, centre, 2)
    assert first[2] == pytest.approx([0.0, 0.0, -0.5 * 9.81], abs=1e-6)  # 1e-9 a step, some 100 to 1000 steps
    bent = centre - np.polynomial.polynomial.polyval(result.t, first).T
    assert np.abs(bent).max() < 1e-7
    assert np.ptp(result.energy) < 1e-6 * np.abs(result.energies["kinetic"]).max()
    size = np.linalg.norm(result.q[:, -4:], axis=1)
    assert size == pytest.approx(
        np.ones(len(size)), abs=1e-6
    )  # nothing pulls the quaternion back, nothing need


def test_two_cross_checks_agree_on_accelerations_and_poses(floating: Simulator) -> None:
    cross_check = Interpreter(floating.program)
    constants = cross_check.constants()
    rng = np.random.default_rng(3)
    q, u = rng.standard_normal((5, 9)), rng.standard_normal((5, 8))
    mine = floating.acceleration(q, u, t=0.2)
    theirs = cross_check.acceleration(0.2, q, u, constants)
    assert mine == pytest.approx(theirs, rel=1e-10, abs=1e-10)  # two ways to solve M u̇ = f of condition 1e3
    rates = cross_check.rates(q, u, constants)
    flow = np.array([floating._motion({}).rhs(0.2, state)[:9] for state in np.hstack([q, u])])
    assert rates == pytest.approx(flow, rel=1e-14, abs=1e-15)  # the same operations
    assert np.array_equal(rates[:, :2], u[:, :2])


def test_the_jacobian_is_the_derivative_of_the_accelerations(floating: Simulator) -> None:
    q, u = floating.start[:9] + 0.1, floating.start[9:] + 0.1
    by_q, by_u = floating.jacobian(q, u)
    assert by_q.shape == (8, 9)
    assert by_u.shape == (8, 8)
    step = 1e-5
    for by, at, move in ((by_q, q, 0), (by_u, u, 1)):
        for k in range(len(at)):
            there = [(q.copy(), u.copy()), (q.copy(), u.copy())]
            there[0][move][k] -= step
            there[1][move][k] += step
            low, high = (floating.acceleration(*state) for state in there)
            # central differences: step² and round-off / step; forward ones in C: 1e-8, all times numbers of some 100
            assert by[:, k] == pytest.approx((high - low) / (2 * step), abs=2e-5)


def test_results_tell_all_coordinates(floating: Simulator, tmp_path: Path) -> None:
    result = floating.run(t_end=0.5, t_eval=[0.0, 0.25, 0.5])
    assert result.q.shape == (3, 9)
    assert result.u.shape == (3, 8)
    assert np.array_equal(result.angle("h2"), result.q[:, 1])
    assert np.array_equal(result.coordinate("base.z"), result.q[:, 4])
    assert np.array_equal(result.rate("base.vz"), result.u[:, 4])
    assert np.array_equal(result.pose("ground")[0], result.q[:, 2:5])
    assert result.constraint_error.tolist() == [0.0, 0.0, 0.0]
    with pytest.raises(KeyError, match=r"no coordinate is named 'z'; there are h1, h2, base\.x"):
        result.coordinate("z")
    with (result.to_csv(tmp_path / "r.csv")).open(encoding="utf-8") as file:
        table = list(csv.DictReader(file))
    assert [float(row["base.z (m)"]) for row in table] == result.coordinate("base.z").tolist()
    assert [float(row["base.wx (rad/s)"]) for row in table] == result.rate("base.wx").tolist()
    arrays = np.load(result.to_npz(tmp_path / "r.npz"))
    assert np.array_equal(arrays["q"], result.q)
    assert arrays["coordinates"].tolist() == [c.name for c in result.coordinates]
    assert arrays["rate_units"].tolist() == [r.unit for r in result.rates]


def test_frames_hold_all_coordinates(floating: Simulator) -> None:
    pytest.importorskip("pandas")
    pytest.importorskip("xarray")
    result = floating.run(t_end=0.2, t_eval=[0.0, 0.2])
    assert result.to_pandas()["base.qw (1)"].tolist() == result.coordinate("base.qw").tolist()
    data = result.to_xarray()
    assert data["base.vx"].values.tolist() == result.rate("base.vx").tolist()
    assert data["angle"].shape == (2, 2)


def test_the_energy_balance_is_in_the_files_where_it_was_kept(floating: Simulator, tmp_path: Path) -> None:
    result = floating.run(t_end=0.2, t_eval=[0.0, 0.2], energy_balance=True)
    file = result.to_npz(tmp_path / "r.npz")
    arrays = np.load(file)
    assert arrays["work_names"].tolist() == list(result.work)
    assert np.array_equal(arrays["work"][:, 0], next(iter(result.work.values())))
    reported = json.loads((tmp_path / "r.npz.manifest.json").read_text(encoding="utf-8"))["books"]
    assert {entry["effect"] for entry in reported["effects"]} == set(result.work)
    assert reported["balance"] == result.energy_balance.balance
    assert "gravity work (J)" in result.to_csv(tmp_path / "r.csv").read_text(encoding="utf-8").splitlines()[0]
    assert "work" not in np.load(floating.run(t_end=0.1).to_npz(tmp_path / "none.npz"))


def test_a_base_that_is_moved_is_where_it_was_told_to_be(shaken: Simulator) -> None:
    """Poses depend on time: x by 0.1 sin 2t, and a turn about z by t / 2 through the world's origin."""
    result = shaken.run(t_end=1.0, t_eval=np.linspace(0.0, 1.0, 5))
    centre, rotation = result.pose("ground")
    com = mechanism().body("ground").com
    angle = 0.5 * result.t
    expected = np.column_stack([com[0] * np.cos(angle) + 0.1 * np.sin(2 * result.t), com[0] * np.sin(angle)])
    assert centre[:, :2] == pytest.approx(expected, abs=1e-15)  # round-off
    assert rotation[:, 0, 0] == pytest.approx(np.cos(angle), abs=1e-15)
    assert shaken.freedoms == 2


def test_states_of_another_size_are_refused(floating: Simulator) -> None:
    with pytest.raises(
        RequestError, match=r"q has shape \(2,\); its last length must be 9, as many as `coordinates`"
    ):
        floating.acceleration([0.0, 0.0], np.zeros(8))
    with pytest.raises(RequestError, match=r"u has shape \(9,\); its last length must be 8"):
        floating.acceleration(floating.start[:9], np.zeros(9))


def test_a_start_that_an_effect_gives_is_not_that_of_another_compile() -> None:
    """Two starts of one effect share the C, and not the start."""
    sims = [
        lamc.compile(mechanism(), lamc.Scene(effects=(lamc.FreeBase(velocity=(v, 0.0, 0.0)),)))
        for v in (1.0, 2.0, 1.0)
    ]
    assert [sim.start[11] for sim in sims] == [1.0, 2.0, 1.0]
    assert sims[0].source_dir == sims[1].source_dir
