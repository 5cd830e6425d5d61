"""From values that people give to the fields of an effect: each effect's dataclass as a pydantic model.

In: values by field, from Python or from a file, and what the file knows. Out: checked values, or errors that know
which part they are about. Never: knows an effect by name.

An effect says what its fields are by annotations, and has nothing else to do:

    stiffness: Annotated[float, Unit("N*m/rad", "of the stop", gt=0.0)]

`lamc.basics.fields` and `quantity_fields` have what may stand there; anything else that pydantic knows may too.
"""

from collections.abc import Mapping
from dataclasses import MISSING, fields
from functools import lru_cache
from pathlib import Path as FilePath
from typing import Annotated, Any, get_args, get_origin, get_type_hints

from pydantic import Field, ValidationError, create_model

from lamc.basics.checks import did_you_mean, shown
from lamc.basics.errors import DesignError, DesignErrors, LamcError
from lamc.basics.fields import EXPRESSIONS, FOLDER, LENGTH_UNIT, StrictModel, problem_text
from lamc.basics.quantity_fields import Expressions, Path

MOST_MODELS = 256  # that are remembered


class DataError(DesignError):
    """An effect's data does not fit.

    problem  the message without the place
    path     of the part that does not fit, from the effect's data on
    cause    the error that was found there, if it was one of lamc's
    """

    problem: str = ""
    path: Path = ()
    cause: LamcError | None = None


def refusal(where: str, problem: str, path: Path = (), cause: LamcError | None = None) -> DataError:
    """The error to raise for data that does not fit, at `path` within it."""
    place = where + "".join(f"[{step}]" if isinstance(step, int) else f".{step}" for step in path)
    other = cause.place if cause is not None else None  # in a file that the data names
    error = DataError(problem if other is not None else f"{place}: {problem}", other)
    error.problem, error.path, error.cause = problem, path, cause
    return error


def file_context(
    length_unit: str | None = None, folder: FilePath | None = None, expressions: Expressions | None = None
) -> Mapping[str, Any]:
    """What a file knows of its values: the unit of bare lengths (None: m), from which folder it names others, and what
    reads its expressions in parameters."""
    return {LENGTH_UNIT: length_unit, FOLDER: folder, EXPRESSIONS: expressions}


@lru_cache(maxsize=MOST_MODELS)
def model_of(kind: Any) -> type[StrictModel]:
    """The model of a dataclass's fields."""
    hints = get_type_hints(kind, include_extras=True)
    parts: dict[str, Any] = {}
    for each in fields(kind):
        made = each.default_factory
        default = ... if each.default is MISSING else each.default
        parts[each.name] = (hints[each.name], default if made is MISSING else Field(default_factory=made))
    return create_model(kind.__name__, __base__=StrictModel, **parts)


def is_map(kind: type, field: str) -> bool:
    """Whether the field holds values by name."""
    origin = get_origin(_bare(model_of(kind).model_fields[field].annotation))
    return isinstance(origin, type) and issubclass(origin, Mapping)


def described(kind: type) -> str:
    """The fields of a class that is to be a dataclass, one a line, with what their annotations say."""
    lines = []
    for name, hint in vars(kind).get("__annotations__", {}).items():
        said = getattr(hint, "__metadata__", ())
        unit = next((each.unit for each in said if hasattr(each, "unit")), None)
        words = [each.description for each in said if getattr(each, "description", None)]
        if unit or words:
            lines.append(f"{name:<16} " + ", ".join([*([unit] if unit not in (None, "1") else []), *words]))
    return "\n".join(lines)


def validated(
    kind: type,
    data: Mapping[Any, Any],
    where: str,
    context: Mapping[str, object] | None = None,
    skip: int = 0,
) -> dict[str, Any]:
    """The checked values of the fields of `kind`.

    where  the place, for messages; skip: so many steps of each path stand in no file

    Raises DataError, or DesignErrors with several.
    """
    if not data and not fields(kind):
        return {}  # the usual effects of hinges, sooner: a model takes half a millisecond
    model = model_of(kind)
    try:
        made = model.model_validate(
            {str(name): value for name, value in data.items()}, context=dict(context or {})
        )
    except ValidationError as error:
        items = error.errors(include_url=False)
    else:
        return {name: getattr(made, name) for name in model.model_fields}
    missing = [item["loc"][0] for item in items if item["type"] == "missing" and len(item["loc"]) == 1]
    found = [_reported(kind, item, where, skip) for item in items if item["loc"][0] not in missing]
    if missing:
        label = getattr(kind, "name", kind.__name__)
        problem = f"{label} needs {' and '.join(map(str, missing))}: give {listed(kind)}"
        found = [refusal(where, problem), *found]
    raise found[0] if len(found) == 1 else DesignErrors(found)


def no_record(kind: type, value: object, where: str) -> DataError:
    """The error for data that is no map of fields."""
    label = getattr(kind, "name", kind.__name__)
    if not fields(kind):
        return refusal(where, f"{label} takes no value; it has {shown(value)}")
    return refusal(where, f"{label} is {shown(value)}; give a map of its fields: {listed(kind)}")


def listed(kind: type) -> str:
    """The names of the fields, first those that must be given."""
    known = model_of(kind).model_fields
    needed = [name for name, each in known.items() if each.is_required()]
    others = [name for name in known if name not in needed]
    if not needed:
        return f"{', '.join(others)}, as many as wished"
    return ", ".join(needed) + (f", and {', '.join(others)} if wished" if others else "")


def _reported(kind: type, item: Any, where: str, skip: int) -> DataError:
    path: Path = tuple(item["loc"])
    if item["type"] == "extra_forbidden":
        name, label = str(path[-1]), getattr(kind, "name", kind.__name__)
        known = list(model_of(kind).model_fields)
        problem = f"{label} has no field {name[:40]!r}; {did_you_mean(name, known)}"
        return refusal(where, problem, (*path[:-1], name[:40]))
    return refusal(where, problem_text(item), path[skip:], item.get("ctx", {}).get("error"))


def _bare(hint: Any) -> Any:
    return get_args(hint)[0] if get_origin(hint) is Annotated else hint
