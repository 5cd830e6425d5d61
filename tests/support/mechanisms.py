"""Mechanisms for tests: deterministic in their arguments, none of them made by the code under test.

Sizes are of the order of 1 m and 1 kg, so that absolute and relative errors are alike.
"""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt
from hypothesis import strategies as st

from lamc.effects import Gravity, HingeDamping, HingeStiffness, RestAngle, Torque
from lamc.records.mechanism import Body, Joint, Mechanism
from lamc.records.scene import Scene

Array = npt.NDArray[np.float64]

KINDS = ("parallel", "space", "laminate", "mixed")
ALL_PASSIVE = (Gravity((0.3, -0.7, -9.81)), HingeStiffness(), HingeDamping(), RestAngle())
_GRID_AXES = np.array(
    [[1, 0, 0], [0, 1, 0], [0, 0, 1], [0, -1, 0], [0.6, 0.8, 0], [0, 0.6, 0.8]], dtype=float
)


def chain(n: int, kind: str = "space", seed: int = 0) -> Mechanism:
    """n bodies in a row, the first hinged to "ground". Kinds: see `random_tree`."""
    return _build(
        [i - 1 for i in range(n)], kind, np.random.default_rng(seed), shuffled=False, name=f"chain{n}"
    )


def random_tree(n: int, seed: int = 0, kind: str = "space") -> Mechanism:
    """n bodies on random branches, names and orders shuffled, half of the joints drawn towards the world.

    parallel  all hinge lines parallel; bodies not symmetric about the plane of motion
    space     any hinge line, full inertia tensors
    laminate  plates without thickness in z = 0, hinge lines in that plane
    mixed     hinge lines along a few directions, so that parallel, opposite and right-angled ones occur
    """
    rng = np.random.default_rng(seed)
    inner = [int(rng.integers(max(0, i - 4), i)) if i and rng.random() > 0.1 else -1 for i in range(n)]
    return _build(inner, kind, rng, shuffled=True, name=f"tree{n}")


def trees(max_bodies: int, kinds: Sequence[str] = KINDS) -> st.SearchStrategy[Mechanism]:
    """`random_tree` of 1 to max_bodies bodies, any seed, any of the kinds, as a hypothesis strategy."""
    return st.builds(
        random_tree,
        n=st.integers(1, max_bodies),
        seed=st.integers(0, 2**32 - 1),
        kind=st.sampled_from(tuple(kinds)),
    )


def random_state(n: int, seed: int, angle: float = 3.0, rate: float = 3.0) -> tuple[Array, Array]:
    """Angles within ±angle (rad) and rates within ±rate (rad/s), both shape (n,)."""
    rng = np.random.default_rng(seed)
    return rng.uniform(-angle, angle, n), rng.uniform(-rate, rate, n)


def unit_plate_pendulum() -> tuple[Mechanism, Scene]:
    """The paper's triple pendulum: three thin plates, 1 m x 1 m, 1 kg, released flat at rest.

    k = 100 N·m/rad, b = 10 N·m·s/rad, g = 9.81 m/s² along -z; an angle is positive where the far plate goes
    down.
    """
    bodies = [Body("ground", fixed=True)]
    joints = []
    for i in range(3):
        bodies.append(Body(f"link{i}", 1.0, np.array([i + 0.5, 0.5, 0.0]), np.diag([1.0, 1.0, 2.0]) / 12.0))
        joints.append(
            Joint(
                f"h{i}",
                bodies[i].name,
                bodies[i + 1].name,
                point=np.array([float(i), 0.0, 0.0]),
                axis=np.array([0.0, 1.0, 0.0]),
                stiffness=100.0,
                damping=10.0,
            )
        )
    scene = Scene(effects=(Gravity((0.0, 0.0, -9.81)), HingeStiffness(), HingeDamping()))
    return Mechanism(tuple(bodies), tuple(joints), name="unit_plates"), scene


