"""Free bodies on the ground, six freedoms and more: a dropped plate rests, the energy balance closes, a crawler
walks."""

import math
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import brentq
from shapely.geometry import Point, box

import lamc
from lamc import Body, Gravity, GroundContact, Mechanism, Scene, Slab
from lamc.effects.free_base import FreeBase
from lamc.run.simulator import Simulator
from tests.support.ctools import needs_cc
from tests.support.quick import tries

pytestmark = needs_cc

G = 9.81  # m/s²
LENGTH, WIDTH, THICKNESS, MASS = 0.1, 0.06, 0.004, 0.05  # m, kg
SIZE = math.hypot(LENGTH, WIDTH, THICKNESS)
SLIP = 1e-3 * math.sqrt(G * SIZE)  # m/s


def plate(length: float = LENGTH, width: float = WIDTH, thickness: float = THICKNESS) -> Mechanism:
    """One plate that nothing holds; its lower face is drawn at z = 0."""
    moments = [width**2 + thickness**2, length**2 + thickness**2, length**2 + width**2]
    outline = (Slab(box(-length / 2, -width / 2, length / 2, width / 2), 0.0, thickness),)
    centre = (0.0, 0.0, thickness / 2)
    return Mechanism(
        (Body("plate", MASS, centre, MASS / 12 * np.diag(moments), fixed=True, outline=outline),), ()
    )


def tossed(ground: GroundContact) -> Simulator:
    toss = FreeBase(
        (0.0, 0.0, 0.08), rotation=(0.3, 0.5, 0.2), velocity=(0.2, 0.1, 0.0), spin=(2.0, -3.0, 1.0)
    )
    return lamc.compile(plate(), Scene((Gravity(), ground, toss)))


@pytest.mark.parametrize(
    ("integrator", "rtol", "rises"),
    [
        ("auto", 1e-4, 1e-6),
        ("auto", 1e-6, 1e-7),
        ("auto", 1e-9, 1e-9),
        ("rodas5p", 1e-6, 1e-7),
        ("radau5", 1e-4, 1e-6),
    ],
)
@pytest.mark.quick("radau5-*", others="campaign")
def test_a_tossed_plate_rests_for_100_s_without_drift(integrator: str, rtol: float, rises: float) -> None:
    """It rattles on its eight corners for half a second, with a hundred touches, and then lies; rest costs nothing."""
    sim = tossed(GroundContact())
    result = sim.run(100.0, rtol=rtol, atol=1e-2 * rtol, integrator=integrator)
    assert result.success, result.message
    assert len(result.events) > 100
    assert result.events[-1].t < 1.0
    lost = float(result.energy[0] - result.energy[-1])
    assert np.diff(result.energy).max() <= rises * lost  # never rises, but for the tolerance of a step
    assert (result.t > 5.0).sum() < 60  # steps of what is left to fade away, and then of seconds
    rows = sim.run(
        100.0, rtol=rtol, atol=1e-2 * rtol, integrator=integrator, t_eval=np.linspace(10.0, 100.0, 10)
    )
    centre, rotation = rows.pose("plate")
    assert np.ptp(centre, axis=0).max() < 1e-9 * SIZE
    assert np.ptp(rotation, axis=0).max() < 1e-9
    assert np.abs(rotation[-1, 2, 2]) == pytest.approx(1.0, abs=1e-9)  # flat
    # Four corners share the weight, each as deep as a quarter of it goes
    depth = 1e-3 * SIZE * 0.25 ** (2.0 / 3.0)
    assert centre[-1, 2] == pytest.approx(THICKNESS / 2 - depth, abs=1e-8 * SIZE)


@pytest.mark.slow
def test_auto_bears_friction_that_is_a_hundred_times_as_sharp() -> None:
    """The rate at which friction brings to rest goes with 1 / slip_speed; steps of an explicit method follow it, and
    those of auto nearly do not."""
    sim = tossed(GroundContact())
    usual, sharp = (
        sim.run(3.0, rtol=1e-5, parameters={"ground_contact.slip_speed": part * SLIP}) for part in (1.0, 0.01)
    )
    assert usual.success
    assert sharp.success
    assert sharp.stats.steps < 4 * usual.stats.steps
    explicit = sim.run(
        3.0,
        rtol=1e-5,
        integrator="dop853",
        max_steps=10 * sharp.stats.steps,
        parameters={"ground_contact.slip_speed": 0.01 * SLIP},
    )
    assert not explicit.success


@pytest.mark.slow
def test_the_energy_balance_of_a_fall_balance() -> None:
    """What gravity gives, the ground takes, but for what it still stores."""
    result = tossed(GroundContact()).run(3.0, rtol=1e-10, atol=1e-12, energy_balance=True)
    taken = float(result.work["ground_contact"][-1] + result.energies["ground_contact"][-1])
    lost = float(result.energy[-1] - result.energy[0])
    assert taken == pytest.approx(lost, rel=1e-8)
    assert lost < 0.0


