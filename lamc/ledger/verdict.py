"""The verdict of a ledger: the cheapest settings, and the effects that do not matter, a line each.

In: points and the account. Out: a `Verdict`. It measures nothing.
"""

import re
from collections.abc import Sequence

from lamc.basics.numbers import duration
from lamc.ledger.records import TARGETS, Account, Cheapest, EffectRow, Point, Reference, Sweep, Verdict


def cheapest_of(points: Sequence[Point], target: float, uncertainty: float) -> Point | None:
    """The quickest point whose path error, with what the reference leaves open, is at most `target`."""
    good = [
        p for p in points if p.seconds is not None and p.path is not None and p.path + uncertainty <= target
    ]
    return min(good, key=lambda p: p.seconds or 0.0, default=None)


def cheapest(points: Sequence[Point], target: float, uncertainty: float) -> Point | None:
    """The same among lamc's own integrators."""
    return cheapest_of([p for p in points if not p.is_peer], target, uncertainty)


def make_verdict(
    points: Sequence[Point], account: Account | None, reference: Reference, sweep: Sweep
) -> Verdict:
    """What a user does with it."""
    found = tuple(Cheapest(t, cheapest(points, t, reference.uncertainty)) for t in TARGETS)
    lines = [_cheapest_line(each, points, reference) for each in found]
    idle: tuple[str, ...] = ()
    saved = None
    if account is not None:
        together = account.together
        if together is not None:
            idle, saved = together.effects, _saved(account.scene, together)
        lines.append(_effects_line(account, idle, saved, sweep))
        lines += [line for row in account.rows if (line := _form_line(row, account, sweep))]
    return Verdict(found, idle, saved, tuple(lines))


def power(value: float) -> str:
    """A number to one digit, as tolerances are written: 1e-6."""
    return re.sub(r"e([+-])0", r"e\1", f"{value:.0e}")


def percent(value: float) -> str:
    """A relative error in words: 1 %, 0.1 %, 1e-6."""
    return f"{100 * value:.2g} %" if value >= 1e-4 else power(value)


def setting_text(point: Point) -> str:
    """Integrator and setting of a point, in the words of `Simulator.run`."""
    used = f" ({point.used})" if point.used and point.used != point.integrator else ""
    amount = f"{duration(point.setting)} steps" if point.is_step else f"rtol {power(point.setting)}"
    return f"{point.integrator}{used}, {amount}"


def _cheapest_line(each: Cheapest, points: Sequence[Point], reference: Reference) -> str:
    head = f"{percent(each.target)} of the range:"
    point = each.point
    if point is None:
        return f"{head} no setting that was measured is known to reach it"
    assert point.seconds is not None
    assert point.path is not None
    line = f"{head} {setting_text(point)}: {duration(point.seconds)}, {point.steps} steps, error {point.path:.1e}"
    rival = cheapest_of([p for p in points if p.is_peer], each.target, reference.uncertainty)
    if rival is not None and rival.seconds is not None:
        line += f"; the quickest peer, {setting_text(rival)}, takes {rival.seconds / point.seconds:.3g} times as long"
    return line


def _effects_line(account: Account, idle: Sequence[str], saved: float | None, sweep: Sweep) -> str:
    limit = percent(sweep.accuracy)
    unknown = [", ".join(row.effects) for row in account.rows if _is_open(row)]
    reported = f"; not known of {', '.join(unknown)}" if unknown else ""
    if not idle and unknown:
        known = sum(not row.is_added and not row.form for row in account.rows) - len(unknown)
        if not known:
            return f"no effect was left out to see what changes{reported}"
        return f"no effect of the {known} measured changes the outputs by less than {limit}{reported}"
    if not idle:
        return f"every effect changes the outputs by {limit} or more: none can be left out"
    names = ", ".join(idle)
    together = account.together
    change = (
        f" ({together.change:.1e} together)" if together is not None and together.change is not None else ""
    )
    saves = (
        f"saves {100 * saved:.0f} % of the time" if saved is not None and saved >= 0.01 else "saves no time"
    )
    return f"{names}: changes the outputs by less than {limit}{change}; leaving it out {saves}{reported}"


def _is_open(row: EffectRow) -> bool:
    """Whether leaving an effect of the scene out was to be measured, and could not be."""
    return not row.is_added and not row.form and row.change is None


def _form_line(row: EffectRow, account: Account, sweep: Sweep) -> str:
    """A word on another form of an effect that is as good and cheaper; nothing where it is not."""
    saved = _saved(account.scene, row)
    if not row.form or row.change is None or row.change >= sweep.accuracy or saved is None or saved < 0.01:
        return ""
    limit = percent(sweep.accuracy)
    return (
        f"{row.effects[0]}: {row.form} changes the outputs by less than {limit} ({row.change:.1e}) and saves "
        f"{100 * saved:.0f} % of the time"
    )


def _saved(scene: EffectRow, without: EffectRow) -> float | None:
    if not scene.seconds or without.seconds is None:
        return None
    return 1.0 - without.seconds / scene.seconds
