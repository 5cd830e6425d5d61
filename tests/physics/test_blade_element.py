"""Air around flat wings: closed forms of revolving, falling and swinging plates, thin aerofoil theory, passivity."""

import math
from dataclasses import replace

import numpy as np
import numpy.typing as npt
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from shapely.geometry import Polygon

import lamc
from lamc.basics.errors import DesignError
from lamc.effects.strips import wing
from lamc.pipeline import equations_of
from lamc.records.effect import Effect
from lamc.records.mechanism import Body, Joint, Mechanism, Slab
from tests.support.ctools import needs_cc
from tests.support.every_effect import SAMPLES, mechanism
from tests.support.floating import lone_body, quaternion_matrix
from tests.support.general_motion import General
from tests.support.quick import tries

Array = npt.NDArray[np.float64]

AIR = 1.2  # kg/m³
INERTIA = np.diag([0.03, 0.05, 0.04])  # kg·m²
RECTANGLE = ((0.2, -0.3), (1.2, -0.3), (1.2, 0.1), (0.2, 0.1))  # m: chord 0.4, pitch axis at a quarter of it
TRIANGLE = ((0.0, -0.45), (1.0, 0.0), (0.0, 0.15))  # m: chord 0.6 (1 - r), pitch axis at a quarter of it
PLAIN = {"line": ((0.0, 0.0), (1.0, 0.0)), "leading": (0.0, 1.0), "rest_speed": 1e-9}


def blade(**fields: object) -> lamc.BladeElementDrag:
    """A wing on the floating body of `lone_body`, pitching about x, leading edge towards y."""
    return lamc.BladeElementDrag("ground", AIR, **{**PLAIN, "outline": RECTANGLE, **fields})  # type: ignore[arg-type]


def floating(*effects: Effect, mass: float = 1.0) -> General:
    return General(lone_body(mass, INERTIA), (*effects, lamc.FreeBase()))


def state(general: General, turn: Array, velocity: Array, spin: Array) -> tuple[Array, Array]:
    """q and u with the base at the origin: turn as axis times angle, velocity in the world, spin in the body."""
    q, u = general.start([0.0], [0.0])
    angle = float(np.linalg.norm(turn)) or 1e-300
    q[-7:-4], q[-4:] = 0.0, [math.cos(angle / 2), *(math.sin(angle / 2) / angle * turn)]
    u[-6:-3], u[-3:] = velocity, spin
    return q, u


def wrench(
    effect: lamc.BladeElementDrag, turn: Array, velocity: Array, spin: Array, mass: float = 1.0
) -> tuple[Array, Array]:
    """Force and moment about the origin, world, that make the accelerations of a rigid body of known inertia."""
    general = floating(effect, mass=mass)
    q, u = state(general, turn, velocity, spin)
    acceleration = general.acceleration(0.0, q, u)
    moment = INERTIA @ acceleration[-3:] + np.cross(spin, INERTIA @ spin)
    return mass * acceleration[-6:-3], quaternion_matrix(q[-4:]) @ moment


# ---- lift and drag ------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("degrees", [0, 20, 45, 70, 90])
@pytest.mark.parametrize(
    ("outline", "second", "third"),
    [
        (RECTANGLE, 0.4 * (1.2**3 - 0.2**3) / 3, 0.4 * (1.2**4 - 0.2**4) / 4),
        (TRIANGLE, 0.6 * (1 / 3 - 1 / 4), 0.6 * (1 / 4 - 1 / 5)),
    ],
)
def test_revolving_wing_has_the_moments_of_its_chord(
    outline: tuple[tuple[float, float], ...], second: float, third: float, degrees: float
) -> None:
    """Lift and drag are ½ ρ Ω² C ∫ c r² dr, their moments ½ ρ Ω² C ∫ c r³ dr; three Gauss points are exact."""
    alpha, rate = math.radians(degrees), 7.0
    spin = rate * np.array([0.0, math.sin(alpha), math.cos(alpha)])  # about z, in axes of the body
    effect = blade(outline=outline, strips=3, added_mass=False)
    force, moment = wrench(effect, np.array([alpha, 0.0, 0.0]), np.zeros(3), spin)
    lift = 1.8 * math.sin(2 * alpha)
    drag = 0.4 * math.cos(alpha) ** 2 + 3.4 * math.sin(alpha) ** 2
    pressure = 0.5 * AIR * rate**2
    size = pressure * 3.4
    # round-off of a 1e-12 speck of dust beside the wing, and of solving for accelerations
    assert force == pytest.approx(pressure * second * np.array([0.0, -drag, lift]), abs=1e-10 * size)
    assert moment[1:] == pytest.approx(-pressure * third * np.array([lift, drag]), abs=1e-10 * size)


