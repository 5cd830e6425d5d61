"""What `lamc plate` found, as plain data for programs: SI, full precision.

In: a `PlateReport`. Out: numbers, strings, lists and maps. Never: files.
"""

from typing import Any

from lamc.plates.answers.failure import PlateFailure
from lamc.plates.answers.modes import PlateModes
from lamc.plates.laminates.laminate import Laminate
from lamc.report.plate_records import MODES, CaseReport, PlateReport, ShapeReport, buckling_key
from lamc.report.plate_text import angles, by_region


def data(report: PlateReport) -> dict[str, Any]:
    """The report as plain data: summary.json, and the answer to --json. SI."""
    mesh, element = report.problem.mesh, report.problem.dofs.element
    low, high = angles(mesh)
    return {
        "ok": not report.errors,
        "plate": report.file.name,
        "source": report.source,
        "mesh": {
            "points": len(mesh.points),
            "cells": len(mesh.cells),
            "corners": mesh.corner_count,
            "pattern": mesh.pattern,
            "regions": list(mesh.region_names),
            "smallest_angle": low,
            "largest_angle": high,
        },
        "element": element.name,
        "unknowns": report.problem.dofs.count,
        "laminates": {name: _laminate_data(stack) for name, stack in by_region(report.problem)},
        "cases": {case.name: _case_data(case) for case in report.cases},
        "failed_cases": list(report.failed),
        "notes": list(report.file.notes),
        "modes": None
        if report.modes is None
        else _modes_data(report.modes) | _shape_data(report.shapes[MODES]),
        "buckling": {name: b.factors.tolist() for name, b in report.buckling.items()},
        "buckling_errors": {
            name: _shape_data(report.shapes[buckling_key(name)], len(b.factors))
            for name, b in report.buckling.items()
        },
        "seconds": dict(report.times.seconds),
    }


def _laminate_data(laminate: Laminate) -> dict[str, Any]:
    return {
        "thickness": laminate.thickness,
        "areal_mass": laminate.areal_mass,
        "A": laminate.A.tolist(),
        "B": laminate.B.tolist(),
        "D": laminate.D.tolist(),
    }


def _case_data(case: CaseReport) -> dict[str, Any]:
    solution = case.solution
    accuracy = solution.report.accuracy
    return {
        "extremes": {
            name: {
                "unit": unit,
                "least": low.value,
                "least_at": list(low.at),
                "largest": high.value,
                "largest_at": list(high.at),
            }
            for name, (unit, low, high) in case.extremes.items()
        },
        "outputs": [
            {
                "name": p.output.name,
                "at": list(p.output.at),
                "value": p.output.value,
                "unit": p.unit,
                "is": p.value,
                "expected": p.output.expected,
            }
            for p in case.printed
        ],
        "two_meshes": [
            {
                "name": h.output.name,
                "at": list(h.output.at),
                "value": h.output.value,
                "unit": h.unit,
                "is": h.error.value,
                "finer": h.error.finer,
                "extrapolated": h.error.extrapolated,
                "error": h.error.error,
            }
            for h in case.halved
        ],
        "first_failure": None if case.strength is None else _failure_data(case.strength),
        "strain_energy": solution.strain_energy,
        "hinges": [
            {
                "name": rotation.hinge.name,
                "stiffness": rotation.hinge.stiffness,
                "length": rotation.length,
                "rotation": rotation.largest,
                "energy": rotation.energy,
            }
            for rotation in solution.hinges
        ],
        "reactions": [{"force": r.force.tolist(), "moment": r.moment.tolist()} for r in solution.reactions],
        "relative_error": case.estimate.relative,
        "solver": solution.report.solver,
        "condition": accuracy.condition,
        "refinement_steps": accuracy.steps,
        "forward_error": accuracy.forward_error,
        "backward_error": accuracy.backward_error,
        "notes": list(case.notes),
    }


def _failure_data(failure: PlateFailure) -> dict[str, Any]:
    return {
        "criterion": failure.criterion,
        "ratio": failure.ratio,
        "at": list(failure.at),
        "region": failure.region,
        "ply": failure.number,
        "face": failure.face,
        "mode": failure.mode,
        "not_judged": list(failure.unjudged),
        "off": failure.off,
        "sharp": failure.sharp,
    }


def _shape_data(shape: ShapeReport, count: int | None = None) -> dict[str, Any]:
    """Of the first `count`, or of all."""
    return {
        "relative_errors": shape.errors[:count].tolist(),
        "notes": list(shape.notes),
        "two_meshes": [
            {"number": pair.number + 1, "mac": pair.mac}
            | (
                {"is": None, "finer": None, "extrapolated": None, "error": None}
                if pair.error is None
                else {
                    "is": pair.error.value,
                    "finer": pair.error.finer,
                    "extrapolated": pair.error.extrapolated,
                    "error": pair.error.error,
                }
            )
            for pair in shape.halved
        ],
    }


def _modes_data(modes: PlateModes) -> dict[str, Any]:
    return {
        "frequencies": modes.frequencies.tolist(),
        "modal_mass": modes.modal_mass.tolist(),
        "effective_mass": modes.effective_mass.tolist(),
        "rigid": list(modes.rigid),
    }
