"""FOLD files of well-known patterns, made by formulas; in mm where nothing else is said."""

import json
import math
from pathlib import Path
from typing import Any

import numpy as np

ALONG, ACROSS, ACUTE = 30.0, 25.0, math.radians(65.0)
Data = dict[str, Any]


def miura_corner(i: int, j: int) -> tuple[float, float]:
    return i * ALONG + (j % 2) * ACROSS * math.cos(ACUTE), j * ACROSS * math.sin(ACUTE)


def miura(columns: int, rows: int, *, faces: bool = False, unit: str | None = "mm") -> Data:
    """Zigzag creases alternate along x; straight ones so that every vertex has three of one kind."""
    index = {(i, j): j * (columns + 1) + i for j in range(rows + 1) for i in range(columns + 1)}
    data = _started([miura_corner(i, j) for i, j in index], unit)
    for j in range(rows + 1):
        for i in range(columns):
            kind = "B" if j in (0, rows) else "MV"[(i + j) % 2 == 0]
            _edge(data, index[i, j], index[i + 1, j], kind)
    for j in range(rows):
        for i in range(columns + 1):
            _edge(data, index[i, j], index[i, j + 1], "B" if i in (0, columns) else "MV"[i % 2])
    if faces:
        cells = [(i, j) for j in range(rows) for i in range(columns)]
        ring = [(0, 0), (1, 0), (1, 1), (0, 1)]
        data["faces_vertices"] = [[index[i + a, j + b] for a, b in ring] for i, j in cells]
    return data


def waterbomb() -> Data:
    """A square with both diagonals, mountains, and a level middle line, valleys."""
    rim = [(40, 0), (40, 40), (-40, 40), (-40, 0), (-40, -40), (40, -40)]
    data = _started([(0, 0), *rim], "mm")
    for k in range(6):
        _edge(data, k + 1, (k + 1) % 6 + 1, "B")
        _edge(data, 0, k + 1, "V" if k % 3 == 0 else "M")
    return data


def yoshimura(columns: int, rows: int) -> Data:
    """Rows of isosceles triangles, 30 mm by 18 mm."""
    index = {(i, j): j * (columns + 1) + i for j in range(rows + 1) for i in range(columns + 1)}
    data = _started([(30.0 * i + 15.0 * (j % 2), 18.0 * j) for i, j in index], "mm")
    for i, j in index:
        if i < columns:
            _edge(data, index[i, j], index[i + 1, j], "B" if j in (0, rows) else "V")
        if j < rows:
            _edge(data, index[i, j], index[i, j + 1], "B" if i in (0, columns) else "M")
            other = i + 1 if j % 2 else i - 1
            if 0 <= other <= columns:
                _edge(data, index[i, j], index[other, j + 1], "M")
    return data


def box_net(unit: str | None = "cm") -> Data:
    """The cross of a cube, 2 units wide: five hinges, no vertex within."""
    cells = [(0, 0), (1, 0), (2, 0), (3, 0), (1, 1), (1, -1)]
    ring = [(0, 0), (1, 0), (1, 1), (0, 1)]
    points = sorted({(i + a, j + b) for i, j in cells for a, b in ring})
    data = _started([(2.0 * x, 2.0 * y) for x, y in points], unit)
    sides: dict[frozenset[int], int] = {}
    for i, j in cells:
        corners = [points.index((i + a, j + b)) for a, b in ring]
        for pair in zip(corners, [*corners[1:], corners[0]], strict=True):
            sides[frozenset(pair)] = sides.get(frozenset(pair), 0) + 1
    for side, count in sides.items():
        a, b = sorted(side)
        _edge(data, a, b, "V" if count == 2 else "B")
    data["edges_foldAngle"] = [90 if kind == "V" else None for kind in data["edges_assignment"]]
    return data


def folded_pair(angle: float) -> Data:
    """Two squares, 20 mm wide, the second lifted by a valley fold of `angle`, rad."""
    x, z = 20.0 * math.cos(angle), 20.0 * math.sin(angle)
    points = [(0, 0, 0), (20, 0, 0), (20, 20, 0), (0, 20, 0), (20 + x, 0, z), (20 + x, 20, z)]
    data = _started(points, "mm")
    for a, b, kind in ((0, 1, "B"), (1, 2, "V"), (2, 3, "B"), (3, 0, "B")):
        _edge(data, a, b, kind)
    for a, b in ((1, 4), (4, 5), (5, 2)):
        _edge(data, a, b, "B")
    data["faces_vertices"] = [[0, 1, 2, 3], [1, 4, 5, 2]]
    return data


