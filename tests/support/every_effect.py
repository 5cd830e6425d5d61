"""A sample of each effect that lamc brings, for tests that hold for all of them.

To add an effect, add its sample here: one that acts on `mechanism()`, with every field of it said in some way.
"""

from collections.abc import Mapping
from types import MappingProxyType

import numpy as np
from shapely.geometry import box

import lamc
from lamc import plate
from lamc.records.effect import Effect
from lamc.records.mechanism import Body, Joint, Mechanism, Slab

PIEZO = plate.Material(62e9, 62e9, 0.31, 24e9, 7800.0, d31=-190e-12, d32=-190e-12, name="piezo")
BIMORPH = plate.Laminate([plate.Ply(PIEZO, 127e-6), plate.Ply(PIEZO, 127e-6, 30.0)])
SHEET = plate.Laminate([plate.Ply(plate.Material.isotropic(2e9, 0.3, 1500.0), 1e-3)])

SAMPLES: Mapping[str, Effect] = MappingProxyType(
    {
        effect.name: effect
        for effect in (
            lamc.BladeElementDrag(
                "b",
                1.3,
                2,
                lift=1.7,
                rotation=3.0,
                lift_point=0.4,
                wind=(0.0, 0.0, 0.0),
                line=((1.0, 0.0), (2.0, 0.1)),
                leading=(0.0, 1.0),
                outline=((1.0, -0.3), (2.0, -0.2), (2.0, 0.2), (1.0, 0.2)),
            ),
            lamc.Cable(
                ("ground", "a", "b"),
                ((0.0, 0.0, 0.4), (1.0, 0.0, 0.2), (2.0, 0.05, 0.1)),
                30.0,
                length="2 - 0.3*sin(t)",
                damping=0.2,
                friction=0.1,
                slip_speed=0.3,
            ),
            lamc.ExternalTorque(("h2",)),
            lamc.Gravity((0.1, 0.2, -9.7)),
            lamc.GroundContact(
                0.4, points={"b": ((2.0, 0.1, 0.0), (2.0, -0.1, 0.0))}, stiffness=1e3, height=-1.0
            ),
            lamc.HingeDamping(),
            lamc.HingeStiffness(),
            lamc.JointLimits(stiffness=3.0, damping=0.2),
            lamc.LinearMotor("h1", "6*sin(t)", torque_constant=0.1, resistance=2.0, gear_ratio=-4.0),
            lamc.NonlinearStiffness(
                {
                    "h1": {"table": ((-1.0, -2.0), (0.0, 0.25), (1.5, 1.0)), "between": "monotone"},
                    "h2": [0.1, 0, 2],
                }
            ),
            lamc.PiezoBender(
                "a", (0.1, 0.0, 0.0), "b", (1.2, 0.0, 0.0), (0, 0, 1), 0.1, BIMORPH, (1, -1), "9*cos(t)", 0.01
            ),
            lamc.Pouch("h2", "2e3 + 1e3*sin(3*t)", 0.02, 0.3, flat_angle=-0.1, reverse=True),
            lamc.RestAngle(),
            lamc.Servo(
                "h2",
                "0.4*sin(5*t)",
                3.0,
                0.05,
                stall_torque=0.6,
                no_load_speed=20.0,
                backlash=0.05,
                dead_band=0.1,
                gear_inertia=0.02,
                gear_stiffness=40.0,
                gear_damping=0.03,
            ),
            lamc.Spring("ground", (0.0, 0.0, 0.5), "b", (2.0, 0.0, 0.0), 4.0, 0.3, 0.1),
            lamc.Torque({"h1": 0.02, "h2": "0.1*sin(t) - rate"}),
            lamc.BaseMotion(
                (0.0, "0.01*sin(t)", 0.0), angle="0.1*t", axis=(0.0, 1.0, 0.0), point=(0.0, 0.1, 0.0)
            ),
            lamc.TwistCompliance(
                ("h2",),
                width=0.02,
                length={"h2": 0.3},
                thickness=1e-3,
                E=2e9,
                nu=0.3,
                freedoms=("twist_x", "slide_x"),
                retardation=1e-4,
                normal=(0.0, 0.1, 1.0),
            ),
            lamc.FlexibleLinks(("a",), 1, 0.02, 0.15, 1.25, static=False, laminate=SHEET),
            lamc.FreeBase(position=(0.0, 0.0, 1.0), velocity=(1.0, 0.0, 0.0), spin=(0.0, 0.2, 0.0)),
        )
    }
)


def mechanism() -> Mechanism:
    """Two links in a row from x = 0 to 2 m, with everything that effects ask of joints."""
    sheet = Slab(box(0.0, -0.15, 1.0, 0.15), -5e-4, 5e-4)
    bodies = (
        Body("ground", 2.0, (-0.5, 0.0, 0.0), np.diag([0.1, 0.2, 0.2]), fixed=True),
        Body("a", 1.0, (0.5, 0.0, 0.0), np.diag([0.01, 0.09, 0.1]), outline=(sheet,)),
        Body("b", 0.7, (1.5, 0.05, 0.0), np.diag([0.02, 0.06, 0.08])),
    )
    values = {"stiffness": 0.7, "damping": 0.03, "rest_angle": 0.2, "limits": (-1.0, 1.2)}
    joints = (
        Joint("h1", "ground", "a", (0.0, 0.0, 0.0), (0.0, 1.0, 0.0), **values),
        Joint("h2", "a", "b", (1.0, 0.0, 0.0), (0.0, 0.8, 0.6), **values),
    )
    return Mechanism(bodies, joints, name="two links")
