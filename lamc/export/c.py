"""A model as one header and one source file in C, for programs that have neither Python nor lamc.

In: a simulator and options. Out: NAME.h and NAME.c as text. The source is the runtime (`runtime.py`) and the model's
own C, of both only what the model needs, and the functions of `templates/export/`, made one by `amalgam.py`. Never:
derives anything anew.
"""

import hashlib
from dataclasses import dataclass

from lamc.basics._version import __version__
from lamc.basics.errors import UnsupportedError
from lamc.codegen.emit import emit, environment, other_entries
from lamc.codegen.names import comment
from lamc.codegen.printer import REAL, literal
from lamc.export.amalgam.files import amalgamate, public_functions
from lamc.export.bound import spins, step_bound
from lamc.export.driven import run_length
from lamc.export.fixed_step import suitable_step
from lamc.export.members import CMember, members_of
from lamc.export.options import ExportOptions
from lamc.export.precision import TOLERANCES, check_range, in_precision
from lamc.export.prefixes import prefix_of
from lamc.export.run_fields import integer_ranges, run_fields
from lamc.export.runtime import BARE, lean, macros, runtime_files, table_of_methods, units
from lamc.export.series import recording_of
from lamc.export.sizes import sizes_of
from lamc.export.statuses import STATUSES
from lamc.records.effect import hooked
from lamc.run.methods import constant
from lamc.run.simulator import Simulator
from lamc.symbolic.program import Program

MODEL = "this"  # what names of the model's own C begin with; they are its alone, whatever the prefix of the export is


@dataclass(frozen=True)
class CSource:
    """The two files, and what others say about them."""

    prefix: str
    header: str
    source: str
    program: Program
    parameters: tuple[CMember, ...]
    inputs: tuple[CMember, ...]
    stable_step: (
        float | None
    )  # s, of `real_time` exports: one that was stable when it was tried from the start on

    @property
    def files(self) -> dict[str, str]:
        return {f"{self.prefix}.h": self.header, f"{self.prefix}.c": self.source}


def c_source(simulator: Simulator, options: ExportOptions) -> CSource:
    """Header and source of `simulator`. Raises EmitError where an operation has no C form."""
    program = lean(simulator.program, options)
    if program.clocks:
        raise UnsupportedError(
            f"{program.guards[program.clocks[0].guard].name}, and what is held between samples is not exported: leave "
            "the period out of the scene that is exported"
        )
    prefix = options.prefix or prefix_of(program.name)
    tree = emit(program, prefix=MODEL, number=REAL, recording=recording_of(simulator, options))
    parameters, inputs = members_of(program.parameters)
    stable_step = suitable_step(simulator, is_stiff=options.is_stiff) if options.real_time else None
    context = _context(simulator, program, options, prefix, parameters, inputs, stable_step)
    header = environment().get_template("export/api.h.j2").render(context)
    header = in_precision(header, options.precision, f"{prefix}.h")
    if options.precision == "float":
        _check_ranges(simulator, program)
    files = {
        **runtime_files(program, options),
        **{name: tree.files[name] for name in (f"{MODEL}.h", f"{MODEL}.c")},
        "api.c": environment().get_template("export/api.c.j2").render(context),
    }
    amalgam = amalgamate(
        {name: in_precision(text, options.precision, name) for name, text in files.items()},
        [*units(options), f"{MODEL}.c", "api.c"],
        public_functions(header, prefix),
        prefix,
        replaced={"run.METHODS": table_of_methods(options)},
        defined=macros(options),
        aliases={} if options.calls_libm else BARE,
    )
    opening = (
        environment()
        .get_template("export/opening.c.j2")
        .render(context | {"system_headers": amalgam.system_headers})
    )
    return CSource(prefix, header, opening + amalgam.text, program, parameters, inputs, stable_step)


def _check_ranges(simulator: Simulator, program: Program) -> None:
    """Raises ExportError for numbers of the model that single precision does not hold."""
    for parameter in program.parameters:
        check_range(parameter.default, f"the parameter {parameter.name!r}")
    motion = simulator.model.motion({})
    for k in range(simulator.model.constant_count):
        check_range(float(motion.constants[k]), "a number that follows from the parameters")


def mark_of(program: Program, options: ExportOptions) -> list[int]:
    """Sixteen bytes by which an export knows what is its own; those of all designs of one structure are alike."""
    layout = (program.structure, __version__, options.integrator, options.precision, str(options.real_time))
    return list(hashlib.sha256("\0".join(layout).encode()).digest()[:16])


def _needs_smooth(simulator: Simulator) -> bool:
    """Whether an effect differentiates an expression in time."""
    return any(drive.smooth for effect in simulator.effects for drive in hooked(effect).drives())


def _context(
    simulator: Simulator,
    program: Program,
    options: ExportOptions,
    prefix: str,
    parameters: tuple[CMember, ...],
    inputs: tuple[CMember, ...],
    stable_step: float | None,
) -> dict[str, object]:
    run = run_fields(runtime_files(program, options)["lamc.h"])
    return {
        "P": prefix,
        "PU": prefix.upper(),
        "name": prefix,
        "model": MODEL,
        "version": __version__,
        "title": comment(program.name),
        "digest": program.digest,
        "mark": mark_of(program, options),
        "joints": [comment(j) for j in program.joints],
        "other_coordinates": other_entries(program, program.coordinates),
        "other_rates": other_entries(program, program.rates),
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
            "parameters": len(program.inputs),
            "energies": len(program.energies),
            "guards": len(program.guards),
            "series": len(program.series),
            "closure": program.closure_count,
            "state": len(program.coordinates) + len(program.rates),
            "closure_numbers": program.closure_count * (len(program.rates) + 1),
        },
        "sizes": sizes_of(simulator.model, options),
        "start": [literal(float(x), REAL) for x in simulator.start] or ["0"],
        "geometry_count": len(program.geometry),
        "geometry_slot": len(program.parameters),
        "reals": run.reals,
        "integers": run.integers,
        "place_of": {
            "t": run.reals.index("t"),
            "t_old": run.reals.index("t_old"),
            "method": run.integers.index("method"),
            "next_method": run.integers.index("watch.next_method"),
            "events": run.integers.index("events"),
            "t_event": run.reals.index("t_event"),
            "event_guard": run.integers.index("event_guard"),
        },
        "integer_ranges": integer_ranges(
            run, len(program.coordinates) + len(program.rates), len(program.guards)
        ),
        "wide": run.wide,
        "real_time": options.real_time,
        "events": bool(program.guards) and not options.real_time,
        "stable_step": stable_step,
        "smooth_until": f"{run_length(simulator.scene):g}" if _needs_smooth(simulator) else "",
        "is_stiff": options.is_stiff,
        "spins": spins(program),
        "jacobian": options.jacobian,
        "libm": options.calls_libm,
        "single": options.precision == "float",
        "tolerances": TOLERANCES[options.precision],
        "method": "an integrator that suits" if options.integrator == "auto" else options.integrator,
        "method_number": constant(options.integrator),
        "bound": _bound(program, options),
    }


def _bound(program: Program, options: ExportOptions) -> str:
    bound = step_bound(program, options)
    return f"{bound.operations} operations (+ - * / and roots), {bound.calls} calls of sin, cos and the like"
