"""Temperature and moisture that change through the thickness: closed forms, and an integral over the thickness."""

import numpy as np
import pytest
from shapely.geometry import LineString, Point

from lamc import plate
from lamc.basics.errors import ExportError
from lamc.export import files_of
from lamc.plates.laminates.materials import strain_rotation
from lamc.readers.plates.problem_file import plate_of_text
from tests.support.plates import assert_refused

E, NU, H, ALPHA, G = 70e9, 0.3, 1e-3, 23e-6, 2e4
METAL = plate.Material.isotropic(E, NU, 2700, alpha=ALPHA)
ONE = plate.Laminate([plate.Ply(METAL, H)])
D = E * H**3 / 12 / (1 - NU**2)
CFRP = plate.Material(
    E1=140e9, E2=9e9, nu12=0.3, G12=5e9, density=1600, alpha1=-1e-6, alpha2=25e-6, beta1=0.0, beta2=0.4
)
LAMINATES = {
    "one": ONE,
    "cross-ply": plate.Laminate([plate.Ply(CFRP, 0.2e-3, angle) for angle in (0, 90)]),
    "off its middle": plate.Laminate([plate.Ply(CFRP, 0.2e-3, angle) for angle in (10, -60, 35)], "bottom"),
}


@pytest.mark.parametrize("name", LAMINATES)
def test_resultants_are_integrals_over_the_thickness(name: str) -> None:
    """∫ Q (α (T + g z) + β (c + k z)) (1, z) dz by Gauss's rule, which is exact for what is quadratic in a ply."""
    laminate = LAMINATES[name]
    T, g, c, k = 30.0, G, 0.002, 3.0
    found = laminate.expansion(plate.Graded(T, g), plate.Graded(c, k))
    force, moment = np.zeros(3), np.zeros(3)
    for ply, (low, high) in zip(laminate.plies, laminate.heights, strict=True):
        rotation, m = strain_rotation(ply.angle), ply.material
        for place, weight in zip(*np.polynomial.legendre.leggauss(3), strict=True):
            z = 0.5 * (low + high) + 0.5 * place * (high - low)
            free = np.array(
                [
                    m.alpha1 * (T + g * z) + m.beta1 * (c + k * z),
                    m.alpha2 * (T + g * z) + m.beta2 * (c + k * z),
                    0.0,
                ]
            )
            push = 0.5 * weight * (high - low) * (rotation.T @ m.Q @ free)
            force += push
            moment += z * push
    size = np.abs(force).max()
    np.testing.assert_allclose(found.force, force, atol=1e-13 * size)  # round-off of a dozen terms
    np.testing.assert_allclose(found.moment, moment, atol=1e-13 * size * laminate.thickness)


def test_stress_in_plies_that_are_kept_flat_follows_the_temperature() -> None:
    """Held still, a ply has the stress -E α T(z) / (1 - ν) in both directions."""
    (state,) = ONE.ply_states((0, 0, 0), temperature=plate.Graded(10.0, G))
    expected = -E * ALPHA / (1 - NU) * (10.0 + G * state.z)
    np.testing.assert_allclose(state.stress[:, 0], expected, rtol=1e-13)  # round-off
    places = np.zeros((2, 3))
    many = ONE.material_stress(places, places, temperature=plate.Graded(np.array([10.0, 10.0]), G))
    np.testing.assert_allclose(many[1, 0, :, 0], expected, rtol=1e-13)


@pytest.mark.parametrize("element", ["dkt", "specht", "dkt+lst"])
def test_free_plate_curls(element: str) -> None:
    """κ = α g in both directions and no moment: w = -α g (x² + y²) / 2 beside a rigid motion. dkt and its kin have this
    shape exactly."""
    pins = [plate.Support(Point(0, 0), ("w", "w_x", "w_y"))]
    problem = plate.Problem(
        plate.grid(0.1, 0.06, 6, 4), ONE, element, pins, [plate.Temperature(0.0, gradient=G)]
    )
    found = plate.solve(problem)
    assert float(found.deflection(0.1, 0.06)) == pytest.approx(-ALPHA * G * (0.1**2 + 0.06**2) / 2, rel=1e-9)
    np.testing.assert_allclose(
        found.curvature(0.05, 0.03), [ALPHA * G, ALPHA * G, 0.0], atol=1e-9 * ALPHA * G
    )
    np.testing.assert_allclose(found.moments(0.05, 0.03), 0.0, atol=1e-9 * D * ALPHA * G)
    stress = found.ply_states(0.03, 0.02)[0].stress
    np.testing.assert_allclose(stress, 0.0, atol=1e-9 * E * ALPHA * G * H)