def test_where_it_comes_to_rest_does_not_depend_on_the_method() -> None:
    found = [
        tossed(GroundContact())
        .run(3.0, rtol=rtol, atol=1e-2 * rtol, integrator=integrator)
        .pose("plate")[0][-1]
        for integrator, rtol in (("dop853", 1e-9), ("radau5", 1e-7), ("auto", 1e-6))
    ]
    # 156 touches each carry on the error of the one before
    assert found[1] == pytest.approx(found[0], abs=1e-5 * SIZE)
    assert found[2] == pytest.approx(found[0], abs=1e-4 * SIZE)


@pytest.mark.quick("0.7")
@pytest.mark.parametrize("direction", [0.0, 0.7])  # rad, of the slope in the plane
def test_a_free_plate_sticks_and_slides_on_a_slope(direction: float) -> None:
    """The plane slants by 30° towards any side, and the plate lies on it; tan 30° = 0.577."""
    slope = math.radians(30.0)
    across = np.array([-math.sin(direction), math.cos(direction), 0.0])
    normal = np.array(
        [math.sin(slope) * math.cos(direction), math.sin(slope) * math.sin(direction), math.cos(slope)]
    )
    down = np.cross(across, normal)
    start = FreeBase(position=tuple(0.5 * THICKNESS * normal), rotation=tuple(slope * across))
    ground = GroundContact(normal=tuple(normal))
    sim = lamc.compile(plate(), Scene((Gravity(), ground, start)))
    times = np.linspace(0.0, 2.0, 201)
    speeds = {}
    for friction in (0.3, 0.7):
        result = sim.run(2.0, rtol=1e-8, t_eval=times, parameters={"ground_contact.friction": friction})
        assert result.success
        speeds[friction] = np.gradient(result.pose("plate")[0] @ down, times)
    expected = G * (math.sin(slope) - 0.3 * math.cos(slope))
    assert (speeds[0.3][-2] - speeds[0.3][50]) / (times[-2] - times[50]) == pytest.approx(expected, rel=1e-3)
    part = math.tan(slope) / 0.7
    creep = SLIP * part / math.sqrt(1.0 - part**2)
    assert speeds[0.7][-2] == pytest.approx(creep, rel=1e-3)


@settings(max_examples=tries(60), deadline=None)
@given(
    turn=st.tuples(*[st.floats(-3.0, 3.0)] * 3),
    height=st.floats(-0.04, 0.06),
    velocity=st.tuples(*[st.floats(-3.0, 3.0)] * 3),
    spin=st.tuples(*[st.floats(-30.0, 30.0)] * 3),
)
def test_the_ground_takes_energy_at_any_state(
    turn: tuple[float, float, float],
    height: float,
    velocity: tuple[float, float, float],
    spin: tuple[float, float, float],
) -> None:
    """Power of the contact forces plus the rate of what the ground stores is never positive.

    The forces' power is the rate of kinetic energy; what is stored changes by central differences along the motion.
    """
    angle = float(np.linalg.norm(turn))
    axis = np.array(turn) / angle if angle else np.zeros(3)
    q = np.array([0.0, 0.0, height, math.cos(angle / 2), *(math.sin(angle / 2) * axis)])
    u = np.array([*velocity, *spin])
    sim = floating()
    step = 1e-7  # s
    energies = []
    for side in (-0.5, 0.5):
        moved = q + side * step * coordinate_rates(q, u)
        rates = u + side * step * sim.acceleration(q, u)
        energies.append(float(sim.energy(moved, rates)))
    power = (energies[1] - energies[0]) / step
    # Round-off of two energies, 1e-16, over the step, 1e-7 s; the energy's third derivative matters less
    assert power <= 1e-7 * max(abs(energies[0]), 1e-3) * 10.0


@cache
def floating() -> Simulator:
    """A plate and the ground, without gravity: all energy is kinetic or in the ground."""
    return lamc.compile(plate(), Scene((GroundContact(friction=0.8), FreeBase())))


def coordinate_rates(q: np.ndarray, u: np.ndarray) -> np.ndarray:
    """The position moves by the velocity, the quaternion by ½ q ω, ω in axes of the body."""
    w, (x, y, z) = q[3], q[4:]
    a, b, c = u[3:]
    quaternion = [-x * a - y * b - z * c, w * a + y * c - z * b, w * b + z * a - x * c, w * c + x * b - y * a]
    return np.array([*u[:3], *(0.5 * np.array(quaternion))])


