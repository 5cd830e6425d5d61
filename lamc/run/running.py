"""Runs of a simulator: one after the other, each with where it comes from.

In: a motion, a checked request. Out: a `Result`, with its provenance. Never: looks at arguments of a user.
"""

import logging
import math
import time
from collections.abc import Callable
from dataclasses import replace

from lamc.basics._version import __version__
from lamc.basics.errors import warn
from lamc.basics.once import lazy
from lamc.records.effect import PlaneMark, marks_of
from lamc.run import integrators
from lamc.run.ending import message
from lamc.run.energy_balance import Kept
from lamc.run.extended import Extended
from lamc.run.methods import STIFFEST
from lamc.run.model import Motion
from lamc.run.request import Request, Status, Trajectory
from lamc.run.result import Result
from lamc.run.run_record import Event, Provenance, RunStats
from lamc.run.sensitivities import Differentiated
from lamc.run.taping import Tape
from lamc.run.unresolved import Modes, Steps, is_affordable, longest_step, unresolved_note

logger = logging.getLogger("lamc")


class Running(Extended):
    """The part of a `Simulator` that makes results of motions."""

    def _integrated(
        self,
        integrator: str,
        request: Request,
        motion: Motion,
        telling: Callable[[], Motion],
        differentiated: Differentiated | None = None,
    ) -> tuple[Result, float]:
        """One run, and what it took in evaluations. telling: makes the motion that tells powers; differentiated: what
        the run's derivatives are by."""
        started = time.perf_counter()
        carrier = motion if differentiated is None else differentiated.motion
        carrier = carrier if request.tape is None else request.tape.motion
        if request.tape is None:
            used, trajectory = integrators.integrate(integrator, carrier, request)
        else:
            used, trajectory, request = self._taped(integrator, request, request.tape)
        wall_time = time.perf_counter() - started
        provenance, marks = self._circumstances(motion)
        result = Result(
            t=trajectory.t,
            q=trajectory.q,
            u=trajectory.u,
            status=trajectory.status,
            message=message(trajectory, request, motion, self._gap_at if self.cut_joints else None),
            events=tuple(Event(t, self._model.guards[k]) for t, k in trajectory.events),
            stats=RunStats(
                integrator=used,
                switches=trajectory.switches,
                rtol=request.rtol,
                atol=request.atol,
                steps=trajectory.accepted + (trajectory.rejected or 0),
                accepted=trajectory.accepted,
                rejected=trajectory.rejected,
                evaluations=trajectory.evaluations,
                last_step=trajectory.last_step,
                singular_steps=trajectory.singular_steps,
                wall_time=wall_time,
                real_time_factor=trajectory.t_reached / wall_time if wall_time > 0.0 else float("inf"),
                max_step=None if request.max_step == float("inf") else request.max_step,
            ),
            provenance=provenance,
            mechanism=self.mechanism,
            motion=motion,
            telling=telling,
            kept=None if trajectory.work is None else Kept(request.y0, trajectory.work),
            marks=marks,
            outputs=tuple(self.scene.outputs or ()),
            sensitivities=None
            if differentiated is None or trajectory.along is None
            else differentiated.sensitivities(trajectory.along, trajectory.lost),
            tape=request.tape,
        )
        logger.info("run of %r: %s, in %.3g s", self._model.name, result.message, wall_time)
        return result, trajectory.effort

    def _taped(self, integrator: str, request: Request, tape: Tape) -> tuple[str, Trajectory, Request]:
        """A run that leaves a tape: once more with shorter steps, or by an implicit method, where they are too long for
        derivatives of modes that do not move. What it was in the end, and what was asked for then."""
        used, trajectory = integrators.integrate(integrator, tape.motion, request)
        if trajectory.status != Status.REACHED_END:
            return used, trajectory, request
        span, tolerance = request.t_end - request.t_start, max(request.rtol, request.atol)
        modes = Modes(tape.motion, request.y0, request.t_start, self.mechanism.size, tolerance)
        longest = modes.bear(
            Steps(used.split(", "), longest_step(request.t_start, trajectory.t, tape.at), span, tolerance)
        )
        if longest >= request.max_step:
            return used, trajectory, request
        tries = [(integrator, longest)]
        if integrator == "auto":  # what is damped away at once needs no short steps of an implicit method
            tries.append((STIFFEST, modes.bear(Steps([STIFFEST], math.inf, span, tolerance))))
        for name, step in tries:
            if is_affordable(step, span, request.max_steps):
                again = replace(request, tape=tape.emptied(), max_step=min(step, request.max_step))
                used_then, found = integrators.integrate(name, tape.motion, again)
                if found.status in (Status.REACHED_END, Status.CANCELLED):
                    return used_then, found, again
        warn(unresolved_note(longest, used))
        return used, trajectory, request

    def _circumstances(self, motion: Motion) -> tuple[Provenance, tuple[PlaneMark, ...]]:
        """Where a result comes from, and what its pictures show besides the bodies."""
        if motion is self._default_motion:
            provenance, marks = self._usual_circumstances
            return replace(provenance, parameters=dict(provenance.parameters)), marks
        provenance = self._provenance(motion)
        return provenance, marks_of(self.effects, provenance.parameters)

    @lazy
    def _usual_circumstances(self) -> tuple[Provenance, tuple[PlaneMark, ...]]:
        """The same where all parameters have their defaults."""
        provenance = self._provenance(self._default_motion)
        return provenance, marks_of(self.effects, provenance.parameters)

    def _provenance(self, motion: Motion) -> Provenance:
        names = self._model.parameters
        return Provenance(
            design=self._model.name,
            digest=self._model.digest,
            lamc_version=__version__,
            compiler=self._module.compiler,
            flags=tuple(self._module.flags),
            effects=tuple(effect.name for effect in self.effects),
            parameters=dict(zip(names, motion.parameters[: len(names)].tolist(), strict=True)),
            series=motion.following.digests,
        )
