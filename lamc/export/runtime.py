"""Which files of the runtime an exported simulator takes along, and in which form.

In: a program and options. Out: names and texts of C files. Units that a model does not need (loops without loops,
events without guards) are replaced by those of `runtime_c/absent/`, which answer at no cost, so that the code around
them is the same and so are its bits.
"""

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

from lamc.basics.resources import data_dir
from lamc.export.options import ExportOptions
from lamc.run.methods import AUTO, METHODS, NUMBERS
from lamc.symbolic.program import Program

# What stands for <math.h> in programs without it, where the text says the name at the left.
_FUNCTIONS = """
sqrt fabs fmin fmax copysign exp log pow sin cos tan asin acos atan atan2 sinh cosh tanh
"""
BARE = {"HUGE_VAL": "LAMC_INFINITY", **{name: f"lamc_{name}" for name in _FUNCTIONS.split()}}


def _linked(options: ExportOptions) -> list[str]:
    """The methods that adaptive steps may be taken with."""
    chosen = options.integrator
    return [name for name, each in METHODS.items() if chosen == name or (chosen == AUTO and each.is_chosen)]


def _needs_jacobian(options: ExportOptions) -> bool:
    """Whether anything asks for derivatives of the accelerations."""
    is_implicit = not options.real_time and any(METHODS[name].is_implicit for name in _linked(options))
    return options.jacobian or is_implicit or options.is_stiff


def lean(program: Program, options: ExportOptions) -> Program:
    """The program without functions that nothing calls."""
    if _needs_jacobian(options) or "jacobian" not in program.functions:
        return program
    unused = {"jacobian"} if "impacts" in program.functions else {"jacobian", "inertia"}
    return replace(program, functions={k: f for k, f in program.functions.items() if k not in unused})


def units(options: ExportOptions) -> list[str]:
    """Sources of the runtime, in an order in which objects stand before their use."""
    first = [
        "series.c",
        "system.c",
        "guards.c",
        "impacts.c",
        "loops.c",
        "linearise.c",
        "powers.c",
        "motion.c",
        "fixed.c",
    ]
    if options.real_time:
        own = ("integrals.c", "implicit.c", f"{options.integrator}.c", "stiff.c")
        return [*first, *own] if options.is_stiff else first
    methods = _linked(options)
    implicit = ["implicit.c"] if any(METHODS[name].is_implicit for name in methods) else []
    return [
        *("integrals.c", *first, *implicit, *(f"{name}.c" for name in methods)),
        *(["stiff.c"] if options.is_stiff else []),
        *("run.c", "watch.c", "events.c", "rows.c"),
    ]


def _absent(program: Program, options: ExportOptions) -> set[str]:
    """Units that the model does without."""
    needed = {
        "loops": bool(program.cuts),
        "guards": bool(program.guards),
        "impacts": "impacts" in program.functions,
        "events": bool(program.guards) and not options.real_time,
        "linearise": _needs_jacobian(options),
        "system": "acceleration" not in program.functions and not program.cuts,
        "watch": options.integrator == "auto" and not options.real_time,
        "powers": False,
        "series": bool(program.series),
        "integrals": False,
    }
    return {unit for unit, is_needed in needed.items() if not is_needed}


def runtime_files(program: Program, options: ExportOptions) -> Mapping[str, str]:
    """The runtime's files by name, with the absent form of what the model does without."""
    root = data_dir("runtime_c")
    paths = sorted([*(root / "include").glob("*.h"), *(root / "src").glob("*.[ch]")])
    files = {path.name: path for path in paths}
    for unit in sorted(_absent(program, options)):
        files[f"{unit}.c"] = root / "absent" / f"{unit}.c"
    files |= {"lamc_real.h": root / "absent" / "real.h", "string.h": root / "absent" / "bytes.h"}
    files |= mathematics(options)
    return {name: path.read_text(encoding="utf-8") for name, path in files.items()}


def mathematics(options: ExportOptions) -> dict[str, Path]:
    """What stands in the place of <math.h> where it is not called, by the names under which it is included."""
    if options.calls_libm:
        return {}
    bare = {path.name: path for path in sorted((data_dir("runtime_c") / "bare").glob("*.h"))}
    return {**bare, "math.h": bare["elementary.h"]}


def macros(options: ExportOptions) -> tuple[str, ...]:
    """What counts as defined while files become one."""
    return tuple(
        name
        for name, is_defined in (
            ("LAMC_BARE", not options.calls_libm),
            ("LAMC_REAL_FLOAT", options.precision == "float"),
        )
        if is_defined
    )


def table_of_methods(options: ExportOptions) -> str:
    """The table of methods, with those that are linked."""
    entries = [f"&lamc_method_{name}" if name in _linked(options) else "NULL" for name in NUMBERS]
    return f"static const method *const METHODS[] = {{{', '.join(entries)}}};"
