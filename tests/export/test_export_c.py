"""Exported C against the compiled module that Python runs: the same motion to the last bit, whatever a caller does
between two steps that does not concern the motion."""

from pathlib import Path

import numpy as np
import pytest

import lamc
from lamc.export.options import ExportOptions
from tests.support.ctools import needs_cc
from tests.support.exported import Exported, c_files
from tests.support.exported_folders import mechanism_of

pytestmark = needs_cc

# name, end s: tree, stiff hinges, loops of each kind, limits with and without impact, contact and a floating base
SCENES = (
    ("pendulum", 2.0),
    ("stiff_triple", 0.3),
    ("four_bar", 1.0),
    ("vertex", 0.5),
    ("two_loops", 0.5),
    ("limit_stop", 1.0),
    ("flaps", 0.5),
    ("crawler", 0.2),
    ("flapping_wing", 0.02),
)


@pytest.mark.parametrize(("name", "t_end"), SCENES)
@pytest.mark.quick("pendulum-*", "limit_stop-*", others="campaign")
def test_states_are_those_of_python_to_the_last_bit(name: str, t_end: float, tmp_path: Path) -> None:
    mechanism = mechanism_of(name)
    times = np.linspace(0.0, t_end, 38)[1:]
    result = lamc.compile(mechanism).run(t_end, t_eval=times)
    assert result.success
    exported = Exported(c_files(mechanism), tmp_path)
    states = exported.trajectory(exported.instance(t_stop=t_end), times)
    assert states.tobytes() == np.hstack([result.q, result.u]).tobytes()


def test_events_are_those_of_python(tmp_path: Path) -> None:
    result = lamc.compile(mechanism_of("limit_stop")).run(1.0)
    exported = Exported(c_files(mechanism_of("limit_stop")), tmp_path)
    it, count, t, kind = (
        exported.instance(t_stop=1.0),
        *map(exported.ffi.new, ("long long *", "double *", "int *")),
    )
    found: list[tuple[float, str]] = []
    for target in np.linspace(0.0, 1.0, 2001):
        assert exported.call("step", it, target) == exported.call("get_events", it, count, t, kind) == 0
        assert count[0] in (len(found), len(found) + 1)
        if count[0] > len(found):
            found.append((t[0], exported.ffi.string(exported.call("event_name", kind[0])).decode()))
        assert (kind[0] == -1) == (not found)
    assert len(found) >= 4
    assert found == [(event.t, event.name) for event in result.events]
    assert exported.call("event_name", exported.constant("event_count")) == exported.ffi.NULL
    assert exported.call("get_events", it, count, t, exported.ffi.NULL) == exported.status("BAD_ARGUMENT")
    assert exported.call("start", it, 0.0, it.q, it.u) == exported.call("get_events", it, count, t, kind) == 0
    assert (count[0], kind[0]) == (0, -1)


@pytest.mark.parametrize("integrator", ["rk45", "dop853", "rodas5p", "radau5"])
@pytest.mark.parametrize("name", ["pendulum", "four_bar"])
@pytest.mark.quick("pendulum-rk45", "four_bar-radau5", others="campaign")
def test_each_method_alone_takes_the_steps_of_python(name: str, integrator: str, tmp_path: Path) -> None:
    mechanism = mechanism_of(name)
    times = np.linspace(0.0, 0.3, 11)[1:]
    result = lamc.compile(mechanism).run(0.3, t_eval=times, integrator=integrator)
    exported = Exported(c_files(mechanism, options=ExportOptions(integrator=integrator)), tmp_path)
    states = exported.trajectory(exported.instance(t_stop=0.3), times)
    assert states.tobytes() == np.hstack([result.q, result.u]).tobytes()


@pytest.fixture(scope="module")
def crawler(tmp_path_factory: pytest.TempPathFactory) -> Exported:
    """Contact, a floating base, switches: of all examples the one with the most to keep between two steps."""
    return Exported(c_files(mechanism_of("crawler")), tmp_path_factory.mktemp("crawler"))


@pytest.fixture(scope="module")
def pendulum(tmp_path_factory: pytest.TempPathFactory) -> Exported:
    return Exported(c_files(mechanism_of("pendulum")), tmp_path_factory.mktemp("pendulum"))


@pytest.fixture(scope="module")
def four_bar(tmp_path_factory: pytest.TempPathFactory) -> Exported:
    return Exported(c_files(mechanism_of("four_bar")), tmp_path_factory.mktemp("four_bar"))


