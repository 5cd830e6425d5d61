"""Bodies that bend by their own plates: frequencies, statics, stiff limit, energy, convergence, refusals."""

import math
from dataclasses import replace
from importlib.resources import as_file, files
from itertools import pairwise
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest
import shapely
from scipy.optimize import brentq
from shapely.geometry import LineString, box

import lamc
from lamc import (
    Body,
    FlexibleLinks,
    FreeBase,
    GroundContact,
    Joint,
    Mechanism,
    Scene,
    Slab,
    TwistCompliance,
    plate,
)
from lamc.basics.errors import DesignError, LamcError
from lamc.basics.times import Times
from lamc.commands.examples import mechanism_of_example
from lamc.effects import Gravity, HingeStiffness
from lamc.effects.flexible_plates import _on_rim
from lamc.examples import find
from lamc.mechanics.arranging import arrange
from lamc.mechanism.plan import plan
from lamc.readers.load import load_text
from lamc.readers.load_scene import scene_of_text
from tests.support.ctools import needs_cc

Array = npt.NDArray[np.float64]
A, B, T, RHO = 0.1, 0.03, 0.5e-3, 2700.0
SHEET = plate.Laminate([plate.Ply(plate.Material.isotropic(70e9, 0.3, RHO), T)])
MASS = RHO * T * A * B
LOCKED = 1e7  # N·m/rad, beside some 10 of the plates

pytestmark = needs_cc


def scaled(factor: float) -> plate.Laminate:
    return plate.Laminate([plate.Ply(plate.Material.isotropic(factor * 70e9, 0.3, RHO), T)])


def flag(stiffness: float = 0.05, count: int = 1, z: float = 0.0) -> Mechanism:
    """Thin plates in a row along x, hinged along y; thin ones, whose inertia about the middle has no t²."""
    bodies, joints = [Body("ground", fixed=True)], []
    inertia = MASS / 12 * np.diag([B**2, A**2, A**2 + B**2])
    for k in range(count):
        outline = Slab(box(k * A, -B / 2, (k + 1) * A, B / 2), z - T / 2, z + T / 2)
        bodies.append(Body(f"b{k}", MASS, ((k + 0.5) * A, 0.0, z), inertia, outline=(outline,)))
        joints.append(
            Joint(f"h{k}", bodies[-2].name, f"b{k}", (k * A, 0.0, z), (0.0, 1.0, 0.0), stiffness=stiffness)
        )
    return Mechanism(tuple(bodies), tuple(joints))


def simulated(mechanism: Mechanism, effect: FlexibleLinks, *others: Any) -> lamc.Simulator:
    return lamc.compile(mechanism, Scene(effects=(HingeStiffness(), effect, *others)))


def frequencies(sim: lamc.Simulator) -> Array:
    """ω of small vibrations as drawn, rad/s, ascending."""
    still = np.zeros(len(sim.coordinates))
    values = np.linalg.eigvals(-sim.jacobian(still, still)[0])
    assert np.abs(values.imag).max() <= 1e-7 * np.abs(values).max()
    return np.sqrt(np.sort(values.real))


def elements(size: float, loads: tuple[Any, ...] = (), spring: float | None = None) -> plate.Problem:
    """The flag as a plate on its own: clamped, or on its hinge's spring, N·m/rad."""
    end = LineString([(0.0, -B / 2), (0.0, B / 2)])
    held = plate.Clamped(end) if spring is None else plate.Hinged(end, spring / B)
    mesh = plate.mesh(box(0.0, -B / 2, A, B / 2), size, follow=[end])
    return plate.Problem(mesh, SHEET, supports=[held], loads=loads)


# --- against the plate's own finite elements -------------------------------------------------------------------------


def test_a_link_on_a_locked_hinge_has_the_frequencies_of_its_plate() -> None:
    sim = simulated(flag(LOCKED), FlexibleLinks(modes=4, size=6e-3, damping_ratio=0.0, laminate=SHEET))
    expected = plate.modes(elements(6e-3), 4).omega
    # The hinge still gives way by 10 / 1e7 of what the plate does.
    assert frequencies(sim)[:4] == pytest.approx(expected, rel=3e-6)


