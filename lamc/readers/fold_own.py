"""What lamc writes into FOLD files beside the spec, so that the same device is read back.

In: fields "lamc:…" of a frame. Out: a checked record. Each is optional; the spec has other programs pass them over.
"""

import math
from dataclasses import dataclass
from typing import Any

from lamc.basics.checks import checked_name, checked_number, shown
from lamc.basics.errors import DesignError
from lamc.readers.fold_frames import Data
from lamc.records.card import Card

CARD, BODIES, FIXED, HINGES = "lamc:card", "lamc:faces_body", "lamc:fixed", "lamc:edges_hinge"
NUMBERS = {
    "stiffness": 0.0,
    "damping": 0.0,
    "rest_angle": -math.inf,
    "start_angle": -math.inf,
}  # the least of each; SI


@dataclass(frozen=True)
class Hinge:
    """N·m/rad, N·m·s/rad, rad, rad."""

    name: str
    stiffness: float
    damping: float
    rest_angle: float
    start_angle: float


@dataclass(frozen=True)
class Own:
    """card, names of bodies by face, those fixed, hinges by edge; None: not said."""

    card: Card | None
    bodies: tuple[str, ...] | None
    fixed: tuple[str, ...] | None
    hinges: tuple[Hinge | None, ...] | None


def own_of(data: Data, faces: int, edges: int) -> Own:
    """Raises DesignError for what lamc would not write."""
    bodies = _list(data, BODIES, faces, "faces")
    fixed = _list(data, FIXED)
    hinges = _list(data, HINGES, edges, "edges")
    return Own(
        own_card(data),
        bodies and tuple(checked_name(each, f"an entry of {BODIES}") for each in bodies),
        fixed and tuple(checked_name(each, f"an entry of {FIXED}") for each in fixed),
        hinges and tuple(None if each is None else _hinge(each) for each in hinges),
    )


def own_card(data: Data) -> Card | None:
    """The card that it says. Raises as `own_of`."""
    if CARD not in data:
        return None
    given = _map(data[CARD], CARD, ("thickness", "density"))
    return Card(given["thickness"], given["density"])


def _hinge(value: Any) -> Hinge:
    given = _map(value, HINGES, ("name", *NUMBERS))
    name = checked_name(given["name"], f"an entry of {HINGES}")
    numbers = {
        key: checked_number(given[key], f"{key} of hinge {name!r}", minimum=least)
        for key, least in NUMBERS.items()
    }
    return Hinge(name, **numbers)


def _map(value: Any, key: str, fields: tuple[str, ...]) -> dict[str, Any]:
    if not isinstance(value, dict) or not all(field in value for field in fields):
        raise DesignError(f"{key} has {shown(value)}; it must be a map of {', '.join(fields)}")
    return value


def _list(data: Data, key: str, length: int | None = None, of: str = "") -> Any:
    if key not in data:
        return None
    found = data[key]
    if not isinstance(found, list) or (length is not None and len(found) != length):
        raise DesignError(
            f"{key} must be a list{f' of {length}, one for each of the {of}' if length else ''}"
        )
    return found
