"""Plates for many tests: meshes of five families, laminates of stiffness 1, supports of a rectangle."""

import json
from collections.abc import Sequence
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.spatial import Delaunay
from shapely.geometry import LineString

from lamc import plate

FAMILIES = ("one-diagonal", "criss-cross", "union-jack", "jittered", "delaunay")
CFRP = plate.Material(E1=350e9, E2=7e9, nu12=0.33, G12=5e9, density=1600)


def published(shared: Path, name: str) -> dict[str, Any]:
    """The case of that name in reference/plates.json."""
    cases = json.loads((shared / "reference" / "plates.json").read_text(encoding="utf-8"))["cases"]
    return next(case for case in cases if case["id"] == name)


def within(case: dict[str, Any]) -> Any:
    """What a case expects, to be compared within its own tolerance."""
    return pytest.approx(case["expected"], rel=case["rel_tol"])


def sheet(
    D: float = 1.0, nu: float = 0.3, thickness: float = 0.01, areal_mass: float = 1.0
) -> plate.Laminate:
    """Isotropic, of bending stiffness D, N·m."""
    E = 12.0 * (1.0 - nu * nu) * D / thickness**3
    material = plate.Material.isotropic(E, nu, density=areal_mass / thickness)
    return plate.Laminate([plate.Ply(material, thickness)])


def stack(material: plate.Material, thickness: float, *angles: float) -> plate.Laminate:
    """Plies of one thickness, bottom to top."""
    return plate.Laminate([plate.Ply(material, thickness, angle) for angle in angles])


def rectangle_mesh(family: str, n: int, a: float = 1.0, b: float = 1.0, amount: float = 0.25) -> plate.Mesh:
    """Rectangle a × b with n parts along each side. "jittered": one-diagonal, every inner point moved by up to `amount`
    of a part; "delaunay": the Delaunay triangulation of scattered points."""
    rng = np.random.default_rng(1)
    if family == "jittered":
        regular = plate.grid(a, b, n, n)
        inner = ((regular.points > 0) & (regular.points < [a, b])).all(axis=1)
        moved = rng.uniform(-amount, amount, regular.points.shape) * [a / n, b / n]
        return plate.Mesh(regular.points + moved * inner[:, None], regular.cells)
    if family == "delaunay":
        points = scattered_points(n)
        return plate.Mesh(points * [a, b], Delaunay(points).simplices)
    return plate.grid(a, b, n, n, pattern=family)


@cache
def scattered_points(n: int) -> np.ndarray:
    """Points of the unit square, n along each side and as dense within: thrown at random, kept where none is nearer
    than 0.8 / n (Poisson disks). Their Delaunay triangles have angles above 25°, as those of a quality mesher."""
    rng = np.random.default_rng(1)
    s, zero, one = np.arange(n) / n, np.zeros(n), np.ones(n)
    borders = ((s, zero), (one, s), (1 - s, one), (zero, 1 - s))
    kept = [tuple(p) for border in borders for p in np.stack(border, axis=1).tolist()]
    radius = 0.8 / n
    near: dict[tuple[int, int], list[tuple[float, float]]] = {}
    for x, y in kept:
        near.setdefault((int(x / radius), int(y / radius)), []).append((x, y))
    for x, y in rng.uniform(0.35 / n, 1.0 - 0.35 / n, (60 * n * n, 2)).tolist():
        i, j = int(x / radius), int(y / radius)
        around = [q for di in (-1, 0, 1) for dj in (-1, 0, 1) for q in near.get((i + di, j + dj), ())]
        if all((x - q[0]) ** 2 + (y - q[1]) ** 2 >= radius**2 for q in around):
            near.setdefault((i, j), []).append((x, y))
            kept.append((x, y))
    return np.array(kept)


def sides(a: float = 1.0, b: float = 1.0) -> dict[str, LineString]:
    """The sides of the rectangle from the origin to (a, b), by name."""
    return {
        "left": LineString([(0, 0), (0, b)]),
        "right": LineString([(a, 0), (a, b)]),
        "bottom": LineString([(0, 0), (a, 0)]),
        "top": LineString([(0, b), (a, b)]),
    }


def held(code: str, a: float = 1.0, b: float = 1.0) -> list[Any]:
    """Supports of left, bottom, right, top in the usual letters: S simple, C clamped, F free, Y symmetry."""
    kinds = {"S": plate.SimplySupported, "C": plate.Clamped, "Y": plate.Symmetry}
    names = ("left", "bottom", "right", "top")
    return [
        kinds[letter](sides(a, b)[name]) for letter, name in zip(code, names, strict=True) if letter != "F"
    ]


def solved(
    mesh: plate.Mesh, laminate: Any, supports: Sequence[Any], loads: Sequence[Any], element: str = "dkt"
) -> Any:
    """The solution of one case."""
    return plate.solve(plate.Problem(mesh, laminate, element=element, supports=supports, loads=loads))


def quarter(n: int, code: str, loads: Sequence[Any], laminate: plate.Laminate | None = None) -> float:
    """Deflection at the centre of the unit square, by its lower left quarter with n × n crossed squares of DKT."""
    edges = {"S": "SSYY", "C": "CCYY"}[code]
    mesh = plate.grid(0.5, 0.5, n, n, pattern="criss-cross")
    solution = solved(mesh, laminate or sheet(), held(edges, 0.5, 0.5), loads)
    return float(solution.deflection(0.5, 0.5))


def extrapolated(coarse: Any, fine: Any) -> Any:
    """Richardson's limit of two values whose error is O(h²), the second with half the h of the first."""
    return (4.0 * np.asarray(fine) - np.asarray(coarse)) / 3.0
