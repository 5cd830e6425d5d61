"""Piezo benders against closed forms, lamc's plates of the same laminate, and the gradient of their energy."""

import json
import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
import shapely

import lamc
from lamc import plate
from lamc.basics.errors import DesignError, ExpressionError
from lamc.effects import Gravity, PiezoBender
from lamc.readers.load_scene import scene_of_text
from lamc.readers.scene_writer import scene_data
from lamc.records.mechanism import Body, Joint, Mechanism
from lamc.records.scene import Scene
from lamc.reference.interpreter import Interpreter
from tests.support.ctools import needs_cc
from tests.support.every_effect import SAMPLES, mechanism
from tests.support.mechanisms import chain, random_state

H, L, W = 127e-6, 10e-3, 2e-3  # m: thickness of a ply, length, width
Y, D31 = 62e9, -190e-12  # Pa, m/V
PIEZO = plate.Material(Y, Y, 0.31, Y / 2.62, 7800.0, d31=D31, d32=D31)
BIMORPH = plate.Laminate([plate.Ply(PIEZO, H), plate.Ply(PIEZO, H)])


def bender(laminate: Any = BIMORPH, polarity: Any = (1.0, -1.0), **changes: Any) -> PiezoBender:
    """From the wall at the origin along x, pushing the flap up."""
    given = {
        "body_a": "wall",
        "root": (0.0, 0.0, 0.0),
        "body_b": "flap",
        "tip": (L, 0.0, 0.0),
        "normal": (0.0, 0.0, 2.0),
        "width": W,
        "laminate": laminate,
        "polarity": polarity,
        "voltage": 100.0,
    }
    return PiezoBender(**{**given, **changes})


# ---- closed forms ---------------------------------------------------------------------------------------------


def test_a_bimorph_is_that_of_smits_and_choi() -> None:
    """Two plies of thickness h, field V/h in opposite directions: tip deflection 3 d31 L² V / (4 h²), compliance
    s11 L³ / (2 w h³) (Smits & Choi 1991, cantilever; theirs has V across both plies, so half the field)."""
    line = bender().line
    # lamc's z points from the first ply to the second; where the lower ply shortens, the tip goes down
    deflection = 3.0 * D31 * L**2 / (4.0 * H**2)
    assert line.deflection_per_volt == pytest.approx(deflection, rel=1e-13)  # a few operations
    assert line.stiffness == pytest.approx(2.0 * Y * W * H**3 / L**3, rel=1e-13)
    assert line.force_per_volt == pytest.approx(3.0 * D31 * Y * W * H / (2.0 * L), rel=1e-13)
    series = bender(polarity=(0.5, -0.5)).line
    assert series.deflection_per_volt == pytest.approx(3.0 * D31 * L**2 / (8.0 * H**2), rel=1e-13)


@pytest.mark.parametrize(("n", "m"), [(2.9, 0.4), (0.1, 1.0), (1.0, 3.0)])
def test_a_unimorph_bends_as_timoshenkos_bimetal(n: float, m: float) -> None:
    """κ = 6 Δε (1 + m)² / (h (3 (1 + m)² + (1 + m n)(m² + 1/(m n)))) with m, n thickness and modulus of the passive ply
    over those of the active one; exact for plates that are free to bend both ways, for equal Poisson's ratios
    (Timoshenko, J. Opt. Soc. Am. 11 (1925) 233-255, eq. 4)."""
    passive = plate.Material(n * Y, n * Y, 0.31, n * Y / 2.62, 8000.0)
    laminate = plate.Laminate([plate.Ply(passive, m * H), plate.Ply(PIEZO, H)])
    total = H * (1.0 + m)
    strain = D31 / H  # per volt
    curvature = 6.0 * strain * (1.0 + m) ** 2
    curvature /= total * (3.0 * (1.0 + m) ** 2 + (1.0 + m * n) * (m * m + 1.0 / (m * n)))
    # a shorter upper ply lifts the tip
    assert bender(laminate, (0.0, 1.0)).line.deflection_per_volt == pytest.approx(
        -0.5 * curvature * L**2, rel=1e-12
    )


def test_a_stiff_end_moves_with_the_slope_of_the_strip() -> None:
    """Tip deflection κ (L²/2 + L e); compliance (L³/3 + L² e + L e²)/EI, by moment areas."""
    e = 4e-3
    plain, longer = bender().line, bender(tip=(L + e, 0.0, 0.0), extension=e).line
    curvature = 2.0 * plain.deflection_per_volt / L**2
    rigidity = plain.stiffness * L**3 / 3.0
    assert longer.deflection_per_volt == pytest.approx(curvature * (0.5 * L * L + L * e), rel=1e-13)
    assert 1.0 / longer.stiffness == pytest.approx((L**3 / 3 + L * L * e + L * e * e) / rigidity, rel=1e-13)