def test_clamped_plate_stays_flat_under_a_moment() -> None:
    """M = -D (1 + ν) α g all over; nothing moves. On the warm top the stress is that of a face that is held."""
    problem = plate.Problem(
        plate.grid(0.1, 0.06, 6, 4),
        ONE,
        "dkt",
        [plate.Clamped("boundary")],
        [plate.Temperature(0.0, gradient=G)],
    )
    found = plate.solve(problem)
    moment = -D * (1 + NU) * ALPHA * G
    np.testing.assert_allclose(
        found.moments(0.041, 0.033), [moment, moment, 0.0], rtol=1e-9, atol=1e-9 * -moment
    )
    assert float(np.abs(found.values).max()) < 1e-12
    assert "cst" not in found.problem.dofs.element.name  # about the middle it pulls by round-off only


def test_gradient_that_varies_from_place_to_place() -> None:
    """g = G x / a bends a cantilever strip of no ν: κ_x = α g, so w = -α G x³ / 6 a."""
    metal = plate.Material.isotropic(E, 0.0, 2700, alpha=ALPHA)
    a = 0.1
    problem = plate.Problem(
        plate.grid(a, 0.01, 32, 2),
        plate.Laminate([plate.Ply(metal, H)]),
        supports=[plate.Clamped(LineString([(0, 0), (0, 0.01)])), plate.Support("boundary", ("w_y",))],
        loads=[plate.Temperature(0.0, gradient=lambda x, y: G * x / a)],
    )
    found = plate.solve(problem)
    assert float(found.deflection(a, 0.005)) == pytest.approx(
        -ALPHA * G * a * a / 6, rel=2e-3
    )  # second order in 1/32


def test_moisture_bends_as_temperature_does() -> None:
    def bent(load: object) -> float:
        laminate = plate.Laminate([plate.Ply(plate.Material.isotropic(E, NU, 1.0, alpha=0.4, beta=0.4), H)])
        held = [plate.Support(Point(0, 0), ("w", "w_x", "w_y"))]
        mesh = plate.grid(0.1, 0.06, 3, 2)
        return float(plate.solve(plate.Problem(mesh, laminate, "dkt", held, [load])).deflection(0.1, 0.06))  # type: ignore

    assert bent(plate.Moisture(0.0, gradient=2.0)) == pytest.approx(
        bent(plate.Temperature(0.0, gradient=2.0))
    )


FILE = """
kind: plate
units: mm
laminate: {{material: aluminium, thickness: 1}}
geometry: {{rect: [0, 0, 100, 60], grid: [6, 4]}}
supports: [{{fixed: [w, w_x, w_y], where: {{point: [0, 0]}}}}]
loads: [{{{load}}}]
"""


def test_files_say_gradients() -> None:
    reported = plate_of_text(FILE.format(load="temperature: 10 K, gradient: 20 K/mm"), "p.yaml").cases[""]
    assert reported[0].rise == 10.0  # type: ignore[union-attr]
    assert reported[0].gradient == 2e4  # type: ignore[union-attr]
    (wet,) = plate_of_text(FILE.format(load="moisture: 0, gradient: 0.5*x"), "p.yaml").cases[""]
    assert float(wet.gradient(np.array(2e-3), np.array(0.0))) == 1.0  # type: ignore


@pytest.mark.parametrize(
    ("load", "message"),
    [
        ("pressure: 1, gradient: 2", "gradient belongs to temperature or moisture"),
        ("temperature: 1, gradient: 3 kg", "gradient"),
    ],
)
def test_gradients_in_files_are_checked(load: str, message: str) -> None:
    assert_refused(lambda: plate_of_text(FILE.format(load=load), "p.yaml"), message)


def test_what_cannot_be_had_is_refused_by_name() -> None:
    problem = plate.Problem(
        plate.grid(1, 1, 2, 2),
        ONE,
        "dkt",
        [plate.Clamped("boundary")],
        [plate.Temperature(1.0, gradient=2.0)],
    )
    assert_refused(
        lambda: plate.gradient(plate.solve(problem)), "Temperature that changes through the thickness"
    )
    with pytest.raises(ExportError, match="Temperature that changes through the thickness"):
        files_of(problem, "c")
    assert_refused(
        lambda: plate.Temperature(0.0, gradient=float("nan")), "the gradient of a Temperature is nan"
    )
    assert_refused(
        lambda: ONE.expansion(plate.Graded(0.0, float("inf"))), "gradient of the rise in temperature"
    )
