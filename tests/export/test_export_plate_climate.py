"""What temperature, moisture and electric fields do to a plate in exported C: what laminate theory and lamc say."""

import ctypes
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
from lamc.export import files_of
from lamc.plates.loads import LoadRecord
from lamc.plates.problem import Problem
from lamc.plates.solving.load_vectors import load_vector
from lamc.plates.solving.system import system
from tests.support.ctools import needs_cc
from tests.support.exported_plates import CFRP, GRAPHITE, PZT, STEEL, Array, Library, problem

pytestmark = needs_cc

Load = Callable[..., Library]
BAD_PARAMETER, COUPLED = -22, -27


@pytest.fixture(scope="module")
def load(tmp_path_factory: pytest.TempPathFactory) -> Load:
    return lambda name, **options: Library(name, tmp_path_factory.mktemp(name), **options)


def _forces(library: Library, case: int) -> Array:
    rhs = library.array("row")
    assert library.call("load", ctypes.byref(library.parameters), case, rhs) == 0
    return rhs


def _close(found: Array, expected: Array) -> None:
    """Sums over plies and cells in another order: each force within 1e-13 of the terms that cancel in it, which the
    largest of all bounds."""
    assert np.abs(found - expected).max() < 1e-13 * np.abs(expected).max()


def test_forces_of_expansion_are_those_of_lamc(load: Load) -> None:
    own, library = problem("warm"), load("warm")
    made = system(own)
    for case, loads in enumerate(own.cases.values()):
        _close(
            _forces(library, case),
            made.constraints.free.T @ load_vector(own, made.kernels, [*own.loads, *loads]),
        )


def test_plies_and_climates_are_parameters(load: Load) -> None:
    """What plies push with follows their angles, thicknesses, moduli and expansions as in a plate made of these."""
    library = load("warm")
    p = library.parameters
    own = problem("warm")
    rest = next(k for k, name in enumerate(own.mesh.region_names) if name != "patch")
    patch = 1 - rest
    of_rest, of_patch = (0, 2) if rest == 0 else (2, 0)  # first plies
    graphite = next(k for k in range(2) if p.d31[k] == 0.0)
    p.angle[of_rest + 1], p.thickness[of_patch], p.E2[graphite] = 45.0, 5e-4, 12e9
    p.alpha1[graphite], p.beta2[graphite], p.d31[1 - graphite] = 1e-6, 0.5, -200e-12
    p.temperature[rest], p.temperature[patch], p.moisture[patch] = 10.0, 20.0, 0.02
    p.field[2 * 2 + of_patch + 1] = -1e5  # of case 1, behind the four fields of case 0
    soft = plate.Material(
        181e9, 12e9, 0.28, 7.17e9, 1600.0, alpha1=1e-6, alpha2=22.5e-6, beta1=0.0, beta2=0.5
    )
    active = plate.Material(61e9, 61e9, 0.35, 22.6e9, 7750.0, 2e-6, 3e-6, d31=-200e-12, d32=-150e-12)
    names = own.mesh.region_names
    other = Problem(
        own.mesh,
        {
            names[rest]: plate.Laminate([plate.Ply(soft, 2e-4, 10.0), plate.Ply(soft, 1e-4, 45.0)]),
            "patch": plate.Laminate([plate.Ply(soft, 5e-4, 10.0), plate.Ply(active, 3e-4, -20.0)], "top"),
        },
        supports=own.supports,
        loads=[plate.Pressure(3.0)],
        cases={
            "wet": [
                plate.Temperature(10.0, region=names[rest]),
                plate.Temperature(20.0, region="patch"),
                plate.Moisture(0.008, region=names[rest]),
                plate.Moisture(0.02, region="patch"),
            ],
            "driven": [
                plate.Temperature(-60.0, region=names[rest]),
                plate.Temperature(-80.0, region="patch"),
                plate.ElectricField([0.0, -1e5], region="patch"),
            ],
        },
    )
    solved = plate.solve(other)
    for case, solution in enumerate(solved.values()):
        found = library.solution(case)
        for column, name in enumerate(("u", "v", "w")):
            expected = solution.values[other.dofs.of(name)]
            # The condition, some 1e7, leaves nine digits to double precision.
            assert np.abs(found[:, column] - expected).max() < 1e-9 * np.abs(expected).max()


