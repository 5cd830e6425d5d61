"""Models that run in a page.

In: a simulator. Out: `Live`, the model in WebAssembly with what the page says of its numbers. What was compiled is kept
in lamc's cache. Never: draws; that is `lamc.view`'s.
"""

import hashlib
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

from lamc.basics.errors import BuildError, LamcError
from lamc.codegen.cache import Cache, cache_root
from lamc.export.c import CSource, c_source
from lamc.export.members import CMember
from lamc.export.options import ExportOptions
from lamc.export.wasm_module import binary_of, engine_of, find_wasm_tools, tools_key
from lamc.readers.scene_writer import scene_data
from lamc.records.scene import Scene
from lamc.run.simulator import Simulator
from lamc.symbolic.program import Parameter
from lamc.view.live import BODIES, Live

# No Jacobian: nothing in a page asks for it, and it is a fifth of the binary of a large sheet.
_OPTIONS = ExportOptions(libm=False, inputs="none", jacobian=False)
_FILE = "model.wasm"


def live_of(simulator: Simulator) -> Live:
    """The model for a page. Raises BuildError without a compiler for WebAssembly, or where it fails."""
    tools = find_wasm_tools()
    source = c_source(simulator, _OPTIONS)
    parts = [f"{name}\0{text}" for name, text in sorted(source.files.items())]
    key = hashlib.sha256("\0".join([tools_key(tools), *parts]).encode()).hexdigest()
    cache = Cache(cache_root() / "wasm")
    folder = cache.find(key)
    if folder is None:
        binary = binary_of(source, _OPTIONS, tools)
        folder = cache.put(key, lambda fresh: _fill(fresh, binary), {"design": source.program.name})
    return live_from(source, (folder / _FILE).read_bytes(), _OPTIONS)


def live_from(source: CSource, wasm: bytes, options: ExportOptions) -> Live:
    """The model of C that was compiled to `wasm`."""
    slots = source.program.parameters
    return Live(
        engine=engine_of(source, options),
        wasm=wasm,
        parameters=tuple(_member(each, slots[each.slot]) for each in source.parameters),
        inputs=tuple(_member(each, slots[each.slot]) for each in source.inputs),
    )


def live_or_why(simulator: Simulator) -> tuple[Live | None, str]:
    """The model, or a sentence that tells why the page has none and what to install."""
    try:
        return live_of(simulator), ""
    except BuildError as error:
        return None, f"Without the model, whose numbers could be changed in this page: {error}."
    except LamcError as error:
        return None, f"Without the model, which cannot run in a page: {error}"


def _fill(folder: Path, binary: bytes) -> None:
    (folder / _FILE).write_bytes(binary)


def _member(member: CMember, parameter: Parameter) -> Mapping[str, Any]:
    least, most = member.bounds.least, member.bounds.most
    return {
        "field": member.field,
        "name": parameter.name,
        "unit": parameter.unit,
        "meaning": parameter.meaning,
        "group": parameter.effect.replace("_", " ").capitalize() if parameter.effect else BODIES,
        "value": parameter.default,
        "least": least,
        "most": most,
    }


def scene_or_none(scene: Scene) -> Mapping[str, Any] | None:
    """The scene as a file has it; None where it has effects that no file can hold."""
    try:
        return scene_data(replace(scene))
    except LamcError:
        return None
