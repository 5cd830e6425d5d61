"""The folder around the C of one model: build files, an example, a README with a picture.

In: the C and the simulator that it is of. Out: relative path → content. It lays out what is known already; the C itself
is the business of `lamc/export/c.py`.
"""

import math
import re
import shlex
from collections.abc import Mapping, Sequence

from lamc.basics._version import __version__
from lamc.codegen.emit import environment
from lamc.codegen.names import comment, string_literal
from lamc.codegen.printer import literal
from lamc.export.bound import step_bound
from lamc.export.c import CSource, c_source, mark_of
from lamc.export.driven import run_length, simulator_of
from lamc.export.markdown import markdown
from lamc.export.members import table_rows
from lamc.export.options import ExportOptions
from lamc.export.picture import picture_of
from lamc.records.mechanism import Mechanism
from lamc.records.scene import Scene
from lamc.run.defaults import default_rows
from lamc.run.files import titles
from lamc.run.simulator import Simulator
from lamc.symbolic.program import Program

_TEMPLATES = {
    "CMakeLists.txt": "CMakeLists.txt.j2",
    "{prefix}.pc.in": "model.pc.in.j2",
    "example_main.c": "example_main.c.j2",
    "README.md": "README.md.j2",
    "{prefix}_params.h": "params.h.j2",
}
# Of decimals: as many as any decimal keeps, and as tell all numbers apart
DIGITS = {"double": {"few_digits": 15, "most_digits": 17}, "float": {"few_digits": 6, "most_digits": 9}}


def files(mechanism: Mechanism, scene: Scene, options: ExportOptions) -> dict[str, bytes]:
    """The folder of a mechanism in its scene."""
    simulator = simulator_of(mechanism, scene, options)
    return package_files(c_source(simulator, options), simulator, options)


def next_step(folder: str, files: Mapping[str, bytes], options: ExportOptions) -> str:
    """Makes the example and runs it; the README has the same line, for who stands in the folder."""
    (prefix,) = (path.removesuffix(".pc.in") for path in files if path.endswith(".pc.in"))
    return f"cd {shlex.quote(folder)} && {compile_line(prefix, options)} && ./example"


def package_files(source: CSource, simulator: Simulator, options: ExportOptions) -> dict[str, bytes]:
    """All files, the C's among them."""
    context = _context(source, simulator, options)
    program = source.program
    texts = source.files
    if options.single_header:
        texts = {f"{source.prefix}.h": single_header(source.prefix, source.header, source.source)}
    files = {
        path.format(prefix=source.prefix): environment()
        .get_template(f"export/package/{name}")
        .render(context)
        .encode()
        for path, name in _TEMPLATES.items()
    }
    picture = picture_of(simulator.mechanism, program.joints, program.bodies)
    return {**{name: text.encode() for name, text in texts.items()}, **files, "mechanism.png": picture}


def single_header(prefix: str, header: str, source: str) -> str:
    """Header and source as one file: the source counts where PREFIX_IMPLEMENTATION is defined, once."""
    upper = prefix.upper()
    body = source.replace(f'#include "{prefix}.h"\n', "", 1)
    return "\n".join(
        [
            header.rstrip("\n"),
            "",
            f"/* In one file of a program: #define {upper}_IMPLEMENTATION before including this. */",
            f"#if defined({upper}_IMPLEMENTATION) && !defined({upper}_IMPLEMENTED)",
            f"#define {upper}_IMPLEMENTED",
            "",
            body.rstrip("\n"),
            "",
            f"#endif /* {upper}_IMPLEMENTATION */",
            "",
        ]
    )


def _context(source: CSource, simulator: Simulator, options: ExportOptions) -> dict[str, object]:
    program, prefix = source.program, source.prefix
    duration = run_length(simulator.scene)
    count = len(program.coordinates)
    start = simulator.start.tolist()
    row_count = default_rows(duration, len(start))
    interval = duration / (row_count - 1)
    longest = interval if source.stable_step is None else source.stable_step
    steps_per_row = math.ceil(interval / longest * (1.0 - 1e-12))
    return {
        "prefix": prefix,
        "what": "a simulator",
        "upper": prefix.upper(),
        "version": __version__,
        "package_version": ".".join(re.findall(r"\d+", __version__)[:3]),
        "title": markdown(program.name),
        "comment_title": comment(program.name),
        "digest": program.digest,
        "single_header": options.single_header,
        "libm": options.calls_libm,
        "real_time": options.real_time,
        "several_integrators": options.integrator == "auto" and not options.real_time,
        "real": options.precision,
        **DIGITS[options.precision],
        "steps_per_row": steps_per_row,
        "h": literal(interval / steps_per_row),
        "effects": [markdown(effect.name) for effect in simulator.effects],
        "compile_line": compile_line(prefix, options),
        "usage": _usage(prefix, options, interval / steps_per_row),
        "coordinates": _coordinates(program, simulator.mechanism, start[:count]),
        "other_rates": [
            {
                "index": k,
                "name": markdown(r.name),
                "unit": markdown(r.unit),
                "start": _number(start[count + k]),
            }
            for k, r in enumerate(program.rates)
            if k >= len(program.joints)
        ],
        "cuts": [markdown(name) for name in program.cuts],
        "parameters": table_rows(program, source.parameters),
        "inputs": table_rows(program, source.inputs),
        "mark": mark_of(program, options),
        "parameter_numbers": [
            _initial(program.parameters[m.slot].default, options) for m in source.parameters
        ],
        "arrays": [
            [_initial(value, options) for value in values]
            for values in ([number.value for number in program.geometry], start or [0.0])
            if values
        ],
        "first_parameter": next((member.field for member in source.parameters), ""),
        "bodies": [markdown(name) for name in program.bodies],
        "energies": [markdown(name) for name in program.energies],
        "costs": _costs(source, options),
        "state_bytes": state_bytes(source),
        "row_count": row_count,
        "t_end": literal(duration),
        "joint_count": len(program.joints),
        "has_other_coordinates": len(program.rates) > len(program.joints),
        "heading": string_literal(_heading(program)),
    }


