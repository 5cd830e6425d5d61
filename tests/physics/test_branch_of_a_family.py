"""Where branches part in families, the motion of a family on which loads do most work is taken.

A vertex of five creases or more leaves its flat position in a family. Of that the second order is one quadratic form,
and the work of springs over the root of twice the kinetic energy is largest somewhere on its cone, which is found here
by points of the cone alone: lines between random points meet it where a quadratic equation says.
"""

import json
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.optimize import least_squares

import lamc
from lamc.records.mechanism import Array, Mechanism
from tests.support.ctools import needs_cc

DIRECTIONS = {  # degrees, of the creases of one vertex
    4: (0.0, 71.0, 166.0, 250.0),
    5: (0.0, 51.0, 139.0, 208.0, 291.0),
    6: (0.0, 38.0, 117.0, 163.0, 241.0, 302.0),
    7: (0.0, 43.0, 97.0, 140.0, 201.0, 262.0, 313.0),
}
LENGTH = 20.0  # mm
POINTS = 20_000  # of the cone: the best of them has all but a hundredth of the most work (of three to six dimensions)


def turned(angle: float, axis: Array) -> Array:
    """Rodrigues' rotation (3, 3) about a unit axis."""
    x, y, z = axis
    across = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    return np.asarray(np.eye(3) + np.sin(angle) * across + (1.0 - np.cos(angle)) * across @ across)


def axes(degree: int, directions: tuple[float, ...] = ()) -> Array:
    """(n, 3), unit vectors along the creases."""
    angles = np.radians(directions or DIRECTIONS[degree])
    return np.stack([np.cos(angles), np.sin(angles), np.zeros(len(angles))], axis=1)


@cache
def folded(degree: int, seed: int) -> Array:
    """Fold angles (n,), rad, with which the facets around the vertex meet: a state that a sheet can rest in."""
    random = np.random.default_rng(seed)

    def missed(angles: Array) -> Array:
        product = np.eye(3)
        for angle, axis in zip(angles, axes(degree), strict=True):
            product = product @ turned(angle, axis)
        return np.array([product[2, 1], product[0, 2], product[1, 0]])

    while True:
        found = least_squares(missed, random.uniform(-1.2, 1.2, degree), xtol=1e-15, ftol=1e-15, gtol=1e-15)
        sizes = np.abs(found.x)
        if np.abs(found.fun).max() < 1e-12 and sizes.min() > 0.15 and sizes.max() < 1.4:
            return np.asarray(found.x)


def sheet(
    folder: Path,
    degree: int,
    rest: Array,
    *,
    mirrored: bool = False,
    turn: float = 0.0,
    tab: bool = False,
    crease: float = 1e-3,
    directions: tuple[float, ...] = (),
) -> Mechanism:
    """The vertex with a triangle between each crease and the next, which rests at these angles.

    turn: of the sheet, rad, about what is upwards. tab: a small triangle beside the last facet but one, folded by 60
    degrees, which no loop holds.
    """
    across = np.array([[np.cos(turn), np.sin(turn)], [-np.sin(turn), np.cos(turn)]])
    points = LENGTH * axes(degree, directions)[:, :2] @ across * ([1.0, -1.0] if mirrored else [1.0, 1.0])
    rim = [[k + 1, (k + 1) % degree + 1] for k in range(degree)]
    faces = [[0, *pair] for pair in rim]
    data: dict[str, Any] = {
        "frame_unit": "mm",
        "vertices_coords": [[0.0, 0.0], *points.tolist()],
        "edges_vertices": [*([0, k + 1] for k in range(degree)), *rim],
        "edges_assignment": [*("V" if angle > 0.0 else "M" for angle in rest), *"B" * degree],
        "edges_foldAngle": [*np.degrees(rest).tolist(), *[None] * degree],
        "faces_vertices": [face[::-1] for face in faces] if mirrored else faces,
    }
    if tab:
        a, b = rim[-2]
        middle, out = 0.5 * (points[a - 1] + points[b - 1]), 0.1 * (points[a - 1] + points[b - 1])
        data["vertices_coords"].append((middle + out).tolist())
        data["edges_vertices"] += [[a, degree + 1], [degree + 1, b]]
        data["edges_assignment"] += "BB"
        data["edges_assignment"][2 * degree - 2] = "V"
        data["edges_foldAngle"] += [None, None]
        data["edges_foldAngle"][2 * degree - 2] = 60.0
        data["faces_vertices"].append([b, a, degree + 1])
    path = folder / "vertex.fold"
    path.write_text(json.dumps(data))
    made = lamc.load(path, card=lamc.Card(), crease=crease, fixed="F0")
    assert isinstance(made, Mechanism)
    return made


