"""Equilibria against closed forms, stable and unstable ones, and what is refused."""

import math
from dataclasses import replace
from typing import Any, ClassVar

import numpy as np
import pytest
from scipy.optimize import brentq

import lamc
from lamc import (
    Body,
    ExternalTorque,
    FreeBase,
    Gravity,
    GroundContact,
    HingeDamping,
    HingeStiffness,
    Joint,
    JointLimits,
    Mechanism,
    RestAngle,
    Scene,
    Simulator,
    Spring,
    Torque,
)
from lamc.commands.examples import mechanism_of_example
from lamc.examples import find
from tests.support.ctools import needs_cc
from tests.support.mechanisms import chain

pytestmark = needs_cc

Y, Z = (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)
G = 9.81
NEAR = 1e-9  # rad and m: what is promised where the stiffness is not near zero


def bar(stiffness: float = 0.0, rest: float = 0.0, damping: float = 0.0, **more: object) -> Mechanism:
    """2 kg at 0.3 m from a pin, drawn along x; gravity along -y turns it about z."""
    body = Body("bar", 2.0, (0.3, 0.0, 0.0), np.diag([1e-3, 1e-2, 1e-2]))
    pin = Joint("pin", "wall", "bar", axis=Z, stiffness=stiffness, rest_angle=rest, damping=damping, **more)
    return Mechanism((Body("wall", fixed=True), body), (pin,))


DOWN = Gravity((0.0, -G, 0.0))


def test_a_pendulum_hangs_or_stands_whichever_is_nearer() -> None:
    sim = lamc.compile(bar(), Scene(effects=(DOWN,)))
    hangs = sim.equilibrium({"pin": -0.9})
    stands = sim.equilibrium({"pin": 1.2})
    assert hangs.angles["pin"] == pytest.approx(-0.5 * math.pi, abs=NEAR)
    assert stands.angles["pin"] == pytest.approx(0.5 * math.pi, abs=NEAR)
    assert (hangs.stable, stands.stable) == (True, False)
    pace = 2.0 * G * 0.3 / (1e-2 + 2.0 * 0.3**2)  # m g l / (I + m l²)
    assert hangs.stiffnesses == pytest.approx([pace], rel=1e-12)  # exact derivatives
    assert stands.stiffnesses == pytest.approx([-pace], rel=1e-12)
    assert sim.equilibrium({"pin": 1.2}, stable=True).stable
    assert sim.equilibrium({"pin": 0.5 * math.pi}, stable=True).stable  # right on the top it falls, too


def test_a_sprung_bar_sags_by_the_root_of_its_equation() -> None:
    sim = lamc.compile(bar(stiffness=5.0, rest=0.4), Scene(effects=(DOWN, HingeStiffness(), RestAngle())))
    expected = brentq(lambda a: 5.0 * (a - 0.4) + 2.0 * G * 0.3 * math.cos(a), -2.0, 1.0, xtol=1e-15)
    found = sim.equilibrium()
    assert found.angles["pin"] == pytest.approx(expected, abs=NEAR)
    energy = 0.5 * 5.0 * (expected - 0.4) ** 2 + 2.0 * G * 0.3 * math.sin(expected)
    assert found.energy == pytest.approx(
        energy, abs=1e-12
    )  # gravity counts from the drawn height of the world
    assert found.residual < 1e-11  # rad/s²: of accelerations of 30
    assert found.criterion == "projected Hessian"


def truss(weight: float = 0.0) -> Simulator:
    """Von Mises' truss: a point that two springs hold to (±B, 0), each as long as to (0, H). Two links lead it through
    the plane, the first of which has its centre of mass at the pin, the second at the point."""
    point, elbow = np.array([0.0, H, 0.0]), np.array([0.9, 0.3, 0.0])
    pin = np.array([0.6, -0.9, 0.0])
    bodies = (
        Body("wall", fixed=True),
        Body("crank", 1.0, pin, 1e-2 * np.eye(3)),
        Body("rod", 0.5, point, 1e-2 * np.eye(3)),
    )
    joints = (
        Joint("pin", "wall", "crank", point=pin, axis=Z),
        Joint("elbow", "crank", "rod", point=elbow, axis=Z),
    )
    length = math.hypot(B, H)
    springs = tuple(Spring("wall", (s * B, 0.0, 0.0), "rod", tuple(point), K, length) for s in (-1.0, 1.0))
    load = (Gravity((0.0, -weight / 0.5, 0.0)),) if weight else ()
    return lamc.compile(Mechanism(bodies, joints), Scene(effects=(*springs, *load)))


