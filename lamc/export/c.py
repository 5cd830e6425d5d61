"""A model as one header and one source file in C, for programs that have neither Python nor lamc.

In: a simulator and options. Out: NAME.h and NAME.c as text. The source is the runtime and the model's own C, of both
only what the model needs, and the functions of `templates/export/`, made one by `amalgam.py`. Units of the runtime that
a model does not need (loops without loops, events without guards) are replaced by those of `runtime_c/absent/`, which
answer at no cost, so that the code around them is the same and so are its bits. Never: derives anything anew.
"""

import hashlib
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

from lamc._version import __version__
from lamc.codegen.emit import emit, environment
from lamc.codegen.names import comment, identifiers
from lamc.codegen.printer import literal
from lamc.codegen.program import Coordinate, Parameter, Program
from lamc.export.amalgam import amalgamate
from lamc.export.bound import spins, step_bound
from lamc.export.options import ExportOptions
from lamc.export.prefixes import prefix_of
from lamc.export.run_fields import integer_ranges, run_fields
from lamc.export.single import REPLACED, TOLERANCES, check_range, single_precision
from lamc.export.sizes import sizes_of
from lamc.resources import data_dir
from lamc.run.native import METHODS
from lamc.run.parameters import Bounds, bounds
from lamc.run.simulator import Simulator

IMPLICIT = ("rodas5p", "radau5")
# What stands for <math.h> in programs without it, where the text says the name at the left.
_FUNCTIONS = """
sqrt fabs fmin fmax copysign exp log pow sin cos tan asin acos atan atan2 sinh cosh tanh
"""
BARE = {"HUGE_VAL": "LAMC_INFINITY", **{name: f"lamc_{name}" for name in _FUNCTIONS.split()}}
MODEL = "this"  # what names of the model's own C begin with; they are its alone, whatever the prefix of the export is


@dataclass(frozen=True)
class CStatus:
    name: str
    value: int
    meaning: str


STATUSES = (
    CStatus("STEP_UNDERFLOW", -1, "the step needed is below the spacing of numbers around t"),
    CStatus("NOT_FINITE", -2, "the motion is not finite (NaN or infinity), however short the step"),
    CStatus("STEP_LIMIT", -3, "the limit on the number of steps was reached: call again to go on"),
    CStatus("BAD_ARGUMENT", -5, "an argument is NULL or outside its range"),
    CStatus("CLOSURE_LOST", -7, "a loop came apart: no position nearby closes it"),
    CStatus("RANK_LOST", -8, "the motion stays at a singular position, where it is not determined"),
    CStatus("EVENTS_PILE_UP", -9, "impacts or switches follow each other ever faster"),
    CStatus("BAD_DIGEST", -20, "a struct of another design, or one that was never initialised"),
    CStatus("IN_PAST", -21, "the time asked for lies before the present one"),
    CStatus("BAD_PARAMETER", -22, "a parameter is not finite or outside its range"),
    CStatus("BAD_INPUT", -23, "an input is not finite"),
    CStatus("BAD_STATE", -24, "a state is damaged or not finite, or no near state closes the loops"),
    CStatus("STEP_TOO_LONG", -25, "something turned by more than half a turn in one step: take shorter ones"),
)


@dataclass(frozen=True)
class CMember:
    """A member of the struct of parameters or of inputs; `slot` counts the program's parameters."""

    field: str
    name: str
    unit: str
    meaning: str
    default: str
    shown: str  # the default in print
    slot: int
    bounds: Bounds

    @property
    def least(self) -> str:
        return literal(self.bounds.least) if math.isfinite(self.bounds.least) else "-DBL_MAX"

    @property
    def most(self) -> str:
        return literal(self.bounds.most) if math.isfinite(self.bounds.most) else "DBL_MAX"

    @property
    def is_open(self) -> int:
        return int(self.bounds.is_open)

    @property
    def range(self) -> str:
        """What it can be, in print, with a semicolon; empty: any number."""
        parts = []
        if math.isfinite(self.bounds.least):
            parts.append(f"{'>' if self.bounds.is_open else '>='} {self.bounds.least:g}")
        if math.isfinite(self.bounds.most):
            parts.append(f"<= {self.bounds.most:g}")
        return " and ".join(parts) + ("; " if parts else "")