# ---- the plate solver on the same strip -------------------------------------------------------------------------


def by_plate(
    laminate: plate.Laminate, fields: tuple[float, ...], width: float, cells: int
) -> tuple[float, float]:
    """(deflection of the free tip, m; compliance, m/N) of the strip by plate finite elements, clamped at x = 0."""
    mesh = plate.grid(L, width, 10 * cells, cells)
    root = plate.Clamped(shapely.LineString([(0, 0), (0, width)]))
    end = shapely.LineString([(L, 0), (L, width)])
    free = plate.Problem(mesh, laminate, supports=[root], loads=[plate.ElectricField(fields)])
    pushed = plate.Problem(mesh, laminate, supports=[root], loads=[plate.EdgeLoad(end, 1.0 / width)])
    places = np.linspace(0.0, width, 5)
    return tuple(float(np.mean([plate.solve(p).deflection(L, y) for y in places])) for p in (free, pushed))  # type: ignore[return-value]


def test_the_plate_solver_gives_the_same_without_poissons_ratio() -> None:
    """With ν = 0 and d32 = 0 nothing bends across, so the plate is the beam, to the plate's discretisation."""
    material = plate.Material(Y, Y, 0.0, Y / 2.0, 7800.0, d31=D31)
    steel = plate.Material(2e11, 2e11, 0.0, 1e11, 7900.0)
    laminate = plate.Laminate([plate.Ply(material, H), plate.Ply(steel, 50e-6), plate.Ply(material, 2 * H)])
    line = bender(laminate, (1.0, 0.0, -0.7)).line
    free, compliance = by_plate(laminate, (1.0 / H, 0.0, -0.7 / (2 * H)), W, 4)
    assert free == pytest.approx(
        line.deflection_per_volt, rel=1e-6
    )  # constant curvature, which elements hold
    assert 1.0 / compliance == pytest.approx(line.stiffness, rel=2e-3)  # linear curvature, h² of 40 cells


def test_a_narrow_strip_goes_to_the_beam() -> None:
    """The clamp holds the strip from bending across over some widths; the rest is the beam's."""
    line = bender().line
    errors = []
    for width in (2e-3, 0.5e-3):
        free, _ = by_plate(BIMORPH, (1.0 / H, -1.0 / H), width, 4)
        errors.append(abs(free / line.deflection_per_volt - 1.0))
    assert errors[0] < 0.08
    assert errors[1] < 0.4 * errors[0]  # the disturbed length is proportional to the width


# ---- in a mechanism ---------------------------------------------------------------------------------------------


def flap_at_the_tip(**joint: float) -> Mechanism:
    """A flap hinged 5 mm beyond the bender's tip, about y; its edge lies on the tip."""
    flap = Body("flap", 2e-6, (L + 2.5e-3, 0.0, 0.0), np.diag([1e-12, 6e-12, 6e-12]))
    hinge = Joint("hip", "wall", "flap", point=(L + 5e-3, 0.0, 0.0), axis=(0.0, -1.0, 0.0), **joint)  # type: ignore[arg-type]
    return Mechanism((Body("wall", fixed=True), flap), (hinge,))


@needs_cc
def test_a_blocked_tip_feels_the_blocked_force() -> None:
    effect = bender()
    arm, inertia = (
        -5e-3,
        6e-12 + 2e-6 * 2.5e-3**2,
    )  # of the tip about the hinge, whose axis -y lifts what is beyond it
    sim = lamc.compile(flap_at_the_tip(), Scene(effects=(effect,)))
    push = effect.line.force_per_volt * 100.0
    assert sim.acceleration([0.0], [0.0])[0] == pytest.approx(push * arm / inertia, rel=1e-13)
    assert sim.parameters["piezo_bender.wall.flap.voltage"] == 100.0
    for name in ("stiffness", "force_per_volt"):
        assert sim.parameters[f"piezo_bender.wall.flap.{name}"] == getattr(effect.line, name)


@needs_cc
def test_a_free_tip_comes_to_rest_at_the_free_deflection() -> None:
    effect = bender()
    sim = lamc.compile(flap_at_the_tip(damping=3e-8), Scene(effects=(effect, lamc.HingeDamping())))
    angle = float(sim.run(t_end=1.0, t_eval=[1.0], rtol=1e-10, atol=1e-13).angle("hip")[0])
    lift = -5e-3 * math.sin(angle)
    assert lift == pytest.approx(100.0 * effect.line.deflection_per_volt, rel=1e-6)  # the swing has died away
    assert float(sim.run(t_end=1.0, t_eval=[1.0]).energies["piezo_bender"][0]) == pytest.approx(
        0.0, abs=1e-15
    )


