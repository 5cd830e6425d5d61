"""What a Design must satisfy before it can be split. In: a Design. Out: nothing, or one DesignError that
names the offender. Front ends refuse most of this with line numbers already; designs are also written by
hand.
"""

import math
from collections.abc import Sequence

import shapely
from shapely.geometry import MultiPolygon

from lamc.basics.errors import DesignError, Place, TopologyError
from lamc.records.design import Design, HingeLine, HingeSet
from lamc.records.mechanism import checked_name


def check_design(design: Design) -> None:
    """Raises DesignError, or TopologyError where no hinge or no fixed region is drawn."""
    if not design.layers:
        raise DesignError(f"design {design.name!r} has no layers; give it at least one")
    if len(design.fixed) != len(design.layers):
        raise DesignError(
            f"design {design.name!r} has {len(design.layers)} layers and fixed regions for "
            f"{len(design.fixed)}; "
            "give one per layer, empty where nothing is held"
        )
    for index, (layer, fixed) in enumerate(zip(design.layers, design.fixed, strict=True)):
        what, place = f"layer {layer.name!r}", design.places.of("layers", index)
        _check_number(layer.thickness, f"the thickness of {what}", "m", positive=True, place=place)
        _check_number(layer.material.density, f"the density of {what}", "kg/m³", positive=False, place=place)
        _check_polygons(layer.geometry, what)
        _check_polygons(fixed, f"the fixed region in {what}")
    if all(layer.geometry.is_empty for layer in design.layers):
        raise DesignError(f"design {design.name!r} has no material in any layer; draw its outline")
    if all(region.is_empty for region in design.fixed):
        raise TopologyError(
            f"design {design.name!r} has no fixed region, so nothing holds it; draw one over the body "
            "that the world holds",
            design.places.of("fixed"),
        )
    if not any(hinge_set.lines for hinge_set in design.hinges):
        raise TopologyError(
            f"design {design.name!r} has no hinge lines, so nothing can move; draw at least one",
            design.places.of("hinges"),
        )
    for hinge_set in design.hinges:
        _check_set(hinge_set, len(design.layers))
    _check_hinge_names([line for hinge_set in design.hinges for line in hinge_set.lines])
    _check_repeated(design.hinges)
    _check_body_names(design)


def hinge_label(line: HingeLine) -> str:
    """How a message names a hinge line that has no name yet."""
    (x0, y0), (x1, y1) = line.line
    ends = f"from ({x0 * 1e3:.6g}, {y0 * 1e3:.6g}) to ({x1 * 1e3:.6g}, {y1 * 1e3:.6g}) mm"
    return f"hinge {line.name!r}" if line.name else f"the hinge line {ends}"


def known(place: Place) -> Place | None:
    """The place, or None where the drawing has none to give."""
    return place if place != Place() else None


def _check_set(hinge_set: HingeSet, count: int) -> None:
    for line in hinge_set.lines:
        what, place = hinge_label(line), known(line.place)
        if not all(math.isfinite(value) for end in line.line for value in end):
            raise DesignError(f"{what} has an end that is not finite; give it two ends in metres", place)
        if line.line[0] == line.line[1]:
            raise DesignError(f"{what} has no length; give it two different ends", place)
        _check_number(hinge_set.width, f"the width of {what}", "m", positive=True, place=place)
        if len(hinge_set.sublaminate) == 0:
            raise DesignError(
                f"{what} runs through no layers; list those that it cuts in its sublaminate", place
            )
        for index in (hinge_set.layer, *hinge_set.sublaminate):
            if not 0 <= index < count:
                raise DesignError(
                    f"{what} refers to layer {index}; the design has layers 0 to {count - 1}, bottom to top",
                    place,
                )


def _check_number(value: float, what: str, unit: str, *, positive: bool, place: Place | None = None) -> None:
    if not math.isfinite(value) or value < 0.0 or (positive and value == 0.0):
        rule = "greater than 0" if positive else "at least 0"
        raise DesignError(f"{what} is {value!r} {unit}; it must be finite and {rule}", place)


def _check_polygons(geometry: MultiPolygon, what: str) -> None:
    if not isinstance(geometry, MultiPolygon):
        raise DesignError(f"{what} is a {geometry.geom_type}; it must be a MultiPolygon")
    if not geometry.is_valid:
        raise DesignError(
            f"{what} is not a proper set of polygons: {shapely.is_valid_reason(geometry)}; draw "
            "outlines that do not "
            "cross themselves or each other"
        )


def _check_hinge_names(lines: Sequence[HingeLine]) -> None:
    seen: dict[str, HingeLine] = {}
    for line in lines:
        if line.name is None:
            continue
        checked_name(line.name, "a hinge")
        if line.name in seen:
            raise DesignError(f"two hinges are named {line.name!r}; names must differ", known(line.place))
        seen[line.name] = line


def _check_repeated(hinge_sets: Sequence[HingeSet]) -> None:
    """Each hinge line once in a layer, whichever way it runs."""
    seen: dict[tuple[int, frozenset[tuple[float, float]]], HingeLine] = {}
    for hinge_set in hinge_sets:
        for line in hinge_set.lines:
            first = seen.setdefault((hinge_set.layer, frozenset(line.line)), line)
            if first is not line:
                raise DesignError(
                    f"{hinge_label(line)} and {hinge_label(first)} are drawn on the same line; keep one of them",
                    known(line.place),
                )


def _check_body_names(design: Design) -> None:
    seen: set[str] = set()
    for each in design.body_names:
        checked_name(each.name, "a body")
        if each.name in seen:
            raise DesignError(f"two bodies are named {each.name!r}; names must differ")
        seen.add(each.name)
        if each.layer is not None and not 0 <= each.layer < len(design.layers):
            raise DesignError(
                f"the point that names body {each.name!r} refers to layer {each.layer}; the design has layers 0 "
                f"to {len(design.layers) - 1}, bottom to top"
            )
