"""A ledger as tables of text.

In: a `Ledger`. Out: plain text. It measures nothing.
"""

from collections.abc import Sequence

from lamc.basics.numbers import duration, shortened, shown_number
from lamc.ledger.records import Account, ArithmeticRow, EffectRow, Ledger, Point, Reference
from lamc.ledger.verdict import cheapest_of, percent, power, setting_text

_REACHED = (1e-2, 1e-3, 1e-4, 1e-6, 1e-8, 1e-10)  # errors whose price is tabled
NAMES = {"cvode:Adams": "CVODE, Adams", "cvode:BDF": "CVODE, BDF", "mujoco": "MuJoCo, RK4"}


def shown_name(integrator: str) -> str:
    """An integrator's name for people: "scipy DOP853", "CVODE, BDF"."""
    return NAMES.get(integrator, integrator.replace("scipy:", "scipy "))


def ledger_text(ledger: Ledger, *, full: bool = False) -> str:
    """All tables, the verdict first. full: a line for every setting too."""
    parts = [_head(ledger), _verdict(ledger), _prices(ledger)]
    if full:
        parts.append(_all_points(ledger))
    parts.append(_failures(ledger))
    if ledger.account is not None:
        parts.append(_account(ledger.account))
    if ledger.arithmetic:
        parts.append(_arithmetic(ledger.arithmetic))
    return "\n\n".join(part for part in parts if part)


def _tolerances(facts: Reference) -> str:
    """Of both runs of the reference."""
    first, second = power(facts.rtol), power(facts.second_rtol)
    return first if first == second else f"{first} and {second}"


def _truth(facts: Reference) -> str:
    """What errors are measured against, and to how many digits it is known."""
    if facts.is_one_method:
        text = f"{facts.integrator} alone, at rtol {_tolerances(facts)}, agrees with itself within"
    else:
        text = f"{facts.integrator} and {facts.second} at rtol {_tolerances(facts)} agree within"
    text += f" {facts.uncertainty:.1e}, the floor of all errors here"
    if facts.events:
        text += f"; {facts.events} events"
        text += ", the same in both" if facts.events_differ_after is None else ""
    if facts.growth is None:
        return text
    if facts.growth > 1.05:
        return f"{text}; a small change of the start grows {facts.growth:.3g}-fold"
    return f"{text}; a small change of the start does not grow"


def _head(ledger: Ledger) -> str:
    lines = [
        f"{shortened(ledger.design, 40)}: {ledger.sweep.t_end:g} s, effects: {', '.join(ledger.effects) or 'none'}",
        f"errors  {_relative_to(ledger)}, at {ledger.sweep.rows} times",
        f"truth   {_truth(ledger.reference)}",
    ]
    if ledger.interrupted:
        lines.append(
            f"note    INCOMPLETE: interrupted in {ledger.interrupted!r}; what comes after is missing"
        )
    return "\n".join([*lines, *(f"note    {note}" for note in ledger.notes)])


def _relative_to(ledger: Ledger) -> str:
    """What errors are relative to."""
    scales = {(output.scale, output.unit) for output in ledger.outputs}
    if len(scales) == 1:
        ((scale, unit),) = scales
        return (
            f"of {', '.join(o.name for o in ledger.outputs[:6])} relative to {shown_number(scale, unit, 3)}"
        )
    reported = ", ".join(f"{o.name} {shown_number(o.scale, o.unit, 3)}" for o in ledger.outputs[:6])
    return f"relative to the range of each output ({reported})"


def _verdict(ledger: Ledger) -> str:
    return "\n".join(f"{'verdict' if k == 0 else '':<8}{line}" for k, line in enumerate(ledger.verdict.lines))


def _prices(ledger: Ledger) -> str:
    """A line per integrator: the time of the cheapest setting that reaches each error."""
    orders = {each.integrator: each for each in ledger.orders}
    head = ["time to reach", *(percent(t) for t in _REACHED), "least error", "order", "closure", "drift"]
    rows = []
    floor = ledger.reference.uncertainty
    for name in dict.fromkeys(p.integrator for p in ledger.points):
        own = [p for p in ledger.points if p.integrator == name]
        good = [p for p in own if p.path is not None]
        cells = [shown_name(name)]
        for target in _REACHED:
            best = cheapest_of(own, target, floor)
            none = "floor" if target <= floor else "–"
            cells.append(duration(best.seconds) if best is not None and best.seconds is not None else none)
        tightest = min(good, key=lambda p: p.setting, default=None)
        order = orders.get(name)
        cells += [
            _least(good, floor),
            f"{order.path:.1f}" if order is not None and order.path is not None else "–",
            _scientific(tightest.closure if tightest else None),
            _scientific(tightest.drift if tightest else None),
        ]
        rows.append(cells)
    shown = [k for k in range(len(head)) if k < 9 or any(row[k] != "–" for row in rows)]
    body = aligned([[row[k] for k in shown] for row in [head, *rows]])
    scales = {"closure": "closure over the size", "drift": "drift over the largest kinetic energy"}
    scaled = ", ".join(scales[head[k]] for k in shown if head[k] in scales)
    reported = f" Of the tightest runs: {scaled}." if scaled else ""
    return (
        f"{body}\n"
        "Processor time of one warm run that keeps its end; all peers but MuJoCo call lamc's equations from Python.\n"
        f"Order: of the error over steps.{reported}"
    )


