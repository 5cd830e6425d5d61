"""What a comparison of cross-checks found, as records, text and plain data.

In: differences that `check` measured. Out: a table for people, a dictionary for JSON. It compares nothing itself.
"""

import math
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]


@dataclass(frozen=True)
class Comparison:
    """One quantity of two cross-checks: the largest difference, relative to the largest value at that state.

    at        the joint, body or energy where it is; empty if there is no difference at all
    where     the state where it is
    infinite  the cross-checks whose values are not finite there
    compared  False if there was nothing to compare; `reason` then says why, and the difference is NaN
    """

    quantity: str
    cross_checks: tuple[str, str]
    difference: float
    limit: float
    at: str
    where: str
    reason: str
    infinite: tuple[str, ...] = ()
    compared: bool = True

    @property
    def passed(self) -> bool:
        """True within the limit; a NaN is no pass."""
        return self.difference <= self.limit

    @property
    def failed(self) -> bool:
        """True if it was compared and is not within the limit; a NaN is a failure."""
        return self.compared and not self.passed

    def cells(self) -> tuple[str, ...]:
        """The row of the table."""
        pair = " / ".join(self.cross_checks)
        if not self.compared:
            return self.quantity, pair, "", f"{self.limit:.0e}", "not compared", "", self.reason
        said = "not finite" if self.infinite else f"{self.difference:.1e}"
        verdict = "ok" if self.passed else "FAIL"
        return self.quantity, pair, said, f"{self.limit:.0e}", verdict, self.at or "exact", self.where

    def to_dict(self) -> dict[str, Any]:
        """Plain data; `passed` and `difference` are None where nothing was compared."""
        data = {**asdict(self), "infinite": list(self.infinite)}
        data["voices"] = list(data.pop("cross_checks"))  # the key that programs read
        data["difference"] = self.difference if math.isfinite(self.difference) else None
        return {**data, "passed": self.passed if self.compared else None}


@dataclass(frozen=True)
class Report:
    """All comparisons of one mechanism."""

    name: str
    comparisons: tuple[Comparison, ...]
    notes: tuple[str, ...] = ()

    @property
    def passed(self) -> bool:
        """True if nothing that was compared differs beyond its limit."""
        return not any(c.failed for c in self.comparisons)

    def to_dict(self) -> dict[str, Any]:
        """Plain data for JSON."""
        rows = [c.to_dict() for c in self.comparisons]
        return {"name": self.name, "passed": self.passed, "comparisons": rows, "notes": list(self.notes)}

    def table(self) -> str:
        """The comparisons as aligned text, one line each, and the notes."""
        rows = [("quantity", "cross-checks", "difference", "limit", "", "at", "where")]
        rows += [c.cells() for c in self.comparisons]  # type: ignore[misc]
        widths = [max(len(row[k]) for row in rows) for k in range(len(rows[0]))]
        lines = [
            "  ".join(cell.ljust(w) for cell, w in zip(row, widths, strict=True)).rstrip() for row in rows
        ]
        return "\n".join([*lines, *(f"note: {note}" for note in self.notes)])


class Largest:
    """Keeps the largest relative difference of arrays and what it belongs to."""

    def __init__(self, names: Sequence[str], cross_checks: tuple[str, str]) -> None:
        self.names, self.cross_checks = names, cross_checks
        self.difference, self.at, self.where = 0.0, "", ""
        self.infinite: tuple[str, ...] = ()

    def add(self, found: Array, expected: Array, where: str, scale: float = 0.0) -> None:
        """Rows of both arrays belong to `names`; `scale`: the least size to divide by."""
        if expected.size == 0 or self.infinite:
            return
        finite = [np.isfinite(a).reshape(len(self.names), -1).all(axis=1) for a in (found, expected)]
        if not (finite[0].all() and finite[1].all()):
            self.difference, self.where = math.nan, where
            self.at = self.names[int(np.argmin(finite[0] & finite[1]))]
            self.infinite = tuple(v for v, f in zip(self.cross_checks, finite, strict=True) if not f.all())
            return
        size = max(float(np.abs(expected).max()), scale)
        gaps = np.abs(found - expected).reshape(len(self.names), -1).max(axis=1)
        k = int(np.argmax(gaps))
        relative = float(gaps[k]) / size if gaps[k] != 0.0 and size > 0.0 else float(gaps[k])
        if relative > self.difference:
            self.difference, self.at, self.where = relative, self.names[k], where

    def comparison(self, quantity: str, limit: float, reason: str) -> Comparison:
        """What was found, against a limit."""
        return Comparison(
            quantity, self.cross_checks, self.difference, limit, self.at, self.where, reason, self.infinite
        )
