"""A plate as C alone: its matrix is lamc's, its deflections are those of print, and it keeps its promises."""

import ctypes
import json
import re
import shutil
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
import shapely
from click.testing import CliRunner

import lamc
from lamc import plate
from lamc.basics.errors import ExportError
from lamc.cli import main
from lamc.examples import plates
from lamc.export import files_of
from lamc.export.plate_profile import check_profile, profile_of
from lamc.export.plate_tables import pattern_of
from lamc.plates.problem import Problem
from lamc.plates.solving.system import system
from lamc.reference.plate_elements import ReferenceElement
from tests.export.test_export_clean import BLOCKS, MATH
from tests.support.ctools import CC, STRICT_CXX, needs_cc, sanitizer_works
from tests.support.exported_folders import STRICT, cc, compilers, does, needs, put
from tests.support.exported_plates import CFRP, MAKERS, SIDE, STEEL, Library, exported, problem

pytestmark = needs_cc

Load = Callable[..., Library]


@pytest.fixture(scope="module")
def load(tmp_path_factory: pytest.TempPathFactory) -> Load:
    return lambda name, **options: Library(name, tmp_path_factory.mktemp(name), **options)


# --- numbers --------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", ["square", "coupled", "squares"])
@pytest.mark.quick("square", others="campaign")
def test_the_matrix_has_the_bits_of_the_compiler_own(load: Load, name: str) -> None:
    """From the same sections: where every unknown is free or held, cells are summed in the same order."""
    made = system(problem(name))
    library = load(name)
    assert library.matrix(made.section_rows[:1]).tobytes() == pattern_of(made).data.tobytes()
    begins = [library.call("row_begin", row) for row in range(library.counts["row"] + 1)]
    assert begins == pattern_of(made).indptr.tolist()
    columns = [library.call("column", entry) for entry in range(library.counts["entry"])]
    assert columns == pattern_of(made).indices.tolist()


@pytest.mark.slow
def test_oblique_supports_and_hinge_lines_give_the_same_matrix(load: Load) -> None:
    """Sums of a few products in another order: each within some units of round-off of the largest beside it."""
    made = system(problem("oblique"))
    expected = pattern_of(made)
    library = load("oblique")
    size = np.sqrt(expected.diagonal())
    scale = size[expected.indices] * np.repeat(size, np.diff(expected.indptr))
    error = np.abs(library.matrix() - expected.data) / scale
    assert error.max() < 1e-13


@pytest.mark.parametrize("name", sorted(MAKERS))
@pytest.mark.quick("coupled", "square")
def test_every_node_moves_as_the_solver_says(load: Load, name: str) -> None:
    """Within the digits that the condition leaves to a solution in double precision; lamc's own is refined beyond."""
    own = problem(name)
    library = load(name)
    tolerance = 10 * np.finfo(float).eps * system(own).condition
    assert tolerance < 1e-7
    solved = plate.solve(own)
    solutions = list(solved.values()) if own.cases else [solved]
    assert library.counts["case"] == len(solutions)
    for case, solution in enumerate(solutions):
        motions = library.solution(case)
        table = own.dofs.table
        expected = np.where(table >= 0, solution.values[table], 0.0)
        for column in range(6):
            error = np.abs(motions[:, column] - expected[:, column]).max()
            assert error <= tolerance * max(np.abs(expected[:, column]).max(), 1e-300) or error == 0.0


def test_the_deflection_of_a_square_is_that_of_print(load: Load, shared: Path) -> None:
    """16 by 16 squares of DKT: its error of h² is 0.5 % there, and a quarter of that on twice as many."""
    cases = json.loads((shared / "reference" / "plates.json").read_text(encoding="utf-8"))["cases"]
    (expected,) = [case["expected"] for case in cases if case["id"] == "ssss_unif"]
    library = load("square")
    middle = library.lib.square_nearest_node(ctypes.c_double(SIDE / 2), ctypes.c_double(SIDE / 2))
    D = 200e9 * 1e-9 / (12 * (1 - 0.3**2))
    w = library.solution()[middle, 2] * D / (1000.0 * SIDE**4)
    assert w == pytest.approx(expected, rel=5e-3)


