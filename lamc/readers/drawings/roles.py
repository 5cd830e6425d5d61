"""What a line is for: by what the user says, by the name of its layer, by its colour.

In: a colour and a layer's name as the file writes them, and the user's options. Out: a `Role`, or None where nothing
tells. The colours are those of Origami Simulator (Amanda Ghassaei): red mountain, blue valley, black border, green cut,
yellow a crease that stays flat, magenta a hinge without a spring.
"""

import difflib
import math
import re
from functools import lru_cache

from lamc.basics.errors import DesignError
from lamc.readers.drawings.colours import colour_of, family_of
from lamc.records.card import SheetOptions
from lamc.records.drawing import Role

COLOURS: dict[str, Role] = {
    "red": "mountain",
    "blue": "valley",
    "black": "border",
    "green": "cut",
    "yellow": "flat",
    "magenta": "undriven",
}
_CREASES: frozenset[Role] = frozenset(("mountain", "valley", "flat", "undriven"))
# Names of layers, singular, in lower case; words are parted by one space. "…fold" and "…crease" are added below.
_LAYERS: dict[Role, tuple[str, ...]] = {
    "border": (
        "border",
        "boundary",
        "outline",
        "body",
        "contour",
        "profile",
        "perimeter",
        "rim",
        "outer",
    ),
    "hole": ("hole", "cutout", "cut out", "window", "opening", "inner"),
    "cut": ("cut", "cutting", "cut line", "cutline", "slit", "laser cut", "through cut", "kerf"),
    "hinge": ("hinge", "joint", "flexure", "living hinge", "hinge line", "joint line"),
    "mountain": ("mountain", "hinge mountain", "mountain hinge", "m"),
    "valley": ("valley", "hinge valley", "valley hinge", "v"),
    "undriven": (
        "undriven",
        "free",
        "free hinge",
        "hinge free",
        "undriven hinge",
        "hinge undriven",
        "unassigned",
    ),
    "flat": ("flat", "facet", "facet crease", "triangulation", "hinge flat"),
    "ignore": (
        *("ignore", "text", "dimension", "dim", "annotation", "guide", "guide line", "note", "construction"),
        *(
            "reference",
            "title",
            "title block",
            "legend",
            "defpoint",
            "label",
            "comment",
            "engrave",
            "engraving",
        ),
    ),
}
# Their colours say which way they fold; other colours, and none, leave them sprung and flat.
_FOLDS = ("fold", "crease", "fold line", "crease line", "score", "score line", "bend", "bend line")
_JOINTS = _LAYERS["hinge"]  # laminates number them: degrees stand in brackets there, or with their unit
_LETTERS = ("m", "v")  # by themselves, or with degrees, "M(90)": M3 is a screw, and v2 a version
_FEWEST_DEGREES = 10.0
_BY_NAME: dict[str, Role] = {name: role for role, names in _LAYERS.items() for name in names}
for _role in ("mountain", "valley", "undriven", "flat"):
    for _word in ("fold", "crease"):
        _BY_NAME |= {f"{_role} {_word}": _role, f"{_word} {_role}": _role}
_WITH_NUMBER = re.compile(
    r"(.*?[^0-9.+-])[\s_(=-]*?([+-]?[0-9]+(?:\.[0-9]*)?)\s*(?:°|deg|degrees)?\)?\Z", re.DOTALL
)

_BY_NAME_SAID = ", as its name says"
_COPY = re.compile(r"(?<![a-z])copy[\s_-]*[0-9]*\Z", re.IGNORECASE)  # of a layer: "mountain 45 copy 2"


def role_of(colour: str | None, layer: str, options: SheetOptions) -> Role | None:
    """What a line is for; None where neither user nor layer nor colour says.

    colour  in any notation of CSS, "#ff0000"; None for no colour of its own
    layer   its layer or group; "" for none

    The user's word comes first, of the layer and then of the colour; then the layer's name, then the colour. Layers of
    folds in general leave it to the colour which way they fold.
    """
    said = said_role(colour, layer, options)
    if said is not None:
        return said
    of_colour = colour_role(colour)
    if layer_name(layer) in _FOLDS:
        return of_colour if of_colour in _CREASES else "hinge"
    return layer_role(layer) or of_colour


def meant_layer(name: str) -> str | None:
    """The known name that an unknown one is nearly, "joint" for "jonit", "M(45)" for "M_45"; None for a known one, and
    for all others."""
    word = layer_name(name)
    if layer_role(name) is not None:
        return None
    lettered = lettered_layer(name)
    if lettered is not None or len(word) < 3:
        return lettered
    near = difflib.get_close_matches(word, [*_BY_NAME, *_FOLDS], 1, 0.75)
    return near[0] if near else None


def lettered_layer(name: str) -> str | None:
    """ "M(45)", for a layer "M_45", which is no mountain, as M3 is a screw; None for any other."""
    letter, _, number = layer_name(name).partition(" ")
    return f"{letter.upper()}({number.lstrip('+-')})" if letter in _LETTERS and number else None


def layer_role(name: str) -> Role | None:
    """What lines of a layer of this name are for, whatever their colour: "hinge_mountain_90" are mountains."""
    word = layer_name(name)
    return "hinge" if word in _FOLDS else _BY_NAME.get(word)


