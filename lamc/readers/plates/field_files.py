"""Fields over a mesh as files: CSV for spreadsheets, VTU for ParaView and other viewers.

In: a mesh and columns of values at its points or of its cells, SI. Out: files, written whole or not at all. Never:
computes a field.
"""

import base64
from collections.abc import Mapping
from pathlib import Path
from xml.sax.saxutils import quoteattr

import numpy as np
from numpy.typing import NDArray

from lamc.basics.checks import Array
from lamc.basics.files import write_text
from lamc.plates.meshing.mesh import Mesh

Columns = Mapping[str, Array]  # name with unit, (n,) or (n, 3)

_TRIANGLE, _QUADRILATERAL = 5, 9  # VTK's numbers for kinds of cells
_KINDS = {"f": "Float64", "i": "Int64", "u": "UInt8"}


def write_table(mesh: Mesh, columns: Columns, path: Path) -> Path:
    """One row per point of the mesh: x, y in m and then `columns`, each (points,), with 17 digits.

    Names are quoted where they hold a comma. Raises LamcError if it cannot write.
    """
    names = ["x [m]", "y [m]", *columns]
    table = np.column_stack([mesh.points, *columns.values()])
    lines = [",".join(_cell(name) for name in names)]
    lines += [",".join(repr(value) for value in row) for row in table.tolist()]
    write_text(path, "\n".join(lines) + "\n")
    return path


def write_vtu(mesh: Mesh, of_points: Columns, of_cells: Columns, path: Path) -> Path:
    """An unstructured grid of VTK, in XML, arrays in base64: points at z = 0, `of_points` and `of_cells` by name.

    Raises LamcError if it cannot write. Source: The VTK User's Guide, 11th ed. 2010, "XML file formats".
    """
    points = np.column_stack([mesh.points, np.zeros(len(mesh.points))])
    corners = mesh.corner_count
    kind = _TRIANGLE if corners == 3 else _QUADRILATERAL
    ends = corners * np.arange(1, len(mesh.cells) + 1)
    text = "\n".join(
        [
            '<?xml version="1.0"?>',
            '<VTKFile type="UnstructuredGrid" version="1.0" byte_order="LittleEndian" header_type="UInt64">',
            "<UnstructuredGrid>",
            f'<Piece NumberOfPoints="{len(points)}" NumberOfCells="{len(mesh.cells)}">',
            "<Points>",
            _array("points", points),
            "</Points>",
            "<Cells>",
            _array("connectivity", mesh.cells.ravel()),
            _array("offsets", ends),
            _array("types", np.full(len(mesh.cells), kind, dtype=np.uint8)),
            "</Cells>",
            "<PointData>",
            *(_array(name, values) for name, values in of_points.items()),
            "</PointData>",
            "<CellData>",
            *(_array(name, values) for name, values in of_cells.items()),
            "</CellData>",
            "</Piece>",
            "</UnstructuredGrid>",
            "</VTKFile>",
        ]
    )
    write_text(path, text + "\n")
    return path


def _array(name: str, values: NDArray[np.generic]) -> str:
    """One array: the number of its bytes and then the bytes, little-endian, in base64."""
    kind = values.dtype.kind
    data = np.ascontiguousarray(values, dtype={"f": "<f8", "i": "<i8", "u": "u1"}[kind]).tobytes()
    size = np.array([len(data)], dtype="<u8").tobytes()
    width = values.shape[1] if values.ndim == 2 else 1
    return (
        f'<DataArray type="{_KINDS[kind]}" Name={quoteattr(name)} NumberOfComponents="{width}" format="binary">'
        f"{base64.b64encode(size + data).decode('ascii')}</DataArray>"
    )


def _cell(text: str) -> str:
    quoted = text.replace('"', '""')
    return f'"{quoted}"' if any(mark in text for mark in ',"\n') else text
