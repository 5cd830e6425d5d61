"""Mesh files give back what was written; broken ones end soon, with a mesh or an error that names the file."""

import sys
import time
from collections.abc import Callable
from functools import cache
from pathlib import Path

import meshio
import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from shapely.geometry import box

from lamc import plate
from lamc.basics.errors import DesignError, LamcError, UnsupportedError
from lamc.plates.meshing.mesh import Mesh
from tests.support.quick import tries

FORMATS = (".msh", ".vtk", ".vtu", ".inp", ".mesh")
PATIENCE = 5.0  # s; a tenth is usual, but the machine may be busy with other tests
FEW = settings(
    max_examples=tries(60), deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture]
)
SQUARE = np.array([(0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (1.0, 1.0, 0.0), (0.0, 1.0, 0.0)])
TWO = np.array([(0, 1, 2), (0, 2, 3)])

MESHES = {
    "regions": lambda: plate.mesh(
        box(0, 0, 20.1e-3, 5e-3),
        2e-3,
        regions={"left": box(0, 0, 10e-3, 5e-3), "hinge é, 1": box(10e-3, 0, 10.1e-3, 5e-3)},
    ),
    "one region": lambda: plate.grid(1.0, 1.0, 2, 2, regions={"all": box(0, 0, 1, 1)}),
    "plain": lambda: plate.grid(1.0, 2.0, 3, 2, "criss-cross"),
    "squares": lambda: plate.grid(1.0, 2.0, 3, 4, "squares", regions={"low": box(0, 0, 1, 1)}),
}


@cache
def mesh_of(name: str) -> plate.Mesh:
    """Made when it is asked for: the first one has the mesher compiled."""
    return MESHES[name]()


@pytest.mark.parametrize("kind", FORMATS)
@pytest.mark.parametrize("name", MESHES)
def test_a_mesh_that_was_written_is_read_again(kind: str, name: str, tmp_path: Path) -> None:
    mesh, path = mesh_of(name), tmp_path / f"a{kind}"
    plate.write_mesh(path, mesh)
    read = plate.read_mesh(path)
    assert np.array_equal(read.points, mesh.points)
    assert np.array_equal(read.cells, mesh.cells)
    if kind == ".mesh":  # numbers are kept, names are not
        assert len(read.region_names) == len(mesh.region_names)
    else:
        assert read.region_names == mesh.region_names
    assert np.array_equal(read.regions, mesh.regions)
    assert [p.name for p in tmp_path.iterdir()] == [path.name]


@pytest.mark.parametrize("kind", [".msh", ".vtk", ".vtu"])
def test_data_at_points_and_cells_are_written(kind: str, tmp_path: Path) -> None:
    mesh, path = mesh_of("regions"), tmp_path / f"a{kind}"
    deflection = np.sin(mesh.points[:, 0])
    plate.write_mesh(
        path, mesh, {"deflection": deflection}, {"moments": np.outer(mesh.areas, (1.0, 2.0, 3.0))}
    )
    raw = getattr(meshio, {".msh": "gmsh", ".vtk": "vtk", ".vtu": "vtu"}[kind]).read(path)
    assert np.array_equal(raw.point_data["deflection"].ravel(), deflection)
    assert np.array_equal(raw.cell_data["moments"][0][:, 1], 2.0 * mesh.areas)
    assert plate.read_mesh(path).region_names == mesh.region_names


def test_a_gmsh_file_of_someone_else_is_read(tmp_path: Path) -> None:
    # As gmsh 4.11 writes it: version 4.1, a line on the border, and a point at a circle's centre that no cell uses.
    path = tmp_path / "theirs.msh"
    path.write_text(
        """$MeshFormat
4.1 0 8
$EndMeshFormat
$PhysicalNames
2
1 7 "rim"
2 3 "link"
$EndPhysicalNames
$Entities
0 1 1 0
1 0 0 0 1 0 0 1 7 0
1 0 0 0 1 1 0 1 3 1 1
$EndEntities
$Nodes
1 5 1 5
2 1 0 5
1
2
3
4
5
0 0 0
1 0 0
9 9 0
1 1 0
0 1 0
$EndNodes
$Elements
2 3 1 3
1 1 1 1
1 1 2
2 1 2 2
2 1 2 4
3 1 5 4
$EndElements
"""
    )
    mesh = plate.read_mesh(path)
    assert mesh.points.tolist() == [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]
    assert mesh.cells.tolist() == [[0, 1, 2], [0, 2, 3]]  # the second was clockwise
    assert mesh.region_names == ("link",)


def write(path: Path, points: np.ndarray, cells: list[tuple[str, np.ndarray]], **more: object) -> None:
    getattr(meshio, {".vtu": "vtu", ".inp": "abaqus"}[path.suffix]).write(
        path, meshio.Mesh(points, cells, **more)
    )


BAD: dict[str, tuple[Callable[[Path], None], str]] = {
    "high": (
        lambda p: write(
            p, SQUARE + np.array([(0, 0, 0), (0, 0, 0), (0, 0, 0), (0, 0, 0.1)]), [("triangle", TWO)]
        ),
        "heights 0 to 0.1",
    ),
    "mixed": (
        lambda p: write(p, SQUARE, [("triangle", TWO[:1]), ("quad", np.array([(0, 1, 2, 3)]))]),
        "cells are quad, triangle; .* recombine all cells or none",
    ),
    "solid": (lambda p: write(p, SQUARE, [("tetra", np.array([(0, 1, 2, 3)]))]), "cells are tetra"),
    "second order": (
        lambda p: write(p, np.random.default_rng(0).random((6, 3)), [("triangle6", np.arange(6)[None])]),
        "cells are triangle6; .* first order",
    ),
    "lines only": (lambda p: write(p, SQUARE, [("line", np.array([(0, 1)]))]), "no triangles"),
    "folded": (
        lambda p: write(
            p, SQUARE * (1, 1, 0) + np.array([(0, 0, 0)] * 3 + [(0.9, -0.8, 0)]), [("triangle", TWO)]
        ),
        "one of them is inverted",
    ),
    "twice": (lambda p: write(p, SQUARE, [("triangle", TWO[[0, 1, 0]])]), "again"),
    "two regions": (
        lambda p: write(
            p,
            SQUARE,
            [("triangle", TWO)],
            cell_data={"region:a": [np.array([1, 1])], "region:b": [np.array([0, 1])]},
        ),
        "cell 1 is in the regions 'a' and 'b'",
    ),
    "not a number": (lambda p: write(p, SQUARE * np.nan, [("triangle", TWO)]), "finite|heights"),
    "other text": (lambda p: p.write_text("<VTKFile"), "not a whole .vtu file"),
    "empty": (lambda p: p.write_bytes(b""), "not a whole .vtu file"),
    "missing": (lambda p: None, "no such file"),
    "folder": (lambda p: p.mkdir(), "not a plain file"),
}


@pytest.mark.parametrize("case", BAD)
def test_files_that_hold_no_plate_are_refused_by_name(case: str, tmp_path: Path) -> None:
    make, message = BAD[case]
    path = tmp_path / "bad.vtu"
    make(path)
    with pytest.raises(DesignError, match=message) as caught:
        plate.read_mesh(path)
    assert str(caught.value).startswith(str(path))
    assert "\n" not in str(caught.value)


def test_files_do_not_pull_in_others(tmp_path: Path) -> None:
    secret = tmp_path / "secret.inp"
    plate.write_mesh(secret, mesh_of("plain"))
    path = tmp_path / "a.inp"
    path.write_text(f"*Include , INPUT={secret}\n")
    with pytest.raises(DesignError, match=r"\*INCLUDE names another file"):
        plate.read_mesh(path)


def test_other_formats_are_refused_with_the_ones_there_are(tmp_path: Path) -> None:
    with pytest.raises(UnsupportedError, match=r"'\.stl'; mesh files end in \.msh, "):
        plate.read_mesh(tmp_path / "a.stl")
    with pytest.raises(UnsupportedError, match=r"'\.xyz'"):
        plate.write_mesh(tmp_path / "a.xyz", mesh_of("plain"))


def test_without_meshio_the_error_says_what_to_install(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "meshio", None)
    with pytest.raises(UnsupportedError, match=r"pip install lamc\[mesh\]"):
        plate.read_mesh(tmp_path / "a.vtu")


@pytest.mark.parametrize(
    ("kind", "arguments", "message"),
    [
        (".vtu", {"point_data": {"w": [1.0]}}, r"point data 'w' .* each of the 4 points"),
        (".vtu", {"cell_data": {"w": ["a", "b"]}}, "cell data 'w'"),
        (".inp", {"point_data": {"w": np.zeros(4)}}, "write .vtu"),
    ],
)
def test_data_that_do_not_fit_are_refused_and_leave_no_file(
    kind: str, arguments: dict[str, object], message: str, tmp_path: Path
) -> None:
    with pytest.raises(LamcError, match=message):
        plate.write_mesh(tmp_path / f"a{kind}", Mesh(SQUARE[:, :2], TWO), **arguments)  # type: ignore[arg-type]
    assert not list(tmp_path.iterdir())


def test_names_that_gmsh_cannot_hold_are_refused(tmp_path: Path) -> None:
    mesh = Mesh(SQUARE[:, :2], TWO, [0, 1], ("a", 'b"'))
    with pytest.raises(UnsupportedError, match="rename it"):
        plate.write_mesh(tmp_path / "a.msh", mesh)


def test_a_failed_write_leaves_the_old_file(tmp_path: Path) -> None:
    path = tmp_path / "a.vtu"
    plate.write_mesh(path, mesh_of("plain"))
    before = path.read_bytes()
    with pytest.raises(LamcError):
        plate.write_mesh(path, mesh_of("plain"), {"w": np.zeros(3)})
    assert path.read_bytes() == before
    with pytest.raises(LamcError, match="cannot be written"):
        plate.write_mesh(tmp_path / "missing" / "a.vtu", mesh_of("plain"))


def attempt(path: Path, data: bytes) -> None:
    """Reads the bytes as a file; anything but a mesh or a LamcError escapes and fails the test."""
    path.write_bytes(data)
    began = time.monotonic()
    message = f"{path}: read"
    try:
        plate.read_mesh(path)
    except LamcError as error:
        message = str(error)
    assert message.startswith(str(path))
    assert "\n" not in message
    assert len(message) < 1000
    assert time.monotonic() - began < PATIENCE


@pytest.fixture(scope="module")
def originals(tmp_path_factory: pytest.TempPathFactory) -> dict[str, bytes]:
    folder = tmp_path_factory.mktemp("originals")
    mesh = Mesh(SQUARE[:, :2], TWO, [0, 1], ("a", "b"))
    for kind in FORMATS:
        plate.write_mesh(folder / f"a{kind}", mesh)
    return {kind: (folder / f"a{kind}").read_bytes() for kind in FORMATS}


@FEW
@pytest.mark.parametrize("kind", FORMATS)
@given(data=st.data())
def test_damaged_files_are_a_mesh_or_an_error(
    kind: str, data: st.DataObject, tmp_path: Path, originals: dict[str, bytes]
) -> None:
    text = originals[kind]
    for _ in range(data.draw(st.integers(1, 3))):
        at = data.draw(st.integers(0, len(text)))
        length = data.draw(st.integers(0, 40))
        new = data.draw(
            st.one_of(
                st.binary(max_size=8), st.sampled_from([b"-1", b"99999999999", b"1e999", b"nan", b"\n"])
            )
        )
        text = text[:at] + new + text[at + length :]
    attempt(tmp_path / f"a{kind}", text)


@FEW
@pytest.mark.parametrize("kind", FORMATS)
@given(data=st.data())
def test_cut_files_are_a_mesh_or_an_error(
    kind: str, data: st.DataObject, tmp_path: Path, originals: dict[str, bytes]
) -> None:
    attempt(tmp_path / f"a{kind}", originals[kind][: data.draw(st.integers(0, len(originals[kind])))])


@FEW
@pytest.mark.parametrize("kind", FORMATS)
@given(data=st.binary(max_size=300))
def test_any_bytes_are_a_mesh_or_an_error(kind: str, data: bytes, tmp_path: Path) -> None:
    attempt(tmp_path / f"a{kind}", data)