def from_reference(spec: Mapping[str, Any]) -> tuple[Mechanism, Scene]:
    """A `spec` of the reference file dynamics.json as a mechanism and the scene that it asks for."""
    bodies = tuple(
        Body(name, b["mass"], np.array(b["com"]), np.array(b["inertia"]), bool(b["fixed"]))
        for name, b in spec["bodies"].items()
    )
    joints = tuple(
        Joint(
            j["name"],
            j["a"],
            j["b"],
            point=np.array(j["point"]),
            axis=np.array(j["axis"]),
            stiffness=j["k"],
            damping=j["c"],
            rest_angle=j["theta0"],
        )
        for j in spec["joints"]
    )
    effects: list[Any] = [Gravity(tuple(float(g) for g in spec["gravity"]))] if any(spec["gravity"]) else []
    if any(j.stiffness for j in joints):
        effects.append(HingeStiffness())
    if any(j.stiffness * j.rest_angle for j in joints):
        effects.append(RestAngle())
    if any(j.damping for j in joints):
        effects.append(HingeDamping())
    torques = {j["name"]: float(j["tau"]) for j in spec["joints"] if j.get("tau")}
    if torques:
        effects.append(Torque(torques))
    scene = Scene(effects=tuple(effects), angles=spec["q0"], rates=spec["qd0"])
    return Mechanism(bodies, joints), scene


def _build(
    inner: Sequence[int], kind: str, rng: np.random.Generator, *, shuffled: bool, name: str
) -> Mechanism:
    """inner[i] is the body on the world's side of body i, -1 for the world."""
    assert kind in KINDS, kind
    common_axis = _unit(rng.normal(size=3))
    bodies, joints, tips = [], [], []
    for i, p in enumerate(inner):
        start = np.zeros(3) if p < 0 else tips[p]
        reach = rng.uniform(0.7, 1.3)
        if kind == "laminate":
            direction = np.array([*_unit(rng.normal(size=2)), 0.0])
            axis = np.array([*_unit(rng.normal(size=2)), 0.0])
            inertia = _thin_plate_inertia(rng)
        else:
            direction = _unit(rng.normal(size=3))
            axis = {"parallel": common_axis, "mixed": _GRID_AXES[rng.integers(len(_GRID_AXES))]}.get(
                kind, _unit(rng.normal(size=3))
            )
            inertia = _solid_inertia(rng)
        tips.append(start + reach * direction)
        spread = rng.uniform(-0.15, 0.15, 3) * ([1.0, 1.0, 0.0] if kind == "laminate" else 1.0)
        mass = rng.uniform(0.5, 1.5)
        bodies.append(Body(f"body{i}", mass, start + 0.5 * reach * direction + spread, mass * inertia))
        ends = ("ground" if p < 0 else f"body{p}", f"body{i}")
        if shuffled and rng.random() < 0.5:
            ends = ends[::-1]
        joints.append(
            Joint(
                f"h{i}",
                *ends,
                point=start,
                axis=axis,
                stiffness=rng.uniform(1.0, 5.0),
                damping=rng.uniform(0.05, 0.3),
                rest_angle=rng.uniform(-1.0, 1.0),
            )
        )
    order = rng.permutation(len(inner)) if shuffled else range(len(inner))
    ground = Body("ground", fixed=True)
    return Mechanism((ground, *(bodies[k] for k in order)), tuple(joints[k] for k in order), name=name)


def _unit(vector: Array) -> Array:
    return vector / np.linalg.norm(vector)


def _solid_inertia(rng: np.random.Generator) -> Array:
    """Full inertia about the centre per unit mass, from the second moments of an ellipsoid, m²."""
    radii = rng.uniform(0.1, 0.5, 3)
    frame = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    moments = frame @ np.diag(radii**2) @ frame.T
    inertia = np.trace(moments) * np.eye(3) - moments
    return 0.5 * (inertia + inertia.T)


def _thin_plate_inertia(rng: np.random.Generator) -> Array:
    """Inertia per unit mass of a plate in the plane z = 0, m²."""
    a, b = rng.uniform(0.2, 0.5, 2) ** 2
    slant = rng.uniform(-0.5, 0.5) * min(a, b)
    return np.array([[a, slant, 0.0], [slant, b, 0.0], [0.0, 0.0, a + b]])


def two_flaps() -> Mechanism:
    """Alike, side by side: they fall on their stops at once."""
    flaps = [
        Body(name, 0.1, np.array([0.1, y, 0.0]), 1e-3 * np.eye(3)) for name, y in (("a", 0.0), ("b", 0.3))
    ]
    hinges = [
        Joint(
            f"h_{flap.name}",
            "ground",
            flap.name,
            point=np.array([0.0, flap.com[1], 0.0]),
            axis=np.array([0.0, 1.0, 0.0]),
            limits=(-1.0, 0.5),
        )
        for flap in flaps
    ]
    return Mechanism((Body("ground", fixed=True), *flaps), tuple(hinges), name="two_flaps")
