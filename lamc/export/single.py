"""C whose numbers are double as C whose numbers are float.

In: C as lamc writes it, for files that take double as the type of every number. Out: the same declarations in single
precision, or a refusal of constants that no float holds. Never: rearranges an expression; what else single precision
asks for, such as other tolerances, stands in `REPLACED`.
"""

import re
from dataclasses import dataclass

import numpy as np

from lamc.basics.errors import ExportError
from lamc.export.ctokens import tokens

_NAMES = {
    "double": "float",
    **{f"DBL_{limit}": f"FLT_{limit}" for limit in ("EPSILON", "MIN", "MAX", "MANT_DIG")},
}
_DECIMAL = re.compile(r"(?!0[xX])[\d.]+(?:[eE][+-]?\d+)?")
_LEAST, _GREATEST = float(np.finfo(np.float32).tiny), float(np.finfo(np.float32).max)

# What takes the place of declarations that hold for double alone. Loops: residuals round off at 1e-7 of the size, and
# equations that fade to half the cube root of that are let go (see take_equations in loops.c). Measured: the N-four-bar
# keeps its energy to 1e-3 over twenty passages through its line at 2e-3, and to 17 % at 7e-4. At 1e-2 and above, where
# pivots of healthy positions lie too (a Sarrus linkage folded by 0.2 rad, a leg of it at rest), wrong ones are let go
# and loops come apart; nor may an equation go along that fades to 5e-2 only.
REPLACED = {
    "method.is_finite": "static inline int is_finite(float x) { return x - x == 0.0f; }",
    "events.AT_ONCE": "static const float AT_ONCE = 2e-5f;",
    "loops.AT_THE_JUMP": "static const float AT_THE_JUMP = 1e-4f;",
    "loops.RANK_TOLERANCE": "static const float RANK_TOLERANCE = 5e-4f;",
    "loops.PASSING": "static const float PASSING = 2e-3f;",
    "loops.TOGETHER": "static const float TOGETHER = 4e-3f;",
    "loops.NEAR_SINGULAR": "static const float NEAR_SINGULAR = 0.2f;",
    "loops.CLOSED": "static const float CLOSED = 2e-6f;",
    "loops.EXACT": "static const float EXACT = 5e-7f;",
    "loops.OUT_OF_NOTHING": "static const float OUT_OF_NOTHING = 2e-3f;",
    "loops.LOST": "static const float LOST = 1e-4f;",
}


@dataclass(frozen=True)
class Tolerances:
    """Of steps, by precision, as C says them."""

    rtol: str
    atol: str
    least_rtol: str  # 500 units of round-off or so: below, estimates of errors are noise
    reach: str  # of a central difference, of 1: the cube root of the round-off


TOLERANCES = {
    "double": Tolerances("1e-9", "1e-11", "1e-13", "6e-6"),
    "float": Tolerances("1e-4", "1e-6", "1e-5", "4e-3"),
}


def single_precision(text: str, file: str) -> str:
    """`text` with floats for doubles. Raises ExportError for a constant out of their range, naming `file`."""
    out = []
    for token in tokens(text):
        if token.kind == "name":
            out.append(_NAMES.get(token.text, token.text))
        elif token.kind == "number":
            out.append(_number(token.text, file))
        elif token.kind == "directive" and (macro := re.match(r"#\s*define\s+\w+(?:\([^)]*\))?", token.text)):
            out.append(macro.group() + single_precision(token.text[macro.end() :], file))
        else:
            out.append(token.text)
    return "".join(out)


def check_range(value: float, what: str) -> None:
    """Raises ExportError for what a float can only hold as infinity, or as zero, or with digits missing."""
    size = abs(value)
    if size > _GREATEST or 0.0 < size < _LEAST:
        raise ExportError(
            f"{what} is {value:.6g}, and single precision holds sizes of {_LEAST:.4g} to {_GREATEST:.4g}; "
            "export in double precision, without --float (precision)"
        )


def _number(text: str, file: str) -> str:
    is_real = _DECIMAL.fullmatch(text) is not None and not text.isdigit()
    if not is_real:
        return text
    value = float(text)
    check_range(value, f"a constant of {file}")
    return f"{np.float32(value)!s}f"
