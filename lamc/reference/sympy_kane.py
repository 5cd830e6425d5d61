"""`sympy.physics.mechanics.KanesMethod` for a `Mechanism`: the textbook derivation, as oracle and as peer.

A tree of hinged bodies goes in; sympy's own mass matrix and forcing come out, and on request a lambdified
acceleration. Nothing of lamc's symbolic core is used. Expressions swell: six hinges in space is the limit.
"""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import sympy as sp
from sympy.physics.mechanics import (
    KanesMethod,
    Point,
    ReferenceFrame,
    RigidBody,
    dynamicsymbols,
    inertia,
)

from lamc.basics.errors import UnsupportedError
from lamc.records.mechanism import Mechanism
from lamc.reference.kinematics import Array, Link, walk
from lamc.reference.loads import NumericLoads, numeric_loads


@dataclass(frozen=True)
class KaneModel:
    """Kane's equations as sympy derives them: mass_matrix du/dt = forcing.

    q, u      dynamicsymbols in the order of `joints`
    torques   symbols of the hinge torques given by formulas, N·m, in the order of `loads.torques`
    """

    joints: tuple[str, ...]
    q: tuple[sp.Expr, ...]
    u: tuple[sp.Expr, ...]
    torques: tuple[sp.Symbol, ...]
    method: KanesMethod
    mass_matrix: sp.Matrix
    forcing: sp.Matrix
    loads: NumericLoads

    def operations(self) -> int:
        """Operations in mass matrix and forcing, as sympy counts them."""
        return int(sp.count_ops(self.mass_matrix) + sp.count_ops(self.forcing))

    def lambdified(self, cse: bool = True) -> Callable[[Array, Array, float], Array]:
        """(q, u, t) → du/dt, shape (n,), rad/s²: numpy functions of M and f, and numpy's solve."""
        function = sp.lambdify(
            [self.q, self.u, self.torques], [self.mass_matrix, self.forcing], modules="numpy", cse=cse
        )
        loads = self.loads

        def acceleration(q: Array, u: Array, t: float = 0.0) -> Array:
            given = [
                formula({"t": t, "angle": float(q[k]), "rate": float(u[k])}) for k, formula in loads.torques
            ]
            mass, force = function(q, u, given)
            result: Array = np.linalg.solve(mass, np.asarray(force).ravel())
            return result

        return acceleration


def kane(mechanism: Mechanism, effects: Iterable[Any], joints: Sequence[str] | None = None) -> KaneModel:
    """Derives the equations of a tree with sympy's KanesMethod; arguments and errors as `NewtonEuler`.

    Raises UnsupportedError for loops: KanesMethod takes independent closure equations only, chosen by hand, and the
    loops of laminates are redundant; and for springs between points.
    """
    names = tuple(j.name for j in mechanism.joints) if joints is None else tuple(joints)
    links = walk(mechanism, names)
    walked = {link.joint.name for link in links}
    outside = [j.name for j in mechanism.joints if j.name not in walked]
    if outside:
        raise UnsupportedError(
            f"joint {outside[0]!r} closes a loop; KanesMethod takes independent closure equations only, chosen by "
            "hand: leave the joint out of the mechanism"
        )
    loads = numeric_loads(mechanism, effects, names)
    if loads.at_points:
        unknown = loads.at_points[0].effect or "blade_element_drag"
        raise UnsupportedError(
            f"the KanesMethod peer does not know the effect {unknown!r}; leave it out of the scene"
        )
    if loads.reflected or loads.gears:
        raise UnsupportedError("the KanesMethod peer does not know the inertia of gears; set it to 0")
    n = len(links)
    q = tuple(dynamicsymbols(f"q:{n}")) if n else ()
    u = tuple(dynamicsymbols(f"u:{n}")) if n else ()
    torques = tuple(sp.Symbol(f"tau{k}") for k, _ in loads.torques)
    world = ReferenceFrame("N")
    origin = Point("O")
    origin.set_vel(world, 0)
    bodies = _bodies(links, q, u, world, origin)
    forces = _forces(links, bodies, loads, q, u, torques, world)
    rate_equations = [ui - qi.diff() for qi, ui in zip(q, u, strict=True)]
    method = KanesMethod(world, q_ind=list(q), u_ind=list(u), kd_eqs=rate_equations)
    method.kanes_equations(bodies, forces)
    return KaneModel(names, q, u, torques, method, method.mass_matrix, method.forcing, loads)


def _vector(frame: ReferenceFrame, components: Array) -> Any:
    x, y, z = (sp.Integer(0) if c == 0.0 else sp.Float(c) for c in components.tolist())
    return x * frame.x + y * frame.y + z * frame.z


def _bodies(
    links: Sequence[Link], q: Sequence[Any], u: Sequence[Any], world: ReferenceFrame, origin: Point
) -> list[RigidBody]:
    bodies: list[RigidBody] = []
    for i, link in enumerate(links):
        inner_frame = world if link.inner < 0 else bodies[link.inner].frame
        inner_point = origin if link.inner < 0 else bodies[link.inner].masscenter
        inner_com = np.zeros(3) if link.inner < 0 else links[link.inner].body.com
        axis = _vector(inner_frame, link.sign * link.joint.axis)
        frame = inner_frame.orientnew(f"B{i}", "Axis", [q[link.coordinate], axis])
        frame.set_ang_vel(inner_frame, u[link.coordinate] * axis)
        hinge = inner_point.locatenew(f"P{i}", _vector(inner_frame, link.joint.point - inner_com))
        hinge.v2pt_theory(inner_point, world, inner_frame)
        centre = hinge.locatenew(f"C{i}", _vector(frame, link.body.com - link.joint.point))
        centre.v2pt_theory(hinge, world, frame)
        j = link.body.inertia
        tensor = inertia(
            frame, *(sp.Float(x) for x in (j[0, 0], j[1, 1], j[2, 2], j[0, 1], j[1, 2], j[0, 2]))
        )
        bodies.append(RigidBody(f"body{i}", centre, frame, sp.Float(link.body.mass), (tensor, centre)))
    return bodies


def _forces(
    links: Sequence[Link],
    bodies: Sequence[RigidBody],
    loads: NumericLoads,
    q: Sequence[Any],
    u: Sequence[Any],
    torques: Sequence[sp.Symbol],
    world: ReferenceFrame,
) -> list[tuple[Any, Any]]:
    given: dict[int, Any] = {}
    for (k, _), symbol in zip(loads.torques, torques, strict=True):
        given[k] = given.get(k, sp.Integer(0)) + symbol
    forces: list[tuple[Any, Any]] = []
    for link, body in zip(links, bodies, strict=True):
        if loads.gravity.any():
            forces.append((body.masscenter, body.mass * _vector(world, loads.gravity)))
        k = link.coordinate
        torque = given.get(k, sp.Integer(0))
        constant = loads.preload[k] + loads.applied[k]
        for value, factor in ((constant, 1), (loads.stiffness[k], -q[k]), (loads.damping[k], -u[k])):
            if value != 0.0:
                torque += sp.Float(value) * factor
        if torque != 0:
            inner_frame = world if link.inner < 0 else bodies[link.inner].frame
            moment = torque * _vector(inner_frame, link.sign * link.joint.axis)
            forces.append((body.frame, moment))
            if link.inner >= 0:
                forces.append((inner_frame, -moment))
    return forces
