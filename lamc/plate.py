"""Plates: how a laminate bends.

In: plies with materials and angles, or a body of a laminate design; supports and loads. Out: the stiffness of the
laminate, deflections, strains and stresses. Never: motion; what is a plate here is a rigid body there.

    from lamc import plate

    cfrp = plate.Material(E1=350e9, E2=7e9, nu12=0.33, G12=5e9, density=1600)
    laminate = plate.Laminate([plate.Ply(cfrp, 50e-6, angle) for angle in (45, 22.5, 45)])  # bottom to top
    laminate.A, laminate.B, laminate.D

    side = shapely.LineString([(0, 0), (0, 2e-3)])
    tip = plate.PointLoad((10e-3, 1e-3), 1e-3)  # N, upwards
    problem = plate.Problem(plate.grid(10e-3, 2e-3, 40, 8), laminate, supports=[plate.Clamped(side)], loads=[tip])
    plate.solve(problem).deflection(10e-3, 1e-3)
"""

from typing import TYPE_CHECKING

from lamc.basics.moved import renamed
from lamc.plates import records
from lamc.plates.answers.buckling import buckling
from lamc.plates.answers.choice import choose_element
from lamc.plates.answers.convergence import converge, error_of
from lamc.plates.answers.failure import first_failure
from lamc.plates.answers.flexibility import flexibility
from lamc.plates.answers.gradients import gradient
from lamc.plates.answers.hinge_stiffness import hinge_stiffness
from lamc.plates.answers.model import FactoredPlate, solve
from lamc.plates.answers.modes import modes
from lamc.plates.answers.shape_pairs import halved_buckling, halved_modes
from lamc.plates.answers.solution import Solution
from lamc.plates.designs.from_design import plate_of
from lamc.plates.elements import ELEMENTS, Element, Node, combine, corners, describe, edges, element
from lamc.plates.elements.kernels import kernels
from lamc.plates.foundations import ElasticFoundation
from lamc.plates.hinge_lines import HingeLine
from lamc.plates.laminates.failure import first_ply_failure, ply_failures
from lamc.plates.laminates.graded import Graded
from lamc.plates.laminates.laminate import Laminate
from lamc.plates.laminates.library import LIBRARY, material
from lamc.plates.laminates.materials import Material
from lamc.plates.laminates.plies import Ply
from lamc.plates.loads import (
    EdgeLoad,
    EdgeMoment,
    ElectricField,
    Moisture,
    PointLoad,
    Pressure,
    SelfWeight,
    Temperature,
)
from lamc.plates.memory import estimate_memory
from lamc.plates.meshing.changes import jittered, refined
from lamc.plates.meshing.files import read_mesh, write_mesh
from lamc.plates.meshing.grid import grid, grid_of_lines, lines
from lamc.plates.meshing.mesh import Mesh
from lamc.plates.meshing.mesher import mesh
from lamc.plates.meshing.report import bciz_bias, mesh_report
from lamc.plates.problem import Problem
from lamc.plates.supports import Clamped, Hinged, SimplySupported, Support, Symmetry
from lamc.readers.plates.problem_file import load_plate
from lamc.readers.plates.problem_make import problem_of
from lamc.readers.plates.problem_records import PlateFile

__all__ = [
    "ELEMENTS",
    "LIBRARY",
    "Clamped",
    "EdgeLoad",
    "EdgeMoment",
    "ElasticFoundation",
    "ElectricField",
    "Element",
    "FactoredPlate",
    "Graded",
    "HingeLine",
    "Hinged",
    "Laminate",
    "Material",
    "Mesh",
    "Moisture",
    "Node",
    "PlateFile",
    "Ply",
    "PointLoad",
    "Pressure",
    "Problem",
    "SelfWeight",
    "SimplySupported",
    "Solution",
    "Support",
    "Symmetry",
    "Temperature",
    "bciz_bias",
    "buckling",
    "choose_element",
    "combine",
    "converge",
    "corners",
    "describe",
    "edges",
    "element",
    "error_of",
    "estimate_memory",
    "first_failure",
    "first_ply_failure",
    "flexibility",
    "gradient",
    "grid",
    "grid_of_lines",
    "halved_buckling",
    "halved_modes",
    "hinge_stiffness",
    "jittered",
    "kernels",
    "lines",
    "load_plate",
    "material",
    "mesh",
    "mesh_report",
    "modes",
    "plate_of",
    "ply_failures",
    "problem_of",
    "read_mesh",
    "refined",
    "solve",
    "write_mesh",
]


def __dir__() -> list[str]:
    return sorted(__all__)


if not TYPE_CHECKING:  # a type checker shall miss the old names
    __getattr__ = renamed(
        "lamc.plate",
        {
            "Gravity": "lamc.plate.SelfWeight",
            "Model": "lamc.plate.FactoredPlate",
            "HingeTurn": "lamc.plates.records.HingeRotation",
            "Modes": "lamc.plates.records.PlateModes",
            "HingeStiffness": "lamc.plates.records.FilmStiffness",
        }
        | {name: f"lamc.plates.records.{name}" for name in records.__all__},
    )
