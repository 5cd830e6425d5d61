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

from lamc.plate.answers.buckling import Buckling, buckling
from lamc.plate.answers.choice import Choice, choose_element
from lamc.plate.answers.convergence import Convergence, ConvergenceRow, QuantityError, converge, error_of
from lamc.plate.answers.estimate import ErrorEstimate
from lamc.plate.answers.failure import PlateFailure, first_failure
from lamc.plate.answers.flexibility import flexibility
from lamc.plate.answers.gradients import gradient
from lamc.plate.answers.hinge_stiffness import HingeStiffness, hinge_stiffness
from lamc.plate.answers.hinge_turns import HingeTurn
from lamc.plate.answers.modes import Modes, modes
from lamc.plate.answers.shape_pairs import ShapePair, halved_buckling, halved_modes
from lamc.plate.designs.from_design import DesignPlate, plate_of
from lamc.plate.designs.hinge_edges import HingeEdge
from lamc.plate.elements import ELEMENTS, Element, Node, combine, corners, describe, edges, element
from lamc.plate.elements.assembly import Assembly
from lamc.plate.elements.kernels import ElementKernels, kernels
from lamc.plate.files.problem_file import load_plate
from lamc.plate.files.problem_make import problem_of
from lamc.plate.files.problem_records import PlateFile
from lamc.plate.foundations import ElasticFoundation
from lamc.plate.hinge_lines import HingeLine
from lamc.plate.laminates.failure import FirstPlyFailure, PlyFailure, first_ply_failure, ply_failures
from lamc.plate.laminates.graded import Graded
from lamc.plate.laminates.laminate import Laminate
from lamc.plate.laminates.library import LIBRARY, material
from lamc.plate.laminates.materials import Material
from lamc.plate.laminates.plies import Deformation, EngineeringConstants, Ply, PlyState, Resultants
from lamc.plate.loads import (
    EdgeLoad,
    EdgeMoment,
    ElectricField,
    Gravity,
    Moisture,
    PointLoad,
    Pressure,
    Temperature,
)
from lamc.plate.memory import Memory, estimate_memory
from lamc.plate.meshing.changes import jittered, refined
from lamc.plate.meshing.files import read_mesh, write_mesh
from lamc.plate.meshing.grid import grid, grid_of_lines, lines
from lamc.plate.meshing.mesh import Mesh
from lamc.plate.meshing.mesher import mesh
from lamc.plate.meshing.report import MeshReport, bciz_bias, mesh_report
from lamc.plate.problem import Problem
from lamc.plate.solving.model import Model, solve
from lamc.plate.solving.reactions import Reaction
from lamc.plate.solving.refine import Accuracy
from lamc.plate.solving.solution import Solution, SolveReport
from lamc.plate.supports import Clamped, Hinged, SimplySupported, Support, Symmetry

__all__ = [
    "ELEMENTS",
    "LIBRARY",
    "Accuracy",
    "Assembly",
    "Buckling",
    "Choice",
    "Clamped",
    "Convergence",
    "ConvergenceRow",
    "Deformation",
    "DesignPlate",
    "EdgeLoad",
    "EdgeMoment",
    "ElasticFoundation",
    "ElectricField",
    "Element",
    "ElementKernels",
    "EngineeringConstants",
    "ErrorEstimate",
    "FirstPlyFailure",
    "Graded",
    "Gravity",
    "HingeEdge",
    "HingeLine",
    "HingeStiffness",
    "HingeTurn",
    "Hinged",
    "Laminate",
    "Material",
    "Memory",
    "Mesh",
    "MeshReport",
    "Model",
    "Modes",
    "Moisture",
    "Node",
    "PlateFailure",
    "PlateFile",
    "Ply",
    "PlyFailure",
    "PlyState",
    "PointLoad",
    "Pressure",
    "Problem",
    "QuantityError",
    "Reaction",
    "Resultants",
    "ShapePair",
    "SimplySupported",
    "Solution",
    "SolveReport",
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
