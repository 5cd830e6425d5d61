"""Plates that several tests share: laminates of a given stiffness, meshes that are not regular, closed forms."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from lamc.basics.errors import DesignError
from lamc.plates.laminates.laminate import Laminate
from lamc.plates.laminates.materials import Material
from lamc.plates.laminates.plies import Ply
from lamc.plates.meshing.mesh import Mesh

LEFT, RIGHT, BOTTOM, TOP = "left", "right", "bottom", "top"


def case(shared: Path, name: str) -> dict[str, Any]:
    """One entry of the table of reference answers."""
    table = json.loads((shared / "reference" / "plates.json").read_text())
    return next(entry for entry in table["cases"] if entry["id"] == name)


def isotropic(D: float = 1.0, nu: float = 0.3, h: float = 1e-3, **more: float) -> Laminate:
    """One layer with bending stiffness D = E h³ / 12 (1 - ν²), N·m, thickness h, m."""
    modulus = 12.0 * D * (1.0 - nu * nu) / h**3
    return Laminate([Ply(Material.isotropic(E=modulus, nu=nu, density=more.pop("density", 0.0), **more), h)])


def cross_ply(angles: tuple[float, ...], E1: float = 25.0, E2: float = 1.0, h: float = 0.01) -> Laminate:
    """Plies of equal thickness, together h m thick, with G12 = E2 / 2 and ν12 = 1/4."""
    ply = Material(E1=E1, E2=E2, nu12=0.25, G12=0.5 * E2, density=0.0)
    return Laminate([Ply(ply, h / len(angles), angle) for angle in angles])


def jittered(mesh: Mesh, amount: float = 0.2, seed: int = 0) -> Mesh:
    """The same mesh with inner points moved by up to `amount` of the shortest edge."""
    edges = mesh.edges
    lengths = np.linalg.norm(mesh.points[edges[:, 0]] - mesh.points[edges[:, 1]], axis=1)
    inner = np.ones(len(mesh.points), dtype=bool)
    cells, local = mesh.boundary_edges.T
    for k in (0, 1):
        inner[mesh.cells[cells, (local + k) % mesh.corner_count]] = False
    moved = mesh.points.copy()
    steps = np.random.default_rng(seed).uniform(-1.0, 1.0, moved.shape)
    moved[inner] += amount * lengths.min() * steps[inner]
    return Mesh(moved, mesh.cells, mesh.regions, mesh.region_names)


def turned(mesh: Mesh, degrees: float, shift: tuple[float, float] = (0.0, 0.0)) -> Mesh:
    """The same mesh, turned about the origin and moved."""
    a = np.radians(degrees)
    rotation = np.array([[np.cos(a), -np.sin(a)], [np.sin(a), np.cos(a)]])
    return Mesh(mesh.points @ rotation.T + shift, mesh.cells, mesh.regions, mesh.region_names)


def disk(rings: int, radius: float = 1.0) -> Mesh:
    """Triangles in rings about the origin: ring k has 6 k points."""
    points, starts = [np.zeros((1, 2))], [0]
    for k in range(1, rings + 1):
        angles = np.arange(6 * k) * (2.0 * np.pi / (6 * k))
        starts.append(starts[-1] + (6 * (k - 1) if k > 1 else 1))
        points.append(radius * k / rings * np.stack([np.cos(angles), np.sin(angles)], axis=1))
    cells = []
    for k in range(1, rings + 1):
        inner, outer = max(6 * (k - 1), 1), 6 * k
        for sector in range(6):
            for j in range(k):
                a = starts[k] + (sector * k + j) % outer
                b = starts[k] + (sector * k + j + 1) % outer
                c = starts[k - 1] + (sector * (k - 1) + j) % inner
                cells.append((a, b, c))
                if j < k - 1:
                    d = starts[k - 1] + (sector * (k - 1) + j + 1) % inner
                    cells.append((c, b, d))
    return Mesh(np.concatenate(points), np.array(cells))


def richardson(coarse: float, fine: float) -> float:
    """The limit of a quantity with an error of order h², from meshes of size h and h / 2."""
    return (4.0 * fine - coarse) / 3.0


def assert_refused(make: Callable[[], object], message: str) -> None:
    """`make` raises a DesignError of one line in which `message` is found."""
    with pytest.raises(DesignError, match=message) as caught:
        make()
    assert "\n" not in str(caught.value)