def test_strips_of_an_elliptic_wing_come_near_its_integrals() -> None:
    """∫ c r² dr = π/16 c₀ R³: the square root at the tip costs Gauss points their order, not their use."""
    turn = np.linspace(-math.pi / 2, math.pi / 2, 2001)
    outline = tuple((math.cos(a), 0.2 * math.sin(a)) for a in turn)
    exact = math.pi / 16 * 0.4
    errors = []
    for strips in (4, 8, 16):
        flat = blade(outline=outline, strips=strips).wing(lone_body(1.0, INERTIA))
        found = math.fsum(s.chord * s.along**2 * s.width for s in flat.strips)
        errors.append(abs(found / exact - 1.0))
    assert errors[0] < 1.5e-2
    assert errors[1] < 2e-3
    assert errors[2] < 3e-4  # falls as n⁻³, as theory says of a square root at an end


def test_coefficients_are_near_the_fits_to_the_robotic_fly() -> None:
    """Dickinson, Lehmann & Sane 1999, at a strip of one Gauss point, within what the docstring says."""
    for degrees in range(0, 91, 5):
        alpha = math.radians(degrees)
        effect = blade(strips=1, added_mass=False)
        force, _ = wrench(effect, np.array([alpha, 0.0, 0.0]), np.array([0.0, 3.0, 0.0]), np.zeros(3))
        _, drag, lift = force / (0.5 * AIR * 9.0 * 0.4)
        assert lift == pytest.approx(0.225 + 1.58 * math.sin(math.radians(2.13 * degrees - 7.2)), abs=0.11)
        assert -drag == pytest.approx(1.92 - 1.55 * math.cos(math.radians(2.04 * degrees - 9.82)), abs=0.21)


def test_sharp_plate_is_pushed_along_its_normal() -> None:
    effect = blade(lift=1.7, drag_edge_on=0.0, drag_broadside=3.4, added_mass=False)
    for alpha in (0.1, 0.7, 1.3):
        turn = np.array([alpha, 0.0, 0.0])
        force, _ = wrench(effect, turn, np.array([0.0, 2.0, -0.4]), np.zeros(3))
        chord = np.array([0.0, math.cos(alpha), math.sin(alpha)])
        assert abs(force @ chord) < 1e-10 * np.linalg.norm(force)  # round-off, as above


@pytest.mark.parametrize(("degrees", "measured"), [(5, 0.073), (45, 0.255), (90, 0.46)])
def test_centre_of_pressure_travels_as_measured(degrees: float, measured: float) -> None:
    """0.82 α/π + 0.05 of the chord from the leading edge (Dickson, Straw & Dickinson 2006), with added mass, which has
    no force in steady motion but its moment."""
    alpha, speed = math.radians(degrees), 3.0
    effect = blade(outline=((-0.5, -0.3), (0.5, -0.3), (0.5, 0.1), (-0.5, 0.1)))
    # A heavy body hardly accelerates, so that the fluid's mass has no say but by velocities
    mass = 1e9
    heavy = General(lone_body(mass, mass * INERTIA), (effect, lamc.FreeBase()))
    q, u = state(heavy, np.array([alpha, 0.0, 0.0]), np.array([0.0, speed, 0.0]), np.zeros(3))
    acceleration = heavy.acceleration(0.0, q, u)
    force = quaternion_matrix(q[-4:]).T @ acceleration[-6:-3]
    place = (
        INERTIA[0, 0] * acceleration[-3] / force[2]
    )  # m ahead of the pitch axis, at a quarter of the chord
    assert 0.25 - place / 0.4 == pytest.approx(measured, abs=0.06)  # what the docstring says


