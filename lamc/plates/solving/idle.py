"""What of a problem does nothing, although its reader may think it does.

In: a system, and the loads of one case. Out: sentences. Never: raises for it; what touches nothing at all is an error
of the problem's own.
"""

from collections.abc import Iterator, Sequence

import numpy as np
import shapely
from numpy.typing import NDArray

from lamc.basics.checks import Array
from lamc.plates.elements.definition import DOFS
from lamc.plates.laminates.laminate import Laminate
from lamc.plates.loads import (
    EdgeLoad,
    EdgeMoment,
    ElectricField,
    LoadRecord,
    Moisture,
    PointLoad,
    SelfWeight,
    Temperature,
)
from lamc.plates.problem import Problem
from lamc.plates.solving.load_vectors import load_vector
from lamc.plates.solving.system import System
from lamc.plates.supports import Where, support_text, where_text

_MOST_LOADS = 20  # that are looked at one by one: each costs a vector of all unknowns
_NOTHING = 1e-9  # of the largest: below it is round-off
_SHARE = 1e-3  # of a line's length: what lies off the plate by less is the drawing's


def idle(system: System, loads: Sequence[LoadRecord]) -> tuple[str, ...]:
    """A note on each support and load of `loads` that does nothing, or less than it seems to."""
    problem = system.problem
    if not system.constraints.free.shape[1] and (system.constraints.owners >= 0).all():
        found = [
            "the supports hold every unknown of the plate, so nothing can move: hold less, or mesh finer"
        ]
    else:
        found = list(_on_held_nodes(system, loads))
    if not loads and not system.constraints.values.any():
        found.append("no load acts and no support prescribes a displacement, so everything is zero")
    found.extend(_off_the_plate(problem, loads))
    found.extend(text for load in loads if (text := _without_material(problem, load)))
    return tuple(dict.fromkeys(found))


def _on_held_nodes(system: System, loads: Sequence[LoadRecord]) -> Iterator[str]:
    local = [load for load in loads if isinstance(load, PointLoad | EdgeLoad | EdgeMoment)]
    if len(local) > _MOST_LOADS:
        return
    problem = system.problem
    arm, held = _arms(problem), system.constraints.fixed[_held(system)]
    for load in local:
        acting = load_vector(problem, system.kernels, [load]) / arm
        largest = np.abs(acting).max()
        if largest > 0.0 and np.abs(acting - held.T @ (held @ acting)).max() <= _NOTHING * largest:
            where = where_text(shapely.Point(load.at) if isinstance(load, PointLoad) else load.where)
            yield (
                f"the {type(load).__name__} at {where} acts on nothing but what supports hold: they take it, and the "
                "plate does not feel it"
            )


def _held(system: System) -> NDArray[np.intp]:
    """Rows of the constraints that supports ask for, not the pins of pieces in balance."""
    return np.flatnonzero(system.constraints.owners >= 0)


def _arms(problem: Problem) -> Array:
    """What makes forces of all that acts on unknowns, (N,): 1, the size of a cell, or its square, m."""
    size = float(np.sqrt(problem.mesh.areas.mean()))
    of_name = [1.0 if name in ("u", "v", "w") else size**2 if name == "w_xy" else size for name in DOFS]
    table = problem.dofs.table
    arm = np.empty(problem.dofs.count)
    arm[table[table >= 0]] = np.broadcast_to(of_name, table.shape)[table >= 0]
    return arm


def _off_the_plate(problem: Problem, loads: Sequence[LoadRecord]) -> Iterator[str]:
    placed: list[tuple[str, Where]] = [(support_text(support), support.where) for support in problem.supports]
    placed += [(hinge.title, hinge.where) for hinge in problem.hinges]
    placed += [
        (f"the {type(load).__name__}", load.where)
        for load in loads
        if isinstance(load, EdgeLoad | EdgeMoment)
    ]
    for what, where in placed:
        if isinstance(where, str):
            continue
        dimension = int(shapely.get_dimensions(where))
        if dimension == 2:  # an area is for picking, and may reach beyond
            continue
        off = shapely.difference(where, problem.places.plate)
        if dimension == 1 and off.length > _SHARE * where.length:
            yield (
                f"{what} at {where_text(where)} is {where.length:.4g} m long, of which {off.length:.4g} m lie off the "
                f"plate: only {where.length - off.length:.4g} m count"
            )
        if dimension == 0 and not off.is_empty:
            count, all_of = len(shapely.get_parts(off)), len(shapely.get_parts(where))
            yield f"{what} at {where_text(where)}: {count} of the {all_of} points lie off the plate and hold nothing"


def _without_material(problem: Problem, load: LoadRecord) -> str:
    """Where no laminate that a load acts on has the property by which it acts."""
    needs, rule = _NEEDS.get(type(load), ((), ""))
    region = getattr(load, "region", None)
    if not needs:
        return ""
    names = problem.mesh.region_names
    of = [lam for lam, name in zip(problem.laminates, names, strict=True) if region in (None, name)]
    if any(_has(laminate, needs) for laminate in of):
        return ""
    where = f"region {region!r}" if region else "the plate"
    return f"the {type(load).__name__} does nothing: no ply of {where} {rule}; give its material {needs[0]}"


_NEEDS: dict[type, tuple[tuple[str, ...], str]] = {
    ElectricField: (("d31", "d32"), "is piezoelectric"),
    SelfWeight: (("density",), "has a mass"),
    Moisture: (("beta1", "beta2"), "expands with moisture"),
    Temperature: (("alpha1", "alpha2"), "expands with temperature"),
}


def _has(laminate: Laminate, names: Sequence[str]) -> bool:
    return any(getattr(ply.material, name) != 0.0 for ply in laminate.plies for name in names)
