"""Chains of shifts and turns from one frame to the next, staged, and what passes along them.

Goes in: steps, each linear in the coordinates that move it. Comes out: velocities and accelerations outwards; forces
inwards, and the work that they do on those coordinates. It knows no tree and no mass.
"""

import math
from collections.abc import Iterable, Iterator, Mapping, MutableMapping, Sequence
from dataclasses import dataclass

import numpy as np

from lamc.basics.checks import Array
from lamc.mechanics.kinematics import acceleration_gradient
from lamc.mechanism.rotations import constant_rotations, snap
from lamc.symbolic.algebra import ZERO, AxisRotation, Vector3, add, cross, dot, inward, outward, scale
from lamc.symbolic.scalars import Scalar, cos, sin
from lamc.symbolic.staging import Store

Wrench = tuple[Vector3, Vector3]  # force N, moment about the frame's origin N·m


@dataclass(frozen=True)
class Shift:
    """The frame's origin moves by `vector`, m, which changes by partials[k] with coordinate k."""

    vector: Vector3
    partials: Mapping[int, Vector3]


@dataclass(frozen=True)
class Rotation:
    """The frame turns about its own x or z, by an angle that changes by partials[k] with coordinate k."""

    rotation: AxisRotation
    partials: Mapping[int, Scalar]


Step = Shift | Rotation


@dataclass(frozen=True)
class LinkState:
    """Motion of a frame, components in that frame: rad/s, m/s of the origin, rad/s², m/s²."""

    omega: Vector3
    velocity: Vector3
    alpha: Vector3
    acceleration: Vector3


def through(
    link_state: LinkState, step: Step, u: Sequence[Scalar], udot: Sequence[Scalar] | None
) -> LinkState:
    """The motion of the frame after a step; udot None: rates do not change."""
    if isinstance(step, Shift):
        return _through_shift(link_state, step, u, udot)
    w, v, alpha, a = (
        outward(step.rotation, part)
        for part in (link_state.omega, link_state.velocity, link_state.alpha, link_state.acceleration)
    )
    rate, change = _combined(step.partials, u), _combined(step.partials, udot)
    if step.rotation.axis == "z":
        alpha = (alpha[0] + w[1] * rate, alpha[1] - w[0] * rate, alpha[2] + change)
        w = (w[0], w[1], w[2] + rate)
    else:
        alpha = (alpha[0] + change, alpha[1] + w[2] * rate, alpha[2] - w[1] * rate)
        w = (w[0] + rate, w[1], w[2])
    return LinkState(w, v, alpha, a)


def _through_shift(
    link_state: LinkState, step: Shift, u: Sequence[Scalar], udot: Sequence[Scalar] | None
) -> LinkState:
    w, v, alpha, a = link_state.omega, link_state.velocity, link_state.alpha, link_state.acceleration
    r = step.vector
    if step.partials:
        rate = total_vector([scale(u[k], p) for k, p in step.partials.items()])
        twice = cross(w, rate)
        v = add(v, rate)
        a = add(a, (2 * twice[0], 2 * twice[1], 2 * twice[2]))
        if udot is not None:
            a = add(a, total_vector([scale(udot[k], p) for k, p in step.partials.items()]))
    if r != ZERO:
        v = add(v, cross(w, r))
        rows = acceleration_gradient(w, alpha)
        a = add(a, (dot(rows[0], r), dot(rows[1], r), dot(rows[2], r)))
    return LinkState(w, v, alpha, a)


def back(wrench: Wrench, step: Step, work: MutableMapping[int, Scalar]) -> Wrench:
    """The wrench in the frame before a step; `work` gains what it does on the step's coordinates."""
    force, moment = wrench
    if isinstance(step, Shift):
        for k, partial in step.partials.items():
            work[k] = work.get(k, 0) + dot(partial, force)
        return force, add(moment, cross(step.vector, force))
    about = moment[2] if step.rotation.axis == "z" else moment[0]
    for k, p in step.partials.items():
        work[k] = work.get(k, 0) + p * about
    return inward(step.rotation, force), inward(step.rotation, moment)


def together(first: Wrench, second: Wrench) -> Wrench:
    """Two wrenches about one origin."""
    return add(first[0], second[0]), add(first[1], second[1])


def offset(chain: Sequence[Step]) -> Vector3:
    """From the first frame's origin to the last one's, m, axes of the first."""
    result = ZERO
    for step in reversed(chain):
        result = add(step.vector, result) if isinstance(step, Shift) else inward(step.rotation, result)
    return result


def constant_rotation(store: Store, rotation: Array) -> Iterator[Rotation]:
    """A constant rotation (columns: the new axes) as up to three elementary turns."""
    twist, fold, angle, _ = constant_rotations(snap(rotation, 1.0))
    for axis, pair in (("z", twist), ("x", fold), ("z", (math.cos(angle), math.sin(angle)))):
        c, s = (float(v) for v in snap(np.array(pair), 1.0))
        if (c, s) != (1.0, 0.0):
            yield Rotation(AxisRotation(axis, store.constant(c), store.constant(s)), {})


def elementary(axis: str, partials: Mapping[int, Scalar], q: Sequence[Scalar]) -> Iterator[Rotation]:
    """A turn about x, y or z by Σ partials·q; one about y is one about x between quarter turns about z."""
    angle = _combined(partials, q)
    if axis == "y":
        yield Rotation(AxisRotation("z", 0, 1), {})
    yield Rotation(AxisRotation("z" if axis == "z" else "x", cos(angle), sin(angle)), dict(partials))
    if axis == "y":
        yield Rotation(AxisRotation("z", 0, -1), {})


def rotations(chain: Iterable[Step]) -> tuple[AxisRotation, ...]:
    """The turns of a chain, in order."""
    return tuple(step.rotation for step in chain if isinstance(step, Rotation))


def total_vector(vectors: Sequence[Vector3]) -> Vector3:
    """Their sum."""
    result = ZERO
    for vector in vectors:
        result = add(result, vector)
    return result


def _combined(partials: Mapping[int, Scalar], values: Sequence[Scalar] | None) -> Scalar:
    result: Scalar = 0
    if values is not None:
        for k, p in partials.items():
            result = result + p * values[k]
    return result
