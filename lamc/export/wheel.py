"""A model as a Python package of its own: a wheel with the compiled C and a binding by cffi, and nothing else.

In: a simulator and options. Out: NAME-VERSION-py3-none-PLATFORM.whl and a README.md beside it. The package needs cffi,
not lamc or NumPy, and any Python from 3.9 on. The same design gives the same bytes, but for what the compiler makes of
them. Never: derives anything; compiles for another platform than this one.
"""

import base64
import builtins
import csv
import hashlib
import io
import keyword
import re
import sys
import sysconfig
import tempfile
from collections.abc import Mapping, Sequence
from pathlib import Path

import cffi
from cffi import recompiler

from lamc.basics._version import __version__
from lamc.basics.errors import ExportError
from lamc.codegen.emit import declarations_of, environment
from lamc.codegen.names import comment
from lamc.codegen.toolchain import find_compiler, make_library
from lamc.export.c import CSource, c_source
from lamc.export.driven import simulator_of
from lamc.export.folder import quoted
from lamc.export.markdown import markdown
from lamc.export.members import CMember
from lamc.export.options import ExportOptions
from lamc.export.statuses import of_bindings
from lamc.export.zips import zipped
from lamc.records.mechanism import Mechanism
from lamc.records.scene import Scene
from lamc.run.simulator import Simulator

_ENDINGS = {"darwin": ".dylib", "win32": ".dll"}
LIBRARY = "_model" + _ENDINGS.get(sys.platform, ".so")
_FLAGS = ("-std=c99", "-O2", "-ffp-contract=off", "-fPIC", "-Werror=implicit")
# Names that a package cannot have: what Python or the package itself would find in its place, or cannot import.
_TAKEN = {
    *sys.stdlib_module_names,
    *keyword.kwlist,
    "cffi",
    "pycparser",
    "lamc",
    "pip",
    "setuptools",
    "numpy",
}
# What the package has besides the class of the model
_OWN = (
    *("Inputs", "Outputs", "Parameters", "Pose", "SimulatorError", "UnknownNameError"),
    *("BODIES", "COORDINATES", "COORDINATE_UNITS", "ENERGIES", "JOINTS", "RATES", "RATE_UNITS"),
    *("DIGEST", "LAMC_VERSION"),
)


def files(mechanism: Mechanism, scene: Scene, options: ExportOptions) -> dict[str, bytes]:
    """As `wheel_files`, of a mechanism in its scene."""
    return wheel_files(simulator_of(mechanism, scene, options), options)


def next_step(folder: str, files: Mapping[str, bytes], options: ExportOptions) -> str:
    """Installs it."""
    return f"pip install {quoted(folder, files, '.whl')}"


def wheel_files(simulator: Simulator, options: ExportOptions) -> dict[str, bytes]:
    """The wheel, and what tells how to use it.

    Raises ExportError for names that do not fit, BuildError where the compiler fails.
    """
    source = c_source(simulator, options)
    if source.prefix in _TAKEN:
        raise ExportError(
            f"a package cannot be named {source.prefix!r}, which Python or a package that it needs has; "
            f"take another by --prefix (prefix), such as {source.prefix}_model"
        )
    library, binding = _compiled(source)
    package = {
        "__init__.py": environment()
        .get_template("export/wheel/init.py.j2")
        .render(_context(source, options)),
        "_binding.py": binding,
        "py.typed": "",
    }
    P, version = source.prefix, _version(source)
    named = f"{re.sub('_+', '_', P).lower()}-{version}"
    tag = f"py3-none-{re.sub('[-.]', '_', sysconfig.get_platform())}"
    files = {f"{P}/{name}": text.encode() for name, text in package.items()}
    files[f"{P}/{LIBRARY}"] = library
    files[f"{named}.dist-info/METADATA"] = _metadata(source, version).encode()
    files[f"{named}.dist-info/WHEEL"] = (
        f"Wheel-Version: 1.0\nGenerator: lamc {__version__}\nRoot-Is-Purelib: false\nTag: {tag}\n".encode()
    )
    files[f"{named}.dist-info/RECORD"] = _record(files, f"{named}.dist-info/RECORD").encode()
    wheel = f"{named}-{tag}.whl"
    return {
        wheel: zipped(files, executable=[f"{P}/{LIBRARY}"]),
        "README.md": _readme(source, options, wheel).encode(),
    }


def _compiled(source: CSource) -> tuple[bytes, str]:
    """The library, and the binding that opens it."""
    compiler = find_compiler(None)
    with tempfile.TemporaryDirectory(prefix="lamc-wheel-") as name:
        folder = Path(name)
        for path, text in source.files.items():
            (folder / path).write_text(text, encoding="utf-8", newline="\n")
        make_library(compiler, _FLAGS, [f"{source.prefix}.c"], LIBRARY, folder)
        ffi = cffi.FFI()
        ffi.cdef(declarations_of(source.header).replace(f"{source.prefix.upper()}_API ", ""))
        ffi.set_source("_binding", None)
        recompiler.make_py_source(ffi, "_binding", str(folder / "_binding.py"))
        return (folder / LIBRARY).read_bytes(), (folder / "_binding.py").read_text(encoding="utf-8")


