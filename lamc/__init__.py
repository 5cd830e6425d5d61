"""lamc compiles laminate designs into fast native simulators.

    import lamc

    design = lamc.load("pendulum.cad")
    sim = lamc.compile(design)
    result = sim.run(t_end=10.0)
    result.angle("h1")

Everything public is listed in `__all__`; everything else may change.
"""

import logging
from typing import TYPE_CHECKING

from lamc.basics import drawing
from lamc.basics._version import __version__
from lamc.basics.errors import (
    BuildError,
    DesignError,
    DesignWarning,
    EmitError,
    ExportError,
    ExpressionError,
    LamcError,
    RequestError,
    SimulationError,
    TopologyError,
    UnsupportedError,
)
from lamc.basics.moved import renamed
from lamc.basics.times import Times
from lamc.codegen.options import CompileOptions
from lamc.design.split import split
from lamc.effects import (
    BaseMotion,
    BladeElementDrag,
    Cable,
    Effect,
    ExternalTorque,
    FlexibleLinks,
    FreeBase,
    Gravity,
    GroundContact,
    HingeDamping,
    HingeStiffness,
    JointLimits,
    LinearMotor,
    NonlinearStiffness,
    PiezoBender,
    Pouch,
    RestAngle,
    Servo,
    Spring,
    Torque,
    TwistCompliance,
)
from lamc.export import convert, export
from lamc.export.options import ExportOptions
from lamc.fitting.answer import Fit
from lamc.fitting.fit import fit
from lamc.pipeline import compile  # noqa: A004  the public name is lamc.compile
from lamc.readers.inert import Limits
from lamc.readers.load import load
from lamc.readers.load_scene import load_scene
from lamc.records.card import Card
from lamc.records.design import Design, Material
from lamc.records.family import Family
from lamc.records.inputs import Input
from lamc.records.mechanism import Body, Joint, Mechanism, Slab
from lamc.records.parameters import DesignParameter
from lamc.records.recording import Camera, Free, Marker, Recording
from lamc.records.scene import OutputPoint, Scene
from lamc.records.series import Series
from lamc.run.ensemble import Ensemble
from lamc.run.equilibrium import Equilibrium
from lamc.run.gradients import Gradient
from lamc.run.linear_model import LinearModel
from lamc.run.result import Result
from lamc.run.simulator import Simulator
from lamc.run.vibration import Modes
from lamc.studies.optimise import optimise
from lamc.studies.sweep import sweep

__all__ = [
    "BaseMotion",
    "BladeElementDrag",
    "Body",
    "BuildError",
    "Cable",
    "Camera",
    "Card",
    "CompileOptions",
    "Design",
    "DesignError",
    "DesignParameter",
    "DesignWarning",
    "Effect",
    "EmitError",
    "Ensemble",
    "Equilibrium",
    "ExportError",
    "ExportOptions",
    "ExpressionError",
    "ExternalTorque",
    "Family",
    "Fit",
    "FlexibleLinks",
    "Free",
    "FreeBase",
    "Gradient",
    "Gravity",
    "GroundContact",
    "HingeDamping",
    "HingeStiffness",
    "Input",
    "Joint",
    "JointLimits",
    "LamcError",
    "Limits",
    "LinearModel",
    "LinearMotor",
    "Marker",
    "Material",
    "Mechanism",
    "Modes",
    "NonlinearStiffness",
    "OutputPoint",
    "PiezoBender",
    "Pouch",
    "Recording",
    "RequestError",
    "RestAngle",
    "Result",
    "Scene",
    "Series",
    "Servo",
    "SimulationError",
    "Simulator",
    "Slab",
    "Spring",
    "Times",
    "TopologyError",
    "Torque",
    "TwistCompliance",
    "UnsupportedError",
    "__version__",
    "compile",
    "convert",
    "export",
    "fit",
    "load",
    "load_scene",
    "optimise",
    "split",
    "sweep",
]

logging.getLogger("lamc").addHandler(logging.NullHandler())  # whoever wants its words adds a handler

_SEEN = ("Design", "Mechanism", "Problem", "Result", "Simulator", "Solution")
drawing.tell(  # (kind of record, verb) → "module:function", imported when the verb is used
    {
        **{(kind, verb): f"lamc.export.pages:{verb}" for kind in _SEEN for verb in ("view", "frame")},
        ("Design", "vary"): "lamc.readers.design_as_such:vary_design",
        ("Design", "draw"): "lamc.report.drawn:draw_design",
        ("Mechanism", "draw"): "lamc.report.drawn:draw_mechanism",
        ("Simulator", "remake"): "lamc.pipeline:compile",
        ("Solution", "plot"): "lamc.report.plate_plot:plot",
        ("Result", "gradient"): "lamc.studies.gradient:gradient",
        ("Result", "plot"): "lamc.report.plots:plot",
        ("Result", "animate"): "lamc.report.animation:animate",
        ("Fit", "animate"): "lamc.report.fit_film:animate",
    }
)


def __dir__() -> list[str]:
    return sorted(__all__)


if not TYPE_CHECKING:  # a type checker shall miss the old name
    __getattr__ = renamed("lamc", {"Plate": "lamc.Slab"})