def test_a_drawn_link_has_the_frequencies_of_its_plate() -> None:
    """The flaps: two materials, a body cut out of layers, the plate without the strip that bends at the hinge."""
    with as_file(files("lamc.examples") / "flaps.yaml") as path:
        design = lamc.load(path)
    mechanism = lamc.split(design)
    held = replace(
        mechanism, joints=tuple(replace(j, stiffness=LOCKED, rest_angle=0.0) for j in mechanism.joints)
    )
    sim = simulated(held, FlexibleLinks(("link_1",), modes=3, size=1e-3, damping_ratio=0.0))
    drawn = plate.plate_of(design, "link_1", hinges="lines")
    line = drawn.hinges["left"].line
    mesh = plate.mesh(drawn.outline, 1e-3, regions=drawn.regions, follow=[line])
    problem = plate.Problem(mesh, drawn.laminates, supports=[plate.Clamped(line)])
    assert [c.name for c in sim.coordinates[2:]] == [f"link_1.mode_{k}" for k in (1, 2, 3, 4)]
    # The other flap is a pendulum on a locked hinge, beyond all of these.
    assert frequencies(sim)[:3] == pytest.approx(plate.modes(problem, 3).omega, rel=1e-5)


@pytest.mark.parametrize("spring", [0.02, 1.0])
@pytest.mark.quick("1.0")
def test_a_link_on_a_spring_tends_to_the_plate_on_it(spring: float) -> None:
    """A floating frame and modes against all of the elements with an elastic hinge: from above, as 1/modes² or faster.
    Statics helps the first: what inertia does in it is nearly what weight does."""
    expected = plate.modes(elements(6e-3, spring=spring), 3).omega
    missed = []
    for modes in (1, 3, 6):
        effect = FlexibleLinks(modes=modes, size=6e-3, damping_ratio=0.0, static=False, laminate=SHEET)
        found = frequencies(simulated(flag(spring), effect))[:2]
        missed.append(np.abs(found / expected[:2] - 1.0).max())
        assert (found >= expected[:2] * (1 - 1e-9)).all()
    assert missed[1] < missed[0] / 9
    assert missed[2] < 2e-3
    with_static = FlexibleLinks(modes=1, size=6e-3, damping_ratio=0.0, laminate=SHEET)
    assert frequencies(simulated(flag(spring), with_static))[0] == pytest.approx(expected[0], rel=2e-3)


def test_finer_meshes_tend_to_one_frequency() -> None:
    """Cells of 3, 5 and 10 to the width; DKT is of second order, with less than 1/10 of h²/b² here."""
    sizes = (10e-3, 6e-3, 3e-3)
    found = [
        frequencies(
            simulated(flag(LOCKED), FlexibleLinks(modes=1, size=s, damping_ratio=0.0, laminate=SHEET))
        )[0]
        for s in sizes
    ]
    for size, omega in zip(sizes, found, strict=True):
        assert abs(omega / found[-1] - 1.0) < 0.1 * (size / B) ** 2
    beam = 1.875104**2 * np.sqrt(70e9 * T**2 / 12 / RHO) / A**2
    assert beam < found[-1] < beam / np.sqrt(1 - 0.3**2)  # it cannot narrow at its clamp


def test_statics_is_the_deflection_of_the_plate() -> None:
    """Under its weight, on a locked hinge, with one mode."""
    g = (0.0, 0.0, -9.81)
    sim = simulated(flag(LOCKED), FlexibleLinks(modes=1, size=6e-3, laminate=SHEET), Gravity(g))
    still = np.zeros(len(sim.coordinates))
    q = np.linalg.solve(sim.jacobian(still, still)[0], -sim.acceleration(still, still))
    bent = arrange(plan(sim.mechanism), sim.effects).flexible[0]
    phi, slopes = bent.shapes(np.array([A, 0.3 * B, 0.0]))
    solution = plate.solve(elements(6e-3, (plate.SelfWeight(g),)))
    assert phi @ q[1:] == pytest.approx(solution.deflection(A, 0.3 * B), rel=1e-6)
    assert (slopes.T @ q[1:])[:2] == pytest.approx(solution.slope(A, 0.3 * B), rel=1e-6)


