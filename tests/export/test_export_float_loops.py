"""Loops in single precision against the same steps in double precision, and where loops become singular."""

from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import lamc
from lamc.examples import find
from lamc.export.driven import simulator_of
from lamc.run.simulator import Simulator
from tests.support.ctools import needs_cc
from tests.support.exported import C99, Exported, c_files

pytestmark = needs_cc

Array = np.ndarray[Any, Any]
EPSILON = float(np.finfo(np.float32).eps)
# Planar loops, alone and sharing bodies; loops in space, of revolute pairs and of creases that meet in a point.
LOOPS = (
    "four_bar", "five_bar", "six_bar", "two_loops", "bricard", "sarrus", "vertex", "waterbomb", "miura:2x2",
    "miura:3x3",
)  # fmt: skip
H = 2.0**-10  # s, exact in both precisions
CLOSED, LOST = (
    2e-6,
    1e-4,
)  # of the size of the mechanism: what a settled state is off at most, and what is refused


class Pair:
    """One model in both precisions, from the same sources but for the numbers."""

    def __init__(self, name: str, folder: Path) -> None:
        many = (
            ("-O1",) if name.startswith("n_four_bar") else ()
        )  # 70 000 steps: worth half a second of the compiler
        text = folder / "model.yaml"
        text.write_text(find(name).text)
        design = lamc.load(text)
        mechanism = design if isinstance(design, lamc.Mechanism) else lamc.split(design)
        scene = mechanism.scene or lamc.Scene()
        kinds = {
            "single": lamc.ExportOptions(real_time=True, precision="float"),
            "double": lamc.ExportOptions(real_time=True, libm=False),
        }
        self.single, self.double = (
            Exported(c_files(mechanism, scene, options), folder / kind, (*C99, *flags))
            for (kind, options), flags in zip(kinds.items(), (many, ()), strict=True)
        )
        self.simulator: Simulator = simulator_of(mechanism, scene, kinds["double"])
        self.size = float(self.simulator.mechanism.size)  # m
        self.count = self.double.constant("coordinate_count")

    def conditions(self, y: Array) -> Array:
        """Singular values of the closure's Jacobian at a state, of the largest; by numpy, in the plain metric."""
        program = self.simulator.program
        rows = self.simulator.model.motion({}).closures(y[np.newaxis])[0]
        jacobian = rows[program.closure_count :].reshape(program.closure_count, -1)
        values = np.linalg.svd(jacobian, compute_uv=False)
        return np.asarray(values / values[0])


@pytest.fixture(scope="module")
def pairs(tmp_path_factory: pytest.TempPathFactory) -> Any:
    return cache(lambda name: Pair(name, tmp_path_factory.mktemp("pair")))


def stepped(model: Exported, it: Any, h: float, count: int) -> tuple[int, Array]:
    """The last status, and the states after each step that succeeded."""
    rows, status = [], 0
    for _ in range(count):
        status = model.call("step_fixed", it, h)
        if status != 0:
            break
        rows.append(model.state(it))
    return status, np.array(rows)


def outputs(model: Exported, it: Any) -> Any:
    found = model.new("outputs")
    assert model.call("get_outputs", it, found) == 0
    return found


def growth(pair: Pair, count: int) -> float:
    """What the scene's motion makes of a nudge of its start over `count` steps, by what it is after one of them."""
    it = pair.double.instance()
    state = np.array(pair.double.state(it))
    _, rows = stepped(pair.double, it, H, count)
    nudge = 1e-7 * np.random.default_rng(7).choice([-1.0, 1.0], len(state))
    status, aside = started(pair.double, pair.count, state + nudge)
    assert status == 0
    off = np.abs(stepped(pair.double, aside, H, count)[1] - rows).max(axis=1)
    return max(1.0, float(off.max() / off[0]))


@pytest.mark.parametrize("name", LOOPS)
@pytest.mark.quick("four_bar", others="campaign")
def test_motion_differs_from_that_of_doubles_by_round_off(name: str, pairs: Any) -> None:
    """A second of the scene, whose loops stay away from singular positions."""
    pair = pairs(name)
    count = 1024
    _, there = stepped(pair.double, pair.double.instance(), H, count)
    _, here = stepped(pair.single, pair.single.instance(), H, count)
    assert here.shape == there.shape == (count, 2 * pair.count)
    size = max(1.0, float(np.abs(there).max()))
    # One rounding of half a unit for the start and for each step: all the same way they add up; at random they grow as
    # their root, and each as the motion makes a nudge grow.
    steps = np.arange(1, count + 1)[:, np.newaxis] + 1.0
    bound = 0.5 * EPSILON * size * (steps + growth(pair, count) * np.sqrt(steps))
    worst = np.max(np.abs(here - there) / bound)
    assert worst <= 1.0
    assert np.any(here != there)


@pytest.mark.parametrize("name", ["four_bar", "six_bar", "bricard", "waterbomb"])
@pytest.mark.campaign
def test_loops_stay_closed_over_a_hundred_thousand_steps(name: str, pairs: Any) -> None:
    pair = pairs(name)
    model, it = pair.single, pair.single.instance()
    found, gap = model.new("outputs"), 0.0
    for _ in range(100_000):
        assert model.call("step_fixed", it, H) == 0
        model.call("get_outputs", it, found)
        gap = max(gap, found.closure)
    # What ends the iteration of a step, with the round-off of a residual on top: lengths of the size of the mechanism.
    assert gap <= (CLOSED + EPSILON) * pair.size
    assert it.t == np.float32(100_000 * H)