# ---- thin aerofoil theory -----------------------------------------------------------------------------------------


@pytest.mark.parametrize("axis", [0.1, 0.25, 0.5, 0.8])
def test_small_motions_are_those_of_theodorsen(axis: float) -> None:
    """With lift = rotation = π and no drag: Theodorsen 1935, eqs. XVIII and XX, with C(k) = 1 (quasi-steady)."""
    speed, pitch, sinking, rate = 4.0, 3e-6, -5e-6, 2e-5  # m/s, rad, m/s, rad/s
    chord, mass = 0.4, 0.7
    b, a = chord / 2, 2 * axis - 1  # half the chord; place of the axis behind mid-chord, in half chords
    outline = tuple(
        (x, y + axis * chord) for x in (-0.5, 0.5) for y in ((-chord, 0.0) if x < 0 else (0.0, -chord))
    )
    effect = blade(outline=outline, lift=math.pi, rotation=math.pi, drag_edge_on=0.0, drag_broadside=0.0)
    general = floating(effect, mass=mass)
    velocity, spin = np.array([0.0, speed, -sinking]), np.array([rate, 0.0, 0.0])
    q, u = state(general, np.array([pitch, 0.0, 0.0]), velocity, spin)
    acceleration = general.acceleration(0.0, q, u)
    h2, a2 = -acceleration[-4], acceleration[-3]
    incidence = sinking + speed * pitch + b * (0.5 - a) * rate
    lift = math.pi * AIR * b**2 * (h2 + speed * rate - b * a * a2) + 2 * math.pi * AIR * speed * b * incidence
    moment = (
        math.pi * AIR * b**2 * (b * a * h2 - speed * b * (0.5 - a) * rate - b**2 * (1 / 8 + a**2) * a2)
        + 2 * math.pi * AIR * speed * b**2 * (a + 0.5) * incidence
    )
    # Theory is linear; what it leaves out is angles squared, 1e-11, and accelerations come by round-off of 1e-12
    assert -mass * h2 == pytest.approx(lift, rel=1e-6)
    assert INERTIA[0, 0] * a2 == pytest.approx(moment, rel=1e-6)


def test_rotation_makes_the_circulation_of_sane_and_dickinson() -> None:
    """ρ U C_rot ω c² per span, C_rot = π (0.75 - x0), across a velocity along the chord."""
    speed, rate, chord, span = 3.0, 0.8, 0.4, 1.0
    with_it, without = (
        wrench(
            blade(rotation=k, added_mass=False),
            np.zeros(3),
            np.array([0.0, speed, 0.0]),
            np.array([rate, 0.0, 0.0]),
        )[0]
        for k in (math.pi, 0.0)
    )
    expected = AIR * speed * math.pi * (0.75 - 0.25) * rate * chord**2 * span
    assert (with_it - without)[2] == pytest.approx(expected, rel=1e-10)


# ---- energy -------------------------------------------------------------------------------------------------------

numbers = st.floats(-10.0, 10.0)
triples = st.tuples(numbers, numbers, numbers).map(np.array)
SKEWED = {"line": ((0.1, 0.02), (1.0, -0.1)), "leading": (0.2, 1.0), "outline": TRIANGLE, "rest_speed": 1e-4}


def power_of(effect: lamc.BladeElementDrag, velocity: Array, spin: Array) -> tuple[float, float]:
    """Power, W, and the scale of its terms."""
    force, moment = wrench(effect, np.zeros(3), velocity, spin)
    terms = [*(force * velocity), *(moment * spin)]
    return math.fsum(terms), 1e-30 + float(np.abs(terms).sum())