def test_a_row_of_links_on_locked_hinges_sags_as_one_plate() -> None:
    """Two plates end to end, b = 0.3 of their length, against one of both lengths: beams, but for the curling near the
    clamp and the joint, which stays straight here and does not there."""
    sim = simulated(flag(LOCKED, 2), FlexibleLinks(modes=1, size=6e-3, laminate=SHEET), Gravity((0, 0, -0.1)))
    still = np.zeros(len(sim.coordinates))
    q = np.linalg.solve(sim.jacobian(still, still)[0], -sim.acceleration(still, still))
    one, two = arrange(plan(sim.mechanism), sim.effects).flexible
    k = one.count
    joint, slope = one.shapes(np.array([A, 0.0, 0.0]))
    tip, _ = two.shapes(np.array([2 * A, 0.0, 0.0]))
    found = joint @ q[2 : 2 + k] + A * (slope.T @ q[2 : 2 + k])[0] + tip @ q[2 + k :]
    D = 70e9 * T**3 / 12
    beam = -0.1 * RHO * T * (2 * A) ** 4 / 8 / D
    plate_like = beam * (1 - 0.3**2)
    assert beam < found < plate_like


# --- motion ----------------------------------------------------------------------------------------------------------


def test_stiff_links_are_rigid_ones() -> None:
    """E times 1e6: bending is 1e-6 of what it was, and that was 1e-3 of the motion."""
    scene = Scene(effects=(Gravity(), HingeStiffness()), angles={"h0": 0.4})
    plain = lamc.compile(flag(), scene).run(0.5, t_eval=[0.25, 0.5])
    effect = FlexibleLinks(modes=2, size=1e-2, damping_ratio=0.5, laminate=scaled(1e6))
    stiff = lamc.compile(flag(), replace(scene, added=(effect,)))
    result = stiff.run(0.5, rtol=1e-8, atol=1e-10, t_eval=[0.25, 0.5], integrator="radau5")
    assert result.success, result.message
    assert result.angle("h0") == pytest.approx(plain.angle("h0"), abs=1e-6)


@pytest.mark.slow
def test_energy_is_kept_by_modes_and_lost_by_their_damping() -> None:
    scene = Scene(effects=(Gravity(), HingeStiffness()), angles={"h0": 0.4}, rates={"h0": 10.0, "h1": -20.0})
    kept, lost = (
        lamc.compile(
            flag(count=2),
            replace(scene, added=(FlexibleLinks(modes=2, size=1e-2, damping_ratio=ratio, laminate=SHEET),)),
        ).run(0.02, rtol=1e-10, atol=1e-13)
        for ratio in (0.0, 0.02)
    )
    scale = float(np.ptp(kept.energies["kinetic"]))
    assert kept.energies["flexible_links"].max() > 1e-4 * scale
    assert np.abs(kept.energy - kept.energy[0]).max() <= 1e-8 * scale
    assert (np.diff(lost.energy) <= 1e-10 * scale).all()
    assert lost.energy[-1] < lost.energy[0]
    assert FlexibleLinks(damping_ratio=0.0).conservative
    assert not FlexibleLinks().conservative


@pytest.mark.slow
def test_energy_balance_close_with_yielding_hinges_on_a_floating_base() -> None:
    """Work of all effects is what the motion has; modes lose what their damping takes, strips without it keep all."""
    made = flag(count=2)
    hub = replace(made.bodies[0], mass=0.01, inertia=1e-5 * np.eye(3))
    strips = TwistCompliance(width=1e-3, length=B, thickness=1e-4, E=2.5e9, nu=0.34)
    bending = FlexibleLinks(modes=1, size=1e-2, damping_ratio=0.02, static=False, laminate=SHEET)
    scene = Scene(
        effects=(Gravity(), HingeStiffness(), strips, bending, FreeBase()), rates={"h0": 10.0, "h1": -20.0}
    )
    sim = lamc.compile(replace(made, bodies=(hub, *made.bodies[1:])), scene)
    energy_balance = sim.run(0.01, rtol=1e-10, atol=1e-13, energy_balance=True).energy_balance
    assert energy_balance is not None
    assert (
        np.abs(energy_balance.residual).max() <= 1e-10 * energy_balance.scale
    )  # the work is integrated with the motion, at rtol
    assert energy_balance.supplied["flexible_links"][-1] < -1e-5 * energy_balance.scale
    for conservative in ("gravity", "hinge_stiffness", "twist_compliance"):
        assert np.abs(energy_balance.supplied[conservative]).max() <= 1e-10 * energy_balance.scale


