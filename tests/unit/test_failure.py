"""Failure of plies against worked examples in print, by what the criteria mean, and bad input."""

import dataclasses
import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from shapely.geometry import LineString, box

from lamc import plate
from lamc.basics.errors import DesignError
from lamc.plate import Laminate, Material, Ply
from lamc.plates.laminates import failure
from lamc.plates.laminates.materials import strain_rotation

T300 = plate.material("T300/5208")
# A ratio comes from some products, a root and a division, each rounded once.
ROUND_OFF = 1e-12


def turned(stress: tuple[float, float, float], angle: float) -> np.ndarray:
    """Stress in plate axes as stress in material axes: the strain rotation's transpose takes it the other way."""
    return np.linalg.solve(strain_rotation(angle).T, np.array(stress))


# --- worked examples -------------------------------------------------------------------------------------------------


def test_off_axis_lamina_fails_at_the_published_stress() -> None:
    """A. K. Kaw, Mechanics of Composite Materials, 2nd ed. 2006, examples 2.16 and 2.19: a 60° lamina of graphite and
    epoxy (T300/5208) under σx = 2S, σy = -3S, τxy = 4S fails at S = 16.33 MPa by maximum stress and at 22.39 MPa by
    Tsai-Wu."""
    stress = turned((2.0, -3.0, 4.0), 60.0)
    # Four digits are printed.
    assert failure.max_stress_ratio(T300, stress) == pytest.approx(16.33e6, rel=3e-4)
    assert failure.tsai_wu_ratio(T300, stress) == pytest.approx(22.39e6, rel=3e-4)


def test_cross_ply_laminate_fails_ply_by_ply_as_published() -> None:
    """Kaw, section 5.3: [0/90/0] of 5 mm plies under Nx = 1 N/m has Tsai-Wu strength ratios of 1.339e7 in the plies at
    0° and 7.277e6 in the one at 90°, which so fails first."""
    laminate = Laminate.parse("[0/90/0]", T300, 5e-3)
    pulled = laminate.deformation(force=(1.0, 0.0, 0.0))
    ratios = [f.tsai_wu_ratio for f in plate.ply_failures(laminate, pulled.strain, pulled.curvature)]
    for found, printed in zip(ratios, (1.339e7, 7.277e6, 1.339e7), strict=True):
        assert found == pytest.approx(np.full(2, printed), rel=1e-3 / 2)  # four digits are printed
    first = plate.first_ply_failure(laminate, force=(1.0, 0.0, 0.0))
    assert (first.number, first.ply.angle, first.mode) == (2, 90.0, "tension along 2")
    assert first.force == pytest.approx([7.277e6, 0, 0], rel=3e-4)
    assert str(first).startswith("ply 2 from the bottom (90°, T300/5208) fails first")


# --- what the criteria mean ------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("stress", "mode"),
    [
        ((1500e6, 0, 0), "tension along 1"),
        ((-1500e6, 0, 0), "compression along 1"),
        ((0, 40e6, 0), "tension along 2"),
        ((0, -246e6, 0), "compression along 2"),
        ((0, 0, 68e6), "shear"),
        ((0, 0, -68e6), "shear"),
    ],
)
def test_each_strength_alone_is_failure(stress: tuple[float, ...], mode: str) -> None:
    given_stress = np.array(stress)
    assert failure.tsai_wu_index(T300, given_stress) == pytest.approx(1.0, rel=ROUND_OFF)
    index, which = failure.max_stress_index(T300, given_stress)
    assert (index, failure.MODES[which]) == (pytest.approx(1.0, rel=ROUND_OFF), mode)
    assert failure.tsai_wu_ratio(T300, given_stress / 7) == pytest.approx(7.0, rel=ROUND_OFF)
    assert failure.max_stress_ratio(T300, given_stress / 7) == pytest.approx(7.0, rel=ROUND_OFF)


def test_equal_strengths_without_interaction_make_an_ellipse() -> None:
    """X, Y and S alike in tension and compression and F12 = 0: (σ1/X)² + (σ2/Y)² + (τ/S)² = 1."""
    alike = dataclasses.replace(T300, Xt=3.0, Xc=3.0, Yt=4.0, Yc=4.0, S=12.0)
    assert failure.tsai_wu_index(alike, np.array([1.0, 2.0, 3.0]), interaction=0.0) == pytest.approx(
        1 / 9 + 1 / 4 + 1 / 16, rel=ROUND_OFF
    )


