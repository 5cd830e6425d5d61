"""Parameters of drawings as such: what every drawing follows from, whatever its file declares.

In: what a file was read into, and values in the place of its own. Out: the record made again. Nothing of this is
computed before somebody asks for a parameter.

`scale` multiplies what is drawn, in the plane: outlines, hinge lines, gaps, points; thickness is a parameter by itself.
"""

from abc import ABC, abstractmethod
from collections.abc import Iterable, Mapping
from dataclasses import MISSING, dataclass, field, fields, replace
from functools import cached_property, lru_cache
from typing import Any, TypeVar

import numpy as np
import shapely

from lamc.basics.errors import DesignError, Place
from lamc.basics.fields import UNIT
from lamc.basics.readonly import ReadOnlyDict
from lamc.effects.data import model_of
from lamc.effects.registry import EFFECTS
from lamc.records.effect import Effect
from lamc.records.parameters import DesignParameter, with_origin
from lamc.records.scene import OutputPoint, Scene

SCALE = "scale"
Maybe = TypeVar("Maybe", Scene, Scene | None)
THIN = 1e-9  # m
_LEAST, _MOST = 1e-3, 1e3  # of the scale


@dataclass(frozen=True, eq=False)
class AsSuch(ABC):
    """A recipe without declared parameters: see `lamc.records.parameters.Recipe`.

    given  SI, those that are not what the file says
    """

    given: Mapping[str, float] = field(default_factory=dict, kw_only=True)

    @abstractmethod
    def drawn(self) -> Mapping[str, DesignParameter]:
        """By name, with what the file says as defaults."""

    @abstractmethod
    def changed(self, values: Mapping[str, float]) -> Any:
        """The record with these values, one for each parameter."""

    @cached_property
    def parameters(self) -> Mapping[str, DesignParameter]:
        drawn = self.drawn().items()
        return ReadOnlyDict(
            {name: replace(each, default=self.given.get(name, each.default)) for name, each in drawn}
        )

    @property
    def listed(self) -> Mapping[str, DesignParameter]:
        return {name: each for name, each in self.parameters.items() if name in self.given}

    def made(self, values: Mapping[str, float]) -> Any:
        again = replace(self, given={**self.given, **values})
        return with_origin(
            again.changed({name: each.default for name, each in again.parameters.items()}), again
        )

    def place(self, name: str) -> Place | None:
        return None

    def __getstate__(self) -> dict[str, Any]:
        return {each.name: getattr(self, each.name) for each in fields(self)}


def scale_parameter(meaning: str = "of all that is drawn, in the plane") -> DesignParameter:
    return DesignParameter(1.0, "1", _LEAST, _MOST, meaning)


def thickness_parameter(value: float, of: str) -> DesignParameter:
    return DesignParameter(value, "m", min(THIN, value), None, f"thickness of {of}")


def named(owner: str, what: str, owners: Iterable[str]) -> str:
    """ "thickness" of an only layer, "board.thickness" of one of several."""
    return what if len(set(owners)) == 1 else f"{owner}.{what}"


def numbered(names: Iterable[str]) -> list[str]:
    """The names, those that stand there already with a number behind them."""
    found: list[str] = []
    for name in names:
        count, own = 1, name
        while own in found:
            count += 1
            own = f"{name}_{count}"
        found.append(own)
    return found


def scaled_shape(shape: Any, scale: float) -> Any:
    """A geometry in the plane, larger about the origin; the same object for 1."""
    return shape if scale == 1.0 else shapely.transform(shape, lambda points: scale * points)


def scaled_scene(scene: Maybe, factors: tuple[float, float, float]) -> Maybe:
    """With its points moved along. Raises DesignError for an effect that holds lengths, which may be of anything."""
    if scene is None or factors == (1.0, 1.0, 1.0):
        return scene
    for effect in (*(scene.effects or ()), *scene.added):
        _check_lengths(effect)
    outputs = scene.outputs
    if outputs is not None:
        outputs = tuple(
            replace(each, point=tuple(np.multiply(each.point, factors)))
            if isinstance(each, OutputPoint)
            else each
            for each in outputs
        )
    tolerance = scene.closure_tolerance
    return replace(
        scene, outputs=outputs, closure_tolerance=None if tolerance is None else factors[0] * tolerance
    )


def _check_lengths(effect: Effect) -> None:
    name = getattr(effect, "name", type(effect).__name__)
    kind: Any = type(effect)
    if kind not in EFFECTS:
        raise DesignError(
            f"effect {name!r} of the scene is not lamc's, so its lengths cannot be scaled; run the scaled design with "
            "a scene made for it"
        )
    for part in fields(effect):  # type: ignore[arg-type]
        default = part.default if part.default_factory is MISSING else part.default_factory()
        if part.name in _of_length(kind) and repr(getattr(effect, part.name)) != repr(default):
            raise DesignError(
                f"the scene has {name} with {part.name}, a length, of which scale cannot know whether it is drawn; "
                "declare parameters: in a native design, or run the scaled design with a scene made for it"
            )


@lru_cache(maxsize=256)
def _of_length(kind: Any) -> frozenset[str]:
    """Fields that hold lengths, whatever the depth."""
    properties = model_of(kind).model_json_schema().get("properties", {})
    return frozenset(name for name, schema in properties.items() if _holds_length(schema))


def _holds_length(schema: Any) -> bool:
    if isinstance(schema, Mapping):
        return schema.get(UNIT) == "m" or any(_holds_length(each) for each in schema.values())
    return isinstance(schema, list) and any(_holds_length(each) for each in schema)
