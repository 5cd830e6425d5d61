"""Where a run begins, shown to the effects that ask for it before it does.

In: effects, a motion with the parameters of the run, its start. Out: nothing, or the error of the effect that refuses
it, which is about that effect. Never: integrates, or knows an effect by name.
"""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from lamc.basics.errors import DesignError, about
from lamc.effects.drives import check_drives
from lamc.records.effect import overrides
from lamc.records.mechanism import Mechanism
from lamc.records.scene import Scene
from lamc.records.series import Series
from lamc.run.model import Motion
from lamc.run.request import Array


def refuse_branch(scene: Scene) -> None:
    """Raises DesignError if the scene chooses among branches, of a mechanism without loops."""
    if scene.branch is not None:
        with about(("branch",)):
            raise DesignError(
                f"branch is {scene.branch}, and a mechanism without loops has none; leave it out"
            )


def check_start(effects: Sequence[Any], mechanism: Mechanism, motion: Motion, start: Array) -> None:
    """Shows the angles at the start (nq + nu,) and the mechanism with the limits of the run. Raises DesignError if an
    effect refuses them."""
    if any(overrides(effect, "check_start") for effect in effects):
        check_angles(effects, mechanism, _by_joint(motion, start)[0])


def check_angles(effects: Sequence[Any], mechanism: Mechanism, angles: Mapping[str, float]) -> None:
    """As `check_start`, of angles by joint, rad."""
    for effect in effects:
        if overrides(effect, "check_start"):
            with about(effect):
                effect.check_start(mechanism, angles)


def check_run(
    effects: Sequence[Any], mechanism: Mechanism, motion: Motion, start: Array, t_end: float
) -> None:
    """Shows the run of t_end s: drives from the start (nq + nu,) on, and where the bodies are there.

    Raises ExpressionError for a drive without a value, or with a kink where it has to be smooth, and DesignError for a
    position that an effect refuses."""
    _check_driven(effects, motion, start, t_end)
    _check_poses(effects, mechanism, motion, start)


def _check_poses(effects: Sequence[Any], mechanism: Mechanism, motion: Motion, start: Array) -> None:
    checks = [effect for effect in effects if overrides(effect, "check_poses")]
    if checks:
        (rows,) = motion.poses(np.zeros(1), start.reshape(1, -1))
        names = motion.model.bodies
        placed = {n: (row[:3], row[3:].reshape(3, 3)) for n, row in zip(names, rows, strict=True)}
        for effect in checks:
            with about(effect):
                effect.check_poses(mechanism, placed, _parameters(motion))


def _check_driven(effects: Sequence[Any], motion: Motion, start: Array, t_end: float) -> None:
    driven = [effect for effect in effects if overrides(effect, "drives")]
    if driven:
        following = motion.following
        inputs: dict[str, float | Series] = {**_parameters(motion)}
        inputs |= dict(zip(following.names, following.series, strict=False))
        check_drives(driven, *_by_joint(motion, start), t_end, inputs)


def _parameters(motion: Motion) -> dict[str, float]:
    """The values of a run, by name."""
    return dict(zip(motion.model.parameters, motion.parameters.tolist(), strict=False))


def _by_joint(motion: Motion, start: Array) -> tuple[dict[str, float], dict[str, float]]:
    """Angles, rad, and rates, rad/s, of all joints in the state `start`."""
    model = motion.model
    joints, count, nq = model.joints, len(model.joints), len(model.coordinates)
    angles = dict(zip(joints, start[:count].tolist(), strict=True))
    rates = dict(zip(joints, start[nq : nq + count].tolist(), strict=True))
    return angles, rates
