"""Events: impacts of several joints and of loops, short touches, impacts without end, flat folds, one's own effects."""

import json
import math
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
import pytest

import lamc
from lamc import Body, Gravity, Joint, JointLimits, Mechanism, Scene, Torque
from lamc.mechanics.loads import Loads
from lamc.run.request import Status
from lamc.run.simulator import Simulator
from tests.support.ctools import needs_cc
from tests.support.mechanisms import chain, from_reference

pytestmark = needs_cc

INERTIA, TORQUE = 2e-5, 1e-3  # kg·m², N·m
WALL = Body("wall", fixed=True)


def flap(limits: tuple[float, float] = (-0.2, 3.0)) -> Mechanism:
    """One body about its own centre, so that only torques move it: θ'' = torque / INERTIA."""
    body = Body("flap", 0.01, (0.0, 0.0, 0.0), np.diag([INERTIA] * 3))
    return Mechanism((WALL, body), (Joint("h", "wall", "flap", axis=(0.0, 0.0, 1.0), limits=limits),))


def limited(mechanism: Mechanism, limits: dict[str, tuple[float, float]]) -> Mechanism:
    joints = tuple(replace(j, limits=limits[j.name]) if j.name in limits else j for j in mechanism.joints)
    return Mechanism(mechanism.bodies, joints)


def mass_matrix(sim: Simulator, q: np.ndarray) -> np.ndarray:
    """From the kinetic energy, which is ½ uᵀ M u: by polarisation."""
    n = len(q)
    rest = sim.energy(q, np.zeros(n))

    def kinetic(u: np.ndarray) -> float:
        return float(sim.energy(q, u) - rest)

    unit = np.eye(n)
    return np.array(
        [
            [kinetic(unit[i] + unit[j]) - kinetic(unit[i]) - kinetic(unit[j]) for j in range(n)]
            for i in range(n)
        ]
    )


def after_first_impact(mechanism: Mechanism, scene: Scene, restitution: float) -> tuple[Simulator, Any, int]:
    effects = (*(scene.effects or ()), JointLimits(restitution=restitution))
    sim = lamc.compile(mechanism, replace(scene, effects=effects))
    result = sim.run(t_end=0.6, rtol=1e-10, atol=1e-12)
    row = int(np.argmin(np.abs(result.t - result.events[0].t)))
    assert result.t[row] == result.events[0].t
    return sim, result, row


@pytest.mark.parametrize("joint", ["h0", "h1", "h2"])
@pytest.mark.quick("h1")
def test_an_impact_is_an_impulse_on_its_hinge_alone(joint: str) -> None:
    """Two restitutions, one state before: u differs by M⁻¹ times an impulse on the hinge, and the hinge's rate by 2."""
    mechanism = limited(chain(3, "laminate", seed=4), {joint: (-0.15, 0.15)})
    scene = Scene(effects=(Gravity((0.0, 0.0, -9.81)),))
    sim, full, row = after_first_impact(mechanism, scene, 1.0)
    _, half, other = after_first_impact(mechanism, scene, 0.5)
    assert full.t[row] == pytest.approx(half.t[other], abs=1e-9)  # the same motion up to there
    index = sim.joints.index(joint)
    assert full.u[row, index] == pytest.approx(2.0 * half.u[other, index], rel=1e-8)
    impulse = mass_matrix(sim, full.q[row]) @ (full.u[row] - half.u[other])
    others = np.delete(impulse, index)
    assert np.abs(others).max() <= 1e-7 * abs(impulse[index])  # differences of energies: eight digits
    drift = np.abs(full.energy - full.energy[0]).max()
    assert drift <= 1e-8 * full.energies["kinetic"].max()  # a full rebound takes nothing


