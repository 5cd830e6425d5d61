"""What the templates of an exported plate lay out: numbers, names and functions, as text.

In: tables, the element's program. Out: one mapping for all templates. Never: files, formulas.
"""

import hashlib
from collections.abc import Sequence
from dataclasses import replace
from functools import cache

import numpy as np

from lamc.basics._version import __version__
from lamc.codegen.layout import arrange
from lamc.codegen.lowering import Lowering, canonical
from lamc.codegen.names import comment, string_literal
from lamc.codegen.printer import ShapePrinter, literal
from lamc.export.options import ExportOptions
from lamc.export.plate_arrays import CNumbers, constant_arrays
from lamc.export.plate_climate import EXPANSIONS, ClimateTables
from lamc.export.plate_laminates import MODULI, LaminateTables
from lamc.export.plate_tables import PlateTables
from lamc.export.statuses import CStatus
from lamc.plates.laminates.ply_terms import EXPANSION, MASS, PLY_NUMBERS, STIFFNESS, ply_equations
from lamc.plates.laminates.sections import NO_COUPLING
from lamc.plates.loads import ElectricField, Moisture, Temperature
from lamc.plates.problem import Problem
from lamc.symbolic.program import ElementProgram, Function, Space
from lamc.symbolic.staging import Level

STATUSES = (
    CStatus("BAD_ARGUMENT", -5, "an argument is NULL or outside its range"),
    CStatus("BAD_DIGEST", -20, "parameters of another plate, or never initialised"),
    CStatus("BAD_PARAMETER", -22, "a parameter is not finite, or outside its range"),
    CStatus("BAD_INPUT", -23, "a number of the caller's is not finite, or a cell has no area"),
    CStatus("SINGULAR", -25, "the matrix is not positive definite within round-off"),
    CStatus("OUTSIDE", -26, "the point is outside of the plate"),
    CStatus("COUPLED", -27, "a laminate bends when it stretches, and the element only bends"),
)
_MOST_BLOCK = 3000  # statements in one function


@cache
def _ply_function(*, expands: bool) -> Function:
    """A, B, D and mass of one ply, and what it pushes with when it expands, without the derivatives that lamc takes for
    itself."""
    equations = ply_equations()
    wanted = [*equations.values[STIFFNESS], equations.values[MASS]]
    wanted += equations.values[EXPANSION] if expands else ()
    return Lowering(equations.store, Level.NUMBER, {}).function(
        "ply_terms", "what a ply adds to its laminate", (Space.PLY,), wanted
    )


