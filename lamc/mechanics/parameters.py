"""Parameters: the numbers of a motion that can change without recompiling.

Goes in: name, default, unit and meaning of each. Comes out: its symbol; records in the order in which they were asked
for. It knows nothing of what they are for.
"""

from dataclasses import dataclass, field

from lamc.codegen.program import Parameter, Space
from lamc.errors import DesignError
from lamc.mechanics.staging import Scalar, Store
from lamc.mechanism.checks import checked_number


@dataclass
class Parameters:
    """Parameters in the order in which they were asked for; the same name twice is the same symbol."""

    store: Store
    records: list[Parameter] = field(default_factory=list)
    _places: dict[str, int] = field(default_factory=dict)

    def add(self, name: str, default: float, unit: str, meaning: str, effect: str = "") -> Scalar:
        """The symbol of a parameter. Raises DesignError for a default that is not finite, and for a name that stands
        for something else already."""
        index = self._places.setdefault(name, len(self.records))
        value = checked_number(default, f"the default of parameter {name!r}")
        if index == len(self.records):
            self.records.append(Parameter(name, value, unit, meaning, effect))
        known = self.records[index]
        if (known.default, known.unit) != (value, unit):
            raise DesignError(
                f"parameter {name!r} is there already, with {known.default:g} {known.unit} ({known.meaning}); "
                "choose another name"
            )
        return self.store.symbol(name, Space.PARAMETER, index)
