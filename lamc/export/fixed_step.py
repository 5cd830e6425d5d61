"""A length for steps of fixed length, by trying: what an exported example begins with.

In: a simulator. Out: seconds. It knows of no error, only of stability: the longest of 1, 2, 5 times a power of ten with
which rates stay within what an adaptive run of the same time reaches.
"""

import math
from typing import Any

import numpy as np

from lamc.export.driven import run_length
from lamc.run.model import Model
from lamc.run.request import Array
from lamc.run.simulator import Simulator

_LENGTHS = (1e-3, 5e-4, 2e-4, 1e-4, 5e-5, 2e-5, 1e-5)  # s
_WINDOW = 0.5  # s, that is tried
_SLACK = 3.0  # of rates: what is stable but coarse may pass beyond them


def suitable_step(simulator: Simulator, *, is_stiff: bool) -> float:
    """A step, s, that is stable from the scene's start on for half a second or the scene's run, whichever is less, or
    the shortest one tried.

    is_stiff  whether steps are those for stiff equations
    """
    t_end = min(run_length(simulator.scene), _WINDOW)
    run = simulator.run(t_end, rtol=1e-5, atol=1e-7, max_steps=100_000)
    largest = _SLACK * max(1e-3, float(np.abs(run.u).max(initial=0.0)))
    for h in _LENGTHS:
        if _is_stable(simulator, h, math.ceil(t_end / h), largest, is_stiff=is_stiff):
            return h
    return _LENGTHS[-1]


def _is_stable(simulator: Simulator, h: float, count: int, largest: float, *, is_stiff: bool) -> bool:
    """Whether rates stay finite and below `largest` over so many steps of length h, s."""
    model = simulator.model
    with model.motion({}).opened() as motion:
        ode = model.ffi.new("lamc_ode *", model.lib.lamc_motion_ode(motion))
        return _stays_below(model, ode, simulator.start.copy(), h, count, largest, is_stiff=is_stiff)


def _stays_below(
    model: Model, ode: Any, y: Array, h: float, count: int, largest: float, *, is_stiff: bool
) -> bool:
    """The same of one equation from the state y (nq + nu,), which is overwritten."""
    lib = model.lib
    step = lib.lamc_stiff_step if is_stiff else lib.lamc_fixed_step
    scratch = np.zeros(lib.lamc_stiff_scratch(ode) if is_stiff else lib.lamc_fixed_scratch(ode))
    state, room = model.write(y), model.write(scratch)
    if model.guards:
        ode.sense(ode.context, 0.0, state)
    rates = y[len(model.coordinates) :]
    for k in range(count):
        if step(ode, k * h, h, state, room) != lib.LAMC_OK:
            return False
        if rates.size and not float(np.abs(rates).max()) <= largest:
            return False
    return True
