"""What moves, as a show of a page: a run, or a mechanism to be folded by hand.

In: a `Result` or a `Mechanism`, and a model in WebAssembly where there is one. Out: a `Show`. Never: compiles; runs.
"""

from collections.abc import Mapping
from typing import Any

import numpy as np

from lamc.basics.errors import LamcError
from lamc.loops.branches import Branch
from lamc.records.effect import marks_of
from lamc.records.mechanism import Array, Mechanism
from lamc.records.scene import Scene
from lamc.report.stage import Stage, as_drawn, stage_of
from lamc.run.result import Result
from lamc.run.simulator import Simulator
from lamc.view.document import MOST_BYTES, Show
from lamc.view.live import Live, live_data
from lamc.view.pack import packed
from lamc.view.recording import COARSEST, FINEST, curve_specs, motion_of, moving_bodies, recording_data
from lamc.view.shape import shape_data

_TEXT = 85_000  # bytes of a page without data, about
_LEAST = 60_000  # bytes that a recording may have in any case
_VIEWS = 24  # instants that the choice of view looks at
_PACE = 1.1  # of the device's size in a second, as it is seen: what the eye follows with ease
_LONGEST = 60.0  # s that a showing takes, about
_EVENTS = 10_000  # that are marked


def run_show(
    result: Result,
    scene: Scene | None = None,
    live: Live | None = None,
    *,
    label: str = "",
    scene_data: Mapping[str, Any] | None = None,
    notes: tuple[str, ...] = (),
    budget: int = MOST_BYTES,
) -> Show:
    """A run, with its model where `live` is one. scene_data: the scene as a file has it, to be copied with changes.

    Raises LamcError for a result without rows.
    """
    if len(result.t) == 0:
        raise LamcError(f"the result of {result.provenance.design!r} has no rows; there is nothing to see")
    mechanism = result.mechanism
    shape = shape_data(mechanism, result.marks)
    size = float(shape["size"])
    specs = curve_specs(result, mechanism, result.outputs, result.energies)
    motion = motion_of(result, specs, size)
    stats = result.stats
    settings = {"rtol": stats.rtol, "atol": stats.atol}
    if stats.max_step is not None:
        settings["maxStep"] = stats.max_step
    model = None if live is None else live_data(live, mechanism, result.provenance.parameters, settings)
    taken = _TEXT + len(packed([shape, model])) + (0 if live is None else len(live.engine))
    recording = _within(motion, size, max(budget - taken, _LEAST))
    duration = float(result.t[-1])
    names = [joint.name for joint in mechanism.joints]
    data = {
        "kind": "device",
        "label": label,
        "description": f"{mechanism.name} in motion; the lists below tell its state",
        **shape,
        "moving": moving_bodies(mechanism, result.motion.model.bodies),
        "order": [names.index(name) for name in result.joints],
        "start": [float(result.angle(name)[0]) if name in result.joints else 0.0 for name in names],
        "rates": [None if scene is None else scene.rates.get(name) for name in names],
        "curves": specs,
        "recording": recording,
        "events": _events(result),
        "duration": duration,
        "speed": _speed(motion.t, motion.centres, size),
        "view": _view(result),
        "walks": any(c.name.startswith("base.") for c in result.coordinates) or bool(result.marks),
        "live": model,
        "scene": scene_data,
        "sceneNote": "" if duration == (scene and scene.duration) else f" --t-end {duration:g}",
    }
    facts = (
        f"{len(mechanism.bodies)} bodies, {len(names)} hinges; {duration:g} s by {result.stats.integrator}"
    )
    failed = "" if result.success else result.message
    said = (*([failed] if failed else []), _error_note(recording["error"], size), *_events_note(result))
    engine = "" if live is None else live.engine
    return Show(mechanism.name, facts, data, engine, (*said, *result.notes, *notes), failed)


def model_show(
    simulator: Simulator, live: Live, *, scene_data: Mapping[str, Any] | None = None, end: float
) -> Show:
    """A model without a recording: it runs on in the page from the moment that it opens. end: s, of a run of it."""
    mechanism, scene = simulator.mechanism, simulator.scene
    names = [joint.name for joint in mechanism.joints]
    start = dict(zip(simulator.joints, simulator.start.tolist(), strict=False))
    marks = marks_of(simulator.effects, simulator.parameters)
    data = {
        "kind": "device",
        "label": "",
        "description": f"{mechanism.name} in motion; the lists below tell its state",
        **shape_data(mechanism, marks),
        "moving": moving_bodies(mechanism, simulator.model.bodies),
        "order": [names.index(name) for name in simulator.joints],
        "start": [float(start.get(name, 0.0)) for name in names],
        "rates": [scene.rates.get(name) for name in names],
        "curves": curve_specs(simulator, mechanism, scene.outputs or (), simulator.model.energies),
        "recording": None,
        "events": None,
        "duration": end,
        "speed": 1.0,
        "view": _angles(Stage(mechanism, as_drawn(mechanism), 400).camera.towards),
        "walks": any(c.name.startswith("base.") for c in simulator.coordinates) or bool(marks),
        "live": live_data(live, mechanism, {}, {}),
        "scene": scene_data,
        "sceneNote": "" if end == scene.duration else f" --t-end {end:g}",
    }
    facts = f"{len(mechanism.bodies)} bodies, {len(names)} hinges"
    return Show(mechanism.name, facts, data, live.engine)