B, H, K = 0.5, 0.2, 300.0


def height(sim: Simulator, point: object) -> tuple[float, float]:
    """Where the point is, by plane trigonometry."""
    angles = point.angles  # type: ignore[attr-defined]

    def turned(vector: np.ndarray, angle: float) -> np.ndarray:
        c, s = math.cos(angle), math.sin(angle)
        return np.array([c * vector[0] - s * vector[1], s * vector[0] + c * vector[1]])

    pin, elbow, tip = np.array([0.6, -0.9]), np.array([0.9, 0.3]), np.array([0.0, H])
    found = pin + turned(elbow - pin, angles["pin"]) + turned(tip - elbow, angles["pin"] + angles["elbow"])
    return float(found[0]), float(found[1])


def on_the_axis(sim: Simulator) -> dict[float, object]:
    """Equilibria by the height of the point, where it is between the springs' ends; there are others in the plane."""
    places = [(height(sim, point), point) for point in sim.equilibria(60)]
    return {round(y, 6) + 0.0: point for (x, y), point in places if abs(x) < 1e-6}


@pytest.mark.slow
def test_von_mises_truss_has_two_stable_places_and_an_unstable_one_between() -> None:
    sim = truss()
    found = on_the_axis(sim)
    for y, stable in ((H, True), (-H, True), (0.0, False)):
        point = found[y]
        assert height(sim, point) == pytest.approx((0.0, y), abs=NEAR)
        assert point.stable is stable
    assert found[0.0].reason == "1 of 2 directions falls away"


def pull(y: float) -> float:
    """Upward force of the springs on the point at (0, y)."""
    length = math.hypot(B, y)
    return -2.0 * K * (1.0 - math.hypot(B, H) / length) * y


@pytest.mark.slow
def test_von_mises_truss_under_load_has_the_roots_of_its_equation_up_to_its_limit() -> None:
    top = B * math.sqrt((1.0 + (H / B) ** 2) ** (1.0 / 3.0) - 1.0)  # where the force is largest
    most = pull(top)
    for share in (0.3, 0.95):
        sim, load = truss(share * most), share * most
        upper = brentq(lambda y, w=load: pull(y) - w, top, H, xtol=1e-16)
        middle = brentq(lambda y, w=load: pull(y) - w, -top, top, xtol=1e-16)
        found = on_the_axis(sim)
        for y, stable in ((upper, True), (middle, False)):
            point = found[round(y, 6)]
            assert height(sim, point) == pytest.approx((0.0, y), abs=NEAR)
            assert point.stable is stable
    beyond = truss(1.05 * most).equilibrium(stable=True)
    lower = brentq(lambda y: pull(y) - 1.05 * most, -2.0 * H, -top, xtol=1e-16)
    assert height(sim, beyond) == pytest.approx((0.0, lower), abs=NEAR)


def vertex(rests: dict[str, float], ratio: float = 1.0) -> Mechanism:
    """The shipped vertex with rest angles, rad; ratio: of the stiffnesses of c2 and c4 over those of c1 and c3."""
    mechanism = mechanism_of_example(find("vertex"))
    joints = tuple(
        replace(j, rest_angle=rests[j.name], stiffness=1e-4 * (ratio if j.name in ("c2", "c4") else 1.0))
        for j in mechanism.joints
    )
    return replace(mechanism, joints=joints)