@pytest.mark.slow
def test_many_targets_change_nothing(crawler: Exported) -> None:
    few, many = crawler.instance(t_stop=0.1), crawler.instance(t_stop=0.1)
    crawler.trajectory(few, np.array([0.05, 0.1]))
    crawler.trajectory(many, np.linspace(0.0, 0.1, 401)[1:])
    assert crawler.state(few) == crawler.state(many)


@pytest.mark.slow
def test_a_state_goes_on_with_the_same_bits_elsewhere(crawler: Exported) -> None:
    """In another instance, through bytes as a file would hold them, and in a copy by assignment."""
    times = np.linspace(0.0, 0.1, 21)[1:]
    it, kept = crawler.instance(t_stop=0.1), crawler.new("state")
    crawler.trajectory(it, times[:9])
    assert crawler.call("get_state", it, kept) == 0
    in_file = bytes(crawler.ffi.buffer(kept))
    copy = crawler.new("t")
    copy[0] = it[0]
    expected = crawler.trajectory(it, times[9:]).tobytes()
    assert crawler.trajectory(copy, times[9:]).tobytes() == expected
    other = crawler.instance()
    crawler.ffi.memmove(kept, in_file, len(in_file))
    assert crawler.call("set_state", other, kept) == 0
    assert crawler.trajectory(other, times[9:]).tobytes() == expected
    assert bytes(crawler.ffi.buffer(other)) == bytes(crawler.ffi.buffer(it))


def test_a_limit_on_steps_only_interrupts(pendulum: Exported) -> None:
    whole, parts = pendulum.instance(t_stop=1.0), pendulum.instance(t_stop=1.0, max_steps=7)
    assert pendulum.call("step", whole, 1.0) == 0
    calls = 0
    while (status := pendulum.call("step", parts, 1.0)) == pendulum.status("STEP_LIMIT"):
        calls += 1
    assert status == 0
    assert calls > 3
    assert pendulum.state(parts) == pendulum.state(whole)


def test_parameters_changed_on_the_way_act_from_there_on(pendulum: Exported) -> None:
    """Against a run in Python that starts at that state with these parameters. Two runs at 1e-9 agree within some
    hundred tolerances after a second."""
    it, parameters = pendulum.instance(), pendulum.new("parameters")
    assert pendulum.call("step", it, 0.37) == 0
    pendulum.call("default_parameters", parameters)
    field = next(name for name, _ in pendulum.ffi.typeof(parameters[0]).fields if name.endswith("_mass"))
    setattr(parameters, field, 2.0 * getattr(parameters, field))
    state = pendulum.state(it)
    assert pendulum.call("set_parameters", it, parameters) == 0
    assert pendulum.state(it) == state
    assert pendulum.call("step", it, 1.37) == 0
    mechanism = mechanism_of("pendulum")
    names = [joint.name for joint in mechanism.joints]
    n = len(names)
    scene = lamc.Scene(
        angles=dict(zip(names, state[:n], strict=True)), rates=dict(zip(names, state[n:], strict=True))
    )
    sim = lamc.compile(mechanism, scene)
    name = next(p for p in sim.parameters if p.replace(".", "_").replace(" ", "_").lower() == field)
    result = sim.run(1.0, parameters={name: 2.0 * sim.parameters[name]})
    # Other steps, each good to 1e-9 of some 10 rad/s; a few hundred of them add up to less than 1e-6.
    np.testing.assert_allclose(pendulum.state(it), [*result.q[-1], *result.u[-1]], rtol=0.0, atol=1e-6)


@pytest.mark.slow
def test_modes_of_contact_survive_a_change_of_parameters(crawler: Exported) -> None:
    """The same parameters once more, every millisecond: another sequence of steps, the same motion. Contact multiplies
    the tolerance of 1e-9 by some thousands."""
    times = np.linspace(0.0, 0.1, 101)[1:]
    calm, stirred = crawler.instance(), crawler.instance()
    parameters = crawler.new("parameters")
    crawler.call("default_parameters", parameters)
    expected, rows = crawler.trajectory(calm, times), []
    for t in times:
        assert crawler.call("set_parameters", stirred, parameters) == 0
        rows.append(crawler.trajectory(stirred, np.array([t]))[0])
    np.testing.assert_allclose(np.array(rows), expected, rtol=0.0, atol=1e-5)


