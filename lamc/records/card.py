"""What a sheet is of that a drawing of lines does not say: its card, how stiff its creases are, what holds it.

In: numbers, SI, or text with units. Out: checked records. Never: reads a file.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, fields
from typing import Any, Literal, get_args

from lamc.basics import units
from lamc.basics.checks import checked_array, checked_kind, checked_number, is_list, shown
from lamc.basics.errors import DesignError
from lamc.basics.given import GivenMaybe, GivenNumber
from lamc.basics.units import is_quantity
from lamc.records.drawing import ROLES, Role
from lamc.records.scene import is_bare

_MOST = 1e6  # m, kg/m³: of no card; its bending stiffness goes with the cube
_THICK = 0.02  # m: a sheet that is thicker was meant in mm


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
            if not 0.0 < value < _MOST:
                raise DesignError(
                    f"the {name} of the card is {value:g} {quantity.unit}; it must be above 0 and below {_MOST:g}"
                )
            object.__setattr__(self, name, value)

    @staticmethod
    def of(text: str) -> "Card":
        """The card of "0.3 mm, 700 kg/m^3". Raises DesignError for other text."""
        parts = [part.strip() for part in text.split(",")]
        if len(parts) != 2:
            raise DesignError(f"the card is {shown(text)}; write thickness and density: '0.3 mm, 700 kg/m^3'")
        card = Card(*parts)
        if card.thickness > _THICK and is_bare(parts[0]):
            raise DesignError(
                f"the card is {card.thickness:g} m thick: numbers without a unit are m; write '{parts[0]} mm, "
                f"{parts[1]}', or '{parts[0]} m, {parts[1]}' if that is meant"
            )
        return card


Facets = Literal["rigid", "bend"]
Fixed = str | tuple[float, float]  # a facet, by its name or a point inside it, m


@dataclass(frozen=True)
class SheetOptions:
    """What a user says of a drawn sheet beside its file; None: what the file says, else a default that is told.

    fixed   name of the facet that is held, "F12", or a point inside it, (x, y), m; or a list of such
    card    of all facets
    crease  N·m/rad for each m of a crease
    units   of the drawing's numbers, "mm"
    roles   what lines of a colour ("#ff0000", "red") or a layer are for, of an SVG or DXF drawing: see `Role`
    heal    m, how far ends of lines may be off and are mended; 0: nothing is mended
    facets  "rigid", or "bend" along diagonals and flat lines; None: they bend where rigid ones do not fold,
            or close only nearly
    large   more facets are read than take some seconds
    """

    fixed: Fixed | Sequence[Fixed] | None = None
    card: Card | None = None
    crease: GivenMaybe = None  # type: ignore[assignment]  # N/rad
    units: str | None = None
    roles: Mapping[str, Role] | None = None
    heal: GivenMaybe = None  # type: ignore[assignment]  # m
    facets: Facets | None = None
    large: bool = False

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
        if self.roles is not None:
            object.__setattr__(self, "roles", _checked_roles(self.roles))
        if not isinstance(self.large, bool):
            raise DesignError(f"large is {shown(self.large)}; it must be True or False")
        if self.facets is not None and self.facets not in get_args(Facets):
            raise DesignError(f"facets is {shown(self.facets)}; it must be 'rigid' or 'bend'")
        if self.heal is not None:
            heal = checked_number(self.heal, "the tolerance of healing", minimum=0.0, quantity=units.LENGTH)
            object.__setattr__(self, "heal", heal)
        if self.fixed is not None:
            object.__setattr__(self, "fixed", _fixed(self.fixed))

    @property
    def held(self) -> tuple[Fixed, ...]:
        """What `fixed` says, one by one."""
        return self.fixed if isinstance(self.fixed, tuple) else ()

    @property
    def given(self) -> tuple[str, ...]:
        """Names of what is given of a sheet alone."""
        names = [each.name for each in fields(self) if each.name != "large"]
        return tuple(name for name in names if getattr(self, name) is not None)


NO_SHEET_OPTIONS = SheetOptions()


def _checked_roles(roles: Any) -> dict[str, Role]:
    if not isinstance(roles, Mapping):
        raise DesignError(f"roles is {shown(roles)}; it must map colours or layers to what they are for")
    for name, role in roles.items():
        if not isinstance(name, str) or role not in ROLES:
            raise DesignError(f"the role of {shown(name)} is {shown(role)}; roles are {', '.join(ROLES)}")
    return dict(roles)


def fixed_of(text: str) -> str | tuple[float, float]:
    """A facet's name, or the point of "10 mm, 20 mm". Raises DesignError for a point that is none."""
    return _point([part.strip() for part in text.split(",")]) if "," in text else text


def roles_of(texts: Iterable[str]) -> dict[str, Any]:
    """Roles by line of "red=cut" and the like; not checked yet. Raises DesignError where there is no "="."""
    roles = {}
    for text in texts:
        line, equals, role = text.rpartition("=")
        if not equals or not line.strip():
            raise DesignError(f"the role is {shown(text)}; write a colour or a layer and a role: red=cut")
        roles[line.strip()] = role.strip()
    return roles


def _fixed(value: Any) -> tuple[Fixed, ...]:
    """Names and points, of one or of several."""
    if isinstance(value, str):
        return (value,)
    several = is_list(value) and len(value) > 0
    if several and any(is_list(each) or (isinstance(each, str) and not is_quantity(each)) for each in value):
        return tuple(each if isinstance(each, str) else _point(each) for each in value)
    return (_point(value),)


def _point(value: Any) -> tuple[float, float]:
    if not is_list(value) or len(value) != 2:
        raise DesignError(
            f"fixed is {shown(value)}; it must be the name of a facet, such as 'F12', or a point (x, y), m"
        )
    x, y = checked_array(value, (2,), "the point of the fixed facet", units.LENGTH)
    return float(x), float(y)
