"""Blocks on the ground: they come to rest and stay, stick and slide on slopes, tip over; and what that costs."""

import math
from functools import cache

import numpy as np
import pytest

import lamc
from lamc import Gravity, GroundContact, Scene
from lamc.run.result import Result
from lamc.run.simulator import Simulator
from tests.support.ctools import needs_cc
from tests.support.grounded import REACH, G, block, pitch, velocities

pytestmark = needs_cc

FALL = {"pitch": 0.4}, {"x": 0.2 / REACH, "pitch": 3.0}  # rad; rad/s: tilted, moving sideways, turning
DROPPED = block(0.1, 0.01, bottom=0.05)


def never_rises(result: Result, largest: float) -> bool:
    """Whether no row has more energy than one before it, but for `largest` of what was there to lose."""
    lost = float(result.energy[0] - result.energy[-1])
    return bool(np.diff(result.energy).max() <= largest * lost)


@pytest.mark.parametrize("exponent", [1.5, 1.0])
@pytest.mark.parametrize(
    ("integrator", "rtol", "t_end", "largest"),
    [
        # One step may err by its tolerance of what moves: some tens of tolerances in all, seldom above zero
        ("auto", 1e-4, 100.0, 1e-6),
        ("auto", 1e-6, 100.0, 1e-7),
        ("auto", 1e-9, 100.0, 1e-9),
        ("rodas5p", 1e-6, 100.0, 1e-7),
        ("radau5", 1e-4, 100.0, 1e-5),
        ("rk45", 1e-6, 2.0, 1e-7),
        ("dop853", 1e-6, 2.0, 1e-7),
    ],
)
def test_a_dropped_block_comes_to_rest_and_stays(
    integrator: str, rtol: float, t_end: float, largest: float, exponent: float
) -> None:
    """It tumbles, rattles on its corners ever faster, and lies still: without piling up of events, drift or jitter."""
    sim = lamc.compile(DROPPED, Scene((Gravity(), GroundContact(exponent=exponent)), *FALL))
    result = sim.run(t_end, rtol=rtol, atol=1e-2 * rtol, integrator=integrator)
    assert result.success, result.message
    assert never_rises(result, largest)
    touches = [event.t for event in result.events]
    assert len(touches) > 40
    assert touches[-1] < 1.0  # no corner flickers afterwards
    rotated = abs(math.remainder(float(pitch(result)[-1]), math.pi))
    assert rotated < 1e-6  # it lies on one of its faces
    if t_end == 100.0:
        at_rest = result.t > 0.5 * t_end
        assert at_rest.sum() <= 5  # rows: rest is crossed in strides of many seconds
        assert result.stats.steps < 12_000
        assert np.abs(result.u[-1]).max() < 1e-12
        rows = sim.run(t_end, rtol=rtol, atol=1e-2 * rtol, integrator=integrator, t_eval=[10.0, 55.0, 100.0])
        centres, _ = rows.pose("block")
        assert np.ptp(centres, axis=0).max() < 1e-9 * 0.1  # m: no drift


def on_slope(
    degrees: float, by: str, friction: float, *, length: float = 0.1, height: float = 0.01
) -> Result:
    """A block that lies on a slope, or on level ground in gravity that slants as much; 2 s from rest."""
    slope = math.radians(degrees)
    if by == "gravity":
        sim = on_level(length, height)
        field = {"gravity.x": G * math.sin(slope), "gravity.z": -G * math.cos(slope)}
    else:
        # The block turns about its centre; the plane is moved to where its lower face then is
        lift = 0.5 * height * (math.cos(slope) - 1.0)
        ground = GroundContact(normal=(math.sin(slope), 0.0, math.cos(slope)), height=lift)
        sim, field = lamc.compile(block(length, height), Scene((Gravity(), ground), {"pitch": slope})), {}
    parameters = {"ground_contact.friction": friction, **field}
    return sim.run(2.0, rtol=1e-9, t_eval=np.linspace(0.0, 2.0, 201), parameters=parameters)


@cache
def on_level(length: float, height: float) -> Simulator:
    return lamc.compile(block(length, height), Scene((Gravity((1.0, 0.0, -G)), GroundContact())))


def downhill(result: Result, degrees: float, by: str) -> np.ndarray:
    """Speed down the slope, (m,), m/s."""
    slope = math.radians(degrees)
    along = [1.0, 0.0, 0.0] if by == "gravity" else [math.cos(slope), 0.0, -math.sin(slope)]
    return velocities(result) @ np.array(along)


@pytest.mark.quick("gravity")
@pytest.mark.parametrize("by", ["gravity", "normal"])
def test_a_block_sticks_below_the_friction_angle_but_for_a_creep(by: str) -> None:
    """μ v / sqrt(v² + vs²) = tan(slope): the creep is a property of the smooth law, and a number."""
    friction = 0.5  # 26.6°
    for degrees in (10.0, 25.0):
        result = on_slope(degrees, by, friction)
        assert result.success
        slip = 1e-3 * math.sqrt(G * math.hypot(0.1, 0.04, 0.01))
        part = math.tan(math.radians(degrees)) / friction
        creep = slip * part / math.sqrt(1.0 - part * part)
        # 1e-4: the block sinks in more at its lower edge, and the last of that dies away with the ringing
        assert downhill(result, degrees, by)[-20:-1] == pytest.approx(creep, rel=1e-4)
        assert creep < 3e-3  # m/s


