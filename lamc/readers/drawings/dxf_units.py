"""What 1 is in a DXF file: by the user, by $INSUNITS where that can be true, else millimetres.

In: the header's variables and how large the drawing is. Out: m, and notes. Never: believes in a hinge 117 m wide.
"""

from typing import Any

from lamc.basics.errors import DesignError
from lamc.basics.units import LENGTH, to_si
from lamc.records.mechanism import Array

# Of a whole drawing, m. The smallest pop-up devices are some mm wide, and lasers cut no finer than 10 um, a fiftieth of
# this; beds of laser cutters and presses end at 3 m or so.
SMALLEST, LARGEST = 0.5e-3, 5.0
_UNITS = {  # $INSUNITS, AutoCAD's DXF Reference: a name that --units takes where it does, and m
    1: ("in", 0.0254),
    2: ("ft", 0.3048),
    3: ("mile", 1609.344),
    4: ("mm", 1e-3),
    5: ("cm", 1e-2),
    6: ("m", 1.0),
    7: ("km", 1e3),
    8: ("microinch", 2.54e-8),
    9: ("mil", 2.54e-5),
    10: ("yd", 0.9144),
    11: ("angstrom", 1e-10),
    12: ("nm", 1e-9),
    13: ("um", 1e-6),
    14: ("dm", 0.1),
    15: ("dam", 10.0),
    16: ("hm", 100.0),
    17: ("Gm", 1e9),
    18: ("astronomical unit", 1.495978707e11),
    19: ("light year", 9.4607304725808e15),
    20: ("parsec", 3.0856775814913673e16),
    21: ("US survey foot", 1200.0 / 3937.0),
    22: ("US survey inch", 100.0 / 3937.0),
    23: ("US survey yard", 3600.0 / 3937.0),
    24: ("US survey mile", 6336000.0 / 3937.0),
}
_IMPERIAL = frozenset((1, 2, 3, 8, 9, 10, 21, 22, 23, 24))
_LIKELY = (("mm", 1e-3), ("in", 0.0254), ("cm", 1e-2), ("m", 1.0), ("um", 1e-6))


def scale_of(header: Any, units: str | None, extent: Array, notes: list[str]) -> float:
    """m of 1 in the file.

    extent  (2,), of what is drawn, in the file's units

    Raises DesignError where the file says what cannot be true, or nothing and millimetres cannot be: which unit it is
    must then be said.
    """
    if units is not None:
        return to_si(f"1 {units}", LENGTH)
    width = float(max(extent))
    said = _UNITS.get(_number(header, "$INSUNITS") or 0)
    if said is None:
        if not _likely(width * 1e-3):
            what = f"the file says no unit ($INSUNITS), and in mm the drawing would be {_wide(width, 1e-3)}"
            raise _asked(what, width)
        imperial = _number(header, "$MEASUREMENT") == 0 and "$INSUNITS" in header
        system = "; $MEASUREMENT says imperial, and it may be drawn in inches" if imperial else ""
        notes.append(
            f"the file says no unit ($INSUNITS): 1 is taken for 1 mm, and the drawing is {_wide(width, 1e-3)}{system} "
            "(--units says another)"
        )
        return 1e-3
    name, scale = said
    if not _likely(width * scale):
        raise _asked(f"$INSUNITS says {name}, and the drawing would be {_wide(width, scale)}", width)
    return scale


def length_text(length: float) -> str:
    """A length with a unit that suits it."""
    for name, unit in (("km", 1e3), ("m", 1.0), ("mm", 1e-3), ("um", 1e-6)):
        if abs(length) >= unit:
            return f"{length / unit:.4g} {name}"
    return f"{1e3 * length:.4g} mm"


def _likely(width: float) -> bool:
    return SMALLEST <= width <= LARGEST


def _wide(width: float, scale: float) -> str:
    return f"{length_text(width * scale)} wide"


def _asked(what: str, width: float) -> DesignError:
    fits = [f"--units {name} ({_wide(width, unit)})" for name, unit in _LIKELY if _likely(width * unit)]
    ways = " or ".join(fits[:3]) if fits else "--units mm, or another,"
    return DesignError(f"{what}: {ways} says which it is")


def _number(header: Any, name: str) -> int | None:
    try:
        return int(header.get(name))
    except (TypeError, ValueError, KeyError):
        return None
