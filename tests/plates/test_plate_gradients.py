"""Gradients by ply angles, thicknesses and moduli, against complex steps through other formulas and differences."""

import re
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from shapely.geometry import LineString, box

from lamc import plate
from lamc.codegen.emit_ply import emit_ply
from lamc.plates.laminates.climate import Climate
from lamc.plates.laminates.ply_kernel import ply_function, split
from lamc.plates.laminates.ply_terms import PLY_NUMBERS, TERMS
from lamc.plates.laminates.slopes import VARIABLES, laminate_terms
from lamc.symbolic.listing import listing_of, run
from lamc.symbolic.operations import BATCHED
from lamc.symbolic.program import Space
from tests.support.ctools import STRICT, cc, needs_cc
from tests.support.plates import assert_refused

CFRP = plate.Material(350e9, 7e9, 0.33, 5e9, 1600, 1e-6, 20e-6, 0.1, 0.6, -1e-10, 2e-10)
GLASS = plate.Material(39e9, 8.3e9, 0.26, 4.1e9, 1800, 8.6e-6, 22e-6, 0.2, 0.4, -3e-10, -4e-10)
PLIES = [plate.Ply(CFRP, 50e-6, 33.0), plate.Ply(GLASS, 70e-6, -20.0, gap=1e-5), plate.Ply(CFRP, 30e-6, 90.0)]
CLIMATE = Climate(temperature=40.0, moisture=1e-3, fields=np.array([1e5, 0.0, -2e5]))
UPPER = np.triu_indices(3)


def terms_of(plies: list[dict[str, Any]], surface: float, height: float) -> np.ndarray:
    """The terms in the order of `TERMS` by Q̄ = Tᵀ Q T and integrals of 1, z and z² between faces; complex numbers pass.

    The reference surface is `surface` thicknesses and `height` m above the middle.
    """
    total = sum(ply["gap"] + ply["thickness"] for ply in plies)
    z = -(0.5 + surface) * total - height
    weights, pushes, mass = [np.zeros((3, 3), complex) for _ in range(3)], np.zeros((2, 3), complex), 0j
    for ply, field in zip(plies, CLIMATE.fields, strict=True):
        z = z + ply["gap"]
        rotation = ply["angle"] * np.pi / 180
        c, s = np.cos(rotation), np.sin(rotation)
        T = np.array([[c * c, s * s, c * s], [s * s, c * c, -c * s], [-2 * c * s, 2 * c * s, c * c - s * s]])
        S = np.array(
            [
                [1 / ply["E1"], -ply["nu12"] / ply["E1"], 0],
                [-ply["nu12"] / ply["E1"], 1 / ply["E2"], 0],
                [0, 0, 1 / ply["G12"]],
            ]
        )
        along = T.T @ np.linalg.inv(S)
        top = z + ply["thickness"]
        for power in range(3):
            weights[power] += (top ** (power + 1) - z ** (power + 1)) / (power + 1) * along @ T
        free = [
            ply["alpha1"] * CLIMATE.temperature + ply["beta1"] * CLIMATE.moisture + ply["d31"] * field,
            ply["alpha2"] * CLIMATE.temperature + ply["beta2"] * CLIMATE.moisture + ply["d32"] * field,
            0,
        ]
        for power in range(2):
            pushes[power] += (top ** (power + 1) - z ** (power + 1)) / (power + 1) * along @ np.array(free)
        mass += ply["density"] * ply["thickness"]
        z = top
    return np.concatenate([*(w[UPPER] for w in weights), pushes.ravel(), [mass]])


def numbers(ply: plate.Ply) -> dict[str, Any]:
    names = (*VARIABLES, "gap")
    return {n: complex(getattr(ply, n) if hasattr(ply, n) else getattr(ply.material, n)) for n in names}


