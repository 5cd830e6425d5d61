"""The account of a fit for people, and for programs.

In: a `Fit`, recordings that were held back. Out: lines of text; plain data. It computes nothing.
"""

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from lamc.basics.numbers import shortened, shown_number
from lamc.fitting.answer import Fit
from lamc.fitting.compared import Compared

if TYPE_CHECKING:
    from lamc.fitting.candidates import Candidate

_WIDE = 30


def fit_summary(fit: Fit, held: Sequence[Compared] = ()) -> str:
    """Values and intervals, what the data cannot tell, what is left, how it ended."""
    word = "converged" if fit.converged else "not converged"
    lines = [f"{word}: {fit.message}, {fit.runs} runs", "", _line("number", "value", "95 % interval", "")]
    for name in fit.names:
        unit = "" if fit.units[name] == "1" else fit.units[name]
        lines.append(_line(name, shown_number(fit.values[name], unit, 6), interval_text(fit, name), ""))
    if fit.unidentifiable:
        lines += ["", "not told   " + "\n           ".join(map(str, fit.unidentifiable))]
    lines += ["", _line("recording", "column", "left (rms)", "of its variance")]
    for each in (*fit.compared, *held):
        for k, column in enumerate(each.columns):
            title = f"{each.name}{' (held back)' if each in held else ''}" if not k else ""
            lines.append(
                _line(
                    title,
                    shortened(column, 18),
                    shown_number(each.rms[column], each.units[k], 3),
                    each.share_text(column),
                )
            )
    if fit.notes:
        lines += ["", "notes      " + "\n           ".join(fit.notes)]
    return "\n".join(line.rstrip() for line in lines)


def candidates_text(found: "Sequence[Candidate]") -> str:
    """What would tell more, the best first."""
    if not found:
        return ""
    lines = [_line("recorded beside", "its noise", "the region of all numbers shrinks by", "")]
    for each in found:
        noise = shown_number(each.noise, "" if each.unit == "1" else each.unit, 3)
        lines.append(_line(each.name, noise, f"{each.shrinks:.4g} times", ""))
    return "\n".join(line.rstrip() for line in lines) + "\n\n"


def candidates_data(found: "Sequence[Candidate]") -> list[dict[str, Any]]:
    """The same for programs."""
    return [
        {
            "name": c.name,
            "noise": c.noise,
            "unit": c.unit,
            "shrinks": c.shrinks,
            "standard_errors": dict(c.errors),
        }
        for c in found
    ]


def interval_text(fit: Fit, name: str) -> str:
    """An interval in the unit of its value."""
    low, high = fit.intervals[name]
    unit = "" if fit.units[name] == "1" else fit.units[name]
    if math.isnan(low):
        return "at its bound"
    if math.isinf(high):
        return "any" if math.isinf(low) or not low else f"at least {shown_number(low, unit, 5)}"
    if math.isinf(low):
        return f"at most {shown_number(high, unit, 5)}"
    return f"{shown_number(low, unit, 5)} … {shown_number(high, unit, 5)}"


def fit_data(fit: Fit, held: Sequence[Compared] = ()) -> dict[str, Any]:
    """The answer to --json, and fit.json."""
    return {
        "converged": fit.converged,
        "message": fit.message,
        "runs": fit.runs,
        "derivatives": fit.derivatives,
        "numbers": [
            {
                "name": name,
                "value": fit.values[name],
                "unit": fit.units[name],
                "low": fit.intervals[name][0],
                "high": fit.intervals[name][1],
                "standard_error": fit.errors[name],
                "of_logarithm": name in fit.logarithms,
            }
            for name in fit.names
        ],
        "correlations": fit.correlations.tolist(),
        "unidentifiable": [{"names": list(each.names), "text": each.text} for each in fit.unidentifiable],
        "recordings": [
            {
                "name": each.name,
                "held_back": each in held,
                "rows": len(each.t),
                "rms": each.rms,
                "of_variance": each.share,
            }
            for each in (*fit.compared, *held)
        ],
        "notes": list(fit.notes),
    }


def _line(*cells: str) -> str:
    name, *others = cells
    return f"{shortened(name, _WIDE):<{_WIDE}}" + "".join(
        f"  {cell:>{width}}" for cell, width in zip(others, (18, 34, 16), strict=False)
    )