@pytest.mark.parametrize("which", [0, -1], ids=["in the tree", "closing the loop"])
def test_impacts_keep_loops_closed_and_a_full_rebound_keeps_energy(shared: Path, which: int) -> None:
    text = (shared / "reference" / "dynamics.json").read_text(encoding="utf-8")
    (case,) = (c for c in json.loads(text)["cases"] if c["id"] == "fivebar")
    mechanism, scene = from_reference(case["spec"])
    plain = lamc.compile(mechanism, scene)
    joint = (*plain.joints, *plain.cut_joints)[which]
    free = plain.run(t_end=1.0, rtol=1e-8, t_eval=np.linspace(0.0, 1.0, 400))
    angles = free.angle(joint)
    limit = angles[0] + 0.6 * (angles.max() - angles[0])
    narrow = limited(mechanism, {joint: (-3.0, limit)})
    undamped = tuple(e for e in scene.effects or () if e.name != "hinge_damping")
    sim = lamc.compile(narrow, Scene((*undamped, JointLimits(restitution=1.0)), scene.angles, scene.rates))
    result = sim.run(t_end=1.0, rtol=1e-9)
    assert result.success, result.message
    assert len(result.events) >= 1
    assert result.angle(joint).max() <= limit + 1e-9
    assert result.constraint_error.max() <= 1e-9 * mechanism.size
    assert np.abs(result.energy - result.energy[0]).max() <= 1e-6 * result.energies["kinetic"].max()


@pytest.mark.parametrize("integrator", ["rk45", "dop853", "rodas5p", "radau5"])
def test_a_touch_within_one_step_is_not_missed(integrator: str) -> None:
    """A spring-driven flap swings ±0.5 rad in 2 π s; its stop is touched for 0.03 s of each swing, while steps at a
    tolerance of 1e-4 are tenths of a second."""
    mechanism = limited(flap(), {"h": (-0.49, 3.0)})
    drive = Torque({"h": f"-{INERTIA}*angle"})
    sim = lamc.compile(mechanism, Scene((drive, JointLimits(stiffness=1e4 * INERTIA)), {"h": 0.5}))
    result = sim.run(t_end=10.0, rtol=1e-4, atol=1e-6, integrator=integrator, t_eval=[10.0])
    assert result.success
    times = [event.t for event in result.events]
    assert len(times) == 4  # on and off, twice
    touch = math.acos(-0.98)  # s; then half a period of the stop's spring, and back as far as it came
    assert times[0] == pytest.approx(touch, abs=1e-3)
    assert times[1] - times[0] == pytest.approx(math.pi / 100.0, rel=0.1)  # the torque lengthens it
    assert times[2] - times[1] == pytest.approx(2 * touch, abs=5e-3)


