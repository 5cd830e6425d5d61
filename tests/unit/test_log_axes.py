"""Logarithmic axes of pictures over time: each has ticks to read it by, whatever its values span."""

import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from lamc.report.curves import dress


@pytest.mark.parametrize(
    ("low", "high"), [(2.9, 3.1), (3.0, 4.8), (1.1, 9.0), (0.9, 11.0), (0.02, 2.0), (1e-6, 1e3), (30.0, 48.0)]
)
def test_a_logarithmic_axis_has_labelled_ticks_that_are_apart(low: float, high: float) -> None:
    figure = Figure(figsize=(7.5, 1.65), layout="constrained")  # a panel of one parameter of optimum.png
    canvas, axis = FigureCanvasAgg(figure), figure.subplots()
    axis.plot([0, 1, 2], [low, np.sqrt(low * high), high], ".")
    axis.set_yscale("log")
    dress(axis)
    canvas.draw()
    bottom, top = axis.get_ylim()
    shown = [tick for tick in axis.yaxis.get_major_ticks() if bottom <= tick.get_loc() <= top]
    assert 3 <= len(shown) <= 12
    assert all(tick.label1.get_text() for tick in shown)
    heights = sorted(axis.transData.transform((0.0, tick.get_loc()))[1] for tick in shown)
    # In pixels, of an axis of some 150: labels are 10 high, and lines nearer than that are bunched.
    assert min(np.diff(heights)) > 10.0