@needs_cc
def test_work_of_the_drive_is_all_that_changes_the_energy() -> None:
    """d(kinetic + stored)/dt = F · d(free deflection)/dt, from the rows alone."""
    effect = bender(voltage="80*sin(900*t)")
    line = effect.line
    sim = lamc.compile(flap_at_the_tip(), Scene(effects=(effect,)))
    t = np.linspace(0.0, 0.02, 8001)
    result = sim.run(t_end=0.02, t_eval=t, rtol=1e-10, atol=1e-13)
    voltage, slope = 80.0 * np.sin(900.0 * t), 80.0 * 900.0 * np.cos(900.0 * t)
    lift = -5e-3 * np.sin(result.angle("hip"))
    power = (line.force_per_volt * voltage - line.stiffness * lift) * line.deflection_per_volt * slope
    simpson = np.ones(len(t))
    simpson[1:-1:2], simpson[2:-1:2] = 4.0, 2.0
    work = (t[1] - t[0]) / 3.0 * float(simpson @ power)
    scale = float(np.abs(result.energy).max())
    assert scale > 1e-9
    # Simpson's rule at 2.5 µs for swings of 1 ms: (2π/400)⁴ / 180 of the power's size, and rtol times the steps
    assert result.energy[-1] - result.energy[0] == pytest.approx(work, abs=1e-6 * scale)


@needs_cc
@pytest.mark.parametrize("seed", range(4))
@pytest.mark.quick("0", others="campaign")
def test_its_forces_are_the_gradient_of_its_energy_between_moving_bodies(seed: int) -> None:
    """Between two links in space: M (u̇ with - u̇ without) = -∂W/∂q, W from the bodies' poses alone."""
    mechanism = chain(3, "space", seed=seed)
    rng = np.random.default_rng(seed)
    root, along, other = rng.normal(size=(3, 3))
    normal = np.cross(along, other)
    effect = bender(
        body_a="body0",
        root=tuple(root),
        body_b="body2",
        tip=tuple(root + along),
        normal=tuple(normal),
        width=0.3,
    )
    line = effect.line
    k, free = 3.0, 0.2  # N/m, m: of the size of the mechanism
    parameters = {
        "piezo_bender.body0.body2.stiffness": k,
        "piezo_bender.body0.body2.force_per_volt": k * free,
        "piezo_bender.body0.body2.voltage": 1.0,
    }
    bent = lamc.compile(mechanism, Scene(effects=(effect,)))
    bare = lamc.compile(mechanism, Scene(effects=()))
    interpreter = Interpreter(bare.program)
    constants = interpreter.constants()
    drawn = {body.name: body.com for body in mechanism.bodies}

    def stored(q: Any) -> float:
        coms, rotations = interpreter.poses(q, constants)
        at = {n: (coms[i], rotations[i]) for i, n in enumerate(interpreter.bodies)}
        ends = [at[n][0] + at[n][1] @ (root + along - drawn[n]) for n in ("body0", "body2")]
        up = at["body0"][1] @ (normal / np.linalg.norm(normal))
        return 0.5 * k * float(up @ (ends[1] - ends[0]) - free) ** 2

    q, u = random_state(3, seed)
    difference = bent.acceleration(q, u, 0.0, parameters) - bare.acceleration(q, u)
    mass = np.zeros((3, 3))
    mass[np.tril_indices(3)] = interpreter._evaluate("inertia", 0.0, q, u, constants)
    mass += np.tril(mass, -1).T
    step = 1e-5
    gradient = [(stored(q + d) - stored(q - d)) / (2 * step) for d in step * np.eye(3)]
    # differences of second order: step² times third derivatives of some N·m, and round-off / step
    assert mass @ difference == pytest.approx(-np.array(gradient), abs=1e-8)
    assert line.stiffness > 0.0


@needs_cc
def test_several_benders_act_and_energy_is_kept_under_constant_voltage() -> None:
    pair = (bender(), bender(normal=(0.0, 0.0, -1.0), voltage=30.0))
    sim = lamc.compile(flap_at_the_tip(), Scene(effects=(*pair, Gravity()), angles={"hip": 0.1}))
    assert "piezo_bender.wall.flap.2.voltage" in sim.parameters
    result = sim.run(t_end=0.05, rtol=1e-10, atol=1e-12)
    # rtol times some hundred steps
    assert result.energy == pytest.approx(result.energy[0], rel=1e-7)


