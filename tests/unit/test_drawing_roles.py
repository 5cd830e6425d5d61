"""What lines of drawings are for: the user's word, the layer's name, the colour."""

import math
import warnings
from pathlib import Path
from typing import Any

import pytest
from PIL import ImageColor

import lamc
from lamc.basics.errors import DesignError, DesignWarning
from lamc.readers.drawings.colours import colour_of, family_of
from lamc.readers.drawings.roles import layer_angle, layer_role, role_of
from lamc.records.card import NO_SHEET_OPTIONS, SheetOptions


@pytest.mark.parametrize(
    ("text", "role"),
    [
        ("#f00", "mountain"),
        ("RED", "mountain"),
        ("#ff0100", "mountain"),
        ("#ed1c24", "mountain"),  # printers' red
        ("rgb(0, 0, 255)", "valley"),
        ("rgb(0% 0% 100% / 50%)", "valley"),
        ("hsl(240deg, 100%, 50%)", "valley"),
        ("#0071bc", "valley"),
        ("#231f20", "border"),  # printers' black
        ("#000000ff", "border"),
        ("green", "cut"),
        ("#00a651", "cut"),
        ("#fff200", "flat"),
        ("fuchsia", "undriven"),
        ("#ec008c", "undriven"),
        ("#808080", None),
        ("white", None),
        ("orange", None),
        ("cyan", None),
        ("url(#a)", None),
        ("none", None),
        ("#ff00", "flat"),  # of four digits, the last is opacity
    ],
)
def test_colours_are_those_of_crease_patterns(text: str, role: str | None) -> None:
    found = role_of(text, "", NO_SHEET_OPTIONS)
    assert found == role


def test_what_is_no_colour_is_none_and_never_black() -> None:
    for text in ("", "foo", "#ggg", "#12", "rgb(", "rgb(1)", "rgb(a,b,c)", "hsl(nan,1,1)", "rgb(1e9999,0,0)"):
        assert colour_of(text) is None
    assert family_of((255, 1, 0)) == ("red", True)
    assert family_of((237, 28, 36)) == ("red", False)


@pytest.mark.parametrize(
    ("name", "role", "degrees"),
    [
        ("Mountain", "mountain", None),
        ("mountain folds", "mountain", None),
        ("hinge_mountain_90", "mountain", -90.0),
        ("valley-30", "valley", 30.0),
        ("valley 2", "valley", None),  # the second one
        ("fold(-45)", "hinge", -45.0),
        ("folds", "hinge", None),
        ("joint_12", "hinge", None),
        ("Bodies", "border", None),
        ("cuts", "cut", None),
        ("facet creases", "flat", None),
        ("TITLE BLOCK", "ignore", None),
        ("0", None, None),
        ("Layer 1", None, None),
        ("1_holes", "hole", None),  # cutters run layers by their numbers
        ("2_slits", "cut", None),
        ("3_outline", "border", None),
        ("4_reference", "ignore", None),
        ("valley_+5", "valley", 5.0),
        ("2", None, None),
        ("", None, None),
    ],
)
def test_layers_have_the_usual_names(name: str, role: str | None, degrees: float | None) -> None:
    assert layer_role(name) == role
    angle = layer_angle(name)
    assert angle == (None if degrees is None else pytest.approx(math.radians(degrees)))


def test_the_user_says_more_than_the_layer_and_the_layer_more_than_the_colour() -> None:
    assert role_of("#00f", "mountain", NO_SHEET_OPTIONS) == "mountain"
    assert role_of("#00f", "mountain", SheetOptions(roles={"Mountain": "cut"})) == "cut"
    assert role_of("#00f", "mountain", SheetOptions(roles={"blue": "hole"})) == "hole"
    # Of folds in general the colour says which; where it says nothing, they rest flat.
    assert role_of("#00f", "folds", NO_SHEET_OPTIONS) == "valley"
    assert role_of("#000", "folds", NO_SHEET_OPTIONS) == "hinge"
    # A colour that is near one that the user names has its role; the one named itself comes first.
    assert role_of("#ed1c24", "", SheetOptions(roles={"red": "cut"})) == "cut"
    assert role_of("#ed1c24", "", SheetOptions(roles={"red": "cut", "#ed1c24": "hole"})) == "hole"
    assert role_of("#808080", "", SheetOptions(roles={"gray": "hinge"})) == "hinge"


def test_names_of_colours_are_read_after_pillow_has_read_them() -> None:
    for name in ("black", "red", "rebeccapurple"):
        ImageColor.getrgb(name)  # which changes Pillow's table of names
        colour_of.cache_clear()
        assert colour_of(name) == (ImageColor.getrgb(name), 1.0)


def test_layers_are_said_by_the_names_that_layers_have(tmp_path: Path) -> None:
    """`layers` of `lamc.load`: "outline" is the role border, as it is of a layer of that name."""
    group = '<g id="{}" fill="none" stroke="white"><path d="{}"/></g>'
    drawn = group.format("RIM", "M0 0H40V20H0Z") + group.format("LINE", "M20 0V20")
    svg = f'<svg xmlns="http://www.w3.org/2000/svg" width="40mm" height="20mm" viewBox="0 0 40 20">{drawn}</svg>'
    file = tmp_path / "part.svg"
    file.write_text(svg, encoding="utf-8")
    options: dict[str, Any] = {"card": lamc.Card(), "crease": 1e-3}
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DesignWarning)
        by_role = lamc.load(file, roles={"RIM": "border", "LINE": "valley"}, **options)
        assert lamc.load(file, layers={"RIM": "outline", "LINE": "valley fold"}, **options) == by_role
        assert lamc.load(file, layers={"RIM": "Outlines"}, roles={"LINE": "valley"}, **options) == by_role
    assert isinstance(by_role, lamc.Mechanism)
    assert len(by_role.joints) == 1
    for layers, message in (
        ({"RIM": "outlin"}, "the role of 'RIM' is 'outlin'; roles are border"),
        ({"RIM": 3}, "the role of 'RIM' is 3"),
        (["RIM"], "layers is .*it must map layers"),
        ({"RIM": "border"}, "roles is .*it must map"),
        ({"LINE": "cut"}, "roles and layers both say what 'LINE' is for"),
    ):
        roles: Any = ["LINE"] if message.startswith("roles is") else {"LINE": "valley"}
        with pytest.raises(DesignError, match=message):
            lamc.load(file, layers=layers, roles=roles, **options)  # type: ignore[arg-type]
