"""The folder around the C of a plate: build files, an example, a README with a picture of the mesh.

In: header, source, and what they were made of. Out: relative path → content. It lays out what is known already.
"""

import re
from collections.abc import Mapping

from lamc.basics._version import __version__
from lamc.codegen.emit import environment
from lamc.export.markdown import markdown
from lamc.export.options import ExportOptions
from lamc.export.package import DIGITS, compile_line, single_header
from lamc.plates.problem import Problem
from lamc.report.plates import mesh_figure
from lamc.report.style import bytes_of

_TEMPLATES = {
    "CMakeLists.txt": "package/CMakeLists.txt.j2",
    "{prefix}.pc.in": "package/model.pc.in.j2",
    "example_main.c": "plate/example_main.c.j2",
    "README.md": "plate/README.md.j2",
}


def folder_of(
    prefix: str,
    header: str,
    source: str,
    problem: Problem,
    context: Mapping[str, object],
    options: ExportOptions,
) -> dict[str, bytes]:
    """All files, the C's among them; `context` is what header and source were rendered from."""
    texts = {f"{prefix}.h": header, f"{prefix}.c": source}
    if options.single_header:
        texts = {f"{prefix}.h": single_header(prefix, header, source)}
    title = str(context["title"])
    known = {
        **context,
        "prefix": prefix,
        "upper": prefix.upper(),
        "version": __version__,
        "package_version": ".".join(re.findall(r"\d+", __version__)[:3]),
        "what": "the finite elements of a plate",
        "single_header": options.single_header,
        "compile_line": compile_line(prefix, options),
        "heading_title": markdown(title),
        "real": "double",
        **DIGITS["double"],
        "names": list(problem.dofs.names),
        "rows": {
            kind: [markdown(str(row)) for row in _listed(context[kind])]
            for kind in ("materials", "plies", "laminates", "springs", "climates", "left_out")
        },
        "cases": [markdown(case) for case in problem.cases],
        "source_kilobytes": round(len(source) / 1000),
    }
    files = {
        path.format(prefix=prefix): environment().get_template(f"export/{name}").render(known).encode()
        for path, name in _TEMPLATES.items()
    }
    picture = bytes_of(mesh_figure(problem, title, problem.all_loads))
    return {**{name: text.encode() for name, text in texts.items()}, **files, "mesh.png": picture}


def _listed(values: object) -> list[object]:
    assert isinstance(values, list | tuple)
    return list(values)
