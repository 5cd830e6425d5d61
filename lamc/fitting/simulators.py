"""Simulators of a design by its dimensions, each made once.

In: a design, a scene, dimensions. Out: simulators, and states that they start from.
"""

from collections.abc import Callable, Mapping
from dataclasses import replace

import numpy as np

from lamc.basics.readonly import ReadOnlyDict
from lamc.codegen.cache import Cache, cache_root
from lamc.codegen.options import CompileOptions
from lamc.design.split import split
from lamc.pipeline import compile as compile_design
from lamc.records.design import Design
from lamc.records.mechanism import Mechanism
from lamc.records.scene import Scene
from lamc.run.request import Array
from lamc.run.simulator import Simulator
from lamc.studies.targets import Made, Studied, made

_KEPT = 64

SceneGiven = Scene | Callable[[Mechanism], Scene] | None


class Simulators:
    """usual: of the design as it stands."""

    def __init__(self, design: Studied, scene: SceneGiven, options: CompileOptions | None = None) -> None:
        self.design, self._scene, self.options = design, scene, options
        self._made: dict[tuple[tuple[str, float], ...], Simulator] = {}
        self._cache = Cache(cache_root())
        self.usual = self.of({})
        self._cache = Cache(cache_root(), passing=True)  # which keeps nothing of drawings that come once

    def of(self, dimensions: Mapping[str, float]) -> Simulator:
        """Raises DesignError for dimensions that no design has."""
        key = tuple(sorted(dimensions.items()))
        found = self._made.get(key)
        if found is None:
            if len(self._made) >= _KEPT:
                del self._made[list(self._made)[1]]  # the first is the usual one
            found = self._made[key] = self._compiled(dimensions)
        return found

    def drawn(self, dimensions: Mapping[str, float]) -> Made:
        return made(self.design, dimensions)

    def _compiled(self, dimensions: Mapping[str, float]) -> Simulator:
        design = made(self.design, dimensions)
        scene = self._scene
        if callable(scene):
            design = split(design) if isinstance(design, Design) else design
            scene = scene(design)
        return compile_design(design, scene, self.options, cache=self._cache)


def start_of(simulator: Simulator, angles: Mapping[str, float], rates: Mapping[str, float]) -> Array:
    """The state (n,) that a run starts from, with some angles, rad, and rates, rad/s, other than the scene's. Raises
    DesignError where loops do not close."""
    if not angles and not rates:
        return np.array(simulator.start)
    scene = simulator.scene
    moved = replace(
        scene, angles=ReadOnlyDict({**scene.angles, **angles}), rates=ReadOnlyDict({**scene.rates, **rates})
    )
    return np.array(simulator.start_of(moved))