def _least(points: Sequence[Point], floor: float) -> str:
    """The least error of some points; one below the floor of the reference is only known to be below it."""
    least = min((p.path for p in points if p.path is not None), default=None)
    return f"<{floor:.0e}" if least is not None and least <= floor else _scientific(least)


def _all_points(ledger: Ledger) -> str:
    head = ["setting", "end", "path", "rates", "time", "steps", "rejected", "evaluations", "closure", "drift"]
    rows = [
        [
            setting_text(p),
            *(_scientific(v) for v in (p.end, p.path, p.rates)),
            duration(p.seconds) if p.seconds is not None else "–",
            *("–" if v is None else str(v) for v in (p.steps, p.rejected, p.evaluations)),
            _scientific(p.closure),
            _scientific(p.drift),
        ]
        for p in ledger.points
        if p.succeeded
    ]
    return aligned([head, *rows])


def _failures(ledger: Ledger) -> str:
    """A line for each setting that gave no point, those with one reason together."""
    grouped: dict[tuple[str, str], list[Point]] = {}
    for p in ledger.points:
        if not p.succeeded:
            grouped.setdefault((p.integrator, p.note), []).append(p)
    lines: list[str] = []
    for (name, note), points in grouped.items():
        few = points if len(points) < 4 else [points[0], points[-1]]
        settings = (", " if few is points else " … ").join(_amount(p) for p in few)
        lines.append(f"{'without' if not lines else '':<8}{shown_name(name)}, {settings}: {note}")
    return "\n".join(lines)


def _amount(p: Point) -> str:
    return duration(p.setting) if p.is_step else power(p.setting)


def _account(account: Account) -> str:
    """A line per effect: what leaving it out changes, and what having it costs."""
    head = ["effect", "changes", "± integrator", "operations", "evaluation", "steps", "time", "compile"]
    rows = [_effect_cells("the scene", account.scene, account.scene)]
    failed = []
    together = account.together
    last = (together,) if together is not None and len(together.effects) > 1 else ()
    for row in (*account.rows, *last):
        name = f"{'with' if row.is_added or row.form else 'without'} {', '.join(row.effects)}"
        name += f": {row.form}" if row.form else ""
        if row.succeeded:
            rows.append(_effect_cells(name, row, account.scene))
        else:
            failed.append(f"{name}: {row.note}")
    lines = [aligned([head, *rows])]
    lines.append(f"Costs at {account.integrator}, rtol {power(account.rtol)}; changes at a tight tolerance.")
    return "\n".join([*lines, *failed])


def _effect_cells(name: str, row: EffectRow, scene: EffectRow) -> list[str]:
    is_scene = row is scene

    def against(value: float | None, base: float | None, text: str) -> str:
        if value is None:
            return "–"
        if is_scene or not base:
            return text
        return f"{text} ({100 * (value / base - 1):+.0f} %)"

    return [
        shortened(name, 40),
        "–" if is_scene or row.change is None else _change(row.change),
        _scientific(row.discretisation),
        against(row.operations, scene.operations, str(row.operations)),
        against(row.evaluation, scene.evaluation, f"{row.evaluation:.3g} ns" if row.evaluation else "–"),
        against(row.steps, scene.steps, str(row.steps)),
        against(row.seconds, scene.seconds, duration(row.seconds) if row.seconds else "–"),
        "–" if row.compiling is None else duration(row.compiling),
    ]


def _change(value: float) -> str:
    return f"{100 * value:.3g} %" if value >= 1e-4 else f"{value:.1e}"


def _arithmetic(rows: Sequence[ArithmeticRow]) -> str:
    head = ["arithmetic", "evaluation", "time", "least error"]
    cells = [
        [
            row.name,
            f"{row.evaluation:.3g} ns" if row.evaluation else "–",
            duration(row.seconds) if row.seconds else "–",
            _scientific(row.floor) if row.succeeded else row.note,
        ]
        for row in rows
    ]
    return aligned([head, *cells])


def _scientific(value: float | None) -> str:
    return "–" if value is None else f"{value:.1e}"


def aligned(rows: Sequence[Sequence[str]]) -> str:
    """Columns under a head, the first to the left, the others to the right."""
    widths = [max(len(row[k]) for row in rows) for k in range(len(rows[0]))]
    ruled = [rows[0], ["-" * w for w in widths], *rows[1:]]
    return "\n".join(
        "  ".join(
            c.ljust(w) if k == 0 else c.rjust(w) for k, (c, w) in enumerate(zip(row, widths, strict=True))
        ).rstrip()
        for row in ruled
    )
