"""A model in WebAssembly: one .wasm without imports, what loads it in node and browsers, and a page that shows it move.

In: a simulator and options. Out: relative path → content. The C is that of `c.py` without a mathematical library, and
numbers are the same as those of that C on any machine, to the last bit. Never: derives anything; needs the network.
"""

import base64
import html
import importlib.metadata
import importlib.util
import json
import os
import shutil
import sys
import tempfile
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from lamc.basics._version import __version__
from lamc.basics.errors import BuildError
from lamc.basics.resources import data_dir
from lamc.codegen.emit import environment
from lamc.codegen.names import comment
from lamc.codegen.toolchain import Compiler, run_compiler
from lamc.codegen.zig import environment as zig_environment
from lamc.export.c import CSource, c_source
from lamc.export.driven import simulator_of
from lamc.export.folder import quoted
from lamc.export.markdown import markdown
from lamc.export.members import table_rows
from lamc.export.options import ExportOptions
from lamc.export.package import state_bytes
from lamc.export.picture import towards_child
from lamc.export.statuses import of_bindings
from lamc.records.mechanism import Array, Mechanism
from lamc.records.scene import Scene
from lamc.report.solid import Lines, Solid, solid_of
from lamc.report.stage import Stage, as_drawn
from lamc.report.style import body_colours
from lamc.run.simulator import Simulator

_FOLDER = "export/wasm"
_PAGE = 65536  # bytes, of WebAssembly's memory
# Against -O2 alone the triple pendulum is two fifths smaller and a twentieth slower: sine and cosine are not put into
# every function that calls them. Vectors of two numbers make it a tenth faster (browsers have them since March 2023,
# node since 16.4). Bulk memory makes copies of memory instructions, where there is no library to call.
_FLAGS = (
    *("-std=c99", "-Os", "-ffp-contract=off", "-ffreestanding", "-Werror=implicit"),
    *("-mbulk-memory", "-msimd128"),
    *("-mllvm", "-inline-threshold=10", "-mllvm", "-inlinehint-threshold=150"),
)
_LINK = ("--no-entry", "--strip-all", "--gc-sections", "--stack-first", "--export=__heap_base")
INSTALL_HINT = "`pip install lamc[cc]`, or install clang with lld (Debian: apt install clang lld)"


@dataclass(frozen=True)
class WasmTools:
    """A compiler for wasm32 and its linker."""

    compiler: Compiler
    linker: Compiler


def files(mechanism: Mechanism, scene: Scene, options: ExportOptions) -> dict[str, bytes]:
    """As `wasm_files`, of a mechanism in its scene."""
    return wasm_files(simulator_of(mechanism, scene, options), options)


def next_step(folder: str, files: Mapping[str, bytes], options: ExportOptions) -> str:
    """Opens its page."""
    return f"open {quoted(folder, files, 'index.html')} in a browser"


def wasm_files(simulator: Simulator, options: ExportOptions) -> dict[str, bytes]:
    """The folder. Raises BuildError without a compiler for WebAssembly."""
    tools = find_wasm_tools()
    source = c_source(simulator, replace(options, libm=False))
    context = _context(source, options)
    binary = binary_of(source, options, tools)
    context |= {
        "base64": base64.b64encode(binary).decode(),
        "wasm_bytes": str(len(binary)),
        "shape_js": _js(_shape(simulator, source)),
    }
    prefix = source.prefix
    texts = {
        f"{prefix}.mjs": "model.mjs.j2",
        f"{prefix}.js": "model.js.j2",
        f"{prefix}.d.mts": "model.d.mts.j2",
        f"{prefix}.d.ts": "model.d.ts.j2",
        "index.html": "index.html.j2",
        "README.md": "README.md.j2",
    }
    files = {path: _rendered(name, context).encode() for path, name in texts.items()}
    return {**files, f"{prefix}.wasm": binary}


def binary_of(source: CSource, options: ExportOptions, tools: WasmTools) -> bytes:
    """The module of WebAssembly. Raises BuildError where the compiler fails."""
    return _compiled(source, _rendered("glue.c.j2", _context(source, options)), tools)


def engine_of(source: CSource, options: ExportOptions) -> str:
    """JavaScript that defines `simulatorOf`, which makes a simulator of the compiled module."""
    return _rendered("simulator.js.j2", _context(source, options))


def tools_key(tools: WasmTools) -> str:
    """What a binary depends on besides its source: lamc, the commands and their flags."""
    glue = (data_dir("templates") / _FOLDER / "glue.c.j2").read_text(encoding="utf-8")
    commands = (*tools.compiler.command, *tools.linker.command, _identity(tools))
    return "\0".join((__version__, *commands, *_FLAGS, *_LINK, glue))


def _identity(tools: WasmTools) -> str:
    """Another one for another version of the compiler."""
    if tools.compiler.identity == "ziglang":
        return importlib.metadata.version("ziglang")
    status = os.stat(tools.compiler.command[0])
    return f"{status.st_size} {status.st_mtime_ns}"


def find_wasm_tools() -> WasmTools:
    """The ziglang package's clang, or that of the system. Raises BuildError without either."""
    if importlib.util.find_spec("ziglang") is not None:
        zig, own = (sys.executable, "-m", "ziglang"), zig_environment(os.environ)
        return WasmTools(
            Compiler((*zig, "cc", "-target", "wasm32-freestanding"), "ziglang", own),
            Compiler((*zig, "wasm-ld"), "ziglang", own),
        )
    clang, linker = shutil.which("clang"), shutil.which("wasm-ld")
    if clang is None or linker is None:
        missing = " and ".join(name for name, found in (("clang", clang), ("wasm-ld", linker)) if not found)
        raise BuildError(
            f"an export to wasm needs a compiler for it, and {missing} is missing; {INSTALL_HINT}"
        )
    return WasmTools(Compiler((clang, "--target=wasm32"), clang), Compiler((linker,), linker))


