"""Starts of loops at given angles are in the way of assembly that was drawn, and count turns: by plane geometry."""

import math

import numpy as np
import pytest
from scipy.optimize import fsolve

import lamc
from lamc import examples
from lamc.loops.closing import CLOSED, settle
from lamc.loops.geometry import LoopGeometry
from lamc.loops.rank import count_loops
from lamc.loops.starts import Starter
from lamc.mechanism.plan import plan
from lamc.records.mechanism import Array
from tests.support.ctools import needs_cc

pytestmark = needs_cc

# Ground, crank, coupler, rocker, mm, and the crank's angle as drawn, rad: the ground is shortest in a double crank, of
# which no motion leads from one way of assembly to the other.
DOUBLE_CRANK = (28.9, 43.1, 46.2, 38.5, 2.48)
ANOTHER = (27.3, 53.8, 54.4, 36.2, 0.04)
CRANK_ROCKER = (55.0, 20.0, 60.0, 40.0, 0.5)


def four_bar(
    ground: float, crank: float, coupler: float, rocker: float, drawn: float
) -> tuple[lamc.Mechanism, Array]:
    """The mechanism in the plane of x and z, angles positive from x to z; and the angles of coupler and rocker, rad."""
    base, foot = np.zeros(2), 1e-3 * np.array([ground, 0.0])
    pin = 1e-3 * crank * np.array([math.cos(drawn), math.sin(drawn)])
    across = foot - pin
    far = float(np.hypot(*across))
    along = ((1e-3 * coupler) ** 2 - (1e-3 * rocker) ** 2 + far**2) / (2.0 * far)
    height = math.sqrt((1e-3 * coupler) ** 2 - along**2)
    unit = across / far
    top = pin + along * unit + height * np.array([-unit[1], unit[0]])

    def at(point: Array) -> tuple[float, float, float]:
        return (float(point[0]), 0.0, float(point[1]))

    def bar(name: str, start: Array, end: Array) -> lamc.Body:
        return lamc.Body(name=name, mass=0.01, com=at(0.5 * (start + end)), inertia=1e-6 * np.eye(3))

    bodies = (
        lamc.Body(name="ground", fixed=True),
        bar("crank", base, pin),
        bar("coupler", pin, top),
        bar("rocker", top, foot),
    )
    joints = tuple(
        lamc.Joint(name=name, parent=parent, child=child, point=at(point), axis=(0.0, -1.0, 0.0))
        for name, parent, child, point in (
            ("a", "ground", "crank", base),
            ("b", "crank", "coupler", pin),
            ("c", "coupler", "rocker", top),
            ("d", "ground", "rocker", foot),
        )
    )
    angles = np.array([math.atan2(*(top - pin)[::-1]), math.atan2(*(top - foot)[::-1])])
    return lamc.Mechanism(name="bars", bodies=bodies, joints=joints), angles


def followed(sizes: tuple[float, ...], angles: Array, turned: float) -> float:
    """How far the rocker has turned, rad, when the crank has, by small steps of the closure of two lengths."""
    ground, crank, coupler, rocker, drawn = sizes

    def gap(found: Array, at: float) -> list[float]:
        return [
            crank * math.cos(at) + coupler * math.cos(found[0]) - ground - rocker * math.cos(found[1]),
            crank * math.sin(at) + coupler * math.sin(found[0]) - rocker * math.sin(found[1]),
        ]

    found = angles
    for at in drawn + np.linspace(0.0, turned, 1 + math.ceil(abs(turned) / 0.01)):
        found = fsolve(gap, found, args=(at,), xtol=1e-13)
    return float(found[1] - angles[1])


@pytest.mark.parametrize(
    "sizes", [DOUBLE_CRANK, ANOTHER, CRANK_ROCKER], ids=["double crank", "another", "crank-rocker"]
)
@pytest.mark.parametrize("turned", [50.0, 118.0, 200.0, 240.0, 350.0, -170.0, -300.0])
def test_a_start_is_where_the_drawn_linkage_moves_to(sizes: tuple[float, ...], turned: float) -> None:
    """Beyond 195 degrees it had been the other way of assembly, or a whole turn away, without a word."""
    mechanism, angles = four_bar(*sizes)
    simulator = lamc.compile(mechanism, lamc.Scene(effects=(), angles={"a": f"{turned} deg"}))
    start = simulator.run(t_end=1e-9, t_eval=[0.0, 1e-9]).angle("d")[0]
    assert start == pytest.approx(
        followed(sizes, angles, math.radians(turned)), abs=1e-9
    )  # of fsolve, some 1e-12


# Linkages that pass near dead points, where a long step came to the other way of assembly.
NEAR_DEAD_POINTS = [
    ((25.63, 41.472, 26.696, 42.045, 0.694), 199.98),
    ((28.175, 44.952, 42.124, 58.569, 1.906), -127.84),
    ((40.306, 41.309, 48.104, 47.255, -0.14), 254.47),
]


