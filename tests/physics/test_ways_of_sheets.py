"""Which way a flat sheet of many free rates goes from rest: by Gauss's principle, in numbers of its own."""

from pathlib import Path
from typing import Any, Literal

import numpy as np
import pytest

import lamc
from lamc.loops.geometry import geometry_of
from lamc.loops.least_constraint import least_constrained
from lamc.loops.rank import count_loops
from lamc.loops.starts import Starter
from lamc.loops.tangents import EXACTLY, FEW_FREE, tangents
from lamc.mechanism.plan import plan
from lamc.records.mechanism import Mechanism
from lamc.records.scene import Scene
from tests.support import fold_corpus
from tests.support.ctools import needs_cc


def sheet(folder: Path, data: fold_corpus.Data, facets: Literal["rigid"] | None = None) -> Mechanism:
    path = fold_corpus.write(folder / "sheet.fold", data)
    loaded = lamc.load(path, card=lamc.Card(), crease=1e-3, facets=facets)
    assert isinstance(loaded, Mechanism)
    return loaded


@needs_cc
def test_inertia_in_numbers_is_that_of_the_generated_energies(tmp_path: Path) -> None:
    sim = lamc.compile(sheet(tmp_path, fold_corpus.hypar(4)), Scene(without=("gravity",)))
    random = np.random.default_rng(5)
    geometry = geometry_of(plan(sim.mechanism))
    order = [sim.joints.index(name) for name in geometry.names]
    result = sim.run(0.01, t_eval=[0.0, 0.01])  # folded a little, on closure
    for angles in (np.zeros(len(geometry.names)), result.q[-1][order]):
        rates = geometry.linear(angles).free()
        some = random.normal(size=len(rates))
        row = np.zeros((1, 2 * len(order)))
        row[0, order] = angles
        row[0, [len(order) + k for k in order]] = some @ rates
        kinetic = float(sim._default_motion.energies(np.zeros(1), row)[0, 0])
        assert 0.5 * some @ geometry.inertia(angles, rates) @ some == pytest.approx(kinetic, rel=1e-10)


@pytest.mark.parametrize("kind", ["yoshimura", "kresling"])
def test_the_way_taken_has_most_work_done_on_it_near_by(kind: str, tmp_path: Path) -> None:
    """No direction on the cone of the second order, a little beside it, has more work done on it for its inertia."""
    mechanism = sheet(tmp_path, getattr(fold_corpus, kind)(5, 5), facets="rigid")
    geometry = geometry_of(plan(mechanism))
    flat = np.zeros(len(geometry.names))
    local = tangents(geometry, flat)
    assert local.basis.shape[1] > FEW_FREE
    rest = np.array([mechanism.joint(name).rest_angle for name in geometry.names])
    inertia = geometry.inertia(flat, local.basis.T)
    asked = np.linalg.solve(inertia, local.basis.T @ rest)  # springs of one stiffness

    def work(x: np.ndarray[Any, Any]) -> float:
        return float(x @ inertia @ asked / np.sqrt(x @ inertia @ x))

    found = next(least_constrained(local, inertia, local.basis @ asked, EXACTLY))
    assert np.abs(local.values(found)).max() < 1e-10
    assert work(found) > 0.0
    nearest = local.local.nearest(local.basis, local.basis @ asked) if local.local else None
    assert nearest is None or work(found) >= work(local.basis.T @ nearest) - 1e-12
    random = np.random.default_rng(6)
    _, _, right = np.linalg.svd(local.slopes(found))
    along = right[np.linalg.matrix_rank(local.slopes(found), 1e-6) :]
    for _ in range(20):
        beside = found + 1e-3 * along.T @ random.normal(size=len(along))
        # Off the cone by 1e-6 of its second order; work is even there, and the search ends where a round gains 1e-4.
        assert work(beside) < work(found) * (1.0 + 1e-2)


def test_an_annulus_of_many_creases_has_all_its_freedoms(tmp_path: Path) -> None:
    """One loop of 70 creases has three equations, as they meet in the middle; it was counted as having no freedom."""
    count, angle = 70, 2.0 * np.pi / 70
    ring = [(r * np.cos(k * angle), r * np.sin(k * angle)) for r in (10.0, 30.0) for k in range(count)]
    data = fold_corpus._started(ring, "mm")
    for k in range(count):
        for start in (0, count):
            fold_corpus._edge(data, start + k, start + (k + 1) % count, "B")
        fold_corpus._edge(data, k, count + k, "MV"[k % 2])
    mechanism = sheet(tmp_path, data, facets="rigid")
    found = count_loops(plan(mechanism))
    assert (found.loops, found.rank, found.freedoms) == (1, 3, count - 3)


@needs_cc
def test_a_start_beside_a_flat_position_holds_its_loops_well(tmp_path: Path) -> None:
    """A large sheet starts where its weakest equations are no round-off, and closed."""
    sim = lamc.compile(sheet(tmp_path, fold_corpus.hypar(6)), Scene(without=("gravity",)))
    starter = sim._starter
    assert isinstance(starter, Starter)
    angles = sim.start[: len(sim.joints)]
    linear = starter.geometry.linear(angles)
    assert np.abs(starter.geometry.closure(angles)[0]).max() < 1e-12
    assert linear.weak[0][linear.nullity()] >= 1e-5 or np.abs(angles).max() > 0.045
    assert 1e-3 <= np.abs(angles).max() <= 0.05 + 1e-9
