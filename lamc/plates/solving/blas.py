"""Which BLAS a compiled package is linked to: told by its symbols, never by a clock.

In: files of extension modules. Out: the name of a tuned BLAS among the libraries that they load, or None.

*Invariant*: no choice looks at a clock. A dense matrix that is factored and timed tells a tuned BLAS from the reference
one on a quiet machine; on a busy one the same plate would be solved by another solver, with other last digits.
"""

import ctypes
from collections.abc import Iterable

# A symbol that each has and the reference BLAS has not. Names of files tell little: a distribution's libblas.so.3 may
# be either. OpenBLAS is built with other names where it is bundled with wheels, and for 64-bit indices.
_SIGNS = {
    "OpenBLAS": (
        "openblas_get_config",
        "openblas_get_config64_",
        "scipy_openblas_get_config",
        "scipy_openblas_get_config64_",
    ),
    "MKL": ("mkl_get_version", "MKL_Get_Version"),
    "BLIS": ("bli_info_get_version_str",),
    "ATLAS": ("ATL_buildinfo",),
    "Arm Performance Libraries": ("armplversion", "armplinfo"),
}


def tuned_blas(files: Iterable[str]) -> str | None:
    """The tuned BLAS that one of these libraries loads. None for the reference one, and where the system does not look
    through what a library depends on (Windows): there the user says which solver."""
    for file in files:
        try:
            library = ctypes.CDLL(file)
        except OSError:
            continue
        for name, symbols in _SIGNS.items():
            # The search goes through the library and what it depends on, and not through the rest of the process,
            # where numpy and scipy have BLAS of their own.
            if any(hasattr(library, symbol) for symbol in symbols):
                return name
    return None