@given(
    velocity=triples,
    spin=triples,
    lift=st.floats(0.0, 5.0),
    drag=st.floats(0.0, 5.0),
    ratio=st.floats(0.0, 5.0),
    rotation=st.floats(-5.0, 5.0),
    point=st.floats(-0.5, 1.5),
)
@settings(deadline=None, max_examples=tries(20))
def test_still_air_only_takes(
    velocity: Array, spin: Array, lift: float, drag: float, ratio: float, rotation: float, point: float
) -> None:
    effect = lamc.BladeElementDrag(
        "ground",
        AIR,
        2,
        lift,
        drag,
        ratio * drag,
        rotation,
        point,
        added_mass=False,
        **SKEWED,  # type: ignore[arg-type]
    )
    power, size = power_of(effect, velocity, spin)
    gyroscopic = float(np.linalg.norm(spin)) ** 3  # moments are found beside ω × I ω, whose round-off stays
    assert power <= 1e-9 * size + 1e-13 * gyroscopic


@given(velocity=triples, spin=triples, point=st.floats(-0.5, 1.5))
@settings(deadline=None, max_examples=tries(20))
def test_lift_does_no_work(velocity: Array, spin: Array, point: float) -> None:
    effect = lamc.BladeElementDrag(
        "ground",
        AIR,
        2,
        1.8,
        0.0,
        0.0,
        lift_point=point,
        added_mass=False,
        **SKEWED,  # type: ignore[arg-type]
    )
    power, size = power_of(effect, velocity, spin)
    assert abs(power) <= 1e-9 * size + 1e-13 * float(np.linalg.norm(spin)) ** 3  # round-off, as above


def test_wing_that_only_pitches_is_damped() -> None:
    """Broadside drag turns it back with ½ ρ C_90 ∫ |x|³ dx = ½ ρ C_90 c⁴/32 per span about mid-chord."""
    outline = ((0.0, -0.2), (1.0, -0.2), (1.0, 0.2), (0.0, 0.2))
    effect = blade(outline=outline, added_mass=False)
    _, moment = wrench(effect, np.zeros(3), np.zeros(3), np.array([5.0, 0.0, 0.0]))
    exact = -0.5 * AIR * 3.4 * 25.0 * 0.4**4 / 32
    assert moment[0] == pytest.approx(exact, rel=0.04)  # three Gauss points: 3.3 % too much


def test_wing_at_rest_feels_nothing_and_its_equations_are_numbers() -> None:
    force, moment = wrench(blade(), np.zeros(3), np.zeros(3), np.zeros(3))
    assert np.abs([*force, *moment]).max() < 1e-15


# ---- wind ---------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("added_mass", [True, False])
def test_wind_is_what_motion_against_it_is(added_mass: bool) -> None:
    """Galileo: in axes that go with a steady wind all accelerations are the same, those of the added mass too."""
    wind = np.array([1.5, -2.0, 0.7])
    turn, velocity, spin = np.array([0.4, 0.3, -0.2]), np.array([0.5, 3.0, -1.0]), np.array([2.0, -1.0, 0.5])
    still = floating(blade(added_mass=added_mass))
    windy = floating(blade(added_mass=added_mass, wind=tuple(wind)))
    expected = still.acceleration(0.0, *state(still, turn, velocity, spin))
    found = windy.acceleration(0.0, *state(windy, turn, velocity + wind, spin))
    assert found == pytest.approx(expected, abs=1e-10 * np.abs(expected).max())  # round-off of two roads


# ---- runs ---------------------------------------------------------------------------------------------------------


@needs_cc
@pytest.mark.parametrize("way", ["broadside", "edge-on"])
@pytest.mark.quick("broadside")
def test_falling_plate_comes_to_its_terminal_speed(way: str) -> None:
    """v = v∞ tanh(m g t / ((m + m') v∞)), v∞ = sqrt(2 m g / (ρ S C)); m' = π ρ c²/4 per span broadside, and 0."""
    mass, chord, gravity = 0.05, 0.4, 9.81
    outline = ((-0.5, -0.2), (0.5, -0.2), (0.5, 0.2), (-0.5, 0.2))
    down, coefficient, added = {
        "broadside": ((0.0, 0.0, -gravity), 3.4, math.pi * AIR * chord**2 / 4),
        "edge-on": ((0.0, gravity, 0.0), 0.4, 0.0),
    }[way]
    effects = (blade(outline=outline, rest_speed=1e-6), lamc.Gravity(down), lamc.FreeBase())  # type: ignore[arg-type]
    sim = lamc.compile(lone_body(mass, INERTIA), lamc.Scene(effects=effects))
    result = sim.run(t_end=1.0, rtol=1e-10, atol=1e-12, energy_balance=True)
    assert result.success, result.message
    terminal = math.sqrt(2 * mass * gravity / (AIR * chord * coefficient))
    expected = terminal * np.tanh(mass * gravity * result.t / ((mass + added) * terminal))
    velocity = result.u[:, -6:-3]
    axis, sign = (2, -1.0) if way == "broadside" else (1, 1.0)
    # 100 rtol; the rest speed of 1e-6 lacks its square over the speed of a metre or two
    assert sign * velocity[:, axis] == pytest.approx(expected, abs=1e-8 * terminal)
    assert expected[-1] > 0.9 * terminal
    assert result.energy_balance.balance < 1e-8