def interpreted(plies: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The function that is compiled, in Python."""
    listing = listing_of(ply_function(), BATCHED)
    memory = run(listing, {Space.PLY: list(plies.T)})
    return split(np.array([np.broadcast_to(sign * memory[at], len(plies)) for sign, at in listing.outputs]).T)


SURFACES = {"middle": (0.0, 0.0), "top": (0.5, 0.0), "bottom": (-0.5, 0.0), 3e-5: (0.0, 3e-5)}


@pytest.mark.parametrize("reference", SURFACES)
@pytest.mark.parametrize("backend", ["interpreted", "c"])
def test_terms_of_a_laminate_change_as_complex_steps_say(reference: str | float, backend: str) -> None:
    """Complex steps have no round-off of differences, so that both agree to round-off of their terms: some tens of
    products each, the largest of which cancel to a few percent in turned stiffness."""
    laminate = plate.Laminate(PLIES, reference)
    found = laminate_terms(laminate, CLIMATE, interpreted if backend == "interpreted" else None)
    assert len(TERMS) == len(found.values)
    plain = [numbers(ply) for ply in PLIES]
    expected = terms_of(plain, *SURFACES[reference]).real
    # Of each kind (N/m, N, N·m, …) the largest sets the scale of the round-off, with B by a thickness times A.
    h = laminate.thickness
    stiff = np.abs(expected[:6]).max() * np.repeat([1.0, h, h * h], 6)
    push = np.abs(expected[18:21]).max() * np.repeat([1.0, h], 3)
    scale = np.concatenate([stiff, push, [expected[-1]]])
    np.testing.assert_allclose(found.values / scale, expected / scale, rtol=0.0, atol=1e-13)
    for variable in VARIABLES:
        for k in range(len(PLIES)):
            size = abs(plain[k][variable])
            stepped = [dict(ply) for ply in plain]
            stepped[k][variable] += 1e-40j * size
            slope = terms_of(stepped, *SURFACES[reference]).imag / (1e-40 * size)
            np.testing.assert_allclose(
                found.slopes[variable][k] * size / scale, slope * size / scale, rtol=0.0, atol=1e-12
            )


@needs_cc
def test_c_of_a_ply_is_strict_and_the_same_every_time(tmp_path: Path) -> None:
    tree = emit_ply(ply_function(), PLY_NUMBERS, TERMS)
    again = emit_ply(ply_function.__wrapped__(), PLY_NUMBERS, TERMS)
    assert tree.files == again.files
    for name, text in tree.files.items():
        (tmp_path / name).write_text(text, encoding="utf-8")
    cc(tmp_path, *STRICT, "-c", "laminate.c")


# --- gradients of answers, against differences of answers ------------------------------------------------------------

LEFT = LineString([(0, 0), (0, 1)])
CLAMPED = plate.Clamped(LEFT)


def varied(laminate: plate.Laminate, ply: int, variable: str, factor: float) -> plate.Laminate:
    """`laminate` with one variable of one ply times `factor`."""
    plies = list(laminate.plies)
    one = plies[ply]
    if hasattr(one, variable):
        plies[ply] = replace(one, **{variable: getattr(one, variable) * factor})
    else:
        material = replace(one.material, **{variable: getattr(one.material, variable) * factor})
        plies[ply] = replace(one, material=material)
    return plate.Laminate(plies, laminate.reference)


def difference(
    number: Callable[[plate.Problem], float], problem: plate.Problem, name: str, step: float
) -> tuple[float, float]:
    """Derivative by the variable `name` times its value, by a central difference of fourth order, and the number."""
    region, ply, variable = re.fullmatch(r"(?:(.+)\.)?ply\[(\d+)\]\.(\w+)", name).groups()  # type: ignore[union-attr]

    def at(factor: float) -> float:
        if isinstance(problem.laminate, plate.Laminate):
            other: Any = varied(problem.laminate, int(ply), variable, factor)
        else:
            key = region or ""
            other = {**problem.laminate, key: varied(problem.laminate[key], int(ply), variable, factor)}
        return number(replace(problem, laminate=other))

    near, far = at(1 + step) - at(1 - step), at(1 + 2 * step) - at(1 - 2 * step)
    return (8.0 * near - far) / (12.0 * step), number(problem)


def value_of(laminate: plate.Laminate, ply: int, variable: str) -> float:
    one = laminate.plies[ply]
    return float(getattr(one, variable) if hasattr(one, variable) else getattr(one.material, variable))


def check(
    found: dict[str, float],
    number: Callable[[plate.Problem], float],
    problem: plate.Problem,
    tolerance: float,
) -> None:
    """Every derivative against a difference; 1e-3 steps of fourth order are wrong by 1e-12 or so of the number, and the
    answers' round-off over the step by some 1e-11: `tolerance` is of the number itself."""
    for name, slope in found.items():
        region, ply, variable = re.fullmatch(r"(?:(.+)\.)?ply\[(\d+)\]\.(\w+)", name).groups()  # type: ignore[union-attr]
        given = problem.laminate
        own = given if isinstance(given, plate.Laminate) else given[region or ""]
        expected, size = difference(number, problem, name, 1e-3)
        assert slope * value_of(own, int(ply), variable) == pytest.approx(
            expected, abs=tolerance * abs(size)
        ), name


def cantilever(laminate: Any, loads: Sequence[Any], **more: Any) -> plate.Problem:
    return plate.Problem(plate.grid(2.0, 1.0, 4, 2, **more), laminate, supports=[CLAMPED], loads=loads)


THICK = plate.Laminate([replace(ply, thickness=1e3 * ply.thickness, gap=0.0) for ply in PLIES])
LOADS = [plate.Pressure(100.0), plate.PointLoad((2.0, 0.2), (30.0, -50.0, 20.0))]
SOME = ["ply[0].angle", "ply[1].thickness", "ply[2].E1", "ply[0].nu12", "ply[1].density", "ply[2].G12"]
STIFFNESS = ["*.angle", "*.thickness", "*.E1", "*.E2", "*.nu12", "*.G12"]


@pytest.mark.slow
def test_compliance_of_a_coupled_plate_changes_as_differences_say() -> None:
    problem = cantilever(THICK, LOADS)
    found = plate.gradient(plate.solve(problem), "compliance", STIFFNESS)
    assert len(found) == 3 * len(STIFFNESS)
    check(
        {name: found[name] for name in SOME if name in found},
        lambda p: plate.solve(p).compliance,
        problem,
        1e-8,
    )


@pytest.mark.slow
def test_deflection_at_a_point_changes_as_differences_say() -> None:
    at = (1.3, 0.7)
    problem = cantilever(THICK, LOADS)
    found = plate.gradient(plate.solve(problem), ("deflection", at), SOME)
    check(found, lambda p: float(plate.solve(p).deflection(*at)), problem, 1e-8)


@pytest.mark.slow
def test_weight_and_heat_change_with_the_plies_too() -> None:
    """Thicker plies weigh more and expand more strongly; a field works on what is piezoelectric."""
    loads = [plate.SelfWeight((0, 0, -9.81)), plate.Temperature(20.0), plate.ElectricField((1e4, 0.0, 2e4))]
    problem = cantilever(THICK, loads)
    solution = plate.solve(problem)
    found = plate.gradient(solution, ("deflection", (2.0, 0.5)))
    assert list(found) == [f"ply[{k}].{variable}" for k in range(3) for variable in VARIABLES]
    wanted = {n: found[n] for n in [*SOME, "ply[0].alpha1", "ply[1].alpha2", "ply[2].d31", "ply[0].d32"]}
    check(wanted, lambda p: float(plate.solve(p).deflection(2.0, 0.5)), problem, 1e-8)
    assert found["ply[0].beta1"] == 0.0
    check(
        plate.gradient(solution, "compliance", ["*.thickness", "ply[1].alpha2"]),
        lambda p: plate.solve(p).compliance,
        problem,
        1e-8,
    )


@pytest.mark.slow
def test_regions_have_their_own_gradients() -> None:
    regions = {"tip": box(1, 0, 2, 1)}
    thin = plate.Laminate([plate.Ply(CFRP, 0.05, 20.0)])
    problem = cantilever({"": THICK, "tip": thin}, [plate.Pressure(100.0)], regions=regions)
    found = plate.gradient(plate.solve(problem), "compliance", ["*.thickness"])
    assert list(found) == ["ply[0].thickness", "ply[1].thickness", "ply[2].thickness", "tip.ply[0].thickness"]
    check(found, lambda p: plate.solve(p).compliance, problem, 1e-8)


def test_one_laminate_for_all_regions_sums_over_them() -> None:
    one = cantilever(THICK, [plate.Pressure(100.0)])
    two = cantilever(THICK, [plate.Pressure(100.0)], regions={"tip": box(1, 0, 2, 1)})
    first, second = (plate.gradient(plate.solve(p), "compliance", ["ply[1].angle"]) for p in (one, two))
    assert second["ply[1].angle"] == pytest.approx(first["ply[1].angle"], rel=1e-11)  # round-off


@pytest.mark.slow
def test_free_plate_under_balanced_loads_has_gradients() -> None:
    ends = [plate.EdgeMoment(LineString([(x, 0), (x, 1)]), 50.0) for x in (0, 2)]
    problem = replace(cantilever(THICK, ends), supports=())
    found = plate.gradient(plate.solve(problem), "compliance", SOME)
    check(found, lambda p: plate.solve(p).compliance, problem, 1e-8)


@pytest.mark.slow
def test_moved_supports_count_as_loads() -> None:
    """A tip held down at a given depth: the reaction changes with the plies, and so the deflection elsewhere."""
    tip = plate.Support(LineString([(2, 0), (2, 1)]), ("w",), -1e-2)
    problem = replace(cantilever(THICK, [plate.Pressure(100.0)]), supports=[CLAMPED, tip])
    found = plate.gradient(plate.solve(problem), ("deflection", (1.0, 0.5)), ["*.thickness", "*.angle"])
    check(found, lambda p: float(plate.solve(p).deflection(1.0, 0.5)), problem, 1e-8)


@pytest.mark.parametrize("inertia", [True, pytest.param(False, marks=pytest.mark.campaign)])
@pytest.mark.slow
def test_frequency_changes_as_differences_say(inertia: bool) -> None:
    problem = replace(cantilever(THICK, []), mesh=plate.grid(2.0, 1.0, 3, 2))
    modes = plate.modes(problem, 4, in_plane_inertia=inertia)
    for k in (0, 2):
        found = plate.gradient(modes, ("omega", k), SOME)
        check(
            found,
            lambda p, k=k: float(plate.modes(p, 4, in_plane_inertia=inertia).omega[k]),  # type: ignore[misc]
            problem,
            1e-8,
        )


@pytest.mark.slow
def test_buckling_factor_changes_as_differences_say() -> None:
    problem = replace(cantilever(THICK, []), mesh=plate.grid(2.0, 1.0, 3, 2))
    forces = (-1e5, 0.0, 3e4)
    found = plate.gradient(plate.buckling(problem, 2, forces=forces), ("factor", 0), SOME)
    check(found, lambda p: plate.buckling(p, 1, forces=forces).critical, problem, 1e-8)


def test_thickness_of_an_isotropic_plate_acts_by_its_powers() -> None:
    """Compliance as h⁻³, frequency as h, by hand: d log J / d log h is -3 and 1."""
    h = 0.01
    steel = plate.Material.isotropic(210e9, 0.3, 7850)
    problem = cantilever(plate.Laminate([plate.Ply(steel, h)]), [plate.Pressure(100.0)])
    solution, modes = plate.solve(problem), plate.modes(problem, 2)
    by_compliance = plate.gradient(solution, "compliance", ["ply[0].thickness"])["ply[0].thickness"]
    by_omega = plate.gradient(modes, ("omega", 0), ["ply[0].thickness"])["ply[0].thickness"]
    # Round-off of the two solutions that the product is made of.
    assert by_compliance * h / solution.compliance == pytest.approx(-3.0, rel=1e-10)
    assert by_omega * h / modes.omega[0] == pytest.approx(1.0, rel=1e-8)


def solved() -> plate.Solution:
    return plate.solve(cantilever(THICK, LOADS))


BAD_REQUESTS = {
    "number": (lambda: plate.gradient(solved(), "stiffness"), "'stiffness'; it can be of 'compliance' or"),
    "cases": (
        lambda: plate.gradient(plate.solve(replace(solved().problem, cases={"a": []}))),  # type: ignore[arg-type]
        "of cases, take one by name",
    ),
    "point": (lambda: plate.gradient(solved(), ("deflection", (5, 5))), "outside the plate"),
    "no point": (
        lambda: plate.gradient(solved(), ("deflection", "tip")),
        "the point of a gradient of the deflection is 'tip'",
    ),
    "names": (lambda: plate.gradient(solved(), by=5), "variables of a gradient are 5; give a list"),  # type: ignore[arg-type]
    "name": (
        lambda: plate.gradient(solved(), "compliance", ["ply[7].angle"]),
        r"no ply variable is named 'ply\[7\].angle'; there are ply\[0\].angle, ",
    ),
    "mode": (lambda: plate.gradient(plate.modes(solved().problem, 2), ("omega", 2)), "omega 2; there are 2"),
    "of modes": (
        lambda: plate.gradient(plate.modes(solved().problem, 2), "compliance"),
        r"can be of \('omega', k\)",
    ),
    "forces of loads": (
        lambda: plate.gradient(plate.buckling(solved().problem, 1), ("factor", 0)),
        "under forces that loads make, .* give these forces",
    ),
    "rigid": (
        lambda: plate.gradient(plate.modes(replace(solved().problem, supports=()), 7), ("omega", 0)),
        "mode 0 is a rigid motion",
    ),
    "repeated": (
        lambda: plate.gradient(
            plate.modes(
                plate.Problem(
                    plate.grid(1, 1, 4, 4, "criss-cross"),
                    plate.Laminate([plate.Ply(plate.Material.isotropic(1, 0.3, 1), 1)]),
                    supports=[plate.SimplySupported("boundary")],
                ),
                3,
            ),
            ("omega", 1),
        ),
        "omega 1 and 2 are one value",
    ),
}


@pytest.mark.parametrize("name", BAD_REQUESTS)
def test_impossible_request_is_refused(name: str) -> None:
    assert_refused(*BAD_REQUESTS[name])
