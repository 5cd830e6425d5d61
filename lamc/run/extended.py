"""What compiled code offers beside the model: powers, steps side by side, derivatives. Modules of their own.

In: `Modules`, which makes them. Out: models and modules, each made when it is first asked for. Never: compiles itself.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING

from lamc.basics.errors import RequestError
from lamc.basics.once import lazy, remembered
from lamc.loops.rank import LoopCount
from lamc.mechanics.tangents import Columns
from lamc.records.effect import Effect
from lamc.records.mechanism import Mechanism
from lamc.records.scene import Scene
from lamc.run.following import series_of
from lamc.run.model import CompiledModule, DesignNumbers, Model
from lamc.run.remaking import Recipe
from lamc.run.starting import Starting
from lamc.symbolic.staging import DrawnKey

if TYPE_CHECKING:
    from lamc.records.series import Series


@dataclass(frozen=True)
class Extras:
    """What a module offers beside the model. Each is a module of its own, made when it is asked for: in every model
    powers would be a tenth of the C (100 hinges: 652 instead of 591 kB, 1.89 instead of 1.77 s of gcc), lanes half.

    energy_balance  powers of the effects
    lanes           steps of several runs side by side
    columns         derivatives of the equations by these
    pullbacks       derivatives of weighted sums of what the equations give
    """

    energy_balance: bool = False
    lanes: bool = False
    columns: Columns | None = None
    pullbacks: bool = False

    def __str__(self) -> str:
        columns = "" if self.columns is None else f" columns {self.columns!r}"
        pullbacks = " pullbacks" if self.pullbacks else ""
        return f"powers {self.energy_balance} lanes {self.lanes}{columns}{pullbacks}"

    @property
    def is_of_machine(self) -> bool:
        """Whether parts are compiled for this very machine."""
        return self.lanes or self.pullbacks or self.columns is not None


PLAIN = Extras()
Modules = Callable[[Extras], tuple[CompiledModule, DesignNumbers, tuple[DrawnKey, ...]]]
"""Makes a module; gives the numbers of the design, and the keys of those of the drawing, besides."""


class Extended(Starting):
    """The part of a `Simulator` that has more than its model."""

    def __init__(
        self,
        module: CompiledModule,
        recipe: Recipe | None,
        numbers: DesignNumbers | None,
        modules: Modules | None,
        mechanism: Mechanism,
        scene: Scene,
        effects: Sequence[Effect],
        loops: LoopCount | None,
    ) -> None:
        series = series_of(scene)
        super().__init__(
            Model(module, recipe, numbers=numbers, series=series), mechanism, scene, effects, loops
        )
        self._module = module
        self._recipe = recipe
        self._modules = modules
        self._columns = None if modules is None else remembered(partial(_with_columns, modules, series))

    @lazy
    def telling(self) -> Model:
        """The model that tells powers."""
        if self._modules is None:
            raise RequestError("this simulator was made by hand and tells no powers; use lamc.compile")
        module, numbers, _ = self._modules(Extras(energy_balance=True))
        return Model(module, self._recipe, tells=True, numbers=numbers, series=series_of(self.scene))

    @lazy
    def lanes(self) -> CompiledModule:
        """The module that runs ensembles."""
        if self._modules is None:
            raise RequestError("this simulator was made by hand and runs no ensembles; use lamc.compile")
        return self._modules(Extras(lanes=True))[0]

    def with_columns(self, columns: Columns) -> tuple[Model, tuple[DrawnKey, ...]]:
        """The model that also has derivatives by these, and the keys of its numbers of the drawing."""
        if self._columns is None:
            raise RequestError("this simulator was made by hand and has no derivatives; use lamc.compile")
        return self._columns(columns)

    @lazy
    def with_pullbacks(self) -> tuple[Model, tuple[DrawnKey, ...]]:
        """The model that takes gradients of runs, and the keys of its numbers of the drawing."""
        if self._modules is None:
            raise RequestError("this simulator was made by hand and has no gradients; use lamc.compile")
        return _model(self._modules, series_of(self.scene), Extras(pullbacks=True))


def _with_columns(
    modules: Modules, series: "Mapping[str, Series]", columns: Columns
) -> tuple[Model, tuple[DrawnKey, ...]]:
    return _model(modules, series, Extras(columns=columns))


def _model(
    modules: Modules, series: "Mapping[str, Series]", extras: Extras
) -> tuple[Model, tuple[DrawnKey, ...]]:
    module, numbers, keys = modules(extras)
    return Model(module, numbers=numbers, series=series), keys
