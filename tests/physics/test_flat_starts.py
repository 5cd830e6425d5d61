"""Starts that are flat and at rest: the branch that the loads choose, against the runs along all of them."""

import warnings
from dataclasses import replace
from importlib.resources import as_file, files
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import lamc
from lamc.basics.errors import DesignWarning
from lamc.effects import Gravity, HingeStiffness, RestAngle, Torque
from lamc.loops.branches import Branch, find_branches
from lamc.loops.geometry import LoopGeometry
from lamc.loops.tangents import MOST_FREE
from lamc.mechanism.plan import plan
from lamc.records.mechanism import Body, Joint, Mechanism
from lamc.run.pushes import push_of
from tests.physics.test_loop_analysis import compiled, vertex
from tests.support.ctools import needs_cc
from tests.support.fold_corpus import write, yoshimura
from tests.support.sheets import flat_miura, sheet

pytestmark = needs_cc

SECTORS = (60.0, 75.0, 120.0, 105.0)
EARLY = 0.02  # s: some hundredths of a radian by gravity


def kinetic_energies(mechanism: Mechanism, **scene: Any) -> dict[int, float]:
    """After a short time on each branch and its opposite, J: what the loads have done by then; negative where they
    drove it back to flat and beyond."""
    count = len(compiled(mechanism, **scene).branches)
    found = {}
    for number in (k * way for k in range(1, count + 1) for way in (1, -1)):
        result = compiled(mechanism, branch=number, **scene).run(t_end=EARLY)
        assert result.success, result.message
        outward = float(np.sign(result.q[0] @ (result.q[-1] - result.q[0])))
        found[number] = outward * float(result.energies["kinetic"][-1])
    return found


LOADS: dict[str, tuple[Any, ...]] = {
    "gravity across the sheet": (Gravity((0.0, 0.0, -9.81)),),
    "gravity from below": (Gravity((0.0, 0.0, 9.81)),),
    "a torque on one crease": (Torque({"c1": -1e-3}),),
    "a torque on the crease that closes the loop": (Torque({"c2": 1e-3}),),
}


@pytest.mark.parametrize("name", sorted(LOADS))
@pytest.mark.quick("gravity across the sheet")
def test_a_flat_vertex_takes_the_branch_on_which_loads_do_most_work(name: str) -> None:
    mechanism = vertex(np.radians(SECTORS))
    done = kinetic_energies(mechanism, effects=LOADS[name])
    best = max(done, key=lambda number: done[number])
    assert done[best] > 1.02 * sorted(done.values())[-2]
    sim = compiled(mechanism, effects=LOADS[name])
    assert sim.pushed_branch == best
    result = sim.run(t_end=EARLY)
    assert result.success, result.message
    assert result.energies["kinetic"][-1] == pytest.approx(done[best], rel=1e-6)  # the same run


def test_where_the_first_order_vanishes_the_second_decides() -> None:
    """Gravity in the plane of the sheet: bodies below the fixed facet rise when folded, those above it fall."""
    mechanism = vertex(np.radians(SECTORS))
    for down in ((-9.81, 0.0, 0.0), (5.0, -7.0, 0.0), (-3.0, -9.0, 0.0)):
        effects = (Gravity(down),)
        falls = {}
        for number in (1, 2):
            sim = compiled(mechanism, effects=effects, branch=number)
            q = sim.start[: len(sim.joints)]
            still = np.zeros_like(q)
            rest = sim.energy(still, still)
            # Over the kinetic energy at such rates: it grows as exp(√ of that, by time).
            falls[number] = (rest - sim.energy(q, still)) / (sim.energy(still, q) - rest)
        chosen = compiled(mechanism, effects=effects).pushed_branch
        assert chosen == max(falls, key=lambda number: falls[number])  # positive: a tie goes by the order


def test_without_loads_the_first_branch_is_taken() -> None:
    sim = compiled(vertex(np.radians(SECTORS)))
    assert sim.pushed_branch == 1
    assert "takes branch 1 (c0 -0.1413, c1 1, c2 0.1413, c3 1)" in sim.notes[-1]
    assert "2: (c0 1, c1 -0.386, c2 1, c3 0.386)" in sim.notes[-1]
    assert np.abs(sim.run(t_end=0.1).u).max() == 0.0


def test_a_choice_in_the_scene_goes_before_the_loads() -> None:
    mechanism = vertex(np.radians(SECTORS))
    for scene in ({"branch": -2}, {"rates": {"c1": 2.0, "c3": 2.0}}, {"angles": {"c1": 0.3}}):
        sim = compiled(mechanism, effects=(Gravity(),), **scene)
        assert sim.pushed_branch is None
        assert not any("takes branch" in note for note in sim.notes)


def folded_bars(stiffness: float) -> Mechanism:
    """A parallelogram of three bars and the ground, drawn in one line; hinges along y: glued sheets, folded flat."""
    places = {"a": 0.0, "b": 0.03, "c": 0.08, "d": 0.05}
    bodies = [Body("ground", fixed=True)]
    for name, (start, end) in {"left": (0.0, 0.03), "top": (0.03, 0.08), "right": (0.05, 0.08)}.items():
        inertia = 1e-3 * (end - start) ** 2 / 12 * np.diag([0.01, 1.0, 1.0])
        bodies.append(Body(name, 1e-3, np.array([0.5 * (start + end), 0.0, 0.0]), inertia))
    pairs = {"a": ("ground", "left"), "b": ("left", "top"), "c": ("top", "right"), "d": ("ground", "right")}
    y = np.array([0.0, 1.0, 0.0])
    joints = tuple(
        Joint(name, *pair, np.array([places[name], 0.0, 0.0]), y, stiffness=stiffness, rest_angle=0.4)
        for name, pair in pairs.items()
    )
    return Mechanism(tuple(bodies), joints, name="bars")


