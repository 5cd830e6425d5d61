"""Effects of lamc's own: what scene files can name, and designs can ask for.

To add one: its module with a class of `RegisteredEffect`, and a line in `registry.py`.
"""

import inspect
from collections.abc import Mapping
from dataclasses import fields
from typing import Any, ClassVar, Self

from lamc.basics.errors import DesignError, DesignErrors, LamcError
from lamc.effects.data import DataError, described, is_map, no_record, refusal, validated
from lamc.records.effect import Effect
from lamc.records.mechanism import Mechanism


class RegisteredEffect(Effect):
    """An effect that files can name: a frozen dataclass, whose fields say by their annotations what they hold.

    absent     why it is not there where nobody asks for it, in a few words
    shorthand  the field that may stand alone, as in `gravity: [0, 0, -9.81]`
    said       the docstring of the class without its fields
    example    how a scene may call for it, YAML of one entry

    Numbers are SI, text has its unit ("3 N*mm/deg"), in Python as in files.
    """

    absent: ClassVar[str] = "the scene does not call for it"
    shorthand: ClassVar[str | None] = None
    said: ClassVar[str] = ""
    example: ClassVar[str] = ""

    def __init_subclass__(cls, **named: Any) -> None:
        super().__init_subclass__(**named)
        cls.said = inspect.cleandoc(cls.__doc__ or cls.summary)
        cls.__doc__ = f"{cls.said}\n\n{described(cls)}".rstrip()

    def __post_init__(self) -> None:
        """Checks the fields one by one; what they have to do with each other is for effects to check after that."""
        given = {each.name: getattr(self, each.name) for each in fields(self)}  # type: ignore[arg-type]
        try:
            values = validated(type(self), given, self.name)
        except DesignErrors as errors:
            raise _as_found(errors.problems[0]) from errors
        except DataError as error:
            raise _as_found(error) from error
        for name, value in values.items():
            object.__setattr__(self, name, value)

    @classmethod
    def default_for(cls, mechanism: Mechanism) -> tuple[Effect | None, str]:
        """The effect as the mechanism itself asks for it (None: not at all), and why, in a few words."""
        return None, cls.absent

    @classmethod
    def from_data(cls, value: object, where: str, context: Mapping[str, object] | None = None) -> Self:
        """The effect from a scene file's plain data: a map of its fields, nothing for all defaults, or the field that
        `shorthand` names.

        where    names the place for errors
        context  `data.file_context` of the file

        Raises DataError with the part at fault, or DesignErrors with several.
        """
        short = cls.shorthand
        alone = short is not None and (
            is_map(cls, short) or not (value in (None, True) or isinstance(value, Mapping))
        )
        data = {short: value} if alone else {} if value is None or value is True else value
        if not isinstance(data, Mapping):
            raise no_record(cls, value, where)
        skip = 1 if alone else 0
        values = validated(cls, data, where, context, skip)
        try:
            return cls(**values)
        except LamcError as error:
            path = error.subject if isinstance(error.subject, tuple) else ()
            raise refusal(where, error.message, path[skip:], error) from error


def _as_found(error: DesignError) -> LamcError:
    """The error as Python's callers know it: of the kind that was found."""
    cause = getattr(error, "cause", None)
    return type(cause)(error.message, cause.place) if cause is not None else error
