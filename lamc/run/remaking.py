"""Compiled code in another process: what holds it is pickled as what it was made from, and found again by its digest.

In: mechanism, scene, options and cache. Out: the same `Simulator` or `Model`, loaded from the cache, or compiled where
that has been emptied. A process that has a model of that digest uses it. Never: pickles compiled code; takes a model of
another program, which another version of lamc may make, for the one that a result was computed by.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any
from weakref import WeakValueDictionary

from lamc.basics.drawing import drawer
from lamc.basics.errors import UnsupportedError
from lamc.basics.once import kept_with
from lamc.codegen.cache import Cache
from lamc.codegen.options import CompileOptions
from lamc.records.mechanism import Mechanism
from lamc.records.scene import Scene

if TYPE_CHECKING:
    from lamc.records.design import Design
    from lamc.records.series import Series
    from lamc.run.model import Model, Motion
    from lamc.run.simulator import Simulator

_models: "WeakValueDictionary[tuple[str, str], Model]" = (
    WeakValueDictionary()
)  # by digest and entry of the cache


@dataclass(frozen=True, eq=False)
class Recipe:
    """What a simulator was compiled from."""

    mechanism: Mechanism
    scene: Scene
    options: CompileOptions
    cache: Cache

    def in_passing(self) -> "Recipe":
        """The same, of which the cache keeps nothing that is of one design alone. One for all that are made of it: what
        these have in common is looked for once."""
        return kept_with(self, "_in_passing", Recipe._passing)

    def _passing(self) -> "Recipe":
        return self if self.cache.passing else replace(self, cache=Cache(self.cache.root, passing=True))

    def __reduce__(self) -> Any:
        return Recipe, (self.mechanism, self.scene, self.options, self.cache)

    def simulator(
        self, design: "Design | Mechanism | None" = None, scene: Scene | None = None
    ) -> "Simulator":
        """A simulator of it, or of another design in a scene (None: the design's own). Raises as `lamc.compile`
        does."""
        of = (self.mechanism, self.scene) if design is None else (design, scene)
        made: Simulator = drawer("Simulator", "remake")(*of, self.options, cache=self.cache)
        return made


class Telling:
    """Makes the motion that tells powers, when it is asked for; in another process from the recipe."""

    def __init__(
        self,
        simulator: "Simulator | None",
        recipe: Recipe | None,
        parameters: "Mapping[str, float | str | Series]",
        baumgarte: float,
    ) -> None:
        self._simulator = simulator
        self._recipe, self._parameters, self._baumgarte = recipe, dict(parameters), baumgarte

    @property
    def simulator(self) -> "Simulator":
        """What ran; in another process made anew when it is first asked for."""
        if self._simulator is None:
            assert self._recipe is not None
            self._simulator = self._recipe.simulator()
        return self._simulator

    @property
    def baumgarte(self) -> float:
        """1/s; 0 where steps are projected."""
        return self._baumgarte

    def __call__(self) -> "Motion":
        return self.simulator.telling.motion(self._parameters, self._baumgarte)

    def __reduce__(self) -> tuple[Any, ...]:
        return Telling, (None, self._recipe, self._parameters, self._baumgarte)


def remember(model: "Model", entry: str) -> None:
    """Lets what is pickled find this model again."""
    _models[model.digest, entry] = model


def remade_simulator(recipe: Recipe) -> "Simulator":
    """What a pickled simulator becomes."""
    return recipe.simulator()


def remade_model(recipe: Recipe, digest: str, entry: str, *, tells: bool) -> "Model":
    """What a pickled model becomes. Raises UnsupportedError where the same design compiles to another program."""
    found = _models.get((digest, entry))
    if found is not None:
        return found
    simulator = recipe.simulator()
    model = simulator.telling if tells else simulator.model
    if model.digest != digest:
        raise UnsupportedError(
            f"what was pickled was computed by another program than this lamc makes of {model.name!r} (digests "
            f"{digest[:12]}… and {model.digest[:12]}…); run it again here, or take results along with to_npz"
        )
    return model
