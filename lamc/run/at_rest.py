"""A motion at rest, seen along the positions in which its loops are closed: what pushes it, and how that changes.

In: a `Motion`, a time, coordinates q (nq,). Out: `Stand`s: an orthonormal basis of the rates that keep the loops
closed, the inertia along it, accelerations from rest, their derivatives along the closed positions. Never: searches.

With N (nu, k) such that J N = 0, the rates are u = N v and a position moves by q' = B(q) N v, where B is what makes
coordinates of rates. From rest the accelerations under closure are N a; M N a = f + Jᵀλ, and so N^T M N a = N^T f: the
forces that nothing balances. Derivatives of the accelerations under closure hold λ·φ_qq, the curvature of closure.
"""

from dataclasses import dataclass

import numpy as np

from lamc.basics.once import lazy
from lamc.run.model import Motion
from lamc.run.request import Array
from lamc.run.ridders import derivative

NO_EQUATION = 1e-12  # of a row of J: less is left over from rounding the drawing, as the runtime has it
OPEN = 1e-8  # rad, or of the size: the runtime closes to 1e-13, and what it cannot close stays far above this
_STEP = 1e-3  # of differences, where the model has no derivatives: to 1e-12 and, by round-off, 1e-12
_WIDEST = 0.01  # of differences that are to tell all they can
_LEAST_STEP = 1e-7
_QUATERNION = ("base.qw", "base.qx", "base.qy", "base.qz")