@pytest.mark.slow
def test_other_forms_have_the_frequencies_that_more_modes_and_finer_meshes_give() -> None:
    """Without static shapes, modes are nested: the lowest of one is among those of three. On cells of twice and of half
    the size, frequencies are those of the plate's own elements of that size."""
    effect = FlexibleLinks(size=1e-2, static=False, laminate=SHEET)
    forms = effect.alternatives()
    assert list(forms) == ["1 mode", "6 modes", "coarser mesh", "finer mesh"]
    mechanism = flag(LOCKED)
    three = frequencies(simulated(mechanism, effect))[:3]
    one, six = (frequencies(simulated(mechanism, forms[name])) for name in ("1 mode", "6 modes"))
    assert one[0] == pytest.approx(three[0], rel=3e-6)  # the hinge still gives way by 10 / 1e7
    assert six[:3] == pytest.approx(three, rel=3e-6)
    for name, size in (("coarser mesh", 2e-2), ("finer mesh", 5e-3)):
        expected = plate.modes(elements(size), 3).omega
        assert frequencies(simulated(mechanism, forms[name]))[:3] == pytest.approx(expected, rel=3e-6)


@pytest.mark.slow
def test_a_sagging_link_rests_on_the_ground_at_its_tip() -> None:
    """A propped cantilever: ground half as deep as the tip sags, where a rigid link would not come. The prop bears
    R = k (sag - gap) with the tip's k, which is 3 E I / L³ of a beam, and of a plate that stays flat across up to
    1 / (1 - ν²) as much; what sagging does at the prop pushes the modes, or there would be another R."""
    bending = FlexibleLinks(modes=6, size=6e-3, damping_ratio=0.2, static=False, laminate=SHEET)
    scene = Scene(effects=(HingeStiffness(), Gravity(), bending))
    hanging = lamc.compile(flag(LOCKED), scene)
    sag = -tip(hanging, hanging.run(1.0, rtol=1e-8, atol=1e-12, integrator="radau5"))
    beam = RHO * 9.81 * T * A**4 / (8 * 70e9 * T**3 / 12)
    assert (1 - 0.3**2) * beam < sag < beam
    height, k = -T / 2 - sag / 2, 1e7  # N/m^1.5: sinks in by some 1e-6 m, beside a gap of 1e-4
    ground = GroundContact(height=height, stiffness=k, friction=0.0)
    sim = lamc.compile(flag(LOCKED), replace(scene, added=(ground,)))
    rest = sim.run(1.0, rtol=1e-8, atol=1e-12, integrator="radau5", energy_balance=True)
    assert rest.success
    assert np.abs(rest.u[-1]).max() < 1e-6
    depth = (height + T / 2) - tip(sim, rest)
    pushed = 2 * k * depth**1.5  # of the two lower corners at the tip
    assert 0.0 < depth < 1e-5
    stiffness = pushed / (sag - (sag / 2 + depth))
    plain = 3 * 70e9 * B * T**3 / 12 / A**3
    assert plain < stiffness < plain / (1 - 0.3**2)
    assert rest.energy_balance is not None
    assert rest.energy_balance.balance < 1e-8
    assert rest.energy_balance.supplied["ground_contact"][-1] < 0.0


def tip(sim: lamc.Simulator, result: lamc.Result) -> float:
    """Height of the corners of the flag's end over where they are drawn, m, at the end of a run."""
    (body,) = arrange(plan(sim.mechanism), sim.effects).flexible
    shapes = np.array([body.shape_at(np.array([A, side * B / 2, 0.0]))[0] for side in (-1, 1)])
    heights = shapes @ result.q[-1, 1:] - A * np.sin(result.q[-1, 0])  # a turn about y lowers x
    assert heights[0] == pytest.approx(heights[1], rel=1e-2)  # on a mesh that is not quite symmetric
    return float(heights.mean())


