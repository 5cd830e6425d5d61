"""Closed loops against independently computed answers: ranks, motion, closure, starts, refusals."""

import dataclasses
import json
import math
import subprocess
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import lamc
from lamc.codegen.build import write_sources
from lamc.pipeline import sources_of
from lamc.run.request import Status
from lamc.run.simulator import Simulator
from tests.support.ctools import SANITIZED, STRICT, cc, needs_cc, objects_of, output_of
from tests.support.mechanisms import from_reference

CASES = (
    "fourbar_crank",
    "fivebar",
    "vertex4_flatfoldable",
    "waterbomb6",
    "miura22",
    "miura33",
    "bricard",
    "sarrus",
)


@pytest.fixture(scope="module")
def cases(shared: Path) -> dict[str, Any]:
    text = (shared / "reference" / "dynamics.json").read_text(encoding="utf-8")
    return {case["id"]: case for case in json.loads(text)["cases"]}


def simulator(case: dict[str, Any]) -> Simulator:
    mechanism, scene = from_reference(case["spec"])
    return lamc.compile(mechanism, scene)


@pytest.mark.parametrize("name", [*CASES, "nfourbar2"])
def test_loops_are_counted_as_in_the_field(cases: dict[str, Any], name: str) -> None:
    expected = cases["loop_ranks"]["expected"][name]
    loops = simulator(cases[name]).loops
    assert (loops.loops, loops.equations, loops.rank) == (
        expected["loops"],
        expected["closure_equations"],
        expected["rank"],
    )
    assert (loops.freedoms, loops.redundant) == (expected["mobility"], expected["redundant"])


@pytest.mark.parametrize("rtol", [1e-6, 1e-9])
@pytest.mark.parametrize("name", CASES)
def test_loops_move_as_computed_independently(cases: dict[str, Any], name: str, rtol: float) -> None:
    case = cases[name]
    sim = simulator(case)
    times = [row["t"] for row in case["expected"]]
    result = sim.run(t_end=times[-1], rtol=rtol, atol=1e-2 * rtol, t_eval=times)
    assert result.success, result.message
    limit = 1e-4 if rtol == 1e-6 else 1e-6  # the file's own rule for what it accepts
    for k, (row, tol) in enumerate(zip(case["expected"], case["tol"], strict=True)):
        for joint, angle in row["theta"].items():
            difference = math.remainder(result.angle(joint)[k] - angle, 2 * math.pi)
            assert abs(difference) <= max(tol, limit), (joint, row["t"])
    assert result.constraint_error.max() <= 1e-9 * sim.mechanism.size  # the file's own rule
    if rtol == 1e-9:
        drift = np.abs(result.energy - result.energy[0]).max()
        assert drift <= 1e-7 * abs(result.energy[0])  # the file's own rule
    assert result.stats.rejected is not None
    # The lock-up of redundant equations shows in 20 to 250 times the steps, nearly all of them rejected.
    assert result.stats.rejected < result.stats.accepted / 3


@pytest.mark.parametrize("rtol", [1e-6, 1e-8, 1e-10, 1e-12])
def test_a_mechanism_passes_through_its_singular_position_on_its_branch(
    cases: dict[str, Any], rtol: float
) -> None:
    case = cases["nfourbar2"]
    times = [row["t"] for row in case["expected"]]
    result = simulator(case).run(t_end=times[-1], rtol=rtol, atol=1e-2 * rtol, t_eval=times)
    assert result.success, result.message
    for k, row in enumerate(case["expected"]):
        for joint, angle in row["theta"].items():
            difference = math.remainder(result.angle(joint)[k] - angle, 2 * math.pi)
            assert abs(difference) <= 1e-3, (joint, row["t"])  # the file's own rule for singular passage
    drift = np.abs(result.energy - result.energy[0]).max()
    assert drift <= 1e-4 * abs(result.energy[0])  # the file's own rule


@pytest.mark.parametrize("rtol", [1e-8, 1e-12])
@pytest.mark.parametrize("name", ["vertex4_flatfoldable", "miura22", "miura33"])
@pytest.mark.quick("vertex4_flatfoldable-*", "miura22-*")
def test_origami_swings_through_its_flat_state_at_any_tolerance(
    cases: dict[str, Any], name: str, rtol: float
) -> None:
    """Springs that rest flat and no gravity: flat is passed again and again, where the rank falls."""
    mechanism, scene = from_reference(cases[name]["spec"])
    flat = dataclasses.replace(
        mechanism, joints=tuple(dataclasses.replace(j, rest_angle=0.0) for j in mechanism.joints)
    )
    sim = lamc.compile(flat, lamc.Scene(effects=(lamc.HingeStiffness(),), angles=scene.angles))
    result = sim.run(t_end=1.0, rtol=rtol, atol=1e-2 * rtol)
    assert result.success, result.message
    passages = int((np.diff(np.sign(result.q[:, 0])) != 0).sum())
    assert passages >= 10
    assert result.constraint_error.max() <= 1e-9 * sim.mechanism.size  # the reference file's rule for loops
    drift = np.abs(result.energy - result.energy[0]).max() / result.energy[0]
    # What the steps cost at 1e-8; at 1e-12 what is left is what the passages cost, some 1e-9 each.
    assert drift <= (1e-6 if rtol == 1e-8 else 1e-7)
    if name == "vertex4_flatfoldable":
        # Its sectors are 60° and 75°. Along one branch the tangents of half the fold angles keep the ratio
        # tan(75°/2) - tan(60°/2) over their sum; along the other they do not (Tachi 2009).
        lesser, larger = math.tan(math.radians(30.0)), math.tan(math.radians(37.5))
        ratio = (larger - lesser) / (larger + lesser)
        halves = [np.tan(0.5 * result.angle(joint)) for joint in ("c1", "c2")]
        assert np.abs(halves[1] - ratio * halves[0]).max() <= 1e-8  # the drawing has angles to 1e-9 or better


