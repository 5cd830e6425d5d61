"""Hinges whose strips yield: what drawings give, small vibrations, loops that do not fit, the stiff limit, refusals."""

from collections.abc import Callable
from dataclasses import replace
from importlib.resources import as_file, files

import numpy as np
import numpy.typing as npt
import pytest
import scipy.linalg
from scipy.optimize import minimize
from scipy.spatial.transform import Rotation

import lamc
from lamc import Body, Joint, Mechanism, Scene, TwistCompliance
from lamc.basics.errors import DesignError
from lamc.effects import Gravity, HingeDamping, HingeStiffness
from lamc.mechanics.arrangement import Arrangement
from lamc.mechanics.arranging import arrange
from lamc.mechanism.plan import plan
from lamc.readers.load_scene import scene_of_text
from tests.support.ctools import needs_cc
from tests.support.general_motion import General

Array = npt.NDArray[np.float64]
FILM = {"width": 1e-3, "length": 20e-3, "thickness": 1e-4, "E": 2.5e9, "nu": 0.34}
G = np.array([1.5, 8.0, -49.0])  # m/s²: strong, and pushes the ring out of its plane, too


def arranged(mechanism: Mechanism, effect: TwistCompliance) -> Arrangement:
    return arrange(plan(mechanism), (effect,))


def drawn(name: str) -> Mechanism:
    with as_file(files("lamc.examples") / name) as path:
        return lamc.split(lamc.load(path))


# --- what a drawing gives --------------------------------------------------------------------------------------------


def test_a_drawn_hinge_has_the_stiffness_of_its_film() -> None:
    """The arm of the four-bar: polyimide, 25 µm, 14 mm along the line and two hinge widths, 2 mm, across."""
    mechanism = drawn("four_bar.yaml")
    E, nu, t, b, L = 2.5e9, 0.34, 25e-6, 14e-3, 2e-3
    (hinge,) = arranged(mechanism, TwistCompliance(("arm",))).compliant
    stretch, D = E * t / (1 - nu**2), E * t**3 / 12 / (1 - nu**2)
    k = np.diag(hinge.stiffness)
    assert np.count_nonzero(hinge.stiffness) == 5
    assert k[3] == pytest.approx(stretch * b / L, rel=1e-9)
    assert k[1] == pytest.approx(stretch * b**3 / 12 / L, rel=1e-9)
    # Clamped fibres, and a little of what twists: 2.4 (1 - ν) (L/b)² = 0.032, itself less by (L/b)² once more.
    assert k[0] == pytest.approx(D * b**3 / L**3 * (1 + 2.4 * (1 - nu) * (L / b) ** 2), rel=1e-3)
    assert k[4] == pytest.approx(12 * D * b / L**3, rel=1e-3)  # shear through the thickness takes (t/L)²
    assert k[2] == 0.0  # the angle's own is what HingeStiffness gives
    assert hinge.point == pytest.approx([0.0, 7e-3, 12.5e-6], abs=1e-12)
    assert hinge.axes[:, 2] == pytest.approx(mechanism.joint("arm").axis)
    assert hinge.axes[:, 1] == pytest.approx([0.0, 0.0, 1.0])


def test_a_line_in_pieces_has_the_stiffness_of_all_of_them() -> None:
    """The vertex: holes where creases meet shorten them at one end, so the strip's middle is not the line's."""
    mechanism = drawn("vertex.yaml")
    for hinge in (*(a := arranged(mechanism, TwistCompliance())).compliant, *(b.hinge for b in a.bushings)):
        joint = mechanism.joint(hinge.joint)
        off = hinge.point - joint.point
        assert np.linalg.norm(np.cross(off, joint.axis)) < 1e-12
        assert np.linalg.norm(off) > 1e-4
        assert np.linalg.eigvalsh(hinge.stiffness)[1] > 0.0  # positive but for the angle


def test_a_scene_takes_the_place_of_what_is_drawn() -> None:
    mechanism = drawn("four_bar.yaml")
    known = arranged(mechanism, TwistCompliance(("arm", "link"))).compliant
    other = arranged(
        mechanism, TwistCompliance(("arm", "link"), thickness={"arm": 50e-6}, E=5e9, retardation=1e-5)
    ).compliant
    for a, b, ratio in zip(known, other, (2.0 * 2.0, 2.0), strict=True):
        assert b.stiffness[3, 3] == pytest.approx(ratio * a.stiffness[3, 3], rel=1e-12)
        assert b.damping == pytest.approx(1e-5 * b.stiffness)


