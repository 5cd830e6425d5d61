"""Methods that look in the whole box: differential evolution (Storn & Price 1997) by scipy, CMA-ES (Hansen 2016) by the
package cma. Whole numbers and choices are shares of an edge.

In: a problem, a seed. Out: the place of the best trial. They compare trials by merit: constraints first.
"""

from importlib import import_module
from typing import Any

import numpy as np
from scipy import optimize

from lamc.basics.errors import LamcError
from lamc.run.request import Array
from lamc.studies.problem import Problem

_SAME = 1e-9  # spread of merits at which a population has nothing left to tell apart


def differential_evolution(problem: Problem, start: Array, seed: int) -> Array:
    """best/1/bin with dithering, from a Latin hypercube and the start."""
    edges = len(start)

    def merits(population: Array) -> Array:
        """Of columns (n, k): a generation at once."""
        places = list(np.atleast_2d(population.T))
        problem.ahead(places)
        return np.array([problem.merit(problem.at(each)) for each in places])

    optimize.differential_evolution(
        merits,
        [(0.0, 1.0)] * edges,
        rng=np.random.default_rng(seed),
        x0=start,
        init="latinhypercube",
        popsize=max(10, 40 // edges),
        maxiter=100,
        tol=1e-6,
        atol=_SAME,
        polish=False,
        vectorized=True,
        updating="deferred",
    )
    return _best(problem, start)


def cma_es(problem: Problem, start: Array, seed: int) -> Array:
    """Two restarts with twice the population each. Raises LamcError without cma."""
    cma = needed("cma", "CMA-ES")
    size = 4 + int(3 * np.log(len(start)))
    at = start
    for turn in range(3):
        options = {
            "bounds": [0.0, 1.0],
            "seed": seed + turn + 1,  # 0 is the clock's
            "verbose": -9,
            "popsize": size * 2**turn,
            "tolfun": _SAME,
            "tolx": 1e-7,
            "maxiter": 150,
            "maxstd": 1.0,  # its own default fails with bounds in one dimension (cma 4.5)
        }
        run = cma.CMAEvolutionStrategy(at.tolist(), 0.25, options)
        while not run.stop():
            asked = run.ask()
            places = [np.clip(each, 0.0, 1.0) for each in asked]
            problem.ahead(places)
            run.tell(asked, [problem.merit(problem.at(each)) for each in places])
        at = _best(problem, start)
    return at


def needed(package: str, what: str) -> Any:
    """The module of an optional package, or LamcError with what to install."""
    try:
        return import_module(package)
    except ImportError as error:
        raise LamcError(
            f"{what} needs {package}: pip install lamc[optimise]; or take another method"
        ) from error


def _best(problem: Problem, start: Array) -> Array:
    best = problem.best()
    return start if best is None else problem.space.places(best.point)
