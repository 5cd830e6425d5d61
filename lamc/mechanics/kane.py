"""Kane's method as the paper writes it (eq. 15-19), for systems made by hand from frames and vectors.

    kane = Kane(system)
    kane.body(frame, mass, inertia, com_velocity)
    kane.force(vector, velocity_of_the_point)                # eq. 18
    kane.torque(vector, angular_velocity)
    kane.hinge_torque(q, u, stiffness, damping, rest_angle)   # eq. 15-17
    matrix, forces = kane.equations()                         # M u̇ = f, eq. 19

The simulator takes the same equations through a recursion made for trees (`elimination.py`); the tests hold one
against the other. Use this layer to read them, to try a force of your own, or for systems that are no laminate.
"""

from dataclasses import dataclass, field

from lamc.mechanics.frames import Frame, System, Vector
from lamc.symbolic.algebra import Matrix3, Vector3, dot
from lamc.symbolic.derivative import derivatives
from lamc.symbolic.scalars import Scalar, Value
from lamc.symbolic.substitution import substitute


@dataclass
class Kane:
    """Collects bodies and loads of one System; one equation per coordinate."""

    system: System
    _active: list[tuple[Vector, Vector]] = field(default_factory=list)  # load, velocity that it works on
    _inertial: list[tuple[Vector, Vector]] = field(default_factory=list)
    _generalised: dict[Value, Scalar] = field(default_factory=dict)

    def body(self, frame: Frame, mass: Scalar, inertia: Matrix3, com_velocity: Vector) -> None:
        """A rigid body: mass, kg; inertia about its centre of mass, own frame, kg·m²; that point's velocity, m/s."""
        world = self.system.world
        omega = frame.angular_velocity_in(world)
        momentum = com_velocity * mass
        spin = Vector({frame: _apply(inertia, omega.express(frame))})
        self._inertial.append((momentum.derivative(world), com_velocity))
        self._inertial.append((spin.derivative(world), omega))

    def force(self, force: Vector, velocity: Vector) -> None:
        """A force, N, on a point with this velocity, m/s."""
        self._active.append((force, velocity))

    def torque(self, torque: Vector, angular_velocity: Vector) -> None:
        """A torque, N·m, on a frame with this angular velocity, rad/s."""
        self._active.append((torque, angular_velocity))

    def hinge_torque(
        self,
        q: Value,
        u: Value,
        stiffness: Scalar = 0,
        damping: Scalar = 0,
        rest_angle: Scalar = 0,
        applied: Scalar = 0,
    ) -> None:
        """-k (q - q₀) - c u + applied, N·m, between the two sides of the hinge with angle q and rate u (eq. 15-17)."""
        torque = applied - stiffness * (q - rest_angle) - damping * u
        self._generalised[u] = self._generalised.get(u, 0) + torque

    def active_forces(self) -> list[Scalar]:
        """Generalised active forces F_r = Σ load · ∂velocity/∂u_r (eq. 18)."""
        return [self._generalised.get(u, 0) + _projected(self._active, u) for u in self.system.rates]

    def inertia_forces(self) -> list[Scalar]:
        """Generalised inertia forces F*_r (eq. 19)."""
        return [-_projected(self._inertial, u) for u in self.system.rates]

    def equations(self) -> tuple[list[list[Scalar]], list[Scalar]]:
        """(M, f) of M u̇ = f from F_r + F*_r = 0; M is (n, n), f (n,)."""
        accelerations = self.system.accelerations
        inertia = self.inertia_forces()
        matrix = [[-x for x in derivatives([row], {a: 1})] for row in inertia for a in accelerations]
        count = len(accelerations)
        flat = [entry[0] for entry in matrix]
        rows = [flat[i * count : (i + 1) * count] for i in range(count)]
        at_rest = substitute(inertia, dict.fromkeys(accelerations, 0))
        forces = [active + star for active, star in zip(self.active_forces(), at_rest, strict=True)]
        return rows, forces


def _projected(loads: list[tuple[Vector, Vector]], rate: Value) -> Scalar:
    result: Scalar = 0
    for load, velocity in loads:
        result = result + load.dot(velocity.partial(rate))
    return result


def _apply(matrix: Matrix3, v: Vector3) -> Vector3:
    return (dot(matrix[0], v), dot(matrix[1], v), dot(matrix[2], v))
