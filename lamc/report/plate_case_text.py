"""What `lamc plate` tells of one case: extremes, strength, energy, reactions, errors, notes.

In: a `CaseReport`. Out: rows of a label and a text. It measures nothing and prints nothing.
"""

import math

import numpy as np

from lamc.basics.numbers import place_text, prefixed, shortened, shown_number
from lamc.plates.answers.corner_fields import Extreme
from lamc.plates.answers.estimate import ErrorEstimate
from lamc.plates.answers.hinge_rotations import HingeRotation
from lamc.report.failure_text import failure_text
from lamc.report.plate_marks import load_text, vector_text
from lamc.report.plate_records import CaseReport, Halved

_DIGITS = 5
_HINGES = 12  # lines that are reported


def case_rows(case: CaseReport) -> list[tuple[str, str]]:
    """All that is told of a case."""
    solution, accuracy = case.solution, case.solution.report.accuracy
    if not solution.loads and not solution.values.any():
        return [*_name(case), ("loads", "none, and nothing is prescribed: the plate stays as it is")]
    energy = _kept(solution.strain_energy, case.fields.smallest_energy)
    digits = (
        f"{solution.report.solver}: condition {accuracy.condition:.1e}, {_count(accuracy.steps, 'step', 'steps')} of "
        f"refinement, unknowns to {max(accuracy.forward_error, 1e-16):.0e}"
    )
    rows = _name(case)
    rows.append(("loads", ", ".join(load_text(load) for load in solution.loads) or "none"))
    rows += [(name, _extreme_text(*found, solution.problem.size)) for name, found in case.extremes.items()]
    if case.strength is not None:
        rows.append(("fails", failure_text(case.strength, solution.problem.size)))
    rows.append(("energy", f"{shown_number(energy, 'J')} stored"))
    rows += [
        ("hinge", _hinge(turn, number)) for number, turn in enumerate(solution.hinges[:_HINGES], start=1)
    ]
    if len(solution.hinges) > _HINGES:
        rows.append(("hinge", f"… {len(solution.hinges)} in all"))
    rows.append(("reactions", _reactions(case)))
    rows.append(("error", _error(case.estimate)))
    rows += [("halved", _halved_text(each)) for each in case.halved]
    rows.append(("digits", digits))
    rows += [("free", solution.report.free)] if solution.report.free else []
    rows += [("note", note) for note in case.notes]
    return rows


def _name(case: CaseReport) -> list[tuple[str, str]]:
    return [("case", case.name)] if case.name else []


def _halved_text(each: Halved) -> str:
    """What halved cells make of a value."""
    error = each.error
    value, finer, limit = (
        shown_number(number, each.unit, 7) for number in (error.value, error.finer, error.extrapolated)
    )
    part = f", {100.0 * error.error / abs(error.extrapolated):.2g} % off" if error.extrapolated else ""
    name = shortened(each.output.name, 32)
    return f"{name}, {each.output.value}: {value}; on halved cells {finer}; tends to {limit}{part}"


def _error(estimate: ErrorEstimate) -> str:
    worst = estimate.worst_region or "the rest"
    where = f", most of it in {worst!r}" if len(estimate.regions) > 1 else ""
    return f"about {100.0 * estimate.relative:.2g} % in stress and strain on average{where}; deflections are better"


def _count(number: int, one: str, many: str) -> str:
    return f"{number} {one if number == 1 else many}"


def _extreme_text(unit: str, low: Extreme, high: Extreme, size: float) -> str:
    """Both values in one unit, with as many decimals as the larger needs."""
    largest = max(abs(low.value), abs(high.value))
    if high.value - low.value <= 1e-9 * largest:
        return f"{shown_number(high.value, unit)} everywhere"
    scale, name = prefixed(largest, unit)
    decimals = _DIGITS - 1 - math.floor(math.log10(largest / scale))
    reported = []
    for each in (low, high):
        value = f"{round(each.value / scale, decimals) + 0.0:.{_DIGITS}g} {name}".rstrip()
        reported.append(f"{value} at {place_text(each.at, size)}")
    return " to ".join(reported)


def _reactions(case: CaseReport) -> str:
    """Their sum, and how well they balance the loads."""
    solution = case.solution
    if not solution.reactions:
        return "no supports"
    total = np.sum([r.force for r in solution.reactions], axis=0)
    least = max(case.fields.smallest_force, 1e-9 * float(np.abs(total).max()))
    reported = vector_text([_kept(float(part), least) for part in total], "N")
    balance = solution.report.accuracy.backward_error
    return f"{reported} in all; out of balance by {balance:.0e} of what acts"


def _hinge(turn: HingeRotation, number: int) -> str:
    """How far a hinge line turns, and what its spring holds."""
    name = shortened(turn.hinge.name, 24) or f"line {number}"
    rotation = turn.largest
    fold = "" if rotation == 0.0 else ", valley" if rotation > 0.0 else ", mountain"
    spring = (
        f"{shown_number(turn.hinge.stiffness, 'N/rad')}, {shown_number(turn.energy, 'J')} stored"
        if turn.hinge.stiffness > 0.0
        else "turns freely"
    )
    return f"{name}: turns by {shown_number(rotation, 'rad')} at most{fold}; {spring}"


def _kept(value: float, least: float) -> float:
    """`value`, or zero where it is round-off."""
    return value if abs(value) > least else 0.0