def test_a_scene_file_gives_it_with_units() -> None:
    text = """
    effects:
      twist_compliance:
        joints: [h1]
        width: {h1: 1 mm}
        length: 2 cm
        thickness: 100 um
        E: 2.5 GPa
        nu: 0.34
        retardation: 10 us
    """
    (effect,) = scene_of_text(text, "scene.yaml").effects or ()
    values = FILM | {"width": {"h1": 1e-3}}
    assert effect == TwistCompliance(("h1",), **values, retardation=1e-5)


# --- motion ----------------------------------------------------------------------------------------------------------


def flag() -> Mechanism:
    """A plate hinged along its edge, y, at the origin."""
    plate = Body("flag", 2e-4, (0.01, 0.0, 0.0), np.diag([8e-9, 6e-9, 1.4e-8]))
    return Mechanism(
        (Body("ground", fixed=True), plate),
        (Joint("h1", "ground", "flag", (0.0, 0.0, 0.0), (0.0, 1.0, 0.0), stiffness=4e-3),),
    )


@needs_cc
def test_small_vibrations_are_those_of_a_body_on_its_strip() -> None:
    """A rigid body on six springs at its edge, by hand: K φ = ω² M φ with M about the hinge."""
    mechanism = flag()
    sim = lamc.compile(mechanism, Scene(effects=(HingeStiffness(), TwistCompliance(**FILM))))
    body = mechanism.body("flag")
    c = body.com
    arm = np.array([[0, -c[2], c[1]], [c[2], 0, -c[0]], [-c[1], c[0], 0]])
    mass = np.block(
        [[body.inertia - body.mass * arm @ arm, body.mass * arm], [-body.mass * arm, body.mass * np.eye(3)]]
    )
    E, nu, t, b, L = FILM["E"], FILM["nu"], FILM["thickness"], FILM["length"], FILM["width"]
    stretch, D = E * t / (1 - nu**2), E * t**3 / 12 / (1 - nu**2)
    twist = D * b**3 / L**3 * (1 + 2.4 * (1 - nu) * (L / b) ** 2)
    shear = 1 / (L**3 / (stretch * b**3) + L / (E / (2 * (1 + nu)) * b * t))
    across = 1 / (L**3 / (12 * D * b) + L / (5 / 6 * E / (2 * (1 + nu)) * b * t))
    # World axes: x across, y along, z up. Rotation about x twists, about z bends in the plane.
    stiffness = np.diag([twist, 4e-3, stretch * b**3 / 12 / L, stretch * b / L, shear, across])
    expected = np.sqrt(scipy.linalg.eigh(stiffness, mass, eigvals_only=True))
    still = np.zeros(6)
    squares = np.linalg.eigvals(-sim.jacobian(still, still)[0])
    # The series for the torsion leaves out (L/b)⁴.
    assert np.sort(np.sqrt(squares.real)) == pytest.approx(np.sort(expected), rel=1e-4)
    assert np.abs(squares.imag).max() <= 1e-9 * np.abs(squares).max()


@needs_cc
def test_stiff_strips_are_plain_hinges() -> None:
    """E times 1e6: deflections are 1e-6 of what they were, and those were 1e-3 of the motion. What would ring at 1e7 Hz
    is damped away."""
    mechanism, scene = flag(), Scene(effects=(Gravity(), HingeStiffness()), angles={"h1": 0.5})
    plain = lamc.compile(mechanism, scene).run(0.2, t_eval=[0.1, 0.2])
    stiff = replace(scene, added=(TwistCompliance(**FILM | {"E": 2.5e15}, retardation=1e-6),))
    result = lamc.compile(mechanism, stiff).run(
        0.2, rtol=1e-8, atol=1e-10, t_eval=[0.1, 0.2], integrator="radau5"
    )
    assert result.success, result.message
    assert result.angle("h1") == pytest.approx(plain.angle("h1"), abs=1e-6)