def forces_of(made: Mechanism, degree: int) -> Array:
    """(n,), N·m, of the springs at rest in the flat position."""
    joints = [made.joint(f"E{k}") for k in range(degree)]
    return np.array([joint.stiffness * joint.rest_angle for joint in joints])


def inertia_of(made: Mechanism, degree: int) -> Array:
    """(n + 6, n + 6), kg·m² and the like, in the flat position, a tab still: of the fold angles, which add up from the
    facet between the first two creases on, and of the spin and speed of that facet at the vertex."""
    lines, inertia = axes(degree), np.zeros((degree + 6, degree + 6))
    for body in made.bodies:
        number = int(body.name[1:])
        last = number if number < degree else degree - 2  # a tab goes with its facet
        spin = np.zeros((3, degree + 6))
        spin[:, 1 : last + 1] = lines[1 : last + 1].T
        spin[:, degree : degree + 3] = np.eye(3)
        arm = np.array([*body.com[:2], 0.0])  # creases lie in the sheet's middle
        speed = np.cross(spin.T, arm).T
        speed[:, degree + 3 :] += np.eye(3)
        inertia += body.mass * speed.T @ speed + spin.T @ body.inertia @ spin
    return inertia


def free_rates(degree: int) -> Array:
    """(n, n - 2), orthonormal: rates whose sum along their creases is nil."""
    return np.asarray(np.linalg.svd(axes(degree)[:, :2].T)[2][2:].T)


def on_the_cone(degree: int, toward: Array) -> Array:
    """Rates (s, n) with which facets go on meeting to the second order, more of them the nearer to some rates (n,)."""
    lines, free = axes(degree), free_rates(degree)
    form = 0.5 * np.cross(lines[:, None], lines[None])[:, :, 2]
    form = np.triu(form) + np.triu(form).T
    cone, ask = free.T @ form @ free, free.T @ toward
    random = np.random.default_rng(7)
    start, way = random.normal(size=(2, POINTS, len(ask)))
    start += random.uniform(0.0, 3.0, (POINTS, 1)) * ask / np.linalg.norm(ask)
    a, b, c = (np.einsum("si,ij,sj->s", x, cone, y) for x, y in ((way, way), (way, start), (start, start)))
    real = b * b > a * c
    root = np.sqrt(b[real] ** 2 - a[real] * c[real])
    both = [start[real] + ((-b[real] + sign * root) / a[real])[:, None] * way[real] for sign in (1.0, -1.0)]
    return np.asarray(np.concatenate(both) @ free.T)


def taken(simulator: lamc.Simulator, degree: int) -> tuple[Array, int]:
    """Rates (n,) of the branch that the start takes, and its freedoms."""
    number = simulator.pushed_branch
    assert number is not None
    branch = simulator.branches[abs(number) - 1]
    return np.sign(number) * branch.row(tuple(f"E{k}" for k in range(degree))), branch.freedoms


@pytest.mark.quick("5-False")
@pytest.mark.ci("4-True", "5-*", "6-*", "7-*")
@needs_cc
@pytest.mark.parametrize("tab", [False, True])
@pytest.mark.parametrize("degree", sorted(DIRECTIONS))
def test_loads_do_most_work_on_the_branch_of_a_family_that_is_taken(
    tmp_path: Path, degree: int, *, tab: bool
) -> None:
    """Whatever a flap outside all loops does, which is free by itself."""
    for seed in (1, 2, 3):
        made = sheet(tmp_path, degree, folded(degree, seed), tab=tab)
        rates, freedoms = taken(lamc.compile(made, lamc.Scene(without=("gravity",))), degree)
        assert freedoms == degree - 3 + tab
        force, inertia = forces_of(made, degree), inertia_of(made, degree)[:degree, :degree]
        free = free_rates(degree)
        asked = free @ np.linalg.solve(free.T @ inertia @ free, free.T @ force)
        points = on_the_cone(degree, asked)
        most = np.max(points @ force / np.sqrt(np.einsum("si,ij,sj->s", points, inertia, points)))
        # Points of the cone come near to the most, and none beyond; the ascent ends where a round gains 1e-12 of it.
        assert rates @ force / np.sqrt(rates @ inertia @ rates) > (1.0 - 1e-6) * most