@pytest.mark.slow
def test_what_floats_and_bends_falls_on_the_ground_with_its_energy_balance_in_order() -> None:
    """The crawler thrown on the ground: contact and modes only take energy, and what acts adds up."""
    with as_file(files("lamc.examples") / "crawler.yaml") as path:
        mechanism = lamc.split(lamc.load(path))
    drop = mechanism.scenes["drop"]
    bending = FlexibleLinks(modes=1, damping_ratio=0.02)
    sim = lamc.compile(mechanism, replace(drop, added=(*drop.added, bending)))
    result = sim.run(0.2, rtol=1e-8, atol=1e-11, integrator="rodas5p", energy_balance=True)
    energy_balance = result.energy_balance
    assert energy_balance is not None
    assert result.events  # it has touched the ground
    assert energy_balance.balance < 1e-8
    for effect in ("ground_contact", "flexible_links"):
        assert energy_balance.supplied[effect][-1] < -1e-6 * energy_balance.scale
        assert np.diff(energy_balance.supplied[effect]).max() <= 1e-9 * energy_balance.scale
    assert np.abs(energy_balance.supplied["gravity"]).max() <= 1e-9 * energy_balance.scale


def test_steps_stay_affordable() -> None:
    """Damped links, highest mode some 5 kHz, half a second of a swing at 4 Hz: the implicit methods step over them."""
    scene = Scene(effects=(Gravity(), HingeStiffness()), angles={"h0": 0.4})
    sim = lamc.compile(flag(), replace(scene, added=(FlexibleLinks(modes=3, size=1e-2, laminate=SHEET),)))
    implicit, chosen = (sim.run(1.0, rtol=1e-4, atol=1e-6, integrator=name) for name in ("radau5", "auto"))
    fastest = float(frequencies(replace_damping(sim))[-1])
    assert implicit.success
    assert chosen.success
    assert implicit.stats.steps < fastest * 1.0 / 10  # an explicit one takes a step for every 3 of ω t, or so
    assert chosen.stats.integrator.split(", ")[-1] in ("rodas5p", "radau5")


def replace_damping(sim: lamc.Simulator) -> lamc.Simulator:
    (effect,) = (e for e in sim.effects if isinstance(e, FlexibleLinks))
    return simulated(sim.mechanism, replace(effect, damping_ratio=0.0))


def test_what_is_made_of_something_else_is_compiled_anew() -> None:
    first, second = (
        simulated(flag(), FlexibleLinks(modes=1, size=1e-2, laminate=sheet)) for sheet in (SHEET, scaled(2.0))
    )
    names = [n for n in first.parameters if "modal_stiffness" in n]
    assert names
    for name in names:
        assert second.parameters[name] == pytest.approx(2.0 * first.parameters[name], rel=1e-9)
    times = Times()
    scene = Scene(effects=(HingeStiffness(), FlexibleLinks(modes=1, size=1e-2, laminate=SHEET)))
    lamc.compile(flag(), scene, times=times)
    assert times.from_cache


# --- files and refusals ----------------------------------------------------------------------------------------------


def test_a_scene_file_gives_it_with_units() -> None:
    text = """
    effects:
      flexible_links:
        bodies: [b0]
        modes: 2
        size: 10 mm
        damping_ratio: 0.02
        laminate: [{material: {E: 70 GPa, nu: 0.3, density: 2700 kg/m^3}, thickness: 0.5 mm}]
    """
    (effect,) = scene_of_text(text, "scene.yaml").effects or ()
    assert isinstance(effect, FlexibleLinks)
    assert replace(effect, laminate=None) == FlexibleLinks(("b0",), 2, 0.02, 0.01)
    assert pytest.approx(SHEET.D) == effect.laminate.D
    assert effect.laminate.areal_mass == pytest.approx(SHEET.areal_mass)


def asked(mechanism: Mechanism, **fields: Any) -> object:
    return arrange(plan(mechanism), (FlexibleLinks(**{"laminate": SHEET} | fields),))


def bare() -> Mechanism:
    made = flag()
    return replace(made, bodies=tuple(replace(b, outline=()) for b in made.bodies))


def upright() -> Mechanism:
    made = flag()
    return replace(made, joints=tuple(replace(j, axis=(0.0, 0.0, 1.0)) for j in made.joints))


def off() -> Mechanism:
    made = flag()
    return replace(made, joints=tuple(replace(j, point=(-0.02, 0.0, 0.0)) for j in made.joints))


