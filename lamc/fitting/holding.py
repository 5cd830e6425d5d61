"""A fit beside a recording that it was not made of: what it is worth elsewhere.

In: a fit, a recording. Out: a `Compared`. Numbers of the model stay as fitted; what is the recording's own (its start,
delay, gains, as far as they are ranges) is found from it, and a camera that the fit knows is as it was.
"""

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from lamc.fitting.cameras import placed
from lamc.fitting.compared import Compared, compared_of
from lamc.fitting.exact import Exact
from lamc.fitting.objective import Objective, first_sigmas
from lamc.fitting.predictions import Predictor
from lamc.fitting.setting import setting_of
from lamc.fitting.simulators import Simulators
from lamc.fitting.solve import Solved, solve
from lamc.records.recording import Camera, Recording

if TYPE_CHECKING:
    from lamc.fitting.answer import Fit


def held_back(fit: "Fit", recording: Recording) -> Compared:
    """The recording beside the fitted model. Raises RequestError as a fit does."""
    usual = fit.setting.simulators
    simulators = usual if not fit.dimensions else Simulators(fit.design, fit.simulator.scene, usual.options)
    if recording.camera is not None:
        recording = replace(recording, camera=_known(fit, recording.camera))
    parameters = {**fit.setting.parameters, **fit.parameters}
    setting = setting_of(simulators, [recording], {}, parameters, held=True)
    predictor = placed(Predictor(setting, Exact()))
    objective = Objective(predictor, first_sigmas(predictor))
    if setting.unknowns.all:
        solved = solve(objective, "linear", 1, 0)
    else:
        solved = Solved(np.zeros(0), 0.0, True, "nothing is free", objective)
    return compared_of(predictor, solved)[0]


def _known(fit: "Fit", camera: Camera) -> Camera:
    """The camera with what the fit knows of it."""
    values, name = fit.values, camera.name
    if not any(each.startswith(f"{name}.") for each in values):
        return camera
    origin = tuple(values.get(f"{name}.origin_{a}", c) for a, c in zip("xyz", camera.origin, strict=False))  # type: ignore[call-overload]
    turned = [f"{name}.rotation_{a}" for a in "xyz"]
    rotation = camera.rotation
    if any(each in values for each in turned[:2]):
        old: tuple[object, ...] = tuple(camera.rotation)  # type: ignore[arg-type]
        rotation = tuple(values.get(each, o) for each, o in zip(turned, old, strict=True))
    elif turned[2] in values:
        rotation = values[turned[2]]
    return replace(camera, scale=values.get(f"{name}.scale", camera.scale), rotation=rotation, origin=origin)
