"""Random mechanisms with loops for tests: deterministic in their arguments, none of them made by the code under test.

In: a seed and a family. Out: a `Mechanism` that closes as drawn, with full inertias, springs, dampers and rest
angles on any hinge, and hinges in any order and either sense. Sizes are of the order of 1 m and 1 kg. No start, no
effect.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np
from hypothesis import strategies as st

from lamc.records.mechanism import Body, Joint, Mechanism
from tests.support.mechanisms import Array, _solid_inertia, _unit

Line = tuple[Array, Array]  # a point, m, and a direction
Rng = np.random.Generator


@dataclass
class Network:
    """Hinge lines between bodies by number; body 0 is the world. `freedoms`: of a generic position."""

    freedoms: int
    hinges: list[tuple[int, int, Line]] = field(default_factory=list)
    count: int = 1

    def chain(self, start: int, lines: Sequence[Line], end: int) -> list[int]:
        """New bodies from `start` to `end`, a hinge between any two neighbours; returns them."""
        new = list(range(self.count, self.count + len(lines) - 1))
        self.count += len(new)
        row = [start, *new, end]
        self.hinges += [(a, b, line) for a, b, line in zip(row[:-1], row[1:], lines, strict=True)]
        return new

    def loop(self, start: int, lines: Sequence[Line]) -> list[int]:
        return self.chain(start, lines, start)


def _rotation(rng: Rng) -> Array:
    rotation = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    return rotation if np.linalg.det(rotation) > 0 else -rotation


def _parallel(rng: Rng, count: int, axis: Array) -> list[Line]:
    """Hinges along `axis`, around a circle in an order that a bar could follow, each point slid along its hinge."""
    x = _unit(np.cross(axis, np.eye(3)[int(np.argmin(np.abs(axis)))]))
    y = np.cross(axis, x)
    places = np.sort(
        rng.uniform(0.0, 2.0 * math.pi / count * 0.6, count)
    ) + 2.0 * math.pi / count * np.arange(count)
    radii = rng.uniform(0.6, 1.2, count)
    return [
        (r * (math.cos(p) * x + math.sin(p) * y) + rng.uniform(-0.3, 0.3) * axis, axis)
        for r, p in zip(radii, places, strict=True)
    ]


def _concurrent(rng: Rng, count: int) -> list[Line]:
    """Hinges through one point, no two nearly alike."""
    centre = rng.normal(size=3)
    axes: list[Array] = []
    while len(axes) < count:
        axis = _unit(rng.normal(size=3))
        if all(abs(axis @ a) < 0.9 for a in axes):
            axes.append(axis)
    return [(centre + rng.uniform(0.5, 1.0) * a, a) for a in axes]


def _any_lines(rng: Rng, count: int) -> list[Line]:
    return [(rng.uniform(-1.0, 1.0, 3), _unit(rng.normal(size=3))) for _ in range(count)]


def planar(rng: Rng) -> Network:
    """4 to 6 bars in any plane: n - 3 freedoms."""
    count = int(rng.integers(4, 7))
    network = Network(count - 3)
    network.loop(0, _parallel(rng, count, _unit(rng.normal(size=3))))
    return network


def spherical(rng: Rng) -> Network:
    """4 to 6 hinges through one point, an origami vertex: n - 3 freedoms."""
    count = int(rng.integers(4, 7))
    network = Network(count - 3)
    network.loop(0, _concurrent(rng, count))
    return network


def spatial(rng: Rng) -> Network:
    """Seven hinges anywhere: 1 freedom, no redundant equation."""
    network = Network(1)
    network.loop(0, _any_lines(rng, 7))
    return network


def sarrus(rng: Rng) -> Network:
    """Two legs of three parallel hinges each, in different directions: 1 freedom where 6 - 6 has none."""
    rotation = _rotation(rng)
    slant = rng.uniform(0.6, 2.5)
    lines: list[Line] = []
    for leg, angle in enumerate((0.0, slant)):
        axis = np.array([math.cos(angle), math.sin(angle), 0.0])
        out = np.array([math.sin(angle), -math.cos(angle), 0.0])
        foot, knee = out * rng.uniform(0.5, 1.0), rng.uniform(0.3, 0.8)
        points = (foot, foot + knee * out + 0.5 * np.array([0, 0, 1]), foot + np.array([0, 0, 1.0]))
        points = points if leg == 0 else points[::-1]
        lines += [(rotation @ (p + rng.uniform(-0.3, 0.3) * axis), rotation @ axis) for p in points]
    network = Network(1)
    network.loop(0, lines)
    return network


def bricard(rng: Rng) -> Network:
    """Bricard's line-symmetric loop: three lines anywhere and their images under a half turn; 1 freedom."""
    lines = _any_lines(rng, 3)
    axis = _unit(rng.normal(size=3))
    half = 2.0 * np.outer(axis, axis) - np.eye(3)
    network = Network(1)
    network.loop(0, [*lines, *((half @ p, half @ a) for p, a in lines)])
    return network