HEAVY = plate.Laminate([plate.Ply(plate.Material.isotropic(70e9, 0.3, 2 * RHO), T)])
BAD = {
    "modes: it is 0; it must be at least 1": lambda: FlexibleLinks(modes=0),
    "modes is 2.5; it must be a whole number": lambda: FlexibleLinks(modes=2.5),  # type: ignore[arg-type]
    r"bodies are \(\)": lambda: FlexibleLinks(()),
    "bodies have 'a' twice": lambda: FlexibleLinks(("a", "a")),
    "the damping ratio is -0.1; it must be at least 0": lambda: FlexibleLinks(damping_ratio=-0.1),
    "the size is 0 m; it must be above 0": lambda: FlexibleLinks(size=0.0),
    "no body is named 'b9'; known are b0": lambda: asked(flag(), bodies=("b9",)),
    "body 'ground' is fixed": lambda: asked(flag(), bodies=("ground",)),
    "what body 'b0' is made of is not known.*give its laminate": lambda: asked(flag(), laminate=None),
    "body 'b0' has no outline": lambda: asked(bare()),
    "hinge 'h0' of body 'b0' does not lie in the plane": lambda: asked(upright()),
    "no edge of the outline of body 'b0' lies on the line of hinge 'h0'": lambda: asked(off()),
    "weighs 0.0081 kg, more than the body": lambda: asked(flag(), laminate=HEAVY),
    "the refinement is 0; it must be above 0": lambda: FlexibleLinks(refinement=0.0),
    "element": lambda: asked(flag(), element="dktt", size=1e-2),
}


@pytest.mark.parametrize("message", BAD)
def test_what_cannot_be_is_refused_by_name(message: str) -> None:
    with pytest.raises(DesignError, match=message):
        BAD[message]()


def test_a_drawn_body_without_moduli_is_refused_with_the_way_out() -> None:
    """The four-bar's tape has none, and its shelf is made of it in part."""
    with as_file(files("lamc.examples") / "four_bar.yaml") as path:
        mechanism = lamc.split(lamc.load(path))
    with pytest.raises(DesignError, match=r"body 'shelf' is no plate here: moduli are needed .*'foam_tape'"):
        arrange(plan(mechanism), (FlexibleLinks(("shelf",)),))


@pytest.mark.slow
def test_two_links_of_many_modes_have_exact_derivatives() -> None:
    """19 rates: the runtime factors M, so that the Jacobian is worth its operations."""
    sim = simulated(flag(count=2), FlexibleLinks(modes=6, laminate=SHEET))
    assert "jacobian" in sim.program.functions
    rng = np.random.default_rng(3)
    q, u = 1e-3 * rng.standard_normal(len(sim.coordinates)), 1e-2 * rng.standard_normal(len(sim.rates))
    by_q, by_u = sim.jacobian(q, u)
    dq, du = 1e-3 * rng.standard_normal(len(q)), 1e-2 * rng.standard_normal(len(u))
    h = 1e-3
    ahead, behind = (sim.acceleration(q + s * dq, u + s * du) for s in (h, -h))
    found, expected = by_q @ dq + by_u @ du, (ahead - behind) / (2 * h)
    # central differences: h² of the change, and round-off of 1e-16 |a| / h
    assert np.abs(found - expected).max() <= 1e-5 * np.abs(expected).max()


STRIP = """
units: mm
materials:
  steel: {density: 7850, E1: 200 GPa, poisson: 0.0, rigid: true}
  film: {density: 1390, E1: 2.5 GPa, poisson: 0.34, flexible: true}
layers:
  - {name: a, material: steel, thickness: 0.05}
  - {name: f, material: film, thickness: 0.025}
  - {name: b, material: steel, thickness: 0.05}
shapes: [{rect: [-10, 0, 80, 10]}]
hinges: [{name: root, line: [[0, 0], [0, 10]], layer: f, gap: 0.2, stiffness: 0.2 N*m/rad}]
fixed: [{rect: [-10, 0, -3, 10]}]
scene: {without: gravity, with: {flexible_links: {modes: MODES, damping_ratio: 0}}}
"""