@pytest.mark.parametrize("count", [2, 5])
@pytest.mark.slow
@pytest.mark.ci("2")
def test_passages_through_a_singular_position_keep_branch_and_energy(count: int, pairs: Any) -> None:
    """The N-four-bar lies in one line twice a turn, where each of its parallelograms could flip; with five of them J is
    no array any more. Ten seconds have ten passages, met by each length of step at other distances: right on one, or$
    with a place around on it, one in some thousand steps made energy out of nothing.

    Places around have pivots of 0.025 at least (half of FADING), and closure is kept to 2e-6: an acceleration is off by
    3e-3 of itself at most, at random, for a tenth of a turn."""
    pair = pairs(f"n_four_bar:{count}")
    model = pair.single
    names = [model.ffi.string(model.call("joint_name", k)).decode() for k in range(pair.count)]
    upright = [names.index(f"g{k}") for k in range(count + 1)]
    found = model.new("outputs")
    for share in np.linspace(0.8, 1.2, 7):
        it = model.instance()
        start = outputs(model, it).total_energy
        rows = []
        for _ in range(round(10.0 / (share * H))):
            assert model.call("step_fixed", it, share * H) == 0
            assert model.call("get_outputs", it, found) == 0
            rows.append((found.closure, found.total_energy, *(found.angle[k] for k in upright)))
        closure, energy, *angles = np.array(rows).T
        spread = np.angle(np.exp(1j * (np.array(angles) - angles[0])))
        assert np.abs(spread).max() < 2e-3  # rad; in line, tops are off by the root of what closure is
        assert np.all(closure <= LOST * pair.size)
        assert np.all(np.abs(energy - start) < 1e-3 * start)
        above = np.cos([0.0, *angles[0]]) > 0.0
        assert np.count_nonzero(above[1:] != above[:-1]) >= 10


def random_state(pair: Pair, generator: np.random.Generator) -> Array | None:
    """A closed state with floats for numbers, somewhere; None: no near state closes, or it is a fast one."""
    spread = generator.choice([3.0, 1.0, 0.3, 0.1])
    q = generator.uniform(-spread, spread, pair.count)
    u = generator.uniform(-3.0, 3.0, pair.count)
    it = pair.double.instance()
    if pair.double.call("start", it, 0.0, q.tolist(), u.tolist()) != 0:
        return None
    state = np.array(pair.double.state(it))
    if np.abs(state[pair.count :]).max() > 30.0:
        return None
    return state.astype(np.float32).astype(float)


def started(model: Exported, count: int, state: Array) -> tuple[int, Any]:
    it = model.instance()
    return model.call("start", it, 0.0, state[:count].tolist(), state[count:].tolist()), it


@pytest.mark.parametrize("name", [*LOOPS[:-1], "miura:3x3", "folding_box"])
@pytest.mark.quick("four_bar", others="campaign")
def test_from_any_state_it_moves_as_doubles_do_or_says_why_not(name: str, pairs: Any) -> None:
    """Random states. Where an equation of the loops has next to no say, single precision cannot tell it from a
    redundant one, and which way the mechanism moves is left to forces: nothing more is asked there than numbers and
    closed loops, or a status. Elsewhere round-off explains the difference, also beside equations that are redundant for
    good, as those of a Sarrus linkage with a leg at rest are."""
    pair = pairs(name)
    rank = pair.simulator.program.rank
    generator = np.random.default_rng(20)
    reasons = {pair.single.status(reason) for reason in ("CLOSURE_LOST", "STEP_TOO_LONG")}
    compared = 0
    for _ in range(400):  # of a sheet one in twenty closes and is far enough from singular
        state = random_state(pair, generator)
        if state is None:
            continue
        status, here = started(pair.single, pair.count, state)
        if status != 0:
            assert status == pair.single.status("BAD_STATE")
            continue
        status, moved = stepped(pair.single, here, H / 4.0, 16)
        assert status in {0} | reasons
        assert np.all(np.isfinite(pair.single.state(here)))
        assert outputs(pair.single, here).closure <= LOST * pair.size
        _, there = started(pair.double, pair.count, state)
        other, rows = stepped(pair.double, there, H / 4.0, 16)
        pivots = np.array([pair.conditions(y)[:rank] for y in (state, *rows)])
        has_say = pivots > 1e-8
        least = pivots[has_say].min()
        if other != 0 or least < 1e-2:
            continue
        # A position is off by round-off over the pivot, and the tangent there turns by that over the pivot again; each
        # of sixteen steps adds two roundings of the state, and the motion makes of them what it makes of a nudge.
        assert status == 0
        nudged = 1e-9 * generator.choice([-1.0, 1.0], len(state))
        _, there = started(pair.double, pair.count, state + nudged)
        aside = np.abs(stepped(pair.double, there, H / 4.0, 16)[1] - rows).max(axis=1)
        growth = max(1.0, float(aside.max() / aside[0]))
        bound = 32 * EPSILON / least**2 * max(1.0, float(np.abs(rows).max()))
        assert np.abs(moved - rows).max() <= growth * bound
        compared += 1
    assert compared >= (10 if name != "folding_box" else 0)
