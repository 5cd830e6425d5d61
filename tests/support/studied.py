"""Designs that studies are tried on, in a module of their own, so that other processes can import them."""

import math
import os

import numpy as np

from lamc import (
    Body,
    DesignError,
    DesignParameter,
    Family,
    Gravity,
    HingeDamping,
    HingeStiffness,
    Input,
    Joint,
    Mechanism,
    Scene,
    Torque,
)
from lamc.run.result import Result


def rod(length: float = 0.3, mass: float = 0.02, tilt: float = 0.0) -> Mechanism:
    """A uniform rod (m, kg) on a hinge "hip" about y, which hangs in the drawing; tilt: rad, of its axis from y.

    Raises DesignError for a length of 0.35 m and more.
    """
    if length >= 0.35:
        raise DesignError(f"a rod of {length:g} m does not fit; make it shorter than 0.35 m")
    inertia = mass * length**2 / 12.0
    bodies = (
        Body("ground", fixed=True),
        Body("rod", mass, np.array([0.0, 0.0, -length / 2]), np.diag([inertia, inertia, 1e-3 * inertia])),
    )
    axis = np.array([math.sin(tilt), math.cos(tilt), 0.0])
    hip = Joint("hip", "ground", "rod", point=np.zeros(3), axis=axis, stiffness=1e-3, damping=1e-5)
    effects = (Gravity((0.0, 0.0, -9.81)), HingeStiffness(), HingeDamping(), Torque({"hip": "drive"}))
    scene = Scene(effects=effects, angles={"hip": 0.5}, inputs={"drive": Input(0.0, "N*m")})
    return Mechanism(bodies, (hip,), name="rod", scene=scene)


def last_angle(result: Result) -> float:
    return float(result.angle("hip")[-1])


def deadly(result: Result) -> float:
    """Ends its process where the rod has a stiffness of 2 N·m/rad."""
    if result.provenance.parameters["hip.stiffness"] == 2.0:
        os._exit(9)
    return last_angle(result)


def broken(result: Result) -> float:
    raise ZeroDivisionError("of the user's")


bounded = Family(rod, {"length": DesignParameter("0.3 m", minimum=0.05, maximum=0.34)})


def hanging(count: float = 1.0, length: float = 0.3) -> Mechanism:
    """So many rods (whole), one below the other, each `length` long, m: another topology for each number."""
    bodies, joints = [Body("ground", fixed=True)], []
    for k in range(int(count)):
        inertia = 0.02 * length**2 / 12.0
        com = np.array([0.0, 0.0, -(k + 0.5) * length])
        bodies.append(Body(f"rod_{k}", 0.02, com, np.diag([inertia, inertia, 1e-3 * inertia])))
        point, axis = np.array([0.0, 0.0, -k * length]), np.array([0.0, 1.0, 0.0])
        before = "ground" if k == 0 else f"rod_{k - 1}"
        joints.append(Joint(f"hip_{k}", before, f"rod_{k}", point=point, axis=axis, damping=1e-5))
    scene = Scene(effects=(Gravity((0.0, 0.0, -9.81)), HingeDamping()), angles={"hip_0": 0.5})
    return Mechanism(tuple(bodies), tuple(joints), name="hanging", scene=scene)