@pytest.mark.parametrize("integrator", ["rk45", "dop853", "rodas5p", "radau5", "auto"])
def test_rows_do_not_depend_on_where_slices_end(integrator: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """A torque that is steep beside the stop, at a loose tolerance: the step that is to end on the stop is often
    refused, and a slice may end there."""
    drive = Torque({"h": "-0.001/(0.0001+(angle+0.2)*(angle+0.2))-0.01*sin(angle)"})
    sim = lamc.compile(flap(), Scene((drive, JointLimits(stiffness=1.0)), {"h": 1.5}))

    def run(first_budget: int, slice_: float) -> np.ndarray:
        monkeypatch.setattr("lamc.run.native.FIRST_BUDGET", first_budget)
        monkeypatch.setattr("lamc.run.native.SLICE", slice_)
        result = sim.run(t_end=2.0, rtol=1e-2, atol=1e-4, integrator=integrator, max_steps=20_000)
        return np.column_stack([result.t, result.q, result.u])

    np.testing.assert_array_equal(run(1, 0.0), run(10**12, 1.0))


def test_impacts_without_end_stop_with_their_own_status() -> None:
    """A constant torque towards the limit: each flight lasts e times the one before, and all of them 1 / (1 - e)."""
    restitution, gap = 0.5, 0.3
    mechanism = flap(limits=(-gap, 3.0))
    sim = lamc.compile(mechanism, Scene((Torque({"h": -TORQUE}), JointLimits(restitution=restitution))))
    result = sim.run(t_end=10.0, rtol=1e-10)
    assert result.status == Status.EVENTS_PILE_UP
    assert "lower limit of h" in result.message
    fall = math.sqrt(2 * INERTIA * gap / TORQUE)
    end = fall * (1 + 2 * restitution / (1 - restitution))
    assert result.t[-1] == pytest.approx(end, abs=1e-8)  # it stops where flights last 1e-9 s
    flights = np.diff([event.t for event in result.events])[:15]
    assert flights[0] == pytest.approx(2 * restitution * fall, rel=1e-9)
    assert (flights[1:] / flights[:-1]) == pytest.approx(restitution, rel=1e-6)


def test_a_stop_that_yields_brings_to_rest() -> None:
    stiffness = 1.0
    sim = lamc.compile(
        flap(limits=(-0.3, 3.0)),
        Scene(
            (
                Torque({"h": -TORQUE}),
                JointLimits(stiffness=stiffness, damping=2 * math.sqrt(stiffness * INERTIA)),
            )
        ),
    )
    result = sim.run(t_end=5.0, rtol=1e-8)
    assert result.success
    assert result.q[-1, 0] == pytest.approx(
        -0.3 - TORQUE / stiffness, abs=1e-7
    )  # where the spring holds the torque
    assert abs(result.u[-1, 0]) < 1e-6


def test_flat_folds_touch_when_called_for() -> None:
    free = flap(limits=(-math.pi, math.pi))
    drive = Torque({"h": TORQUE})
    folded = lamc.compile(free, Scene((drive, JointLimits(stiffness=1.0, damping=0.01, flat_fold=True))))
    result = folded.run(t_end=5.0, rtol=1e-8)
    assert result.q[-1, 0] == pytest.approx(math.pi + TORQUE, abs=1e-6)
    assert lamc.compile(free, Scene((drive,))).run(t_end=1.0).q[-1, 0] > 4.0
    with pytest.raises(lamc.DesignError, match="no joint has limits narrower than ±180°"):
        lamc.compile(free, Scene((drive, JointLimits(stiffness=1.0))))


def test_stops_of_which_the_scene_says_nothing_hold() -> None:
    mechanism = limited(chain(2, "parallel", seed=3), {"h0": (-0.3, 0.3), "h1": (-0.2, 0.2)})
    sim = lamc.compile(mechanism)  # the design asks for its limits by itself
    assert "joint_limits" in {effect.name for effect in sim.effects}
    result = sim.run(t_end=2.0, rtol=1e-8)
    assert result.success, result.message
    assert result.events
    assert np.abs(result.angle("h1")).max() < 0.2 + math.radians(3)


@dataclass(frozen=True)
class Backlash:
    """A spring that begins to act 0.1 rad from the drawn angle, on one side."""

    name: ClassVar[str] = "backlash"
    summary: ClassVar[str] = "Spring with play"

    def contribute(self, loads: Loads) -> None:
        beyond = loads.hinge("h").angle - 0.1
        touching = loads.switch("play of h", beyond)
        loads.hinge_torque("h", -touching * (INERTIA * 400.0 * beyond))
        loads.stored_energy(touching * (INERTIA * 200.0 * beyond * beyond))


def test_effects_of_ones_own_can_switch() -> None:
    """Free flight to 0.1 rad, half a period of the spring, and back: closed form."""
    sim = lamc.compile(flap(), Scene((Backlash(),), rates={"h": 1.0}))
    result = sim.run(t_end=0.3, rtol=1e-11, atol=1e-13)
    on, off = (event.t for event in result.events)
    assert on == pytest.approx(0.1, abs=1e-11)
    assert off == pytest.approx(0.1 + math.pi / 20.0, abs=1e-10)
    assert result.u[-1, 0] == pytest.approx(-1.0, abs=1e-10)
    assert np.ptp(result.energy) <= 1e-10 * result.energy[0]


@pytest.mark.parametrize(
    ("fields", "words"),
    [
        ({"restitution": 0.0}, "must be above 0: for a stop without bounce"),
        ({"restitution": 1.5}, "the restitution is 1.5; it must be at most 1"),
        ({"restitution": 0.5, "stiffness": 1.0}, "a limit either bounces or yields"),
        ({"stiffness": 0.0}, "the stiffness is 0 N.m.rad; it must be above 0"),
        ({"stiffness": -1.0}, "the stiffness is -1 N.m.rad; it must be above 0"),
        ({"damping": math.nan}, "the damping is nan"),
        ({"flat_fold": 1}, "flat fold is 1; it must be True or False"),
    ],
)
def test_limits_that_make_no_sense_are_refused(fields: dict[str, Any], words: str) -> None:
    with pytest.raises(lamc.DesignError, match=words):
        JointLimits(**fields)


def test_a_scene_without_limits_has_no_trace_of_them() -> None:
    sim = lamc.compile(flap(), Scene((Torque({"h": TORQUE}),)))
    text = "".join(p.read_text() for p in sorted(sim.source_dir.glob("mechanism.*")))
    assert text
    assert "_limit" not in text
    assert "mechanism_guards" not in text
    assert not {"guards", "impacts"} & set(sim.program.functions)
