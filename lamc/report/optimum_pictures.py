"""Pictures of an optimisation: how the goal came down, where parameters went, and the front of two goals.

In: a `Best`, the path of a picture. Out: the file. It computes nothing but scales.
"""

from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from lamc.basics.numbers import prefixed, shortened
from lamc.report.curves import dress
from lamc.report.style import PALETTE, WORLD, save
from lamc.run.request import Array
from lamc.studies.optimum import Best

_WIDTH, _PANEL = 7.5, 3.0  # inches
_MOST_PARAMETERS = 6  # panels
_STEEP = 30.0  # largest over least, above which an axis is logarithmic


def draw_optimum(best: Best, path: Path) -> Path:
    """The goal over runs, or the front of two goals, and the parameters over runs. Raises LamcError if `path` cannot be
    written."""
    names = best.problem.space.names[:_MOST_PARAMETERS]
    heights = [_PANEL * 1.2] + [_PANEL * 0.55] * len(names)
    figure = Figure(figsize=(_WIDTH, 0.7 + sum(heights)), layout="constrained")
    figure.suptitle(shortened(_title(best), 90), fontsize=12, parse_math=False)
    axes: list[Axes] = list(np.ravel(figure.subplots(1 + len(names), 1, height_ratios=heights)))
    if best.on_front is not None and len(best.values) >= 2:
        _draw_front(axes[0], best)
    else:
        _draw_goal(axes[0], best)
    for k, axis in enumerate(axes[1:]):
        axis.sharex(axes[1])
        _draw_parameter(axis, best, k)
    if len(axes) > 1:
        axes[-1].set_xlabel("run")
    return save(figure, path)


def _title(best: Best) -> str:
    word = "converged" if best.converged else "not converged"
    return f"{best.runs} runs by {best.method}: {word}"


def _kinds(best: Best) -> Array:
    """(runs,): 0 keeps to constraints, 1 does not, 2 has no value."""
    problem = best.problem
    return np.array([2 if not t.is_ok else 0 if problem.is_feasible(t) else 1 for t in problem.trials])


def _draw_goal(axis: Axes, best: Best) -> None:
    problem, kinds = best.problem, _kinds(best)
    runs = np.arange(len(kinds))
    unit = "" if best.unit == "1" else best.unit
    values = np.array([trial.goals[0] for trial in problem.trials])
    seen = values[kinds < 2]
    scale, text = prefixed(float(np.max(np.abs(seen), initial=0.0)), unit)
    values = values / scale
    if (kinds == 1).any():
        axis.plot(
            runs[kinds == 1],
            values[kinds == 1],
            "x",
            color=WORLD,
            markersize=4,
            label="violates a constraint",
        )
    axis.plot(runs[kinds == 0], values[kinds == 0], ".", color=PALETTE[0], markersize=4, label="run")
    least = np.minimum.accumulate(np.where(kinds == 0, values, np.inf))
    axis.plot(
        runs,
        np.where(np.isfinite(least), least, np.nan),
        color=PALETTE[1],
        linewidth=1.5,
        drawstyle="steps-post",
        label="best so far",
    )
    for at in runs[kinds == 2][:300]:
        axis.axvline(at, color=WORLD, linestyle=":", linewidth=0.8)
    if (kinds == 2).any():
        axis.plot([], [], color=WORLD, linestyle=":", label="no value")
    positive = values[(kinds < 2) & (values > 0.0)]
    if len(positive) and (values[kinds < 2] >= 0.0).all() and positive.max() > _STEEP * positive.min():
        axis.set_yscale("log")
    dress(axis)
    axis.set_xlabel("run")
    axis.set_ylabel(shortened(problem.goal.text, 34) + (f" [{text}]" if text else ""), parse_math=False)
    axis.legend(fontsize=8, frameon=False)


def _draw_front(axis: Axes, best: Best) -> None:
    problem, kinds = best.problem, _kinds(best)
    values = np.array([trial.goals[:2] for trial in problem.trials])
    scales = []
    for k, goal in enumerate(problem.goals[:2]):
        unit = "" if goal.unit == "1" else goal.unit
        front = np.abs(values[list(best.on_front or ()), k])
        scales.append(prefixed(float(np.max(front, initial=0.0)), unit))
    x, y = values[:, 0] / scales[0][0], values[:, 1] / scales[1][0]
    axis.plot(x[kinds == 0], y[kinds == 0], ".", color=WORLD, markersize=3, label="run")
    chosen = list(best.on_front or ())
    axis.plot(x[chosen], y[chosen], "o", color=PALETTE[0], markersize=4, label="front")
    at = next(k for k in chosen if problem.trials[k].point == best.point)
    axis.plot(x[at], y[at], "*", color=PALETTE[1], markersize=12, label="nearest to the least of both")
    _around(axis, x[chosen], y[chosen])
    dress(axis)
    labels = [
        shortened(goal.text, 34) + (f" [{text}]" if text else "")
        for goal, (_, text) in zip(problem.goals, scales, strict=False)
    ]
    axis.set_xlabel(labels[0], parse_math=False)
    axis.set_ylabel(labels[1], parse_math=False)
    axis.legend(fontsize=8, frameon=False)


def _around(axis: Axes, x: Array, y: Array) -> None:
    """Shows the front, and as much again around it."""
    for values, limits in ((x, axis.set_xlim), (y, axis.set_ylim)):
        span = float(np.ptp(values)) or abs(float(values[0])) or 1.0
        limits(float(values.min()) - 0.3 * span, float(values.max()) + 0.8 * span)


def _draw_parameter(axis: Axes, best: Best, k: int) -> None:
    variable, kinds = best.problem.space.variables[k], _kinds(best)
    values = np.array([trial.point[k] for trial in best.problem.trials])
    scale, text = 1.0, "" if variable.unit == "1" else variable.unit
    if variable.unit in ("rad", "rad/s"):
        scale, text = np.pi / 180.0, variable.unit.replace("rad", "°")
    elif variable.unit != "1":
        scale, text = prefixed(float(np.max(np.abs(values))), variable.unit)
    runs = np.arange(len(values))
    axis.plot(runs[kinds > 0], values[kinds > 0] / scale, "x", color=WORLD, markersize=3)
    axis.plot(runs[kinds == 0], values[kinds == 0] / scale, ".", color=PALETTE[0], markersize=3)
    axis.axhline(best.point[k] / scale, color=PALETTE[1], linewidth=1.0)
    if variable.log:
        axis.set_yscale("log")
    dress(axis)
    if variable.has_words:
        axis.set_yticks(range(len(variable.levels)), [shortened(str(each), 16) for each in variable.levels])
    axis.set_ylabel(shortened(variable.name, 18) + (f"\n[{text}]" if text else ""), parse_math=False)