# ---- across a hinge ---------------------------------------------------------------------------------------------


def folded(distance: float, *, turned: bool = False) -> tuple[Mechanism, PiezoBender]:
    """A flap whose hinge line lies under the strip, at a distance from its tip, with axis +y; `turned`: drawn from the
    flap to the wall."""
    flap = Body("flap", 2e-6, (L + 2.5e-3, 0.0, 0.0), np.diag([1e-12, 6e-12, 6e-12]))
    ends = ("flap", "wall") if turned else ("wall", "flap")
    hinge = Joint("fold", *ends, point=(L - distance, 0.0, 0.0), axis=(0.0, 1.0, 0.0))
    return Mechanism((Body("wall", fixed=True), flap), (hinge,)), bender(hinge="fold", normal=(0.0, 0.0, 1.0))


@pytest.mark.parametrize(("share", "factor"), [(0.0, 4.0), (0.5, 1.0), (1.0, 4.0), (0.25, 1.75)])
def test_a_strip_across_a_hinge_is_as_stiff_as_a_clamped_beam(share: float, factor: float) -> None:
    """4 EI/L where the hinge line lies at an end, EI/L in the middle: rotation of a beam's clamp, uniform bending."""
    mechanism, effect = folded(share * L)
    rigidity = effect.line.stiffness * L**3 / 3.0
    stiffness, per_volt = effect.across(mechanism.joints[0])
    assert stiffness == pytest.approx(factor * rigidity / L, rel=1e-13)
    # where the lower ply shortens the flap folds down, positive about +y: by the moment EI κ, wherever the line is
    assert per_volt == pytest.approx(-rigidity * 2.0 * effect.line.deflection_per_volt / L**2, rel=1e-13)


@needs_cc
@pytest.mark.parametrize("turned", [False, True])
def test_a_strip_across_a_hinge_folds_it_to_its_free_curvature(turned: bool) -> None:
    """In the middle of the strip the hinge settles at κ L, to the side of the ply that shortens."""
    mechanism, effect = folded(0.5 * L, turned=turned)
    damped = [Joint(j.name, j.parent, j.child, j.point, j.axis, damping=2e-6) for j in mechanism.joints]
    scene = Scene(effects=(effect, lamc.HingeDamping()))
    result = lamc.compile(Mechanism(mechanism.bodies, tuple(damped)), scene).run(t_end=1.0, t_eval=[1.0])
    curvature = -2.0 * effect.line.deflection_per_volt / L**2 * 100.0
    assert curvature > 0.0  # d31 is negative: the lower ply shortens
    angle = -curvature * L if turned else curvature * L
    assert result.angle("fold")[0] == pytest.approx(angle, rel=1e-6)  # the swing has died away
    assert result.energies["piezo_bender"][0] == pytest.approx(0.0, abs=1e-15)
    assert float(result.pose("flap")[0][0][2]) < 0.0


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"point": (2 * L, 0.0, 0.0)}, "not crossed by the hinge line"),
        ({"axis": (1.0, 0.0, 0.0)}, "not crossed by the hinge line at right angles"),
        ({"axis": (0.0, 0.0, 1.0)}, "not crossed"),
    ],
)
def test_a_hinge_that_does_not_cross_the_strip_is_refused(change: dict[str, Any], words: str) -> None:
    given = {"point": (0.5 * L, 0.0, 0.0), "axis": (0.0, 1.0, 0.0)}
    with pytest.raises(DesignError, match=words):
        bender(hinge="fold").across(Joint("fold", "wall", "flap", **{**given, **change}))
    with pytest.raises(DesignError, match="the hinge joins 'a' and 'b'; name these"):
        bender(hinge="fold").across(Joint("fold", "a", "b"))
    with pytest.raises(DesignError, match="set the extension to 0"):
        bender(hinge="fold", extension=1e-3)


# ---- files and refusals -----------------------------------------------------------------------------------------

DATA = {
    "body_a": "wall",
    "root": [0, 0, 0],
    "body_b": "flap",
    "tip": ["10 mm", 0, 0],
    "normal": [0, 0, 1],
    "width": "2 mm",
    "laminate": [
        {"material": "PZT-5H", "thickness": "127 um"},
        {"material": {"E": "200 GPa", "nu": 0.3}, "thickness": "50 um"},
        {
            "material": {"E1": "62 GPa", "E2": "62 GPa", "nu12": 0.31, "G12": "24 GPa", "d31": "-190 pm/V"},
            "thickness": "127 um",
            "angle": "90 deg",
        },
    ],
    "polarity": [1, 0, -1],
    "voltage": "100*sin(2*pi*50*t)",
}


