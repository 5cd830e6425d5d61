"""Pages and the parts of them that run in node."""

import base64
import json
import subprocess
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

import lamc
from lamc.export.live import live_of
from lamc.export.pages import result_show
from lamc.run.result import Result
from lamc.run.simulator import Simulator
from lamc.view.document import core, page
from tests.support.exported_folders import mechanism_of, scene_of


def in_node(script: str, folder: Path, **values: object) -> Any:
    """What `script` leaves in `result`, after the parts of the page's JavaScript that need no browser.

    values  are there by name
    """
    given = "\n".join(f"const {name} = {json.dumps(value)};" for name, value in values.items())
    body = f"{core()}\n(async () => {{\n{given}\nlet result = null;\n{script}\n"
    (folder / "script.js").write_text(f'"use strict";\n{body}console.log(JSON.stringify(result));\n}})();\n')
    done = subprocess.run(["node", "script.js"], cwd=folder, capture_output=True, text=True, timeout=120)
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


@cache
def simulator(name: str) -> Simulator:
    return lamc.compile(mechanism_of(name), scene_of(name))


def run(name: str, end: float, rows: int = 401, **parameters: float) -> Result:
    times = np.linspace(0.0, end, rows)
    return simulator(name).run(end, t_eval=times, parameters=parameters)


def page_of(name: str, end: float, folder: Path, *, live: bool = True) -> Path:
    """A page in a file."""
    path = folder / f"{name}.html"
    path.write_text(page([result_show(run(name, end), live=live)]), encoding="utf-8")
    return path


def engine_script(name: str) -> tuple[str, str]:
    """JavaScript that defines `simulatorOf`, and the module's bytes in base64."""
    live = live_of(simulator(name))
    return live.engine, base64.b64encode(live.wasm).decode()
