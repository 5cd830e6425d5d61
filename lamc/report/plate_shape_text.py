"""What `lamc plate` tells of modes and buckling: values, how far off they are, notes.

In: a `PlateReport`. Out: rows of a label and a text. It measures nothing and prints nothing.
"""

from lamc.basics.numbers import shown_number
from lamc.plates.answers.buckling import Buckling
from lamc.plates.answers.shape_errors import REPORTED
from lamc.plates.answers.shape_pairs import ShapePair
from lamc.report.plate_records import MODES, PlateReport, ShapeReport, buckling_key


def shape_rows(report: PlateReport) -> list[tuple[str, str]]:
    """All that is told of modes, then of the buckling factors of every case."""
    rows: list[tuple[str, str]] = []
    if report.modes is not None:
        found = ", ".join(shown_number(float(f), "Hz", 5) for f in report.modes.frequencies)
        rows += [("modes", found), *_trust(report.shapes[MODES], len(report.modes), "mode", "Hz")]
    for name, buckling in report.buckling.items():
        count = len(buckling.factors)
        rows.append(("buckling", f"{name + ': ' if name else ''}{_factors_text(buckling)}"))
        rows += _trust(report.shapes[buckling_key(name)], count, "factor", "")
    return rows


def _factors_text(buckling: Buckling) -> str:
    if len(buckling.factors):
        return f"at {', '.join(f'{factor:.5g}' for factor in buckling.factors)} times the loads"
    if buckling.is_open:
        return (
            f"none up to {buckling.told_to:.3g} times the loads; more cannot be told from round-off, as reversed ones "
            f"buckle it at {-buckling.reversed[0]:.3g}"
        )
    return "none: these forces do not buckle it"


def _trust(shape: ShapeReport, count: int, what: str, unit: str) -> list[tuple[str, str]]:
    """How far off the first `count` are."""
    if not count:
        return []
    reported = ", ".join(percent(float(error)) for error in shape.errors[:count])
    rows = [("error", f"about {reported} %, by the energy of the error of their shapes")]
    rows += [("halved", _halved_text(pair, what, unit)) for pair in shape.halved]
    return rows + [("note", note) for note in shape.notes]


def percent(error: float) -> str:
    """A relative error in percent, two digits; without unit."""
    return f"{100.0 * error:.2g}"


def off_text(error: float) -> str:
    """What a picture says of an error where a note is due, such as " (16 % off)"."""
    return f" ({percent(error)} % off)" if error > REPORTED else ""


def _halved_text(pair: ShapePair, what: str, unit: str) -> str:
    """What halved cells make of a value."""
    name, error = f"{what} {pair.number + 1}", pair.error
    if error is None:
        return f"{name}: none on halved cells has its shape (likeness {pair.mac:.2g} at best): mesh finer"
    value, finer, limit = (
        shown_number(number, unit, 6) for number in (error.value, error.finer, error.extrapolated)
    )
    part = f", {percent(error.error / abs(error.extrapolated))} % off" if error.extrapolated else ""
    return f"{name}: {value}; on halved cells {finer}; tends to {limit}{part}; likeness {pair.mac:.3f}"