@dataclass(frozen=True)
class CSource:
    """The two files, and what others say about them."""

    prefix: str
    header: str
    source: str
    program: Program
    parameters: tuple[CMember, ...]
    inputs: tuple[CMember, ...]

    @property
    def files(self) -> dict[str, str]:
        return {f"{self.prefix}.h": self.header, f"{self.prefix}.c": self.source}


def c_source(simulator: Simulator, options: ExportOptions) -> CSource:
    """Header and source of `simulator`. Raises EmitError where an operation has no C form."""
    program = _lean(simulator.program, options)
    prefix = options.prefix or prefix_of(program.name)
    tree = emit(program, prefix=MODEL)
    parameters, inputs = _members(program.parameters)
    context = _context(simulator, program, options, prefix, parameters, inputs)
    header = environment().get_template("export/api.h.j2").render(context)
    is_single = options.precision == "float"
    files = {
        **_runtime(program, options),
        **{name: tree.files[name] for name in (f"{MODEL}.h", f"{MODEL}.c")},
        "api.c": environment().get_template("export/api.c.j2").render(context),
    }
    if is_single:
        _check_ranges(simulator, program)
        header = single_precision(header, f"{prefix}.h")
        files = {name: single_precision(text, name) for name, text in files.items()}
    amalgam = amalgamate(
        files,
        [*_units(options), f"{MODEL}.c", "api.c"],
        public_functions(header, prefix),
        prefix,
        replaced={"run.METHODS": _methods(options), **(REPLACED if is_single else {})},
        defined=() if options.calls_libm else ("LAMC_BARE",),
        aliases={} if options.calls_libm else BARE,
    )
    opening = (
        environment()
        .get_template("export/opening.c.j2")
        .render(context | {"system_headers": amalgam.system_headers})
    )
    return CSource(prefix, header, opening + amalgam.text, program, parameters, inputs)


def _check_ranges(simulator: Simulator, program: Program) -> None:
    """Raises ExportError for numbers of the model that single precision does not hold."""
    for parameter in program.parameters:
        check_range(parameter.default, f"the parameter {parameter.name!r}")
    motion = simulator.model.motion({})
    for k in range(simulator.model.constant_count):
        check_range(motion.handle.constants[k], "a number that follows from the parameters")


def _needs_jacobian(options: ExportOptions) -> bool:
    """Whether anything asks for derivatives of the accelerations."""
    is_implicit = not options.real_time and options.integrator in ("auto", *IMPLICIT)
    return options.jacobian or is_implicit


def _lean(program: Program, options: ExportOptions) -> Program:
    """The program without functions that nothing calls."""
    if _needs_jacobian(options) or "jacobian" not in program.functions:
        return program
    unused = {"jacobian"} if "impacts" in program.functions else {"jacobian", "inertia"}
    return replace(program, functions={k: f for k, f in program.functions.items() if k not in unused})


def _members(parameters: Sequence[Parameter]) -> tuple[tuple[CMember, ...], tuple[CMember, ...]]:
    """Parameters and inputs."""
    fields = identifiers(p.name for p in parameters)
    members = [
        CMember(
            field,
            comment(p.name),
            comment(p.unit),
            comment(p.meaning),
            literal(p.default),
            repr(p.default),
            slot,
            bounds(p.name),
        )
        for slot, (field, p) in enumerate(zip(fields, parameters, strict=True))
    ]
    is_input = [getattr(p, "is_input", False) for p in parameters]
    return (
        tuple(m for m, outside in zip(members, is_input, strict=True) if not outside),
        tuple(m for m, outside in zip(members, is_input, strict=True) if outside),
    )


def _units(options: ExportOptions) -> list[str]:
    """Sources of the runtime, in an order in which objects stand before their use."""
    first = ["system.c", "guards.c", "loops.c", "linearise.c", "powers.c", "motion.c", "fixed.c"]
    if options.real_time:
        return first
    methods = [name for name in METHODS if name != "auto" and options.integrator in ("auto", name)]
    implicit = ["implicit.c"] if any(name in IMPLICIT for name in methods) else []
    return [
        *("integrals.c", *first, *implicit, *(f"{name}.c" for name in methods)),
        *("run.c", "watch.c", "events.c", "rows.c"),
    ]


