"""A sheet moves as its pattern says, whatever file it comes from."""

import json
import math
import warnings
from pathlib import Path

import numpy as np
import pytest

import lamc
from lamc.basics.errors import DesignWarning
from lamc.records.mechanism import Mechanism
from tests.support import fold_corpus as corpus
from tests.support.ctools import needs_cc
from tests.support.same_motion import assert_same_motion

COLUMNS, ROWS = 3, 3
Corner = tuple[int, int]
THICKNESS, DENSITY, CREASE = 3e-4, 700.0, 1e-3  # m, kg/m³, N·m/rad/m


def load(path: Path, data: corpus.Data, **options: object) -> Mechanism:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DesignWarning)
        made = lamc.load(
            corpus.write(path, data), card=lamc.Card(THICKNESS, DENSITY), crease=CREASE, **options
        )  # type: ignore[arg-type]
    assert isinstance(made, Mechanism)
    return made


def facet(i: int, j: int) -> dict[str, object]:
    """A parallelogram of card, by the closed form of its moments: A/12 (u u + v v) about its middle."""
    a, b, c = (np.array(corpus.miura_corner(*at)) * 1e-3 for at in ((i, j), (i + 1, j), (i, j + 1)))
    u, v = b - a, c - a
    area = abs(u[0] * v[1] - u[1] * v[0])
    second = np.zeros((3, 3))
    second[:2, :2] = area / 12.0 * (np.outer(u, u) + np.outer(v, v))
    second[2, 2] = area * THICKNESS**2 / 12.0
    second *= DENSITY * THICKNESS
    return {
        "name": f"f{i}_{j}",
        "mass": float(DENSITY * THICKNESS * area),
        "com": [*(a + 0.5 * (u + v)).tolist(), THICKNESS / 2],
        "inertia": (np.trace(second) * np.eye(3) - second).tolist(),
        "fixed": (i, j) == (0, 0),
    }


def hinge(name: str, parent: str, child: str, start: Corner, end: Corner, rest: float) -> dict[str, object]:
    """The child lies to the left of start → end."""
    p, q = (np.array([*corpus.miura_corner(*at), 0.0]) * 1e-3 for at in (start, end))
    length = float(np.linalg.norm(q - p))
    point = [*p[:2].tolist(), THICKNESS / 2]
    springs = {"stiffness": CREASE * length, "damping": 2e-7, "rest_angle": rest}
    return {
        "name": name,
        "parent": parent,
        "child": child,
        "point": point,
        "axis": (q - p).tolist(),
        **springs,
    }


def by_hand() -> dict[str, object]:
    """The Miura-ori as a mechanism: zigzag creases z, straight ones s, each before its facet."""
    rest = math.radians(60.0)
    joints = []
    for j in range(ROWS):
        for i in range(1, COLUMNS):
            sign = 1.0 if i % 2 else -1.0
            ends = (i, j + 1), (i, j)
            joints.append(hinge(f"z{i}_{j}", f"f{i - 1}_{j}", f"f{i}_{j}", *ends, sign * rest))
    for j in range(1, ROWS):
        for i in range(COLUMNS):
            sign = 1.0 if (i + j) % 2 == 0 else -1.0
            ends = (i, j), (i + 1, j)
            joints.append(hinge(f"s{i}_{j}", f"f{i}_{j - 1}", f"f{i}_{j}", *ends, sign * rest))
    bodies = [facet(i, j) for i in range(COLUMNS) for j in range(ROWS)]
    return {"kind": "mechanism", "name": "miura", "bodies": bodies, "joints": joints}


@pytest.mark.parametrize("faces", [False, True])
def test_a_miura_from_fold_moves_as_one_from_yaml(tmp_path: Path, *, faces: bool) -> None:
    (tmp_path / "miura.yaml").write_text(json.dumps(by_hand()))
    hand = lamc.load(tmp_path / "miura.yaml")
    fold = load(tmp_path / "miura.fold", corpus.miura(COLUMNS, ROWS, faces=faces), fixed=(0.012, 0.005))
    assert isinstance(hand, Mechanism)
    assert_same_motion(hand, fold)


@pytest.mark.quick("box_net", others="campaign")
@pytest.mark.parametrize("make", [lambda: corpus.miura(4, 4), corpus.waterbomb, corpus.box_net])
def test_flat_sheets_fold_the_way_that_their_creases_are_marked(tmp_path: Path, make: object) -> None:
    sheet = load(tmp_path / "sheet.fold", make())  # type: ignore[operator]
    result = lamc.compile(sheet, lamc.Scene(without=("gravity",))).run(t_end=3.0)
    for joint in sheet.joints:
        assert result.angle(joint.name)[-1] * joint.rest_angle > 0.0, joint.name


@needs_cc
def test_a_crease_of_no_loop_is_no_branch_beside_a_flat_vertex(tmp_path: Path) -> None:
    """One inner vertex of six creases, and a crease of no loop: to move that one alone is no branch, but the edge of
    the family on which the vertex folds too. Of that there are an example, and the one on which loads do most work."""
    sim = lamc.compile(load(tmp_path / "yoshimura.fold", corpus.yoshimura(2, 2)))
    assert (sim.loops.rank, sim.loops.freedoms, len(sim.branches)) == (3, 5, 2)
    assert {branch.freedoms for branch in sim.branches} == {5}
    result = sim.run(t_end=0.05)
    assert result.success, result.message
    assert result.constraint_error.max() <= 1e-9 * sim.mechanism.size
    assert result.energies["kinetic"].max() > 0.0
