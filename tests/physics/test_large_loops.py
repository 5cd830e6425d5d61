"""Large loops, whose closure is eliminated row by row: by the plan, by an order found at run time, as one array; and
the Miura sheet against its closed forms."""

import dataclasses
import math
from collections.abc import Callable, Mapping

import numpy as np
import pytest
from scipy.integrate import quad

import lamc
from lamc.codegen import emit
from lamc.examples.miura import ACUTE, miura
from lamc.mechanics import closure_plan
from lamc.mechanics.closure_plan import eliminated
from lamc.readers.load import load_text
from lamc.records.mechanism import Array, Mechanism
from lamc.reference import Interpreter
from lamc.reference.newton_euler import NewtonEuler
from lamc.symbolic.pattern import PlanStep
from tests.support.ctools import needs_cc

pytestmark = needs_cc


def sheet(count: int) -> Mechanism:
    return lamc.split(load_text(miura(count, count), "miura"))


def followed(rows: list[dict[int, float]], plan: tuple[PlanStep, ...], count: int) -> Array:
    """What each step leaves of its row, (steps, count), by numbers alone."""
    left = np.zeros((len(plan), count))
    for k, step in enumerate(plan):
        for j, value in rows[step.row].items():
            left[k, j] = value
        for earlier in step.updates:
            pivot = plan[earlier].left[0]
            left[k] -= left[k, pivot] / left[earlier, pivot] * left[earlier]
    return left