@needs_cc
def test_energy_is_kept_by_strips_and_lost_by_their_retardation() -> None:
    scene = Scene(effects=(Gravity(), HingeStiffness()), angles={"h1": 0.5}, rates={"h1": 20.0})
    made = [
        lamc.compile(flag(), replace(scene, added=(TwistCompliance(**FILM, retardation=tau),)))
        for tau in (0.0, 1e-4)
    ]
    kept, lost = (sim.run(0.05, rtol=1e-10, atol=1e-13) for sim in made)
    scale = np.ptp(kept.energies["kinetic"])
    assert np.abs(kept.energy - kept.energy[0]).max() <= 1e-8 * scale  # some thousand steps of 1e-10
    assert (np.diff(lost.energy) <= 1e-9 * scale).all()
    assert lost.energy[-1] < lost.energy[0] - 1e-6 * scale
    assert kept.energies["twist_compliance"].max() > 0.0
    assert TwistCompliance().conservative
    assert not TwistCompliance(retardation=1e-4).conservative


@needs_cc
@pytest.mark.slow
def test_energy_balance_close_and_retardation_only_takes() -> None:
    """A ring on its bushing: the strips' damping, and that of the hinges, lose energy at every row."""
    effects = (Gravity(tuple(G)), HingeStiffness(), HingeDamping(), TwistCompliance(**RING, retardation=1e-4))
    energy_balance = (
        lamc.compile(ring(), Scene(effects=effects))
        .run(0.01, rtol=1e-10, atol=1e-13, energy_balance=True)
        .energy_balance
    )
    assert energy_balance is not None
    assert np.abs(energy_balance.residual).max() <= 1e-10 * energy_balance.scale
    for dissipative in ("twist_compliance", "hinge_damping"):
        assert (np.diff(energy_balance.supplied[dissipative]) <= 1e-14 * energy_balance.scale).all()
        assert energy_balance.supplied[dissipative][-1] < -1e-3 * energy_balance.scale


# --- loops that do not fit -------------------------------------------------------------------------------------------

CORNERS = {"A": (0.0, 0.0, 0.0), "B": (0.0, 0.0, 0.02), "C": (0.04, 0.0, 0.03), "D": (0.035, 0.0, 0.0)}
BARS = {"crank": "AB", "coupler": "BC", "rocker": "DC"}


def ring(tilt: float = 0.03) -> Mechanism:
    """A four-bar in the plane of x and z, with the axis at C off by `tilt` rad and by a tenth of a millimetre."""
    bodies = [Body("ground", fixed=True)]
    for name, (a, b) in BARS.items():
        com = 0.5 * (np.array(CORNERS[a]) + CORNERS[b]) + [0.0, 1e-3, 0.0]
        bodies.append(Body(name, 1e-3, com, 1e-8 * np.diag([3.0, 4.0, 5.0])))
    axes = dict.fromkeys("ABD", (0.0, 1.0, 0.0)) | {"C": (0.0, np.cos(tilt), np.sin(tilt))}
    points = {k: np.array(v) for k, v in CORNERS.items()}
    points["C"] = points["C"] + [1e-4, 0.0, 0.0]
    ends = {
        "A": ("ground", "crank"),
        "B": ("crank", "coupler"),
        "C": ("coupler", "rocker"),
        "D": ("ground", "rocker"),
    }
    joints = (Joint(k, *ends[k], points[k], axes[k], stiffness=2e-3, damping=2e-5) for k in "ABCD")
    return Mechanism(tuple(bodies), tuple(joints))


RING = FILM | {"length": 5e-3}


class Potential:
    """Energy of the ring's bodies anywhere, (9,) positions and (9,) turns: six springs at each hinge, and gravity.

    Written from the meaning of p alone, with nothing of the code under test: no tree, no cut, no hinge coordinates.
    """

    def __init__(self, mechanism: Mechanism, hinges: dict[str, object]) -> None:
        self.mechanism, self.hinges = mechanism, hinges
        self.names = [b.name for b in mechanism.bodies if not b.fixed]

    def deflections(self, x: Array, joint: Joint) -> Array:
        """p: turns Rx Ry Rz of the child in the parent's axes, then the way of the child's point."""
        hinge = self.hinges[joint.name]
        (ra, ca), (rb, cb) = self.pose(x, joint.parent), self.pose(x, joint.child)
        pa = ca + ra.apply(hinge.point - self.mechanism.body(joint.parent).com)
        pb = cb + rb.apply(hinge.point - self.mechanism.body(joint.child).com)
        axes_a, axes_b = ra.as_matrix() @ hinge.axes, rb.as_matrix() @ hinge.axes
        rotations = Rotation.from_matrix(axes_a.T @ axes_b).as_euler("XYZ")
        return np.concatenate([rotations, axes_a.T @ (pb - pa)])

    def pose(self, x: Array, name: str) -> tuple[Rotation, Array]:
        body = self.mechanism.body(name)
        if body.fixed:
            return Rotation.identity(), body.com
        k = 3 * self.names.index(name)
        return Rotation.from_rotvec(x[9 + k : 12 + k]), body.com + x[k : k + 3]

    def energy(self, x: Array) -> float:
        total = 0.0
        for joint in self.mechanism.joints:
            p = self.deflections(x, joint)
            stiffness = self.hinges[joint.name].stiffness.copy()
            stiffness[2, 2] = joint.stiffness
            total += 0.5 * p @ stiffness @ p
        return total - sum(self.mechanism.body(n).mass * (G @ self.pose(x, n)[1]) for n in self.names)


