"""How long the arrays of an instance are: as the compiled runtime says."""

from dataclasses import dataclass
from typing import Any

from lamc.export.options import ExportOptions
from lamc.run.methods import NUMBERS
from lamc.run.model import Model


@dataclass(frozen=True)
class Sizes:
    """Lengths of arrays in C, at least 1 each, since C has no empty ones."""

    q: int
    u: int
    y: int  # state, q and u
    joints: int
    bodies: int
    energies: int
    parameters: int
    constants: int
    modes: int  # of guards
    motion: int  # what a motion works with
    work: int  # what a run works with
    fixed: int  # what a step of fixed length works with
    scratch: int  # what derivatives work with


def sizes_of(model: Model, options: ExportOptions) -> Sizes:
    """Lengths for `model` run as the options say."""
    with model.motion({}).opened() as motion:
        ode = model.ffi.new("lamc_ode *", model.lib.lamc_motion_ode(motion))
        ode.integral_count = 0
        return _sizes(model, ode, options)


def _sizes(model: Model, ode: Any, options: ExportOptions) -> Sizes:
    lib = model.lib
    lengths = {
        "q": len(model.coordinates),
        "u": len(model.rates),
        "y": model.state_size,
        "joints": len(model.joints),
        "bodies": len(model.bodies),
        "energies": len(model.energies),
        "parameters": len(model.parameters) + len(model.geometry),
        "constants": model.constant_count,
        "modes": len(model.guards),
        "motion": lib.lamc_motion_work_size(model.handle),
        "work": lib.lamc_run_work_size(ode, NUMBERS[options.integrator]),
        "fixed": lib.lamc_stiff_scratch(ode) if options.is_stiff else lib.lamc_fixed_scratch(ode),
        "scratch": lib.lamc_motion_jacobian_scratch(model.handle),
    }
    return Sizes(**{name: max(1, int(length)) for name, length in lengths.items()})
