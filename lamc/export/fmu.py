"""A model as a Functional Mock-up Unit for co-simulation, FMI 2.0 or 3.0: binary of this platform, and sources.

In: a simulator and options. Out: NAME.fmu, a zip file. Its sources are the C of `c.py` and the files of
`templates/export/fmu/`: `slave.h` does the work, `fmi2.c` or `fmi3.c` speaks the standard. The same design gives the
same bytes, but for what the compiler makes of them. Never: derives anything; changes the FMI's own headers.
"""

import hashlib
import math
import platform
import sys
import tempfile
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path

from lamc.basics._version import __version__
from lamc.basics.errors import ExportError
from lamc.basics.resources import data_dir
from lamc.codegen.emit import environment
from lamc.codegen.names import comment, string_literal
from lamc.codegen.toolchain import find_compiler, make_library
from lamc.export.c import CSource, c_source
from lamc.export.driven import run_length, simulator_of
from lamc.export.fmu_description import (
    FmuFacts,
    build_description,
    description_2,
    description_3,
    unit_name,
)
from lamc.export.fmu_variables import Variable, variables
from lamc.export.folder import quoted
from lamc.export.options import ExportOptions
from lamc.export.picture import picture_of
from lamc.export.series import from_outside, resources
from lamc.export.zips import zipped
from lamc.records.mechanism import Mechanism
from lamc.records.scene import Scene
from lamc.run.defaults import RTOL
from lamc.run.simulator import Simulator

_FOLDER = "export/fmu"
_FLAGS = (
    "-std=c99",
    "-O2",
    "-ffp-contract=off",
    "-fPIC",
    "-fvisibility=hidden",
    "-Werror=implicit",
)
_MACHINES = {"amd64": "x86_64", "arm64": "aarch64", "i386": "x86", "i686": "x86"}
_SYSTEMS = {"linux": ("linux", ".so"), "darwin": ("darwin", ".dylib"), "win32": ("windows", ".dll")}


def files(mechanism: Mechanism, scene: Scene, options: ExportOptions) -> dict[str, bytes]:
    """As `fmu_files`, of a mechanism in its scene."""
    return fmu_files(simulator_of(mechanism, from_outside(scene), options), options, resources(scene))


def next_step(folder: str, files: Mapping[str, bytes], options: ExportOptions) -> str:
    """Simulates it with FMPy."""
    return f"fmpy simulate {quoted(folder, files, '.fmu')} --show-plot"


def fmu_files(
    simulator: Simulator, options: ExportOptions, more: Mapping[str, bytes] | None = None
) -> dict[str, bytes]:
    """NAME.fmu. more: files that it takes along.

    Raises ExportError for systems that FMI has no name for, BuildError where the compiler fails."""
    source = c_source(simulator, options)
    program = source.program
    parameters, inputs = ([member.slot for member in kind] for kind in (source.parameters, source.inputs))
    listed = variables(program, parameters, inputs, [float(x) for x in simulator.start])
    facts = _facts(source, simulator, options)
    facts = replace(facts, token=_token(source, listed, facts, options))
    sources = {name: text.encode() for name, text in _sources(source, listed, facts, options).items()}
    describe = description_2 if options.fmi_version == 2 else description_3
    files = {
        "modelDescription.xml": describe(facts, listed),
        **{f"sources/{name}": content for name, content in sources.items()},
        _binary_path(facts.identifier, options): _binary(facts, sources),
        "documentation/index.html": _page(source, listed, facts, options).encode(),
        "documentation/licenses/fmi.txt": (_folder() / "headers" / "LICENSE.txt").read_bytes(),
        "documentation/mechanism.png": picture_of(simulator.mechanism, program.joints, program.bodies),
    }
    files |= more or {}
    if options.fmi_version == 3:
        files["sources/buildDescription.xml"] = build_description(facts)
    return {
        f"{source.prefix}.fmu": zipped(
            dict(sorted(files.items())), executable=[path for path in files if path.startswith("binaries/")]
        )
    }


def _facts(source: CSource, simulator: Simulator, options: ExportOptions) -> FmuFacts:
    duration = run_length(simulator.scene)
    return FmuFacts(
        title=source.program.name,
        identifier=source.prefix,
        duration=float(duration),
        tolerance=RTOL,
        sources=(f"fmi{options.fmi_version}.c", f"{source.prefix}.c"),
    )


