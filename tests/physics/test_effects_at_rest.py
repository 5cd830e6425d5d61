"""What every effect does at rest: inertia by energies, derivatives by the model and by differences."""

import numpy as np
import pytest

import lamc
from lamc import Gravity, HingeDamping, HingeStiffness, LinearMotor, Scene
from lamc.run.at_rest import Rest
from tests.support.ctools import needs_cc
from tests.support.every_effect import SAMPLES, mechanism
from tests.support.mechanisms import Array

pytestmark = needs_cc


def mass_matrix(rest: Rest, q: Array) -> Array:
    """M (nu, nu), as the C has it."""
    model, nu = rest.motion.model, rest.nu
    out, still = np.zeros(nu * (nu + 1) // 2 + nu), np.zeros(nu)
    constants, place = model.read(rest.motion.constants), model.read(q)
    if model.handle.system != model.ffi.NULL:
        model.handle.system(constants, rest.t, place, model.read(still), model.write(out))
    else:
        model.handle.inertia(constants, place, model.write(out))
    found = np.zeros((nu, nu))
    found[np.tril_indices(nu)] = out[: nu * (nu + 1) // 2]
    return np.asarray(found + np.tril(found, -1).T)


@pytest.mark.parametrize("name", sorted(SAMPLES))
@pytest.mark.quick("cable", "hinge_stiffness", "blade_element_drag")
def test_inertia_by_energies_is_that_of_the_equations(name: str) -> None:
    """Rotors, and air that goes with a wing, too: what is no kinetic energy falls out."""
    sim = lamc.compile(mechanism(), Scene(effects=(SAMPLES[name],)))
    rest = Rest(sim.model.motion({}), 0.3, sim.mechanism.size)
    q = np.ascontiguousarray(sim.start[: rest.nq] + 0.1)
    expected = mass_matrix(rest, q)
    found = rest.stand(q)
    assert found is not None
    back = np.linalg.inv(found.tangent)
    assert back.T @ found.inertia @ back == pytest.approx(expected, abs=1e-14 * np.abs(expected).max())


@pytest.mark.parametrize("name", sorted(SAMPLES))
@pytest.mark.quick(
    "blade_element_drag",
    "flexible_links",
    "free_base",
    "hinge_damping",
    "joint_limits",
    "nonlinear_stiffness",
)
def test_derivatives_at_rest_are_what_differences_say(name: str) -> None:
    """By the same road that models without derivatives take. Beside drag and friction, whose rates have a scale of
    their own, the widths that it tries leave 1e-9 of the damping."""
    own = (HingeStiffness(), HingeDamping(), Gravity((0.0, 0.0, -9.81)))
    effects = (*(each for each in own if each.name != name), SAMPLES[name])
    sim = lamc.compile(mechanism(), Scene(effects=effects))
    rest = Rest(sim.model.motion({}), 0.3, sim.mechanism.size)
    stand = rest.stand(np.ascontiguousarray(sim.start[: rest.nq]))
    assert stand is not None
    exact = stand.slopes
    assert exact[2] == 0.0
    rest.is_exact = False
    again = rest.stand(stand.q)
    assert again is not None
    by_differences = again.slopes
    for told, found in zip(exact[:2], by_differences[:2], strict=True):
        assert found == pytest.approx(told, abs=1e-8 * max(np.abs(told).max(), 1.0))


def test_a_rotor_behind_gears_slows_a_vibration_down() -> None:
    """I + n² J in place of I."""
    body = lamc.Body("bar", 2.0, (0.3, 0.0, 0.0), np.diag([1e-3, 1e-2, 1e-2]))
    pin = lamc.Joint("pin", "wall", "bar", axis=(0.0, 0.0, 1.0), stiffness=5.0)
    motor = LinearMotor("pin", 0.0, torque_constant=0.1, resistance=1e9, gear_ratio=30.0, rotor_inertia=2e-4)
    both = lamc.Mechanism((lamc.Body("wall", fixed=True), body), (pin,))
    sim = lamc.compile(both, Scene(effects=(HingeStiffness(), motor)))
    (mode,) = sim.modes(damping=False).modes
    assert mode.angular_frequency == pytest.approx(np.sqrt(5.0 / (0.19 + 900.0 * 2e-4)), rel=1e-12)