def _compiled(source: CSource, glue: str, tools: WasmTools) -> bytes:
    """A few copies of an instance may lie on the stack at a time; with `--stack-first` an overflow is a trap."""
    stack = -(-(4 * _PAGE + 16 * state_bytes(source)) // _PAGE) * _PAGE
    with tempfile.TemporaryDirectory(prefix="lamc-wasm-") as name:
        folder = Path(name)
        for path, text in {**source.files, "wasm_glue.c": glue}.items():
            (folder / path).write_text(text, encoding="utf-8", newline="\n")
        run_compiler(tools.compiler, [*_FLAGS, "-c", f"{source.prefix}.c", "-o", "model.o"], folder)
        run_compiler(tools.compiler, [*_FLAGS, "-c", "wasm_glue.c", "-o", "wasm_glue.o"], folder)
        arguments = [*_LINK, "-z", f"stack-size={stack}", "model.o", "wasm_glue.o", "-o", "model.wasm"]
        run_compiler(tools.linker, arguments, folder)
        return (folder / "model.wasm").read_bytes()


def _rendered(name: str, context: dict[str, object]) -> str:
    return environment().get_template(f"{_FOLDER}/{name}").render(context)


def _context(source: CSource, options: ExportOptions) -> dict[str, object]:
    program = source.program
    nq, nu, inputs = len(program.coordinates), len(program.rates), len(source.inputs)
    counts = {
        "joint": len(program.joints),
        "coordinate": nq,
        "rate": nu,
        "body": len(program.bodies),
        "energy": len(program.energies),
    }
    return {
        "P": source.prefix,
        "fixed_method": options.fixed_method,
        "PU": source.prefix.upper(),
        "version": __version__,
        "title": comment(program.name),
        "title_html": html.escape("".join(ch if ch.isprintable() else " " for ch in program.name)),
        "title_md": markdown(program.name),
        "digest": program.digest,
        "name_js": _js(source.prefix),
        "counts_js": _js(counts),
        "statuses_js": _js(of_bindings()),
        "parameters_js": _js([member.field for member in source.parameters]),
        "inputs_js": _js([member.field for member in source.inputs]),
        "parameters": source.parameters,
        "inputs": source.inputs,
        "parameters_md": table_rows(program, source.parameters),
        "inputs_md": table_rows(program, source.inputs),
        "jacobian": options.jacobian,
        "value_count": max(1, nq + nu),
        "found_count": max(1, nq + nu, nu * (nq + nu + inputs), len(program.energies)),
    }


def _js(value: object) -> str:
    """A literal of JavaScript, for a script inside a page too: in ASCII, without what could end a script."""
    return json.dumps(value, separators=(",", ":"), allow_nan=False).replace("<", "\\u003c")


# --- what the page draws ----------------------------------------------------------------------------------------------


def _shape(simulator: Simulator, source: CSource) -> dict[str, object]:
    """Bodies, faces and lines as drawn; the view is the one of lamc's own pictures."""
    mechanism, moving = simulator.mechanism, source.program.bodies
    solid = solid_of(mechanism)
    towards = Stage(mechanism, as_drawn(mechanism), 400).camera.towards
    colours = body_colours(mechanism)
    return {
        "name": source.prefix,
        "size": _rounded(np.array(solid.size)),
        "azimuth": round(float(np.degrees(np.arctan2(towards[0], -towards[1]))), 3),
        "elevation": round(float(np.degrees(np.arcsin(np.clip(towards[2], -1.0, 1.0)))), 3),
        "bodies": [
            {
                "name": body.name,
                "com": _rounded(body.com),
                "moving": moving.index(body.name) if body.name in moving else -1,
                "colour": [int(colours[body.name][k : k + 2], 16) for k in (1, 3, 5)],
            }
            for body in mechanism.bodies
        ],
        "faces": [[f.body, _rounded(f.normal), [_rounded(ring) for ring in f.rings]] for f in solid.faces],
        "edges": _segments(solid.edges),
        "sticks": _segments(solid.sticks),
        "hinges": _hinges(solid),
    }


def _hinges(solid: Solid) -> list[dict[str, object]]:
    """Ends of what is drawn of the axis, its direction, and the direction from it to the child's side, as drawn."""
    mechanism = solid.mechanism
    places = {body.name: k for k, body in enumerate(mechanism.bodies)}
    return [
        {
            "name": joint.name,
            "parent": places[joint.parent],
            "child": places[joint.child],
            "ends": _rounded(ends),
            "axis": _rounded(joint.axis),
            "out": _rounded(towards_child(mechanism, joint, ends.mean(axis=0))),
        }
        for joint, ends in zip(mechanism.joints, solid.hinges.segments, strict=True)
    ]


def _segments(lines: Lines) -> list[object]:
    return [[int(body), _rounded(ends)] for body, ends in zip(lines.bodies, lines.segments, strict=True)]


def _rounded(values: Array) -> object:
    """For the eye: six digits."""
    digits = np.vectorize(lambda x: float(f"{x:.6g}") + 0.0, otypes=[float])
    return digits(values).tolist()
