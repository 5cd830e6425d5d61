"""Colours, line styles and the writing of figures, shared by all pictures.

In: matplotlib figures and names from a design. Out: image files, written whole or not at all. It draws nothing
itself and keeps no state; names are shown as they are, never read as markup or mathematics.
"""

import io
import os
import warnings
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import matplotlib as mpl
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.legend import Legend

from lamc.basics.errors import LamcError
from lamc.basics.files import replacing
from lamc.basics.numbers import shortened
from lamc.report.palette import PALETTE as PALETTE
from lamc.report.palette import WORLD as WORLD
from lamc.report.palette import body_colours as body_colours

SUFFIXES = (".png", ".svg", ".pdf")
# No date in the file: the same design gives the same picture.
_UNDATED: dict[str, dict[str, str | None]] = {
    "png": {"Software": "lamc"},
    "svg": {"Date": None},
    "pdf": {"CreationDate": None},
}
_RC: Any = {
    "axes.unicode_minus": True,
    "svg.hashsalt": "lamc",
    "figure.autolayout": False,
    "figure.constrained_layout.use": False,
}
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


def save_axes(axis: Axes, path: str | os.PathLike[str]) -> Path:
    """Writes the figure that `axis` is in, as `save` does."""
    whole: Any = axis.figure
    while not isinstance(whole, Figure):  # of a figure in a figure
        whole = whole.figure
    return save(whole, Path(path))


def save(figure: Figure, path: Path) -> Path:
    """Writes the figure in one step, as PNG, SVG or PDF by the suffix. Raises LamcError for another suffix, and if it
    cannot write."""
    kind = path.suffix.lower()
    if kind not in SUFFIXES:
        raise LamcError(f"cannot draw into {path.name!r}; the name must end in {', '.join(SUFFIXES)}")
    with replacing(path) as temporary:
        temporary.write_bytes(bytes_of(figure, kind[1:]))
    return path


def bytes_of(figure: Figure, kind: str = "png") -> bytes:
    """The figure as a file of a kind, without a date: the same figure gives the same bytes."""
    stream = io.BytesIO()
    # A fixed salt makes the ids in an SVG repeat from run to run.
    with mpl.rc_context(_RC), warnings.catch_warnings():
        # A name may hold characters that the font lacks; they appear as boxes, and that is no news for a terminal.
        warnings.filterwarnings("ignore", message="Glyph .* missing", category=UserWarning)
        _arrange(figure)
        quick: Any = (
            {"pil_kwargs": {"compress_level": 3}} if kind == "png" else {}
        )  # a tenth larger, thrice as fast
        figure.savefig(stream, dpi=DPI, format=kind, metadata=_UNDATED[kind], **quick)
    return stream.getvalue()


def _arrange(figure: Figure) -> None:
    """Lays the figure out. matplotlib would draw it twice to do so; axes of equal scales take two goes to settle."""
    engine = figure.get_layout_engine()
    if engine is not None:
        dpi, figure.dpi = figure.dpi, DPI
        for _ in range(2):
            engine.execute(figure)
        figure.dpi = dpi
        figure.set_layout_engine(None)
