"""Many effects in one scene: what they come to together, against a beam that floats and among methods."""

import numpy as np
import pytest
from shapely.geometry import box

import lamc
from lamc import Body, Joint, Mechanism, Slab, plate

THICK, DENSITY, MODULUS = 1e-3, 2700.0, 70e9  # m, kg/m³, Pa
REACH, SPECK, WIDE = 0.1, 1e-4, 0.01  # m: half the beam, half of what floats, the width


def slab(
    name: str, x: tuple[float, float], y: tuple[float, float], density: float, fixed: bool = False
) -> Body:
    """A plate from z = 0 to THICK."""
    a, b = x[1] - x[0], y[1] - y[0]
    mass = density * a * b * THICK
    inertia = mass / 12.0 * np.diag([b * b + THICK**2, a * a + THICK**2, a * a + b * b])
    centre = (0.5 * (x[0] + x[1]), 0.5 * (y[0] + y[1]), 0.5 * THICK)
    outline = (Slab(box(x[0], y[0], x[1], y[1]), 0.0, THICK),)
    return Body(name, mass, centre, inertia, fixed=fixed, outline=outline)


def test_two_halves_clamped_to_a_speck_that_floats_are_a_free_beam() -> None:
    """FlexibleLinks and FreeBase: the roots 4.7300 and 7.8532 of cos x cosh x = 1 (Blevins 1979, table 8-1)."""
    y = (-0.5 * WIDE, 0.5 * WIDE)
    bodies = (
        slab("speck", (-SPECK, SPECK), y, DENSITY, fixed=True),
        slab("right", (SPECK, REACH), y, DENSITY),
        slab("left", (-REACH, -SPECK), y, DENSITY),
    )
    joints = [
        Joint(f"to {end}", "speck", end, (at, 0.0, 0.5 * THICK), (0.0, 1.0, 0.0), stiffness=1e5)
        for end, at in (("right", SPECK), ("left", -SPECK))
    ]
    laminate = plate.Laminate([plate.Ply(plate.Material.isotropic(MODULUS, 0.0, DENSITY), THICK)])
    bending = lamc.FlexibleLinks(modes=4, damping_ratio=0.0, laminate=laminate)
    scene = lamc.Scene(effects=(lamc.FreeBase(), lamc.HingeStiffness(), bending))
    sim = lamc.compile(Mechanism(bodies, tuple(joints)), scene)
    nq, nu = len(sim.coordinates), len(sim.rates)
    by_q, _ = sim.jacobian(sim.start[:nq], sim.start[nq:])
    rotations = np.zeros((nq, nu))  # small motions: q̇ = u but for the quaternion, whose vector grows by ω / 2
    rotations[: nu - 3, : nu - 3] = np.eye(nu - 3)
    rotations[-3:, -3:] = 0.5 * np.eye(3)
    squares = np.sort(-np.linalg.eigvals(by_q @ rotations).real)
    frequencies = np.sqrt(squares[squares > 100.0])[:2]
    unit = np.sqrt(MODULUS * THICK**2 / (12.0 * DENSITY)) / (2.0 * REACH) ** 2
    # the speck, a thousandth of the beam, does not bend: that and four modes of each half come to 1.2e-3
    assert frequencies == pytest.approx(np.array([4.7300, 7.8532]) ** 2 * unit, rel=2e-3)


@pytest.mark.slow
def test_a_robot_that_flaps_on_the_ground_moves_alike_by_all_methods_and_keeps_its_energy_balance() -> None:
    """Free base, ground, motors, nonlinear hinges, stops, air, which is touched and left again and again."""
    bodies = (
        slab("hull", (-0.02, 0.02), (-0.03, 0.03), 300.0, fixed=True),
        slab("left", (0.02, 0.06), (-0.02, 0.02), 300.0),
        slab("right", (-0.06, -0.02), (-0.02, 0.02), 300.0),
    )
    given = {"damping": 1e-6, "limits": (-1.2, 1.2)}
    joints = (
        Joint("hl", "hull", "left", (0.02, 0.0, 0.0), (0.0, 1.0, 0.0), **given),
        Joint("hr", "hull", "right", (-0.02, 0.0, 0.0), (0.0, -1.0, 0.0), **given),
    )
    line = {"stall_torque": 2e-4, "no_load_speed": 60.0, "nominal_voltage": 3.0}
    effects = (
        lamc.Gravity(),
        lamc.HingeDamping(),
        lamc.FreeBase(position=(0.0, 0.0, 0.05), rotation=(0.2, 0.3, 0.1), spin=(0.0, 1.0, 2.0)),
        lamc.LinearMotor("hl", "3*sin(60*t)", **line),
        lamc.LinearMotor("hr", "2*sin(60*t + 0.3)", **line),
        lamc.NonlinearStiffness({"hl": [5e-4, 0.0, 2e-4], "hr": "5e-4*sinh(angle)"}),
        lamc.GroundContact(0.6),
        lamc.JointLimits(restitution=0.5),
        *(
            lamc.BladeElementDrag(wing, 1.2, 4, leading=(0.0, 1.0), line=((x, 0.0), (3 * x, 0.0)))
            for wing, x in (("left", 0.02), ("right", -0.02))
        ),
    )
    sim = lamc.compile(Mechanism(bodies, joints), lamc.Scene(effects=effects, angles={"hl": 0.3}))
    runs = [
        sim.run(0.2, rtol=1e-10, atol=1e-12, integrator=method, energy_balance=True)
        for method in ("rk45", "dop853", "rodas5p", "radau5")
    ]
    for run in runs:
        assert run.success
        energy_balance = run.energy_balance
        assert energy_balance.balance < 1e-8
        assert len(run.events) == len(runs[0].events) > 10
        # at a tolerance of 1e-10, over some ten contacts that each make errors grow a few times
        assert run.q[-1] == pytest.approx(runs[0].q[-1], abs=1e-6)
        for passive in ("ground_contact", "blade_element_drag", "hinge_damping", "impacts"):
            assert energy_balance.supplied[passive].max() <= 1e-8 * energy_balance.scale
        for conservative in ("gravity", "nonlinear_stiffness"):
            assert np.abs(energy_balance.supplied[conservative]).max() < 1e-8 * energy_balance.scale
