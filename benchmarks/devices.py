"""Mechanisms that the benchmarks run: rows of the paper's unit plates, hinges parallel or in space."""

import math
from collections.abc import Sequence

import numpy as np

from lamc.effects import Gravity, HingeDamping, HingeStiffness
from lamc.records.mechanism import Body, Joint, Mechanism
from lamc.records.scene import Scene

SCENE = Scene(effects=(Gravity((0.0, 0.0, -9.81)), HingeStiffness(), HingeDamping()))
PARALLEL = (90.0,)
CROSSED = (90.0, 0.0)  # right angles, which every formulation likes best
OBLIQUE = (90.0, 40.0, 115.0, 65.0)


def plates(n: int, directions: Sequence[float] = PARALLEL) -> Mechanism:
    """n thin plates of 1 m x 1 m and 1 kg along x, hinged to the world and to each other.

    directions: of the hinge lines in the plates' plane, degrees from x, repeated in turn; k = 100 N·m/rad,
    b = 10 N·m·s/rad.
    """
    bodies = [Body("ground", fixed=True)]
    joints = []
    for i in range(n):
        bodies.append(Body(f"link{i}", 1.0, np.array([i + 0.5, 0.5, 0.0]), np.diag([1.0, 1.0, 2.0]) / 12.0))
        turn = math.radians(directions[i % len(directions)])
        axis = np.array([round(math.cos(turn), 15), round(math.sin(turn), 15), 0.0])
        joints.append(
            Joint(
                f"h{i}",
                bodies[i].name,
                bodies[i + 1].name,
                point=np.array([float(i), 0.0, 0.0]),
                axis=axis,
                stiffness=100.0,
                damping=10.0,
            )
        )
    return Mechanism(tuple(bodies), tuple(joints), name=f"plates{n}")