HINGED = 0.02  # kg·m², inertia of the plate about its hinge
SPRING = 3.0  # N·m/rad


def hinged(*effects: Effect, angle: float) -> lamc.Simulator:
    """A plate that swings broadside about y on a spring; hinge at x = 0, span along x from 0 to 1 m, chord 0.4 m."""
    plate = Body("plate", 0.05, np.array([0.4, 0.0, 0.0]), np.diag([0.002, HINGED - 0.05 * 0.16, 0.0125]))
    joint = Joint("h", "ground", "plate", axis=np.array([0.0, 1.0, 0.0]), stiffness=SPRING)
    whole = Mechanism((Body("ground", fixed=True), plate), (joint,))
    scene = lamc.Scene(effects=(lamc.HingeStiffness(), *effects), angles={"h": angle})
    return lamc.compile(whole, scene)


def swung(**fields: object) -> lamc.BladeElementDrag:
    outline = ((0.0, -0.3), (1.0, -0.3), (1.0, 0.1), (0.0, 0.1))
    return replace(blade(outline=outline, **fields), body="plate")


@needs_cc
def test_quadratic_drag_wears_a_swing_down_as_averaging_says() -> None:
    """θ'' + ω² θ + β |θ'| θ' = 0: 1/A grows by 4 β ω / (3 π) per second (Nayfeh & Mook 1979, § 3.3); β = K / I, with
    K = ½ ρ C_90 ∫ c r³ dr."""
    beta = 0.5 * 0.05 * 3.4 * 0.4 / 4 / HINGED
    omega, start = math.sqrt(SPRING / HINGED), 0.2
    sim = hinged(replace(swung(added_mass=False), air_density=0.05), angle=start)
    result = sim.run(t_end=40.0, rtol=1e-9, atol=1e-11, t_eval=np.linspace(0.0, 40.0, 4001))
    energy = 0.5 * SPRING * result.angle("h") ** 2 + 0.5 * HINGED * result.rate("h") ** 2
    amplitude = np.sqrt(2 * energy / SPRING)
    expected = start / (1 + 4 * beta * omega * start * result.t / (3 * math.pi))
    assert expected[-1] < 0.2 * start
    # averaging leaves out β A, 0.43 · 0.2, squared, and its wobble within a swing, a third of it
    assert np.abs(amplitude / expected - 1).max() < 0.04
    whole = amplitude[:: round(2 * math.pi / omega / 0.01)][-1] / expected[-1]
    assert whole == pytest.approx(1.0, abs=0.02)


@needs_cc
def test_mass_of_the_air_slows_a_swing() -> None:
    """f = sqrt(k / (I + π/4 ρ ∫ c² r² dr)) / 2 π at small angles, where drag fades."""
    omega = math.sqrt(SPRING / (HINGED + math.pi / 4 * AIR * 0.4**2 / 3))
    effect = swung(lift=0.0, drag_edge_on=0.0, drag_broadside=0.0)
    result = hinged(effect, angle=0.3).run(t_end=10 * 2 * math.pi / omega, rtol=1e-10, atol=1e-12)
    assert result.angle("h")[-1] == pytest.approx(0.3, abs=1e-8)  # ten whole swings: 100 rtol
    assert abs(result.rate("h")[-1]) < 1e-6 * 0.3 * omega


