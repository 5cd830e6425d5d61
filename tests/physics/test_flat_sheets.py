"""Large sheets that start flat: they go where their creases push, from a place at which the closure holds."""

import warnings
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import lamc
from lamc.basics.errors import DesignWarning
from lamc.loops.geometry import LoopGeometry
from lamc.loops.rank import count_loops
from lamc.loops.tangents import EXACTLY, FEW_FREE, MOST_FREE, tangents
from lamc.loops.zeros import arrivals
from lamc.mechanism.plan import plan
from lamc.records.mechanism import Mechanism
from tests.support.ctools import needs_cc
from tests.support.fold_corpus import Data, miura, write

pytestmark = needs_cc


def loaded(folder: Path, data: Data) -> Mechanism:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DesignWarning)
        mechanism = lamc.load(write(folder / "sheet.fold", data))
    assert isinstance(mechanism, Mechanism)
    return mechanism


def crossed(columns: int, rows: int) -> Data:
    """Square cells, 20 mm wide, each with its diagonals, mountains, and a level middle line, a valley. Two straight
    lines cross in the middle of every upright side: only one of them can fold there."""
    data: dict[str, Any] = {"file_spec": 1.1, "frame_unit": "mm"}
    places: dict[tuple[int, int], int] = {}
    edges: dict[tuple[int, int], str] = {}

    def line(*ways: tuple[int, int], kind: str) -> None:
        a, b = (places.setdefault(way, len(places)) for way in ways)
        edges.setdefault((min(a, b), max(a, b)), kind)

    for i, j in np.ndindex(columns, rows):
        x, y = 2 * i, 2 * j
        for dx, dy in ((0, 0), (2, 0), (2, 2), (0, 2)):
            line((x + 1, y + 1), (x + dx, y + dy), kind="M")
        for side in (0, 2):
            rim = x + side in (0, 2 * columns)
            line((x + 1, y + 1), (x + side, y + 1), kind="V")
            line((x + side, y), (x + side, y + 1), kind="B" if rim else "M")
            line((x + side, y + 1), (x + side, y + 2), kind="B" if rim else "M")
            line((x, y + side), (x + 2, y + side), kind="B" if y + side in (0, 2 * rows) else "V")
    data["vertices_coords"] = [[10.0 * x, 10.0 * y] for x, y in places]
    data["edges_vertices"] = [list(pair) for pair in edges]
    data["edges_assignment"] = list(edges.values())
    return data


@pytest.mark.slow
def test_a_sheet_of_crossing_lines_starts_where_one_of_them_folds(tmp_path: Path) -> None:
    """Loads ask for the same of both lines at some crossings. Where neither folds the equation there goes by the third
    power of the way out, and steps of 1e-13 s follow."""
    sim = lamc.compile(loaded(tmp_path, crossed(7, 7)))
    (branch,) = sim.branches
    assert (
        branch.freedoms == sim.loops.freedoms
    )  # slopes that vanish there would add one for each such crossing
    result = sim.run(1e-4, rtol=1e-6, max_steps=200)  # it takes 30
    assert result.success, result.message


@pytest.mark.slow
@pytest.mark.parametrize(("across", "along"), [(6, 78), pytest.param(42, 42, marks=pytest.mark.campaign)])
def test_sheets_of_quadrilaterals_start_however_many_rates_are_free(
    tmp_path: Path, across: int, along: int
) -> None:
    """A flat Miura sheet of so many facets has 82 free rates. It folds as a whole, with all rates but one held, and
    along each of its straight lines."""
    mechanism = loaded(tmp_path, miura(across, along))
    count = count_loops(plan(mechanism))
    joints = len(mechanism.joints)
    assert count.shakes == 0
    assert joints - 2 * count.loops > MOST_FREE
    assert count.rank == joints - 1
    assert set(count.branch_ranks) <= {joints - 1, joints - (along - 1)}


@pytest.mark.slow
def test_a_miura_sheet_folds_as_its_creases_ask(tmp_path: Path) -> None:
    """Of more branches than are looked for, the one on which all creases fold as they rest has most work done on it."""
    sim = lamc.compile(loaded(tmp_path, miura(12, 12)), lamc.Scene(without=("gravity", "hinge_damping")))
    number = sim.pushed_branch
    assert number is not None
    branch = sim.branches[abs(number) - 1]
    rates = np.sign(number) * branch.row(sim.joints)
    rest = np.array([sim.mechanism.joint(name).rest_angle for name in sim.joints])
    assert branch.freedoms == 1
    assert (rates * rest > 0.0).all()
    assert sim.loops.rank == len(sim.joints) - 1
    # Pivots of a hundredth, one after the other across the sheet, make an equation of what is round-off of none.
    result = sim.run(0.2, rtol=1e-8)
    assert result.success, result.message
    for q, u in zip(result.q, result.u, strict=True):
        missed = sim.closure(q)[1] @ u
        assert (
            np.abs(missed).max() <= 1e-8 * np.abs(u).max() + 1e-12
        )  # as `NOISE` of tolerances.h, and at rest


def test_forms_by_vertices_have_the_zeros_of_forms_of_all_rates(tmp_path: Path) -> None:
    """Newton's method by vertices, and the forms themselves by the brackets of all screws."""
    mechanism = loaded(tmp_path, miura(10, 10))
    geometry = LoopGeometry(plan(mechanism))
    flat = np.zeros(len(mechanism.joints))
    local = tangents(geometry, flat)
    assert local.local is not None
    assert local.count > local.basis.shape[1] > FEW_FREE
    random = np.random.default_rng(3)
    starts = random.normal(size=(8, local.basis.shape[1]))
    zeros = arrivals(local, starts, EXACTLY)
    assert len(zeros) > 0
    linear = geometry.linear(flat)
    for zero in zeros:
        bias = geometry.rings.bias(flat, (local.basis @ zero)[:, None])[:, 0, 0]
        missed = bias + linear.matrix @ linear.least_change(-bias, 1e-9)
        assert np.abs(missed).max() < 1e-10  # of rates of length one: round-off of some hundred terms