@pytest.mark.slow
def test_a_cooled_cross_ply_becomes_the_saddle_of_laminate_theory(load: Load) -> None:
    """[0/90] cooled by 150 K on three points: curvature is the same everywhere, so w is a saddle, and the element,
    which holds constant strains, is exact on any mesh: what is left is round-off by the condition."""
    t, rise, a, b = 125e-6, -150.0, 0.04, 0.03
    m = GRAPHITE
    own = Problem(
        plate.mesh(shapely.box(0.0, 0.0, a, b), 0.006),
        plate.Laminate([plate.Ply(m, t, 0.0), plate.Ply(m, t, 90.0)]),
        supports=[
            plate.Support(shapely.Point(0.0, 0.0), ("u", "v", "w")),
            plate.Support(shapely.Point(a, 0.0), ("v", "w")),
            plate.Support(shapely.Point(0.0, b), ("w",)),
        ],
        loads=[plate.Temperature(rise)],
    )
    rest = 1 - m.nu12**2 * m.E2 / m.E1
    q11, q22, q12 = m.E1 / rest, m.E2 / rest, m.nu12 * m.E2 / rest
    A11, A12, B11, D11, D12 = (q11 + q22) * t, 2 * q12 * t, (q22 - q11) * t**2 / 2, 0.0, 0.0
    D11, D12 = A11 * t**2 / 3, A12 * t**2 / 3
    along, across = (
        (q11 * m.alpha1 + q12 * m.alpha2) * rise,
        (q12 * m.alpha1 + q22 * m.alpha2) * rise,
    )
    N, M = (along + across) * t, (across - along) * t**2 / 2  # N_x = N_y, M_x = -M_y
    # By symmetry strain is the same along x and y, and curvature of opposite sign.
    strain, kappa = np.linalg.solve([[A11 + A12, B11], [B11, D11 - D12]], [N, M])
    library = load("saddle", made=own)
    rhs, work, x = _forces(library, 0), library.array("work"), library.array("row")
    assert library.call("solve", library.matrix(), rhs, work, x) == 0
    out = np.zeros(6)
    for px, py in ((a, b), (0.013, 0.011), (0.02, 0.0), (0.0, 0.015)):
        assert library.at(x, px, py, out) == 0
        w = -0.5 * kappa * px * (px - a) + 0.5 * kappa * py * (py - b)
        assert out[:3] == pytest.approx(
            [strain * px, strain * py, w], rel=1e-8, abs=1e-8 * abs(kappa) * a * b
        )
        slope = (-kappa * (px - a / 2), kappa * (py - b / 2))
        assert out[3:5] == pytest.approx(slope, rel=1e-8, abs=1e-8 * abs(kappa) * a)


@pytest.mark.slow
def test_a_symmetric_bimorph_bends_as_two_strips_that_pull_apart(load: Load) -> None:
    """Free of width: κ of a beam of one material whose halves want to strain by ∓e is 3 e / (2 t), t that of a half.
    Isotropic halves want it along x and y alike, so nothing is held back and κ_x = κ_y."""
    t, E3 = 1.5e-4, 5e5
    same = plate.Material.isotropic(61e9, 0.35, 7750.0, name="ceramic")
    active = plate.Material(61e9, 61e9, 0.35, same.G12, 7750.0, d31=-171e-12, d32=-171e-12, name="ceramic")
    boundary = shapely.Point(0.0, 0.0)
    own = Problem(
        plate.grid(0.03, 0.01, 6, 2),
        plate.Laminate([plate.Ply(active, t), plate.Ply(active, t)]),
        supports=[
            plate.Support(boundary, ("w", "w_x", "w_y")),
        ],
        loads=[plate.ElectricField([-E3, E3])],
    )
    assert not own.dofs.element.stretches
    library = load("bimorph", made=own)
    rhs, work, x, out = _forces(library, 0), library.array("work"), library.array("row"), np.zeros(6)
    assert library.call("solve", library.matrix(), rhs, work, x) == 0
    assert library.at(x, 0.03, 0.01, out) == 0
    kappa = 3.0 * (-171e-12 * E3) / (2.0 * t)  # the upper half shortens: hollow above, κ = -w_xx negative
    assert out[2] == pytest.approx(
        -0.5 * kappa * (0.03**2 + 0.01**2), rel=1e-8
    )  # exact but for the condition


def test_climates_that_are_no_numbers_are_refused_by_status(load: Load) -> None:
    library = load("warm")
    p, rhs = library.parameters, library.array("row")
    for field in ("temperature", "moisture", "field", "alpha1", "beta2", "d31"):
        kept = getattr(p, field)[1]
        getattr(p, field)[1] = np.inf
        assert library.call("load", ctypes.byref(p), 0, rhs) == BAD_PARAMETER, field
        getattr(p, field)[1] = kept
    assert library.call("load", ctypes.byref(p), 0, rhs) == 0


