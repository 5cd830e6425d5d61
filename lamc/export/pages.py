"""What becomes a page: `view()` of results, simulators, mechanisms, designs and plates, and `lamc view`.

In: the record. Out: `Show`s, a file of HTML, a frame for notebooks. It lies beside the exports since a page may hold a
model as an export to WebAssembly does; what is drawn is the business of `lamc.view`.
"""

import tempfile
import webbrowser
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from lamc.basics.errors import LamcError
from lamc.basics.files import checked_path
from lamc.codegen.names import identifier
from lamc.design.split import split
from lamc.export.live import live_or_why, scene_or_none
from lamc.loops.at_start import loops_of
from lamc.loops.branches import Branch
from lamc.loops.geometry import LoopGeometry
from lamc.loops.starts import Starter
from lamc.mechanism.plan import plan
from lamc.plates.answers.model import FactoredPlate
from lamc.plates.answers.solution import Solution
from lamc.plates.problem import Problem
from lamc.records.design import Design
from lamc.records.mechanism import Mechanism
from lamc.records.scene import Scene
from lamc.run.length import length_of
from lamc.run.remaking import Telling
from lamc.run.result import Result
from lamc.run.simulator import Simulator
from lamc.view.device import fold_show, run_show
from lamc.view.document import MOST_BYTES, Show, framed, page, write_page
from lamc.view.plates import problem_show, solution_show, solutions_show

_STABILISED = (
    "Without the model: this run was stabilised (baumgarte), and models in pages project steps on closure."
)
_MOST_JOINTS = 40  # of a mechanism whose ways out of a singular drawing are looked for, which takes a moment


def show_of(record: Any, *, live: bool, label: str = "", budget: int = MOST_BYTES) -> Show:
    """The record as a show of a page."""
    if isinstance(record, Result):
        return result_show(record, live=live, label=label, budget=budget)
    if isinstance(record, Simulator):
        return result_show(_run(record), live=live, label=label, budget=budget)
    if isinstance(record, Design):
        return mechanism_show(split(record), label)
    if isinstance(record, Mechanism):
        return mechanism_show(record, label)
    if isinstance(record, Problem):
        return problem_show(record, label=label)
    if isinstance(record, Solution):
        return solution_show(record, label=label)
    raise LamcError(f"a {type(record).__name__} is nothing that a page can show")


def _run(simulator: Simulator) -> Result:
    """A run as `lamc run` makes it."""
    length = length_of(None, None, simulator)
    return length.run(simulator, length.rows(len(simulator.start))).result


def result_show(result: Result, *, live: bool, label: str = "", budget: int = MOST_BYTES) -> Show:
    """A run; with its model where one is asked for and can be had."""
    if not live or not isinstance(result.telling, Telling):
        return run_show(result, label=label, budget=budget)
    if result.telling.baumgarte:
        return run_show(result, label=label, notes=(_STABILISED,), budget=budget)
    simulator = result.telling.simulator
    model, why = live_or_why(simulator)
    scene, notes = simulator.scene, (why,) if why else ()
    data = scene_or_none(scene)
    return run_show(result, scene, model, label=label, scene_data=data, notes=notes, budget=budget)


def mechanism_show(mechanism: Mechanism, label: str = "") -> Show:
    """A mechanism as drawn, to be folded by its hinges."""
    return fold_show(mechanism, {}, _ways(mechanism), label=label)


def _ways(mechanism: Mechanism) -> tuple[Branch, ...]:
    """Ways out of a drawing that is singular, such as a flat one."""
    tree = plan(mechanism)
    if not tree.cuts or len(mechanism.joints) > _MOST_JOINTS:
        return ()
    try:
        return Starter(LoopGeometry(tree), loops_of(tree, Scene())).branches(Scene())
    except LamcError:
        return ()  # loops that do not close as drawn: sliders move what they can


def view(record: Any, path: str | Path | None, open_browser: bool | None, live: bool) -> Path:
    """`Viewable.view`."""
    show = _solved(record) if isinstance(record, Problem) else show_of(record, live=live)
    text = page([show])
    written = write_page(text, temporary(record) if path is None else checked_path(path))
    if open_browser or (open_browser is None and path is None):
        open_page(written)
    return written


def _solved(problem: Problem) -> Show:
    """All cases of a problem."""
    model = FactoredPlate(problem)
    return solutions_show(model.solve_cases() if problem.cases else {"": model.solve()})


def temporary(record: Any) -> Path:
    """A place for a page that nobody gave one, in a new folder each time."""
    name = getattr(getattr(record, "mechanism", record), "name", None) or "plate"
    return Path(tempfile.mkdtemp(prefix="lamc-view-")) / f"{identifier(str(name))}.html"


def open_page(path: Path) -> bool:
    """Asks the system's browser; False where there is none."""
    return webbrowser.open(path.resolve().as_uri())


def frame(record: Any) -> str:
    """`Viewable._repr_html_`: no model, and a plate that nobody solved is not solved for it."""
    show = _at_start(record) if isinstance(record, Simulator) else show_of(record, live=False)
    return framed(page([show]))


def _at_start(simulator: Simulator) -> Show:
    """A simulator as it begins: a notebook that shows its value shall not wait for a run."""
    start = dict(zip(simulator.joints, simulator.start.tolist(), strict=False))
    return fold_show(simulator.mechanism, start)


def compared(shows: Sequence[Show], title: str) -> str:
    """Several side by side."""
    return page(shows, title)
