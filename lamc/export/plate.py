"""A plate as one header and one source file in C: laminates, elements, assembly, a solver; the folder around them.

In: a plate file or a problem, and options. Out: relative path → content. The equations of ply and element are those
that lamc compiles for itself; mesh, supports and loads are tables (`plate_tables.py`). Never: derives anything anew.
"""

from dataclasses import dataclass

from lamc.basics.errors import ExportError
from lamc.basics.resources import data_dir
from lamc.codegen.emit import environment
from lamc.export.amalgam.files import amalgamate, public_functions
from lamc.export.options import ExportOptions
from lamc.export.plate_context import expansions_of, plate_context
from lamc.export.plate_laminates import MODULI, LaminateTables, laminate_tables
from lamc.export.plate_package import folder_of
from lamc.export.plate_tables import PlateTables, plate_tables
from lamc.export.precision import in_precision
from lamc.export.prefixes import prefix_of
from lamc.export.runtime import BARE, mathematics
from lamc.plates.elements.build import element_program
from lamc.plates.problem import Problem
from lamc.readers.plates.problem_make import problem_of
from lamc.readers.plates.problem_records import PlateFile


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
    if isinstance(plate, PlateFile):
        plate = plate.drawn_for(options.edge_length)
    problem = problem_of(plate, size=options.edge_length) if isinstance(plate, PlateFile) else plate
    try:
        source = plate_source(problem, options, name)
    except ExportError as error:
        if not isinstance(plate, PlateFile) or error.subject is None:
            raise
        raise ExportError(error.message, plate.origins.place(error.subject)) from error
    return folder_of(source.prefix, source.header, source.source, problem, source.context, options)


def plate_source(problem: Problem, options: ExportOptions, name: str) -> PlateSource:
    """Header and source of `problem`. Raises as `plate_files` does."""
    chosen = problem.dofs.element
    if chosen.shear:
        raise ExportError(
            f"element {chosen.name!r} has shear through the thickness, which exports of plates do not have; export "
            "with element 'dkt', whose report says how much it leaves out"
        )
    tables = plate_tables(problem, lossy=options.lossy)
    laminates = laminate_tables(problem, (*MODULI, *expansions_of(tables)))
    program = element_program(problem.dofs.element)
    prefix = options.prefix or prefix_of(name)
    context = plate_context(problem, tables, laminates, program, options, prefix, name)
    header = _render("api.h", context)
    root = data_dir("runtime_c")
    files = {"api.c": _render("api.c", context)}
    files |= {path.name: path.read_text(encoding="utf-8") for path in sorted((root / "src").glob("trig*.h"))}
    files["string.h"] = (root / "absent" / "bytes.h").read_text(encoding="utf-8")
    files |= {name: path.read_text(encoding="utf-8") for name, path in mathematics(options).items()}
    amalgam = amalgamate(
        {name: in_precision(text, "double", name) for name, text in files.items()},
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
