"""A plate as one header and one source file in C: laminates, elements, assembly, a solver; the folder around them.

In: a plate file or a problem, and options. Out: relative path → content. The equations of ply and element are those
that lamc compiles for itself; mesh, supports and loads are tables (`plate_tables.py`). Never: derives anything anew.
"""

import hashlib
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from functools import cache

import numpy as np
from numpy.typing import NDArray

from lamc._version import __version__
from lamc.codegen.emit import environment
from lamc.codegen.layout import arrange
from lamc.codegen.lowering import Lowering, canonical
from lamc.codegen.names import comment, string_literal
from lamc.codegen.printer import ShapePrinter, literal
from lamc.codegen.program import ElementProgram, Function, Space
from lamc.export.amalgam import amalgamate, public_functions
from lamc.export.options import ExportOptions
from lamc.export.plate_laminates import MODULI, LaminateTables, laminate_tables
from lamc.export.plate_package import folder_of
from lamc.export.plate_tables import PlateTables, plate_tables
from lamc.export.prefixes import prefix_of
from lamc.export.runtime import BARE, mathematics
from lamc.export.statuses import CStatus
from lamc.mechanics.staging import Level
from lamc.plate.elements.build import element_program
from lamc.plate.files.problem_make import problem_of
from lamc.plate.files.problem_records import PlateFile
from lamc.plate.laminates.ply_terms import MASS, PLY_NUMBERS, STIFFNESS, ply_equations
from lamc.plate.problem import Problem
from lamc.resources import data_dir

STATUSES = (
    CStatus("BAD_ARGUMENT", -5, "an argument is NULL or outside its range"),
    CStatus("BAD_DIGEST", -20, "parameters of another plate, or never initialised"),
    CStatus("BAD_PARAMETER", -22, "a parameter is not finite, or outside its range"),
    CStatus("BAD_INPUT", -23, "a number of the caller's is not finite, or a cell has no area"),
    CStatus("SINGULAR", -25, "the matrix is not positive definite within round-off"),
)
_MOST_BLOCK = 3000  # statements in one function
_SHORT = 65536
_PER_LINE = 12


@dataclass(frozen=True)
class CNumbers:
    """A constant array."""

    name: str
    kind: str
    meaning: str
    lines: tuple[str, ...]


@dataclass(frozen=True)
class PlateSource:
    """The two files, and what they are made of."""

    prefix: str
    header: str
    source: str
    problem: Problem
    tables: PlateTables
    laminates: LaminateTables
    context: dict[str, object]


def plate_files(plate: PlateFile | Problem, options: ExportOptions, name: str = "plate") -> dict[str, bytes]:
    """All files of the export of `plate`; `name` is that of a Problem, which has none.

    Raises ExportError for plates that are not held or too large, and for loads that it does not have; DesignError as
    `problem_of` does.
    """
    name = plate.name if isinstance(plate, PlateFile) else name
    problem = problem_of(plate, size=options.edge_length) if isinstance(plate, PlateFile) else plate
    source = plate_source(problem, options, name)
    return folder_of(source.prefix, source.header, source.source, problem, source.context, options)


def plate_source(problem: Problem, options: ExportOptions, name: str) -> PlateSource:
    """Header and source of `problem`. Raises as `plate_files` does."""
    tables, laminates = plate_tables(problem, lossy=options.lossy), laminate_tables(problem)
    program = element_program(problem.dofs.element)
    prefix = options.prefix or prefix_of(name)
    context = _context(problem, tables, laminates, program, options, prefix, name)
    header = _render("api.h", context)
    root = data_dir("runtime_c")
    files = {"api.c": _render("api.c", context)}
    files |= {path.name: path.read_text(encoding="utf-8") for path in sorted((root / "src").glob("trig*.h"))}
    files["string.h"] = (root / "absent" / "bytes.h").read_text(encoding="utf-8")
    files |= {name: path.read_text(encoding="utf-8") for name, path in mathematics(options).items()}
    amalgam = amalgamate(
        files,
        ["api.c"],
        public_functions(header, prefix),
        prefix,
        defined=() if options.libm else ("LAMC_BARE",),
        aliases={} if options.libm else BARE,
    )
    opening = _render("opening.c", context | {"system_headers": amalgam.system_headers})
    return PlateSource(prefix, header, opening + amalgam.text, problem, tables, laminates, context)


def _render(name: str, context: dict[str, object]) -> str:
    return environment().get_template(f"export/plate/{name}.j2").render(context)


@cache
def _ply_function() -> Function:
    """A, B, D and mass of one ply, without the derivatives that lamc takes for itself."""
    equations = ply_equations()
    wanted = [*equations.values[STIFFNESS], equations.values[MASS]]
    return Lowering(equations.store, Level.NUMBER, {}).function(
        "ply_terms", "what a ply adds to its laminate", (Space.PLY,), wanted
    )


