"""Parameters: the numbers of a motion that can change without recompiling.

Goes in: name, default, unit and meaning of each. Comes out: its symbol; records in the order in which they were asked
for. It knows nothing of what they are for.
"""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field

from lamc.basics.checks import checked_number, did_you_mean
from lamc.basics.errors import DesignError, about
from lamc.basics.si_units import si_unit
from lamc.records.inputs import Input
from lamc.records.series import ORDERS
from lamc.symbolic.program import Parameter, Space
from lamc.symbolic.scalars import Scalar, Value
from lamc.symbolic.staging import Store


@dataclass
class Parameters:
    """Parameters in the order in which they were asked for; the same name twice is the same symbol."""

    store: Store
    records: list[Parameter] = field(default_factory=list)
    units: dict[str, str] = field(default_factory=dict)  # of the series
    series: dict[str, Value] = field(
        default_factory=dict
    )  # inputs that follow one, in the order of their constants
    asked: set[str] = field(
        default_factory=set
    )  # those of them that an effect asked for as a parameter of its own
    _places: dict[str, int] = field(default_factory=dict)

    def add(
        self, name: str, default: float, unit: str, meaning: str, effect: str = "", *, is_input: bool = False
    ) -> Scalar:
        """The symbol of a parameter. is_input: it comes from outside while a model runs.

        Raises DesignError for a default that is not finite, and for a name that stands for something else already.
        """
        if is_input and name in self.series:
            return self._asked(name, unit)
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

    def _asked(self, name: str, unit: str) -> Scalar:
        """The symbol of the series that an effect's own input follows."""
        own, given = si_unit(unit).text, self.units[name]
        if own != given:
            with about(("inputs", name)):
                raise DesignError(f"the input {name!r} has the unit {given!r}; an effect reads it in {own!r}")
        self.asked.add(name)
        return self.series[name]

    def check_asked(self) -> None:
        """Once all effects had their turn: raises DesignError for a series with the name of an effect's own input,
        such as knee.torque, that no effect has."""
        for name in self.series:
            if "." in name and name not in self.asked:
                known = [each.name for each in self.records if each.is_input and "." in each.name]
                hint = did_you_mean(name, known) if known else "none of the scene's effects has such inputs"
                with about(("inputs", name)):
                    raise DesignError(f"no effect of the scene has an input {name!r} of its own; {hint}")

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
        for name, each in sorted(inputs.items()):
            if each.series is not None:
                self.units[name] = each.unit
                self.series[name] = self.store.series(name, ORDERS * len(self.series), ORDERS)
        return {
            name: self.series[name]
            if each.series is not None
            else self.add(name, each.default, each.unit, each.meaning or "input", is_input=True)
            for name, each in sorted(inputs.items())
        }

    @property
    def first_mode(self) -> int:
        """The constant behind those that the runtime keeps for series."""
        return ORDERS * len(self.series)