def bennett(rng: Rng) -> Network:
    """Bennett's loop of four hinges in space: opposite bars alike, sin(twist) over length equal for all; 1 freedom."""
    alpha, beta = rng.uniform(0.5, 1.1), rng.uniform(1.3, 2.0)
    a = rng.uniform(0.6, 1.0)
    b = a * math.sin(beta) / math.sin(alpha)
    first = rng.uniform(0.6, 2.4)
    ratio = math.sin(0.5 * (beta + alpha)) / math.sin(0.5 * (beta - alpha))
    second = 2.0 * math.atan(ratio / math.tan(0.5 * first))
    frame, point, lines = np.eye(3), np.zeros(3), []
    for angle, length, twist in (
        (first, a, alpha),
        (second, b, beta),
        (-first, a, alpha),
        (-second, b, beta),
    ):
        lines.append((point.copy(), frame[:, 2].copy()))
        c, s = math.cos(angle), math.sin(angle)
        frame = frame @ np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
        point = point + length * frame[:, 0]
        c, s = math.cos(twist), math.sin(twist)
        frame = frame @ np.array([[1.0, 0.0, 0.0], [0.0, c, -s], [0.0, s, c]])
    assert np.abs(point).max() < 1e-12, "bars and twists of a Bennett loop lead back to the first hinge"
    assert np.abs(frame[:, 2] - [0.0, 0.0, 1.0]).max() < 1e-12
    rotation = _rotation(rng)
    network = Network(1)
    network.loop(0, [(rotation @ p, rotation @ axis) for p, axis in lines])
    return network


def several(rng: Rng) -> Network:
    """A plane or spherical loop of 6 with a bar or a dyad across it, and another loop on one of its bodies."""
    if rng.random() < 0.5:
        axis = _unit(rng.normal(size=3))
        lines = _parallel(rng, 10, axis)
        lines = [lines[k] for k in rng.permutation(10)] if rng.random() < 0.3 else lines
    else:
        lines = _concurrent(rng, 10)
    network = Network(3)
    ring = [0, *network.loop(0, lines[:6])]
    bar = int(rng.integers(2, 4))  # a bar (two hinges) takes a freedom away, a dyad (three) does not
    network.chain(ring[1], lines[6 : 6 + bar], ring[4])
    network.freedoms += bar - 3
    if rng.random() < 0.5:
        other = [_concurrent, lambda r, n: _parallel(r, n, _unit(r.normal(size=3)))][int(rng.integers(2))]
        network.loop(int(rng.integers(network.count)), other(rng, 4))
        network.freedoms += 1
    if rng.random() < 0.5:
        network.chain(
            int(rng.integers(network.count)), _any_lines(rng, 2), network.count + 1
        )  # a limb, no loop
        network.count += 1
        network.freedoms += 2
    return network


FAMILIES: dict[str, Callable[[Rng], Network]] = {
    "planar": planar,
    "spherical": spherical,
    "spatial": spatial,
    "sarrus": sarrus,
    "bricard": bricard,
    "bennett": bennett,
    "several": several,
}


@dataclass(frozen=True)
class ClosedMechanism:
    """A mechanism with loops, and the freedoms that it has by theory where it is drawn and moves from there."""

    mechanism: Mechanism
    freedoms: int

    def __repr__(self) -> str:
        return f"{self.mechanism.name}: {len(self.mechanism.joints)} hinges"


def closed_mechanism(family: str, seed: int, sprung: bool = True) -> ClosedMechanism:
    """The mechanism of a family and a seed. sprung: about two of three hinges are."""
    rng = np.random.default_rng([seed, list(FAMILIES).index(family)])
    network = FAMILIES[family](rng)
    names = ["ground", *(f"body{i}" for i in range(1, network.count))]
    # Hinges on the world are shared out between two fixed bodies, which are one world.
    second = rng.random() < 0.3
    bodies = [Body("ground", fixed=True), *([Body("wall", fixed=True)] if second else [])]
    for i in range(1, network.count):
        at = np.array([line[0] for a, b, line in network.hinges if i in (a, b)])
        mass = rng.uniform(0.5, 1.5)
        com = at.mean(axis=0) + rng.uniform(-0.2, 0.2, 3)
        bodies.append(Body(names[i], mass, com, mass * _solid_inertia(rng)))
    joints = []
    for k, (a, b, (point, axis)) in enumerate(network.hinges):
        ends = [("wall" if second and e == 0 and rng.random() < 0.5 else names[e]) for e in (a, b)]
        if rng.random() < 0.5:
            ends.reverse()
        joints.append(
            Joint(
                f"h{k}",
                *ends,
                point=point,
                axis=axis if rng.random() < 0.5 else -axis,
                stiffness=rng.uniform(1.0, 5.0) if sprung and rng.random() < 0.7 else 0.0,
                damping=rng.uniform(0.05, 0.3),
                rest_angle=rng.uniform(-0.5, 0.5) if rng.random() < 0.5 else 0.0,
            )
        )
    bodies = [bodies[k] for k in rng.permutation(len(bodies))]
    joints = [joints[k] for k in rng.permutation(len(joints))]
    mechanism = Mechanism(tuple(bodies), tuple(joints), name=f"{family}{seed}")
    return ClosedMechanism(mechanism, network.freedoms)


def closed_mechanisms() -> st.SearchStrategy[ClosedMechanism]:
    """Any family, any seed, as a hypothesis strategy."""
    return st.builds(
        closed_mechanism,
        family=st.sampled_from(tuple(FAMILIES)),
        seed=st.integers(0, 2**32 - 1),
        sprung=st.booleans(),
    )