def test_a_bistable_vertex_has_the_roots_of_its_closed_form() -> None:
    """Opposite creases turn alike: c1 = c3 = x, c4 = -c2, tan(c2/2) = -p tan(x/2) with p = cos((α+β)/2)/cos((α-β)/2)
    of the sectors α = 60°, β = 75° (flat-foldable degree-4 vertices; R. J. Lang, Twists, Tilings and Tessellations)."""
    p = math.cos(math.radians(67.5)) / math.cos(math.radians(7.5))
    rests = {"c1": -2.9, "c3": -3.1, "c2": -3.1, "c4": 3.1}
    ratio = 2.75  # of the stiffnesses of c2 and c4 over those of c1 and c3

    def slope(x: float) -> float:
        """dE/dx over the stiffness of c1."""
        y = -2.0 * math.atan(p * math.tan(0.5 * x))
        by_x = -p / math.cos(0.5 * x) ** 2 / (1.0 + (p * math.tan(0.5 * x)) ** 2)
        along = (x - rests["c1"]) + (x - rests["c3"])
        return along + ratio * by_x * ((y - rests["c2"]) - (-y - rests["c4"]))

    grid = np.linspace(-3.1, 3.1, 2001)
    values = [slope(x) for x in grid]
    roots = [
        brentq(slope, a, b, xtol=1e-15)
        for a, b, va, vb in zip(grid, grid[1:], values, values[1:], strict=False)
        if va * vb < 0.0
    ]
    assert len(roots) == 3
    stable = [slope(x + 1e-6) > 0.0 for x in roots]
    assert sorted(stable) == [False, True, True]
    sim = lamc.compile(vertex(rests, ratio), Scene(effects=(HingeStiffness(), RestAngle())))
    for root, holds in zip(roots, stable, strict=True):
        y = -2.0 * math.atan(p * math.tan(0.5 * root))
        aside = root + 0.05
        found = sim.equilibrium({"c1": aside, "c2": -2.0 * math.atan(p * math.tan(0.5 * aside))})
        assert found.angles["c1"] == pytest.approx(root, abs=NEAR)
        assert found.angles["c3"] == pytest.approx(root, abs=NEAR)
        assert found.angles["c2"] == pytest.approx(y, abs=NEAR)
        assert found.stable is holds


def test_a_chain_hangs_straight_by_descent_from_anywhere() -> None:
    """15 links: more than have exact derivatives."""
    sim = lamc.compile(chain(15, kind="parallel", seed=3), Scene(effects=(Gravity((0.0, 0.0, -G)),)))
    found = sim.equilibrium(stable=True)
    assert found.stable
    assert found.residual < 1e-9  # rad/s², of accelerations of 10
    assert sim.acceleration(found.q, np.zeros(15)) == pytest.approx(np.zeros(15), abs=1e-9)


def test_what_lies_on_the_ground_is_held_down_and_free_to_slide() -> None:
    lone = Mechanism((Body("block", 0.1, (0.0, 0.0, 0.02), 1e-5 * np.eye(3), fixed=True),), (), name="block")
    corners = {"block": [(x, y, 0.0) for x in (-0.02, 0.02) for y in (-0.01, 0.01)]}
    contact = GroundContact(stiffness=500.0, exponent=1.0, points=corners)
    sim = lamc.compile(lone, Scene(effects=(FreeBase(), Gravity((0.0, 0.0, -G)), contact)))
    found = sim.equilibrium()
    depth = 0.1 * G / (4.0 * 500.0)
    assert found.coordinates["base.z"] == pytest.approx(0.02 - depth, abs=NEAR)
    assert found.kind == "neutral"
    assert len(found.contacts) == 4
    assert "3 of 6" in found.reason


def test_a_stop_that_yields_is_part_of_the_stiffness() -> None:
    limited = bar(limits=(-0.5, 3.0))
    sim = lamc.compile(limited, Scene(effects=(DOWN, JointLimits(stiffness=200.0))))
    found = sim.equilibrium()
    expected = brentq(lambda a: 200.0 * (a + 0.5) + 2.0 * G * 0.3 * math.cos(a), -1.0, -0.5, xtol=1e-15)
    assert found.angles["pin"] == pytest.approx(expected, abs=NEAR)
    assert found.contacts == ("lower limit of pin",)
    stiffness = 200.0 - 2.0 * G * 0.3 * math.sin(expected)
    assert found.stiffnesses == pytest.approx([stiffness / (1e-2 + 0.18)], rel=1e-9)


class Follower(lamc.Effect):
    """Pushes the tip of the second rod along that rod, which has no potential."""

    name: ClassVar[str] = "follower"
    summary: ClassVar[str] = "A force along the last rod"

    def contribute(self, loads: Any) -> None:
        push = loads.parameter("follower.push", 1.0, "N", "force along the rod")
        tip, elbow = (loads.position("second", (x, 0.0, 0.0)) for x in (1.0, 0.5))
        along = [2.0 * (a - b) for a, b in zip(tip, elbow, strict=True)]
        loads.force("second", (1.0, 0.0, 0.0), [-push * x for x in along])