def test_isotropic_strength_with_half_interaction_is_von_mises() -> None:
    """Equal strengths, S = X / √3 and F12 = -F11/2: σ1² - σ1 σ2 + σ2² + 3 τ² = X²."""
    X = 250e6
    metal = dataclasses.replace(plate.material("steel"), Xt=X, Xc=X, Yt=X, Yc=X, S=X / math.sqrt(3))
    a, b, t = 120e6, -70e6, 55e6
    mises = math.sqrt(a * a - a * b + b * b + 3 * t * t)
    assert failure.tsai_wu_ratio(metal, np.array([a, b, t])) == pytest.approx(X / mises, rel=ROUND_OFF)


stresses = st.tuples(*[st.floats(-1e9, 1e9)] * 3).filter(lambda s: max(map(abs, s)) > 1e-3)
strengths = st.fixed_dictionaries({symbol: st.floats(1e6, 3e9) for symbol in ("Xt", "Xc", "Yt", "Yc", "S")})
interactions = st.floats(-0.95, 0.95)


@given(strengths, stresses, interactions)
def test_ratio_leads_to_failure_exactly(
    given_strengths: dict[str, float], stress: tuple[float, ...], interaction: float
) -> None:
    """R solves a R² + b R = 1: stress times R has index 1, by both criteria."""
    material = dataclasses.replace(T300, **given_strengths)
    s = np.array(stress)
    R = failure.tsai_wu_ratio(material, s, interaction=interaction)
    assert np.isfinite(R)
    assert R > 0
    # The terms of the index are up to (ratio of strengths)/(1 - f²) times their sum: 3000 and 10, ulps of that.
    assert failure.tsai_wu_index(material, R * s, interaction) == pytest.approx(1.0, abs=1e-10)
    index, _ = failure.max_stress_index(material, failure.max_stress_ratio(material, s) * s)
    assert index == pytest.approx(1.0, rel=ROUND_OFF)


@given(strengths, stresses, st.floats(0.01, 100))
def test_ratio_falls_as_the_load_grows(
    given_strengths: dict[str, float], stress: tuple[float, ...], factor: float
) -> None:
    material = dataclasses.replace(T300, **given_strengths)
    s = np.array(stress)
    for ratio in (failure.tsai_wu_ratio, failure.max_stress_ratio):
        assert ratio(material, factor * s) * factor == pytest.approx(float(ratio(material, s)), rel=1e-10)


@given(strengths, stresses, st.floats(0.0, 0.99))
def test_residual_stress_takes_its_part_of_the_way(
    given_strengths: dict[str, float], stress: tuple[float, ...], part: float
) -> None:
    """Where the residual stress is along the load and has gone `part` of the way, the rest is left: R (1 - part)."""
    material = dataclasses.replace(T300, **given_strengths)
    s = np.array(stress)
    for ratio in (failure.tsai_wu_ratio, failure.max_stress_ratio):
        R = float(ratio(material, s))
        assert ratio(material, s, part * R * s) == pytest.approx((1 - part) * R, rel=1e-8)
        assert ratio(material, s, 1.01 * R * s) == 0.0


@given(stresses)
def test_sign_of_shear_does_not_matter(stress: tuple[float, ...]) -> None:
    s = np.array(stress)
    other = s * [1, 1, -1]
    assert failure.tsai_wu_ratio(T300, s) == failure.tsai_wu_ratio(T300, other)
    assert failure.max_stress_ratio(T300, s) == failure.max_stress_ratio(T300, other)


@given(st.floats(-180, 180), stresses)
def test_failure_of_a_turned_laminate_under_turned_load_is_the_same(
    angle: float, force: tuple[float, ...]
) -> None:
    """Plies and load turned together; forces turn as stresses do."""
    there = Laminate([Ply(T300, 1e-4, a) for a in (10, -40, 75)])
    here = Laminate([Ply(T300, 1e-4, a + angle) for a in (10, -40, 75)])
    one = plate.first_ply_failure(there, force=force)
    other = plate.first_ply_failure(here, force=turned(force, -angle))  # type: ignore[arg-type]
    # The condition of the laminate, E1/E2 or so times a few digits of the turns.
    assert other.ratio == pytest.approx(one.ratio, rel=1e-9)


def test_bent_laminate_fails_at_its_faces() -> None:
    """One ply along x, bent: tension where the hollow side is not, 6 M/h² = Xt."""
    h = 2e-3
    metal = dataclasses.replace(plate.material("steel"), Xt=300e6, Xc=500e6, Yt=300e6, Yc=500e6, S=200e6)
    laminate = Laminate([Ply(metal, h)])
    for sign, face in ((1.0, "upper"), (-1.0, "lower")):
        first = plate.first_ply_failure(laminate, moment=(sign, 0, 0), criterion="max-stress")
        assert (first.face, first.mode) == (face, "tension along 1")
        assert abs(first.moment[0]) == pytest.approx(300e6 * h * h / 6, rel=1e-10)


