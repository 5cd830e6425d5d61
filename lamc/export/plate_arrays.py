"""The constant arrays of an exported plate as lines of C.

In: tables of numbers. Out: arrays with names and meanings. Never: makes numbers.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lamc.codegen.printer import literal
from lamc.export.plate_laminates import LaminateTables
from lamc.export.plate_points import PointTables
from lamc.export.plate_tables import PlateTables

_SHORT = 65536
_PER_LINE = 12


@dataclass(frozen=True)
class CNumbers:
    """A constant array."""

    name: str
    kind: str
    meaning: str
    lines: tuple[str, ...]


def constant_arrays(t: PlateTables, laminates: LaminateTables, facts: dict[str, bool]) -> list[CNumbers]:
    """All of them; `facts` tell which there are beside those of every plate."""
    place = np.argsort(t.order).astype(np.int32)
    of_region = np.array(laminates.of_region, dtype=np.int32)
    found = [
        _whole("ply_begins", "Where the plies of each laminate begin", laminates.begins),
        _whole("ply_material", "Material of each ply", [ply.material for ply in laminates.plies]),
        _reals("surface", "Reference surfaces above the middle, in thicknesses", laminates.surface),
        _reals("points", "Corners of cells: x and y, m", t.points.ravel()),
        _whole("cells", "Corners of each cell", t.cells.ravel()),
        _whole("laminate_of_cell", "Laminate of each cell", of_region[t.regions]),
        _whole("unknowns", "Unknowns of each cell, numbered over the mesh", t.unknowns.ravel()),
        _whole(
            "share_begins", "Where the rows that an unknown of the mesh takes part in begin", t.shares.begins
        ),
        _whole("share_rows", "These rows of the matrix", t.shares.columns),
        _whole("begins", "Where each row of the matrix begins", t.begins),
        _whole("columns", "Column of each entry", t.columns),
        _whole("order", "Rows in the order of the factorisation", t.order),
        _whole("places", "Place of each row in that order", place),
        _whole("profile", "Where each row of the factor begins", t.profile),
        _reals("nodes", "Nodes: x and y, m", t.nodes.ravel()),
        _whole("node_unknowns", "Unknowns of each node: u, v, w, w_x, w_y, w_xy", t.node_unknowns.ravel()),
        _whole("node_rows", "Rows of these in the matrix", t.node_rows.ravel()),
        *_near(t.near),
    ]
    if not facts["is_simple"]:
        found.append(_reals("share_factors", "How much of them it takes", t.shares.factors))
    if facts["has_fixed"]:
        found.append(_reals("fixed", "What is prescribed, of each unknown of the mesh", t.fixed))
    if t.springs.names:
        s = t.springs
        found += [
            _whole("spring_begins", "Where the slope at each point of a line begins", s.rows.begins),
            _whole("spring_rows", "Rows that it is a sum of", s.rows.columns),
            _reals("spring_factors", "and how much of each", s.rows.factors),
            _reals("spring_lengths", "Length of line that the point stands for, m", s.length),
            _whole("spring_groups", "Which line it lies on", s.group),
        ]
        if facts["has_fixed"]:
            found.append(_reals("spring_offsets", "Slope by what is prescribed", s.offset))
    if facts["has_loads"]:
        found.append(_reals("loads", "Forces of each load case", t.loads.ravel()))
    if facts["has_gravity"]:
        by_laminate = np.zeros((len(t.cases), len(laminates.names), len(t.order)))
        for region, laminate in enumerate(laminates.of_region):
            by_laminate[:, laminate] += t.gravity[:, region]
        found.append(
            _reals("weights", "Forces per kg/m^2 of each laminate, in each load case", by_laminate.ravel())
        )
    if t.climate.kinds:
        found += [
            _whole("region_of_cell", "Region of each cell", t.regions),
            _whole("laminate_of_region", "Laminate of each region", laminates.of_region),
        ]
    if facts["has_field"]:
        found.append(
            _whole(
                "field_begins", "Where the fields of each region in each load case begin", t.climate.begins
            )
        )
    return found


def _near(near: PointTables) -> list[CNumbers]:
    return [
        _whole(
            "cut_axis",
            "A tree over the plate: what each node is cut along, 0: x, 1: y, 2: nothing",
            near.axis,
        ),
        _reals("cut_at", "and where, m", near.at),
        _whole(
            "cut_next",
            "The node below the cut, which the one above follows; of a leaf its number",
            near.following,
        ),
        _whole("near_begins", "Where the cells near each leaf begin", near.begins),
        _whole(
            "near_cells", "These cells, in the order in which a point on an edge asks for them", near.cells
        ),
    ]


def _reals(name: str, meaning: str, values: Iterable[float]) -> CNumbers:
    return CNumbers(name, "double", meaning, _lines([literal(float(value)) for value in values]))


def _whole(name: str, meaning: str, values: Sequence[int] | NDArray[np.integer]) -> CNumbers:
    numbers = np.asarray(values, dtype=np.int64)
    is_short = numbers.size == 0 or (numbers.min() >= 0 and numbers.max() < _SHORT)
    kind = "unsigned short" if is_short else "int"
    return CNumbers(name, kind, meaning, _lines([str(value) for value in numbers.tolist()]))


def _lines(texts: list[str]) -> tuple[str, ...]:
    return tuple(", ".join(texts[k : k + _PER_LINE]) + "," for k in range(0, len(texts), _PER_LINE))
