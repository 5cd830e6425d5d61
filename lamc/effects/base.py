"""What an effect is. The rest of the compiler knows effects through this page only.

An effect is a small immutable record. `contribute` adds its symbolic loads, stored energy and parameters to a
`Loads` collector; what it does not add leaves no trace in the equations or in the C.
"""

from typing import TYPE_CHECKING, ClassVar, Protocol, runtime_checkable

if TYPE_CHECKING:
    from lamc.mechanics.loads import Loads
    from lamc.mechanism.records import Mechanism


@runtime_checkable
class Effect(Protocol):
    """One physical effect. Implementations are frozen dataclasses.

    name     lower-case identifier, the effect's name in scene files, tables and energies
    summary  one line for people
    """

    name: ClassVar[str]
    summary: ClassVar[str]

    def contribute(self, loads: "Loads") -> None:
        """Adds the effect's loads. Raises DesignError if it names bodies or joints that are not there."""

    @classmethod
    def default_for(cls, mechanism: "Mechanism") -> "tuple[Effect | None, str]":
        """The effect as the mechanism itself asks for it (None: not at all), and why, in a few words."""
