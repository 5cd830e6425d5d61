"""What `lamc run` tells at its end: bodies, hinges, effects, steps, times, files.

In: a `RunReport`. Out: plain text. It measures nothing and prints nothing.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from lamc.basics.numbers import duration, shortened
from lamc.basics.times import Times
from lamc.effects.registry import Choice
from lamc.mechanism.limits import outside_limits
from lamc.records.parameters import DesignParameter
from lamc.report.loops_text import branch_lines, loops_line
from lamc.report.parameters_text import parameters_line
from lamc.run.outputs import outputs_of
from lamc.run.result import Result
from lamc.run.simulator import Simulator

_NAMES = 6  # names in a list before it is cut
_STAGES = ("load", "split", "load from cache", "plan", "derive", "lower", "emit", "compile", "branch", "run")


@dataclass(frozen=True, eq=False)
class RunReport:
    """A run and all that belongs to it.

    account  every effect, in or out, and why
    drift    largest change of the energy, J; None where something may dissipate or drive
    scene    what the scene was called on the command line; None: the design's own
    beside   files that the design was read from besides `source`: name and SHA-256
    remarks  what else the user should know
    facets   whether those of a sheet bend, where a run chose other ones than options say
    dimensions  parameters of the design; given: values of those that were set, SI
    """

    source: str
    source_digest: str
    simulator: Simulator
    result: Result
    account: tuple[Choice, ...]
    times: Times
    drift: float | None
    scene: str | None = None
    beside: tuple[tuple[str, str], ...] = ()
    remarks: tuple[str, ...] = ()
    facets: str | None = None
    enough: str = ""  # why an end before the end is as good; empty: it is not
    dimensions: Mapping[str, DesignParameter] = field(default_factory=dict)
    given: Mapping[str, float] = field(default_factory=dict)

    @property
    def notes(self) -> tuple[str, ...]:
        """What the user should know and cannot see."""
        notes = [*self.remarks, *([self.enough] if self.enough else [])]
        limited = [joint.name for joint in self.simulator.mechanism.joints if joint.is_limited]
        if limited and not any("limit" in c.name for c in self.account if c.effect is not None):
            notes.append(
                f"the scene does not call for joint_limits, so those of {names(limited)} are not simulated"
            )
        notes += self.simulator.notes
        result = self.result
        notes += result.notes
        if len(result.t):
            angles = {joint: float(result.angle(joint)[0]) for joint in limited}
            notes += outside_limits(self.simulator.mechanism, angles)
        if 2 < len(result.t) < result.stats.accepted / 2:
            notes.append(
                f"{result.stats.accepted} steps lie behind {len(result.t)} rows, so fast motion may not show; "
                "raise --points (0 keeps every step)"
            )
        return tuple(notes)


def energy_drift(result: Result) -> float | None:
    """Largest change of the energy from its start, J."""
    return float(np.abs(result.energy - result.energy[0]).max()) if len(result.t) else None


def summary(report: RunReport, folder: Path, files: Sequence[str], *, verbose: bool = False) -> str:
    """The whole summary, a labelled line for each matter; `verbose`: one for each effect that is not in, too."""
    rows = [("device", _device(report))]
    rows += [("params", parameters_line(report.dimensions))] if report.dimensions else []
    rows += _loops(report)
    rows += _scene(report)
    rows += _effects(report.account, verbose=verbose)
    rows += [("note", note) for note in report.notes]
    rows += [("run", _run(report.result)), ("steps", _steps(report.result)), *_accuracy(report.result)]
    rows += _happenings(report.result)
    rows += [("balance", line) for line in energy_balance_lines(report.result)]
    rows += [("times", _times(report.times))]
    if report.drift is not None:
        rows.append(("energy", _drift(report)))
    rows.append(("files", f"{folder}: {', '.join(files)}"))
    lines = []
    before = ""
    for label, text in rows:
        lines.append(f"{label if label != before else '':<8}{text}")
        before = label
    return "\n".join(lines)


def names(items: Sequence[str]) -> str:
    """A few names, then how many there are."""
    shown = ", ".join(shortened(item, 24) for item in items[:_NAMES])
    return shown + (f", … ({len(items)} in all)" if len(items) > _NAMES else "")


def _device(report: RunReport) -> str:
    mechanism = report.simulator.mechanism
    fixed = sum(body.fixed for body in mechanism.bodies)
    joints, freedoms = len(mechanism.joints), report.simulator.freedoms
    return (
        f"{shortened(mechanism.name, 40)}: {_count(len(mechanism.bodies), 'body', 'bodies')} ({fixed} fixed), "
        f"{_count(joints, 'hinge', 'hinges')}, {_count(freedoms, 'degree', 'degrees')} of freedom"
    )


def _loops(report: RunReport) -> list[tuple[str, str]]:
    """What the loops come to, and the branches of a singular start."""
    line = loops_line(report.simulator.loops)
    return [("loops", text) for text in ([line] if line else []) + branch_lines(report.simulator.branches)]


def _scene(report: RunReport) -> list[tuple[str, str]]:
    """Which scene it is, where the design has several; and what its outputs came to, where it names them."""
    simulator, result = report.simulator, report.result
    others = [name for name in simulator.mechanism.scenes if name != report.scene]
    more = f"; also there: {names(others)} (--scene NAME)" if others else ""
    if report.scene is None:
        rows = [("scene", f"the design's own{more}")] if others else []
    else:
        rows = [("scene", f"{report.scene}{more}")]
    if simulator.scene.outputs is not None and len(result.t):
        ends = (f"{o.name} {o.values[-1]:.6g} {o.unit}" for o in outputs_of(result, simulator.scene))
        rows.append(("outputs", f"at {duration(float(result.t[-1]))}: {', '.join(ends)}"))
    return rows


def _count(number: int, one: str, many: str) -> str:
    return f"{number} {one if number == 1 else many}"


def _effects(account: Sequence[Choice], *, verbose: bool) -> list[tuple[str, str]]:
    """A line for each effect that acts, or that somebody left out; the others in one line unless `verbose`."""
    told = [c for c in account if verbose or c.effect is not None or c.left_out]
    width = max((len(choice.name) for choice in told), default=0)
    lines = [
        f"{'in ' if c.effect is not None else 'out'}  {c.name:<{width}}  {c.reason}"
        for c in sorted(told, key=lambda c: c.effect is None)
    ]
    if len(told) < len(account):
        lines.append(f"out  {len(account) - len(told)} more, which nothing calls for (--verbose names them)")
    return [("effects", line) for line in lines]


def _run(result: Result) -> str:
    stats = result.stats
    pace = stats.real_time_factor
    speed = f"{pace:.3g} × real time" if math.isfinite(pace) else "no time at all"
    return f"{result.message}, in {duration(stats.wall_time)}: {speed}"


def _steps(result: Result) -> str:
    stats = result.stats
    rejected = "rejected unknown" if stats.rejected is None else f"{stats.rejected} rejected"
    return (
        f"{stats.accepted} accepted, {rejected}, {stats.evaluations} evaluations "
        f"({stats.integrator}, rtol {stats.rtol:g}, atol {stats.atol:g}); {len(result.t)} rows"
    )


def _accuracy(result: Result) -> list[tuple[str, str]]:
    """What a run to an accuracy came to: the error, how it is known, and what was chosen from what at which cost."""
    facts = result.accuracy
    if facts is None:
        return []
    known = "unknown" if math.isinf(facts.error) else f"{facts.error:.1e}"
    met = "" if facts.reached else ": NOT REACHED"
    how = (
        "runs at other tolerances bear it out"
        if facts.proportionality is not None
        else "runs differ by it at any tolerance"
    )
    rows = [f"{known} of the outputs' range, {facts.asked:g} asked for{met}; {how}"]
    rows.append(
        f"{facts.integrator} at rtol {facts.rtol:.1e}; {len(facts.runs)} runs and probes took "
        f"{facts.evaluations:.0f} evaluations"
    )
    if facts.candidates:
        tried = (
            f"{name} {effort:.0f}" if math.isfinite(effort) else f"{name} more"
            for name, effort in facts.candidates.items()
        )
        rows.append(f"evaluations where it was probed: {', '.join(tried)}")
    return [("error", row) for row in rows]


def _happenings(result: Result) -> list[tuple[str, str]]:
    """When the integrator changed, and the limits that were met."""
    rows = [("auto", ", ".join(f"{name} from {duration(t)}" for t, name in result.stats.switches[:_NAMES]))]
    first = ", ".join(f"{e.name} at {duration(e.t)}" for e in result.events[:_NAMES])
    more = f", … ({len(result.events)} in all)" if len(result.events) > _NAMES else ""
    rows.append(("events", first + more))
    return [(head, text) for head, text in rows if text]


def _times(times: Times) -> str:
    """The stages in order; what came from the cache was not compiled."""
    reported = {"load from cache": "fetch from cache"} | (
        {"compile": "find in cache"} if times.from_cache else {}
    )
    kept = [name for name in _STAGES if name in times.seconds]
    if "compile" in kept:
        kept.remove("load from cache")  # it looked, and found nothing
    return ", ".join(f"{reported.get(name, name)} {duration(times.seconds[name])}" for name in kept)


def energy_balance_lines(result: Result) -> list[str]:
    """Who stored, supplied and dissipated how much over the run; nothing where no energy balance was kept."""
    if result.kept is None or not len(result.t):
        return []
    energy_balance = result.energy_balance
    noise = max(10.0 * energy_balance.balance, 1e-12) * energy_balance.scale  # what is not worth a digit
    rows = [
        ("", "stored", "supplied", "dissipated"),
        ("kinetic", _joules(float(energy_balance.kinetic[-1]), noise) or "0 J", "", ""),
    ]
    for entry in energy_balance.entries:
        gave = _joules(entry.supplied, noise) if entry.supplied > 0.0 else ""
        took = _joules(-entry.supplied, noise) if entry.supplied < 0.0 else ""
        stored = _joules(entry.stored, noise) or ("" if gave or took else "0 J")
        rows.append((entry.effect, stored, gave, took))
    width = max(len(row[0]) for row in rows)
    lines = [f"{row[0]:<{width}}" + "".join(f"{cell:>14}" for cell in row[1:]).rstrip() for row in rows]
    return [
        *lines,
        f"they balance within {energy_balance.balance:.1e} of the {energy_balance.scale:.4g} J in play",
    ]


def _joules(energy: float, noise: float) -> str:
    return f"{energy:.5g} J" if abs(energy) > noise else ""


def _drift(report: RunReport) -> str:
    assert report.drift is not None
    largest = float(report.result.energies["kinetic"].max(initial=0.0))
    part = f", {report.drift / largest:.1e} of the largest kinetic energy" if largest > 0.0 else ""
    return f"nothing dissipates or drives: it changes by at most {report.drift:.2e} J{part}"
