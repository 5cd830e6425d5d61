"""The ensemble of a simulator, from its arguments to its rows.

In: a `Simulator` and checked arguments. Out: an `Ensemble`. Never: runs anything in Python.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from lamc.basics.errors import RequestError
from lamc.basics.places import located_at
from lamc.codegen.options import MOST_RATES_IN_LOOPS, why_alone
from lamc.records.effect import overrides
from lamc.run.ensemble import Ensemble, Instances, run_instances
from lamc.run.instances import Values, columns, made_instances
from lamc.run.methods import NUMBERS
from lamc.run.parameters import with_limits
from lamc.run.request import Array, Request, did_you_mean
from lamc.run.start_checks import check_run, check_start

if TYPE_CHECKING:
    from lamc.run.result import Result
    from lamc.run.simulator import Simulator

_CHECKS = ("check_start", "check_poses", "drives")


def ensemble_of(
    simulator: "Simulator",
    request: Request,
    integrator: str,
    given: tuple[Values, Values, Values],
    threads: int | None,
    *,
    side_by_side: bool,
) -> Ensemble:
    """See `Simulator.ensemble`; given: parameters, angles and rates."""
    if integrator not in NUMBERS:
        raise RequestError(
            f"ensembles have no integrator {integrator!r}; {did_you_mean(integrator, NUMBERS)}"
        )
    if threads is not None and (isinstance(threads, bool) or not isinstance(threads, int) or threads < 1):
        raise RequestError(f"threads is {threads!r}; it must be a whole number above zero, or None")
    instances = _instances(simulator, request, given)
    if request.t_eval is None:
        ends = np.array([0.0, request.t_end] if request.t_end > 0.0 else [0.0])
        request = replace(request, t_eval=ends)
    alone = _why_alone(simulator) if side_by_side else "side_by_side is off"
    following = simulator.model.motion({}).following
    with located_at(simulator.scene.places):
        following.check_run(request.t_end)
    y, status, t_reached, stats = run_instances(
        simulator.lanes,
        instances,
        request,
        integrator,
        threads,
        following,
        use_lanes=not alone,
        why_alone=alone,
    )
    nq = len(simulator.coordinates)
    assert request.t_eval is not None
    return Ensemble(
        t=request.t_eval,
        q=y[:, :, :nq],
        u=y[:, :, nq:],
        status=status,
        t_reached=t_reached,
        stats=stats,
        refusals=instances.refusals,
        _run=_Alone(simulator, instances, replace(request, progress=None), integrator),
    )


def _why_alone(simulator: "Simulator") -> str:
    """As the module was made; without the program, which would be derived anew where all came from the cache."""
    precision = "float" if "-DLAMC_FLOAT" in simulator.lanes.flags else "double"
    model = simulator.lanes.lib.lamc_this_model()
    is_large = bool(simulator.cut_joints) and (
        model.pattern.step_count > 0
        or model.dynamics == simulator.lanes.ffi.NULL
        or model.rate_count > MOST_RATES_IN_LOOPS
    )
    return why_alone(large_loops=is_large, moves=bool(simulator.rates), precision=precision)


def _instances(simulator: "Simulator", request: Request, given: tuple[Values, Values, Values]) -> Instances:
    known = dict.fromkeys((*simulator.joints, *(joint.name for joint in simulator.mechanism.joints)))
    count, parameters, angles, rates = columns(*given, simulator.parameter_units, list(known))
    plain = simulator.joints if len(simulator.coordinates) == len(known) and not simulator.cut_joints else ()
    return made_instances(
        count,
        simulator.parameters,
        simulator.model.geometry,
        parameters,
        angles,
        rates,
        simulator.scene,
        simulator.start_of,
        _checker(simulator, request.t_end),
        plain,
    )


def _checker(simulator: "Simulator", t_end: float) -> Callable[[Mapping[str, float], Array], None] | None:
    """Shows the effects parameters and a start; None where none asks for them."""
    effects: tuple[Any, ...] = simulator.effects
    if not any(overrides(effect, what) for effect in effects for what in _CHECKS):
        return None

    def check(parameters: Mapping[str, float], start: Array) -> None:
        motion = simulator.model.motion(parameters)
        check_start(effects, with_limits(simulator.mechanism, parameters), motion, start)
        check_run(effects, simulator.mechanism, motion, start, t_end)

    return check


@dataclass(frozen=True, eq=False)
class _Alone:
    """Runs one instance by itself, in another process too."""

    simulator: "Simulator"
    instances: Instances
    request: Request
    integrator: str

    def __call__(self, k: int) -> "Result":
        simulator, instances = self.simulator, self.instances
        values = instances.parameters[k % len(instances.parameters)].tolist()
        parameters = dict(zip(simulator.parameters, values, strict=False))
        request = replace(self.request, y0=instances.starts[k % len(instances.starts)].copy())
        return simulator.integrated(simulator.model.motion(parameters), parameters, request, self.integrator)
