"""Types of record fields that take text with a unit, and hold numbers: "30 deg" goes in, 0.5236 is what one reads.

In and out: nothing at run time, where they are the types of what is held; type checkers see both sides.
"""

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:

    class GivenNumber:
        """A number, SI, given as one or as text with its unit."""

        def __get__(self, record: object, owner: Any = None) -> float: ...
        def __set__(self, record: object, value: float | str) -> None: ...

    class GivenByName:
        """Numbers by name, SI, each given as one or as text with its unit."""

        def __get__(self, record: object, owner: Any = None) -> Mapping[str, float]: ...
        def __set__(self, record: object, value: Mapping[str, float | str]) -> None: ...

    class GivenMaybe:
        """A number or None."""

        def __get__(self, record: object, owner: Any = None) -> float | None: ...
        def __set__(self, record: object, value: float | str | None) -> None: ...
else:
    GivenNumber, GivenByName, GivenMaybe = float, Mapping[str, float], float | None
