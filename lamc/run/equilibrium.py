"""Operating points: where a mechanism stays, and whether it does so when it is pushed.

In: a simulator, a start. Out: an `Equilibrium`, or several; a SimulationError says why there is none.
Never: integrates.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, fields, replace
from functools import partial
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

import numpy as np

from lamc.basics.checks import shown
from lamc.basics.errors import DesignError, LamcError, RequestError, SimulationError
from lamc.basics.once import lazy
from lamc.basics.threads import on_one_thread
from lamc.run.arguments import check_names
from lamc.run.at_rest import Rest, Stand
from lamc.run.balance import DOWN, Search, search, went_far
from lamc.run.defaults import DURATION
from lamc.run.held import true_angles
from lamc.run.model import Motion, Unchanging
from lamc.run.operating_notes import notes_of
from lamc.run.request import Array, finite
from lamc.run.stability import Criterion, Kind, Resistance, resistance
from lamc.run.steady import CLOSED, check_clocks, check_edges, check_rank, check_time, contacts

if TYPE_CHECKING:
    from lamc.run.simulator import Simulator

SAME = 1e-6  # rad, of the size, or of the energy: what is nearer than this is one; each is known far better
_SPREAD = 2.0  # rad: to both sides of the scene's start, where starts are not given

Start = "Mapping[str, float | str] | Equilibrium | None"


@dataclass(frozen=True, eq=False)
class Equilibrium(Unchanging):
    """A position in which the mechanism stays at rest.

    q            coordinates (nq,), in the order of `Simulator.coordinates`
    kind         "stable", "unstable", or "neutral": not held in one direction at least, to first order
    criterion    what says so: "projected Hessian", of conservative loads, or "eigenvalues" of the linear model
    reason       the same for people
    stiffnesses  (k,): eigenvalues of stiffness over inertia, 1/s², ascending: squares of the undamped frequencies where
                 loads are conservative, real parts of them elsewhere; below zero: it falls that way
    residual     largest acceleration that is left, in the units of the rates per second
    uncertainty  of the position, rad, or of the mechanism's size: the last Newton step, or what closure leaves open
    energy       stored at rest, J; loads that store none, such as torques, have no part in it
    contacts     names of conditions that hold: limits reached, points that touch, points of tables that are passed
    moved        the largest way of a coordinate from the start, rad or m
    way          how it was found: "nearest", or "descended" where the loads push
    steps        that it took
    t            s: loads are those of that instant
    notes        what to mind
    """

    q: Array
    kind: Kind
    criterion: Criterion
    reason: str
    stiffnesses: Array
    residual: float
    uncertainty: float
    energy: float
    contacts: tuple[str, ...]
    moved: float
    way: str
    steps: int
    t: float
    notes: tuple[str, ...]
    motion: Motion = field(repr=False)
    stand: Stand = field(repr=False)
    resistance: Resistance = field(repr=False)

    def __reduce__(self) -> tuple[Any, ...]:
        return partial(type(self), **{each.name: getattr(self, each.name) for each in fields(self)}), ()

    @property
    def stable(self) -> bool:
        """Whether a small push is answered by a motion that stays small; neutral ones are not held."""
        return self.kind == "stable"

    @lazy
    def angles(self) -> Mapping[str, float]:
        """By joint, rad."""
        return MappingProxyType({name: float(self.q[k]) for k, name in enumerate(self.motion.model.joints)})

    @lazy
    def coordinates(self) -> Mapping[str, float]:
        """By name, with those that effects add, rad and m."""
        names = [c.name for c in self.motion.model.coordinates]
        return MappingProxyType(dict(zip(names, self.q.tolist(), strict=True)))

    def __repr__(self) -> str:
        shown = ", ".join(f"{name} {np.degrees(angle):.4g}°" for name, angle in list(self.angles.items())[:4])
        more = f", … ({len(self.angles)} joints)" if len(self.angles) > 4 else ""
        return f"<Equilibrium, {self.kind}: {shown}{more}; {self.reason}>"


@on_one_thread
def equilibrium_of(
    simulator: "Simulator",
    angles: "Mapping[str, float | str] | Equilibrium | None",
    parameters: Mapping[str, float | str],
    t: float | None,
    *,
    stable: bool,
) -> Equilibrium:
    """As `Simulator.equilibrium`."""
    rest = _rest(simulator, parameters, t)
    return _found(simulator, rest, _start(simulator, rest, angles), has_time=t is not None, stable=stable)


@on_one_thread
def equilibria_of(
    simulator: "Simulator",
    starts: "int | Sequence[Mapping[str, float | str]]",
    parameters: Mapping[str, float | str],
    t: float | None,
    *,
    stable: bool,
) -> tuple[Equilibrium, ...]:
    """As `Simulator.equilibria`."""
    rest = _rest(simulator, parameters, t)
    found: list[Equilibrium] = []
    refusals: list[LamcError] = []
    for angles in _starts(simulator, starts):
        try:
            place = _start(simulator, rest, angles)
            point = _found(simulator, rest, place, has_time=t is not None, stable=stable)
        except RequestError:
            raise
        except (SimulationError, DesignError) as error:
            refusals.append(error)
            continue
        if not any(_is_same(point, other) for other in found):
            found.append(point)
    if not found:
        raise refusals[0]
    return tuple(sorted(found, key=lambda each: (round(each.energy, 15), *np.round(each.q, 6))))


def _rest(simulator: "Simulator", parameters: Mapping[str, float | str], t: float | None) -> Rest:
    check_clocks(simulator.model)
    instant = 0.0 if t is None else finite(t, "t", "a time in s")
    return Rest(simulator.model.motion(parameters), instant, simulator.mechanism.size)


def _start(
    simulator: "Simulator", rest: Rest, angles: "Mapping[str, float | str] | Equilibrium | None"
) -> Stand:
    """Where the search begins."""
    if isinstance(angles, Equilibrium):
        if angles.motion.model.structure != simulator.structure:
            raise RequestError("angles is an equilibrium of another mechanism; give angles by joint")
        q = rest.closed(angles.q)
    else:
        if angles is not None and not isinstance(angles, Mapping):
            raise RequestError(
                f"angles is {shown(angles)}; it must map joints to angles, as in {{'h1': '30 deg'}}, or be an "
                "equilibrium"
            )
        scene = (
            simulator.scene
            if angles is None
            else replace(simulator.scene, angles=angles, rates={}, branch=None)
        )
        check_names(
            scene, tuple(dict.fromkeys((*simulator.joints, *(j.name for j in simulator.mechanism.joints))))
        )
        q = rest.closed(simulator.start_of(scene)[: rest.nq])
    if q is None:
        raise SimulationError(
            "the loops do not close at the start of the search; give angles that close them"
        )
    stand = rest.stand(np.ascontiguousarray(q))
    if stand is None:
        raise SimulationError(
            "forces have no value at the start of the search; give angles where they have one"
        )
    return stand


def _starts(simulator: "Simulator", starts: object) -> "list[Mapping[str, float | str] | None]":
    """The scene's start and those given, or spread evenly over the joints of the tree (Halton's sequence)."""
    if isinstance(starts, int) and not isinstance(starts, bool) and starts > 0:
        from scipy.stats import qmc

        joints = simulator.joints[: len(simulator.joints) - len(simulator.cut_joints)]
        free = joints[: max(1, min(len(joints), simulator.freedoms))]
        near = np.array([simulator.scene.angles.get(name, 0.0) for name in free])
        spread = near + _SPREAD * (2.0 * qmc.Halton(len(free), scramble=False).random(starts)[1:] - 1.0)
        return [None, *(dict(zip(free, row, strict=True)) for row in spread.tolist())]
    if isinstance(starts, Sequence) and starts and all(isinstance(each, Mapping) for each in starts):
        return list(starts)
    raise RequestError(
        f"starts is {shown(starts)}; it must be a number of starts above zero, or a list of angles by joint"
    )


def _found(simulator: "Simulator", rest: Rest, start: Stand, *, has_time: bool, stable: bool) -> Equilibrium:
    """The equilibrium next to a start. Raises SimulationError where there is none, or none that can be told of."""
    duration = simulator.scene.duration or DURATION
    if not has_time:
        check_time(rest, start.q, duration)
    ended = search(start, stable=stable)
    if not ended.is_balanced:
        raise SimulationError(_refusal(start, ended))
    stand = ended.stand
    if not has_time:
        check_time(rest, stand.q, duration)
    check_rank(stand)
    check_edges(stand)
    found = resistance(stand)
    q = true_angles(simulator, rest.motion, rest.row(stand.q))
    q.flags.writeable = False
    energies = rest.motion.energies(np.array([rest.t]), rest.row(stand.q))[0]
    return Equilibrium(
        q=q,
        kind=found.kind,
        criterion=found.criterion,
        reason=found.reason,
        stiffnesses=np.sort(np.linalg.eigvals(found.stiffness).real),
        residual=float(np.abs(stand.udot).max(initial=0.0)),
        uncertainty=max(ended.step, CLOSED / stand.weakest if rest.motion.model.rank else 0.0),
        energy=float(energies[1:].sum()),
        contacts=contacts(rest, stand.q),
        moved=float(np.abs(q - start.q).max(initial=0.0)),
        way=ended.way,
        steps=ended.steps,
        t=rest.t,
        notes=notes_of(simulator.mechanism, q, ended, found, has_time=has_time),
        motion=rest.motion,
        stand=stand,
        resistance=found,
    )


def _refusal(start: Stand, ended: Search) -> str:
    """Why there is no equilibrium."""
    model, stand = start.rest.motion.model, ended.stand
    worst = int(np.abs(stand.udot / start.rest.per_radian).argmax())
    rate = model.rates[worst]
    where = ", ".join(
        f"{name} {np.degrees(q):.4g}°" for name, q in zip(model.joints[:4], stand.q, strict=False)
    )
    free = not np.any(np.abs(stand.response) > 0.0)
    why = "no load there depends on the position" if free else "from there no small change lessens it"
    if went_far(start, stand):
        why = "loads push it on and on"
    elif ended.steps >= DOWN:
        why = "the search has not come to an end"
    return (
        f"no equilibrium is within reach of the start: after {ended.steps} steps {rate.name!r} still accelerates by "
        f"{stand.udot[worst]:.3g} {rate.unit}² at {where}, and {why}; start elsewhere (angles=…, or "
        "equilibria(starts=20)), or see what holds it"
    )


def _is_same(point: Equilibrium, other: Equilibrium) -> bool:
    """Whether all bodies are at the same places, and equally strained: a hinge that nothing winds up may have made
    turns, and a quaternion may be the other one of two."""
    rest, model = point.stand.rest, point.motion.model
    rows = np.vstack([rest.row(point.q), rest.row(other.q)])
    here, there = rest.motion.poses(np.full(2, rest.t), rows)
    apart = np.abs(here - there)
    apart[:, :3] /= rest.size or 1.0
    own = [k for k, c in enumerate(model.coordinates) if k >= len(model.joints) and "base." not in c.name]
    deformed = np.abs(point.q[own] - other.q[own]).max(initial=0.0)
    strained = abs(point.energy - other.energy) > SAME * max(abs(point.energy), abs(other.energy))
    return bool(apart.max(initial=0.0) <= SAME and deformed <= SAME and not strained)