def _initial(value: float, options: ExportOptions) -> str:
    """A number in the braces of an initialiser, in the precision of the export."""
    return repr(float(value)) + ("F" if options.precision == "float" else "")


def _heading(program: Program) -> str:
    """The first line of the table that `lamc run` writes."""
    named = titles(program.joints, program.coordinates, program.rates, program.energies)
    return ",".join(_field(title) for title in named) + "\n"


def _field(text: str) -> str:
    """A text in a table with commas, as RFC 4180 has it."""
    return '"' + text.replace('"', '""') + '"' if re.search(r'[",\r\n]', text) else text


def _coordinates(program: Program, mechanism: Mechanism, start: Sequence[float]) -> list[dict[str, str]]:
    by_name = {joint.name: joint for joint in mechanism.joints}
    rows = []
    for k, coordinate in enumerate(program.coordinates):
        joint = by_name.get(coordinate.name) if k < len(program.joints) else None
        rows.append(
            {
                "name": markdown(coordinate.name),
                "unit": markdown(coordinate.unit),
                "meaning": f"{markdown(joint.child)} relative to {markdown(joint.parent)}" if joint else "",
                "start": _number(start[k]),
            }
        )
    return rows


def _number(value: float) -> str:
    return f"{value:.6g}"


def compile_line(prefix: str, options: ExportOptions) -> str:
    """How a compiler makes a program of the example."""
    sources = "example_main.c" if options.single_header else f"example_main.c {prefix}.c"
    return f"cc -O2 -std=c99 {sources}{' -lm' if options.calls_libm else ''} -o example"


def _usage(P: str, options: ExportOptions, h: float) -> list[str]:
    """A few lines to begin with."""
    suffix = "f" if options.precision == "float" else ""
    step = f"{P}_step_fixed(&it, {h:.6g}{suffix})" if options.real_time else f"{P}_step(&it, 0.01)"
    return [
        f'#include "{P}.h"',
        "",
        f"{P}_t it; /* yours: on the stack, in a struct, in an array */",
        f"{P}_status status = {P}_init(&it, 0, 0); /* 0: the design's parameters, usual tolerances */",
        f"if (status == {P.upper()}_OK) status = {step};",
        f"if (status != {P.upper()}_OK) puts({P}_status_message(status));",
    ]


def _costs(source: CSource, options: ExportOptions) -> list[dict[str, str]]:
    """Operations and bytes."""
    functions, bound = source.program.functions, step_bound(source.program, options)
    is_whole = "acceleration" in functions
    whole = "one right-hand side"
    named = {
        whole
        if is_whole
        else f"{whole}, without solving for accelerations": source.program.motion_operations,
        "energies": functions["energy"].operations,
        "poses": functions["poses"].operations,
        "a change of parameters or inputs": functions["setup"].operations,
    }
    rows = [
        {
            "what": what,
            "value": f"{operations.flops} operations, {operations.calls} calls of sin, cos and the like",
        }
        for what, operations in named.items()
    ]
    return [
        *rows,
        {
            "what": "a step of fixed length, at most",
            "value": f"{bound.operations} operations, {bound.calls} calls, linear algebra included",
        },
        {"what": "one instance", "value": f"{state_bytes(source)} bytes, `sizeof({source.prefix}_t)`"},
    ]


def state_bytes(source: CSource) -> int:
    """sizeof of an instance where numbers of n bytes are aligned to n, long longs having 8."""
    settings = _bytes_of(source, f"{source.prefix}_settings", {})
    return _bytes_of(source, f"{source.prefix}_t", {f"{source.prefix}_settings": settings})


def _bytes_of(source: CSource, record: str, known: Mapping[str, int]) -> int:
    """Of a struct of the header that has a long long in it."""
    sizes = {"double": 8, "float": 4, "long long": 8, "unsigned char": 1, **known}
    (body,) = re.findall(rf"typedef struct {record} {{\n(.*?)\n}} {record};", source.header, re.DOTALL)
    total = 0
    for kind, names in re.findall(r"^  ((?:\w+ )*\w+) ([^;]+);", body, re.MULTILINE):
        for name in names.split(","):
            total += -total % min(sizes[kind], 8)
            total += sizes[kind] * int((re.findall(r"\[(\d+)\]", name) or ["1"])[0])
    return total + -total % 8