@pytest.mark.parametrize("alike", closure_plan.ALIKE)
@pytest.mark.parametrize("seed", range(8))
def test_a_plan_takes_all_independent_rows_and_leaves_a_triangle(seed: int, alike: float) -> None:
    """Sparse rows of random numbers, a third of them sums of others. Pivots are the largest of their row, or have as
    much of it as is taken for as large."""
    random = np.random.default_rng(seed)
    m, n = int(random.integers(6, 40)), int(random.integers(5, 40))
    matrix = np.where(random.random((m, n)) < 3.0 / n, random.normal(size=(m, n)), 0.0)
    matrix[2 * m // 3 :] = np.where(random.random((m - 2 * m // 3, m)) < 2.0 / m, 1.0, 0.0) @ matrix
    rows = [{j: float(row[j]) for j in np.flatnonzero(row)} for row in matrix]
    rank = int(np.linalg.matrix_rank(matrix))
    plan = tuple(eliminated(rows, min(m, n), alike).steps)
    assert len(plan) == rank
    left = followed(rows, plan, n)
    pivots = [step.left[0] for step in plan]
    for k, step in enumerate(plan):
        assert set(np.flatnonzero(np.abs(left[k]) > 1e-9)) <= set(step.left)
        assert abs(left[k, pivots[k]]) >= alike * np.abs(left[k]).max() * (
            1 - 1e-12
        )  # round-off of another order
        assert not np.any(np.abs(left[k, pivots[:k]]) > 1e-9)  # what earlier steps eliminated is gone
    # The same rows: what is left spans what the rows span
    assert np.linalg.matrix_rank(np.vstack([matrix, left])) == rank


@pytest.fixture
def ways(monkeypatch: pytest.MonkeyPatch) -> Callable[[Mechanism, str], lamc.Simulator]:
    """Simulators of a mechanism by the "array", by the "plan", and by an order that is always "found"."""
    texts = emit._runtime()

    def made(mechanism: Mechanism, way: str) -> lamc.Simulator:
        with monkeypatch.context() as patch:
            if way == "array":
                patch.setattr(closure_plan, "_is_cheaper", lambda *_: False)
            if way == "found":
                patch.setattr(emit, "_runtime", lambda: without_plans(texts))
            # Another name, or the cache of compiled modules would give the one made before.
            return lamc.compile(dataclasses.replace(mechanism, name=f"{mechanism.name}_{way}"))

    return made


def without_plans(texts: Mapping[str, str]) -> dict[str, str]:
    """The runtime's files, of which no plan is ever good enough."""
    kept = "LAMC_R(0.02)"
    assert texts["loop_sparse.h"].count(kept) == 1
    return {**texts, "loop_sparse.h": texts["loop_sparse.h"].replace(kept, "LAMC_R(2.0)")}


@pytest.mark.parametrize("name", ["miura", "folding_box"])
@pytest.mark.slow
def test_all_ways_to_eliminate_give_one_motion(
    name: str, ways: Callable[[Mechanism, str], lamc.Simulator]
) -> None:
    """Accelerations at states along a run to its own round-off, and where the run ends to its tolerance."""
    mechanism = sheet(3) if name == "miura" else lamc.split(lamc.load(lamc.examples.path(name)))
    sims = {way: ways(mechanism, way) for way in ("array", "plan", "found")}
    assert "dynamics" in sims["array"].program.functions
    assert "residual" in sims["plan"].program.functions
    runs = {way: sim.run(t_end=0.3, rtol=1e-10, atol=1e-12) for way, sim in sims.items()}
    q, u = runs["array"].q, runs["array"].u
    there = {way: sim.acceleration(q, u) for way, sim in sims.items()}
    scale = np.abs(there["array"]).max()
    for way in ("plan", "found"):
        # 1e-13 of closed states, over pivots of 0.1 and squared where the motion comes by a singular position
        assert np.abs(there[way] - there["array"]).max() <= 1e-9 * scale
        assert np.abs(runs[way].q[-1] - q[-1]).max() <= 1e-8 * max(1.0, float(np.abs(q).max()))
        # A step is no more often rejected than by complete pivoting, but for a few.
        assert runs[way].stats.accepted <= 1.2 * runs["array"].stats.accepted + 5


def folded(names: tuple[str, ...], zigzag: float, known: Mapping[str, float]) -> Array:
    """Angles of all creases where the zigzag ones are at ±zigzag: tan(s/2) = cos(acute) tan(z/2) (Schenk & Guest,
    "Geometry of Miura-folded metamaterials", PNAS 110, 2013; T. Tachi, 2009). known: a folded position, for signs."""
    straight = 2.0 * math.atan(math.cos(ACUTE) * math.tan(zigzag / 2.0))
    return np.array([math.copysign(zigzag if name[0] == "z" else straight, known[name]) for name in names])


def tangent_of(names: tuple[str, ...], q: Array, zigzag: float) -> Array:
    """Rates of all creases at these angles for a rate of 1 rad/s of the zigzag ones."""
    cosine, tangent = math.cos(ACUTE), math.tan(zigzag / 2.0)
    slope = cosine * (1.0 + tangent**2) / (1.0 + (cosine * tangent) ** 2)
    return np.sign(q) * np.array([1.0 if name[0] == "z" else slope for name in names])


@pytest.mark.parametrize(
    "count", [4, pytest.param(8, marks=pytest.mark.slow), pytest.param(16, marks=pytest.mark.campaign)]
)
def test_miura_sheets_fold_as_their_closed_form(count: int) -> None:
    """Along the whole fold: closed to 1e-12, and moving along the tangent of the closed form to 1e-12."""
    sim = lamc.compile(sheet(count))
    names, start = sim.joints, sim.start
    known = dict(zip(names, start[: len(names)], strict=True))
    rank = sim.program.rank
    assert len(names) - rank == 1
    for zigzag in np.radians([0.5, 5.0, 30.0, 60.0, 90.0, 120.0, 150.0, 175.0]):
        q = folded(names, zigzag, known)
        residual, jacobian = sim.closure(q)
        assert np.abs(residual).max() <= 1e-12
        assert np.abs(jacobian @ tangent_of(names, q, zigzag)).max() <= 1e-12


@pytest.mark.parametrize("count", [5, pytest.param(8, marks=pytest.mark.campaign)])
def test_three_formulations_agree_on_sheets(count: int) -> None:
    """The C, by a table of kernels at 8 x 8; the same program read in Python, with M put together from passes; and
    Newton and Euler's equations with a spanning tree of their own."""
    mechanism = sheet(count)
    sim = lamc.compile(mechanism)
    assert "momenta" in sim.program.functions
    newton = NewtonEuler(mechanism, sim.effects, sim.joints)
    interpreter = Interpreter(sim.program)
    constants = interpreter.constants()
    result = sim.run(t_end=0.05, rtol=1e-9, atol=1e-11, t_eval=np.array([0.0, 0.02, 0.05]))
    for t, q, u in zip(result.t.tolist(), result.q, result.u, strict=True):
        found = sim.acceleration(q, u, t)
        scale = np.abs(found).max()
        # Round-off of closed positions, 1e-13, times the condition of the closure, some hundred, squared
        assert np.abs(found - interpreter.acceleration(t, q, u, constants)).max() <= 1e-9 * scale
        assert np.abs(found - newton.acceleration(q, u, t)).max() <= 1e-9 * scale


def test_one_freedom_by_quadrature() -> None:
    """A sheet that springs on from rest at 30 degrees: ½ I(z) ż² + V(z) = V(30°), so that the time to 50 degrees is an
    integral; I and V of the closed form's rates and angles from the independent formulation of the bodies' motion."""
    mechanism = sheet(4)
    effects = (lamc.HingeStiffness(), lamc.RestAngle())
    scene = lamc.Scene(effects=effects, angles=(mechanism.scene or lamc.Scene()).angles)
    sim = lamc.compile(mechanism, scene)
    names = sim.joints
    newton = NewtonEuler(mechanism, effects, names)
    known = dict(zip(names, sim.start[: len(names)], strict=True))
    first, last = math.radians(30.0), math.radians(50.0)
    still = np.zeros(len(names))

    def potential(z: float) -> float:
        return sum(newton.energy(folded(names, z, known), still).values())

    def slowness(root: float) -> float:
        """dt / d(root), where z = first + root²: regular at the start, which is at rest."""
        z = first + root**2
        q = folded(names, z, known)
        inertia = 2.0 * newton.energy(q, tangent_of(names, q, z))["kinetic"]
        return 2.0 * root / math.sqrt(2.0 * (potential(first) - potential(z)) / inertia)

    time = quad(slowness, 0.0, math.sqrt(last - first), epsabs=0.0, epsrel=1e-11, limit=200)[0]
    result = sim.run(t_end=time, rtol=1e-12, atol=1e-14)
    assert np.abs(result.q[-1] - folded(names, last, known)).max() <= 1e-9
