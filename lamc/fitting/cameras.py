"""Where cameras of unknown place begin: nearest to the run from where all other numbers begin.

In: a predictor. Out: starts of the unknowns of its cameras, and the predictor with them. They are guesses, and what is
said of a start stays.
"""

from dataclasses import replace

import numpy as np

from lamc.fitting.predictions import Predictor
from lamc.fitting.sight import sees
from lamc.fitting.unknowns import Unknowns, begun_at
from lamc.run.request import Array


def placed(predictor: Predictor) -> Predictor:
    """The predictor with cameras where the first run says."""
    starts = camera_starts(predictor)
    if not starts:
        return predictor
    setting = predictor.setting
    unknowns = Unknowns(begun_at(setting.unknowns.all, starts))
    return Predictor(replace(setting, unknowns=unknowns), predictor.runs)


def camera_starts(predictor: Predictor) -> dict[str, float]:
    """Starts of cameras' numbers by name; nothing where no run is made, or no row has all coordinates."""
    setting = predictor.setting
    unknowns = setting.unknowns
    at = predictor.numbers(unknowns.values(unknowns.start))
    points: dict[str, list[tuple[Array, Array]]] = {}
    for which, run in enumerate(setting.runs):
        camera = run.recording.camera
        if camera is None or not any(u.owner == camera.name for u in unknowns.all):
            continue
        seen, flight = predictor.seen(which, at)
        if flight.message:
            continue
        for base in sorted({told.base for told in run.sight.told if told.axis is not None}):
            columns: list[Array] = [np.full(len(seen), np.nan)] * len(camera.axes)
            for k, told in enumerate(run.sight.told):
                if told.axis is not None and told.base == base:
                    columns[told.axis] = run.measured[:, k]
            points.setdefault(camera.name, []).append((seen[:, base : base + 3], np.stack(columns, axis=1)))
    starts: dict[str, float] = {}
    for run in setting.runs:
        camera = run.recording.camera
        if camera is None or camera.name not in points:
            continue
        world, coordinates = (np.concatenate(each) for each in zip(*points[camera.name], strict=True))
        good = np.isfinite(coordinates).all(axis=1)
        if int(good.sum()) < 3:
            continue
        scale, turn, origin = sees(camera, world, coordinates)
        found = {f"{camera.name}.scale": scale}
        found |= {f"{camera.name}.rotation_{a}": float(v) for a, v in zip("xyz", turn, strict=True)}
        found |= {f"{camera.name}.origin_{a}": float(v) for a, v in zip("xyz", origin, strict=False)}
        starts |= found
    return {u.name: starts[u.name] for u in unknowns.all if u.name in starts and u.free.start is None}