def _context(
    problem: Problem,
    tables: PlateTables,
    laminates: LaminateTables,
    program: ElementProgram,
    options: ExportOptions,
    prefix: str,
    name: str,
) -> dict[str, object]:
    element = problem.dofs.element
    stiffness = replace(program.functions["stiffness"], name="element_stiffness")
    printer = ShapePrinter()
    both = element.bends and element.stretches
    is_simple = bool((tables.shares.factors == 1.0).all() and (np.diff(tables.shares.begins) <= 1).all())
    facts = {
        "is_simple": is_simple,
        "has_fixed": bool(tables.fixed.any()),
        "has_loads": bool(tables.loads.any()),
        "has_gravity": bool(tables.gravity.any()),
    }
    numbers = _numbers(tables, laminates, facts)
    digest = _digest(numbers, program, laminates)
    function = arrange(stiffness, printer, [], "double", _MOST_BLOCK)
    named = {"xy": "corners", "s": "section", "xi": "element_points[point]"}
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
        "counts": _counts(problem, tables, laminates, program),
        "statuses": STATUSES,
        "materials": [
            f"{material}: {', '.join(f'{field} {value:.6g}' for field, value in zip(MODULI, values, strict=True))}"
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
        "operations": stiffness.operations.flops * max(1, len(program.points.get("stiffness", ()))),
        "condition": f"1e{round(np.log10(tables.condition))}",
        "defaults": _defaults(tables, laminates),
        "uses_ratio": "RATIO("
        in "".join([*function.body, *(li for r in function.routines for li in r.lines)]),
        "ply": arrange(_ply_function(), printer, []),
        "ply_numbers": PLY_NUMBERS,
        "term_count": len(_ply_function().outputs),
        "element_function": function,
        "points": [", ".join(map(literal, point)) for point in program.points.get("stiffness", ())],
        "point_arguments": ", ".join(named[letter] for letter in function.reads),
        "case_names": [string_literal(case) for case in tables.cases],
        "kinds": {table.name: table.kind for table in numbers},
        "tables": numbers,
        "left_out": tables.left_out,
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
    }


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
    return [[literal(float(value)) for value in member] for member in members]


def _digest(numbers: Sequence[CNumbers], program: ElementProgram, laminates: LaminateTables) -> str:
    text = hashlib.sha256()
    for part in (program.digest, "\n".join(canonical(_ply_function())), repr(laminates)):
        text.update(part.encode())
    for table in numbers:
        text.update("\n".join((table.name, *table.lines)).encode())
    return text.hexdigest()


def _numbers(t: PlateTables, laminates: LaminateTables, facts: dict[str, bool]) -> list[CNumbers]:
    """All constant arrays."""
    place = np.argsort(t.order).astype(np.int32)
    of_region = np.array(laminates.of_region, dtype=np.int32)
    found = [
        _whole("ply_begins", "Where the plies of each laminate begin", laminates.begins),
        _whole("ply_material", "Material of each ply", [ply.material for ply in laminates.plies]),
        _reals("surface", "Reference surfaces above the middle, in thicknesses", laminates.surface),
        _reals("points", "Corners of cells: x and y, m", t.points.ravel()),
        _whole("cells", "Corners of each cell", t.cells.ravel()),
        _whole("laminate_of_cell", "Laminate of each cell", of_region[t.regions]),
        _whole("unknowns", "Unknowns of each cell, numbered over the mesh", t.unknowns.ravel()),
        _whole(
            "share_begins", "Where the rows that an unknown of the mesh takes part in begin", t.shares.begins
        ),
        _whole("share_rows", "These rows of the matrix", t.shares.columns),
        _whole("begins", "Where each row of the matrix begins", t.begins),
        _whole("columns", "Column of each entry", t.columns),
        _whole("order", "Rows in the order of the factorisation", t.order),
        _whole("places", "Place of each row in that order", place),
        _whole("profile", "Where each row of the factor begins", t.profile),
        _reals("nodes", "Nodes: x and y, m", t.nodes.ravel()),
        _whole("node_unknowns", "Unknowns of each node: u, v, w, w_x, w_y, w_xy", t.node_unknowns.ravel()),
        _whole("node_rows", "Rows of these in the matrix", t.node_rows.ravel()),
    ]
    if not facts["is_simple"]:
        found.append(_reals("share_factors", "How much of them it takes", t.shares.factors))
    if facts["has_fixed"]:
        found.append(_reals("fixed", "What is prescribed, of each unknown of the mesh", t.fixed))
    if t.springs.names:
        s = t.springs
        found += [
            _whole("spring_begins", "Where the slope at each point of a line begins", s.rows.begins),
            _whole("spring_rows", "Rows that it is a sum of", s.rows.columns),
            _reals("spring_factors", "and how much of each", s.rows.factors),
            _reals("spring_lengths", "Length of line that the point stands for, m", s.length),
            _whole("spring_groups", "Which line it lies on", s.group),
        ]
        if facts["has_fixed"]:
            found.append(_reals("spring_offsets", "Slope by what is prescribed", s.offset))
    if facts["has_loads"]:
        found.append(_reals("loads", "Forces of each load case", t.loads.ravel()))
    if facts["has_gravity"]:
        by_laminate = np.zeros((len(t.cases), len(laminates.names), len(t.order)))
        for region, laminate in enumerate(laminates.of_region):
            by_laminate[:, laminate] += t.gravity[:, region]
        found.append(
            _reals("weights", "Forces per kg/m^2 of each laminate, in each load case", by_laminate.ravel())
        )
    return found


def _reals(name: str, meaning: str, values: Iterable[float]) -> CNumbers:
    return CNumbers(name, "double", meaning, _lines([literal(float(value)) for value in values]))


def _whole(name: str, meaning: str, values: Sequence[int] | NDArray[np.integer]) -> CNumbers:
    numbers = np.asarray(values, dtype=np.int64)
    is_short = numbers.size == 0 or (numbers.min() >= 0 and numbers.max() < _SHORT)
    kind = "unsigned short" if is_short else "int"
    return CNumbers(name, kind, meaning, _lines([str(value) for value in numbers.tolist()]))


def _lines(texts: list[str]) -> tuple[str, ...]:
    return tuple(", ".join(texts[k : k + _PER_LINE]) + "," for k in range(0, len(texts), _PER_LINE))