def test_modes_above_what_the_shapes_reach_are_told() -> None:
    """Of two shapes the third mode is 5 % too high, and the fourth none of the strip's: by Euler's and Bernoulli's beam
    on a spring, w = a sin + b cos + c sinh + d cosh of βx with w(0) = 0, EI w''(0) = k w'(0), free at its end."""
    steel, film = (200e9, 7850.0, 50e-6), (2.5e9, 1390.0, 25e-6)
    mass = 2.0 * steel[1] * steel[2] + film[1] * film[2]
    outer = 0.5 * film[2] + steel[2]
    bending = (
        2.0 / 3.0 * steel[0] * (outer**3 - (0.5 * film[2]) ** 3)
        + film[0] / (1.0 - 0.34**2) * film[2] ** 3 / 12.0
    )
    length, spring = 79.9e-3, 0.2 / 10e-3

    def open_by(beta: float) -> float:
        x = beta * length
        rows = [  # of a, c, d, as b = -d
            [spring, spring, -2.0 * bending * beta],
            [-math.sin(x), math.sinh(x), math.cosh(x) + math.cos(x)],
            [-math.cos(x), math.cosh(x), math.sinh(x) - math.sin(x)],
        ]
        return float(np.linalg.det(rows))

    grid = np.linspace(0.1, 20.0, 4000) / length
    roots = [brentq(open_by, a, b) for a, b in pairwise(grid) if open_by(a) * open_by(b) < 0.0]
    exact = np.array(roots) ** 2 * math.sqrt(bending / mass) / (2.0 * math.pi)
    # The fourth of six shapes twists the strip, which no beam does.
    for count, known, told in (
        (2, [0, 1], "modes 3 to 4 are above 108"),
        (6, [0, 1, 2, 4], "modes 7 to 8 are above"),
    ):
        modes = lamc.compile(load_text(STRIP.replace("MODES", str(count)), "strip")).modes()
        found = modes.frequencies[known]
        assert found == pytest.approx(exact[: len(known)], rel=0.01)  # of cells, and of the gap
        assert len(modes.notes) == 1
        assert modes.notes[0].startswith(told)


@pytest.mark.parametrize("name", ["miura", "yoshimura", "waterbomb"])
def test_facets_with_oblique_hinges_bend(name: str) -> None:
    """Regions of a plate lie on a grid, and its hinge lines do not: an oblique one had been refused, as outside."""
    mechanism = mechanism_of_example(find(name))
    tree = plan(mechanism)
    oblique = [
        link.body.name for link in tree.links if min(abs(link.joint.axis[0]), abs(link.joint.axis[1])) > 0.1
    ]
    for _, bent, reduced in lamc.FlexibleLinks(bodies=oblique[:1]).reductions(tree):
        apart = shapely.distance(shapely.points(shapely.get_coordinates(bent.clamped)), bent.outline.boundary)
        assert apart.max() <= 1e-10  # m: the grid that regions lie on
        hinge = next(link.joint for link in tree.links if link.body.name == oblique[0])
        arms = shapely.get_coordinates(bent.clamped) - hinge.point[:2]
        across = np.abs(arms[:, 0] * hinge.axis[1] - arms[:, 1] * hinge.axis[0])
        assert across.max() <= 2e-3 + 1e-10  # m: half of the widest gap of these examples, and the grid
        assert bent.clamped.length > 0.5 * bent.outline.length / len(shapely.get_coordinates(bent.outline))
        assert (reduced.omega[: reduced.natural] > 0.0).all()


@pytest.mark.parametrize(
    ("line", "found"),
    [
        (LineString([(3e-11, -2e-11), (1.0, 3e-11)]), LineString([(0.0, 0.0), (1.0, 0.0)])),
        (LineString([(1.0, 0.2), (1.0, 0.6)]), LineString([(1.0, 0.2), (1.0, 0.6)])),
        (LineString([(0.0, 0.0), (1.0, 0.0), (1.0, 0.5)]), LineString([(0.0, 0.0), (1.0, 0.0), (1.0, 0.5)])),
        (LineString([(0.2, 0.2), (0.4, 0.3)]), LineString([(0.2, 0.2), (0.4, 0.3)])),
        (LineString(), LineString()),
    ],
)
def test_an_edge_is_the_sides_of_the_outline_or_stays(line: LineString, found: LineString) -> None:
    """A whole side; a part of one; a side and a part of the next; a line within; none, which is told later."""
    assert _on_rim(line, box(0.0, 0.0, 1.0, 1.0), 1e-10).equals(found)


def test_a_facet_that_falls_into_pieces_is_refused_by_its_name() -> None:
    mechanism = mechanism_of_example(find("kresling"))
    with pytest.raises(LamcError, match=r"flexible_links: the plate of body 'f0_0b' cannot be reduced"):
        lamc.compile(mechanism, lamc.Scene(added=[lamc.FlexibleLinks()]))
