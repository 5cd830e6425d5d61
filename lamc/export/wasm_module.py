"""A model in WebAssembly: the tools that make it, its bytes, and the JavaScript that makes a simulator of them.

In: the C of a model (`c.py`) without a mathematical library. Out: a module without imports; numbers are those of that
C on any machine, to the last bit. Never: derives anything; writes an export.
"""

import importlib.metadata
import importlib.util
import json
import os
import shutil
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path

from lamc.basics._version import __version__
from lamc.basics.errors import BuildError
from lamc.basics.resources import data_dir
from lamc.codegen.emit import environment
from lamc.codegen.names import comment
from lamc.codegen.toolchain import Compiler, run_compiler
from lamc.codegen.zig import environment as zig_environment
from lamc.export.c import CSource
from lamc.export.markdown import markdown
from lamc.export.members import table_rows
from lamc.export.options import ExportOptions
from lamc.export.package import state_bytes
from lamc.export.statuses import of_bindings

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


def binary_of(source: CSource, options: ExportOptions, tools: WasmTools) -> bytes:
    """The module of WebAssembly. Raises BuildError where the compiler fails."""
    return _compiled(source, rendered("glue.c.j2", context_of(source, options)), tools)


def engine_of(source: CSource, options: ExportOptions) -> str:
    """JavaScript that defines `simulatorOf`, which makes a simulator of the compiled module."""
    return rendered("simulator.js.j2", context_of(source, options))


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
        verb = "are" if " and " in missing else "is"
        raise BuildError(
            f"a model in WebAssembly needs a compiler for it, and {missing} {verb} missing; {INSTALL_HINT}"
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


def rendered(name: str, context: dict[str, object]) -> str:
    return environment().get_template(f"{_FOLDER}/{name}").render(context)


def context_of(source: CSource, options: ExportOptions) -> dict[str, object]:
    program = source.program
    nq, nu, inputs = len(program.coordinates), len(program.rates), len(source.inputs)
    counts = {
        "joint": len(program.joints),
        "coordinate": nq,
        "rate": nu,
        "body": len(program.bodies),
        "energy": len(program.energies),
    }
    events = bool(program.guards) and not options.real_time
    if events:
        counts["event"] = len(program.guards)
    return {
        "P": source.prefix,
        "fixed_method": options.fixed_method,
        "PU": source.prefix.upper(),
        "version": __version__,
        "title": comment(program.name),
        "title_md": markdown(program.name),
        "digest": program.digest,
        "name_js": js(source.prefix),
        "counts_js": js(counts),
        "statuses_js": js(of_bindings()),
        "parameters_js": js([member.field for member in source.parameters]),
        "inputs_js": js([member.field for member in source.inputs]),
        "parameters": source.parameters,
        "inputs": source.inputs,
        "parameters_md": table_rows(program, source.parameters),
        "inputs_md": table_rows(program, source.inputs),
        "jacobian": options.jacobian,
        "events": events,
        "value_count": max(1, nq + nu),
        "found_count": max(3, nq + nu, nu * (nq + nu + inputs), len(program.energies)),
    }


def js(value: object) -> str:
    """A literal of JavaScript, for a script inside a page too: in ASCII, without what could end a script."""
    return json.dumps(value, separators=(",", ":"), allow_nan=False).replace("<", "\\u003c")
