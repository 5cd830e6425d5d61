"""What a plate gives way by, between a few of its points.

In: a problem; its supports count, its loads do not. Out: a small symmetric matrix. Never: the dent in the
plane under a point load, which grows without end as the mesh is refined.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from lamc.basics.checks import Array, checked_array, checked_kind
from lamc.basics.errors import DesignError
from lamc.plates.answers.model import FactoredPlate
from lamc.plates.loads import PointLoad
from lamc.plates.problem import Problem
from lamc.plates.solving.load_vectors import load_vector


def flexibility(
    problem: Problem, at: Sequence[Sequence[float]] | Array, along: Sequence[float] = (0.0, 0.0, 1.0)
) -> Array:
    """Displacements along a direction at points, each by 1 N along it at every other, m/N, shape (k, k), symmetric.

    at     (k, 2), m
    along  (x, y, z); of any length

    One factorisation serves all points. Raises DesignError for points off the plate, a direction that is zero, and
    where the supports leave the plate free to move.
    """
    checked_kind(problem, Problem, "the problem of a flexibility", "make one of a mesh and a laminate")
    count = len(at) if hasattr(at, "__len__") else 0
    points = checked_array(at, (count, 2), "the points of a flexibility")
    direction = checked_array(along, (3,), "the direction of a flexibility")
    length = float(np.linalg.norm(direction))
    if not length > 0.0:
        raise DesignError("the direction of a flexibility is zero; give one such as (0, 0, 1)")
    loads = [PointLoad(tuple(point), tuple(direction / length)) for point in points.tolist()]
    still = replace(problem, loads=loads, cases={})  # loads in the plane bring a membrane
    model = FactoredPlate(still)
    columns = [load_vector(still, model.system.kernels, [load]) for load in loads]
    answers = [model.solve([load]).values for load in loads]
    held = model.system.constraints
    prescribed = held.fixed.T @ held.values
    if prescribed.any():
        rest = model.solve([]).values
        answers = [answer - rest for answer in answers]
    found = np.array(columns) @ np.array(answers).T
    return np.asarray(0.5 * (found + found.T))
