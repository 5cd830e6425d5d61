"""Parameters: the numbers of a motion that can change without recompiling.

Goes in: name, default, unit and meaning of each. Comes out: its symbol; records in the order in which they were asked
for. It knows nothing of what they are for.
"""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field

from lamc.basics.checks import checked_number
from lamc.basics.errors import DesignError, about
from lamc.records.inputs import Input
from lamc.symbolic.program import Parameter, Space
from lamc.symbolic.scalars import Scalar, Value
from lamc.symbolic.staging import Store


@dataclass
class Parameters:
    """Parameters in the order in which they were asked for; the same name twice is the same symbol."""

    store: Store
    records: list[Parameter] = field(default_factory=list)
    _places: dict[str, int] = field(default_factory=dict)

    def add(
        self, name: str, default: float, unit: str, meaning: str, effect: str = "", *, is_input: bool = False
    ) -> Scalar:
        """The symbol of a parameter. is_input: it comes from outside while a model runs.

        Raises DesignError for a default that is not finite, and for a name that stands for something else already.
        """
        index = self._places.setdefault(name, len(self.records))
        value = checked_number(default, f"the default of parameter {name!r}")
        if index == len(self.records):
            self.records.append(Parameter(name, value, unit, meaning, effect, is_input))
        known = self.records[index]
        if (known.default, known.unit, known.is_input) != (value, unit, is_input):
            kind = "input" if known.is_input else "parameter"
            raise DesignError(
                f"{kind} {name!r} is there already, with {known.default:g} {known.unit} ({known.meaning}); "
                "choose another name"
            )
        return self.store.symbol(name, Space.PARAMETER, index)

    def from_outside(self) -> tuple[Value, ...]:
        """The symbols of inputs that effects bring and that are zero unless set otherwise."""
        return tuple(
            self.store.symbol(each.name, Space.PARAMETER, index)
            for index, each in enumerate(self.records)
            if each.is_input and each.effect and each.default == 0.0
        )

    def declare(self, inputs: Mapping[str, Input], coordinates: Iterable[str]) -> Mapping[str, Scalar]:
        """The symbols of a scene's inputs by name, in the order of their names. coordinates: names of q and u.

        Raises DesignError for a name that the equations have for something else.
        """
        named = {f"{symbol}_{name}": name for name in coordinates for symbol in ("q", "u", "udot")}
        for name in sorted(inputs):
            if name in named:
                with about(("inputs", name)):
                    raise DesignError(
                        f"an input is named {name!r}, as the equations name the motion of {named[name]!r}; choose "
                        "another name"
                    )
        return {
            name: self.add(name, each.default, each.unit, each.meaning or "input", is_input=True)
            for name, each in sorted(inputs.items())
        }
