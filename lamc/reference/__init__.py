"""The independent cross-checks: numeric paths that share no code with the symbolic one, and the interpreter.

`lamc.reference.sympy_kane` (sympy's own KanesMethod) is not imported here, because sympy.physics takes long.
"""

from lamc.reference.check import check
from lamc.reference.check_report import Report
from lamc.reference.integrate import Run, cross_check, fixed_steps, initial_state, simulate
from lamc.reference.interpreter import Interpreter
from lamc.reference.lagrange import Lagrange
from lamc.reference.maximal import MaximalCoordinates
from lamc.reference.newton_euler import NewtonEuler

__all__ = [
    "Interpreter",
    "Lagrange",
    "MaximalCoordinates",
    "NewtonEuler",
    "Report",
    "Run",
    "check",
    "cross_check",
    "fixed_steps",
    "initial_state",
    "simulate",
]