def _absent(program: Program, options: ExportOptions) -> set[str]:
    """Units that the model does without."""
    needed = {
        "loops": bool(program.cuts),
        "guards": bool(program.guards),
        "events": bool(program.guards) and not options.real_time,
        "linearise": _needs_jacobian(options),
        "system": "acceleration" not in program.functions and not program.cuts,
        "watch": options.integrator == "auto" and not options.real_time,
        "powers": False,
        "integrals": False,
    }
    return {unit for unit, is_needed in needed.items() if not is_needed}


def _runtime(program: Program, options: ExportOptions) -> Mapping[str, str]:
    """The runtime's files by name, with the absent form of what the model does without."""
    root = data_dir("runtime_c")
    paths = sorted([*(root / "include").glob("*.h"), *(root / "src").glob("*.[ch]")])
    files = {path.name: path for path in paths}
    for unit in sorted(_absent(program, options)):
        files[f"{unit}.c"] = root / "absent" / f"{unit}.c"
    files["string.h"] = root / "absent" / "bytes.h"
    if options.precision == "float":
        files |= {"math.h": root / "single" / "elementary.h", "trig.h": root / "single" / "trig.h"}
    elif not options.libm:
        files["math.h"] = root / "bare" / "elementary.h"
    return {name: path.read_text(encoding="utf-8") for name, path in files.items()}


def _methods(options: ExportOptions) -> str:
    """The table of methods, with those that are linked."""
    entries = [
        f"&lamc_method_{name}" if name != "auto" and options.integrator in ("auto", name) else "NULL"
        for name in METHODS
    ]
    return f"static const method *const METHODS[] = {{{', '.join(entries)}}};"


def public_functions(header: str, prefix: str) -> list[str]:
    """Functions that the header declares."""
    lines = [line for line in header.splitlines() if line.startswith(f"{prefix.upper()}_API ")]
    return [line.split("(")[0].split()[-1].lstrip("*") for line in lines]


def _context(
    simulator: Simulator,
    program: Program,
    options: ExportOptions,
    prefix: str,
    parameters: tuple[CMember, ...],
    inputs: tuple[CMember, ...],
) -> dict[str, object]:
    run = run_fields(_runtime(program, options)["lamc.h"])
    layout = (program.digest, __version__, options.integrator, options.precision, str(options.real_time))
    mark = hashlib.sha256("\0".join(layout).encode())
    return {
        "P": prefix,
        "PU": prefix.upper(),
        "name": prefix,
        "model": MODEL,
        "version": __version__,
        "title": comment(program.name),
        "digest": program.digest,
        "mark": list(mark.digest()[:16]),
        "joints": [comment(j) for j in program.joints],
        "cuts": [comment(j) for j in program.cuts],
        "coordinates": [_entry(c) for c in program.coordinates],
        "rates": [_entry(c) for c in program.rates],
        "bodies": [comment(b) for b in program.bodies],
        "energies": [comment(e) for e in program.energies],
        "parameters": parameters,
        "inputs": inputs,
        "statuses": STATUSES,
        "counts": {
            "joints": len(program.joints),
            "cuts": len(program.cuts),
            "coordinates": len(program.coordinates),
            "rates": len(program.rates),
            "bodies": len(program.bodies),
            "parameters": len(program.parameters),
            "energies": len(program.energies),
            "guards": len(program.guards),
            "closure": program.closure_count,
        },
        "sizes": sizes_of(simulator.model, options.integrator),
        "start": [literal(float(x)) for x in simulator.start] or ["0.0"],
        "reals": run.reals,
        "integers": run.integers,
        "integer_ranges": integer_ranges(
            run, len(program.coordinates) + len(program.rates), len(program.guards)
        ),
        "wide": run.wide,
        "real_time": options.real_time,
        "spins": spins(program),
        "jacobian": options.jacobian,
        "libm": options.calls_libm,
        "single": options.precision == "float",
        "tolerances": TOLERANCES[options.precision],
        "method": "an integrator that suits" if options.integrator == "auto" else options.integrator,
        "method_number": f"LAMC_{options.integrator.upper()}",
        "bound": _bound(program),
    }


def _entry(coordinate: Coordinate) -> str:
    return f"{comment(coordinate.name)}, {comment(coordinate.unit)}"


def _bound(program: Program) -> str:
    bound = step_bound(program)
    return f"{bound.operations} operations (+ - * / and roots), {bound.calls} calls of sin, cos and the like"