def test_a_laminate_that_couples_is_refused_where_the_element_only_bends(load: Load) -> None:
    """As `Problem.with_laminate` does: without a membrane the plate would come out too stiff."""
    edge = shapely.box(0.0, 0.0, 0.1, 0.1).exterior
    own = Problem(
        plate.grid(0.1, 0.1, 3, 3),
        plate.Laminate([plate.Ply(CFRP, 1e-3, angle) for angle in (30.0, -30.0, -30.0, 30.0)]),
        supports=[plate.SimplySupported(edge)],
        loads=[plate.Pressure(10.0)],
    )
    library = load("turned", made=own)
    p = library.parameters
    library.matrix()
    p.angle[0] = p.angle[3] = 50.0  # symmetric still
    library.matrix()
    p.angle[3] = 50.001
    assert library.call("assemble", ctypes.byref(p), library.array("entry")) == COUPLED
    p.angle[3], p.reference[0] = 50.0, 1e-9
    assert library.call("assemble", ctypes.byref(p), library.array("entry")) == COUPLED
    assert load("coupled").counts["section"] == 18  # this one reads B


def _held(*loads: LoadRecord) -> Problem:
    edge = shapely.LineString([(0.0, 0.0), (0.0, 0.1)])
    mesh = plate.grid(0.1, 0.1, 2, 2)
    laminate = plate.Laminate([plate.Ply(STEEL, 1e-3), plate.Ply(PZT, 1e-3)])
    return Problem(mesh, laminate, supports=[plate.Clamped(edge)], loads=loads)


@pytest.mark.parametrize(
    ("load_record", "kind"),
    [
        (plate.Temperature(lambda x, y: x + y), "Temperature"),
        (plate.Moisture(lambda x, y: x + y), "Moisture"),
        (plate.ElectricField(lambda x, y: x + y), "ElectricField"),
        (plate.ElectricField([1.0, lambda x, y: x + y]), "ElectricField"),
    ],
)
@pytest.mark.quick("load_record0-*", "load_record3-*")
def test_a_climate_that_varies_is_refused_or_left_out_and_told(load_record: LoadRecord, kind: str) -> None:
    own = _held(load_record, plate.Temperature(3.0))
    with pytest.raises(
        ExportError, match=rf"a load {kind} that varies from place to place.*a number.*--lossy"
    ):
        files_of(own, "c")
    files = files_of(own, "c", options=lamc.ExportOptions(lossy=True))
    assert (
        "**Left out**, as exported C has no loads that change from place to place or through the thickness: "
        f"{kind} that varies" in (files["README.md"].decode())
    )
    assert b"  double temperature[plate_climate_count];" in files["plate.h"]
    if kind != "Temperature":
        assert b"double moisture[" not in files["plate.h"]
        assert b"double field[" not in files["plate.h"]


def test_the_refusal_tells_the_place_in_the_file(tmp_path: Path) -> None:
    file = tmp_path / "warm.yaml"
    file.write_text(
        "kind: plate\nname: warm\nunits: mm\nlaminate: {material: steel, thickness: 1}\n"
        "geometry: {rect: [0, 0, 20, 10], grid: [4, 2]}\nsupports:\n  - clamped: left\n"
        "loads:\n  - pressure: 1 kPa\n  - temperature: 2*x\n"
    )
    result = CliRunner().invoke(main, ["export", str(file), "--out", str(tmp_path / "out")])
    assert result.exit_code == 2
    assert f"{file}:10:" in result.stderr.strip().splitlines()[-1]
    assert "a load Temperature that varies" in result.stderr


@pytest.mark.parametrize("name", ["thermal", "bimorph"])
@pytest.mark.quick("bimorph", others="campaign")
def test_examples_that_expand_move_as_lamc_says(load: Load, name: str) -> None:
    """A corner of each, within the digits that the condition leaves."""
    from lamc.examples import plates
    from lamc.readers.plates.problem_make import problem_of

    own = problem_of(plate.load_plate(plates.find(name).path))
    solution = plate.solve(own)
    assert isinstance(solution, plate.Solution)
    library = load(f"an_{name}", made=own)
    rhs, work, x, out = _forces(library, 0), library.array("work"), library.array("row"), np.zeros(6)
    assert library.call("solve", library.matrix(), rhs, work, x) == 0
    px, py = own.mesh.points.max(axis=0)
    assert library.at(x, px, py, out) == 0
    tolerance = 10 * np.finfo(float).eps * system(own).condition
    assert tolerance < 1e-6
    assert out[2] == pytest.approx(float(solution.deflection(px, py)), rel=tolerance)
