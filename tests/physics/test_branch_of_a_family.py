"""Where branches part in families, the motion of a family on which loads do most work is taken.

A vertex of five creases or more leaves its flat position in a family. Of that the second order is one quadratic form,
and the work of springs over the root of twice the kinetic energy is largest somewhere on its cone, which is found here
by points of the cone alone: lines between random points meet it where a quadratic equation says.
"""

import json
from pathlib import Path

import numpy as np
import pytest
from scipy.optimize import least_squares

import lamc
from lamc.records.mechanism import Array, Mechanism
from tests.support.ctools import needs_cc

DIRECTIONS = {  # degrees, of the creases of one vertex
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


def axes(degree: int) -> Array:
    """(n, 3), unit vectors along the creases."""
    angles = np.radians(DIRECTIONS[degree])
    return np.stack([np.cos(angles), np.sin(angles), np.zeros(len(angles))], axis=1)


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


def sheet(folder: Path, degree: int, rest: Array, *, mirrored: bool = False) -> Mechanism:
    """The vertex with a triangle between each crease and the next, which rests at these angles."""
    points = LENGTH * axes(degree)[:, :2] * ([1.0, -1.0] if mirrored else [1.0, 1.0])
    rim = [[k + 1, (k + 1) % degree + 1] for k in range(degree)]
    faces = [[0, *pair] for pair in rim]
    data = {
        "frame_unit": "mm",
        "vertices_coords": [[0.0, 0.0], *points.tolist()],
        "edges_vertices": [*([0, k + 1] for k in range(degree)), *rim],
        "edges_assignment": [*("V" if angle > 0.0 else "M" for angle in rest), *"B" * degree],
        "edges_foldAngle": [*np.degrees(rest).tolist(), *[None] * degree],
        "faces_vertices": [face[::-1] for face in faces] if mirrored else faces,
    }
    path = folder / "vertex.fold"
    path.write_text(json.dumps(data))
    made = lamc.load(path, card=lamc.Card(), crease=1e-3, fixed="F0")
    assert isinstance(made, Mechanism)
    return made


def most_work(made: Mechanism, degree: int) -> tuple[float, Array, Array]:
    """The most of p / √I over points of the cone, the generalised forces (n,) of the springs, and inertia (n, n). The
    facet between the first two creases is fixed; fold angles add up from crease to crease."""
    lines = axes(degree)
    free = np.linalg.svd(lines[:, :2].T)[2][2:].T  # the sum of the rates along their creases is nil
    form = np.zeros((degree, degree))
    inertia = np.zeros((degree, degree))
    for i in range(degree):
        for j in range(i + 1, degree):
            form[i, j] = form[j, i] = 0.5 * np.cross(lines[i], lines[j])[2]
    for k in range(1, degree):
        body = next(each for each in made.bodies if each.name == f"F{k}")
        spin = np.zeros((3, degree))
        spin[:, 1 : k + 1] = lines[1 : k + 1].T
        arm = np.array([*body.com[:2], 0.0])  # creases lie in the sheet's middle
        speed = np.cross(spin.T, arm).T
        inertia += body.mass * speed.T @ speed + spin.T @ body.inertia @ spin
    force = np.array([j.stiffness * j.rest_angle for j in (made.joint(f"E{k}") for k in range(degree))])
    root = np.linalg.inv(np.linalg.cholesky(free.T @ inertia @ free)).T
    cone, ask = root.T @ free.T @ form @ free @ root, root.T @ free.T @ force
    random = np.random.default_rng(7)
    start, way = random.normal(size=(2, POINTS, len(ask)))
    start += random.uniform(0.0, 3.0, (POINTS, 1)) * ask / np.linalg.norm(ask)
    a, b, c = (np.einsum("si,ij,sj->s", x, cone, y) for x, y in ((way, way), (way, start), (start, start)))
    real = b * b > a * c
    root_of = np.sqrt(b[real] ** 2 - a[real] * c[real])
    best = 0.0
    for sign in (1.0, -1.0):
        on = start[real] + ((-b[real] + sign * root_of) / a[real])[:, None] * way[real]
        best = max(best, float(np.abs(on @ ask / np.linalg.norm(on, axis=1)).max()))
    return best, force, inertia


@needs_cc
@pytest.mark.parametrize("degree", sorted(DIRECTIONS))
def test_loads_do_most_work_on_the_branch_of_a_family_that_is_taken(tmp_path: Path, degree: int) -> None:
    for seed in (1, 2):
        rest = folded(degree, seed)
        made = sheet(tmp_path, degree, rest)
        simulator = lamc.compile(made, lamc.Scene(without=("gravity",)))
        number = simulator.pushed_branch
        assert number is not None
        branch = simulator.branches[abs(number) - 1]
        rates = np.sign(number) * branch.row(tuple(f"E{k}" for k in range(degree)))
        assert branch.freedoms == degree - 3
        most, force, inertia = most_work(made, degree)
        # A round of the ascent that gains less than 1e-4 is the last.
        assert rates @ force / np.sqrt(rates @ inertia @ rates) > (1.0 - 1e-3) * most


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