def test_a_linkage_drawn_in_one_line_runs_without_an_option() -> None:
    """As parallelogram or crossed; down under gravity, up where its hinges rest folded upwards (about y: negative)."""
    down = lamc.compile(folded_bars(0.0), lamc.Scene(effects=(Gravity(),)))
    result = down.run(t_end=0.1)
    assert result.success, result.message
    assert result.pose("top")[0][-1, 2] < -1e-3
    sprung = lamc.compile(folded_bars(1e-2), lamc.Scene(effects=(HingeStiffness(), RestAngle())))
    result = sprung.run(t_end=0.02)
    assert result.success, result.message
    assert result.energies["kinetic"].max() > 0.0


@pytest.mark.parametrize("angle", [1e-6, 1e-5, 1e-4, 1e-3, 1e-2])
@pytest.mark.quick("1e-05")
def test_a_start_next_to_flat_is_had_by_one_angle_as_by_all(angle: float) -> None:
    """On one of the two published branches, and with the freedom that the vertex has there."""
    mechanism = vertex(np.radians(SECTORS))
    sim = compiled(mechanism, effects=(Gravity(),), angles={"c1": angle})
    assert (sim.loops.freedoms, sim.pushed_branch) == (1, None)
    q = sim.start[: len(sim.joints)]
    found = dict(zip(sim.joints, q.tolist(), strict=True))
    assert found["c1"] == angle
    # The other angles by the branch's ratios, to the second order in the angle; round-off of closure over the angle.
    assert abs(found["c0"] / angle) == pytest.approx(0.14128053239285, abs=angle**2 + 1e-14 / angle**2)
    again = compiled(mechanism, effects=(Gravity(),), angles=found)
    assert np.abs(again.start - sim.start).max() <= 1e-15


@pytest.mark.parametrize("angle", [1e-6, 1e-4])
def test_a_net_with_many_motions_keeps_them_next_to_flat(angle: float) -> None:
    with as_file(files("lamc.examples") / "folding_box.yaml") as path:
        box = lamc.split(lamc.load(path))
    sim = lamc.compile(box, lamc.Scene(angles={"diagonal_3": angle}))
    assert sim.loops.freedoms == 4
    assert sim.run(t_end=0.01).success


@pytest.mark.parametrize("count", [6, 8, 32])
@pytest.mark.slow
@pytest.mark.ci("6")
def test_a_large_sheet_that_lies_flat_finds_its_branch_by_itself(count: int) -> None:
    """A Miura fold of n x n facets has 2 (n - 1) free rates where it is flat. On the branch that a weight takes, its
    n - 1 straight lines fold, each by itself."""
    mechanism = sheet(flat_miura(count, count))
    sim = compiled(mechanism, effects=(Gravity((0.3, 0.2, -9.81)),))
    assert sim.loops.freedoms == count - 1
    assert sim.pushed_branch is not None
    assert np.abs(sim.start).max() > 0.0
    result = sim.run(t_end=0.02, rtol=1e-6, atol=1e-8)
    assert result.success, result.message
    assert result.constraint_error.max() <= 1e-9 * mechanism.size
    assert result.energies["kinetic"][-1] > 0.0


@pytest.mark.slow
def test_a_flat_sheet_of_many_free_rates_goes_where_its_creases_push(tmp_path: Path) -> None:
    """A Yoshimura sheet as FOLD files have it: three equations for each vertex within, and no branch but one family."""
    columns, rows = 6, 6
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DesignWarning)
        sheet = lamc.load(write(tmp_path / "sheet.fold", yoshimura(columns, rows)))
    assert isinstance(sheet, Mechanism)
    scene = lamc.Scene(without=("gravity", "hinge_damping"))
    sim = lamc.compile(sheet, scene)
    count = sim.loops
    vertices = sum(len(cycle.joints) == 6 for cycle in LoopGeometry(plan(sheet)).cycles)
    assert vertices == count.loops
    assert count.shakes == 0
    assert count.rank == 3 * vertices
    assert len(sim.joints) - 2 * vertices > MOST_FREE / 2  # rates that are free there to first order
    (branch,) = sim.branches
    assert branch.freedoms == count.freedoms
    ways = {number: lamc.compile(sheet, replace(scene, branch=number)) for number in (1, -1)}
    assert sim.pushed_branch in ways
    result = sim.run(t_end=1e-3, rtol=1e-8)
    assert result.success, result.message
    kinetic, total = result.energies["kinetic"], result.energy
    assert kinetic[-1] > 0.0
    assert np.abs(total - total[0]).max() <= 1e-6 * kinetic[-1]  # the tolerance, over some hundred steps
    # In a short time energy goes by the square of the force along the way: no random way has as much of it.
    other = find_branches(sim._starter.geometry, np.zeros(len(sim.joints)))[0]
    towards = sheet_energy(sim, branch), sheet_energy(sim, other)
    assert towards[0] > 2.0 * towards[1]


def sheet_energy(sim: lamc.Simulator, branch: Branch) -> float:
    """(f·τ)² / (τ·M τ), W: how fast springs would drive a sheet along a branch, from its flat start."""
    rows = branch.row(sim.joints)
    power, inertia = push_of(sim._default_motion, sim._arrangement)(np.zeros(len(rows)), rows)
    return power * power / inertia