def test_zieglers_column_flutters_where_its_closed_form_says() -> None:
    """Rods of l = 0.5 m with 2 m at the elbow and m at the tip, springs k: P = (7/2 - √2) k / l (H. Ziegler, Die
    Stabilitätskriterien der Elastomechanik, Ingenieur-Archiv 20, 1952). With hardly any inertia of their own."""
    k, length, small = 3.0, 0.5, 1e-9
    bodies = (
        Body("wall", fixed=True),
        Body("first", 2.0, (length, 0.0, 0.0), small * np.eye(3)),
        Body("second", 1.0, (2.0 * length, 0.0, 0.0), small * np.eye(3)),
    )
    joints = (
        Joint("root", "wall", "first", axis=Z, stiffness=k),
        Joint("elbow", "first", "second", point=(length, 0.0, 0.0), axis=Z, stiffness=k),
    )
    sim = lamc.compile(Mechanism(bodies, joints), Scene(effects=(HingeStiffness(), Follower())))
    critical = (3.5 - math.sqrt(2.0)) * k / length
    for share, kind in (
        (0.999, "neutral"),
        (1.001, "unstable"),
    ):  # it vibrates on, without damping; it flutters
        point = sim.equilibrium(parameters={"follower.push": share * critical})
        assert point.angles["root"] == pytest.approx(0.0, abs=NEAR)
        assert point.criterion == "eigenvalues"
        assert point.kind == kind
        assert "not conservative" in point.reason
    growing = sim.modes(point).modes
    assert any(mode.kind == "vibration" and mode.damping < 0.0 for mode in growing)


def test_with_no_stiffness_every_place_is_as_good() -> None:
    sim = lamc.compile(bar(damping=0.1), Scene(effects=(HingeDamping(),)))
    found = sim.equilibrium({"pin": 0.7})
    assert found.kind == "neutral"
    assert found.angles["pin"] == 0.7
    assert any("no load depends on the position" in note for note in found.notes)


def test_loads_that_change_with_time_need_an_instant() -> None:
    scene = Scene(effects=(HingeStiffness(), Torque({"pin": "0.3*sin(2*t)"})))
    sim = lamc.compile(bar(stiffness=5.0), scene)
    with pytest.raises(lamc.RequestError, match="depend on time"):
        sim.equilibrium()
    found = sim.equilibrium(t=0.7)
    assert found.angles["pin"] == pytest.approx(0.3 * math.sin(1.4) / 5.0, abs=NEAR)
    assert "t = 0.7 s" in found.notes[0]


def test_parameters_move_the_equilibrium() -> None:
    sim = lamc.compile(bar(stiffness=5.0), Scene(effects=(HingeStiffness(), ExternalTorque(("pin",)))))
    (torque,) = [name for name in sim.parameters if "torque" in name]
    first = sim.equilibrium(parameters={torque: 0.2})
    assert first.angles["pin"] == pytest.approx(0.04, abs=NEAR)
    again = sim.equilibrium(first, parameters={torque: 0.2, "pin.stiffness": "4 N*m/rad"})
    assert again.angles["pin"] == pytest.approx(0.05, abs=NEAR)


def test_a_motor_that_nothing_resists_has_no_equilibrium() -> None:
    sim = lamc.compile(bar(), Scene(effects=(Torque({"pin": 0.3}),)))
    with pytest.raises(
        lamc.SimulationError, match=r"no equilibrium is within reach.*'pin' still accelerates"
    ):
        sim.equilibrium()


def test_an_impact_gives_no_force_at_rest() -> None:
    limited = bar(limits=(-0.5, 3.0))
    sim = lamc.compile(limited, Scene(effects=(DOWN, JointLimits(restitution=0.5))))
    with pytest.raises(lamc.SimulationError, match=r"no equilibrium|impact gives no force"):
        sim.equilibrium()


def test_a_contact_on_the_edge_is_refused() -> None:
    """The spring rests right on the stop: beyond it the stiffness is another."""
    limited = bar(stiffness=5.0, rest=0.3, limits=(-0.5, 0.3))
    effects = (HingeStiffness(), RestAngle(), JointLimits(stiffness=200.0))
    with pytest.raises(lamc.SimulationError, match="upper limit of pin is on the edge"):
        lamc.compile(limited, Scene(effects=effects)).equilibrium()


