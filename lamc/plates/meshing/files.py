"""Mesh files, by way of meshio: gmsh, VTK, Abaqus, Medit.

In: a path. Out: a `Mesh` with its regions; or the file, whole or not at all. Never: runs or includes what a file names;
3-D meshes, elements with nodes on their edges.

Regions are physical groups in .msh, sets of elements in .inp, references in .mesh, and in .vtk and .vtu one array per
region that is 1 on its cells, named "region:" and the name as URLs write it.
"""

import contextlib
import io
import os
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from types import ModuleType
from typing import Any
from urllib.parse import quote, unquote

import numpy as np
from numpy.typing import ArrayLike, NDArray

from lamc.basics.checks import Array, checked_kind, shown
from lamc.basics.errors import DesignError, LamcError, Place, UnsupportedError
from lamc.basics.files import checked_path, replacing
from lamc.plates.meshing.mesh import MAKING, Integers, Mesh

LARGEST = 2**30  # bytes of a file

_FORMATS = {".msh": "gmsh", ".vtk": "vtk", ".vtu": "vtu", ".inp": "abaqus", ".mesh": "medit"}
_CELLS = {"triangle": 3, "quad": 4}
_OTHER = ("vertex", "line", "line3", "line4", "line5")  # of no area: borders and marks, left out
_FLAT = 1e-9  # of the extent in x and y: largest height of points over each other
_PREFIX = "region:"
_NUMBERED = ("gmsh:physical", "medit:ref", "region", "gmsh:geometrical")


def read_mesh(path: str | os.PathLike[str]) -> Mesh:
    """The triangles or quadrilaterals of a mesh file in the plane z = 0, or another constant z; coordinates are taken
    to be metres. Points that none of them uses are left out, and so are lines and data.

    Raises DesignError with the path for a file that is missing, larger than LARGEST, broken, not flat, or holds cells
    of several kinds; UnsupportedError without meshio and for other formats.
    """
    file = checked_path(path)
    place = Place(str(file))
    module = _format(file, place)
    _check_readable(file, place)
    try:
        with _silent():
            raw = module.read(str(file))
    except MemoryError as error:
        raise DesignError("the file asks for more memory than there is; it may be broken", place) from error
    # meshio's readers trust their input: what a broken file raises can be anything, sys.exit included.
    except (Exception, SystemExit) as error:
        reported = " ".join(str(error).split())[:120] or type(error).__name__
        raise DesignError(
            f"this is not a whole {file.suffix} file: {reported}; write it again", place
        ) from error
    try:
        return _mesh_of(raw)
    except LamcError as error:
        raise type(error)(error.message, place) from error
    except (TypeError, ValueError, IndexError, KeyError, AttributeError, OverflowError) as error:
        raise DesignError(
            f"the mesh in this file does not fit together: {shown(error)}; write it again", place
        ) from error


def write_mesh(
    path: str | os.PathLike[str],
    mesh: Mesh,
    point_data: Mapping[str, ArrayLike] | None = None,
    cell_data: Mapping[str, ArrayLike] | None = None,
) -> None:
    """Writes `mesh` in one step; `read_mesh` gives it back, to the last digit; .mesh numbers regions instead of naming
    them. Data have one row per point or per cell; .inp and .mesh have no place for them.

    Raises DesignError for data of another length, UnsupportedError without meshio, for other formats, and for data or
    names that the format cannot hold, LamcError where the file cannot be written.
    """
    file = checked_path(path)
    checked_kind(mesh, Mesh, f"what is written to {file.name}", MAKING)
    module = _format(file, None)
    data = [
        {name: _checked_data(name, values, count, what) for name, values in (given or {}).items()}
        for given, count, what in (
            (point_data, len(mesh.points), "point"),
            (cell_data, len(mesh.cells), "cell"),
        )
    ]
    kind = file.suffix.lower()
    if kind in (".inp", ".mesh") and (data[0] or data[1]):
        raise UnsupportedError(f"{kind} files hold no data at points or cells; write .vtu for them")
    cells = {name: [values] for name, values in data[1].items()}
    fields, sets = _written_regions(mesh, kind, cells)
    points = np.column_stack([mesh.points, np.zeros(len(mesh.points))])
    name = "triangle" if mesh.corner_count == 3 else "quad"
    blocks = [(name, np.asarray(mesh.cells, dtype=np.int64 if kind != ".mesh" else np.int32))]
    meshio = _meshio()
    options: dict[str, dict[str, Any]] = {
        ".msh": {"fmt_version": "2.2", "binary": True},
        ".inp": {"float_fmt": ".16e"},
    }
    with replacing(file) as temporary, _silent():
        raw = meshio.Mesh(
            points, blocks, point_data=data[0], cell_data=cells, field_data=fields, cell_sets=sets
        )
        try:
            module.write(str(temporary), raw, **options.get(kind, {}))
        except (meshio.WriteError, KeyError, ValueError, TypeError) as error:
            raise UnsupportedError(
                f"{kind} files cannot hold this mesh: {shown(error)}; write .vtu"
            ) from error


