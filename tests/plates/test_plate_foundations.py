"""Plates on elastic ground against closed forms of E. Winkler's model."""

import math

import numpy as np
import pytest
from shapely.geometry import LineString, box

from lamc import plate
from lamc.basics.errors import ExportError
from lamc.export import files_of
from lamc.readers.plates.problem_file import plate_of_text
from lamc.readers.plates.problem_make import problem_of
from tests.support.plates import assert_refused

NU = 0.3
UNIT = plate.Material.isotropic(12 * (1 - NU**2), NU, 1.0)  # D = 1 N·m and 1 kg/m² at a thickness of 1 m
ISOTROPIC = plate.Laminate([plate.Ply(UNIT, 1.0)])
SIMPLE = plate.SimplySupported("boundary")
K = 500.0


def square(n: int, *foundations: plate.ElasticFoundation, **more: object) -> plate.Problem:
    mesh = plate.grid(1.0, 1.0, n, n, "criss-cross")
    supports = more.pop("supports", [SIMPLE])
    return plate.Problem(mesh, ISOTROPIC, "dkt", supports, foundations=foundations, **more)  # type: ignore[arg-type]


def test_ground_adds_its_stiffness_over_the_mass_to_every_frequency() -> None:
    """ω² = π⁴ (m² + n²)² D/ρa⁴ + k/ρ: between plates with and without it, k/ρ is exact, but that dkt's own deflection
    within a cell, by which the ground is pressed, is the one that its mass moves by."""
    bare, held = (plate.modes(square(8, *on), 4).omega ** 2 for on in ((), (plate.ElasticFoundation(K),)))
    np.testing.assert_allclose(held - bare, K, rtol=1e-8)  # round-off of differences
    exact = math.sqrt(4.0 * math.pi**4 + K)
    assert math.sqrt(held[0]) == pytest.approx(exact, rel=2e-3)  # of second order in 1/8


def test_square_on_ground_sinks_under_a_wave_of_pressure() -> None:
    """w = q / (D (2π²)² + k) in the middle, for a pressure q sin πx sin πy."""
    wave = plate.Pressure(lambda x, y: np.sin(np.pi * x) * np.sin(np.pi * y))
    found = plate.solve(square(16, plate.ElasticFoundation(K), loads=[wave]))
    assert float(found.deflection(0.5, 0.5)) == pytest.approx(1.0 / (4.0 * math.pi**4 + K), rel=2e-3)
    supports, ground = (reaction.force[2] for reaction in found.reactions)
    assert supports + ground == pytest.approx(
        -4.0 / math.pi**2, rel=1e-6
    )  # what the wave weighs, by quadrature
    assert ground == pytest.approx(-K * 4.0 / math.pi**2 / (4.0 * math.pi**4 + K), rel=5e-3)


def test_square_on_ground_buckles_at_more() -> None:
    """N = π² D (m² + 1)² / m² + k / π² m², the least over m: for k = 2000 that is at m = 2."""
    k = 2000.0
    found = plate.buckling(square(16, plate.ElasticFoundation(k)), 1, forces=(-1.0, 0.0, 0.0))
    exact = min(math.pi**2 * (m * m + 1) ** 2 / m**2 + k / (math.pi * m) ** 2 for m in range(1, 5))
    assert exact == pytest.approx(math.pi**2 * 25 / 4 + k / (4 * math.pi**2))
    assert found.critical == pytest.approx(exact, rel=5e-3)  # of second order in 1/16


def test_free_plate_on_ground_sinks_by_its_weight_alone() -> None:
    """Ground alone holds a plate against rise and turns: w = -g ρ / k everywhere, and no moment."""
    found = plate.solve(square(4, plate.ElasticFoundation(K), supports=[], loads=[plate.SelfWeight()]))
    np.testing.assert_allclose(found.at_nodes("w"), -9.81 / K, rtol=1e-9)
    assert not found.report.free
    np.testing.assert_allclose(found.moments(0.4, 0.3), 0.0, atol=1e-9 * 9.81)
    np.testing.assert_allclose(plate.modes(found.problem, 3).omega, math.sqrt(K), rtol=1e-9)