def _token(source: CSource, listed: Sequence[Variable], facts: FmuFacts, options: ExportOptions) -> str:
    """A name for what description and sources say without it, in the form of a GUID."""
    describe = description_2 if options.fmi_version == 2 else description_3
    digest = hashlib.sha256(describe(facts, listed))
    for name, text in sorted(_sources(source, listed, facts, options).items()):
        digest.update(f"\0{name}\0{text}".encode())
    text = digest.hexdigest()
    return f"{{{text[:8]}-{text[8:12]}-{text[12:16]}-{text[16:20]}-{text[20:32]}}}"


def _sources(
    source: CSource, listed: Sequence[Variable], facts: FmuFacts, options: ExportOptions
) -> dict[str, str]:
    """All files of the folder `sources`, flat."""
    folder = _folder()
    own = sorted([*folder.glob("slave*.h"), *folder.glob(f"fmi{options.fmi_version}*.[ch]")])
    headers = sorted((folder / "headers").glob(f"fmi{options.fmi_version}*.h"))
    model = environment().get_template(f"{_FOLDER}/model.h.j2").render(_context(source, listed, facts))
    texts = {path.name: path.read_text(encoding="utf-8") for path in (*own, *headers)}
    texts["sum.h"] = (data_dir("runtime_c") / "src" / "sum.h").read_text(encoding="utf-8")
    return {**texts, **source.files, "model.h": model}


def _folder() -> Path:
    """Where the files lie that are the same in all FMUs."""
    return data_dir("templates") / _FOLDER


def _context(source: CSource, listed: Sequence[Variable], facts: FmuFacts) -> dict[str, object]:
    settable = 1 + len(source.parameters) + len(source.inputs)
    return {
        "title": comment(facts.title),
        "version": __version__,
        "prefix": source.prefix,
        "upper": source.prefix.upper(),
        "token": facts.token,
        "parameters": [member.field for member in source.parameters],
        "inputs": [member.field for member in source.inputs],
        "has_slopes": int("rates" in source.program.functions),
        "ranges": [_range(variable) for variable in listed[:settable]],
        "names": [string_literal(variable.name) for variable in listed],
    }


def _range(variable: Variable) -> dict[str, str]:
    bounds = variable.bounds
    return {
        "least": _limit(bounds.least),
        "most": _limit(bounds.most),
        "is_open": str(int(bounds.is_open)),
        "is_fixed": str(int(variable.variability == "fixed")),
    }


def _limit(value: float) -> str:
    return repr(value) if math.isfinite(value) else "-HUGE_VAL" if value < 0.0 else "HUGE_VAL"


def _page(source: CSource, listed: Sequence[Variable], facts: FmuFacts, options: ExportOptions) -> str:
    """What both standards want at `documentation/index.html`: what it does and does not, and its variables."""
    rows = [
        {
            "name": v.name,
            "kind": f"{v.variability} {v.causality}",
            "unit": "" if v.unit == "1" else unit_name(v.unit),
            "start": "" if v.start is None else f"{v.start:.6g}",
            "description": v.description,
        }
        for v in listed
    ]
    context = {
        "title": facts.title,
        "version": __version__,
        "digest": source.program.digest,
        "fmi": options.fmi_version,
        "rows": rows,
    }
    return environment().get_template(f"{_FOLDER}/index.html.j2").render(context)


# --- the binary --------------------------------------------------------------------------------------------


def _system() -> tuple[str, str]:
    """This system's name, and the ending of its shared libraries."""
    known = _SYSTEMS.get(sys.platform)
    if known is None:
        raise ExportError(
            f"FMI has no name for binaries of {sys.platform!r}; export on Linux, macOS or Windows"
        )
    return known


def _binary_path(identifier: str, options: ExportOptions) -> str:
    """Where the standard wants the binary of this platform."""
    system, ending = _system()
    if options.fmi_version == 2:
        bits = 64 if sys.maxsize > 2**32 else 32
        return f"binaries/{'win' if system == 'windows' else system}{bits}/{identifier}{ending}"
    machine = platform.machine().lower()
    return f"binaries/{_MACHINES.get(machine, machine)}-{system}/{identifier}{ending}"


def _binary(facts: FmuFacts, sources: Mapping[str, bytes]) -> bytes:
    compiler = find_compiler(None)
    with tempfile.TemporaryDirectory(prefix="lamc-fmu-") as name:
        folder = Path(name)
        for path, content in sources.items():
            (folder / path).write_bytes(content)
        library = f"{facts.identifier}{_system()[1]}"
        make_library(compiler, _FLAGS, facts.sources, library, folder)
        return (folder / library).read_bytes()
