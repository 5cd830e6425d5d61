"""What `lamc plate` tells at its end: mesh, element, laminates, results by case, trust, times, files.

In: a `PlateReport`. Out: plain text. It measures nothing and prints nothing.
"""

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from lamc.basics.numbers import duration, place_text, prefixed, shortened, shown_number
from lamc.basics.times import Times
from lamc.plates.laminates.laminate import Laminate
from lamc.plates.meshing.mesh import Mesh
from lamc.plates.meshing.report import corner_angles
from lamc.plates.problem import Problem
from lamc.plates.supports import Clamped, Hinged, SimplySupported, Support, SupportRecord, Symmetry
from lamc.report.plate_case_text import case_rows
from lamc.report.plate_records import PlateReport
from lamc.report.plate_shape_text import shape_rows
from lamc.report.split_text import table

_NAMES = 6  # names in a list before it is cut
_NAMED = {
    Clamped: "clamped",
    SimplySupported: "simply supported",
    Hinged: "hinged",
    Symmetry: "symmetric",
}


def summary(report: PlateReport, folder: Path, files: Sequence[str]) -> str:
    """The whole summary: labelled lines in blocks, and a table of what was asked for."""
    head = [
        ("plate", _plate(report)),
        ("mesh", _mesh(report.problem.mesh)),
        ("element", _element(report.problem)),
    ]
    head += [("laminate", text) for text in _laminates(report.problem)]
    head += [("note", text) for text in report.file.notes]
    end = [("times", _times(report.times)), ("files", f"{folder}: {', '.join(files)}")]
    cases = [_block(case_rows(case)) for case in report.cases]
    cases += [
        _block([("case", name), ("failed", "not solved, see the error below")]) for name in report.failed
    ]
    blocks = [_block(head), *cases, printed_table(report), _block(shape_rows(report)), _block(end)]
    return "\n\n".join(block for block in blocks if block)


def _block(rows: Sequence[tuple[str, str]]) -> str:
    """Lines whose label is written once."""
    lines, before = [], ""
    for label, text in rows:
        lines.append(f"{label if label != before else '':<10}{text}")
        before = label
    return "\n".join(lines)


def printed_table(report: PlateReport) -> str:
    """The outputs that the file asks for, one line per case and output; "" if none."""
    rows = []
    for case in report.cases:
        for each in case.printed:
            output = each.output
            expected = error = ""
            if output.expected is not None:
                expected = shown_number(output.expected, each.unit, 7)
                error = _percent(each.value / output.expected - 1.0) if output.expected else ""
            value = shown_number(each.value, each.unit, 7)
            row = [
                shortened(output.name, 32),
                place_text(output.at, report.problem.size),
                output.value,
                value,
                expected,
                error,
            ]
            rows.append([case.name, *row] if case.name else row)
    if not rows:
        return ""
    heads = ["at", "place", "value", "is", "expected", "error"]
    heads = ["case", *heads] if report.cases[0].name else heads
    kept = [k for k in range(len(heads)) if any(row[k] for row in rows)]
    return table([heads[k] for k in kept], [[row[k] for k in kept] for row in rows])


def angles(mesh: Mesh) -> tuple[float, float]:
    """The smallest and the largest angle of all cells, degrees."""
    found = corner_angles(mesh)
    return float(found.min()), float(found.max())


def _percent(part: float) -> str:
    return f"{round(100.0 * part, 4) + 0.0:+.4f} %"


def _plate(report: PlateReport) -> str:
    x0, y0, x1, y1 = report.file.geometry.outline.bounds
    scale, unit = prefixed(max(x1 - x0, y1 - y0), "m")
    ground = [
        f"on elastic ground of {shown_number(each.stiffness, 'N/m³')}" for each in report.problem.foundations
    ]
    supports = "; ".join([*_supports(report.problem.supports), *ground]) or "free"
    return f"{shortened(report.file.name, 40)}: {(x1 - x0) / scale:.5g} × {(y1 - y0) / scale:.5g} {unit}, {supports}"


def _supports(records: Sequence[SupportRecord]) -> list[str]:
    """What holds the plate, equal ones counted."""
    counts: dict[str, int] = {}
    for record in records:
        name = f"{', '.join(record.dofs)} held" if isinstance(record, Support) else _NAMED[type(record)]
        counts[name] = counts.get(name, 0) + 1
    return [name if count == 1 else f"{name} ({count} times)" for name, count in counts.items()]


def _mesh(mesh: Mesh) -> str:
    low, high = angles(mesh)
    ends = mesh.points[mesh.edges]
    lengths = np.hypot(*(ends[:, 1] - ends[:, 0]).T)
    scale, unit = prefixed(float(lengths.max()), "m")
    kind = "triangles" if mesh.corner_count == 3 else "quadrilaterals"
    pattern = f" ({mesh.pattern})" if mesh.pattern else ""
    regions = (
        f"; regions {_listed([n or 'the rest' for n in mesh.region_names])}"
        if len(mesh.region_names) > 1
        else ""
    )
    return (
        f"{len(mesh.cells)} {kind}{pattern}, angles {low:.3g}° to {high:.3g}°, edges {lengths.min() / scale:.3g} to "
        f"{lengths.max() / scale:.3g} {unit}{regions}"
    )


def _listed(names: Sequence[str]) -> str:
    shown = ", ".join(shortened(name, 24) for name in names[:_NAMES])
    return shown + (f", … ({len(names)} in all)" if len(names) > _NAMES else "")


def _element(problem: Problem) -> str:
    element = problem.dofs.element
    wanted = problem.element if isinstance(problem.element, str) else problem.element.name
    why = "" if element.name == wanted else f" (in place of {wanted}: the plate stretches as well as bends)"
    return f"{element.name}{why}, {len(element.dofs)} unknowns each; {problem.dofs.count} unknowns in all"


def by_region(problem: Problem) -> list[tuple[str, Laminate]]:
    return list(zip(problem.mesh.region_names, problem.laminates, strict=True))


def _laminates(problem: Problem) -> list[str]:
    """A line for each that differs; regions are named where there are several."""
    reported: dict[str, list[str]] = {}
    for name, laminate in by_region(problem):
        reported.setdefault(laminate_text(laminate), []).append(name or "the rest")
    if len(reported) == 1:
        return list(reported)
    return [f"{_listed(names)}: {text}" for text, names in reported.items()]


def laminate_text(laminate: Laminate) -> str:
    """Plies, thickness and bending stiffness in a line."""
    count = len(laminate.plies)
    materials = list(dict.fromkeys(ply.material.name or "unnamed" for ply in laminate.plies))
    angles_of = "/".join(f"{ply.angle:g}" for ply in laminate.plies[:8]) + ("/…" if count > 8 else "")
    stack = f"[{angles_of}]° of " if count > 1 or laminate.plies[0].angle else ""
    D = laminate.D
    stiffness = f"D11 {shown_number(D[0, 0], 'N·m', 4)}, D22 {shown_number(D[1, 1], 'N·m', 4)}"
    if max(abs(D[0, 2]), abs(D[1, 2])) > 1e-9 * D[0, 0]:
        stiffness += f", D16 {shown_number(D[0, 2], 'N·m', 4)}"
    return f"{stack}{_listed(materials)}, {shown_number(laminate.thickness, 'm', 4)} thick; {stiffness}"


def _times(times: Times) -> str:
    return ", ".join(f"{name} {duration(seconds)}" for name, seconds in times.seconds.items())