def read(data: object) -> Scene:
    return scene_of_text(json.dumps({"effects": {"piezo_bender": data}}), "scene.yaml")


def test_scene_files_give_benders_and_take_them_back() -> None:
    scene = read(DATA)
    assert scene.effects is not None
    (effect,) = scene.effects
    assert isinstance(effect, PiezoBender)
    steel = plate.Material(200e9, 200e9, 0.3, 200e9 / 2.6, 0.0)
    upper = plate.Material(62e9, 62e9, 0.31, 24e9, 0.0, d31=-190e-12)
    plies = [(plate.material("PZT-5H"), H, 0.0), (steel, 50e-6, 0.0), (upper, H, 90.0)]
    laminate = plate.Laminate([plate.Ply(*ply) for ply in plies])
    assert effect == bender(laminate, (1, 0, -1), normal=(0, 0, 1), voltage=DATA["voltage"])
    assert hash(effect) == hash(bender(laminate, (1, 0, -1), normal=(0, 0, 1), voltage=DATA["voltage"]))
    assert scene_of_text(json.dumps(scene_data(scene)), "again.yaml").effects == scene.effects


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"laminate": []}, r"laminate.*give its plies from bottom to top"),
        (
            {"laminate": [{"material": "PZT-5", "thickness": 1e-4}]},
            r"laminate\[0\]\.material.*did you mean 'PZT-5",
        ),
        (
            {"laminate": [{"material": "PZT-5A", "thicknes": 1}]},
            "no field 'thicknes'; did you mean 'thickness'",
        ),
        ({"laminate": [{"material": {"E": 1e9}, "thickness": 1}]}, "a material has E and nu, or"),
        ({"laminate": [{"material": {"E": 1e9, "nu": -1}, "thickness": 1}]}, "nu of a material is -1"),
        ({"laminate": [{"material": {"E1": 1e9}, "thickness": 1}]}, "no E2, nu12, G12"),
        ({"laminate": [{"material": "PZT-5A", "thickness": "1 kg"}]}, r"laminate\[0\]\.thickness.*'kg'"),
        ({"tip": [1e-200, 0, 0]}, "out of range"),
        ({"polarity": [1, -1]}, r"polarity.*must hold 3 numbers, one per ply"),
        ({"polarity": [0, 1, 0]}, "does not bend under voltage"),
        ({"normal": [1, 0, 1]}, "not at right angles to the strip"),
        ({"normal": [0, 0, 0]}, "not at right angles"),
        ({"tip": [0, 0, 0]}, "0 m from root to tip"),
        ({"extension": "10 mm"}, "there must be a bending length"),
        ({"width": 0}, "the width is 0 m; it must be above 0"),
        ({"body_b": "wall"}, "both ends on body 'wall'"),
        ({"widht": 1}, "no field 'widht'; did you mean 'width'"),
        ({"voltage": "angle"}, "the voltage of a piezo bender: .*'angle' is not known"),
    ],
)
def test_benders_that_cannot_be_are_refused(change: dict[str, Any], words: str) -> None:
    with pytest.raises(DesignError, match=words) as caught:
        read({**DATA, **change})
    assert "\n" not in str(caught.value)


def test_a_symmetric_stack_that_only_stretches_is_refused() -> None:
    with pytest.raises(DesignError, match="does not bend under voltage"):
        bender(polarity=(1.0, 1.0))
    with pytest.raises(ExpressionError, match="the voltage of a piezo bender"):
        bender(voltage="rate")


def test_a_body_that_is_not_there_is_refused() -> None:
    with pytest.raises(DesignError, match="no body is named 'wall'"):
        lamc.compile(chain(1), Scene(effects=(bender(),)))


@needs_cc
def test_a_bender_on_a_body_that_bends_keeps_the_energy() -> None:
    """Its force is the gradient of what it stores, though its normal and its root ride on different parts of the body:
    the frame turns with the hinge, the root with the plate besides."""
    bending = replace(SAMPLES["flexible_links"], damping_ratio=0.0)  # type: ignore[type-var]
    stiff = replace(SAMPLES["piezo_bender"], voltage=9.0, width=20.0)  # type: ignore[type-var]
    scene = Scene(effects=(bending, stiff), angles={"h1": 0.9, "h2": -0.8}, rates={"h1": 2.0, "h2": -1.5})
    result = lamc.compile(mechanism(), scene).run(t_end=0.5, rtol=1e-10, atol=1e-12)
    change = float(np.abs(result.energy - result.energy[0]).max() / result.energies["kinetic"].max())
    assert change < 1e-7  # rtol times some hundred steps