def test_a_flat_vertex_is_singular() -> None:
    rests = dict.fromkeys(("c1", "c2", "c3", "c4"), 0.0)
    sim = lamc.compile(vertex(rests), Scene(effects=(HingeStiffness(),), angles={"c1": -0.3}))
    with pytest.raises(lamc.SimulationError, match=r"singular|no equilibrium"):
        sim.equilibrium()


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        ({"angles": {"pins": 0.1}}, "pins"),
        ({"angles": 3}, "must map joints"),
        ({"t": "soon"}, "t is"),
        ({"parameters": {"mass": 1.0}}, "no parameter is named"),
    ],
)
def test_arguments_that_make_no_sense_are_refused(arguments: dict[str, object], said: str) -> None:
    sim = lamc.compile(bar(), Scene(effects=(DOWN,)))
    with pytest.raises(lamc.LamcError, match=said):
        sim.equilibrium(**arguments)  # type: ignore[arg-type]


@pytest.mark.parametrize("starts", [0, True, "h1", [], [1.0]])
def test_starts_are_a_number_or_angles(starts: object) -> None:
    sim = lamc.compile(bar(), Scene(effects=(DOWN,)))
    with pytest.raises(lamc.RequestError, match="starts is"):
        sim.equilibria(starts)  # type: ignore[arg-type]


def test_a_flat_scene_has_other_starts_too() -> None:
    """What loads choose at the flat start of the scene is no matter where the start is another."""
    mechanism = vertex(dict.fromkeys(("c1", "c2", "c3", "c4"), 0.5))
    sim = lamc.compile(mechanism, Scene(effects=(HingeStiffness(), RestAngle())))
    assert sim.pushed_branch is not None
    many = sim.ensemble(1e-3, angles={"c1": np.array([0.0, 0.4])})
    assert many.q[1, 0, sim.joints.index("c1")] == pytest.approx(0.4, abs=1e-12)


def test_whole_turns_of_what_nothing_winds_up_are_the_same_place() -> None:
    sim = lamc.compile(bar(), Scene(effects=(DOWN,)))
    starts = [{"pin": f"{-1.4 + turn} rad"} for turn in (0.0, 2.0 * math.pi, -2.0 * math.pi, math.pi)]
    assert [point.stable for point in sim.equilibria(starts)] == [True, False]
    sprung = lamc.compile(bar(stiffness=0.05), Scene(effects=(DOWN, HingeStiffness())))
    assert len(sprung.equilibria(starts)) == 4


def test_another_geometry_has_its_own_equilibrium() -> None:
    sim = lamc.compile(bar(), Scene(effects=(DOWN,)))
    other = lamc.compile(bar(stiffness=1.0), Scene(effects=(DOWN, HingeStiffness())))
    with pytest.raises(lamc.RequestError, match="of another mechanism"):
        sim.equilibrium(other.equilibrium())


def test_an_input_that_follows_a_series_needs_an_instant() -> None:
    """Also where the series is nought but for a millisecond."""
    pulse = lamc.Series([0.0, 3.0, 3.0005, 3.001, 10.0], [0.0, 0.0, 0.2, 0.0, 0.0])
    scene = Scene(
        effects=(HingeStiffness(), Torque({"pin": "w"})), inputs={"w": lamc.Input(unit="N*m", series=pulse)}
    )
    sim = lamc.compile(bar(stiffness=5.0), scene)
    with pytest.raises(lamc.RequestError, match="depend on time"):
        sim.equilibrium()
    point = sim.equilibrium(t=3.0005)
    assert point.angles["pin"] == pytest.approx(0.04, abs=NEAR)
    model = sim.linearise(point, inputs=["pin.stiffness"])
    assert model.B[1, 0] == pytest.approx(-0.04 / 0.19, rel=1e-9)


def test_limits_that_nothing_holds_are_told() -> None:
    found = lamc.compile(bar(limits=(-0.5, 3.0)), Scene(effects=(DOWN,))).equilibrium()
    assert any("'pin'" in note and "does not hold it to them" in note for note in found.notes)
    held = lamc.compile(
        bar(limits=(-0.5, 3.0)), Scene(effects=(DOWN, JointLimits(stiffness=200.0)))
    ).equilibrium()
    assert not any("does not hold" in note for note in held.notes)