def test_a_ball_of_one_point_bounces_as_high_as_its_restitution_says() -> None:
    """Dropped from h, the speed of each bounce is e times the last, with e of Marhefka and Orin at that speed."""
    stone = Body("stone", 0.02, (0.0, 0.0, 0.0), 1e-6 * np.eye(3), fixed=True)
    ground = GroundContact(points={"stone": [(0.0, 0.0, 0.0)]}, stiffness=1e11, damping=0.2)
    scene = Scene((Gravity(), ground, FreeBase(position=(0.0, 0.0, 0.5))))
    result = lamc.compile(Mechanism((stone,), ()), scene).run(2.0, rtol=1e-10, atol=1e-13)
    leaving = [event.t for event in result.events][1::2]
    touching = [event.t for event in result.events][::2]
    speed = math.sqrt(2.0 * G * 0.5)
    for left, next_touch in zip(leaving[:3], touching[1:4], strict=True):
        a = 1.5 * 0.2 * speed

        def balance(e: float, a: float = a) -> float:
            return a * (1 + e) - math.log((1 + a) / (1 - a * e))

        speed *= float(brentq(balance, 1e-6, min(1.0, 1.0 / a) - 1e-9))
        # A blow lasts 20 us at first, in which gravity brings 1e-4 of the momentum, and more as speeds fall
        assert 0.5 * G * (next_touch - left) == pytest.approx(speed, rel=3e-4)


@pytest.mark.slow
def test_a_disc_of_many_corners_rolls_down_as_a_disc_does() -> None:
    """A wheel on its rim, 64 corners, on a slope of 5°: 2/3 g sin, less what the corners' blows take."""
    radius, slope = 0.05, math.radians(5.0)
    outline = (Slab(Point(0, 0).buffer(radius, quad_segs=16), -0.005, 0.005),)
    inertia = 0.1 * np.diag([radius**2 / 4, radius**2 / 4, radius**2 / 2])
    wheel = Body("wheel", 0.1, (0.0, 0.0, 0.0), inertia, fixed=True, outline=outline)
    field = Gravity((G * math.sin(slope), 0.0, -G * math.cos(slope)))
    start = FreeBase(
        position=(0.0, 0.0, radius),
        rotation=(math.pi / 2, 0.0, 0.0),
        velocity=(0.5, 0.0, 0.0),
        spin=(0.0, 0.0, -10.0),
    )
    ground = GroundContact(corners=64, friction=0.8, damping=0.05)
    sim = lamc.compile(Mechanism((wheel,), ()), Scene((field, ground, start)))
    result = sim.run(1.0, rtol=1e-6, t_eval=np.linspace(0.0, 1.0, 51))
    assert result.success, result.message
    centre, _ = result.pose("wheel")
    gained = 2.0 * (centre[-1, 0] - 0.5)
    assert gained == pytest.approx(2.0 / 3.0 * G * math.sin(slope), rel=0.1)
    assert np.abs(centre[:, 1]).max() < 1e-3 * radius  # straight on


@pytest.mark.slow
def test_the_crawler_walks_alike_by_any_method() -> None:
    """Strokes are alike once the gait is found, 36 mm/s, and do not depend on the method. From rtol 1e-5 on they are
    alike to 1e-4; around 1e-4 they scatter by up to 0.8 %, as touches fall on other steps (any change of step control
    deals that anew), so nothing is asked there."""
    mechanism = lamc.split(lamc.load(Path(lamc.__file__).parent / "examples" / "crawler.yaml"))
    sim = lamc.compile(mechanism)
    strokes = np.arange(1.0, 3.01, 0.125)  # s, eight a second
    walks = []
    for integrator, rtol in (("auto", 1e-5), ("dop853", 1e-7)):
        result = sim.run(3.0, rtol=rtol, atol=1e-2 * rtol, integrator=integrator, t_eval=strokes)
        assert result.success, result.message
        walks.append(result.pose("body")[0][:, 0])
    steps = np.diff(walks[0])
    assert steps == pytest.approx(
        np.full(16, steps.mean()), rel=0.02
    )  # each touch of 16 a stroke is a little different
    assert steps.mean() == pytest.approx(4.54e-3, rel=0.01)  # m, as the story tells
    assert walks[1] - walks[1][0] == pytest.approx(walks[0] - walks[0][0], rel=1e-3)  # ten times what is seen


