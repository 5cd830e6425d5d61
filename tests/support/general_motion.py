"""Runs equations in the general form in Python: staged values as plain functions of t, q and u, integrated by scipy.

The road of the tests here leads past C, printer and runtime: what they judge is the derivation.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import numpy.typing as npt
from scipy.integrate import solve_ivp

from lamc.mechanics.equations import Equations
from lamc.pipeline import equations_of
from lamc.records.effect import Effect
from lamc.records.mechanism import Mechanism
from lamc.reference.constrained import constrained
from lamc.symbolic.functions import FUNCTIONS
from lamc.symbolic.scalars import NUMBER, Scalar, Value
from lamc.symbolic.staging import SYMBOL, Symbol

Array = npt.NDArray[np.float64]
_INFIX = {"+": "+", "-": "-", "*": "*"}


def compiled(equations: Equations, outputs: Sequence[Scalar]) -> Callable[..., Array]:
    """outputs as a function of (t, q, u, a=()), parameters at their defaults; arrays in, an array out."""
    store = equations.store
    lines = ["def f(t, q, u, a=()):"]
    for index in store.live(outputs):
        operation, at = store.operations[index], store.arguments[index]
        payload = store.payloads.get(index)
        if operation == SYMBOL:
            assert isinstance(payload, Symbol)
            space, k = payload.space.name, payload.index
            text = {"ANGLE": f"q[{k}]", "RATE": f"u[{k}]", "TIME": "t", "ACCELERATION": f"a[{k}]"}.get(space)
            text = repr(equations.parameters[k].default) if space == "PARAMETER" else text
        elif payload is not None or operation == NUMBER:
            assert payload is not None
            assert not isinstance(payload, Symbol)
            text = repr(float(payload))
        elif operation in _INFIX:
            text = f"z{at[0]} {_INFIX[operation]} z{at[1]}"
        elif operation == "neg":
            text = f"-z{at[0]}"
        elif operation == "reciprocal":
            text = f"1.0 / z{at[0]}"
        else:
            text = f"F_{operation}({', '.join(f'z{i}' for i in at)})"
        lines.append(f"    z{index} = {text}")
    names = [
        f"{'-' if v.sign < 0 else ''}z{v.index}" if isinstance(v, Value) else repr(float(v)) for v in outputs
    ]
    lines.append(f"    return array([{', '.join(names)}])")
    space: dict[str, Any] = {f"F_{name}": f.value for name, f in FUNCTIONS.items()} | {"array": np.array}
    exec("\n".join(lines), space)
    function: Callable[..., Array] = space["f"]
    return lambda t, q, u, a=(): function(float(t), list(map(float, q)), list(map(float, u)), a)


@dataclass(frozen=True)
class Motion:
    """States along a run: t (m,), q (m, nq), u (m, nu)."""

    t: Array
    q: Array
    u: Array


class General:
    """One mechanism under effects, in the general form."""

    def __init__(self, mechanism: Mechanism, effects: Sequence[Effect]) -> None:
        equations = self.equations = equations_of(mechanism, tuple(effects)).forked()  # to write in
        arrangement = equations.arrangement
        assert arrangement is not None
        assert not arrangement.is_plain
        self.arrangement = arrangement
        self.coordinates = [c.name for c in equations.coordinates]
        self.rates = [c.name for c in equations.rates]
        n = self.n = len(self.rates)
        lower = [equations.inertia.get((i, j), 0) for i in range(n) for j in range(i + 1)]
        closure = equations.closure
        self.m = len(closure.residual) if closure else 0
        self.places = [(i, j) for i, row in enumerate(closure.jacobian) for j, _ in row] if closure else []
        held = [*(v for row in closure.jacobian for _, v in row), *closure.bias] if closure else []
        self._system = compiled(equations, [*lower, *equations.forces, *held])
        rates = equations.coordinate_rates
        self._speeds = compiled(equations, rates) if rates is not None else None

    @cached_property
    def _energies(self) -> Callable[..., Array]:
        return compiled(self.equations, list(self.equations.energies.values()))

    @cached_property
    def _poses(self) -> Callable[..., Array]:
        return compiled(self.equations, list(self.equations.poses))

    @cached_property
    def _powers(self) -> Callable[..., Array]:
        return compiled(self.equations, list(self.equations.powers.values()))

    def start(self, q: Sequence[float], u: Sequence[float]) -> tuple[Array, Array]:
        """Angles and rates of the joints with what the arrangement starts the others at."""
        return self.arrangement.start(q, u)

    def system(self, t: float, q: Array, u: Array) -> tuple[Array, Array, Array, Array]:
        """M, f, J, γ."""
        n, values = self.n, self._system(t, q, u)
        mass = np.zeros((n, n))
        mass[np.tril_indices(n)] = values[: n * (n + 1) // 2]
        mass += np.tril(mass, -1).T
        rest = values[n * (n + 1) // 2 :]
        jacobian = np.zeros((self.m, n))
        for place, value in zip(self.places, rest[n:], strict=False):
            jacobian[place] = value
        return mass, rest[:n], jacobian, rest[n + len(self.places) :]

    def acceleration(self, t: float, q: Array, u: Array) -> Array:
        """u̇."""
        mass, force, jacobian, bias = self.system(t, q, u)
        if self.m:
            return constrained(mass, force, jacobian, bias)
        return np.linalg.solve(mass, force)

    def speeds(self, q: Array, u: Array) -> Array:
        """q̇."""
        return np.asarray(u, dtype=float) if self._speeds is None else self._speeds(0.0, q, u)

    def energies(self, t: float, q: Array, u: Array) -> dict[str, float]:
        """By name, J."""
        return dict(zip(self.equations.energies, self._energies(t, q, u).tolist(), strict=True))

    def energy(self, t: float, q: Array, u: Array) -> float:
        """Their sum, J."""
        return float(self._energies(t, q, u).sum())

    def power(self, name: str, t: float, q: Array, u: Array) -> float:
        """Of an effect, W."""
        values = self._powers(t, q, u, self.acceleration(t, q, u).tolist())
        return float(values[list(self.equations.powers).index(name)])

    def poses(self, t: float, q: Array) -> dict[str, tuple[Array, Array]]:
        """Centre and rotation by body."""
        flat = self._poses(t, q, np.zeros(self.n)).reshape(-1, 12)
        rows = zip(self.equations.bodies, flat, strict=True)
        return {name: (row[:3], row[3:].reshape(3, 3)) for name, row in rows}

    def run(self, q: Array, u: Array, t_eval: Array, rtol: float = 1e-11, atol: float = 1e-13) -> Motion:
        """scipy's DOP853 from t_eval[0] on."""
        nq = len(q)

        def rhs(t: float, y: Array) -> Array:
            return np.concatenate([self.speeds(y[:nq], y[nq:]), self.acceleration(t, y[:nq], y[nq:])])

        span = (float(t_eval[0]), float(t_eval[-1]))
        done = solve_ivp(
            rhs, span, np.concatenate([q, u]), method="DOP853", t_eval=t_eval, rtol=rtol, atol=atol
        )
        assert done.success, done.message
        return Motion(done.t, done.y[:nq].T, done.y[nq:].T)