def test_plies_and_springs_are_parameters(load: Load) -> None:
    """A changed angle, thickness, modulus, surface and spring give what a problem of these gives."""
    library, own = load("oblique"), problem("oblique")
    p = library.parameters
    soft = plate.Material(E1=90e9, E2=9e9, nu12=0.3, G12=5e9, density=1500.0)
    thin = plate.Laminate([plate.Ply(soft, 4e-4, 70.0)])
    thick = plate.Laminate([plate.Ply(soft, 3e-4, -25.0), plate.Ply(STEEL, 3e-4)], 1e-4)
    first = 0 if own.mesh.region_names[0] != "patch" else 2
    laminates = {name: thick if name == "patch" else thin for name in own.mesh.region_names}
    cfrp = next(k for k in range(2) if p.E1[k] == CFRP.E1)
    p.E1[cfrp], p.density[cfrp] = 90e9, 1500.0
    rest, patch = (0, 1) if first == 0 else (2, 0)
    p.angle[rest], p.thickness[rest] = 70.0, 4e-4
    p.angle[patch], p.thickness[patch + 1] = -25.0, 3e-4
    expected = plate.solve(own.with_laminate(laminates))
    assert isinstance(expected, plate.Solution)
    error = np.abs(library.solution()[:, 2] - expected.values[own.dofs.of("w")]).max()
    assert error < 1e-9 * np.abs(expected.values).max()  # condition 1e5

    other = Problem(
        own.mesh,
        laminates,
        supports=[*own.supports[:1], plate.Hinged(own.supports[1].where, stiffness=9.0), own.supports[2]],
        loads=own.loads,
        hinges=[plate.HingeLine(own.hinges[0].where, 0.1, name="fold")],
    )
    p.spring[0], p.spring[1] = 9.0, 0.1
    expected = plate.solve(other)
    assert isinstance(expected, plate.Solution)
    error = np.abs(library.solution()[:, 2] - expected.values[own.dofs.of("w")]).max()
    assert error < 1e-9 * np.abs(expected.values).max()


class _Laminate(ctypes.Structure):
    _fields_ = [*((name, ctypes.c_double * 6) for name in "ABD"), ("areal_mass", ctypes.c_double)]


def test_a_laminate_is_that_of_the_formulas_in_print(load: Load) -> None:
    """Two plies at 0° and 90°, by hand: Q11, Q22 change places, and A, B, D are sums of thickness, times z, z²."""
    library = load("coupled")
    p, t = library.parameters, 1e-3
    p.angle[0], p.angle[1], p.thickness[0], p.thickness[1], p.gap[1] = 0.0, 90.0, t, t, 0.0
    p.reference[0] = t  # above the lower face: the middle
    out = _Laminate()
    assert library.call("laminate_stiffness", ctypes.byref(p), 0, ctypes.byref(out)) == 0
    rest = 1 - 0.3**2 * 9 / 150
    q11, q22, q12 = 150e9 / rest, 9e9 / rest, 0.3 * 9e9 / rest
    A = [(q11 + q22) * t, 2 * q12 * t, 0.0, (q11 + q22) * t, 0.0, 2 * 5e9 * t]
    B = [(q22 - q11) * t**2 / 2, 0.0, 0.0, (q11 - q22) * t**2 / 2, 0.0, 0.0]
    D = [entry * t**2 / 3 for entry in A]
    for found, expected in ((out.A, A), (out.B, B), (out.D, D)):  # some hundred operations of round-off
        assert np.allclose(found, expected, rtol=1e-14, atol=1e-14 * max(map(abs, expected)))
    assert out.areal_mass == pytest.approx(1600.0 * 2 * t, rel=1e-15)


