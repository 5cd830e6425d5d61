"""The hand-written triple pendulum (`closed_triple.c`) as a peer: three equal links in a row, parallel hinges.

In: a tolerance and an end. Out: hinge angles and rates, positive where the far link goes down.
"""

import ctypes
import subprocess
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]
SOURCE = Path(__file__).with_name("closed_triple.c")
# lamc's own flags, so that both get what one compiler gives.
FLAGS = ("-std=c11", "-O2", "-fPIC", "-ffp-contract=off")


class Model(ctypes.Structure):
    """Three unit plates of the paper: 1 m, 1 kg, thin, k = 100 N·m/rad, b = 10 N·m·s/rad."""

    _fields_ = [
        (name, ctypes.c_double)
        for name in ("length", "centre", "mass", "moment", "stiffness", "damping", "gravity")
    ]


PLATES = Model(1.0, 0.5, 1.0, 1.0 / 12.0, 100.0, 10.0, 9.81)


class ClosedTriple:
    """The compiled peer. textbook: with the formulas as they are printed, else with half as many sines and cosines."""

    def __init__(
        self, folder: Path, *, textbook: bool = False, compiler: str = "cc", flags: Sequence[str] = FLAGS
    ) -> None:
        folder.mkdir(exist_ok=True)
        library = folder / f"closed_triple_{int(textbook)}.so"
        more = ["-DTEXTBOOK"] if textbook else []
        command = [compiler, *flags, *more, "-shared", "-o", str(library), str(SOURCE), "-lm"]
        subprocess.run(command, check=True)
        found = ctypes.CDLL(str(library))
        pointer, number = ctypes.POINTER(ctypes.c_double), ctypes.c_double
        self._run = found.triple_run
        self._run.argtypes, self._run.restype = (
            [ctypes.c_void_p, pointer, number, number, number],
            ctypes.c_long,
        )
        self._slopes = found.triple_slopes
        self._slopes.argtypes = [ctypes.c_void_p, ctypes.c_long, pointer, pointer]
        self._slopes.restype = None

    def run(self, t_end: float, rtol: float, atol: float) -> tuple[Array, int]:
        """Hinge angles, rad, and rates, rad/s, as one row (6,), from rest in the flat position; and the steps."""
        y = np.zeros(6)
        steps = int(self._run(ctypes.addressof(PLATES), _pointer(y), t_end, rtol, atol))
        assert steps > 0, "the step underflows"
        return np.concatenate([np.diff(y[:3], prepend=0.0), np.diff(y[3:], prepend=0.0)]), steps

    def job(self, t_end: float, rtol: float, atol: float) -> Callable[[], int]:
        """The bare run, to be timed."""
        y, start = np.zeros(6), np.zeros(6)
        pointer, model = _pointer(y), ctypes.addressof(PLATES)

        def run() -> int:
            y[:] = start
            return int(self._run(model, pointer, t_end, rtol, atol))

        return run

    def accelerations(self, q: Array, u: Array) -> Array:
        """Accelerations of the hinges, (m, 3), at hinge angles q and rates u, (m, 3)."""
        rows = np.ascontiguousarray(np.hstack([np.cumsum(q, axis=1), np.cumsum(u, axis=1)]))
        out = np.empty_like(rows)
        self._slopes(ctypes.addressof(PLATES), len(rows), _pointer(rows), _pointer(out))
        return np.diff(out[:, 3:], axis=1, prepend=0.0)


def _pointer(array: Array) -> "ctypes._Pointer[ctypes.c_double]":
    return array.ctypes.data_as(ctypes.POINTER(ctypes.c_double))
