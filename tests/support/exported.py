"""Exported C, compiled alone in a folder and called through cffi."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import cffi
import numpy as np

from lamc import Mechanism, Scene
from lamc.codegen.emit import declarations_of
from lamc.export.c import c_source
from lamc.export.driven import simulator_of
from lamc.export.options import ExportOptions
from tests.support.compiling import compiled
from tests.support.ctools import CC
from tests.support.mechanisms import Array

C99 = ("-std=c99", "-pedantic", "-Wall", "-Wextra", "-Wconversion", "-Wshadow", "-Werror")
CXX17 = (
    "-x",
    "c++",
    "-std=c++17",
    "-pedantic",
    "-Wall",
    "-Wextra",
    "-Wconversion",
    "-Wshadow",
    "-Werror",
)


def c_files(
    mechanism: Mechanism, scene: Scene | None = None, options: ExportOptions | None = None
) -> dict[str, bytes]:
    """Header and source alone, without what comes with them in a folder."""
    options = options or ExportOptions()
    simulator = simulator_of(mechanism, scene or mechanism.scene or Scene(), options)
    return {name: text.encode() for name, text in c_source(simulator, options).files.items()}


class Exported:
    """An exported model: `call("step", …)` calls PREFIX_step."""

    def __init__(self, files: Mapping[str, bytes], folder: Path, flags: tuple[str, ...] = C99) -> None:
        folder.mkdir(parents=True, exist_ok=True)
        for name, content in files.items():
            (folder / name).write_bytes(content)
        self.folder = folder
        self.prefix = next(name for name in files if name.endswith(".h")).removesuffix(".h")
        flags = (*flags, "-fPIC", "-shared", f"{self.prefix}.c", "-lm", "-o", "model.so")
        compiled([*CC.split(), *flags], folder)
        self.ffi: Any = cffi.FFI()
        declarations = declarations_of(files[f"{self.prefix}.h"].decode())
        self.ffi.cdef(declarations.replace(f"{self.prefix.upper()}_API ", ""))
        self.lib: Any = self.ffi.dlopen(str(folder / "model.so"))

    def new(self, what: str) -> Any:
        """A struct PREFIX_what, filled with what no caller should rely on."""
        struct = self.ffi.new(f"{self.prefix}_{what} *")
        self.ffi.memmove(struct, b"\xa5" * self.ffi.sizeof(struct[0]), self.ffi.sizeof(struct[0]))
        return struct

    def call(self, function: str, *arguments: Any) -> Any:
        return getattr(self.lib, f"{self.prefix}_{function}")(*arguments)

    def constant(self, name: str) -> int:
        return int(getattr(self.lib, f"{self.prefix}_{name}"))

    def status(self, name: str) -> int:
        return int(getattr(self.lib, f"{self.prefix.upper()}_{name}"))

    def instance(self, **settings: float) -> Any:
        """An initialised instance; settings by name, the others as they are by default."""
        chosen = self.new("settings")
        self.call("default_settings", chosen)
        for name, value in settings.items():
            setattr(chosen, name, value)
        it = self.new("t")
        assert self.call("init", it, self.ffi.NULL, chosen) == 0
        return it

    def state(self, it: Any) -> list[float]:
        """[q, u]"""
        nq, nu = self.constant("coordinate_count"), self.constant("rate_count")
        return [*list(it.q)[:nq], *list(it.u)[:nu]]

    def trajectory(self, it: Any, times: Array) -> Array:
        """States at `times`, shape (m, nq + nu); every step must succeed."""
        rows = []
        for t in times:
            status = self.call("step", it, float(t))
            assert status == 0, (t, self.ffi.string(self.call("status_message", status)))
            assert it.t == t
            rows.append(self.state(it))
        return np.array(rows)