def _meshio() -> ModuleType:
    try:
        import meshio
    except ImportError as error:
        raise UnsupportedError(
            "mesh files need the package meshio, which is not installed: `pip install lamc[mesh]`"
        ) from error
    module: ModuleType = meshio
    return module


def _format(file: Path, place: Place | None) -> ModuleType:
    kind = file.suffix.lower()
    if kind not in _FORMATS:
        raise UnsupportedError(
            f"{str(file)!r} has the ending {kind!r}; mesh files end in {', '.join(_FORMATS)}: convert it, as by "
            "`meshio convert`",
            place,
        )
    module: ModuleType = getattr(_meshio(), _FORMATS[kind])
    return module


def _check_readable(file: Path, place: Place) -> None:
    try:
        if not file.is_file():
            raise DesignError(
                "there is no such file" if not file.exists() else "this is not a plain file", place
            )
        if file.stat().st_size > LARGEST:
            raise DesignError(f"the file is larger than the limit 'bytes' of {LARGEST}", place)
        if file.suffix.lower() == ".inp" and b"*INCLUDE" in file.read_bytes().upper().replace(b" ", b""):
            raise DesignError(
                "*INCLUDE names another file, and is not followed: put all into one file", place
            )
    except OSError as error:
        raise DesignError(f"the file cannot be read: {error.strerror or error}", place) from error
    except ValueError as error:  # a null character in the path
        raise DesignError(f"{str(file)!r} is not a usable path: {error}") from error


@contextlib.contextmanager
def _silent() -> Iterator[None]:
    """meshio tells the terminal about data that it leaves out."""
    with (
        contextlib.redirect_stdout(io.StringIO()),
        contextlib.redirect_stderr(io.StringIO()),
        np.errstate(all="ignore"),
    ):
        yield


def _mesh_of(raw: Any) -> Mesh:
    kinds = [block.type for block in raw.cells]
    areas = sorted({kind for kind in kinds if kind not in _OTHER})
    if not areas:
        raise DesignError(
            "there are no triangles and no quadrilaterals in this file; mesh the surface and write them"
        )
    if len(areas) > 1 or areas[0] not in _CELLS:
        raise DesignError(
            f"the cells are {', '.join(areas)}; a mesh has triangles only or quadrilaterals only, with corners only: "
            "write a 2-D mesh of first order, and recombine all cells or none"
        )
    chosen = [k for k, kind in enumerate(kinds) if kind == areas[0]]
    cells = np.concatenate([np.asarray(raw.cells[k].data) for k in chosen])
    points = _flat(np.asarray(raw.points, dtype=float))
    if cells.min(initial=0) < 0 or cells.max(initial=-1) >= len(points):
        raise DesignError(
            f"a cell has a corner that is none of the {len(points)} points; write the file again"
        )
    names, regions = _read_regions(raw, chosen, len(cells))
    used, renumbered = np.unique(cells, return_inverse=True)
    return Mesh(points[used], renumbered.reshape(cells.shape).astype(np.int32), regions, names)


def _flat(points: Array) -> Array:
    if points.ndim != 2 or points.shape[1] not in (2, 3) or not len(points):
        raise DesignError(f"the points have shape {points.shape}; they must have two or three coordinates")
    if points.shape[1] == 3 and len(points):
        extent = float(np.ptp(points[:, :2], axis=0).max())
        height = float(np.ptp(points[:, 2]))
        if not height <= _FLAT * extent:
            raise DesignError(
                f"the points lie at heights {points[:, 2].min():g} to {points[:, 2].max():g} m; a plate is flat: "
                "all must have the same z"
            )
    return points[:, :2]


