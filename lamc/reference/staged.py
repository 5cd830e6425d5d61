"""From values of the staged equations to joint accelerations.

In: `Equations`, and the values of those of its assignments that `names` lists. Out: u̇. For a tree the values are u̇; for
loops they are M, f, J and γ, and numpy solves M u̇ = f under J u̇ + γ = 0, redundant equations included.
"""

from typing import TYPE_CHECKING

import numpy as np

from lamc.records.mechanism import Array
from lamc.reference.constrained import constrained

if TYPE_CHECKING:
    from lamc.mechanics.equations import Equations


class StagedValues:
    """`names` of the assignments that accelerations follow from, in the order in which `acceleration` takes them."""

    def __init__(self, equations: "Equations") -> None:
        self.count = n = len(equations.joints)
        self.is_closed = equations.closure is not None
        if equations.closure is None:
            self.names = tuple(f"udot_{joint}" for joint in equations.joints)
            return
        rows = range(len(equations.closure.residual))
        self._entries = np.array(sorted(equations.inertia), dtype=int)
        self._rows = len(rows)
        self._places = [(i, j) for i, row in enumerate(equations.closure.jacobian) for j, _ in row]
        self.names = (
            *(f"M_{i}_{j}" for i, j in self._entries.tolist()),
            *(f"f_{i}" for i in range(n)),
            *(f"J_{i}_{j}" for i, j in self._places),
            *(f"gamma_{i}" for i in rows),
        )

    def acceleration(self, values: Array) -> Array:
        """u̇, shape (n,), rad/s², from the values (len(names),)."""
        if not self.is_closed:
            return values
        n, m, entries = self.count, self._rows, len(self._entries)
        mass = np.zeros((n, n))
        i, j = self._entries.T
        mass[i, j] = mass[j, i] = values[:entries]
        force, rest = values[entries : entries + n], values[entries + n :]
        jacobian = np.zeros((m, n))
        for (i, j), value in zip(self._places, rest, strict=False):
            jacobian[i, j] = value
        return constrained(mass, force, jacobian, rest[len(self._places) :])
