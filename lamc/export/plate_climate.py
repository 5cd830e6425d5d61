"""What makes the laminates of an exported plate expand: temperature, moisture and electric fields, as parameters.

In: the loads of every case. Out: numbers per case and region, which C multiplies with what its plies expand. Never:
resultants or forces, which C takes from its plies and its element.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from lamc.basics.checks import Array
from lamc.basics.errors import ExportError, about
from lamc.plates.laminates.climate import Climate, climates
from lamc.plates.laminates.graded import level_of
from lamc.plates.loads import CLIMATES, ElectricField, LoadRecord, Moisture, Temperature
from lamc.plates.problem import Problem

# Of each kind: what materials answer it with, and its parameter.
EXPANSIONS: dict[type, tuple[tuple[str, str], str]] = {
    Temperature: (("alpha1", "alpha2"), "temperature"),
    Moisture: (("beta1", "beta2"), "moisture"),
    ElectricField: (("d31", "d32"), "field"),
}


@dataclass(frozen=True, eq=False)
class ClimateTables:
    """Of R regions and all cases of loads.

    kinds        of loads that are there, in the order of EXPANSIONS
    temperature  (cases, R), K; moisture (cases, R)
    fields       of case after case, region after region, ply after ply, V/m
    begins       (cases R): where the fields of each begin
    left_out     names of loads that C does not have
    """

    kinds: tuple[type, ...]
    temperature: Array
    moisture: Array
    fields: tuple[float, ...]
    begins: tuple[int, ...]
    left_out: tuple[str, ...]


def climate_tables(
    problem: Problem, cases: Mapping[str, Sequence[LoadRecord]], *, lossy: bool
) -> ClimateTables:
    """Of `cases`, what acts in every case included. Raises ExportError for one that varies within a region, which is
    left out where `lossy`."""
    kinds: set[type] = set()
    left_out: dict[str, None] = {}
    found: list[Climate] = []
    for acting in cases.values():
        kept = []
        for load in acting:
            if not isinstance(load, CLIMATES):
                continue
            what = _unlike(load)
            if what:
                left_out[what] = None
                with about(load):
                    _check_may_go(what, lossy=lossy)
                continue
            kinds.add(type(load))
            kept.append(load)
        found += [of.uniform for of in climates(problem.laminates, kept, problem.mesh.region_names)]
    fields = [of.fields for of in found]
    shape = (len(cases), len(problem.mesh.region_names))
    return ClimateTables(
        kinds=tuple(kind for kind in EXPANSIONS if kind in kinds),
        temperature=np.reshape([float(level_of(of.temperature)) for of in found], shape),
        moisture=np.reshape([float(level_of(of.moisture)) for of in found], shape),
        fields=tuple(np.concatenate(fields).tolist()),
        begins=tuple(np.cumsum([0, *map(len, fields[:-1])]).tolist()),
        left_out=tuple(left_out),
    )


def _check_may_go(what: str, *, lossy: bool) -> None:
    if not lossy:
        raise ExportError(
            f"the plate has a load {what}; exported C has those that are the same all over a region and through its "
            "thickness: give it a number, region by region, or leave it out with --lossy (in Python lossy=True)"
        )


def _unlike(load: Temperature | Moisture | ElectricField) -> str:
    """What C does not have of it, as a message says it; "" where it has all."""
    name = type(load).__name__
    if isinstance(load, Temperature | Moisture) and load.has_gradient:
        return f"{name} that changes through the thickness"
    return f"{name} that varies from place to place" if _varies(load) else ""


def _varies(load: Temperature | Moisture | ElectricField) -> bool:
    """Whether it is a function of the place."""
    if isinstance(load, Temperature):
        return callable(load.rise)
    if isinstance(load, Moisture):
        return callable(load.content)
    return any(map(callable, load.field)) if isinstance(load.field, Sequence) else callable(load.field)
