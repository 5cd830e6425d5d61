"""Effects of lamc's own: what scene files can name, and designs can ask for.

To add one: its module with a class of `RegisteredEffect`, and a line in `registry.py`.
"""

from collections.abc import Mapping
from typing import ClassVar, Self

from lamc.effects.data import record
from lamc.records.effect import Effect
from lamc.records.mechanism import Mechanism


class RegisteredEffect(Effect):
    """An effect that files can name; a frozen dataclass.

    absent       why it is not there where nobody asks for it, in a few words
    units        SI unit of each field that has one; `data.record` reads the fields from a file then: numbers are SI,
                 text has its unit ("3 N*mm/deg")
    shorthand    the field that may stand alone, as in `gravity: [0, 0, -9.81]`
    data_schema  JSON Schema of data that is no record of fields
    """

    absent: ClassVar[str] = "the scene does not call for it"
    units: ClassVar[Mapping[str, str]] = {}
    shorthand: ClassVar[str | None] = None
    data_schema: ClassVar[Mapping[str, object] | None] = None

    @classmethod
    def default_for(cls, mechanism: Mechanism) -> tuple[Effect | None, str]:
        """The effect as the mechanism itself asks for it (None: not at all), and why, in a few words."""
        return None, cls.absent

    @classmethod
    def from_data(cls, value: object, where: str) -> Self:
        """The effect from a scene file's plain data; `where` names the place for errors.

        Raises DesignError, at best a `data.DataError` with the part at fault, if the data does not fit.
        """
        return record(cls, value, where)
