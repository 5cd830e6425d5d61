"""Runs a `Program` in Python: the cross-check that tests printer, compiler and binding.

A `Program` goes in, numbers come out, one state at a time or a batch of states at once. The meaning of each
operation comes from `operations.py`; nothing is shared with the C printer, and no text is made on the way.
"""

import math
from collections.abc import Mapping
from types import MappingProxyType
from typing import Any, Protocol

import numpy as np
import numpy.typing as npt

from lamc.basics.errors import DesignError
from lamc.records.series import ORDERS
from lamc.reference.constrained import constrained
from lamc.symbolic.listing import listing_of, run
from lamc.symbolic.operations import BATCHED, SCALAR, lookups
from lamc.symbolic.program import Program, Space

Array = npt.NDArray[np.float64]


class Curve(Protocol):
    """A function of the time, with its derivatives."""

    def at(self, t: Any, order: int = 0, /) -> Any: ...


NO_CURVES: Mapping[str, Curve] = MappingProxyType({})


class Interpreter:
    """A `Program` as Python functions; constants come from `constants(parameters)`.

    Coordinates q are arrays of shape (nq,), or (k, nq) for k states at once, and rates u likewise; results then carry
    a leading axis of length k. Raises EmitError for an operation without a meaning here.
    """

    def __init__(self, program: Program, curves: Mapping[str, Curve] = NO_CURVES) -> None:
        """curves: what inputs follow over time, by name; one that is missing is NaN."""
        self.program = program
        self._curves = [curves.get(each.name) for each in program.series]
        self.joints = program.joints
        self.bodies = program.bodies
        tables = lookups(program.tables)
        scalar, batched = {**SCALAR, **tables}, {**BATCHED, **tables}
        self._scalar = {name: listing_of(f, scalar) for name, f in program.functions.items()}
        self._batched = {name: listing_of(f, batched) for name, f in program.functions.items()}

    def constants(self, parameters: Mapping[str, float] | None = None) -> Array:
        """Parameter-only values, shape (constant_count,), with defaults replaced by `parameters` by name.

        Raises DesignError for a name that is no parameter.
        """
        given = dict(parameters or {})
        known = [p.name for p in self.program.parameters]
        for name in given:
            if name not in known:
                raise DesignError(f"no parameter is named {name!r}; there are {', '.join(known[:8])}")
        values = [float(given.get(p.name, p.default)) for p in self.program.parameters]
        values += [number.value for number in self.program.geometry]
        listing = self._scalar["setup"]
        memory = run(listing, {Space.PARAMETER: values})
        constants = np.zeros(self.program.constant_count)
        for k, (sign, address) in enumerate(listing.outputs):
            constants[k] = sign * memory[address]
        for address, index in listing.constants:
            constants[index] = memory[address]
        return constants

    def acceleration(self, t: float, q: Array, u: Array, constants: Array) -> Array:
        """du/dt, shape of u. t in s; of joints, q in rad, u in rad/s. With loops, those of closed states."""
        if self.program.guards and np.ndim(q) == 2:
            rows = zip(q, u, strict=True)
            return np.array([self.acceleration(t, *row, constants) for row in rows]).reshape(np.shape(u))
        constants = self._sensed(t, q, u, constants)
        if "acceleration" in self.program.functions:
            return self._evaluate("acceleration", t, q, u, constants)
        if np.ndim(q) == 2:
            rows = zip(q, u, strict=True)
            return np.array([self._solved(t, *row, constants) for row in rows]).reshape(np.shape(u))
        return self._solved(t, q, u, constants)

    def rates(self, q: Array, u: Array, constants: Array) -> Array:
        """dq/dt, shape of q."""
        if "rates" not in self.program.functions:
            return np.array(u, dtype=np.float64)
        return self._evaluate("rates", 0.0, q, u, constants)

    def gaps(self, q: Array, constants: Array) -> tuple[Array, Array]:
        """Residuals φ (m,) of the loops, rad or parts of the size, and their Jacobian by rates (m, nu), at coordinates
        q (nq,)."""
        m, n = self.program.closure_count, len(self.program.rates)
        flat = self._evaluate("closure", 0.0, q, np.zeros(n), constants)
        return flat[:m], self._dense(flat[m:])

    def energy(self, t: float, q: Array, u: Array, constants: Array) -> Array:
        """Energies, J, shape (len(program.energies),), "kinetic" first."""
        if self.program.guards and np.ndim(q) == 2:
            return np.array([self.energy(t, *row, constants) for row in zip(q, u, strict=True)])
        return self._evaluate("energy", t, q, u, self._sensed(t, q, u, constants))

    def powers(self, t: float, q: Array, u: Array, udot: Array, constants: Array) -> Array:
        """Power of the loads of each effect, W, shape (len(program.powers),), at one state q (nq,), u (nu,) with its
        accelerations (nu,); of programs that tell them."""
        return self._evaluate("power", t, q, u, self._sensed(t, q, u, constants), udot)

    def poses(self, q: Array, constants: Array, t: float = 0.0) -> tuple[Array, Array]:
        """Centres of mass (m, 3), m, and rotations (m, 3, 3), drawn axes to world, by `bodies`."""
        flat = self._evaluate(
            "poses", t, q, np.zeros((*np.shape(q)[:-1], len(self.program.rates))), constants
        )
        rows = flat.reshape(*flat.shape[:-1], len(self.bodies), 12)
        return rows[..., :3], rows[..., 3:].reshape(*rows.shape[:-1], 3, 3)

    def _sensed(self, t: float, q: Array, u: Array, constants: Array) -> Array:
        """`constants` with the modes of one state: 1 for guards that are positive there, 0 for the others."""
        if not self.program.guards:
            return constants
        sensed = np.array(constants, dtype=np.float64)
        if self.program.clocks:
            held = [slot for clock in self.program.clocks for slot in clock.held]
            sensed[held] = self._evaluate("samples", t, q, u, constants)[len(self.program.clocks) :]
        values = self._evaluate("guards", t, q, u, sensed)
        for guard, value in zip(self.program.guards, values, strict=False):  # values, then their rates
            if guard.mode >= 0:
                sensed[guard.mode] = 1.0 if value > 0.0 else 0.0
        return sensed

    def _at(self, t: float, constants: Array) -> list[float]:
        """`constants` with what inputs come to at t: for each its value and derivatives, the first of all."""
        known: list[float] = np.asarray(constants).tolist()
        for place, curve in enumerate(self._curves):
            for order in range(ORDERS):
                value = math.nan if curve is None else float(curve.at(np.float64(t), order))
                known[ORDERS * place + order] = value
        return known

    def _solved(self, t: float, q: Array, u: Array, constants: Array) -> Array:
        """u̇ of M u̇ = f and the closure, at one state."""
        n, held = len(self.program.rates), np.zeros(0)
        if "residual" in self.program.functions:
            none = np.zeros(n)
            columns = [self._evaluate("momenta", t, q, none, constants, unit) for unit in np.eye(n)]
            mass, force = np.array(columns).T, -self._evaluate("residual", t, q, u, constants, none)
            held = self._evaluate("constraints", t, q, u, constants)
        else:
            name = "dynamics" if self.program.cuts else "system"
            triangle = n * (n + 1) // 2
            half, force, held = np.split(self._evaluate(name, t, q, u, constants), [triangle, triangle + n])
            mass = np.zeros((n, n))
            mass[np.tril_indices(n)] = half
            mass += np.tril(mass, -1).T
        jacobian, bias = np.split(held, [len(held) - self.program.closure_count])
        return constrained(mass, force, self._dense(jacobian), bias)

    def _dense(self, entries: Array) -> Array:
        """J (m, nu) of its entries."""
        pattern = self.program.pattern
        return (
            np.zeros((0, len(self.program.rates)))
            if pattern is None
            else pattern.dense(entries, len(self.program.rates))
        )

    def _evaluate(
        self, name: str, t: float, q: Array, u: Array, constants: Array, udot: Array | None = None
    ) -> Array:
        q, u = np.asarray(q, dtype=np.float64), np.asarray(u, dtype=np.float64)
        program, alike = self.program, q.ndim in (1, 2) and q.shape[:-1] == u.shape[:-1]
        nq, nu = len(program.coordinates), len(program.rates)
        if not alike or (q.shape[-1], u.shape[-1]) != (nq, nu):
            raise DesignError(f"angles {q.shape} and rates {u.shape} must be (…, {nq}) and (…, {nu})")
        fixed = {Space.CONSTANT: self._at(t, constants), Space.TIME: [float(t)]}
        if udot is not None:
            fixed[Space.ACCELERATION] = np.asarray(udot).tolist()
        if q.ndim == 1:
            listing = self._scalar[name]
            memory = run(listing, {**fixed, Space.ANGLE: q.tolist(), Space.RATE: u.tolist()})
            return np.array([sign * memory[address] for sign, address in listing.outputs])
        listing = self._batched[name]
        with np.errstate(all="ignore"):
            memory = run(listing, {**fixed, Space.ANGLE: list(q.T), Space.RATE: list(u.T)})
        result = np.empty((len(q), len(listing.outputs)))
        for k, (sign, address) in enumerate(listing.outputs):
            result[:, k] = sign * memory[address]
        return result