@pytest.mark.quick("gravity")
@pytest.mark.parametrize("by", ["gravity", "normal"])
def test_a_block_slides_above_the_friction_angle_as_coulomb_says(by: str) -> None:
    """g (sin - μ cos); what friction lacks at a speed v, (vs / v)² / 2 of it, is 1e-4 here by mid-way."""
    friction = 0.5
    for degrees in (30.0, 40.0):
        result = on_slope(degrees, by, friction)
        slope = math.radians(degrees)
        v = downhill(result, degrees, by)
        expected = G * (math.sin(slope) - friction * math.cos(slope))
        assert (v[-2] - v[50]) / (result.t[-2] - result.t[50]) == pytest.approx(expected, rel=1e-3)


@pytest.mark.parametrize(("shape", "tips"), [(0.9, False), (1.1, True)])
def test_a_block_tips_where_its_centre_is_beyond_its_edge(shape: float, tips: bool) -> None:
    """On a slope with tan = 1/2, where friction holds, a block of length l and height h tips if h > 2 l."""
    degrees = math.degrees(math.atan(0.5))
    result = on_slope(degrees, "gravity", 5.0, length=0.04, height=shape * 0.08)
    rotated = pitch(result)
    assert result.success
    if tips:
        assert rotated[-1] > 0.5
    else:
        assert abs(rotated).max() < 0.02  # what the lower edge sinks in more than the upper one


def test_static_friction_holds_what_rests_and_lets_slide_what_slides() -> None:
    """Between the two friction angles both go on as they began. The block starts as deep as it rests."""
    slope = math.radians(30.0)  # tan = 0.577
    depth = 1e-3 * math.hypot(0.1, 0.04, 0.01) * (math.cos(slope) / 4.0) ** (2.0 / 3.0)
    ground = GroundContact(friction=0.5, static_friction=0.65, height=depth)
    field = Gravity((G * math.sin(slope), 0.0, -G * math.cos(slope)))
    times = np.linspace(0.0, 1.0, 101)
    resting = lamc.compile(block(0.1, 0.01), Scene((field, ground))).run(1.0, rtol=1e-8, t_eval=times)
    sliding_start = Scene((field, ground), rates={"x": 0.5 / REACH})
    sliding = lamc.compile(block(0.1, 0.01), sliding_start).run(1.0, rtol=1e-8, t_eval=times)
    slip = 1e-3 * math.sqrt(G * math.hypot(0.1, 0.04, 0.01))
    assert velocities(resting)[-2, 0] < 5.0 * slip  # below where friction is strongest, it creeps
    v = velocities(sliding)[:, 0]
    expected = G * (math.sin(slope) - 0.5 * math.cos(slope))
    assert (v[-2] - v[50]) / (times[-2] - times[50]) == pytest.approx(expected, rel=1e-3)


def test_a_swept_friction_needs_no_compilation() -> None:
    slope = math.radians(30.0)
    for friction in (0.0, 0.2, 0.4):
        centre, _ = on_slope(30.0, "gravity", friction).pose("block")
        expected = 0.5 * 2.0**2 * G * (math.sin(slope) - friction * math.cos(slope))
        # 1e-3: while the block speeds up from rest, over a few slip speeds, friction is less than it will be
        assert centre[-1, 0] == pytest.approx(expected, rel=1e-3)


def test_the_energy_of_the_fall_is_what_the_ground_takes() -> None:
    """At rest there is m g times the drop left in no account but the ground's dissipation."""
    sim = lamc.compile(DROPPED, Scene((Gravity(), GroundContact()), {"pitch": 0.0}))
    result = sim.run(5.0, rtol=1e-8)
    lost = float(result.energy[0] - result.energy[-1])
    assert lost == pytest.approx(0.05 * G * 0.05, rel=1e-3)  # it sinks in by 1e-4 of the size


@pytest.mark.parametrize("count", [8, 50])
def test_many_points_stay_cheap(count: int) -> None:
    """Operations per point, a root, a power, an exponential and a logarithm among them; gated, as time is not."""
    mechanism = block(0.1, 0.01)
    angles = np.linspace(0.0, 2.0 * math.pi, count, endpoint=False)
    ring = [(0.05 * math.cos(a), 0.02 * math.sin(a), 0.0) for a in angles]
    scenes = (Scene((Gravity(),)), Scene((Gravity(), GroundContact(points={"block": ring}))))
    without, with_points = (
        lamc.compile(mechanism, scene).program.functions["acceleration"].operations for scene in scenes
    )
    assert with_points.flops - without.flops < 70 * count
    assert with_points.calls - without.calls <= 7 * count + 12