def plate_context(
    problem: Problem,
    tables: PlateTables,
    laminates: LaminateTables,
    program: ElementProgram,
    options: ExportOptions,
    prefix: str,
    name: str,
) -> dict[str, object]:
    element, kinds = problem.dofs.element, tables.climate.kinds
    fields = (*MODULI, *expansions_of(tables))
    printer = ShapePrinter()
    both = element.bends and element.stretches
    is_simple = bool((tables.shares.factors == 1.0).all() and (np.diff(tables.shares.begins) <= 1).all())
    facts = {
        "is_simple": is_simple,
        "has_fixed": bool(tables.fixed.any()),
        "has_loads": bool(tables.loads.any()),
        "has_gravity": bool(tables.gravity.any()),
        **{f"has_{member}": kind in kinds for kind, (_, member) in EXPANSIONS.items()},
    }
    numbers = constant_arrays(tables, laminates, facts)
    digest = _digest(numbers, program, laminates, tables.climate)
    functions = {
        name: arrange(
            replace(program.functions[name], name=f"element_{name}"), printer, [], "double", _MOST_BLOCK
        )
        for name in ("stiffness", "displacement", *(["prestress"] if kinds else []))
    }
    operations = {name: function.operations.flops for name, function in functions.items()}
    ply = _ply_function(expands=bool(kinds))
    named = {"xy": "corners", "s": "section", "xi": "element_points[point]"}
    motions = ["u", "v"] * element.stretches + ["w", "w_x", "w_y"] * element.bends
    counts = _counts(problem, tables, laminates, program)
    return {
        **facts,
        "P": prefix,
        "PU": prefix.upper(),
        "title": comment(name),
        "version": __version__,
        "digest": digest,
        "mark": list(hashlib.sha256(f"{digest} {__version__}".encode()).digest()[:16]),
        "libm": options.libm,
        "is_plain": is_simple and not tables.springs.names,
        "element": comment(element.name),
        "element_source": comment(element.source),
        "element_nodes": [
            f"{k}  {', '.join(own)} at xi = {float(node.at[0]):g}, eta = {float(node.at[1]):g}"
            for k, (node, own) in enumerate(zip(element.nodes, program.nodes, strict=True))
        ],
        "counts": counts,
        "statuses": STATUSES,
        "materials": [
            f"{material}: "
            + ", ".join(f"{field} {value:.6g}" for field, value in zip(fields, values, strict=True))
            for material, values in laminates.materials
        ],
        "plies": [
            f"{ply.laminate}, {laminates.materials[ply.material][0]}, {ply.angle:g} degrees, {ply.thickness:g} m"
            for ply in laminates.plies
        ],
        "laminates": laminates.names,
        "springs": [
            f"{comment(line)}: {value:g} N/rad"
            for line, value in zip(tables.springs.names, tables.springs.stiffness, strict=True)
        ],
        "surfaces_are_middle": not any(laminates.surface),
        "section_text": "A, then of B, then of D" if both else "D" if element.bends else "A",
        "section_first": 12 if element.bends and not both else 0,
        "operations": operations["stiffness"] * max(1, len(program.points.get("stiffness", ()))),
        "operations_at": operations["displacement"],
        "condition": f"1e{round(np.log10(tables.condition))}",
        "defaults": _defaults(tables, laminates),
        "expands": bool(kinds),
        "expansions": expansions_of(tables),
        "climates": _climate_rows(problem, tables),
        "strain_first": 18 + 1 + (3 if element.bends and not both else 0),
        "only_bends": element.bends and not element.stretches,
        "motions": motions,
        "motion_values": [
            (name, f"fields[{motions.index(name)}]" if name in motions else "0.0")
            for name in ("u", "v", "w", "w_x", "w_y", "w_xy")
        ],
        "work_megabytes": f"{counts['work'] * 8e-6:.1f}",
        "told": "w" if element.bends else "u",
        "told_climates": _reported(kinds),
        "near": tables.near,
        "outside": f"{max(tables.near.outside, tables.near.inside):.2g}",
        "near_numbers": {
            **{f"low_{axis}": literal(float(x)) for axis, x in zip("xy", tables.near.low, strict=True)},
            **{f"high_{axis}": literal(float(x)) for axis, x in zip("xy", tables.near.high, strict=True)},
            "inside": literal(tables.near.inside),
            "outside": literal(tables.near.outside),
        },
        "sample": [f"{x:.6g}" for x in _middle(problem)],
        "uses_ratio": "RATIO("
        in "".join(
            line
            for function in functions.values()
            for line in (*function.body, *(own for routine in function.routines for own in routine.lines))
        ),
        "ply": arrange(ply, printer, []),
        "ply_numbers": PLY_NUMBERS,
        "term_count": len(ply.outputs),
        "element_functions": functions,
        "points": [", ".join(map(literal, point)) for point in program.points.get("stiffness", ())],
        "point_arguments": ", ".join(named[letter] for letter in functions["stiffness"].reads),
        "displacement_arguments": ", ".join(
            {"xy": "corners", "xi": "xi", "d": "d"}[letter] for letter in functions["displacement"].reads
        ),
        "no_coupling": literal(NO_COUPLING),
        "case_names": [string_literal(case) for case in tables.cases],
        "kinds": {table.name: table.kind for table in numbers},
        "tables": numbers,
        "left_out": tables.climate.left_out,
        "first_angle": laminates.plies[0].angle,
    }


