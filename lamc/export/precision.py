"""C in the precision of an export.

In: C as lamc writes it, with the type `lamc_real` and constants `LAMC_R(…)`. Out: the same with both written out, or a
refusal of constants that no float holds. What else depends on the precision stands in runtime_c/src/tolerances.h.
"""

import re
from dataclasses import dataclass

import numpy as np

from lamc.basics.errors import ExportError

_REAL = re.compile(r"\blamc_real\b|\bLAMC_R\(([^()]*)\)")
_LEAST, _GREATEST = float(np.finfo(np.float32).tiny), float(np.finfo(np.float32).max)


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


def in_precision(text: str, precision: str, file: str) -> str:
    """`text` with `lamc_real` and `LAMC_R(…)` as lamc_real.h defines them, since exports read better without. Floats
    have as many digits as tell them apart. Raises ExportError for a constant out of their range, naming `file`."""

    def written(found: re.Match[str]) -> str:
        if found[1] is None:
            return precision
        if precision == "double":
            return found[1]
        value = float(found[1])
        check_range(value, f"a constant of {file}")
        return f"{np.float32(value)!s}f"

    return _REAL.sub(written, text)


def check_range(value: float, what: str) -> None:
    """Raises ExportError for what a float can only hold as infinity, or as zero, or with digits missing."""
    size = abs(value)
    if size > _GREATEST or 0.0 < size < _LEAST:
        raise ExportError(
            f"{what} is {value:.6g}, and single precision holds sizes of {_LEAST:.4g} to {_GREATEST:.4g}; "
            "export in double precision, without --float (precision)"
        )
