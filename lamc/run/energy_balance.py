"""The energy balance of a run: what energy each effect brought in, took out or stored, and whether it adds up.

In: work and energies along a run. Out: `EnergyBalance`. Never: integrates; knows an effect by name.

The rate of the kinetic energy T is the power of all loads, so T - T₀ = Σ W with the work W of each effect since t = 0,
and what impacts add. An effect that stores V gives W = -(V - V₀) as far as it is conservative; the rest, W + (V - V₀),
it has supplied, or dissipated where it is negative.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType

import numpy as np

from lamc.run.request import Array

IMPACTS = "impacts"
KINETIC = "kinetic"


@dataclass(frozen=True, eq=False)
class Kept:
    """What a run keeps for its energy balance: the state it started from, and work (m, effects, then impacts), J."""

    start: Array
    work: Array


@dataclass(frozen=True)
class Entry:
    """One effect over the whole run, J. supplied = work + stored; negative: dissipated."""

    effect: str
    work: float  # on the motion
    stored: float  # change of what it stores
    supplied: float


@dataclass(frozen=True, eq=False)
class EnergyBalance:
    """Energies since t = 0, each of shape (m,), J.

    kinetic   T - T₀
    work      by effect: of all its loads; of impacts: the energy they added
    stored    by effect: change of what it stores; zero where it stores nothing
    supplied  by effect: work + stored, which is what it brought in from outside; negative: dissipated
    residual  kinetic less the sum of all work: what the integration lost or made, zero but for its error
    scale     the largest sum over the run of the kinetic energy and the sizes of all work, J
    """

    kinetic: Array
    work: Mapping[str, Array]
    stored: Mapping[str, Array]
    supplied: Mapping[str, Array]
    residual: Array
    scale: float

    def __repr__(self) -> str:
        entries = ", ".join(f"{e.effect} {e.supplied:+.3g} J" for e in self.entries)
        return f"<EnergyBalance: {entries}; balance within {self.balance:.1e} of {self.scale:.3g} J>"

    @property
    def entries(self) -> tuple[Entry, ...]:
        """The last row, effect by effect; nothing for a run without rows."""
        if not len(self.kinetic):
            return ()
        names = self.work
        return tuple(
            Entry(n, float(self.work[n][-1]), float(self.stored[n][-1]), float(self.supplied[n][-1]))
            for n in names
        )

    @property
    def balance(self) -> float:
        """The largest residual over the scale; 0 where nothing moves."""
        return float(np.abs(self.residual).max(initial=0.0)) / self.scale if self.scale else 0.0


def energy_balance_of(
    work: Mapping[str, Array], energies: Mapping[str, Array], first: Mapping[str, float]
) -> EnergyBalance:
    """The balance from work (m,) by effect, energies (m,) by name and those at t = 0; J."""
    kinetic = energies[KINETIC] - first[KINETIC]
    zero = np.zeros(len(kinetic))
    changes = {name: values - first[name] for name, values in energies.items() if name != KINETIC}
    names = tuple(dict.fromkeys((*work, *changes)))
    done = {name: work.get(name, zero) for name in names}
    stored = {name: changes.get(name, zero) for name in names}
    sizes = energies[KINETIC] + sum((np.abs(values) for values in done.values()), start=zero)
    return EnergyBalance(
        kinetic=kinetic,
        work=MappingProxyType(done),
        stored=MappingProxyType(stored),
        supplied=MappingProxyType({name: done[name] + stored[name] for name in names}),
        residual=kinetic - sum(done.values(), start=zero),
        scale=float(sizes.max(initial=0.0)),
    )
