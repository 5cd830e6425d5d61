"""What the shapes of an SVG are for, and at which angles its creases rest; what of it is told.

In: styles. Out: roles, layers, angles; notes of colours that are for nothing, or are near to one of the convention.
"""

import math
from collections.abc import Sequence

from lamc.readers.drawings.colours import Colour, colour_of, family_of, shown_colour
from lamc.readers.drawings.notes import Notes
from lamc.readers.drawings.roles import (
    angle_note,
    check_roles,
    colour_role,
    counted_note,
    layer_angle,
    layer_role,
    lettered_layer,
    role_of,
    said_role,
)
from lamc.readers.drawings.svg_style import Style
from lamc.records.card import SheetOptions
from lamc.records.drawing import Role

_SIGNS = {"mountain": -1.0, "valley": 1.0}


class ShapeRoles:
    """Of one drawing; `notes` grows."""

    def __init__(self, options: SheetOptions, notes: Notes) -> None:
        check_roles(options)
        self.options, self.notes = options, notes
        self._said = {name.strip().casefold() for name in options.roles or ()}
        self._seen: set[str] = set()  # colours and layers
        self._angled: dict[str, float] = {}  # rad, by layers whose names say it
        self._counted: dict[str, str] = {}  # notes, by layers

    def of_stroke(self, style: Style, source: str) -> tuple[Role | None, str]:
        """Role and layer of a shape with a stroke; None: it is for nothing."""
        assert style.stroke is not None
        colour, layer = shown_colour(style.stroke), self._layer(style.layers)
        self._seen |= {colour, layer.casefold()}
        role = role_of(colour, layer, self.options)
        if said_role(colour, layer, self.options) is None:
            self._tell(role, style.stroke, layer, source)
        return (None if role == "ignore" else role), layer

    def _tell(self, role: Role | None, stroke: Colour, layer: str, source: str) -> None:
        """What nobody said of a line with a stroke."""
        colour, family = shown_colour(stroke), family_of(stroke)
        of_layer, of_colour = layer_role(layer), colour_role(colour)
        if role is None:
            self.notes.add(
                f"is left out: its colour {colour} is for nothing (--role '{colour}=cut' says what for)",
                source,
            )
        elif role == "ignore":
            self.notes.add(
                f"is left out: its layer {layer[:40]!r} is for nothing (--role '{layer[:40]}=cut' says what for)",
                source,
            )
        elif of_layer is None and (meant := lettered_layer(layer)) is not None:
            self.notes.add(
                f"is on the layer {layer[:40]!r}: {role}, by its colour; if the layer is to be {meant!r}, name it so",
                source,
            )
        elif of_layer is not None and of_colour not in (None, role, "border"):
            self.notes.add(
                f"is on the layer {layer[:40]!r}: {role}, whatever its colour {colour} (--role '{layer[:40]}=…' says "
                "another)",
                source,
            )
        elif role == of_colour and role != of_layer and family is not None and not family[1]:
            self.notes.add(
                f"is of the colour {colour}, taken for {family[0]}: {role} (--role '{colour}=…' says another)",
                source,
            )

    def of_fill(self, style: Style, source: str, *, is_silhouette: bool) -> tuple[Role | None, str]:
        """The same of a shape without a stroke: as its layer or the user says, else nothing; a drawing that has nothing
        else is of silhouettes."""
        layer = self._layer(style.layers)
        if style.unread and not (is_silhouette and style.fill is not None):
            return self._of_unread(style, layer, source), layer
        if style.fill is None:
            self.notes.add("is left out: it has neither stroke nor fill", source)
            return None, layer
        colour = shown_colour(style.fill)
        self._seen |= {colour, layer.casefold()}
        role = said_role(colour, layer, self.options) or layer_role(layer)
        if role is None and is_silhouette and role_of(colour, layer, self.options) is not None:
            stroke = "a stroke without a colour" if style.unread else "no stroke"
            self.notes.add(f"is filled and has {stroke}: its rim is taken for an outline", source)
            return "border", layer
        if role is None:
            self.notes.add(
                f"is left out: it is filled with {colour} and has no stroke (--role '{colour}=border' says what its "
                "rim is for)",
                source,
            )
        return (None if role == "ignore" else role), layer

    def _of_unread(self, style: Style, layer: str, source: str) -> Role | None:
        """What a shape is for whose stroke is no colour: only its layer may say."""
        colour = shown_colour(style.fill) if style.fill is not None else None
        self._seen |= {layer.casefold()} | ({colour} if colour is not None else set())
        role = said_role(colour, layer, self.options) or layer_role(layer)
        if role is None:
            why = (
                ", as a gradient or pattern has no colour" if style.unread.lower().startswith("url(") else ""
            )
            also = f", or say what its layer is for (--role '{layer[:40]}=cut')" if layer else ""
            self.notes.add(
                f"is left out: its stroke '{style.unread[:40]}' is not understood{why}; write a colour, such as "
                f"stroke='#ff0000'{also}",
                source,
            )
        return None if role == "ignore" else role

    def angle(self, role: Role, layer: str, opacity: float) -> float | None:
        """rad, where a crease rests; None where the drawing does not say."""
        if role == "hinge":
            named = layer_angle(layer)
            if named is not None:
                self._angled[layer] = named
            elif (counted := counted_note(layer)) is not None:
                self._counted[layer] = counted
            return named
        if role not in _SIGNS:
            return None
        if opacity == 1.0:
            of_layer = layer_angle(layer)
            if of_layer is not None:
                self._angled[layer] = abs(of_layer) * _SIGNS[role]
                return self._angled[layer]
        return _SIGNS[role] * math.pi * opacity

    def tell(self) -> None:
        """Notes of angles that names say, and of roles that no line has."""
        for layer, angle in sorted(self._angled.items()):
            self.notes.say(angle_note(layer, angle))
        for _, counted in sorted(self._counted.items()):
            self.notes.say(counted)
        colours = {colour[0] for name in self._seen if (colour := colour_of(name)) is not None}
        families = {family[0] for colour in colours if (family := family_of(colour)) is not None}
        for name in self.options.roles or ():
            given = colour_of(name)
            family = family_of(given[0]) if given is not None else None
            by_colour = given is not None and (
                given[0] in colours or (family is not None and family[1] and family[0] in families)
            )
            if not by_colour and name.strip().casefold() not in self._seen:
                self.notes.say(f"no line is of the colour or layer {name[:40]!r} that a role is given for")

    def _layer(self, groups: Sequence[tuple[str, bool]]) -> str:
        """The layer of a shape: the innermost group that the user names, else one whose name says what its lines are
        for, else what a program calls a layer, else the outermost group."""
        inner = [(name, is_layer) for name, is_layer in groups[::-1]]
        of_user = [name for name, _ in inner if name.casefold() in self._said]
        named = [name for name, _ in inner if layer_role(name) is not None]
        layers = [name for name, is_layer in inner if is_layer]
        outermost = [groups[0][0]] if groups else [""]
        return [*of_user, *named, *layers, *outermost][0]
