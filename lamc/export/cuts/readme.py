"""README.md of cut files: what each file is of, what the names of its layers mean, how it compares with the design.

In: what cut.json says. Out: markdown.
"""

from collections.abc import Mapping
from typing import Any

from lamc.export.markdown import markdown

_LAMINATE = """Within a file, cut the layers in the order of their names:

| layer | what it is |
|---|---|
| `1_holes` | windows in parts, and holes for pins |
| `2_creases` | lines to be scored, not cut through: creases of a layer without boards beside |
| `2_slits` | lines that are cut once: perforations, slits narrower than the kerf |
| `3_outline` | outlines of parts, which come loose |
| `4_reference` | the edge of the sheet; not to be cut where the sheet has this size |"""

_SHEET = """Within a file, cut the layers in this order; the outline comes last, as it sets the part free:

| layer | what it is |
|---|---|
| `1_holes` | holes for pins |
| `mountain` (red), `valley` (blue), `hinge` (a spring that rests flat), `undriven` (magenta) | creases, to be scored; \
with perforations, dashes to be cut |
| `flat` (yellow) | lines inside of bodies, which do not fold; not to be cut |
| `hole` | windows |
| `cut` | slits |
| `border` | outlines, where the part comes loose |
| `4_reference` | the edge of the sheet; not to be cut where the sheet has this size |

These are the layers that lamc reads. Of a mountain or valley, the opacity of a line in SVG is its angle by 180 degrees;
in DXF the angle ends the layer's name."""


def readme(data: Mapping[str, Any]) -> str:
    """The text of README.md."""
    width = 1e3 * data["kerf"]
    beside = f"Outlines and holes are {width / 2:g} mm beside the edges, for a kerf of {width:g} mm."
    text = [
        f"# Cut files of {markdown(data['design'])}",
        "Real size: 1 is 1 mm. DXF and SVG show the same. "
        + (beside if width else "Lines are the edges; no kerf is allowed for."),
        "| file | layer, from below | material | thickness | parts | area | mass |\n|---|---|---|---|---|---|---|\n"
        + "\n".join(_row(each) for each in data["layers"]),
        _SHEET if data["kind"] == "sheet" else _LAMINATE,
        _hinges(data),
        f"Compared: {markdown(data['comparison'])}.",
        "\n".join(f"- {markdown(note)}" for note in data["notes"]),
    ]
    return "\n\n".join(text) + "\n"


def _row(layer: Mapping[str, Any]) -> str:
    thickness = "" if layer["thickness"] is None else f"{1e3 * layer['thickness']:g} mm"
    cells = [
        f"`{layer['file']}`" if layer["file"] else "none",
        markdown(layer["layer"]),
        markdown(layer["material"]),
        thickness,
        str(layer["parts"]),
        f"{1e6 * layer['area']:.6g} mm²",
        f"{1e3 * layer['mass']:.6g} g",
    ]
    return f"| {' | '.join(cells)} |"


def _hinges(data: Mapping[str, Any]) -> str:
    if data["kind"] == "sheet":
        return f"Creases: {'lines' if data['hinge_style'] == 'gap' else data['hinge_style']}."
    return f"Hinges: {data['hinge_style']}, width {_width(data['hinge_width'])}."


def _width(width: str | float) -> str:
    return width if isinstance(width, str) else f"{1e3 * width:g} mm"