@pytest.mark.parametrize("rtol", [1e-6, 1e-8, 1e-10])
@pytest.mark.parametrize("down", [-9.81, 9.81])
@pytest.mark.parametrize("name", ["vertex4_flatfoldable", "miura22", "miura33"])
@pytest.mark.quick("vertex4_flatfoldable-*-1e-08", "miura22-*", "miura33-9.81-1e-08", others="campaign")
def test_gravity_drives_origami_through_its_flat_state(
    cases: dict[str, Any], name: str, down: float, rtol: float
) -> None:
    """Weight pulls across the branch where the rank falls, and nothing but closure holds it there."""
    mechanism, scene = from_reference(cases[name]["spec"])
    flat = dataclasses.replace(
        mechanism, joints=tuple(dataclasses.replace(j, rest_angle=0.0) for j in mechanism.joints)
    )
    effects = (lamc.HingeStiffness(), lamc.effects.Gravity((0.0, 0.0, down)))
    sim = lamc.compile(flat, lamc.Scene(effects=effects, angles=scene.angles))
    refused = []
    for k in range(
        5
    ):  # which steps a passage refuses is a matter of round-off: the same, but for its last digits
        weight = {"gravity.z": sim.parameters["gravity.z"] * (1.0 + 1e-13 * k)}
        result = sim.run(t_end=1.0, rtol=rtol, atol=1e-2 * rtol, parameters=weight)
        assert result.success, result.message
        assert (np.diff(np.sign(result.q[:, 0])) != 0).sum() >= 10
        assert result.constraint_error.max() <= 1e-9 * mechanism.size  # the reference file's rule for loops
        assert result.stats.rejected is not None
        refused.append(result.stats.rejected / result.stats.accepted)
        in_play = sum(np.abs(energy).max() for energy in result.energies.values())
        drift = np.abs(result.energy - result.energy[0]).max() / in_play
        # What some hundred steps cost, and below it what the passages do, some 1e-9 each.
        assert drift <= 10.0 * len(result.t) * rtol + 1e-7
    # The lock-up of redundant equations shows in 20 to 250 times the steps, nearly all of them rejected.
    assert np.median(refused) < 1 / 3


@pytest.mark.parametrize("lightness", [1e-3, 1e-6, 1e-9])
def test_a_light_body_in_a_loop_is_no_singular_position(cases: dict[str, Any], lightness: float) -> None:
    """Its equations are small beside others in the mass metric; they are not let go for that."""
    mechanism, scene = from_reference(cases["fourbar_crank"]["spec"])
    light = tuple(
        dataclasses.replace(b, mass=lightness * b.mass, inertia=lightness * b.inertia)
        if b.name == "crank"
        else b
        for b in mechanism.bodies
    )
    sim = lamc.compile(dataclasses.replace(mechanism, bodies=light), scene)
    result = sim.run(t_end=0.5, rtol=1e-9, atol=1e-11)
    assert result.success, result.message
    assert result.constraint_error.max() <= 1e-9 * mechanism.size  # the reference file's rule for loops
    drift = np.abs(result.energy - result.energy[0]).max()
    assert drift <= 1e-7 * abs(result.energy[0])  # likewise


def test_angles_left_out_follow_from_closure(cases: dict[str, Any]) -> None:
    mechanism, scene = from_reference(cases["fourbar_crank"]["spec"])
    whole = lamc.compile(mechanism, scene)
    first = next(iter(whole.joints))
    given = lamc.Scene(effects=scene.effects, angles={first: scene.angles[first]})
    start = lamc.compile(mechanism, given).start
    state = lamc.compile(mechanism, given).run(t_end=0.0, t_eval=[0.0])
    assert state.angle(first)[0] == scene.angles[first]
    assert state.constraint_error[0] <= 1e-12 * mechanism.size  # a few hundred units of round-off
    assert np.isfinite(start).all()