def test_the_crawler_stays_where_friction_holds_it() -> None:
    """On a slope of 20° with μ = 0.6 it settles, and then creeps as the smooth law says: tan 20° / 0.6 = 0.607."""
    mechanism = lamc.split(lamc.load(Path(lamc.__file__).parent / "examples" / "crawler.yaml"))
    sim = lamc.compile(mechanism, mechanism.scenes["slope"])
    times = np.linspace(0.0, 6.0, 61)
    result = sim.run(6.0, rtol=1e-6, t_eval=times)
    along = result.pose("body")[0][:, 0]
    part = math.tan(math.radians(20.0)) / 0.6
    creep = sim.parameters["ground_contact.slip_speed"] * part / math.sqrt(1.0 - part**2)
    speeds = np.diff(along)[-20:] / 0.1
    # Its two feet carry unlike loads, and what pulls at them goes over from one to the other: each creeps by itself
    assert speeds == pytest.approx(np.full(20, creep), rel=0.05)


def test_a_start_deep_in_the_ground_is_refused_before_it_flings() -> None:
    """Four corners 10 mm deep store 4 / 2.5 (10 mm / (1e-3 size))^1.5 times the weight times 10 mm."""
    sim = lamc.compile(plate(), Scene((Gravity(), GroundContact(), FreeBase(position=(0.0, 0.0, -0.008)))))
    with pytest.raises(
        lamc.DesignError, match=r"body 'plate' is 10 mm deep in the ground, .* start it higher"
    ):
        sim.run(0.1)
    lowered = sim.run(0.1, parameters={"ground_contact.height": -0.011})
    assert lowered.success


def test_a_start_that_rests_in_the_ground_is_none_to_refuse() -> None:
    depth = 1e-3 * SIZE * 0.25 ** (2.0 / 3.0)
    start = FreeBase(position=(0.0, 0.0, THICKNESS / 2 - depth))
    result = lamc.compile(plate(), Scene((Gravity(), GroundContact(), start))).run(10.0, rtol=1e-8)
    assert np.ptp(result.pose("plate")[0][:, 2]) < 1e-6 * SIZE  # it is at rest there
    assert not result.events


@pytest.mark.parametrize(("friction", "degrees"), [(0.3, 30.0), (0.5, 40.0), (0.7, 30.0)])
def test_a_plate_slides_and_sticks_as_mujoco_says(friction: float, degrees: float) -> None:
    """Another engine with another law of contact: soft constraints and a friction cone. Needs the package mujoco (extra
    "bench")."""
    mujoco = pytest.importorskip("mujoco", reason="mujoco is an extra: pip install 'lamc[bench]'")
    slope = math.radians(degrees)
    field = (G * math.sin(slope), 0.0, -G * math.cos(slope))
    box_size = f"{LENGTH / 2} {WIDTH / 2} {THICKNESS / 2}"
    model = mujoco.MjModel.from_xml_string(
        f'<mujoco><option timestep="1e-4" gravity="{field[0]} 0 {field[2]}" cone="elliptic" impratio="10"/>'
        f'<default><geom friction="{friction} 0 0" condim="3"/></default><worldbody><geom type="plane" size="50 50 1"/>'
        f'<body pos="0 0 {THICKNESS / 2}"><freejoint/><geom type="box" size="{box_size}" mass="{MASS}"/></body>'
        "</worldbody></mujoco>"
    )
    data = mujoco.MjData(model)
    times = np.linspace(0.0, 1.0, 11)
    theirs = []
    for t in times:
        while data.time < t - 1e-9:
            mujoco.mj_step(model, data)
        theirs.append(float(data.qpos[0]))
    sim = lamc.compile(plate(), Scene((Gravity(field), GroundContact(friction=friction), FreeBase())))
    ours = sim.run(1.0, rtol=1e-8, t_eval=times).pose("plate")[0][:, 0]
    if math.tan(slope) > friction:
        # Theirs is 0.3 % faster than Coulomb's law: its contacts let go a little on the way
        assert ours[-1] == pytest.approx(theirs[-1], rel=0.01)
    else:
        assert max(abs(ours[-1] - ours[1]), abs(theirs[-1] - theirs[1])) < 2e-3 * times[-1]  # both creep, m


@pytest.mark.slow
def test_a_dropped_origami_stays_closed_and_comes_to_rest() -> None:
    """Six panels round a vertex, one loop, 48 corners: closure holds through hundreds of touches."""
    mechanism = lamc.split(lamc.load(Path(lamc.__file__).parent / "examples" / "waterbomb.yaml"))
    sim = lamc.compile(mechanism, mechanism.scenes["drop"])
    result = sim.run(3.0, rtol=1e-5, atol=1e-7)
    assert result.success, result.message
    assert len(result.events) > 200
    assert result.constraint_error.max() < 1e-9 * mechanism.size
    lost = float(result.energy[0] - result.energy[-1])
    assert np.diff(result.energy).max() <= 1e-6 * lost  # the tolerance of a step
    assert np.abs(result.u[-1]).max() < 1e-3  # rad/s and m/s: what is left dies away
    assert result.events[-1].t < 1.0