def _version(source: CSource) -> str:
    """lamc's version, and a mark of this source: another design's wheel, or a changed one's, is another version."""
    mark = hashlib.sha256((source.header + source.source).encode()).hexdigest()[:12]
    return f"{__version__}+d{mark}"


def _metadata(source: CSource, version: str) -> str:
    """Core metadata 2.1, https://packaging.python.org/en/latest/specifications/core-metadata."""
    return (
        f"Metadata-Version: 2.1\nName: {source.prefix}\nVersion: {version}\n"
        f"Summary: {comment(source.program.name)}, a simulator made by lamc\n"
        "Requires-Python: >=3.9\nRequires-Dist: cffi>=1.16\n"
        "Description-Content-Type: text/plain\n\n"
        f"import {source.prefix}; help({source.prefix}) tells what there is. "
        f"Made by lamc {__version__}; program digest {source.program.digest}.\n"
    )


def _record(files: Mapping[str, bytes], own: str) -> str:
    """Digests as PEP 376 and PEP 427 have them; RECORD itself has none."""
    lines = io.StringIO()
    writer = csv.writer(lines, lineterminator="\n")
    for path, content in files.items():
        digest = base64.urlsafe_b64encode(hashlib.sha256(content).digest()).rstrip(b"=").decode()
        writer.writerow([path, f"sha256={digest}", len(content)])
    writer.writerow([own, "", ""])
    return lines.getvalue()


def _context(source: CSource, options: ExportOptions) -> dict[str, object]:
    program = source.program
    first = program.coordinates[0].name if program.coordinates else None
    return {
        "P": source.prefix,
        "cls": class_name(source.prefix),
        "version": __version__,
        "title": comment(program.name).replace("\\", "/").replace('"', "'"),
        "digest": program.digest,
        "example": f"[{first!a}]" if first and re.fullmatch(r"\w+", first, re.ASCII) else "",
        "joints": ascii(program.joints),
        "coordinates": ascii(tuple(c.name for c in program.coordinates)),
        "coordinate_units": ascii(tuple(c.unit for c in program.coordinates)),
        "rates": ascii(tuple(r.name for r in program.rates)),
        "rate_units": ascii(tuple(r.unit for r in program.rates)),
        "bodies": ascii(tuple(program.bodies)),
        "energies": ascii(tuple(program.energies)),
        "parameters": _members(source, source.parameters),
        "inputs": _members(source, source.inputs),
        "own_names": _OWN,
        "statuses": [
            {"number": number, "name": name, "meaning": meaning}
            for number, (name, meaning) in of_bindings().items()
        ],
        "library": LIBRARY,
        "real_time": options.real_time,
        "fixed_method": options.fixed_method,
        "jacobian": options.jacobian,
    }


def _readme(source: CSource, options: ExportOptions, wheel: str) -> str:
    program = source.program
    reported = {
        "title_md": markdown(program.name),
        "wheel": wheel,
        "coordinates_md": [{"name": markdown(c.name), "unit": markdown(c.unit)} for c in program.coordinates],
        "inputs_md": _reported(source, source.inputs),
        "parameters_md": _reported(source, source.parameters),
    }
    template = environment().get_template("export/wheel/README.md.j2")
    return template.render(_context(source, options) | reported)


def _reported(source: CSource, members: Sequence[CMember]) -> list[dict[str, str]]:
    """Rows of a table, text of the design as text of Markdown."""
    numbers = [source.program.parameters[member.slot] for member in members]
    return [
        {
            "name": markdown(p.name),
            "default": f"{p.default:.6g}",
            "unit": markdown(p.unit),
            "meaning": markdown(p.meaning),
        }
        for p in numbers
    ]


def class_name(prefix: str) -> str:
    """`triple_pendulum` → `TriplePendulum`; not a name that the module or Python has for something else."""
    name = "".join(part[:1].upper() + part[1:] for part in prefix.split("_"))
    return f"{name}Model" if name in _OWN or hasattr(builtins, name) or keyword.iskeyword(name) else name


def _members(source: CSource, members: Sequence[CMember]) -> list[dict[str, object]]:
    """With the names of the design as literals of Python."""
    return [
        {
            "name": ascii(source.program.parameters[member.slot].name),
            "field": member.field,
            "slot": member.slot,
            "unit": member.unit,
            "meaning": member.meaning,
            "default": f"{member.range}{member.shown}",
        }
        for member in members
    ]
