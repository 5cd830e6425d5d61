"""What inputs follow over time, as tables in the C of an export.

In: piecewise polynomials, and where steps end for them. Out: lines of numbers for `templates/recording.c.j2`.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
import numpy.typing as npt

from lamc.codegen.names import comment
from lamc.codegen.printer import literal

Array = npt.NDArray[np.float64]

IN_A_LINE = 6
FOREVER = 1e30  # s: what stands for an infinite time, which C has no literal for; floats hold it too


class Polynomials(Protocol):
    """See `lamc.records.series.Pieces`."""

    @property
    def t(self) -> Array: ...
    @property
    def rows(self) -> Array: ...
    @property
    def begin(self) -> float: ...
    @property
    def end(self) -> float: ...


@dataclass(frozen=True, eq=False)
class Recording:
    """names, pieces: of the inputs, in the order of the program's; breaks: (k,), s."""

    names: tuple[str, ...]
    pieces: Sequence[Polynomials]
    breaks: Array


def recording_context(recording: Recording, number: str) -> dict[str, Any]:
    """What the template lays out."""
    return {
        "series": [
            {
                "title": comment(name),
                "count": len(each.t),
                "width": each.rows.shape[1],
                "begin": literal(max(each.begin, -FOREVER), number),
                "end": literal(min(each.end, FOREVER), number),
                "t": _lines(each.t, number),
                "rows": _lines(each.rows.ravel(), number),
            }
            for name, each in zip(recording.names, recording.pieces, strict=True)
        ],
        "breaks": _lines(recording.breaks, number),
        "break_count": len(recording.breaks),
    }


def _lines(values: Array, number: str) -> list[str]:
    texts = [literal(value, number) for value in values.tolist()]
    return [", ".join(texts[k : k + IN_A_LINE]) + "," for k in range(0, len(texts), IN_A_LINE)]
