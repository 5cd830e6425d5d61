"""What a sheet is of that a drawing of lines does not say: its card, how stiff its creases are, what holds it.

In: numbers, SI, or text with units. Out: checked records. Never: reads a file.
"""

from dataclasses import dataclass
from typing import Any

from lamc.basics import units
from lamc.basics.checks import checked_array, checked_kind, checked_number, is_list, shown
from lamc.basics.errors import DesignError
from lamc.basics.given import GivenMaybe, GivenNumber


@dataclass(frozen=True)
class Card:
    """The material of a sheet's facets: thickness, m, and density, kg/m³; text has its unit, as in "0.3 mm".

    Raises DesignError for numbers that are not above zero.
    """

    thickness: GivenNumber = 3e-4  # type: ignore[assignment]  # m
    density: GivenNumber = 700.0  # type: ignore[assignment]  # kg/m³

    def __post_init__(self) -> None:
        for name, quantity in (("thickness", units.LENGTH), ("density", units.DENSITY)):
            value = checked_number(getattr(self, name), f"the {name} of the card", quantity=quantity)
            if not value > 0.0:
                raise DesignError(f"the {name} of the card is {value:g} {quantity.unit}; it must be above 0")
            object.__setattr__(self, name, value)

    @staticmethod
    def of(text: str) -> "Card":
        """The card of "0.3 mm, 700 kg/m^3". Raises DesignError for other text."""
        parts = [part.strip() for part in text.split(",")]
        if len(parts) != 2:
            raise DesignError(f"the card is {shown(text)}; write thickness and density: '0.3 mm, 700 kg/m^3'")
        return Card(*parts)


@dataclass(frozen=True)
class SheetOptions:
    """What a user says of a drawn sheet beside its file; None: what the file says, else a default that is told.

    fixed   name of the facet that is held, "F12", or a point inside it, (x, y), m
    card    of all facets
    crease  N·m/rad for each m of a crease
    units   of the drawing's numbers, "mm"
    """

    fixed: str | tuple[float, float] | None = None
    card: Card | None = None
    crease: GivenMaybe = None  # type: ignore[assignment]  # N/rad
    units: str | None = None

    def __post_init__(self) -> None:
        if self.card is not None:
            checked_kind(self.card, Card, "card", "make one with lamc.Card(thickness=…, density=…)")
        if self.crease is not None:
            crease = checked_number(
                self.crease, "the stiffness of creases", minimum=0.0, quantity=units.LINE_STIFFNESS
            )
            object.__setattr__(self, "crease", crease)
        if self.units is not None:
            units.length_unit(self.units)
        if self.fixed is not None and not isinstance(self.fixed, str):
            object.__setattr__(self, "fixed", _point(self.fixed))

    @property
    def given(self) -> tuple[str, ...]:
        """Names of what is given."""
        return tuple(name for name in ("fixed", "card", "crease", "units") if getattr(self, name) is not None)


NO_SHEET_OPTIONS = SheetOptions()


def fixed_of(text: str) -> str | tuple[float, float]:
    """A facet's name, or the point of "10 mm, 20 mm". Raises DesignError for a point that is none."""
    return _point([part.strip() for part in text.split(",")]) if "," in text else text


def _point(value: Any) -> tuple[float, float]:
    if not is_list(value) or len(value) != 2:
        raise DesignError(
            f"fixed is {shown(value)}; it must be the name of a facet, such as 'F12', or a point (x, y), m"
        )
    x, y = checked_array(value, (2,), "the point of the fixed facet", units.LENGTH)
    return float(x), float(y)
