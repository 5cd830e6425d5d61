"""The summary of an optimum for people.

In: a `Best`. Out: lines of text. It computes nothing.
"""

import math

from lamc.basics.numbers import shortened, shown_number
from lamc.studies.optimum import Best

_WIDE = 28


def optimum_summary(best: Best) -> str:
    """What was found, what holds it, how flat it is, and whether it is an optimum."""
    failed = sum(not trial.is_ok for trial in best.problem.trials)
    lines = [f"runs      {best.runs} by {best.method}" + (f", {failed} without a value" if failed else "")]
    if failed:
        lines.append(f"          {best.problem.reasons()}")
    structures = int(best.structures.max(initial=-1)) + 1
    if structures > 1:
        lines.append(
            f"compiled  {structures} structures, as the topology changes with what is varied: slopes end there"
        )
    word = "converged" if best.converged else "not converged"
    lines += [f"{word}: {best.message}", "", _line("parameter", "value", "known to", "1 % of the value")]
    for name, value in best.parameters.items():
        if isinstance(value, str):
            lines.append(_line(name, value, "", ""))
            continue
        unit = "" if best.units[name] == "1" else best.units[name]
        known = _near(best.known_to.get(name), unit, "±")
        lines.append(
            _line(name, shown_number(value, unit, 10), known, _near(best.moves.get(name), unit, "±"))
        )
    lines += ["", _line("goal", "value", "", "")]
    for goal, value in zip(best.problem.goals, best.values, strict=True):
        lines.append(_line(goal.text, shown_number(value, "" if goal.unit == "1" else goal.unit, 8), "", ""))
    if best.constraints:
        lines += ["", _line("constraint", "left to its bound", "holds it", "the value falls by, for 1")]
    for constraint in best.problem.constraints:
        unit = "" if constraint.measure.unit == "1" else constraint.measure.unit
        force = best.multipliers.get(constraint.text)
        left = shown_number(-best.constraints[constraint.text] + 0.0, unit, 4)
        told = "" if force is None else f"{force:.4g}"
        lines.append(_line(constraint.text, left, "" if force is None else "yes", told))
    bounds = [each for each in best.active if each not in best.constraints]
    if bounds:
        lines += ["", "held by   " + ("\n          ".join(bounds))]
    lines += _flattest(best)
    return "\n".join(line.rstrip() for line in lines)


def _flattest(best: Best) -> list[str]:
    """The direction in which least is felt, of several; where something holds the optimum, its slope is felt, too."""
    if len(best.curvature) < 2 or best.active:
        return []
    steep, flat = float(best.curvature[-1]), float(best.curvature[0])
    ratio = f"{steep / flat:.2g} times as flat as the steepest" if flat > 1e-12 * steep else "not felt at all"
    parts = [
        f"{part:+.2f} {shortened(name, 20)}"
        for name, part in zip(best.names, best.directions[:, 0], strict=True)
        if abs(part) > 0.05
    ]
    return ["", f"flattest  {' '.join(parts)} (shares of the ranges), {ratio}"]


def _near(value: float | None, unit: str, sign: str) -> str:
    if value is None:
        return ""
    return (
        f"{sign} {shown_number(value, unit, 3)}"
        if math.isfinite(value)
        else "not known"
        if unit is None
        else "any"
    )


def _line(*cells: str) -> str:
    name, *others = cells
    return f"{shortened(name, _WIDE):<{_WIDE}}" + "".join(f"  {cell:>18}" for cell in others)