def turned_rocker(sizes: tuple[float, ...], turned: float) -> float | None:
    """How far the rocker has turned, rad, in closed form and the way of assembly of `four_bar`; None where the crank
    meets a dead point on its way."""
    ground, crank, coupler, rocker, drawn = sizes
    at = drawn + np.linspace(0.0, turned, 4001)
    pin = crank * np.stack([np.cos(at), np.sin(at)], axis=1)
    across = np.array([ground, 0.0]) - pin
    far = np.hypot(*across.T)
    if not ((abs(coupler - rocker) < far) & (far < coupler + rocker)).all():
        return None
    along = (coupler**2 - rocker**2 + far**2) / (2.0 * far)
    unit = across / far[:, None]
    normal = np.stack([-unit[:, 1], unit[:, 0]], axis=1)
    top = pin + along[:, None] * unit + np.sqrt(coupler**2 - along**2)[:, None] * normal
    angles = np.unwrap(np.arctan2(top[:, 1], top[:, 0] - ground))
    return float(angles[-1] - angles[0])


def starter_of(mechanism: lamc.Mechanism) -> Starter:
    tree = plan(mechanism)
    return Starter(LoopGeometry(tree), count_loops(tree))


@pytest.mark.parametrize(("sizes", "turned"), NEAR_DEAD_POINTS)
def test_a_start_behind_a_narrow_pass_is_the_drawn_linkage(sizes: tuple[float, ...], turned: float) -> None:
    mechanism, _ = four_bar(*sizes)
    starter = starter_of(mechanism)
    expected = turned_rocker(sizes, math.radians(turned))
    assert expected is not None
    found = starter.position({"a": math.radians(turned)})
    assert found[starter.geometry.names.index("d")] == pytest.approx(
        expected, abs=1e-9
    )  # closure is to 1e-12


@pytest.mark.parametrize("seed", range(6))
def test_starts_of_random_linkages_are_where_they_move_to_or_told(seed: int) -> None:
    """The largest of 3396 such errors, of ten minutes of these, was 4e-11."""
    random, led, not_led = np.random.default_rng(seed), 0, 0
    while led + not_led < 40:
        sizes = (*random.uniform(15.0, 60.0, 4), random.uniform(-3.0, 3.0))
        turned = math.radians(random.uniform(-400.0, 400.0))
        if turned_rocker(sizes, 0.0) is None:
            continue  # is no linkage
        expected = turned_rocker(sizes, turned)
        starter = starter_of(four_bar(*sizes)[0])
        scene = lamc.Scene(effects=(), angles={"a": turned})
        assert starter.is_elsewhere(scene) == (expected is None)
        led, not_led = led + (expected is not None), not_led + (expected is None)
        if expected is not None:
            found = starter.position({"a": turned})
            assert found[starter.geometry.names.index("d")] == pytest.approx(expected, abs=1e-8)
    assert min(led, not_led) >= 10


def test_a_spatial_linkage_is_led_by_every_hinge() -> None:
    """Bricard's: a single long step had come to the other branch from 149 degrees on. By small steps of closure."""
    example = examples.find("bricard")
    assert example.path is not None
    loaded = lamc.load(example.path)
    starter = starter_of(loaded if isinstance(loaded, lamc.Mechanism) else lamc.split(loaded))
    count = starter.size
    for k, name in enumerate(starter.geometry.names):
        free = np.arange(count) != k
        for sign in (1.0, -1.0):
            place = np.zeros(count)
            for step in range(1, 3001):
                guess = place.copy()
                guess[k] = sign * 1e-3 * step
                following, error = settle(starter.geometry, guess, free)
                if error > CLOSED or np.abs(following - place).max() > 0.1:
                    break  # no hinge of it turns a hundred times as fast as another but at a dead point
                place = following
                if step % 300 == 0:
                    found = starter.position({name: sign * 1e-3 * step})
                    assert found == pytest.approx(place, abs=1e-8), (name, sign * 1e-3 * step)


def test_a_start_that_the_drawing_does_not_move_to_is_told() -> None:
    """Its crank turns to and fro."""
    mechanism, _ = four_bar(40.0, 20.0, 25.0, 30.0, 0.5)
    there, around = (
        lamc.compile(mechanism, lamc.Scene(effects=(), angles={"a": f"{angle} deg"})) for angle in (-10, 350)
    )
    assert not there.notes
    (note,) = around.notes
    assert note.startswith(
        "the drawn mechanism does not move to a = 6.10865 rad without a dead point on its way"
    )


@pytest.mark.parametrize("name", ["four_bar", "five_bar", "six_bar", "sarrus", "bricard", "two_loops"])
def test_a_position_that_is_known_is_not_told_to_be_elsewhere(name: str) -> None:
    """Of all hinges, as an equilibrium or the end of a run has them."""
    example = examples.find(name)
    assert example.path is not None
    loaded = lamc.load(example.path)
    sim = lamc.compile(loaded, lamc.Scene(effects=()))
    starter = starter_of(sim.mechanism)
    moved = starter.position(
        {starter.geometry.names[0]: 0.05 if name == "six_bar" else -0.05}
    )  # at a dead point
    again = lamc.compile(loaded, lamc.Scene(effects=(), angles=dict(zip(sim.joints, moved, strict=True))))
    assert not again.notes
