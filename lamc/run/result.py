"""The `Result` of a run: what was computed, by name.

In: rows from an integrator. Out: angles, rates, energies and poses in SI units, tables and files. Energies
and poses are evaluated by the compiled model when first asked for. Never: integrates, or changes after it
was made.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, fields, replace
from functools import partial
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from lamc.basics.drawing import drawer
from lamc.basics.errors import RequestError
from lamc.basics.moved import superseded
from lamc.basics.once import lazy
from lamc.basics.seen import Viewable
from lamc.records.mechanism import Mechanism
from lamc.records.scene import OutputPoint
from lamc.run import doubts
from lamc.run.accuracy_record import Accuracy
from lamc.run.derivatives import Sensitivities
from lamc.run.energy_balance import IMPACTS, EnergyBalance, Kept, energy_balance_of
from lamc.run.given_out import GivenOut
from lamc.run.model import Motion, Unchanging
from lamc.run.quantities import Quantity, quantity_of
from lamc.run.request import Array, Status
from lamc.run.run_record import Event, Provenance, RunStats
from lamc.run.taping import Tape
from lamc.symbolic.program import Coordinate

if TYPE_CHECKING:
    from lamc.records.effect import PlaneMark
    from lamc.run.gradients import Gradient


@dataclass(frozen=True, eq=False)
class Result(GivenOut, Viewable, Unchanging):
    """A run, complete or not. m rows at times t.

    t, q, u  times (m,), s; coordinates (m, nq) and rates (m, nu), in the order of `coordinates` and `rates`: first
             joint angles, rad, and joint rates, rad/s, in the order of `joints`, and for most scenes nothing else
    status   how it ended: 0 (`Status.REACHED_END`), 1 (`FOLDED`), or a negative `Status`; every row is good in any case
    message  the same for people
    stats    what it took
    events   limits reached and left, and impacts, in order
    marks    what pictures show besides the bodies, such as the ground
    accuracy what a run to an accuracy came to; None for runs at a tolerance
    outputs  what the scene asks for: names and points; empty: all hinges

    Rows lie where `run` was asked for them. A run that ended early ends with one more: the last state it reached.

    As `solve_ivp` has it: `t`, `y` (nq + nu, m), `status`, `message`, `success`, `nfev`.
    """

    t: Array  # (m,), s
    q: Array  # (m, nq)
    u: Array  # (m, nu)
    status: Status
    message: str
    stats: RunStats
    provenance: Provenance
    mechanism: Mechanism
    motion: Motion = field(repr=False)
    events: tuple[Event, ...] = ()
    marks: "tuple[PlaneMark, ...]" = ()
    accuracy: Accuracy | None = None
    outputs: tuple[str | OutputPoint, ...] = ()

    telling: Callable[[], Motion] | None = field(default=None, repr=False)  # of the motion that tells powers
    sensitivities: Sensitivities | None = None  # where the run was differentiated
    kept: Kept | None = field(default=None, repr=False)  # where the run kept the energy balance
    tape: Tape | None = field(default=None, repr=False)  # where the run kept its steps; it is not pickled
    tape_lost: str | None = field(
        default=None, repr=False
    )  # why there is none any more of a run that kept its steps

    def __post_init__(self) -> None:
        for array in (self.t, self.q, self.u):
            array.flags.writeable = False

    def __repr__(self) -> str:
        n = len(self.joints)
        return f"<Result of {self.provenance.design!r}: {len(self.t)} rows, {n} joints; {self.message}>"

    def __reduce__(self) -> tuple[Any, ...]:
        kept = {each.name: getattr(self, each.name) for each in fields(self) if each.name != "tape"}
        if self.tape is not None:
            kept["tape_lost"] = "the tape of a run is not pickled with its result: take the gradient before"
        return partial(type(self), **kept), ()

    @property
    def success(self) -> bool:
        """True if the run reached its end, or what was to end it."""
        return self.status >= Status.REACHED_END

    @lazy
    def notes(self) -> tuple[str, ...]:
        """One line for each thing in which this result may not be what it seems; looked for when asked for."""
        return doubts.notes(self)

    @property
    def error_estimate(self) -> float | None:
        """Largest error of any output at any row, relative to the output's range over the run, as a run to an accuracy
        estimates it; details are in `accuracy`. None for a run at a tolerance, which knows errors of steps only."""
        return self.accuracy.error if self.accuracy is not None else None

    def at_rows(self, keep: npt.NDArray[np.bool_]) -> "Result":
        """The result with some of its rows only. keep: shape (m,), of bool."""
        kept = self.kept and replace(self.kept, work=self.kept.work[keep])
        found = self.sensitivities
        if found is not None:
            found = replace(found, values=found.values[keep])
        t, q, u = self.t[keep], self.q[keep], self.u[keep]
        lost = self.tape_lost
        if self.tape is not None:
            lost = (
                "the tape is of all rows, and some are left out here: take the gradient of the whole result"
            )
        return replace(self, t=t, q=q, u=u, kept=kept, sensitivities=found, tape=None, tape_lost=lost)

    @property
    def nfev(self) -> int:
        """Evaluations of the right-hand side."""
        return self.stats.evaluations

    @property
    def y(self) -> Array:
        """State, shape (nq + nu, m): coordinates, then rates; the layout of `solve_ivp`."""
        return self._rows.T

    @property
    def joints(self) -> tuple[str, ...]:
        """Names of the joints, in the order of the first columns of q and u."""
        return self.motion.model.joints

    @lazy
    def hinges(self) -> tuple[str, ...]:
        """Names of all hinges whose angle is known, those that close loops too, in the design's order."""
        known = {*self.joints, *self._held}
        return tuple(joint.name for joint in self.mechanism.joints if joint.name in known)

    @property
    def coordinates(self) -> tuple[Coordinate, ...]:
        """Names and units of the columns of q: the joints, then what effects add."""
        return self.motion.model.coordinates

    @property
    def rates(self) -> tuple[Coordinate, ...]:
        """Names and units of the columns of u."""
        return self.motion.model.rates

    def coordinate(self, name: str) -> Array:
        """One coordinate by name, as "base.z", shape (m,), in the unit that `coordinates` tells. Raises KeyError with
        the names there are."""
        return self.q[:, _place(name, self.coordinates, "coordinate")]

    @property
    def bodies(self) -> tuple[str, ...]:
        """Names of all bodies, fixed ones too."""
        return tuple(body.name for body in self.mechanism.bodies)

    def angle(self, joint: str) -> Array:
        """Angle of a joint, shape (m,), rad; zero as drawn, positive by the right-hand rule about its axis,
        child relative to parent; it counts turns. Raises KeyError with the names there are."""
        return self.coordinate(joint) if joint in self._held else self._of(joint, self.q)

    def rate(self, joint: str) -> Array:
        """Rate of a joint, shape (m,), rad/s, or another of `rates`, as "base.vz", in the unit told there. Raises
        KeyError with the names there are."""
        if any(rate.name == joint for rate in self.rates[len(self.joints) :]):
            return self.u[:, _place(joint, self.rates, "rate")]
        if joint in self._held:
            return self.motion.coordinate_rates(self._rows)[:, _place(joint, self.coordinates, "joint")]
        return self._of(joint, self.u)

    @lazy
    def energies(self) -> Mapping[str, Array]:
        """Energies by name, each of shape (m,), J: "kinetic", then one for each effect that stores energy."""
        values = self.motion.energies(self.t, self._rows)
        values.flags.writeable = False
        return MappingProxyType({name: values[:, i] for i, name in enumerate(self.motion.model.energies)})

    @lazy
    def energy(self) -> Array:
        """Kinetic plus stored energy, shape (m,), J."""
        return sum(self.energies.values(), start=np.zeros(len(self.t)))

    @lazy
    def powers(self) -> Mapping[str, Array]:
        """Power of all loads of each effect, conservative ones too, each of shape (m,), W. With that of impacts, and of
        what moves a base as prescribed, the rate of the kinetic energy.

        The first time, this takes a compile of its own."""
        if self.telling is None:
            raise RequestError("this result tells no powers")
        motion = self.telling()
        values = motion.powers(self.t, self._rows)
        values.flags.writeable = False
        return MappingProxyType({name: values[:, i] for i, name in enumerate(motion.model.powers)})

    @lazy
    def work(self) -> Mapping[str, Array]:
        """Work of all loads of each effect since t = 0, each of shape (m,), J; of "impacts" too where they can happen.

        Raises RequestError unless the run kept the energy balance."""
        if self.kept is None:
            raise RequestError("the run kept no energy balance: run it with energy_balance=True")
        model = self.motion.model
        names = (*model.powers, *((IMPACTS,) if model.has_impacts else ()))
        return MappingProxyType({name: self.kept.work[:, i] for i, name in enumerate(names)})

    @lazy
    def energy_balance(self) -> EnergyBalance:
        """Who stored, dissipated and supplied how much energy, and how well it balances. Raises RequestError unless the
        run kept the energy balance."""
        work = self.work
        assert self.kept is not None
        first = self.motion.energies(np.zeros(1), self.kept.start.reshape(1, -1))[0]
        return energy_balance_of(
            work, self.energies, dict(zip(self.motion.model.energies, first.tolist(), strict=True))
        )

    @property
    def books(self) -> EnergyBalance:
        """The old name of `energy_balance`."""
        superseded("Result.books", "Result.energy_balance")
        return self.energy_balance

    @lazy
    def constraint_error(self) -> Array:
        """Largest gap at any hinge that closes a loop, shape (m,), m; zero for a tree.

        The gap of a hinge is the distance between its two sides' points, or the mechanism's size times the angle
        between their axes, whichever is larger. It is measured on the poses, not on the equations of closure.
        """
        worst = np.zeros(len(self.t))
        for name in self.motion.model.cuts:
            joint = self.mechanism.joint(name)
            points, axes = [], []
            for body in (joint.parent, joint.child):
                com, rotation = self.pose(body)
                points.append(com + rotation @ (joint.point - self.mechanism.body(body).com))
                axes.append(rotation @ joint.axis)
            distance = np.linalg.norm(points[1] - points[0], axis=1)
            angle = np.arctan2(
                np.linalg.norm(np.cross(axes[0], axes[1]), axis=1), (axes[0] * axes[1]).sum(axis=1)
            )
            worst = np.maximum(worst, np.maximum(distance, self.mechanism.size * angle))
        return worst

    def pose(self, body: str) -> tuple[Array, Array]:
        """Centre of mass, shape (m, 3), m, and rotation, shape (m, 3, 3), of a body in world axes.

        The rotation takes body axes to world axes and is the identity as drawn. A fixed body keeps its
        drawn pose, unless an effect moves it. Raises KeyError with the names there are.
        """
        record = self.mechanism.body(body)
        moving = self.motion.model.bodies
        m = len(self.t)
        if body not in moving:
            return np.tile(record.com, (m, 1)), np.tile(np.eye(3), (m, 1, 1))
        rows = self._poses[:, moving.index(body)]
        return rows[:, :3], rows[:, 3:].reshape(m, 3, 3)

    @property
    def points(self) -> tuple[OutputPoint, ...]:
        """The points that the scene's outputs name."""
        return tuple(each for each in self.outputs if isinstance(each, OutputPoint))

    def point(self, name: str) -> Array:
        """Path of a point that the scene's outputs name (`OutputPoint`), shape (m, 3), m, world. Raises KeyError with
        the names there are."""
        for each in self.points:
            if each.name == name:
                com, rotation = self.pose(each.body)
                return com + rotation @ (np.array(each.point) - self.mechanism.body(each.body).com)
        known = ", ".join(each.name for each in self.points) or "none"
        raise KeyError(f"no output point is named {name!r}; there are {known}")

    def quantity(self, name: str) -> Quantity:
        """Anything of the run by name, with its unit: a hinge's angle, a coordinate, a rate such as "base.vz" or
        "h1.rate", a body's centre or an output point by axis ("link.x", "tip.z"), an energy by effect ("gravity", or
        "energy.gravity" as in measures), "energy" or "constraint_error". Raises KeyError with the nearest names there
        are."""
        return quantity_of(self, name)

    def sensitivity(self, output: str, name: str) -> Array:
        """d output / d name at the rows, shape (m,), in SI units; NaN from where there is no derivative on (`notes`
        says since when, and why).

        output  as for `quantity`; derivatives of angles, coordinates and rates are exact, those of positions and
                energies follow from them by differences of order 4 and more, some 1e-10 of their size
        name    one of those that the run was asked to be differentiated by

        Raises RequestError for a run that was not differentiated, KeyError for names that are not there."""
        if self.sensitivities is None:
            raise RequestError("the run was not differentiated: run it with sensitivities=[…]")
        return self.sensitivities.of(self, output, name)

    def gradient(self, measure: object, names: Sequence[str] | None = None) -> "Gradient":
        """Derivatives of one number of the run by parameters: by all of them at the cost of a few runs. The run must
        have been made with taped=True.

        measure  text, such as "max(tip.z)" or "rms(h2 - 10 deg)", as of `lamc.sweep`; it may name dimensions of the
                 design, and parameters that the run was given
        names    parameters of the model, dimensions of the design, "angles.JOINT" and "rates.JOINT" of the start; None:
                 all parameters of the model but times at which servos sample, by which there are none. A dimension
                 takes some milliseconds besides, as its drawing is split anew

        The derivatives are those of what the run computes at the steps that it takes, as `sensitivity` has them;
        extremes, averages and crossings are followed as the measure reads them off the rows. Raises RequestError for
        measures and names without a gradient, SimulationError where the run has none, with the instant and why."""
        found: Gradient = drawer("Result", "gradient")(self, measure, names)
        return found

    @lazy
    def _rows(self) -> Array:
        rows = np.hstack([self.q, self.u])
        rows.flags.writeable = False
        return rows

    @lazy
    def _poses(self) -> Array:
        poses = self.motion.poses(self.t, self._rows)
        poses.flags.writeable = False
        return poses

    @lazy
    def _held(self) -> tuple[str, ...]:
        """Joints whose angle is a coordinate without a rate of its own: they yield and close a loop."""
        joints = {joint.name for joint in self.mechanism.joints}
        return tuple(c.name for c in self.coordinates[len(self.joints) :] if c.name in joints)

    def _of(self, joint: str, values: Array) -> Array:
        """The column of a joint in q or u."""
        if joint not in self.joints:
            names = ", ".join((*self.joints, *self._held)) or "none"
            raise KeyError(f"no joint is named {joint!r}; there are {names}")
        return values[:, self.joints.index(joint)]


def _place(name: str, entries: tuple[Coordinate, ...], what: str) -> int:
    """The column of a name, or KeyError."""
    names = [entry.name for entry in entries]
    if name not in names:
        raise KeyError(f"no {what} is named {name!r}; there are {', '.join(names) or 'none'}")
    return names.index(name)
