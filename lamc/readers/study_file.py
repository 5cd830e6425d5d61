"""Study files: a design, what is varied of it and what is measured, for `lamc sweep STUDY.yaml`.

In: the text of a YAML file. Out: a `StudyFile`, whose values are read where the design is known. Nothing in a file is
ever executed. Names of files count from the folder of the study's own.
"""

import re
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

from pydantic import Field, model_validator

from lamc.basics.errors import DesignError, LamcError, Place
from lamc.basics.fields import UNIT
from lamc.readers import fields
from lamc.readers.checking import Problems, validate
from lamc.readers.fields import Duration, Number, StrictModel
from lamc.readers.inert import compose
from lamc.readers.load import file_text
from lamc.records.scene import is_scene_name

_KIND = re.compile(rb"^kind:\s*[\"']?study\b", re.MULTILINE)
_PEEKED = 4096  # bytes in which a file says what it is
_VALUE = {"type": ["number", "string"], UNIT: "of what is named"}
_SET: dict[str, Any] = {"additionalProperties": _VALUE}
_VARIED: dict[str, Any] = {"additionalProperties": {"anyOf": [_VALUE, {"type": "array", "items": _VALUE}]}}


class StudyRunModel(StrictModel):
    """How each run of a study goes."""

    t_end: Duration | None = Field(None, description="its end; the scene's duration if not said, else 10 s")
    rtol: Number | None = Field(None, description="relative tolerance of a step; 1e-9 if not said")
    atol: Number | None = Field(
        None, description="absolute tolerance of a step, rad and rad/s; 1e-11 if not said"
    )
    max_step: Duration | None = Field(None, description="longest step")
    integrator: str = Field("auto", description="as of `lamc run`")
    rows: int | None = Field(
        None, ge=2, description="rows that measures look at; 200 a second, and 2001 at least, if not said"
    )
    max_steps: int = Field(1_000_000, ge=1, description="steps after which it gives up")


class StudyModel(StrictModel):
    """A study: a design run at many points, and what is measured of each run, or is to be least."""

    kind: Literal["study"] = Field(description="what the file is")
    name: str | None = Field(None, description="of the study; the file's name if not said")
    story: str = Field("", description="what the study is for, a paragraph of plain text")
    design: str | None = Field(None, description="the design's file, from the folder of this one")
    example: str | None = Field(None, description="an example that ships with lamc, in place of a design")
    scene: str | None = Field(None, description="NAME of one of the design's scenes, FILE, or FILE:NAME")
    set: dict[str, float | str] = Field(
        {}, description="dimensions and parameters that all points have", json_schema_extra=_SET
    )
    vary: dict[str, float | str | list[float | str]] = Field(
        {}, description="what is varied, by name: ranges, lists, distributions", json_schema_extra=_VARIED
    )
    points: str | None = Field(None, description="a CSV file of points, in place of vary")
    sample: str | None = Field(
        None, description="METHOD:COUNT of samples, such as lhs:200; a grid if not said"
    )
    seed: int = Field(0, ge=0, description="of the samples")
    measure: dict[str, str] = Field({}, description="what is read off each run, by name: max(tip.z)")
    minimise: str | list[str] | None = Field(
        None, description="for `lamc optimise`: what is to be least, rms(tip.z - 5 mm); a list makes a front"
    )
    subject_to: list[str] = Field(
        [], description="for `lamc optimise`: what must hold there, max(abs(h1)) < 60 deg"
    )
    method: str = Field("auto", description="for `lamc optimise`: as of its --method")
    start: dict[str, float | str] = Field(
        {}, description="for `lamc optimise`: where it begins, by name", json_schema_extra=_SET
    )
    starts: int = Field(5, ge=1, description="for `lamc optimise`: how many starts")
    max_runs: int = Field(5000, ge=1, description="for `lamc optimise`: runs after which it ends")
    run: StudyRunModel | None = Field(None, description="how each run goes")

    @model_validator(mode="after")
    def _one_design(self) -> "StudyModel":
        if (self.design is None) == (self.example is None):
            raise fields.custom(DesignError("a study has exactly one of design: FILE and example: NAME"))
        if bool(self.vary) == (self.points is not None):
            raise fields.custom(DesignError("a study has exactly one of vary: {…} and points: FILE"))
        if not self.measure and self.minimise is None:
            raise fields.custom(
                DesignError(
                    "a study has measure: {…} for `lamc sweep`, minimise: … for `lamc optimise`, or both"
                )
            )
        return self


@dataclass(frozen=True, eq=False)
class StudyFile:
    """A study as its file says it. places: where names and measures stand, to be told with what is wrong with them."""

    path: Path
    said: StudyModel
    places: Mapping[str, Place]

    @property
    def design(self) -> str | None:
        """The design's file."""
        return None if self.said.design is None else str(self.path.parent / self.said.design)

    @property
    def points(self) -> str | None:
        return None if self.said.points is None else str(self.path.parent / self.said.points)

    @property
    def scene(self) -> str | None:
        """As --scene takes it: a file counts from the study's folder."""
        word = self.said.scene
        if word is None or is_scene_name(word):
            return word
        return str(self.path.parent / word)

    def located(self, error: LamcError) -> LamcError:
        """The error with the place of what it is about, where that is known."""
        if error.place is not None:
            return error
        for name, place in self.places.items():
            if repr(name) in error.message:
                return type(error)(error.message, place)
        return type(error)(error.message, Place(str(self.path)))


def is_study(path: Path) -> bool:
    """Whether a file says that it is a study."""
    if path.suffix.lower() not in (".yaml", ".yml") or not path.is_file():
        return False
    with path.open("rb") as stream:
        return _KIND.search(stream.read(_PEEKED)) is not None


def load_study(path: Path) -> StudyFile:
    """The study in a file. Raises DesignError (DesignErrors for several problems)."""
    node = compose(file_text(path), str(path))
    said = validate(StudyModel, node)
    problems = Problems(node)
    places = {
        **problems.places(("start",)),
        **problems.places(("vary",)),
        **problems.places(("set",)),
        **problems.places(("measure",)),
    }
    places |= {text: problems.place(("measure", name)) for name, text in said.measure.items()}
    for key in ("sample", "points", "scene", "method"):
        value = getattr(said, key)
        if value is not None:
            places[value] = problems.place((key,))
    places |= {text: problems.place(("subject_to", k)) for k, text in enumerate(said.subject_to)}
    goals = [said.minimise] if isinstance(said.minimise, str) else said.minimise or []
    places |= {text: problems.place(("minimise",)) for text in goals}
    return StudyFile(path, said, places)