@pytest.mark.parametrize(("name", "element"), [("square", "dkt"), ("coupled", "dkt+cst"), ("squares", "q8")])
@pytest.mark.quick("square-*", "coupled-*")
def test_one_cell_is_that_of_quadrature(load: Load, name: str, element: str) -> None:
    """Against the element by interpolation conditions and quadrature in numpy, which shares nothing with the C."""
    library, own = load(name), problem(name)
    size = library.counts["cell_unknown"]
    section = system(own).section_rows[0]
    for cell in (0, len(own.mesh.cells) // 2):
        corners = np.ascontiguousarray(own.mesh.corners[cell])
        found = np.full((size, size), np.nan)
        assert library.call("element_stiffness", corners, section, found) == 0
        expected = ReferenceElement(element).stiffness(corners[None], section[None])[0]
        scale = np.sqrt(np.outer(np.diag(expected), np.diag(expected)))
        assert np.abs((found - expected) / scale).max() < 1e-11  # of the quadrature's own conditions


# --- the C -----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("compiler", compilers())
@pytest.mark.parametrize("name", sorted(MAKERS))
@pytest.mark.quick("coupled-gcc", others="campaign")
def test_it_builds_without_a_warning_and_prints_the_same(
    name: str, compiler: list[str], tmp_path: Path
) -> None:
    folder = put(exported(name), tmp_path)
    files = ("example_main.c", f"{name}.c", "-lm", "-o", "example")
    cc(folder, "-std=c99", "-O2", *STRICT, *files, command=compiler)
    first = does([folder / "example"], folder)
    assert len(first.splitlines()) == len(problem(name).dofs.points) + 1
    cc(folder, "-std=c11", "-ffp-contract=off", *files, command=compiler)
    assert does([folder / "example"], folder) == first


@needs("g++")
@pytest.mark.parametrize("name", ["oblique", "squares", "warm"])
@pytest.mark.quick("oblique", "warm")
def test_it_is_valid_cxx_too(name: str, tmp_path: Path) -> None:
    folder = put(exported(name), tmp_path)
    cc(folder, *STRICT_CXX, "-Wconversion", "-c", "-x", "c++", f"{name}.c", "-o", "it.o", command=("g++",))


@pytest.mark.parametrize("name", ["oblique", "squares"])
@pytest.mark.quick("squares")
def test_the_single_header_without_a_library_is_all_there_is(name: str, tmp_path: Path) -> None:
    """Sines and cosines of plies are lamc's own either way, so the bits are the same."""
    folder = put(exported(name), tmp_path / "usual")
    cc(folder, "-std=c99", "example_main.c", f"{name}.c", "-lm", "-o", "example")
    expected = does([folder / "example"], folder)
    files = exported(name, single_header=True, libm=False)
    assert f"{name}.c" not in files
    folder = put(files, tmp_path / "single")
    cc(folder, "-std=c99", *STRICT, "example_main.c", "-o", "example")
    assert does([folder / "example"], folder) == expected


@needs("nm")
@pytest.mark.parametrize("name", ["coupled", "oblique", "squares", "warm"])
def test_nothing_is_allocated_and_nothing_is_writable(name: str, tmp_path: Path) -> None:
    folder = put(exported(name), tmp_path)
    cc(folder, "-std=c99", "-fno-pic", "-fno-pie", "-c", f"{name}.c", "-o", "it.o")
    kinds = dict(line.split()[-2:][::-1] for line in does(["nm", "it.o"], folder).splitlines())
    assert {s for s, kind in kinds.items() if kind in "BbCDdGgSs"} == set()
    assert {s for s, kind in kinds.items() if kind == "U"} <= MATH | BLOCKS
    assert all(s.startswith(f"{name}_") for s, kind in kinds.items() if kind == "T")


@pytest.mark.parametrize("name", ["coupled", "oblique", "squares", "warm"])
@pytest.mark.quick("coupled", others="campaign")
def test_it_runs_clean_under_the_sanitizers(name: str, tmp_path: Path) -> None:
    flags = ("-std=c99", "-g", "-fsanitize=address,undefined", "-fno-sanitize-recover=all")
    if not sanitizer_works(tmp_path, *flags):
        pytest.skip("this compiler has no address and undefined-behaviour sanitizers")
    folder = put(exported(name), tmp_path)
    cc(folder, *flags, "example_main.c", f"{name}.c", "-lm", "-o", "example")
    assert does([folder / "example"], folder).startswith("x,y,")


@needs("cmake", "pkg-config")
@pytest.mark.slow
def test_cmake_and_pkg_config_find_two_plates_for_one_program(tmp_path: Path) -> None:
    names, prefix = ("square", "oblique"), tmp_path / "prefix"
    for name in names:
        folder = put(exported(name), tmp_path / name)
        does(["cmake", "-S", ".", "-B", "build"], folder)
        does(["cmake", "--build", "build"], folder)
        assert does([f"build/{name}_example"], folder).startswith("x,y,")
        does(["cmake", "--install", "build", "--prefix", prefix], folder)
    (tmp_path / "app.c").write_text(
        '#include "square.h"\n#include "oblique.h"\n'
        "int main(void) { return square_row_begin(0) + oblique_row_begin(0); }\n"
    )
    (folders,) = {str(path.parent) for path in prefix.rglob("square.pc")}
    command = f"{shutil.which(CC.split()[0])} app.c $(pkg-config --cflags --libs square oblique) -o app"
    does(["sh", "-c", command], tmp_path, PKG_CONFIG_PATH=folders)
    does([tmp_path / "app"], tmp_path)


def test_the_same_plate_gives_the_same_bytes() -> None:
    options = lamc.ExportOptions(prefix="oblique")
    assert dict(files_of(MAKERS["oblique"](), "c", options=options)) == exported("oblique")


# --- refusals --------------------------------------------------------------------------------------------------------


def test_wrong_arguments_are_refused_by_status(load: Load) -> None:
    library = load("oblique")
    p, values = library.parameters, library.array("entry")
    rhs, work, x = library.array("row"), library.array("work"), library.array("row")
    pointer = ctypes.byref(p)

    def again() -> None:
        ctypes.memmove(pointer, library.default, len(library.default))

    assert library.call("assemble", pointer, None) == -5
    assert library.call("load", pointer, 1, rhs) == library.call("load", pointer, -1, rhs) == -5
    p.digest[3] ^= 1
    assert library.call("assemble", pointer, values) == library.call("load", pointer, 0, rhs) == -20
    again()
    for field, value in (
        ("E1", np.nan),
        ("E2", 0.0),
        ("nu12", 9.0),
        ("thickness", -1e-3),
        ("angle", np.inf),
        ("gap", -1e-9),
        ("spring", -1.0),
    ):
        getattr(p, field)[0] = value
        assert library.call("assemble", pointer, values) == -22, field
        again()
    assert library.call("assemble", None, values) == library.call("load", None, 0, rhs) == 0
    rhs[5] = np.nan
    assert library.call("solve", values, rhs, work, x) == -23
    rhs[5] = 0.0
    assert library.call("solve", np.zeros_like(values), rhs, work, x) == -25
    assert library.call("displacement", x, -1, np.zeros(6)) == -5
    assert library.call("row_of", 10**6, 2) == -2


def _grid(count: int, **parts: object) -> Problem:
    return Problem(plate.grid(SIDE, SIDE, count, count), plate.Laminate([plate.Ply(STEEL, 1e-3)]), **parts)  # type: ignore[arg-type]


EDGE = shapely.LineString([(0.0, 0.0), (0.0, SIDE)])


@pytest.mark.parametrize(
    ("made", "said"),
    [
        (lambda: _grid(3), r"not held: nothing prevents that it .*add a support"),
        (
            lambda: _grid(101, supports=[plate.Clamped(EDGE)]),
            r"20402 cells; 20000 at most.*--size '2.1 mm'.*edge_length=0.0021",
        ),
    ],
)
def test_what_cannot_be_exported_is_reported_with_a_way_out(made: Callable[[], Problem], said: str) -> None:
    with pytest.raises(ExportError, match=said):
        files_of(made(), "c")


def test_the_command_knows_a_plate_by_its_content(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    text = plates.find("creases").text
    (tmp_path / "card.yaml").write_text(text, encoding="utf-8")
    result = CliRunner().invoke(main, ["export", "card.yaml", "--size", "5 mm", "--out", "here", "--json"])
    assert result.exit_code == 0, result.stderr
    data = json.loads(result.stdout)
    assert data["design"] == "creases"
    assert set(data["files"]) == {path.name for path in (tmp_path / "here").iterdir()}
    file = plate.load_plate(tmp_path / "card.yaml")
    expected = files_of(file, "c", options=lamc.ExportOptions(edge_length=5e-3))
    assert {path: (tmp_path / "here" / path).read_bytes() for path in expected} == dict(expected)
    for words, said in (
        (("card.yaml", "--real-time"), "--real-time (real_time): a plate has no use for it"),
        (("card.yaml", "--angle", "h=1"), "effects, angles, rates and scenes belong to mechanisms"),
        (("card.yaml", "--size", "2 kg"), "--size '2 kg'"),
        (
            ("--example", "squar"),
            "there is no example 'squar'; did you mean 'square'?",
        ),
        (
            ("--example", "pendulum", "--size", "2 mm"),
            "--size (edge_length): c has no use for it; leave it out (it is for a plate)",
        ),
    ):
        refused = CliRunner().invoke(main, ["export", *words])
        assert refused.exit_code == 2
        *stages, error = refused.stderr.strip().splitlines()
        assert said in error
        assert all(stage.endswith(" …") for stage in stages)


@pytest.mark.slow
def test_the_length_of_edges_that_a_refusal_tells_is_long_enough(tmp_path: Path) -> None:
    """By the limit of cells: the gallery's square, as the command meets it. By that of the factors, five unknowns per
    node: the same mesh but for the plies."""
    words = ["export", "--example", "square", "--out", str(tmp_path / "square"), "--json"]
    refused = CliRunner().invoke(main, words)
    assert refused.exit_code == 2
    said = refused.stderr.strip().splitlines()[-1]
    assert "the mesh has 51200 cells; 20000 at most" in said
    (size,) = re.findall(r"--size '([^']+)'", said)
    assert float(size.removesuffix(" mm")) < 1.1 * 2.0  # 100 by 100 squares are the finest
    assert CliRunner().invoke(main, [*words, "--size", size]).exit_code == 0

    plies = plate.Laminate([plate.Ply(CFRP, 1e-3, 30.0), plate.Ply(CFRP, 1e-3)])

    def of(count: int) -> Problem:
        return Problem(plate.grid(SIDE, SIDE, count, count), plies, supports=[plate.Clamped(EDGE)])

    for count in (80, 101):
        with pytest.raises(ExportError, match=r"at most are exported") as reported:
            files_of(of(count), "c")
        (length,) = re.findall(r"edge_length=(\S+)", str(reported.value))
        enough = round(SIDE / float(length))
        assert 0.9 * 77 < enough <= 77  # the finest
        check_profile(of(enough), int(profile_of(pattern_of(system(of(enough))))[1][-1]))


def test_options_and_targets_of_mechanisms_are_refused() -> None:
    with pytest.raises(
        ExportError, match=r"--real-time \(real_time\): a Problem, which has its mesh, has no"
    ):
        files_of(problem("square"), "c", options=lamc.ExportOptions(real_time=True))
    with pytest.raises(ExportError, match="to 'c' only, not to 'fmu'"):
        files_of(problem("square"), "fmu")
    with pytest.raises(
        ExportError, match=r"--size \(edge_length\): a Problem, which has its mesh, .* for a plate"
    ):
        files_of(problem("square"), "c", options=lamc.ExportOptions(edge_length=1e-3))
    for call in (files_of, lamc.export):
        with pytest.raises(ExportError, match=r"a scene is given with a plate.*leave scene= out"):
            call(problem("square"), "c", lamc.Scene())
    with pytest.raises(ExportError, match=r"--size \(edge_length\) is 0"):
        lamc.ExportOptions(edge_length=0.0)
