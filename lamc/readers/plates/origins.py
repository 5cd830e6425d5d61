"""Where a plate file says what: for errors that show only when the plate is meshed or solved.

In: records made from a file, and errors about them. Out: the same errors with file, line and column. Never: reads a
file.
"""

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field

from lamc.basics.errors import DesignError, DesignErrors, Place


@dataclass(frozen=True, eq=False)
class Origins:
    """Places in one file.

    file     the file, without a line
    keys     of keys at its top
    records  supports, loads and outputs, each with its place; a record is known by identity
    """

    file: Place = field(default_factory=Place)
    keys: Mapping[str, Place] = field(default_factory=dict)
    records: Sequence[tuple[object, Place]] = ()

    def place(self, subject: object, key: str = "") -> Place:
        """Of `subject`; of the file's `key` where it is no record of the file; of the file where it has no such key."""
        for record, place in self.records:
            if record is subject:
                return place
        return self.keys.get(key, self.file)

    @contextmanager
    def located(self, key: str = "") -> Iterator[None]:
        """DesignErrors of the block get their place in the file, that of `key` where they are about no record."""
        try:
            yield
        except DesignErrors:
            raise
        except DesignError as error:
            if error.place is not None or not self.file.file:
                raise
            raise type(error)(error.message, self.place(error.subject, key)) from error
