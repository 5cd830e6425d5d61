"""Sheets of facets between vertices, and chains of hinges in space, as mechanisms: by their drawings alone."""

import math
from collections.abc import Sequence

import numpy as np

from lamc.records.mechanism import Array, Body, Joint, Mechanism


def sheet(vertices: Array, *, diagonals: bool = False) -> Mechanism:
    """Quadrangles, or with diagonals triangles, between vertices (rows, columns, 3), m; the first facet is fixed.

    Creases are z{i}_{j} before facet f{i}_{j} along columns, s{i}_{j} before it along rows, d{i}_{j} across it, where
    triangles are f{i}_{j}a below the diagonal from (i, j) to (i + 1, j + 1), and f{i}_{j}b above.
    """
    rows, columns = vertices.shape[0] - 1, vertices.shape[1] - 1
    facets: list[tuple[str, list[Array]]] = []
    joints: list[Joint] = []
    near, far = ("b", "a") if diagonals else ("", "")

    def crease(name: str, parent: str, child: str, start: Array, end: Array) -> None:
        axis = (end - start) / np.linalg.norm(end - start)
        joints.append(Joint(name, parent, child, 0.5 * (start + end), axis))

    for i in range(rows):
        for j in range(columns):
            a, b = vertices[i, j], vertices[i, j + 1]
            c, d = vertices[i + 1, j + 1], vertices[i + 1, j]
            if diagonals:
                facets += [(f"f{i}_{j}a", [a, b, c]), (f"f{i}_{j}b", [a, c, d])]
                crease(f"d{i}_{j}", f"f{i}_{j}a", f"f{i}_{j}b", a, c)
            else:
                facets.append((f"f{i}_{j}", [a, b, c, d]))
            if j > 0:
                crease(f"z{i}_{j}", f"f{i}_{j - 1}{far}", f"f{i}_{j}{near}", a, d)
            if i > 0:
                crease(f"s{i}_{j}", f"f{i - 1}_{j}{near}", f"f{i}_{j}{far}", a, b)
    bodies = []
    for k, (name, corners) in enumerate(facets):
        side = float(np.linalg.norm(corners[1] - corners[0]))
        inertia = 1e-3 * side**2 / 12 * np.diag([1.0, 1.0, 2.0])
        bodies.append(Body(name, 1e-3, np.mean(corners, axis=0), inertia, fixed=k == 0))
    return Mechanism(tuple(bodies), tuple(joints), name="sheet")


def flat_miura(columns: int, rows: int, turned: float = 0.0, decimals: int | None = None) -> Array:
    """Vertices (rows + 1, columns + 1, 3), m, of a flat Miura-ori of sides 30 and 25 mm and 65 degrees; turned by so
    many degrees, and rounded to so many decimals of a millimetre."""
    acute, turn = math.radians(65.0), math.radians(turned)
    found = [
        [
            [30.0 * i + (j % 2) * 25.0 * math.cos(acute), 25.0 * j * math.sin(acute), 0.0]
            for i in range(columns + 1)
        ]
        for j in range(rows + 1)
    ]
    c, s = math.cos(turn), math.sin(turn)
    points = np.array(found) @ np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]])
    return 1e-3 * (points if decimals is None else np.round(points, decimals))


def folded_miura(count: int, theta: float = 1.0, gamma: float = math.radians(60.0)) -> Array:
    """Vertices of a folded sheet of count x count facets of side 1 m, by the closed form (M. Schenk and S. D. Guest,
    Geometry of Miura-folded metamaterials, PNAS 110, 2013, 3276)."""
    lean = math.cos(theta) * math.tan(gamma)
    height = math.sin(theta) * math.sin(gamma)
    step, shift = lean / math.sqrt(1 + lean**2), 1 / math.sqrt(1 + lean**2)
    along = math.sqrt(1 - height**2)
    grid = range(count + 1)
    return np.array([[[j * step, i * along + (j % 2) * shift, (i % 2) * height] for j in grid] for i in grid])


def chain(lines: Sequence[tuple[Array, Array]]) -> Mechanism:
    """A single loop of hinges along lines (a point, m, and a direction), the first link fixed."""
    count = len(lines)
    points = [point for point, _ in lines]
    bodies = [
        Body(f"b{k}", 1.0, 0.5 * (points[k] + points[(k + 1) % count]), 0.1 * np.eye(3), fixed=k == 0)
        for k in range(count)
    ]
    joints = [
        Joint(f"h{k}", f"b{(k - 1) % count}", f"b{k}", point, axis / np.linalg.norm(axis))
        for k, (point, axis) in enumerate(lines)
    ]
    return Mechanism(tuple(bodies), tuple(joints), name="chain")