def test_strip_on_ground_is_a_beam_on_ground() -> None:
    """A long strip pushed at its end: w = 2 P λ / k at the end, λ⁴ = k / 4 D per width, ν = 0 (M. Hetényi, Beams on
    Elastic Foundation, 1946)."""
    metal = plate.Laminate([plate.Ply(plate.Material.isotropic(12.0, 0.0, 1.0), 1.0)])
    k, length = 4.0, 8.0  # λ = 1/m: the far end is e^-8 away
    end = LineString([(0, 0), (0, 0.5)])
    found = plate.solve(
        plate.Problem(
            plate.grid(length, 0.5, 128, 4),
            metal,
            loads=[plate.EdgeLoad(end, 1.0)],
            foundations=[plate.ElasticFoundation(k)],
        )
    )
    assert float(found.deflection(0.0, 0.25)) == pytest.approx(2.0 / k, rel=3e-3)  # second order in 1/16


def test_ground_under_a_part_pushes_there() -> None:
    """Under half of a plate that a rigid support turns about: k ∫ x² = k/24 of a turn for the half, k/3 for all."""
    regions = {"half": box(0.0, 0.0, 0.5, 1.0)}
    mesh = plate.grid(1.0, 1.0, 4, 4, regions=regions)
    hinge = plate.SimplySupported(LineString([(0, 0), (0, 1)]))
    stiff = plate.Laminate([plate.Ply(plate.Material.isotropic(12e9, 0.0, 1.0), 1.0)])
    push = plate.EdgeLoad(LineString([(1, 0), (1, 1)]), 1.0)
    for where, arm in ((box(-1.0, -1.0, 0.5, 2.0), 1.0 / 24.0), (None, 1.0 / 3.0)):
        ground = plate.ElasticFoundation(K, where)
        found = plate.solve(plate.Problem(mesh, stiff, "dkt", [hinge], [push], foundations=[ground]))
        assert float(found.deflection(1.0, 0.5)) == pytest.approx(
            1.0 / (K * arm), rel=1e-5
        )  # the plate bends a little


FILE = """
kind: plate
units: mm
laminate: {material: aluminium, thickness: 1}
geometry: {rect: [0, 0, 100, 60], grid: [10, 6]}
foundation: [{stiffness: 2 kPa/mm}, {stiffness: 1e6, where: {rect: [0, 0, 50, 60]}}]
loads: [{pressure: 10 Pa}]
"""


def test_files_have_foundations() -> None:
    file = plate_of_text(FILE, "p.yaml")
    assert [each.stiffness for each in file.foundations] == [2e6, 1e6]
    assert len(plate.solve(problem_of(file)).reactions) == 2


REFUSED = {
    "nothing": (lambda: plate.ElasticFoundation(0.0), "is 0 N/m³"),
    "negative": (lambda: plate.ElasticFoundation(-1.0), "at least 0"),
    "line": (lambda: plate.ElasticFoundation(1.0, LineString([(0, 0), (1, 1)])), "without an area"),
    "text": (lambda: plate.ElasticFoundation(1.0, "boundary"), "must be a shapely polygon"),  # type: ignore[arg-type]
    "beside": (
        lambda: plate.solve(square(2, plate.ElasticFoundation(1.0, box(5, 5, 6, 6)))),
        "lies beside the plate",
    ),
    "membrane": (
        lambda: plate.Problem(
            plate.grid(1, 1, 2, 2), ISOTROPIC, "cst", foundations=[plate.ElasticFoundation(1.0)]
        ),
        "element 'cst' has none",
    ),
    "file": (
        lambda: plate_of_text(FILE.replace("where: {rect: [0, 0, 50, 60]}", "where: boundary"), "p.yaml"),
        "the boundary is none",
    ),
}


@pytest.mark.parametrize("name", REFUSED)
def test_impossible_ground_is_refused(name: str) -> None:
    assert_refused(*REFUSED[name])


def test_export_refuses_ground_by_name() -> None:
    with pytest.raises(ExportError, match="lies on the ElasticFoundation, which exported C does not have"):
        files_of(square(2, plate.ElasticFoundation(1.0)), "c")
