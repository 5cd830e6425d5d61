"""A model in WebAssembly: one .wasm without imports, what loads it in node and browsers, and a page that shows it move.

In: a simulator and options. Out: relative path → content. The C is that of `c.py` without a mathematical library, and
numbers are the same as those of that C on any machine, to the last bit. Never: derives anything; needs the network.
"""

import base64
from collections.abc import Mapping
from dataclasses import replace

from lamc.export.c import c_source
from lamc.export.driven import run_length, simulator_of
from lamc.export.folder import quoted
from lamc.export.live import live_from, scene_or_none
from lamc.export.options import ExportOptions
from lamc.export.wasm_module import binary_of, context_of, find_wasm_tools, rendered
from lamc.records.mechanism import Mechanism
from lamc.records.scene import Scene
from lamc.run.simulator import Simulator
from lamc.view.device import model_show
from lamc.view.document import page


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
    context = context_of(source, options)
    binary = binary_of(source, options, tools)
    context |= {
        "base64": base64.b64encode(binary).decode(),
        "wasm_bytes": str(len(binary)),
    }
    prefix = source.prefix
    texts = {
        f"{prefix}.mjs": "model.mjs.j2",
        f"{prefix}.js": "model.js.j2",
        f"{prefix}.d.mts": "model.d.mts.j2",
        f"{prefix}.d.ts": "model.d.ts.j2",
        "README.md": "README.md.j2",
    }
    files = {path: rendered(name, context).encode() for path, name in texts.items()}
    scene = simulator.scene
    live = live_from(source, binary, options)
    shown = page([model_show(simulator, live, scene_data=scene_or_none(scene), end=run_length(scene))])
    return {**files, "index.html": shown.encode(), f"{prefix}.wasm": binary}