@pytest.mark.quick("6-True")
@needs_cc
@pytest.mark.parametrize("falls", [False, True])
@pytest.mark.parametrize("degree", sorted(DIRECTIONS))
def test_on_a_base_that_is_free_loads_do_most_work_too(tmp_path: Path, degree: int, *, falls: bool) -> None:
    """The base goes with each motion as nothing holds it, and a fall folds nothing."""
    made = sheet(tmp_path, degree, folded(degree, 2))
    scene = lamc.Scene(added=(lamc.FreeBase(),), without=() if falls else ("gravity",))
    rates, _ = taken(lamc.compile(made, scene), degree)
    whole, force, free = inertia_of(made, degree), forces_of(made, degree), free_rates(degree)
    joints, base = slice(degree), slice(degree, None)
    inertia = whole[joints, joints] - whole[joints, base] @ np.linalg.solve(
        whole[base, base], whole[base, joints]
    )
    points = on_the_cone(degree, free @ np.linalg.solve(free.T @ inertia @ free, free.T @ force))
    most = np.max(points @ force / np.sqrt(np.einsum("si,ij,sj->s", points, inertia, points)))
    assert rates @ force / np.sqrt(rates @ inertia @ rates) > (1.0 - 1e-6) * most


@pytest.mark.slow
@needs_cc
@pytest.mark.parametrize("degree", sorted(DIRECTIONS))
def test_a_sheet_that_is_turned_takes_the_same_branch(tmp_path: Path, degree: int) -> None:
    rest = folded(degree, 2)
    scene = lamc.Scene(without=("gravity",))
    first, *others = (
        taken(lamc.compile(sheet(tmp_path, degree, rest, turn=turn), scene), degree)[0]
        for turn in (0.0, 0.8, 2.5)
    )
    for other in others:
        # The root of a share of the work that ends the ascent, 1e-12, over how steep it is
        assert other == pytest.approx(first, abs=1e-4)


@needs_cc
@pytest.mark.parametrize("crease", [1e-3, 1.0, 1e3])
def test_loads_that_balance_make_no_branch_of_round_off(tmp_path: Path, crease: float) -> None:
    """A vertex of six creases alike, whose rests go as the cosine of their direction, does no work on any motion of the
    facets to first order: rates add up to nought along x and y."""
    angles = np.radians(60.0 * np.arange(6))
    rest = 0.3 * np.cos(angles + 0.35)
    made = sheet(tmp_path, 6, rest, crease=crease, directions=tuple(np.degrees(angles).tolist()))
    simulator = lamc.compile(made, lamc.Scene(without=("gravity",)))
    assert len(simulator.branches) == 1


@pytest.mark.slow
@needs_cc
@pytest.mark.parametrize("degree", sorted(DIRECTIONS))
def test_a_vertex_folds_to_where_its_creases_rest(tmp_path: Path, degree: int) -> None:
    """From flat, to a state in which no spring is stretched; and its mirror image, which has the same angles, too."""
    rest = folded(degree, 1)
    ends = []
    for mirrored in (False, True):
        made = sheet(tmp_path, degree, rest, mirrored=mirrored)
        result = lamc.compile(made, lamc.Scene(without=("gravity",))).run(1.0)
        assert result.success, result.message
        ends.append([result.angle(f"E{k}")[-1] for k in range(degree)])
    # What swings is left of creases that are damped by half of critical, a second after they were let go.
    assert ends[0] == pytest.approx(rest.tolist(), abs=1e-3)
    assert ends[1] == pytest.approx(rest.tolist(), abs=1e-3)


@pytest.mark.slow
@needs_cc
def test_a_map_whose_loops_close_by_round_off_takes_one_of_its_families(tmp_path: Path) -> None:
    """Panels of a third of 100 mm close by round-off, and forms are nought within 5e-3 then: what loads ask for lies
    between folds along both ways, where loops hold less than on either, and a run from there came apart."""
    side = range(4)
    number = {(i, j): 4 * j + i for j in side for i in side}
    across = [
        (number[i, j], number[i + 1, j], "B" if j in (0, 3) else "MVM"[i]) for j in side for i in range(3)
    ]
    along = [(number[i, j], number[i, j + 1], "B" if i in (0, 3) else "V") for i in side for j in range(3)]
    data = {
        "vertices_coords": [[i, j] for j in side for i in side],
        "edges_vertices": [[a, b] for a, b, _ in (*across, *along)],
        "edges_assignment": [kind for *_, kind in (*across, *along)],
        "faces_vertices": [
            [number[i, j], number[i + 1, j], number[i + 1, j + 1], number[i, j + 1]]
            for j in range(3)
            for i in range(3)
        ],
    }
    (tmp_path / "map.fold").write_text(json.dumps(data))
    made = lamc.load(tmp_path / "map.fold", card=lamc.Card(), crease=1e-3)
    assert isinstance(made, Mechanism)
    simulator = lamc.compile(made, lamc.Scene())
    assert (
        simulator.loops.rank >= 10
    )  # 12 hinges of four vertices, each with one fold: all the lines of one way
    result = simulator.run(1.0)
    assert result.success, result.message