def _read_regions(raw: Any, chosen: Sequence[int], count: int) -> tuple[tuple[str, ...], Integers]:
    """Region names and index per cell, from whatever the format has for them."""
    data = {
        name: np.concatenate([np.ravel(values[k]) for k in chosen]) for name, values in raw.cell_data.items()
    }
    named = {
        unquote(name[len(_PREFIX) :]): values != 0
        for name, values in data.items()
        if name.startswith(_PREFIX)
    }
    if not named and "gmsh:physical" not in data:
        named = _sets(raw, chosen)
    if named:
        return _from_sets(named, count)
    numbers = next((data[name] for name in _NUMBERED if name in data), np.zeros(count, dtype=int))
    names = {int(tag): str(name) for name, (tag, dimension) in raw.field_data.items() if int(dimension) == 2}
    present, index = np.unique(numbers, return_inverse=True)
    if len(present) == 1 and int(present[0]) not in names:
        return ("",), np.zeros(count, dtype=np.int32)
    return tuple(names.get(int(k), "" if int(k) == 0 else str(int(k))) for k in present), index.astype(
        np.int32
    )


def _sets(raw: Any, chosen: Sequence[int]) -> dict[str, NDArray[np.bool_]]:
    """Cells of each set of elements; a set of all cells tells nothing beside others, and is left out."""
    found = {}
    for name, parts in raw.cell_sets.items():
        marks = []
        for k in chosen:
            mark = np.zeros(len(raw.cells[k].data), dtype=bool)
            if parts[k] is not None:
                mark[np.asarray(parts[k], dtype=np.int64)] = True
            marks.append(mark)
        inside = np.concatenate(marks)
        if inside.any():
            found[unquote(name)] = inside
    return found if len(found) < 2 else {name: inside for name, inside in found.items() if not inside.all()}


def _from_sets(named: Mapping[str, NDArray[np.bool_]], count: int) -> tuple[tuple[str, ...], Integers]:
    index = np.zeros(count, dtype=np.int32)
    names = list(named)
    for number, name in enumerate(names, start=1):
        both = named[name] & (index > 0)
        if both.any():
            cell = int(np.argmax(both))
            raise DesignError(
                f"cell {cell} is in the regions {names[index[cell] - 1]!r} and {name!r}; a cell has one region: take "
                "it out of one of them"
            )
        index[named[name]] = number
    if (index > 0).all():
        return tuple(names), index - np.int32(1)
    if "" in names:
        index[index == 0] = names.index("") + 1
        return tuple(names), index - np.int32(1)
    return ("", *names), index


def _written_regions(
    mesh: Mesh, kind: str, cells: dict[str, list[NDArray[Any]]]
) -> tuple[dict[str, NDArray[np.int64]], dict[str, list[NDArray[np.int64]]]]:
    """Fields and sets for the regions; what goes into arrays is put into `cells`."""
    several = len(mesh.region_names) > 1 or mesh.region_names[0] != ""
    numbers = mesh.regions.astype(np.int32) + np.int32(1)
    if kind == ".msh":
        bad = [name for name in mesh.region_names if not set(name).isdisjoint('"\\')]
        if bad:
            raise UnsupportedError(
                f"region {bad[0]!r} has a quote or backslash, which .msh cannot hold: rename it"
            )
        cells["gmsh:physical"] = cells["gmsh:geometrical"] = [numbers]
        groups = {name: np.array([k, 2]) for k, name in enumerate(mesh.region_names, start=1)}
        return groups if several else {}, {}
    if kind == ".mesh":
        cells["medit:ref"] = [numbers]
    if kind in (".vtk", ".vtu") and several:
        for k, name in enumerate(mesh.region_names):
            cells[_PREFIX + quote(name, safe="")] = [(mesh.regions == k).astype(np.int32)]
    sets = {
        quote(n, safe=""): [np.flatnonzero(mesh.regions == k)] for k, n in enumerate(mesh.region_names) if n
    }
    return {}, sets if kind == ".inp" else {}


def _checked_data(name: str, values: ArrayLike, count: int, what: str) -> NDArray[Any]:
    array = np.asarray(values)
    if array.dtype.kind not in "fiu" or array.ndim not in (1, 2) or len(array) != count:
        raise DesignError(
            f"{what} data {shown(name)} have shape {array.shape} of {array.dtype}; they must be numbers, one row for "
            f"each of the {count} {what}s"
        )
    return array
