"""What can be varied: dimensions of a design, parameters of its model, starts, and how a run goes.

In: a design, or a family of them, and its simulator. Out: `Target`s by name, each with its unit and bounds, and
their values put to use. Raises RequestError for names and values that make no point.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import cast

from lamc.basics.checks import did_you_mean, shown
from lamc.basics.errors import RequestError
from lamc.basics.readonly import ReadOnlyDict
from lamc.records.design import Design
from lamc.records.family import Family
from lamc.records.mechanism import Mechanism
from lamc.records.scene import Scene
from lamc.run.parameters import bounds
from lamc.run.simulator import Simulator
from lamc.studies.axes import Axis

Made = Design | Mechanism
Studied = Made | Family[Design] | Family[Mechanism]

OPTIONS: Mapping[str, str] = {"t_end": "s", "rtol": "1", "atol": "1", "max_step": "s"}
ANGLES, RATES = "angles.", "rates."


@dataclass(frozen=True)
class Target:
    """kind: "dimension", "angle", "rate", "parameter" or "option"; unit: SI; minimum and maximum: None where nothing is
    said. A point that is another in kinds of `SLOW` takes another simulator."""

    name: str
    kind: str
    unit: str
    default: float | None = None
    minimum: float | None = None
    maximum: float | None = None
    meaning: str = ""


SLOW = ("dimension", "angle", "rate")


def family_of(design: object) -> Studied:
    """What is studied: a function becomes the family of what it gives. Raises RequestError for what cannot be."""
    if isinstance(design, Design | Mechanism | Family):
        return design
    if not callable(design):
        raise RequestError(
            f"the design is {shown(design)}; it must be a Design, a Mechanism, or a function that gives one"
        )
    return Family(design)


def made(design: Studied, dimensions: Mapping[str, float]) -> Made:
    """The design with other dimensions."""
    if isinstance(design, Family) or dimensions:
        return design.with_parameters(dimensions)
    return design


def targets_of(design: Studied, simulator: Simulator) -> dict[str, Target]:
    """All that can be varied, by name. Raises RequestError where one name means two things."""
    found = {
        name: Target(name, "dimension", each.unit, each.default, each.minimum, each.maximum, each.meaning)
        for name, each in design.parameters.items()
    }
    others = [Target(f"{ANGLES}{joint}", "angle", "rad") for joint in simulator.joints]
    others += [Target(f"{RATES}{joint}", "rate", "rad/s") for joint in simulator.joints]
    for name, default in simulator.parameters.items():
        least, _, most = bounds(name)
        unit = simulator.parameter_units[name]
        others.append(Target(name, "parameter", unit, default, least, most))
    others += [Target(name, "option", unit, minimum=0.0) for name, unit in OPTIONS.items()]
    for each in others:
        if each.name in found:
            raise RequestError(
                f"{each.name!r} names a dimension of the design, and of its runs the {each.kind} {each.name!r} too; "
                "rename the dimension"
            )
        found[each.name] = each
    return found


def check_axes(axes: Mapping[str, Axis], targets: Mapping[str, Target]) -> None:
    """Raises RequestError for values outside of what their target can have."""
    for name, axis in axes.items():
        check_within(targets[name], *axis.extremes)


def check_within(target: Target, least: float, most: float) -> None:
    """Raises RequestError unless a target can have values from `least` to `most`; infinite ones tell nothing."""
    for value, bound, is_out, word in (
        (least, target.minimum, least < (target.minimum or 0.0), "least"),
        (most, target.maximum, most > (target.maximum or 0.0), "most"),
    ):
        if bound is not None and is_out and abs(value) != float("inf"):
            unit = "" if target.unit == "1" else f" {target.unit}"
            raise RequestError(
                f"vary {target.name!r}: {value:g}{unit} is out of bounds; the {word} is {bound:g}{unit}"
            )


def known_target(name: object, targets: Mapping[str, Target]) -> Target:
    """The target of a name, or RequestError with the nearest."""
    if name not in targets:
        hint = did_you_mean(str(name), list(targets))
        raise RequestError(f"nothing that can be varied is named {shown(name)}; {hint}")
    return targets[cast("str", name)]


def started(scene: Scene, angles: Mapping[str, float], rates: Mapping[str, float]) -> Scene:
    """The scene with other angles, rad, and rates, rad/s, of some joints at the start."""
    if not angles and not rates:
        return scene
    return replace(
        scene,
        angles=ReadOnlyDict({**scene.angles, **angles}),
        rates=ReadOnlyDict({**scene.rates, **rates}),
    )
