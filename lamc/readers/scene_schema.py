"""The schema of scenes: what a `scene:` or `scenes:` section and a file of scenes may say.

In: plain data. Out: validated models in SI. What effects hold is read by the effects (`scene_file`), and described by
them (`effects_schema`).
"""

from collections.abc import Callable
from typing import Annotated, Any, Literal

from pydantic import Field, GetCoreSchemaHandler, GetJsonSchemaHandler, model_validator
from pydantic_core import CoreSchema, core_schema

from lamc.basics.checks import shown
from lamc.basics.errors import DesignError
from lamc.basics.fields import UNIT, part
from lamc.readers.fields import AngleRate, AnyAngle, Duration, Gap, LengthUnit, SpacePoint, StrictModel
from lamc.readers.series_file import GAPS
from lamc.records.series import BEYOND, HOLDS

_CALLED: dict[str, Any] = {"type": ["object", "array", "null"]}
_INPUT_FIELDS = {
    "default": {
        "type": ["number", "string"],
        UNIT: "of the input",
        "description": "value until told otherwise, as in 0 N*mm",
    },
    "unit": {"type": "string", "description": "of a default that is written without one"},
    "meaning": {"type": "string", "description": "what it is, in a few words"},
}
_ROW = {"type": "array", "items": {"type": "number"}}
_COLUMN = {"type": ["string", "integer"]}
_SERIES_FIELDS = {
    "csv": {"type": "string", "description": "file with columns over time, from this file on"},
    "column": {
        **_COLUMN,
        "description": "name or number, from 1, of the values; the only one beside the time if not said",
    },
    "time": {**_COLUMN, "description": "name or number of the times; t, time or the first if not said"},
    "unit": {"type": "string", "description": "of the values, such as deg; else as the heading says, [deg]"},
    "time_unit": {
        "type": "string",
        "description": "of the times, such as ms; else as the heading says, or s",
    },
    "hold": {
        "enum": list(HOLDS),
        "description": "between rows: each value until the next, straight lines, or a smooth spline",
    },
    "beyond": {
        "enum": list(BEYOND),
        "description": "before the first row and after the last: refuse the run, or hold the value",
    },
    "gaps": {"enum": list(GAPS), "description": "rows without a number: refuse them, or leave them out"},
    "t": {**_ROW, UNIT: "s", "description": "times, in place of a file"},
    "values": {**_ROW, UNIT: "of the input", "description": "values at these times"},
    "meaning": {"type": "string", "description": "what it is, in a few words"},
}
_INPUTS: dict[str, Any] = {
    "additionalProperties": {
        "anyOf": [
            {"type": ["number", "string"], UNIT: "of the input"},
            {"type": "object", "properties": _INPUT_FIELDS, "additionalProperties": False},
            {"type": "object", "properties": _SERIES_FIELDS, "additionalProperties": False},
        ]
    },
}
_PARAMETERS: dict[str, Any] = {
    "additionalProperties": {"type": ["number", "string"], UNIT: "of the parameter"}
}
_SAYS = "effects by name with their values, as a map, or as a list of names and one-entry maps"


class OutputPointModel(StrictModel):
    """A point of a rigid body; its x, y and z, world, are outputs."""

    name: str = Field(description="of the point")
    body: str = Field(description="that it belongs to")
    point: SpacePoint = Field(description="where it is as drawn, world axes")


class _OrName:
    """Beside a model, text stands for itself. A union would report the problems of a map twice."""

    def __get_pydantic_core_schema__(self, source: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
        def read(value: Any, inner: Callable[[Any], Any]) -> Any:
            return value if isinstance(value, str) else inner(value)

        return core_schema.no_info_wrap_validator_function(read, handler(source))

    def __get_pydantic_json_schema__(self, schema: CoreSchema, handler: GetJsonSchemaHandler) -> Any:
        return {"anyOf": [{"type": "string"}, handler(schema)]}


class SceneModel(StrictModel):
    """What acts, how the mechanism starts, how long it runs. Without `effects`: what the design itself asks for."""

    like: str | None = Field(
        None, description="another scene of the file, of which this one has all but what it says"
    )
    effects: Any = Field(None, description=f"exactly these act: {_SAYS}", json_schema_extra=_CALLED)
    with_: Any = Field(
        None,
        alias="with",
        description=f"these act besides, or in place of those of the same name: {_SAYS}",
        json_schema_extra=_CALLED,
    )
    without: Any = Field(
        None,
        description="names of effects that are left out",
        json_schema_extra={"type": ["array", "string", "null"], "items": {"type": "string"}},
    )
    angles: dict[str, AnyAngle] = Field({}, description="initial angles by joint")
    rates: dict[str, AngleRate] = Field({}, description="initial rates by joint")
    inputs: dict[str, Any] = Field(
        {},
        description="numbers from outside by name, which expressions may hold: the value until told otherwise, with "
        "its unit, or a map of default, unit and meaning; or what they follow over time, as {csv: bench.csv, column: "
        "cmd, unit: deg, hold: linear}",
        json_schema_extra=_INPUTS,
    )
    parameters: dict[str, Any] = Field(
        {},
        description="parameters of the model by name, in place of the design's values, such as h1.stiffness: a number "
        "(SI), or text with a unit; what `lamc fit` finds",
        json_schema_extra=_PARAMETERS,
    )
    branch: int | None = Field(
        None, description="way out of a singular start: 1, 2, … as listed; negative for the other way"
    )
    closure_tolerance: Gap | None = Field(
        None, description="gap up to which loops that do not fit count as closed"
    )
    duration: Duration | None = Field(None, description="how long `lamc run` simulates it; 10 s if not said")
    outputs: list[Annotated[OutputPointModel, _OrName()]] | None = Field(
        None,
        description="what matters of the motion: joints, coordinates, BODY.x, BODY.y, BODY.z (centres of mass), and "
        "points of bodies as {name, body, point}; all joints if not said",
    )

    @model_validator(mode="before")
    @classmethod
    def _is_no_name(cls, data: Any) -> Any:
        with part():
            if isinstance(data, str):
                raise DesignError(
                    f"a scene is a map, and it is {shown(data)}; write {{like: NAME}} for one of `scenes`"
                )
        return data


ScenesModel = Annotated[
    dict[str, SceneModel], Field(description="scenes by name; `lamc run DESIGN --scene NAME` simulates one")
]


class SceneFileModel(StrictModel):
    """Scenes in a file of their own, for `lamc run DESIGN --scene FILE:NAME`."""

    kind: Literal["scene"] = Field("scene", description="what the file is")
    units: LengthUnit = Field("m", description="the unit of every length written without one, such as mm")
    scene: SceneModel | None = Field(None, description="the one that is meant where no name is given")
    scenes: ScenesModel = Field(default={})


class LoneSceneModel(SceneModel):
    """What acts, how the mechanism starts, how long it runs: one scene. Without `effects`: what the design asks for."""

    kind: Literal["scene"] = Field("scene", description="what the file is")
    units: LengthUnit = Field("m", description="the unit of every length written without one, such as mm")