def test_rates_left_out_follow_from_closure(cases: dict[str, Any]) -> None:
    mechanism, scene = from_reference(cases["fivebar"]["spec"])
    names = lamc.compile(mechanism, scene).joints
    turning = lamc.Scene(effects=scene.effects, angles=scene.angles, rates={names[0]: 2.0})
    result = lamc.compile(mechanism, turning).run(t_end=1e-3, rtol=1e-10, atol=1e-12)
    assert result.rate(names[0])[0] == pytest.approx(2.0, abs=1e-9)  # one linear solve
    assert result.constraint_error.max() <= 1e-12 * mechanism.size  # a few hundred units of round-off


def test_angles_that_cannot_close_are_refused_with_the_gap(cases: dict[str, Any]) -> None:
    mechanism, scene = from_reference(cases["fourbar_crank"]["spec"])
    impossible = dict.fromkeys(lamc.compile(mechanism, scene).joints, 1.5)
    sim = lamc.compile(mechanism, lamc.Scene(effects=(), angles=impossible))
    with pytest.raises(lamc.DesignError, match=r"no position closes the loops .* within [\d.e-]+ m"):
        sim.run(t_end=0.1)


def test_rates_that_contradict_each_other_are_refused(cases: dict[str, Any]) -> None:
    mechanism, scene = from_reference(cases["fourbar_crank"]["spec"])
    rates = {name: 1.0 + k for k, name in enumerate(lamc.compile(mechanism, scene).joints)}
    sim = lamc.compile(mechanism, lamc.Scene(effects=(), angles=scene.angles, rates=rates))
    with pytest.raises(lamc.DesignError, match="no motion of the loops has the rates given"):
        sim.run(t_end=0.1)


def test_accelerations_keep_the_loops_closed(cases: dict[str, Any]) -> None:
    """J u̇ + γ is the second derivative of the residuals: a small step in time shows it by differences."""
    sim = simulator(cases["vertex4_flatfoldable"])
    result = sim.run(t_end=0.02, rtol=1e-11, atol=1e-13, t_eval=np.linspace(0.01, 0.02, 5))
    h = 1e-4
    for q, u in zip(result.q, result.u, strict=True):
        acceleration = sim.acceleration(q, u)
        ahead, behind = (q + s * h * u + 0.5 * h * h * acceleration for s in (1, -1))
        gaps = [
            sim._model.motion({}).closures(np.concatenate([x, u]).reshape(1, -1))[0] for x in (ahead, behind)
        ]
        m = sim._model.closure_count
        # Third order in h at most: h³ u³ and the like, with u of some 10 rad/s and lengths of 0.05 m.
        assert max(np.abs(g[:m]).max() for g in gaps) < 0.1 * (h * 50.0) ** 3


@needs_cc
@pytest.mark.slow
def test_c_of_a_mechanism_with_loops_is_strict_and_clean_under_sanitizers(
    cases: dict[str, Any], tmp_path: Path
) -> None:
    sim = simulator(cases["miura33"])
    _, tree = sources_of(sim.equations)
    write_sources(tree, tmp_path)
    cc(tmp_path, *SANITIZED, "main.c", *objects_of(tree, tmp_path, *SANITIZED), "-o", "run", "-lm")
    assert output_of(tmp_path / "run").count("\n") == 102  # a header and 101 rows


@needs_cc
def test_c_folds_a_cut_hinge_with_a_spring_past_180_degrees(cases: dict[str, Any], tmp_path: Path) -> None:
    """From rest as drawn: nothing stops this sheet there."""
    sim = simulator(cases["miura22"])
    _, tree = sources_of(sim.equations)
    write_sources(tree, tmp_path)
    cc(tmp_path, *STRICT, "main.c", *objects_of(tree, tmp_path, *STRICT), "-o", "run", "-lm")
    done = subprocess.run([str(tmp_path / "run")], capture_output=True, text=True, timeout=120, check=False)
    assert done.returncode == 0, done.stderr
    _, *rows = (line.split(",") for line in done.stdout.splitlines())
    angles = np.array([float(row[len(sim.joints)]) for row in rows])  # the last joint's, behind the time
    assert np.abs(angles).max() > np.pi
    assert np.abs(np.diff(angles)).max() < np.pi  # from row to row; a jump would be 2 pi less that


def test_a_state_that_is_no_number_is_none_that_closes(cases: dict[str, Any]) -> None:
    """Whichever of several loops has it, and whatever the others are."""
    sim = simulator(cases["miura33"])
    motion = sim._model.motion({})
    lib, ffi = motion.model.lib, motion.model.ffi
    for place in range(len(sim.joints)):
        y = sim.run(t_end=0.0).y[:, 0].copy()
        y[place] = np.nan
        memory = ffi.from_buffer("double[]", y, require_writable=True)
        with motion.opened() as handle:
            status = lib.lamc_motion_settle(handle, 0.0, memory, ffi.new("double *"))
        assert status == Status.CLOSURE_LOST, sim.joints[place]
