"""Steps of fixed length by Rodas5P: of order 5, stable where hinges are stiff, in both precisions."""

from pathlib import Path

import numpy as np
import pytest

import lamc
from tests.support.ctools import needs_cc
from tests.support.exported import C99, Exported
from tests.support.exported_folders import STRICT, cc, compilers, exported, mechanism_of, needs, put, scene_of

pytestmark = needs_cc

EPSILON = float(np.finfo(np.float32).eps)


def stiff(name: str, folder: Path, precision: str = "double") -> Exported:
    files = exported(name, real_time=True, integrator="rodas5p", precision=precision, jacobian=False)
    return Exported(files, folder / precision, (*C99, "-Wdouble-promotion"))


def after(model: Exported, h: float, count: int) -> np.ndarray[tuple[int], np.dtype[np.float64]]:
    """The state after so many steps."""
    it = model.instance()
    for k in range(count):
        assert model.call("step_fixed", it, h) == 0, (k, count)
    return np.array(model.state(it))


def exact(name: str, t: float) -> np.ndarray[tuple[int], np.dtype[np.float64]]:
    """The state at t, s, by an adaptive run of another method."""
    sim = lamc.compile(mechanism_of(name), scene_of(name))
    tight = sim.run(t, rtol=1e-13, atol=1e-15, t_eval=[t], integrator="dop853", max_steps=10_000_000)
    return np.hstack([tight.q[-1], tight.u[-1]])


def loop_condition(name: str) -> float:
    """Of the closure's Jacobian at the start, by numpy; 1 without loops."""
    sim = lamc.compile(mechanism_of(name), scene_of(name))
    if not sim.cut_joints:
        return 1.0
    rows = sim.model.motion({}).closures(sim.start[np.newaxis])[0]
    jacobian = rows[sim.program.closure_count :].reshape(sim.program.closure_count, -1)
    values = np.linalg.svd(jacobian, compute_uv=False)
    return float(values[0] / values[sim.program.rank - 1])


@pytest.mark.parametrize(("name", "h"), [("pendulum", 0.005), ("four_bar", 0.01)])
@pytest.mark.quick("pendulum-*")
def test_halved_steps_have_a_thirty_second_of_the_error(name: str, h: float, tmp_path: Path) -> None:
    """20 to 45: steps of this length leave some of the next order."""
    model, count = stiff(name, tmp_path), round(0.4 / h)
    truth = exact(name, 0.4)
    errors = [float(np.abs(after(model, h / k, count * k) - truth).max()) for k in (1, 2)]
    assert 20.0 < errors[0] / errors[1] < 45.0, errors


@pytest.mark.slow
def test_a_millisecond_is_enough_where_hinges_ring_at_kilohertz(tmp_path: Path) -> None:
    """An explicit method does not bear such steps. The stiff hinges ring by less than 1e-5 rad, which is what a step
    that does not resolve them may be off."""
    explicit = Exported(exported("stiff_triple", real_time=True), tmp_path / "explicit")
    it = explicit.instance()
    statuses = [explicit.call("step_fixed", it, 1e-3) for _ in range(100)]
    assert statuses[-1] in (explicit.status("STEP_TOO_LONG"), explicit.status("NOT_FINITE"))
    joints = lamc.compile(mechanism_of("stiff_triple")).model.joints
    there, truth = after(stiff("stiff_triple", tmp_path), 1e-3, 100), exact("stiff_triple", 0.1)
    np.testing.assert_allclose(there[: len(joints)], truth[: len(joints)], rtol=0.0, atol=1e-5)


@pytest.mark.parametrize("name", ["limit_stop", "crawler"])
@pytest.mark.quick("limit_stop")
def test_stops_and_contact_are_met(name: str, tmp_path: Path) -> None:
    """Events are looked at at ends of steps of 20 us, within which rates of some rad/s change by what 1e-3 allows."""
    t = 0.02
    there = after(stiff(name, tmp_path), 2e-5, round(t / 2e-5))
    np.testing.assert_allclose(there, exact(name, t), rtol=0.0, atol=1e-3)


@pytest.mark.parametrize(
    ("name", "count"), [("pendulum", 200), ("four_bar", 200), ("stiff_triple", 200), ("crawler", 50)]
)
@pytest.mark.quick("pendulum-*", others="campaign")
def test_single_precision_follows_double_within_its_round_off(name: str, count: int, tmp_path: Path) -> None:
    """A step rounds the state by half a unit; of loops, which it closes, by as much as the condition of their
    Jacobian makes of the last digit of closure (19 in the four-bar). Its change is a sum that cancels: weights of
    one stage add up to 325, and what a stage rounds is in all that follow, so that a thousand half units of it are
    lost. Contacts make errors grow: the crawler runs briefly."""
    h = 2.0**-13
    here, there = after(stiff(name, tmp_path, "float"), h, count), after(stiff(name, tmp_path), h, count)
    size = max(1.0, float(np.abs(there).max()))
    lost = count * loop_condition(name) + 1000.0
    assert np.abs(here - there).max() < 0.5 * EPSILON * lost * size


@pytest.mark.parametrize("compiler", compilers())
@pytest.mark.parametrize("options", [{"precision": "float"}, {"libm": False}, {"real_time": False}])
@pytest.mark.quick("options0-*", others="campaign")
def test_it_compiles_without_a_warning(
    options: dict[str, object], compiler: list[str], tmp_path: Path
) -> None:
    folder = put(exported("crawler", **{"real_time": True, "integrator": "rodas5p", **options}), tmp_path)
    cc(folder, "-std=c99", *STRICT, "-c", "crawler.c", "-o", "it.o", command=compiler)


@needs("g++")
def test_it_is_cxx_too(tmp_path: Path) -> None:
    folder = put(exported("crawler", real_time=True, integrator="rodas5p", precision="float"), tmp_path)
    cc(folder, "-x", "c++", "-std=c++17", *STRICT, "-c", "crawler.c", "-o", "it.o", command=["g++"])


def test_both_kinds_of_steps_of_an_instance_are_of_the_same_method(tmp_path: Path) -> None:
    """An adaptive step whose first step is h, and takes it, ends where a step of h does, to the last bit."""
    whole = Exported(exported("pendulum", integrator="rodas5p"), tmp_path / "whole")
    h = 1.0 / 1024.0
    adaptive, fixed = whole.instance(rtol=1e-3, atol=1e-3, first_step=h, max_step=h), whole.instance()
    for k in range(100):
        assert whole.call("step", adaptive, h * (k + 1)) == 0
        assert whole.call("step_fixed", fixed, h) == 0
    assert whole.state(adaptive) == whole.state(fixed)
    assert whole.state(fixed) == list(after(stiff("pendulum", tmp_path), h, 100))
