"""`lamc ledger`: what accuracy costs on a design, and which effects matter. Out: tables, ledger.json and ledger.png."""

import json
import math
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

from lamc.basics.errors import LamcError
from lamc.basics.files import write_text
from lamc.basics.renewal import renewed
from lamc.basics.times import Times
from lamc.commands.inputs import (
    SceneChanges,
    Source,
    changed_scene,
    load_source,
    mechanism_of,
    output_folder,
)
from lamc.commands.pairs import share_of
from lamc.commands.terminal import INTERRUPTED, Terminal, plain
from lamc.ledger.measure import measure
from lamc.ledger.peers import PEERS
from lamc.ledger.records import DECADES, Ledger, Sweep
from lamc.ledger.schema import ledger_schema
from lamc.report.ledger import draw_ledger
from lamc.report.ledger_text import ledger_text
from lamc.run.defaults import DURATION
from lamc.run.integrators import NAMES
from lamc.run.request import MIN_RTOL, did_you_mean

FILES = ("ledger.json", "ledger.png")
_SECONDS = {"s": 1.0, "ms": 1e-3, "min": 60.0}


@dataclass(frozen=True)
class LedgerOrder:
    """What `lamc ledger` was asked for, in words as typed."""

    source: Source
    changes: SceneChanges
    t_end: float | None  # s; None: the scene's duration, or `DURATION`
    accuracy: str  # 1e-3 or "0.1 %"
    budget: str  # 30 or "30 s" or "2 min"
    tightest: float  # rtol
    integrators: tuple[str, ...]  # empty: all
    account: bool
    full: bool
    out: str | None


def ledger(order: LedgerOrder, terminal: Terminal) -> int:
    """Measures, writes, prints; after Ctrl-C what is measured by then, and the exit code of an interruption."""
    sweep = _sweep(order)
    times = Times()
    with terminal.progress() as progress:
        times.observer = progress.stage
        loaded = load_source(order.source, times, progress)
        with output_folder(order.out, loaded.name) as folder:
            mechanism = mechanism_of(loaded, times, progress)
            scene, _ = changed_scene(mechanism, order.changes)
            if order.t_end is None and scene.duration is not None:
                sweep = replace(sweep, t_end=scene.duration)
            measured = measure(
                mechanism, scene, order.source.options, sweep, progress, with_account=order.account
            )
            data = ledger_data(measured)
            with renewed(folder, FILES[0], lambda _: set(FILES)) as staged:
                write_text(staged / FILES[0], json.dumps(data, indent=1, ensure_ascii=False) + "\n")
                files = _drawn(measured, staged)
    terminal.say(f"{ledger_text(measured, full=order.full)}\n\nfiles   {folder}: {', '.join(files)}")
    is_whole = not measured.interrupted and len(files) == len(FILES)
    terminal.result({"ok": is_whole, **data, "folder": str(folder), "files": files})
    if is_whole:
        return 0
    when = f"in {measured.interrupted!r}" if measured.interrupted else "while the picture was drawn"
    terminal.error(f"interrupted {when}; what was measured until then is in {folder}")
    return INTERRUPTED


def _drawn(measured: Ledger, folder: Path) -> list[str]:
    """The files that are there once the picture is drawn; a second Ctrl-C does without it."""
    try:
        draw_ledger(measured, folder / FILES[1])
    except KeyboardInterrupt:
        return list(FILES[:1])
    return list(FILES)


def schema() -> int:
    """The JSON Schema of ledger.json on stdout."""
    print(json.dumps(ledger_schema(), indent=1))
    return 0


def ledger_data(measured: Ledger) -> dict[str, Any]:
    """The record in JSON's own types."""
    data: dict[str, Any] = plain(asdict(measured))
    return data


def _sweep(order: LedgerOrder) -> Sweep:
    """Raises LamcError for what makes no sweep."""
    if order.t_end is not None and not (math.isfinite(order.t_end) and order.t_end > 0.0):
        raise LamcError(f"--t-end is {order.t_end:g} s; it must be above zero: nothing else can be measured")
    if not MIN_RTOL <= order.tightest <= DECADES[0]:
        raise LamcError(
            f"--tightest is {order.tightest:g}; it must lie between {MIN_RTOL:g} (round-off) and {DECADES[0]:g}"
        )
    known = (*NAMES, *PEERS)
    for name in order.integrators:
        if name not in known:
            raise LamcError(f"--integrator: none is named {name[:40]!r}; {did_you_mean(name, known)}")
    tolerances = tuple(rtol for rtol in DECADES if rtol >= 0.999 * order.tightest)
    return Sweep(
        t_end=order.t_end or DURATION,
        accuracy=_accuracy(order.accuracy),
        tolerances=tolerances,
        integrators=order.integrators or Sweep.integrators,
        budget=_budget(order.budget),
    )


def _accuracy(text: str) -> float:
    """A share of the range: "1e-3" or "0.1 %"."""
    value = share_of(text, "--accuracy")
    if not 0.0 < value <= 1.0:
        raise LamcError(f"--accuracy is {text!r}; it must lie above 0 and be at most 1, or 100 %")
    return value


def _budget(text: str) -> float:
    """Seconds of "30", "30s", "30 s" or "2 min"."""
    amount = text.strip()
    unit = next((u for u in ("min", "ms", "s") if amount.endswith(u)), "")
    number = amount.removesuffix(unit).strip()
    try:
        value = float(number) * _SECONDS[unit or "s"]
    except ValueError as error:
        raise LamcError(f"--budget {text!r} is no number; write a time such as 30s or '2 min'") from error
    if not math.isfinite(value):
        raise LamcError(f"--budget {text!r} is not finite; write a time such as 30s or '2 min'")
    if value <= 0.0:
        raise LamcError(f"--budget is {text!r}; it must be above zero")
    return value
