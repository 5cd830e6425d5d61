"""Tools from elsewhere beside lamc's integrators, where they are installed and can do what the scene asks for.

In: the reference run and a grid. Out: runners, and the reason for each tool that is missing. CVODE (SUNDIALS, through
scikit-sundae) integrates lamc's own compiled equations, called from Python once per evaluation, as scipy does. Neither
projects: loops stay closed as well as they integrate accelerations that keep them closed. MuJoCo has equations of its
own, in C, and fixed steps of RK4; it shares nothing with lamc but the records.
"""

import importlib
import math
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np

from lamc.basics.errors import LamcError
from lamc.ledger.clock import Clock, OutOfTime
from lamc.ledger.records import Sweep
from lamc.ledger.runners import ATOL, MOST_STEPS, Own, Runner, Trace, grid
from lamc.reference.inputs import with_inputs
from lamc.reference.kinematics import Link, walk
from lamc.reference.loads import NumericLoads, numeric_loads
from lamc.run.request import Array
from lamc.run.result import Result
from lamc.run.simulator import Simulator

PEERS = ("cvode", "mujoco")  # by the name that a sweep gives them
_STEPS = tuple(10.0 ** (-k / 2) for k in range(4, 11))  # s, of MuJoCo: 10 ms to 10 µs
_DRIFT = "loops are held by accelerations alone in"
_THIN = (
    1e-9  # of the largest moment: what is added so that MuJoCo takes a plate without thickness, and taken off
)


def make_runners(simulator: Simulator, truth: Result, sweep: Sweep) -> tuple[list[Runner], list[str]]:
    """A runner for each integrator that is asked for, and why the others are not there. Raises RequestError by the
    first run for a name that nobody knows."""
    times = grid(sweep.t_end, sweep.rows)
    runners: list[Runner] = []
    notes: list[str] = []
    for name in sweep.integrators:
        try:
            if name == "cvode":
                runners += [Cvode(method, truth, times, sweep.tolerances) for method in ("Adams", "BDF")]
            elif name == "mujoco":
                runners.append(Mujoco(simulator, truth, times))
            else:
                runners.append(Own(name, simulator, times, sweep.tolerances))
        except (LamcError, ImportError) as error:
            notes.append(f"{name} is left out: {error}")
    drifting = sorted(
        {runner.name.split(":")[0] for runner in runners if runner.is_peer and not runner.is_step}
    )
    if simulator.cut_joints and drifting:
        notes.append(f"{_DRIFT} {' and '.join(drifting)}: how far they come apart is part of the error")
    return runners, notes


def versions() -> dict[str, str]:
    """Versions of the tools that are installed."""
    found = {}
    for name in ("scipy", "sksundae", "mujoco"):
        try:
            found[name] = str(importlib.import_module(name).__version__)
        except ImportError:
            continue
    return found


class Cvode:
    """CVODE of SUNDIALS on the compiled right-hand side: "Adams" for smooth motion, "BDF" for stiff."""

    is_peer, is_step = True, False

    def __init__(self, method: str, truth: Result, times: Array, settings: tuple[float, ...]) -> None:
        """Raises ImportError without scikit-sundae, LamcError for events, which it does not know."""
        if truth.motion.model.guards:
            raise LamcError("it knows no events")
        try:
            self._solver: Any = importlib.import_module("sksundae.cvode").CVODE
        except ImportError as error:
            raise ImportError("scikit-sundae is not installed") from error
        self.name, self.settings = f"cvode:{method}", settings
        self._method, self._truth, self._times = method, truth, times
        self._start = np.concatenate([truth.q[0], truth.u[0]])

    def trace(self, setting: float, clock: Clock, seconds: float) -> Trace:
        found = self._solve(setting, self._times)
        if not found.success or len(found.t) != len(self._times):
            return Trace(None, " ".join(str(found.message).split()))
        nq = self._truth.q.shape[1]
        result = replace(self._truth, q=found.y[:, :nq].copy(), u=found.y[:, nq:].copy())
        return Trace(result, evaluations=int(found.nfev))

    def job(self, setting: float) -> Callable[[], object]:
        ends = self._times[[0, -1]]
        return lambda: self._solve(setting, ends)

    def _solve(self, setting: float, times: Array) -> Any:
        rhs = self._truth.motion.rhs

        def slope(t: float, y: Array, out: Array) -> None:
            out[:] = rhs(t, y)

        solver = self._solver(
            slope, rtol=setting, atol=ATOL * setting, method=self._method, max_num_steps=MOST_STEPS
        )
        return solver.solve(times, self._start)


