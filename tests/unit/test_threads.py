"""Threads that share results, simulators and plates get the numbers that one thread gets, to the last bit."""

import threading
from collections.abc import Callable, Sequence
from functools import partial
from typing import Any

import numpy as np
import pytest

import lamc
from lamc import examples, plate
from lamc.basics.once import lazy, remembered
from tests.support.plates import cross_ply

THREADS = 8


def at_once(jobs: Sequence[Callable[[], Any]]) -> list[Any]:
    """What the jobs return, each run by a thread of its own, started together."""
    barrier, found = threading.Barrier(len(jobs)), [None] * len(jobs)

    def work(k: int) -> None:
        barrier.wait()
        try:
            found[k] = jobs[k]()
        except Exception as error:
            found[k] = error

    threads = [threading.Thread(target=work, args=(k,)) for k in range(len(jobs))]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    for each in found:
        if isinstance(each, Exception):
            raise each
    return found


def same(one: Any, other: Any) -> bool:
    """Whether arrays, by name or in a row, are equal to the last bit."""
    if isinstance(one, dict):
        return one.keys() == other.keys() and all(same(one[k], other[k]) for k in one)
    if isinstance(one, list | tuple):
        return len(one) == len(other) and all(map(same, one, other))
    return np.asarray(one).tobytes() == np.asarray(other).tobytes()


def told(result: lamc.Result) -> dict[str, Any]:
    """All that a result computes when it is asked for it."""
    name = result.joints[0]
    return {
        "energies": dict(result.energies),
        "powers": dict(result.powers),
        "constraint error": result.constraint_error,
        "pose": result.pose(result.bodies[-1]),
        "angles": [result.angle(joint) for joint in (name, *result.motion.model.cuts)],
        "jacobian": result.motion.jacobian(0.0, np.concatenate([result.q[0], result.u[0]])),
    }


@pytest.fixture(params=["limit_stop", "crawler", "four_bar"], scope="module")
def simulator(request: pytest.FixtureRequest) -> lamc.Simulator:
    return lamc.compile(lamc.load(examples.path(request.param)))


def run(simulator: lamc.Simulator, **given: Any) -> lamc.Result:
    return simulator.run(0.1, 1e-6, 1e-8, np.linspace(0.0, 0.1, 8_001), energy_balance=True, **given)


@pytest.mark.quick("limit_stop", others="campaign")
def test_threads_that_read_one_result_get_its_numbers(simulator: lamc.Simulator) -> None:
    alone = told(run(simulator))
    for _ in range(3):
        read_together(run(simulator), alone)


def read_together(shared: lamc.Result, alone: dict[str, Any]) -> None:
    """Different parts at once, which are computed there and then, and then all of them."""
    rows = np.hstack([shared.q, shared.u])
    parts: list[Callable[[], Any]] = [
        lambda: dict(shared.energies),
        lambda: dict(shared.powers),
        lambda: shared.motion.energies(shared.t, rows),
        lambda: shared.motion.accelerations(shared.t, rows),
    ]
    found = at_once(parts * (THREADS // len(parts)))
    assert same(found[0], alone["energies"])
    assert same(found[1], alone["powers"])
    assert same(found[: len(parts)], found[len(parts) :])
    assert all(same(each, alone) for each in at_once([lambda: told(shared)] * THREADS))


@pytest.mark.quick("limit_stop", "four_bar")
def test_threads_that_run_one_simulator_get_its_numbers(simulator: lamc.Simulator) -> None:
    alone = run(simulator)
    fresh = lamc.compile(simulator.mechanism, simulator.scene)  # nothing made when it was first asked for
    for result in at_once([lambda: run(fresh)] * THREADS):
        assert same(
            (result.t, result.q, result.u, result.kept.work), (alone.t, alone.q, alone.u, alone.kept.work)
        )  # type: ignore[union-attr]
    q, u = alone.q[:500], alone.u[:500]
    answers = at_once([lambda: (fresh.acceleration(q, u), fresh.energy(q, u))] * THREADS)
    assert all(same(each, (simulator.acceleration(q, u), simulator.energy(q, u))) for each in answers)


def test_runs_do_not_hear_of_one_another_by_the_motion_that_they_share(simulator: lamc.Simulator) -> None:
    motion = run(simulator).motion
    with motion.opened() as one, motion.opened() as other:
        assert one.constants != other.constants
        assert one.work != other.work or not motion.model.lib.lamc_motion_work_size(motion.model.handle)


@pytest.mark.slow
def test_threads_that_solve_one_plate_get_its_numbers() -> None:
    def model() -> plate.FactoredPlate:
        supports = [plate.Clamped("boundary")]
        return plate.FactoredPlate(
            plate.Problem(
                plate.grid(1.0, 1.0, 24, 24, "one-diagonal"), cross_ply((0, 90, 90, 0)), supports=supports
            )
        )

    def answers(shared: plate.FactoredPlate, k: int) -> tuple[Any, ...]:
        solution = shared.solve([plate.Pressure(1.0 + k), plate.PointLoad((0.3, 0.4), 2.0)])
        at = np.array([0.2, 0.5, 0.71]), np.array([0.3, 0.5, 0.6])
        return (
            solution.deflection(*at),
            solution.moments(*at),
            solution.recovered.moments(*at),
            solution.strain_energy,
            solution.error_estimate.relative,
        )

    serial = [answers(model(), k) for k in range(THREADS)]
    for _ in range(3):
        shared = model()
        assert same(at_once([partial(answers, shared, k) for k in range(THREADS)]), serial)


# --- what is made once --------------------------------------------------------------------------------------------


class Counted:
    def __init__(self) -> None:
        self.made: list[str] = []

    def _slow(self, name: str) -> object:
        threading.Event().wait(0.01)  # lets the others come
        self.made.append(name)
        return object()

    @lazy
    def value(self) -> object:
        """A value."""
        return self._slow("value")

    @lazy
    def other(self) -> object:
        return self._slow("other")

    @lazy
    def failing(self) -> object:
        raise KeyError("not yet")


def test_a_lazy_value_is_made_once_and_leaves_no_lock() -> None:
    from lamc.basics import once

    thing = Counted()
    found = at_once([lambda: thing.value] * THREADS + [lambda: thing.other] * THREADS)
    assert sorted(thing.made) == ["other", "value"]
    assert len(set(map(id, found))) == 2
    assert not once._turns
    with pytest.raises(KeyError):
        _ = thing.failing
    assert not once._turns
    assert Counted.value.__doc__ == "A value."


def test_a_function_is_remembered_once_for_each_argument() -> None:
    calls: list[tuple[int, int]] = []

    @remembered
    def slow(a: int, *, b: int = 0) -> object:
        calls.append((a, b))
        threading.Event().wait(0.01)
        if a < 0:
            raise ValueError("negative")
        return object()

    found = at_once([lambda: slow(1)] * THREADS + [lambda: slow(1, b=2)] * THREADS)
    assert sorted(calls) == [(1, 0), (1, 2)]
    assert len(set(map(id, found))) == 2
    for _ in range(2):
        with pytest.raises(ValueError, match="negative"):
            slow(-1)
    assert calls.count((-1, 0)) == 2