class Rest:
    """A motion at rest at time t, s. size: m, of the mechanism: a length of so much is taken like a radian."""

    def __init__(self, motion: Motion, t: float, size: float) -> None:
        self.motion, self.t, self.size = motion, t, size
        model = motion.model
        self.nq, self.nu = len(model.coordinates), len(model.rates)
        self.freedoms = self.nu - model.rank
        lengths = np.array([rate.unit == "m/s" for rate in model.rates], dtype=bool)
        self.per_radian = np.where(lengths, size or 1.0, 1.0)  # (nu,)
        names = [c.name for c in model.coordinates]
        self._quaternion = [names.index(name) for name in _QUATERNION if name in names]
        self.is_exact = model.handle.jacobian != model.ffi.NULL  # whether derivatives are no differences
        self._gap = motion.gap / size if size > 0.0 else 0.0

    def row(self, q: Array, u: Array | None = None) -> Array:
        """The state (1, nq + nu) with these coordinates, at rest."""
        return np.concatenate([q, np.zeros(self.nu) if u is None else u]).reshape(1, -1)

    def accelerations(self, rows: Array) -> Array:
        """(m, nu) at states (m, nq + nu)."""
        return self.motion.accelerations(np.full(len(rows), self.t), np.ascontiguousarray(rows))

    def guards(self, q: Array) -> Array:
        """Values of the guards (guard_count,), positive where passed."""
        model = self.motion.model
        found = np.zeros(2 * len(model.guards))
        if len(found):
            t, row, udot = np.array([self.t]), self.row(q), np.zeros(self.nu)
            q, still = row[0, : self.nq].copy(), np.zeros(self.nu)
            with self.motion.opened() as handle:  # whose constants then hold what inputs follow at t
                model.lib.lamc_motion_accelerations(
                    handle, 1, model.read(t), model.read(row), model.write(udot)
                )
                given = (handle.constants, self.t, model.read(q), model.read(still))
                model.handle.guards(*given, model.write(found))
        return found[: len(model.guards)]

    def flow(self, q: Array) -> Array:
        """B (nq, nu) of dq/dt = B(q) u."""
        rows = np.hstack([np.tile(q, (self.nu, 1)), np.eye(self.nu)])
        return self.motion.coordinate_rates(rows).T

    def closed(self, q: Array) -> Array | None:
        """The closed position next to q; None where there is none."""
        found = q.copy()
        if self._quaternion:
            found[self._quaternion] /= np.linalg.norm(found[self._quaternion])
        if not self.motion.model.cuts:
            return found
        found = self.motion.settled(self.t, self.row(found)[0])[: self.nq]
        gaps = self.motion.closures(self.row(found))[0, : self.motion.model.closure_count]
        is_closed = np.all(np.isfinite(found)) and np.abs(gaps).max(initial=0.0) <= OPEN + self._gap
        return found if is_closed else None

    def stand(self, q: Array) -> "Stand | None":
        """At closed q (nq,); None where a force or an inertia is not finite."""
        udot = self.accelerations(self.row(q))[0]
        if not np.all(np.isfinite(udot)):
            return None
        tangent, weakest = self._tangent(q)
        inertia = self._inertia(q, tangent)
        try:
            factor = np.linalg.cholesky(inertia)
        except np.linalg.LinAlgError:
            return None
        return Stand(self, q, udot, tangent, weakest, inertia, np.asarray(factor, dtype=float))

    def _tangent(self, q: Array) -> tuple[Array, float]:
        """N (nu, k), and how far the loops' equations are from losing rank: the least singular value that counts over
        the largest, rad or parts of the size by rad. For N, rows of J are taken at equal length, since an equation that
        fades near a flat position keeps its digits."""
        model = self.motion.model
        if not model.rank:
            return np.eye(self.nu), 1.0
        flat = self.motion.closures(self.row(q))[0]
        jacobian = flat[model.closure_count :].reshape(-1, self.nu)
        largest = np.abs(jacobian).max(axis=1)
        kept = jacobian[largest > NO_EQUATION] / largest[largest > NO_EQUATION, None]
        if len(kept) < model.rank:
            kept = np.vstack([kept, np.zeros((model.rank - len(kept), self.nu))])
        rows = np.linalg.svd(kept, full_matrices=True)[2]
        values = np.linalg.svd(jacobian, compute_uv=False)
        is_full = model.rank <= len(values) and values[0] > 0.0
        return rows[model.rank :].T, float(values[model.rank - 1] / values[0]) if is_full else 0.0

    def _inertia(self, q: Array, tangent: Array) -> Array:
        """N^T M N (k, k), kg·m² for angles: by energies, T(a + b) - T(a) - T(b) + T(0), which whatever form the model
        has its equations in tells exactly. Rotors and the air that goes with a wing are among the energies of effects,
        whose potentials fall out, one by one to the last digit."""
        k = tangent.shape[1]
        still = self._energies(q, np.zeros((1, self.nu)))
        moving = 2.0 * (self._energies(q, tangent.T) - still).sum(axis=1)
        scale = np.sqrt(np.maximum(moving, np.finfo(float).tiny))
        unit = (
            tangent.T / scale[:, None]
        )  # of about equal energies, so that no digit is lost between large and small
        first, second = np.triu_indices(k)
        alone = self._energies(q, unit)
        pairs = (self._energies(q, unit[first] + unit[second]) - alone[first] - alone[second] + still).sum(
            axis=1
        )
        matrix = np.zeros((k, k))
        matrix[first, second] = matrix[second, first] = pairs
        return np.asarray(matrix * np.outer(scale, scale), dtype=float)

    def _energies(self, q: Array, rates: Array) -> Array:
        """(m, energies), J, at rates (m, nu)."""
        rows = np.ascontiguousarray(np.hstack([np.tile(q, (len(rates), 1)), rates]))
        return self.motion.energies(np.full(len(rows), self.t), rows)


