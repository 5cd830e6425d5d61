"""Records that plates are answered with, for annotations and `isinstance`: functions of `lamc.plate` make them.

In: what the rooms beside it define. Out: the same names in one place. Never: what users construct, such as loads; a
name that `lamc` or `lamc.plate` has for something else.
"""

from typing import TYPE_CHECKING

from lamc.basics.moved import renamed
from lamc.plates.answers.buckling import Buckling
from lamc.plates.answers.choice import Choice
from lamc.plates.answers.convergence import Convergence, ConvergenceRow, QuantityError
from lamc.plates.answers.estimate import ErrorEstimate
from lamc.plates.answers.failure import PlateFailure
from lamc.plates.answers.hinge_rotations import HingeRotation
from lamc.plates.answers.hinge_stiffness import FilmStiffness
from lamc.plates.answers.modes import PlateModes
from lamc.plates.answers.shape_pairs import ShapePair
from lamc.plates.answers.solution import SolveReport
from lamc.plates.designs.from_design import DesignPlate
from lamc.plates.designs.hinge_edges import HingeEdge
from lamc.plates.elements.kernels import ElementKernels
from lamc.plates.laminates.failure import FirstPlyFailure, PlyFailure
from lamc.plates.laminates.plies import Deformation, EngineeringConstants, PlyState, Resultants
from lamc.plates.memory import Memory
from lamc.plates.meshing.report import MeshReport
from lamc.plates.solving.assembly import Assembly
from lamc.plates.solving.reactions import Reaction
from lamc.plates.solving.refine import Accuracy

if not TYPE_CHECKING:  # a type checker shall miss the old names
    __getattr__ = renamed(
        "lamc.plates.records",
        {
            "Modes": "lamc.plates.records.PlateModes",
            "HingeStiffness": "lamc.plates.records.FilmStiffness",
        },
    )

__all__ = [
    "Accuracy",
    "Assembly",
    "Buckling",
    "Choice",
    "Convergence",
    "ConvergenceRow",
    "Deformation",
    "DesignPlate",
    "ElementKernels",
    "EngineeringConstants",
    "ErrorEstimate",
    "FilmStiffness",
    "FirstPlyFailure",
    "HingeEdge",
    "HingeRotation",
    "Memory",
    "MeshReport",
    "PlateFailure",
    "PlateModes",
    "PlyFailure",
    "PlyState",
    "QuantityError",
    "Reaction",
    "Resultants",
    "ShapePair",
    "SolveReport",
]
