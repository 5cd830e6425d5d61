"""Meshes of bodies: closed, outward, and of the volume of what was drawn, by the divergence theorem."""

import numpy as np
from shapely.geometry import Polygon, box

from lamc.export.meshes import body_meshes
from lamc.records.mechanism import Array, Body, Joint, Mechanism, Slab

TRIANGLE = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])


def triangles(stl: bytes) -> Array:
    """Corners (k, 3, 3) of a binary STL file, by its definition: 80 bytes, a count, 50 bytes each."""
    count = int.from_bytes(stl[80:84], "little")
    assert len(stl) == 84 + 50 * count
    facets = np.frombuffer(stl, dtype=TRIANGLE, offset=84)
    corners = facets["corners"].astype(float)
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    lengths = np.linalg.norm(normals, axis=1)
    assert np.allclose(np.einsum("ka,ka->k", normals, facets["normal"]), lengths, rtol=1e-5)
    return corners


def volume(corners: Array) -> float:
    """∫ x·n / 3 over the surface."""
    return float(np.einsum("ka,ka->", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])) / 6.0)


def test_a_sheet_with_a_hole_has_its_volume_and_lies_in_its_frame() -> None:
    outline = Polygon(
        [(0, 0), (0.2, 0), (0.2, 0.1), (0.1, 0.05), (0, 0.1)], [[(0.04, 0.02), (0.08, 0.02), (0.06, 0.04)]]
    )
    stack = (
        Slab(outline, 0.0, 0.001),
        Slab(outline, 0.001, 0.004),
        Slab(box(0, 0, 0.02, 0.01), 0.004, 0.006),
    )
    bodies = (Body("ground", fixed=True), Body("sheet", 1.0, (0.1, 0.05, 0), np.eye(3), outline=stack))
    mechanism = Mechanism(bodies, (Joint("h", "ground", "sheet", (0.0, 0.0, 0.0), (0.0, 1.0, 0.0)),))
    origin = np.array([0.05, -0.02, 0.001])
    corners = triangles(body_meshes(mechanism, {"sheet": origin})["sheet"])
    drawn = outline.area * 0.004 + 0.02 * 0.01 * 0.002
    # 1e-5: STL holds single precision, of which the thickness loses some digits
    assert abs(volume(corners) / drawn - 1.0) < 1e-5
    low, high = corners.reshape(-1, 3).min(axis=0) + origin, corners.reshape(-1, 3).max(axis=0) + origin
    # 1e-7 m: half a metre in single precision is good to 6e-8
    assert np.allclose(low, [0.0, 0.0, 0.0], rtol=0.0, atol=1e-7)
    assert np.allclose(high, [0.2, 0.1, 0.006], rtol=0.0, atol=1e-7)


def test_a_body_without_an_outline_is_a_bar_from_hinge_to_centre() -> None:
    bodies = (Body("ground", fixed=True), Body("rod", 1.0, (0.3, 0.0, 0.4), np.eye(3)))
    mechanism = Mechanism(bodies, (Joint("h", "ground", "rod", (0.0, 0.0, 0.0), (0.0, 1.0, 0.0)),))
    corners = triangles(body_meshes(mechanism, {"rod": np.zeros(3)})["rod"])
    ends = corners.reshape(-1, 3) @ np.array([0.6, 0.0, 0.8])
    assert np.allclose([ends.min(), ends.max()], [0.0, 0.5], rtol=0.0, atol=1e-7)
    assert volume(corners) > 0.0  # outward


def test_bodies_without_a_frame_are_left_out() -> None:
    bodies = (Body("ground", fixed=True), Body("rod", 1.0, (0.3, 0.0, 0.4), np.eye(3)))
    mechanism = Mechanism(bodies, (Joint("h", "ground", "rod", (0.0, 0.0, 0.0), (0.0, 1.0, 0.0)),))
    assert set(body_meshes(mechanism, {"rod": np.zeros(3)})) == {"rod"}