def potential_of(mechanism: Mechanism) -> Potential:
    arrangement = arranged(mechanism, TwistCompliance(**RING))
    hinges = {h.joint: h for h in arrangement.compliant} | {
        b.hinge.joint: b.hinge for b in arrangement.bushings
    }
    assert len(arrangement.bushings) == 1
    return Potential(mechanism, hinges)


@needs_cc
@pytest.mark.slow
def test_a_loop_that_does_not_fit_rests_where_its_energy_is_least() -> None:
    """A slow descent of all 18 coordinates of the free bodies, against where the compiled accelerations vanish."""
    mechanism = ring()
    effects = (Gravity(tuple(G)), HingeStiffness(), HingeDamping())
    with pytest.raises(DesignError, match="closes only within"):
        lamc.compile(mechanism, Scene(effects=effects))
    sim = lamc.compile(mechanism, Scene(effects=(*effects, TwistCompliance(**RING, retardation=1e-4))))
    assert sim.cut_joints == ()
    assert len(sim.rates) == 3 + 3 * 5
    assert len(sim.coordinates) == len(sim.rates) + 1  # and the turns of the hinge that closes the loop
    result = sim.run(5.0, rtol=1e-8, atol=1e-10, t_eval=[0.0, 5.0])
    assert result.success, result.message
    assert np.abs(result.u[-1]).max() < 1e-6  # at rest
    potential = potential_of(mechanism)
    scale = np.concatenate([np.full(9, 1e-3), np.full(9, 0.1)])

    def energy(y: Array) -> float:
        return 1e6 * potential.energy(scale * y)

    y = minimize(energy, np.zeros(18), method="BFGS").x
    for _ in range(2):  # a minimum is flat: Newton's method on differences finds its place more sharply
        gradient, hessian = differences(energy, y)
        y = y - np.linalg.solve(hessian, gradient)
    x = scale * y
    for name in potential.names:
        place, turn = result.pose(name)
        rotation, expected = potential.pose(x, name)
        # Gradients by differences of energies of 1e-4 J to 16 digits, over stiffnesses of 2e-3 N·m/rad.
        assert place[-1] == pytest.approx(expected, abs=2e-8)
        assert turn[-1] == pytest.approx(rotation.as_matrix(), abs=1e-6)
    assert np.abs(result.q[-1]).max() > 0.05  # it has sagged


def differences(f: Callable[[Array], float], x: Array, h: float = 2e-4) -> tuple[Array, Array]:
    """Gradient and matrix of second derivatives, by central differences of f."""
    steps = h * np.eye(len(x))
    ahead, back = (np.array([f(x + sign * s) for s in steps]) for sign in (1, -1))
    wider = [np.array([f(x + sign * 2 * s) for s in steps]) for sign in (1, -1)]
    gradient = (8 * (ahead - back) - (wider[0] - wider[1])) / (12 * h)
    second = np.empty((len(x), len(x)))
    for i, a in enumerate(steps):
        for j, b in enumerate(steps):
            second[i, j] = (f(x + a + b) - f(x + a - b) - f(x - a + b) + f(x - a - b)) / (4 * h * h)
    return gradient, second