def _counts(
    problem: Problem, tables: PlateTables, laminates: LaminateTables, program: ElementProgram
) -> dict[str, int]:
    rows, profile = len(tables.order), int(tables.profile[-1])
    element = problem.dofs.element
    return {
        "row": rows,
        "entry": len(tables.columns),
        "profile": profile,
        "work": profile + 2 * rows,
        "node": len(tables.nodes),
        "cell": len(tables.cells),
        "corner": program.corner_count,
        "unknown": program.unknown_count,
        "section": 18 if element.bends and element.stretches else 6,
        "laminate": len(laminates.names),
        "ply": len(laminates.plies),
        "material": len(laminates.materials),
        "spring": len(tables.springs.names),
        "spring_point": len(tables.springs.length),
        "case": len(tables.cases),
        "region": len(problem.mesh.region_names),
        "climate": len(tables.cases) * len(problem.mesh.region_names),
        "field": len(tables.climate.fields),
        "strain": 3 * (element.bends + element.stretches),
    }


def expansions_of(tables: PlateTables) -> list[str]:
    """What of materials answers the climates that there are."""
    return [name for kind in tables.climate.kinds for name in EXPANSIONS[kind][0]]


def _climate_rows(problem: Problem, tables: PlateTables) -> list[str]:
    """One line for each region in each case: what it is, and where its fields begin."""
    t = tables.climate
    rows = []
    for c, case in enumerate(tables.cases):
        for r, region in enumerate(problem.mesh.region_names):
            k = c * len(problem.mesh.region_names) + r
            found = [f"case {comment(case)}"] * bool(case) + [comment(region) or "the plate"]
            found += [f"{t.temperature[c, r]:g} K"] * (Temperature in t.kinds)
            found += [f"{t.moisture[c, r]:g} of moisture"] * (Moisture in t.kinds)
            plies = len(problem.laminates[r].plies)
            own = t.fields[t.begins[k] : t.begins[k] + plies]
            reported = f"field[{t.begins[k]}] to [{t.begins[k] + plies - 1}], ply by ply: "
            found += [reported + " ".join(f"{field:g}" for field in own) + " V/m"] * (
                ElectricField in t.kinds
            )
            rows.append(", ".join(found))
    return rows


def _reported(kinds: Sequence[type]) -> str:
    """What the list of climates is about."""
    whole = [f"`{EXPANSIONS[kind][1]}`" for kind in kinds if kind is not ElectricField]
    of_plies = ["`field` of its plies"] * (ElectricField in kinds)
    return f"Climate i, a region in a load case: {', '.join([*whole, *of_plies])}:"


def _middle(problem: Problem) -> tuple[float, float]:
    """Of the cell in the middle of all: a place on the plate."""
    centres = problem.mesh.corners.mean(axis=1)
    away = np.linalg.norm(centres - centres.mean(axis=0), axis=1)
    x, y = centres[np.argmin(away)].tolist()
    return x, y


def _defaults(tables: PlateTables, laminates: LaminateTables) -> list[list[str]]:
    """Members of the parameters, each a list of numbers."""
    moduli = zip(*(values for _, values in laminates.materials), strict=True)
    members: list[Sequence[float]] = [
        *moduli,
        [ply.angle for ply in laminates.plies],
        [ply.thickness for ply in laminates.plies],
        [ply.gap for ply in laminates.plies],
        laminates.reference,
    ]
    if tables.springs.names:
        members.append(tables.springs.stiffness)
    climate = tables.climate
    for kind, values in (
        (Temperature, climate.temperature.ravel()),
        (Moisture, climate.moisture.ravel()),
        (ElectricField, climate.fields),
    ):
        if kind in climate.kinds:
            members.append(list(values))
    return [[literal(float(value)) for value in member] for member in members]


def _digest(
    numbers: Sequence[CNumbers], program: ElementProgram, laminates: LaminateTables, climate: ClimateTables
) -> str:
    text = hashlib.sha256()
    ply = _ply_function(expands=bool(climate.kinds))
    acting = [kind.__name__ for kind in climate.kinds], climate.fields
    amounts = climate.temperature.tolist(), climate.moisture.tolist()
    for part in (program.digest, "\n".join(canonical(ply)), repr(laminates), repr((acting, amounts))):
        text.update(part.encode())
    for table in numbers:
        text.update("\n".join((table.name, *table.lines)).encode())
    return text.hexdigest()