# ---- the wing that is meant ---------------------------------------------------------------------------------------


def drawn(*plates: Polygon, axis: tuple[float, float, float] = (-1.0, 0.0, 0.0)) -> Mechanism:
    outline = tuple(Slab(polygon, 0.001, 0.003) for polygon in plates)
    body = Body("wing", 0.1, np.array([0.5, 0.0, 0.0]), np.diag([0.01, 0.02, 0.03]), outline=outline)
    joint = Joint("h", "ground", "wing", point=np.array([0.3, 0.2, 0.0]), axis=np.array(axis))
    return Mechanism((Body("ground", fixed=True), body), (joint,))


def test_wing_is_the_outline_of_its_body_and_pitches_about_its_hinge() -> None:
    made = drawn(shapely_box(0.0, -0.5, 0.6, 0.3), shapely_box(0.5, -0.5, 1.0, 0.3))
    flat = wing(made, "wing", 4, None, None, None)
    assert flat.origin == (0.3, 0.2, 0.002)
    assert flat.axes[0] == (0.0, 1.0, 0.0)  # less of it lies on that side of the hinge
    assert [s.chord for s in flat.strips] == pytest.approx([0.8] * 4, abs=1e-15)
    assert [s.axis for s in flat.strips] == pytest.approx([0.125] * 4, abs=1e-15)
    assert math.fsum(s.width for s in flat.strips) == pytest.approx(1.0, abs=1e-15)


def shapely_box(left: float, bottom: float, right: float, top: float) -> Polygon:
    return Polygon([(left, bottom), (right, bottom), (right, top), (left, top)])


@pytest.mark.parametrize(
    ("change", "reported"),
    [
        ({"body": "wings"}, "no body is named 'wings'; the bodies are ground, wing"),
        ({"body": "ground"}, "body 'ground' has no outline"),
        ({"strips": 0}, "strips: it is 0; it must be at least 1"),
        ({"leading": (1.0, 0.0)}, "must point to one side"),
        ({"leading": (0.0, 0.0)}, "must have a direction"),
        ({"line": ((0.0, 0.0), (0.0, 0.0))}, "give two points that differ"),
        ({"line": ((0.0, -0.1), (1.0, -0.1))}, "halves it"),
        ({"outline": ((0.0, 0.0), (1.0, 1.0), (1.0, 0.0), (0.0, 1.0))}, "is no polygon"),
        ({"rest_speed": 0.0}, "the rest speed is 0 m/s; it must be above 0"),
        ({"air_density": -1.0}, "the air density is -1 kg/m.3"),
    ],
)
def test_what_is_no_wing_is_refused(change: dict[str, object], reported: str) -> None:
    made = drawn(shapely_box(0.0, -0.5, 1.0, 0.3))
    with pytest.raises(DesignError, match=reported):
        lamc.BladeElementDrag(**{"body": "wing", **change}).wing(made)  # type: ignore[arg-type]


def test_hinge_out_of_the_plane_is_refused() -> None:
    made = drawn(shapely_box(0.0, -0.5, 1.0, 0.3), axis=(0.0, 0.0, 1.0))
    with pytest.raises(DesignError, match="give two points of the line"):
        lamc.BladeElementDrag("wing").wing(made)


@needs_cc
def test_one_body_has_air_around_it_once() -> None:
    made = drawn(shapely_box(0.0, -0.5, 1.0, 0.3))
    with pytest.raises(DesignError, match="air around body 'wing'"):
        lamc.compile(made, lamc.Scene(effects=(lamc.BladeElementDrag("wing"), lamc.BladeElementDrag("wing"))))


def test_flexible_wing_is_refused() -> None:
    wet = replace(blade(line=((0.0, 0.0), (1.0, 0.0))), body="a")
    with pytest.raises(DesignError, match="'a' is flexible, and strips are those of a rigid one"):
        equations_of(mechanism(), (wet, SAMPLES["flexible_links"]))


def test_wing_that_does_not_move_is_refused() -> None:
    with pytest.raises(DesignError, match="the wing 'ground' does not move"):
        equations_of(mechanism(), (blade(added_mass=False),))