@needs_cc
def test_the_energy_of_a_strained_ring_is_that_of_its_strips() -> None:
    """At random deflections, large angles among them: the same springs, seen from free bodies."""
    mechanism = ring()
    effects = (Gravity(tuple(G)), HingeStiffness(), TwistCompliance(**RING))
    sim = lamc.compile(mechanism, Scene(effects=effects))
    potential, rng, n = potential_of(mechanism), np.random.default_rng(5), len(sim.coordinates)
    for _ in range(5):
        size = np.array([1.0 if c.unit == "rad" else 1e-3 for c in sim.coordinates])
        q = size * rng.uniform(-0.3, 0.3, n)
        poses = General(mechanism, effects).poses(0.0, q)
        x = np.zeros(18)
        for k, name in enumerate(potential.names):
            place, turn = poses[name]
            x[3 * k : 3 * k + 3] = place - mechanism.body(name).com
            x[9 + 3 * k : 12 + 3 * k] = Rotation.from_matrix(turn).as_rotvec()
        assert float(sim.energy(q, np.zeros(len(sim.rates)))) == pytest.approx(potential.energy(x), rel=1e-9)


@needs_cc
def test_given_angles_start_a_yielding_loop_nearly_closed() -> None:
    """The crank a tenth of a radian on: the others follow as rigid bars would, and the strips hold the misfit only."""
    mechanism = ring()
    effects = (HingeStiffness(), TwistCompliance(**RING))
    rest, rotated = (
        lamc.compile(mechanism, Scene(effects=effects, angles=angles)) for angles in ({}, {"A": 0.1})
    )
    n = len(rest.coordinates)
    assert rotated.start[0] == 0.1
    assert np.abs(rotated.start[1:3]).min() > 0.01
    torn = rotated.start[:n].copy()
    torn[1:3] = 0.0
    still = np.zeros(len(rest.rates))
    # Torn, the ring gapes by a tenth of its crank, 2 mm; closed, by what 0.03 rad at C over 0.1 rad of turn leaves.
    assert rotated.energy(rotated.start[:n], still) < 1e-3 * rotated.energy(torn, still)


# --- refusals --------------------------------------------------------------------------------------------------------

BAD = {
    "no joint is named 'h9'": lambda: arranged(flag(), TwistCompliance(("h9",), **FILM)),
    "comes from no drawing: give width, length, thickness, E, nu": lambda: arranged(
        flag(), TwistCompliance()
    ),
    "comes from no drawing: give width to": lambda: arranged(
        flag(), TwistCompliance(**FILM | {"width": None})
    ),
    "no joint is named 'x'": lambda: arranged(flag(), TwistCompliance(**FILM | {"width": {"x": 1.0}})),
    "runs along the normal": lambda: arranged(flag(), TwistCompliance(**FILM, normal=(0.0, 1.0, 0.0))),
    "twist_compliance.width: the width is 0 m; it must be above 0": lambda: TwistCompliance(width=0.0),
    "twist_compliance.nu: the nu is 1.5": lambda: TwistCompliance(nu=1.5),
    "did you mean 'twist_x'": lambda: TwistCompliance(freedoms=("twistx",)),
    "joints are \\(\\)": lambda: TwistCompliance(joints=()),
    "twist_compliance.retardation: the retardation is -1 s": lambda: TwistCompliance(retardation=-1.0),
    "the normal of twist_compliance": lambda: TwistCompliance(normal=(0.0, 0.0, 0.0)),
    "but rigid in slide_y": lambda: arranged(
        ring(), TwistCompliance(**RING, freedoms=("twist_x", "twist_y", "slide_x", "slide_z"))
    ),
}


@pytest.mark.parametrize("message", BAD)
def test_what_cannot_be_is_refused_by_name(message: str) -> None:
    with pytest.raises(DesignError, match=message):
        BAD[message]()


def test_a_film_without_moduli_is_refused_with_the_way_out() -> None:
    """popupCAD's file has placeholders for moduli."""
    mechanism = drawn("pendulum.cad")
    with pytest.raises(DesignError, match=r"moduli .*; twist_compliance takes E and nu of the strips, too"):
        arranged(mechanism, TwistCompliance())
    assert arranged(mechanism, TwistCompliance(E=2.5e9, nu=0.34)).compliant


def test_strips_that_turn_only_or_slide_only_are_other_forms() -> None:
    forms = TwistCompliance().alternatives()
    assert {name: form.freedoms for name, form in forms.items()} == {
        "only twist": ("twist_x", "twist_y"),
        "only slide": ("slide_x", "slide_y", "slide_z"),
    }
    assert not TwistCompliance(freedoms=("twist_x",)).alternatives()