@dataclass(frozen=True, eq=False)
class Stand:
    """A closed position at rest.

    udot     (nu,), accelerations from rest
    tangent  N (nu, k): orthonormal rates that keep the loops closed
    weakest  of the loops' equations that count, by singular values, over the strongest; 1 without loops
    inertia  N^T M N (k, k), and factor, L of it
    """

    rest: Rest
    q: Array
    udot: Array
    tangent: Array
    weakest: float
    inertia: Array
    factor: Array

    @lazy
    def push(self) -> Array:
        """Lᵀ a (k,): what the loads that nothing balances do, whatever the basis: its square is u̇ᵀ M u̇."""
        return np.asarray(self.factor.T @ (self.tangent.T @ self.udot))

    @lazy
    def flow(self) -> Array:
        """B N (nq, k): how the coordinates change along the tangent."""
        return np.asarray(self.rest.flow(self.q) @ self.tangent)

    @lazy
    def derivatives(self) -> tuple[Array, Array]:
        """Of the accelerations along N (k,) by positions along N, and by rates along N: (k, k) both, 1/s² and 1/s."""
        if not self.rest.is_exact:
            return self.by_differences(_STEP)
        by_q, by_u = self.rest.motion.jacobian(self.rest.t, self.rest.row(self.q)[0])
        return self.tangent.T @ by_q @ self.flow, self.tangent.T @ by_u @ self.tangent

    @lazy
    def slopes(self) -> tuple[Array, Array, float]:
        """`derivatives`, as well as can be, and an estimate of the largest error; 0 where the model has them. Where it
        has none, by differences of several widths: drag and friction may change within a small rate."""
        if self.rest.is_exact:
            return (*self.derivatives, 0.0)
        k = len(self.push)
        found = []
        for part in (slice(None, k), slice(k, None)):
            most = self.width(_WIDEST) if part.start is None else _WIDEST
            tried = [
                derivative(lambda x, part=part: self.differenced(x)[:, part], 0.0, most * share)  # type: ignore[misc]
                for share in (1.0, 1e-2, 1e-4)
            ]
            found.append(min(tried, key=lambda each: each[1]))
        (by_q, wrong_q), (by_u, wrong_u) = found
        return by_q, by_u, max(wrong_q, wrong_u)

    def by_differences(self, h: float) -> tuple[Array, Array]:
        """The same by central differences, h rad, or of the size, and 1/s of that, wide, and half as wide, extrapolated
        to h⁴. Closure that such a step opens, by h², is the same on both sides and falls out. Where contacts change
        within h, it is less."""
        h, k = self.width(h), self.tangent.shape[1]
        found = [(self.differenced(w) - self.differenced(-w)) / (2.0 * w) for w in (h, 0.5 * h)]
        best = (4.0 * found[1] - found[0]) / 3.0
        return best[:, :k], best[:, k:]

    def differenced(self, x: float) -> Array:
        """(k, 2 k): accelerations along N, x along each column of N from here, by positions, then by rates."""
        rest, k = self.rest, self.tangent.shape[1]
        moves = np.zeros((2 * k, rest.nq + rest.nu))
        moves[:k, : rest.nq], moves[k:, rest.nq :] = self.flow.T, self.tangent.T
        steps = moves * (x / np.tile(self._lengths, 2))[:, None]
        there = rest.accelerations(rest.row(self.q) + steps)
        return np.asarray(self.tangent.T @ there.T * np.tile(self._lengths, 2))

    def width(self, h: float) -> float:
        """h, or less, such that no contact is made or lost within it, where that can be."""
        while h > _LEAST_STEP and self._meets(h):
            h *= 0.1
        return h

    def _meets(self, h: float) -> bool:
        """Whether a contact is made or lost within h of here."""
        rest = self.rest
        if not rest.motion.model.guards:
            return False
        steps = (self.flow * (h / self._lengths)).T
        before = rest.guards(self.q) > 0.0
        return any(np.any((rest.guards(self.q + s) > 0.0) != before) for s in (*steps, *-steps))

    @property
    def _lengths(self) -> Array:
        """(k,): of the columns of N, rad/s, or of the size."""
        return np.asarray(np.linalg.norm(self.tangent / self.rest.per_radian[:, None], axis=0))

    @lazy
    def response(self) -> Array:
        """The derivative of `push` by positions along N L⁻ᵀ (k, k), 1/s²: where forces balance it is -L⁻¹ K L⁻ᵀ, with
        the projected Hessian K of conservative loads."""
        factor = self.factor
        return np.asarray(np.linalg.solve(factor, (factor.T @ self.derivatives[0]).T).T)

    def rates(self, step: Array) -> Array:
        """Rates (nu,) of a step (k,) in the axes of `push`."""
        return np.asarray(self.tangent @ np.linalg.solve(self.factor.T, step))

    def reach(self, step: Array) -> float:
        """How far a step (k,) in the axes of `push` goes, rad, or of the size."""
        return float(np.linalg.norm(self.rates(step) / self.rest.per_radian))

    def moved(self, step: Array) -> "Stand | None":
        """Where a step (k,) in the axes of `push` leads, closed again; None where loops come apart or forces have no
        value."""
        going = np.linalg.solve(self.factor.T, step)
        q = self.rest.closed(self.q + self.flow @ going)
        return None if q is None else self.rest.stand(q)