def cube() -> Data:
    """A closed box: no flat piece folds to it."""
    points = [(x, y, z) for x in (0, 1) for y in (0, 1) for z in (0, 1)]
    data = _started(points, "cm")
    faces = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
    data["faces_vertices"] = faces
    sides = {frozenset(s) for face in faces for s in zip(face, [*face[1:], face[0]], strict=True)}
    for a, b in sorted(sorted(side) for side in sides):
        _edge(data, a, b, "M")
    return data


def write(path: Path, data: Data) -> Path:
    path.write_text(json.dumps(data), encoding="utf-8")
    return path


def _started(points: list[Any], unit: str | None) -> Data:
    data: Data = {"file_spec": 1.2, "vertices_coords": np.array(points, dtype=float).tolist()}
    if unit is not None:
        data["frame_unit"] = unit
    return {**data, "edges_vertices": [], "edges_assignment": []}


def _edge(data: Data, a: int, b: int, kind: str) -> None:
    data["edges_vertices"].append([a, b])
    data["edges_assignment"].append(kind)


def kresling(columns: int, rows: int) -> Data:
    """A tower laid flat: rows of parallelograms, 20 mm by 15 mm, each with its short diagonal."""
    index = {(i, j): j * (columns + 1) + i for j in range(rows + 1) for i in range(columns + 1)}
    data = _started([(20.0 * i + 8.0 * j, 15.0 * j) for i, j in index], "mm")
    for i, j in index:
        if i < columns:
            _edge(data, index[i, j], index[i + 1, j], "B" if j in (0, rows) else "M")
        if j < rows:
            _edge(data, index[i, j], index[i, j + 1], "B" if i in (0, columns) else "M")
        if i and j < rows:
            _edge(data, index[i, j], index[i - 1, j + 1], "V")
    return data


def hypar(rings: int) -> Data:
    """Concentric squares, by turns mountains and valleys, in triangles: each ring is parted along its corners and by
    four undriven lines, which turn the other way round in the next. All of them around the outermost square are as few
    as the creases of a corner within, eight."""
    sides = [2.0 * k for k in range(rings, 0, -1)]
    corners = [(s * x, s * y) for s in sides for x, y in ((1, 1), (-1, 1), (-1, -1), (1, -1))]
    data = _started([*corners, (0.0, 0.0)], "mm")
    for ring in range(rings):
        here = [4 * ring + k for k in range(4)]
        for k in range(4):
            kind = "B" if ring == 0 else "MV"[ring % 2]
            _edge(data, here[k], here[(k + 1) % 4], kind)
            if ring == rings - 1:
                _edge(data, here[k], len(corners), "U")
                continue
            _edge(data, here[k], here[k] + 4, "VM"[ring % 2])
            one, other = (here[k], here[(k + 1) % 4]) if (ring + k) % 2 else (here[(k + 1) % 4], here[k])
            _edge(data, one, other + 4, "U")
    return data


def with_flaps(data: Data, every: int = 1) -> tuple[Data, int]:
    """A triangle more on every so many edges of the rim, each on a crease of its own; and how many."""
    places = np.array(data["vertices_coords"])[:, :2]
    rim = [k for k, kind in enumerate(data["edges_assignment"]) if kind == "B"][::every]
    vertices, edges = list(data["vertices_coords"]), list(data["edges_vertices"])
    kinds = list(data["edges_assignment"])
    for k in rim:
        a, b = edges[k]
        along = places[b] - places[a]
        outward = np.array([-along[1], along[0]])
        outward *= np.sign(outward @ (places[a] - places.mean(axis=0)))
        vertices.append((0.5 * (places[a] + places[b]) + 0.3 * outward).tolist())
        edges += [[a, len(vertices) - 1], [len(vertices) - 1, b]]
        kinds[k] = "V"
        kinds += ["B", "B"]
    made = {key: value for key, value in data.items() if key not in ("faces_vertices", "edges_foldAngle")}
    return made | {"vertices_coords": vertices, "edges_vertices": edges, "edges_assignment": kinds}, len(rim)
