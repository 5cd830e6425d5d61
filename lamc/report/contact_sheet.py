"""Several folded mechanisms in one picture, one panel each.

In: `Result`s with their titles. Out: a PNG file. Each panel has a view and a scale of its own; nothing is stretched.
"""

import math
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from lamc.report.folded import instants
from lamc.report.stage import stage_of
from lamc.report.style import save
from lamc.run.result import Result

COLUMNS = 4
_LONGEST = 520  # pixels of a panel
_PANEL = 2.6  # inches


def draw_contact_sheet(results: Sequence[tuple[str, Result]], path: Path) -> Path:
    """Plates at the instant that differs most from the start and the end of their run, bare links as they start.

    results  titles and runs, in the order of the panels; one or more. Raises LamcError if it cannot write.
    """
    lines = math.ceil(len(results) / COLUMNS)
    figure = Figure(figsize=(COLUMNS * _PANEL, lines * (0.85 * _PANEL)), layout="constrained")
    axes = np.atleast_1d(figure.subplots(lines, COLUMNS)).ravel()
    for axis in axes:
        axis.set_axis_off()
    for axis, (title, result) in zip(axes, results, strict=False):
        stage = stage_of(result, result.t[[_row(result)]], _LONGEST)
        axis.imshow(stage.draw(0), interpolation="antialiased")
        axis.set_title(title, fontsize=10, parse_math=False)
    return save(figure, path)


def _row(result: Result) -> int:
    """Links without plates are told by their lines alone, which one recognises as they are drawn."""
    taken = instants(result, 3)
    plated = any(body.outline for body in result.mechanism.bodies)
    return taken[len(taken) // 2] if plated else 0
