"""How a shape of an SVG is drawn: what it says itself, what style sheets say, what groups hand down.

In: an element's declarations, and the style of what it lies in. Out: a `Style`.
"""

from dataclasses import dataclass, replace

from lamc.basics.checks import shown
from lamc.readers.drawings.colours import Colour, colour_of
from lamc.readers.drawings.notes import Notes
from lamc.readers.drawings.svg_css import Declarations
from lamc.readers.drawings.svg_tree import Element


@dataclass(frozen=True)
class Style:
    """What a shape has of its own and of the groups that it lies in.

    stroke, fill  colours; None for none
    unread        what is given as the stroke and is no colour; "" for a colour and for none
    current       of stroke and fill, those that are the `color` of whatever shape inherits them
    opacity       of the stroke, all groups' multiplied
    layers        names of the groups, outermost first; True for those that a program calls layers
    """

    stroke: Colour | None = None
    stroke_alpha: float = 1.0
    stroke_opacity: float = 1.0
    fill: Colour | None = (0, 0, 0)
    color: tuple[Colour, float] = ((0, 0, 0), 1.0)
    opacity: float = 1.0
    is_visible: bool = True
    layers: tuple[tuple[str, bool], ...] = ()
    unread: str = ""
    current: frozenset[str] = frozenset()

    @property
    def strength(self) -> float:
        return self.opacity * self.stroke_opacity * self.stroke_alpha


def styled(element: Element, above: Style, declared: Declarations, notes: Notes) -> Style | None:
    """The style of an element; None where it is not drawn at all."""
    said = {name: value.strip() for name, value in declared.items()}
    if said.get("display", "").lower() == "none":
        notes.add("is hidden (display: none)", element.source)
        return None
    for name in ("clip-path", "mask"):
        if said.get(name, "none").lower() != "none":
            notes.add(f"is drawn whole, its {name} is not applied", element.source)
    said = {name: value for name, value in said.items() if value.lower() != "inherit"}
    for name in ("opacity", "stroke-opacity"):
        if name in said and _share(said[name]) is None:
            notes.add(
                f"has the {name} {shown(said[name][:40])}, which is no number and says nothing",
                element.source,
            )
    share = _share(said.get("opacity", "1"))
    style = replace(above, opacity=above.opacity * (1.0 if share is None else share))
    color = _paint(said.get("color", ""), above.color)
    if color is not None:
        style = replace(style, color=color)
    paints = dict.fromkeys(style.current, _CURRENT) | {n: said[n] for n in ("stroke", "fill") if n in said}
    style = replace(style, current=frozenset(n for n, paint in paints.items() if paint.lower() == _CURRENT))
    if "stroke" in paints:
        stroke = _paint(paints["stroke"], style.color)
        unread = paints["stroke"] if stroke is None and paints["stroke"].lower() not in _NO_PAINT else ""
        paint, alpha = stroke if stroke is not None else (None, 1.0)
        style = replace(style, stroke=paint, stroke_alpha=alpha, unread=unread)
    if "fill" in paints:
        fill = _paint(paints["fill"], style.color)
        style = replace(style, fill=fill[0] if fill is not None else None)
    of_stroke = _share(said["stroke-opacity"]) if "stroke-opacity" in said else None
    if of_stroke is not None:
        style = replace(style, stroke_opacity=of_stroke)
    if "visibility" in said:
        style = replace(style, is_visible=said["visibility"].lower() == "visible")
    if element.tag in _NAMED and element.label and element.parent is not None:
        is_layer = element.get("inkscape:groupmode") == "layer"
        style = replace(style, layers=(*style.layers, (element.label, is_layer)))
    return style


_NO_PAINT = ("none", "transparent")
_CURRENT = "currentcolor"
_NAMED = frozenset(("g", "svg", "a", "use", "symbol"))


def _paint(text: str, current: tuple[Colour, float]) -> tuple[Colour, float] | None:
    """A colour and its opacity; None for none."""
    if text.lower() == _CURRENT:
        return current
    # What stands behind an address is drawn where there is no such gradient.
    if text.lower() in _NO_PAINT or text.lower().startswith("url("):
        return None
    return colour_of(text) if text else None


def _share(text: str) -> float | None:
    """An opacity, 0 to 1; None for what cannot be read, which changes nothing, as in CSS."""
    word = text.strip()
    try:
        value = float(word[:-1]) / 100.0 if word.endswith("%") else float(word)
    except ValueError:
        return None
    return min(max(value, 0.0), 1.0) if value == value else None