class Mujoco:
    """MuJoCo's RK4 at fixed steps on a model of its own: trees with gravity, springs and dampers in hinges."""

    name, is_peer, is_step = "mujoco", True, True

    def __init__(self, simulator: Simulator, truth: Result, times: Array) -> None:
        """Raises ImportError without MuJoCo, LamcError for a scene that it cannot have."""
        try:
            self._mujoco: Any = importlib.import_module("mujoco")
        except ImportError as error:
            raise ImportError("mujoco is not installed") from error
        if simulator.cut_joints:
            raise LamcError("it holds loops by soft constraints, which converge to another motion")
        if simulator.model.series:
            raise LamcError("inputs that follow series are not translated for it")
        inputs = {name: each.default for name, each in simulator.scene.inputs.items()}
        effects = with_inputs(simulator.mechanism, simulator.effects, inputs)
        loads = numeric_loads(simulator.mechanism, effects, simulator.joints)
        if loads.torques or loads.at_points:
            raise LamcError("torques by formula and forces at points are not translated for it")
        self._mujoco.set_mju_user_warning(_unheard)  # else it prints, and writes a file
        self._truth, self._times = truth, times
        span = float(times[1] - times[0])
        self.settings = tuple(dict.fromkeys(span / math.ceil(span / h) for h in _STEPS))
        links = walk(simulator.mechanism, simulator.joints)
        self._model = self._mujoco.MjModel.from_xml_string(_document(links, loads))
        for k, link in enumerate(links):
            self._model.body(f"b{k}").inertia[:] -= _THIN * float(np.abs(link.body.inertia).max())
        self._mujoco.mj_setConst(self._model, self._mujoco.MjData(self._model))
        self._order = [int(self._model.joint(f"j{k}").qposadr[0]) for k in range(len(simulator.joints))]

    def trace(self, setting: float, clock: Clock, seconds: float) -> Trace:
        data, until = self._begun(setting), clock.guard(seconds)
        steps = round(float(self._times[1] - self._times[0]) / setting)
        q, u = np.empty_like(self._truth.q), np.empty_like(self._truth.u)
        try:
            for row in range(len(self._times)):
                if row:
                    self._mujoco.mj_step(self._model, data, steps)
                if any(warning.number for warning in data.warning):
                    return Trace(None, "it becomes unstable, and says so")
                q[row], u[row] = data.qpos[self._order], data.qvel[self._order]
                until(0.0, 0.0)
        except OutOfTime:
            return Trace(None, f"stopped after {seconds:.2g} s")
        total = steps * (len(self._times) - 1)
        return Trace(replace(self._truth, q=q, u=u), steps=total, rejected=0, evaluations=4 * total)

    def job(self, setting: float) -> Callable[[], object]:
        steps = round(float(self._times[-1]) / setting)
        return lambda: self._mujoco.mj_step(self._model, self._begun(setting), steps)

    def _begun(self, setting: float) -> Any:
        self._model.opt.timestep = setting
        data = self._mujoco.MjData(self._model)
        data.qpos[self._order], data.qvel[self._order] = self._truth.q[0], self._truth.u[0]
        return data


def _unheard(_text: str) -> None:
    """What MuJoCo warns of is read from its data instead."""


def _document(links: tuple[Link, ...], loads: NumericLoads) -> str:
    """The model in MJCF: body frames coincide with the world's as drawn, so every number is used as it is."""
    hanging: dict[int, list[int]] = {}
    for k, link in enumerate(links):
        hanging.setdefault(link.inner, []).append(k)

    def body(k: int) -> str:
        link = links[k]
        j = link.coordinate
        solid = link.body.inertia + _THIN * float(np.abs(link.body.inertia).max()) * np.eye(3)
        rest = loads.preload[j] / loads.stiffness[j] if loads.stiffness[j] else 0.0
        below = "".join(body(each) for each in hanging.get(k, []))
        return (
            f'<body name="b{k}"><inertial pos="{_row(link.body.com)}" mass="{link.body.mass!r}" '
            f'fullinertia="{_row(solid[[0, 1, 2, 0, 0, 1], [0, 1, 2, 1, 2, 2]])}"/>'
            f'<joint name="j{j}" type="hinge" pos="{_row(link.joint.point)}" '
            f'axis="{_row(link.sign * link.joint.axis)}" stiffness="{float(loads.stiffness[j])!r}" '
            f'springref="{float(rest)!r}" damping="{float(loads.damping[j])!r}"/>{below}</body>'
        )

    return (
        '<mujoco><compiler angle="radian"/>'
        f'<option integrator="RK4" gravity="{_row(loads.gravity)}">'
        '<flag contact="disable" autoreset="disable"/></option>'
        f"<worldbody>{''.join(body(k) for k in hanging.get(-1, []))}</worldbody></mujoco>"
    )


def _row(values: Array) -> str:
    return " ".join(repr(float(value)) for value in values)
