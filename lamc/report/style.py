"""Colours, line styles and the writing of figures, shared by all pictures.

In: matplotlib figures and names from a design. Out: image files, written whole or not at all. It draws nothing
itself and keeps no state; names are shown as they are, never read as markup or mathematics.
"""

import io
import warnings
from collections.abc import Sequence
from pathlib import Path

import matplotlib as mpl
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.legend import Legend

from lamc.basics.files import replacing
from lamc.report.palette import PALETTE as PALETTE
from lamc.report.palette import WORLD as WORLD
from lamc.report.palette import body_colours as body_colours
from lamc.report.plan_view import shortened

LINE_STYLES = ("-", "--", "-.", ":")
DPI = 160


def curve_style(index: int) -> tuple[str, str]:
    """Colour and line style of curve `index`; the pairs repeat after 24. Yellow is too pale for lines."""
    colours = PALETTE[:-1]
    return colours[index % len(colours)], LINE_STYLES[index // len(colours) % len(LINE_STYLES)]


def add_legend(axis: Axes, handles: Sequence[object], names: Sequence[str], columns: int = 1) -> Legend:
    """A legend to the right of the axes. Names may begin with "_" or hold "$": they are shown as they are."""
    legend = axis.legend(
        handles=list(handles),
        labels=[str(k) for k in range(len(names))],
        loc="upper left",
        bbox_to_anchor=(1.01, 1.02),
        fontsize=8,
        frameon=False,
        ncols=columns,
        borderaxespad=0.0,
    )
    for text, name in zip(legend.get_texts(), names, strict=True):
        text.set_parse_math(False)
        text.set_text(shortened(name, 24))
    return legend


def save(figure: Figure, path: Path) -> Path:
    """Writes the figure as PNG in one step. Raises LamcError if it cannot."""
    with replacing(path) as temporary:
        temporary.write_bytes(png_of(figure))
    return path


def png_of(figure: Figure) -> bytes:
    """The figure as PNG, without a date."""
    stream = io.BytesIO()
    with mpl.rc_context({"axes.unicode_minus": True}), warnings.catch_warnings():
        # A name may hold characters that the font lacks; they appear as boxes, and that is no news for a terminal.
        warnings.filterwarnings("ignore", message="Glyph .* missing", category=UserWarning)
        figure.savefig(stream, dpi=DPI, format="png", metadata={"Software": "lamc"})
    return stream.getvalue()