def test_cooling_uses_up_part_of_the_transverse_strength() -> None:
    """A cross-ply cured hot: its plies shrink across the fibres and are in tension there, so the first fails sooner."""
    laminate = Laminate.parse("[0/90]s", T300, 125e-6)
    cold = plate.first_ply_failure(laminate, force=(1e5, 0, 0), temperature=-100)
    assert cold.ratio < plate.first_ply_failure(laminate, force=(1e5, 0, 0)).ratio
    # The load found brings the ply, with the stress of cooling, to an index of 1: by another way through the code.
    bent = laminate.deformation(force=cold.force, temperature=-100)
    found = plate.ply_failures(laminate, bent.strain, bent.curvature, temperature=-100)
    assert max(float(f.tsai_wu.max()) for f in found) == pytest.approx(1.0, rel=1e-9)


def test_expansion_alone_can_be_too_much() -> None:
    laminate = Laminate.parse("[0/90]s", T300, 125e-6)
    first = plate.first_ply_failure(laminate, force=(1e5, 0, 0), temperature=-1000)
    assert first.ratio == 0.0
    assert "by expansion alone" in str(first)


def test_no_load_makes_no_failure() -> None:
    first = plate.first_ply_failure(Laminate.parse("[0/90]s", T300, 125e-6))
    assert first.ratio == math.inf
    assert "no ply fails" in str(first)


def test_many_places_at_once_are_each_as_alone() -> None:
    laminate = Laminate.parse("[30/-60]", T300, 1e-4)
    random = np.random.default_rng(1)
    strain, bend = 1e-3 * random.normal(size=(4, 5, 3)), random.normal(size=(4, 5, 3))
    together = plate.ply_failures(laminate, strain, bend)
    alone = plate.ply_failures(laminate, strain[2, 3], bend[2, 3])
    for many, one in zip(together, alone, strict=True):
        np.testing.assert_allclose(many.tsai_wu_ratio[2, 3], one.tsai_wu_ratio, rtol=1e-12)
        np.testing.assert_array_equal(many.mode[2, 3], one.mode)
        assert many.stress.shape == (4, 5, 2, 3)


# --- plates ----------------------------------------------------------------------------------------------------------

LENGTH, WIDTH, THICKNESS = 50e-3, 20e-3, 1e-3
# No Poisson ratio: a strip is a beam.
BRITTLE = dataclasses.replace(
    Material.isotropic(E=50e9, nu=0.0, density=2000), Xt=40e6, Xc=200e6, Yt=40e6, Yc=200e6, S=60e6
)


