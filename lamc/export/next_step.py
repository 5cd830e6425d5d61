"""What comes after an export: one line, by target.

In: the folder as it was written to, its files, the options. Out: a line of a shell with the folder in it, or a
sentence. Never: looks at the folder, or runs anything.
"""

import shlex
from collections.abc import Mapping

from lamc.export.options import ExportOptions


def compile_c(folder: str, files: Mapping[str, bytes], options: ExportOptions) -> str:
    """Makes the example and runs it; the README has the same line, for who stands in the folder."""
    from lamc.export.package import compile_line

    (prefix,) = (path.removesuffix(".h") for path in files if path.endswith(".h"))
    return f"cd {shlex.quote(folder)} && {compile_line(prefix, options)} && ./example"


def view_mjcf(folder: str, files: Mapping[str, bytes], options: ExportOptions) -> str:
    return f"python -m mujoco.viewer --mjcf={_quoted(folder, files, '.xml')}"


def build_urdf(folder: str, files: Mapping[str, bytes], options: ExportOptions) -> str:
    return f"colcon build --paths {shlex.quote(folder)}"


def simulate_fmu(folder: str, files: Mapping[str, bytes], options: ExportOptions) -> str:
    return f"fmpy simulate {_quoted(folder, files, '.fmu')} --show-plot"


def open_page(folder: str, files: Mapping[str, bytes], options: ExportOptions) -> str:
    return f"open {_quoted(folder, files, 'index.html')} in a browser"


def install_wheel(folder: str, files: Mapping[str, bytes], options: ExportOptions) -> str:
    return f"pip install {_quoted(folder, files, '.whl')}"


def _quoted(folder: str, files: Mapping[str, bytes], ending: str) -> str:
    """The first file with this ending, for a shell."""
    return shlex.quote(f"{folder}/{next(path for path in files if path.endswith(ending))}")