def test_rates_of_change_outputs_and_derivatives_are_those_of_python(four_bar: Exported) -> None:
    mechanism = mechanism_of("four_bar")
    sim = lamc.compile(mechanism)
    result = sim.run(0.2, t_eval=[0.2])
    it, outputs = four_bar.instance(t_stop=0.2), four_bar.new("outputs")
    assert four_bar.call("step", it, 0.2) == 0
    n, count = len(sim.coordinates), len(sim.rates)
    state = np.array(four_bar.state(it))
    slope = four_bar.ffi.new("double[]", n + count)
    assert four_bar.call("rhs", it, 0.2, four_bar.ffi.new("double[]", list(state)), slope) == 0
    assert list(slope)[n:] == list(sim.acceleration(state[:n], state[n:], 0.2))
    assert list(slope)[:n] == list(state[n:])
    assert four_bar.call("get_outputs", it, outputs) == 0
    for i, name in enumerate(sim.joints):
        assert four_bar.ffi.string(four_bar.call("joint_name", i)).decode() == name
        assert outputs.angle[i] == result.angle(name)[-1]
        assert outputs.rate[i] == result.rate(name)[-1]
    assert outputs.total_energy == pytest.approx(float(result.energy[-1]), rel=1e-15)  # the order of the sum
    for i in range(four_bar.constant("body_count")):
        com, rotation = result.pose(four_bar.ffi.string(four_bar.call("body_name", i)).decode())
        assert list(outputs.pose[i]) == [*com[-1], *rotation[-1].ravel()]
    assert 0.0 <= outputs.closure < 1e-12 * sim.mechanism.size  # settled to 1e-13 of the size
    by_q, by_u = four_bar.ffi.new("double[]", n * count), four_bar.ffi.new("double[]", count * count)
    assert four_bar.call("jacobian", it, by_q, by_u, four_bar.ffi.NULL) == 0
    expected = sim.jacobian(state[:n], state[n:], 0.2)
    np.testing.assert_array_equal(np.array(list(by_q)).reshape(count, n), expected[0])
    np.testing.assert_array_equal(np.array(list(by_u)).reshape(count, count), expected[1])


@pytest.mark.parametrize("name", ["pendulum", "four_bar"])
@pytest.mark.quick("pendulum")
def test_steps_of_one_length_are_of_order_four(name: str, tmp_path: Path) -> None:
    """Errors against a run at the tightest tolerance fall by 16 where the step is halved; by 13 at least, since steps
    of this length leave some of the next order. The same bits with `real_time`, which has nothing else."""
    mechanism = mechanism_of(name)
    tight = lamc.compile(mechanism).run(0.05, rtol=1e-12, atol=1e-14, t_eval=[0.05])
    exported = Exported(c_files(mechanism), tmp_path / "whole")
    lean = Exported(
        c_files(mechanism, options=ExportOptions(real_time=True, jacobian=False)), tmp_path / "lean"
    )
    errors = []
    for steps in (100, 200):
        it, other = exported.instance(), lean.instance()
        for _ in range(steps):
            assert exported.call("step_fixed", it, 0.05 / steps) == 0
            assert lean.call("step_fixed", other, 0.05 / steps) == 0
        assert exported.state(it) == lean.state(other)
        errors.append(
            float(np.abs(np.array(exported.state(it)) - np.hstack([tight.q[-1], tight.u[-1]])).max())
        )
    assert 13.0 < errors[0] / errors[1] < 20.0, errors
    assert not hasattr(lean.lib, f"{lean.prefix}_step")


@pytest.mark.slow
def test_fixed_steps_and_adaptive_ones_go_on_from_each_other(crawler: Exported) -> None:
    """Neither kind of step forgets where the other one was. Steps of 20 us see contacts begin at their ends: rates of
    some 10 rad/s are off by 1e-4 of that, and angles by what this comes to within milliseconds."""
    mixed, whole = crawler.instance(), crawler.instance()
    for k in range(20):
        assert crawler.call("step", mixed, mixed.t + 1e-3) == 0
        for _ in range(50):
            assert crawler.call("step_fixed", mixed, 2e-5) == 0
        assert mixed.t == pytest.approx(2e-3 * (k + 1), rel=1e-12)
    assert crawler.call("step", whole, mixed.t) == 0
    np.testing.assert_allclose(list(mixed.q), list(whole.q), rtol=0.0, atol=1e-5)
    np.testing.assert_allclose(list(mixed.u), list(whole.u), rtol=0.0, atol=1e-3)