def fold_show(
    mechanism: Mechanism, start: Mapping[str, float], branches: tuple[Branch, ...] = (), *, label: str = ""
) -> Show:
    """A mechanism that is folded by its hinges' sliders, loops closed. start: rad, closed; branches: ways out of it
    where it is singular."""
    names = [joint.name for joint in mechanism.joints]
    camera = Stage(mechanism, as_drawn(mechanism), 400).camera.towards
    data = {
        "kind": "device",
        "label": label,
        "description": f"{mechanism.name}, to be folded by the sliders beside it",
        **shape_data(mechanism),
        "moving": [],
        "order": list(range(len(names))),
        "start": [float(start.get(name, 0.0)) for name in names],
        "ways": [[float(branch.rates[name]) for name in names] for branch in branches],
        "curves": [],
        "recording": None,
        "events": None,
        "duration": 0.0,
        "speed": 1.0,
        "view": _angles(camera),
        "walks": False,
        "live": None,
        "scene": None,
    }
    facts = f"{len(mechanism.bodies)} bodies, {len(names)} hinges"
    note = "Folded by geometry alone: bodies pass through one another, and no force is weighed."
    return Show(mechanism.name, facts, data, "", (note,))


def _within(motion: Any, size: float, budget: int) -> dict[str, Any]:
    """The finest recording that takes no more than `budget` bytes, or the coarsest."""
    tolerance = FINEST
    while True:
        data = recording_data(motion, tolerance, size)
        if len(packed(data)) <= budget or tolerance >= COARSEST:
            return data
        tolerance *= 2.0


def _error_note(error: Mapping[str, float], size: float) -> str:
    return (
        f"Recorded to within {1e3 * error['length']:.2g} mm ({100 * error['length'] / size:.2g} % of the size) and, in "
        f"curves, {100 * error['share']:.2g} % of their range; numbers in full are in the files of lamc run."
    )


def _events(result: Result) -> dict[str, Any]:
    """Times, and names by number."""
    names = list(dict.fromkeys(event.name for event in result.events))
    kept = result.events[:_EVENTS]
    return {
        "t": np.array([event.t for event in kept], dtype="f4"),
        "kind": np.array([names.index(event.name) for event in kept], dtype="u2"),
        "names": names,
    }


def _events_note(result: Result) -> tuple[str, ...]:
    if len(result.events) <= _EVENTS:
        return ()
    return (f"The first {_EVENTS} of {len(result.events)} events are marked.",)


def _speed(t: Array, centres: Array, size: float) -> float:
    """How many seconds of the run are shown in one, so that the motion can be seen."""
    if len(t) < 2 or t[-1] <= t[0] or centres.shape[1] == 0:
        return 1.0
    steps = np.diff(t)
    moved = np.linalg.norm(np.diff(centres, axis=0), axis=2).max(axis=1)
    fast = (
        float(np.sqrt((moved**2 / np.maximum(steps, 1e-12)).sum() / (t[-1] - t[0]))) / size
    )  # 1/s, root mean square
    duration = float(t[-1] - t[0])
    wished = _PACE / fast if fast > 0.0 else 1.0
    if wished > 0.4 and 1.5 <= duration <= _LONGEST:
        return 1.0
    return float(np.clip(wished, duration / _LONGEST, duration / 2.0))


def _view(result: Result) -> dict[str, float]:
    """The view of lamc's other pictures."""
    times = np.linspace(result.t[0], result.t[-1], _VIEWS if len(result.t) > 1 else 1)
    return _angles(stage_of(result, times, 400).camera.towards)


def _angles(towards: Array) -> dict[str, float]:
    azimuth = float(np.degrees(np.arctan2(towards[0], -towards[1])))
    return {"azimuth": azimuth, "elevation": float(np.degrees(np.arcsin(np.clip(towards[2], -1.0, 1.0))))}