def layer_angle(name: str) -> float | None:
    """rad, where creases of a layer of this name rest: the degrees at its end, "mountain_90", "fold(-45)".

    A small bare number, "mountain 2" or "mountain-2", counts layers and is no angle.
    """
    role, word, name = layer_role(name), layer_name(name), _bare(name)
    found = _WITH_NUMBER.match(name)
    if found is None or role not in ("mountain", "valley", "hinge"):
        return None
    if word in _JOINTS and not _is_marked(name):
        return None
    degrees = float(found[2])
    # A hyphen amid the name parts it from a number, as programs write spaces and number copies.
    before = name[found.start(2) - 1]
    signed = found[2][0] == "+" or (found[2][0] == "-" and not before.isalnum())
    bare = name[-1].isdigit() and not signed
    if abs(degrees) > 180.0 or (bare and abs(degrees) < _FEWEST_DEGREES):
        return None
    if role == "hinge":
        return math.radians(degrees)
    # A hyphen before the number may part it from the name or be a sign; nothing hangs on it here.
    return math.radians(-abs(degrees) if role == "mountain" else abs(degrees))


def counted_note(name: str) -> str | None:
    """That a number at the end of a layer of hinges, which may be meant for degrees, counts layers; None where there is
    no such number."""
    found = _WITH_NUMBER.match(_bare(name))
    if found is None or layer_name(name) not in _JOINTS or layer_angle(name) is not None:
        return None
    if not _FEWEST_DEGREES <= abs(float(found[2])) <= 180.0:
        return None
    return (
        f"creases on layer {name[:60]!r} rest flat: a number behind joint or hinge counts layers; "
        f"{f'{layer_name(name)}({found[2]})'!r} is one of degrees"
    )


def _is_marked(name: str) -> bool:
    """Whether the number at a name's end is one of degrees, and counts nothing: it has its unit, or is in brackets and
    not small, as programs name copies "hinge (2)"."""
    found = _WITH_NUMBER.match(name)
    if found is None:
        return False
    after = name[found.end(2) :].strip(" )")
    return bool(after) or (name.endswith(")") and abs(float(found[2])) >= _FEWEST_DEGREES)


def angle_note(layer: str, angle: float) -> str:
    """That the name of a layer says the angle, rad, of its creases."""
    return f"creases on layer {layer[:60]!r} rest at {math.degrees(angle):.6g} degrees{_BY_NAME_SAID}"


def is_angle_note(note: str) -> bool:
    """Whether a line is one of `angle_note`."""
    return note.endswith(_BY_NAME_SAID)


def colour_role(colour: str | None) -> Role | None:
    """What lines of a colour are for by the convention of crease patterns, nearly that colour included."""
    found = colour_of(colour) if colour is not None else None
    family = family_of(found[0]) if found is not None else None
    return COLOURS[family[0]] if family is not None else None


@lru_cache(4096)
def layer_name(name: str) -> str:
    """A layer's name as the table has it: in lower case, singular, without a number or sign at its end, or a number
    before it, by which cutters order layers: 3_outline."""
    name = _bare(name)
    found = _WITH_NUMBER.match(name)
    words = re.findall(r"[^\W_]+", (found[1] if found else name).lower())
    if len(words) > 1 and words[0].isdigit():
        words.pop(0)
    if words and words[-1] in ("layer", "layers"):
        words.pop()
    joined = " ".join(words)
    each = " ".join(word.removesuffix("s") for word in words)  # "folds mountain"
    if joined in _LETTERS and found is not None and not _is_marked(name):
        return f"{joined} {found[2]}"
    for singular in (joined, joined.removesuffix("s"), joined.removesuffix("es"), each):
        if (singular in _BY_NAME and (singular == joined or singular not in _LETTERS)) or singular in _FOLDS:
            return singular
    return "body" if joined == "bodies" else joined


def _bare(name: str) -> str:
    """A layer's name without what says that it is a copy."""
    bare = _COPY.sub("", name.strip())
    return bare.rstrip(" \t_-") if bare != name.strip() else bare


def check_roles(options: SheetOptions) -> None:
    """Raises DesignError where the user says two things of one colour or layer."""
    said: dict[object, tuple[str, Role]] = {}
    for name, role in (options.roles or {}).items():
        colour = colour_of(name)
        for key in (name.strip().casefold(), *([colour[0]] if colour is not None else [])):
            other = said.setdefault(key, (name, role))
            if other[1] != role:
                raise DesignError(
                    f"roles say two things of one colour or layer: {other[0][:40]!r} is {other[1]}, and {name[:40]!r} "
                    f"is {role}; leave one out"
                )


def said_role(colour: str | None, layer: str, options: SheetOptions) -> Role | None:
    """What the user says of a layer, of a colour, or of the colour that it is near."""
    roles = options.roles
    if not roles:
        return None
    for name, role in roles.items():
        if layer and name.strip().casefold() == layer.strip().casefold():
            return role
    own = colour_of(colour) if colour is not None else None
    if own is None:
        return None
    named = {given[0]: role for name, role in roles.items() if (given := colour_of(name)) is not None}
    if own[0] in named:
        return named[own[0]]
    family = family_of(own[0])
    for given_colour, role in named.items():
        if family is not None and family_of(given_colour) == (family[0], True):
            return role
    return None
