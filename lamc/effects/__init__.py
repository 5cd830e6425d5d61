"""Effects: one module each, known to the rest of lamc through `registry.py` only."""

from lamc.effects.base_motion import BaseMotion
from lamc.effects.bender import PiezoBender
from lamc.effects.blade_element import BladeElementDrag
from lamc.effects.cable import Cable
from lamc.effects.external_torque import ExternalTorque
from lamc.effects.flexible import FlexibleLinks
from lamc.effects.free_base import FreeBase
from lamc.effects.gravity import Gravity
from lamc.effects.ground_contact import GroundContact
from lamc.effects.hinges import HingeDamping, HingeStiffness, RestAngle
from lamc.effects.limits import JointLimits
from lamc.effects.motor import LinearMotor
from lamc.effects.nonlinear import NonlinearStiffness
from lamc.effects.pouch import Pouch
from lamc.effects.servo import Servo
from lamc.effects.spring import Spring
from lamc.effects.torque import Torque
from lamc.effects.twist import TwistCompliance
from lamc.records.effect import Effect

__all__ = [
    "BaseMotion",
    "BladeElementDrag",
    "Cable",
    "Effect",
    "ExternalTorque",
    "FlexibleLinks",
    "FreeBase",
    "Gravity",
    "GroundContact",
    "HingeDamping",
    "HingeStiffness",
    "JointLimits",
    "LinearMotor",
    "NonlinearStiffness",
    "PiezoBender",
    "Pouch",
    "RestAngle",
    "Servo",
    "Spring",
    "Torque",
    "TwistCompliance",
]