def cantilever(
    laminate: Laminate | dict[str, Laminate],
    load: float,
    regions: dict[str, Any] | None = None,
    along: int = 20,
) -> plate.Solution:
    """Clamped at x = 0 with a force at its end, N, up."""
    outline = box(0, 0, LENGTH, WIDTH)
    cells = (
        plate.mesh(outline, 4e-3, regions=regions)
        if regions
        else plate.grid(LENGTH, WIDTH, along, 2 * along // 5)
    )
    end = LineString([(LENGTH, 0), (LENGTH, WIDTH)])
    root = LineString([(0, 0), (0, WIDTH)])
    problem = plate.Problem(
        cells, laminate, supports=[plate.Clamped(root)], loads=[plate.EdgeLoad(end, load / WIDTH)]
    )
    solution = plate.solve(problem)
    assert isinstance(solution, plate.Solution)
    return solution


@pytest.mark.parametrize("criterion", ["tsai-wu", "max-stress"])
@pytest.mark.parametrize(("load", "face"), [(1.0, "lower"), (-1.0, "upper")])
def test_cantilever_fails_at_its_root_in_tension(criterion: str, load: float, face: str) -> None:
    """6 P L / (b h²) = Xt, on the face that the load stretches; uniaxial, so both criteria say the same."""
    laminate = Laminate([Ply(BRITTLE, THICKNESS)])
    first = plate.first_failure(cantilever(laminate, load), criterion)
    expected = 40e6 * WIDTH * THICKNESS**2 / (6 * LENGTH)
    # Moments that grow linearly are beyond the elements' patch test, and errors of nodes at a clamped edge do not
    # cancel: the order is 1.5, with 0.07 in front where the unit is the length over the cells.
    assert first.ratio == pytest.approx(expected, rel=0.1 / 20**1.5)
    finer = plate.first_failure(cantilever(laminate, load, along=40), criterion)
    assert finer.ratio == pytest.approx(expected, rel=0.1 / 40**1.5)
    assert (first.face, first.mode, first.number) == (face, "tension along 1", 1)
    assert first.at[0] == pytest.approx(0.0, abs=1e-12)
    assert first.unjudged == ()
    assert "ply 1 from the bottom" in str(first)


def test_weakest_ply_of_a_laminated_cantilever_is_named() -> None:
    """[90/0]s: the outer plies are weak along x. Which fails first the laminate says by itself, under the moment at the
    root, P L / b."""
    laminate = Laminate.parse("[90/0]s", T300, THICKNESS / 4)
    first = plate.first_failure(cantilever(laminate, 1.0))
    alone = plate.first_ply_failure(laminate, moment=(-LENGTH / WIDTH, 0, 0))
    assert (first.number, first.face, first.mode) == (alone.number, alone.face, alone.mode)
    assert (first.number, first.face) == (1, "lower")
    assert first.ratio == pytest.approx(alone.ratio, rel=0.1)  # what the clamped edge adds


def test_regions_of_unknown_strength_are_left_out_and_told() -> None:
    parts = {"root": box(0, 0, LENGTH / 2, WIDTH), "end": box(LENGTH / 2, 0, LENGTH, WIDTH)}
    materials = {"root": plate.material("steel"), "end": BRITTLE}
    laminates = {name: Laminate([Ply(material, THICKNESS)]) for name, material in materials.items()}
    first = plate.first_failure(cantilever(laminates, 1.0, regions=parts))
    assert (first.region, first.unjudged) == ("end", ("root",))
    # Half the length, half the moment; the change of ν at the border disturbs it over a thickness of plate or so.
    assert first.ratio == pytest.approx(40e6 * WIDTH * THICKNESS**2 / (6 * LENGTH / 2), rel=0.15)
    assert first.at[0] == pytest.approx(LENGTH / 2, rel=1e-6)
    assert "of region 'end'" in str(first)


def test_plate_of_unknown_strength_is_refused() -> None:
    solution = cantilever(Laminate([Ply(plate.material("steel"), THICKNESS)]), 1.0)
    with pytest.raises(DesignError, match="'steel' lacks Xt, Xc, Yt, Yc, S"):
        plate.first_failure(solution)
    with pytest.raises(DesignError, match="'hashin'; it must be one of"):
        plate.first_failure(solution, "hashin")


# --- refusals --------------------------------------------------------------------------------------------------------

WEAK = Material(40e9, 10e9, 0.3, 4e9, 1.0, Xt=1e9, name="half known")
BAD: dict[str, tuple[Any, str]] = {
    "unknown strengths": (
        lambda: plate.first_ply_failure(Laminate([Ply(T300, 1e-4), Ply(WEAK, 1e-4)])),
        "'half known' lacks Xc, Yt, Yc, S: give them",
    ),
    "unnamed": (
        lambda: plate.ply_failures(
            Laminate([Ply(dataclasses.replace(WEAK, name=""), 1e-4)]), (0, 0, 0), (0, 0, 0)
        ),
        "the material of ply 1 lacks",
    ),
    "material": (lambda: failure.tsai_wu_index(WEAK, np.zeros(3)), "'half known'; not all are given"),
    "interaction": (
        lambda: failure.tsai_wu_terms(T300, -1.0),
        "the interaction of Tsai-Wu is -1; it must be between -1 and 1",
    ),
    "criterion": (
        lambda: plate.first_ply_failure(Laminate([Ply(T300, 1e-4)]), criterion="hashin"),
        "'hashin'; it must be one of tsai-wu, max-stress",
    ),
    "force": (
        lambda: plate.first_ply_failure(Laminate([Ply(T300, 1e-4)]), force=(1, 2)),
        "the force per width",
    ),
    "strength": (lambda: dataclasses.replace(T300, Yc=-246e6), "Yc of material 'T300/5208' is -2.46e.08 Pa"),
    "strength type": (lambda: dataclasses.replace(T300, S="high"), "S of material 'T300/5208' is 'high'"),
}


@pytest.mark.parametrize("name", BAD)
def test_what_cannot_be_judged_is_refused(name: str) -> None:
    make, message = BAD[name]
    with pytest.raises(DesignError, match=message) as caught:
        make()
    assert "\n" not in str(caught.value)
