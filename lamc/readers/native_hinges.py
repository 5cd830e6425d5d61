"""What native designs say and may not mean, and what follows for hinges: names, stiffness from material.

In: the schema's models, a design. Out: names, warnings, the design with every stiffness.
"""

from collections.abc import Sequence
from functools import partial

from lamc.basics.errors import warn
from lamc.design.cutting import material_size
from lamc.readers.checking import Path, Problems, shown
from lamc.readers.schema import HingeModel
from lamc.records.design import Design
from lamc.records.mechanism import checked_name
from lamc.records.scene import is_bare, warn_of_degrees

_LARGE = 5.0  # m: no laminate is drawn as wide, but one in millimetres without its unit


def line_names(hinge: HingeModel, count: int) -> list[str | None]:
    """One name per line: the hinge's own, numbered where it has several lines."""
    if hinge.name is None or count == 1:
        return [hinge.name] * count
    return [f"{hinge.name}_{i}" for i in range(1, count + 1)]


def check_line_names(names: Sequence[str | None], seen: set[str], path: Path, problems: Problems) -> None:
    """Adds a problem for each name that is none, or was seen before."""
    for name in [name for name in names if name is not None]:
        problems.attempt((*path, "name"), partial(checked_name, name, "a hinge"))
        if name in seen:
            problems.add((*path, "name"), f"two hinges are named {name!r}; names must differ")
        seen.add(name)


def stiffened(design: Design, hinges: Sequence[HingeModel], problems: Problems) -> Design:
    """With the stiffness of hinges that ask for it from their material. Raises DesignErrors where it has no moduli."""
    asked = next((i for i, hinge in enumerate(hinges) if isinstance(hinge.stiffness, str)), None)
    if asked is None:
        return design
    from lamc.plates.designs.hinges import with_material_stiffness  # a tenth of a second, for few designs

    found = problems.attempt(
        ("hinges", asked, "stiffness"), lambda: with_material_stiffness(design, only_asked=True)[0]
    )
    problems.raise_if_any()
    assert found is not None
    return found


def tell_old_names(hinges: Sequence[HingeModel], problems: Problems) -> None:
    """One warning for all hinges that say width in place of gap."""
    old = [(i, hinge.width) for i, hinge in enumerate(hinges) if hinge.width is not None]
    if not old:
        return
    index, width = old[0]
    others = f" and {len(old) - 1} more" if len(old) > 1 else ""
    warn(
        f"hinges[{index}]{others}: width is gap now, from board to board, which is twice as much: write "
        f"gap: {2e3 * width:.6g} mm",
        problems.place(("hinges", index, "width")),
    )


def check_angles(hinges: Sequence[HingeModel], problems: Problems) -> None:
    """Warns of rest angles and limits of more than a turn that are written without a unit."""
    for index, hinge in enumerate(hinges):
        path: Path = ("hinges", index)
        said: list[tuple[float, Path, str]] = [(hinge.rest_angle, (*path, "rest_angle"), "rest_angle")]
        said += [(limit, (*path, "limits", k), "limits") for k, limit in enumerate(hinge.limits or ())]
        for value, at, name in said:
            if is_bare(problems.text(at)):
                warn_of_degrees(value, f"{shown(path)}.{name}", problems.place(at))


def check_size(design: Design, unit: str | None) -> None:
    """Warns of a drawing of metres that names no unit: its numbers are millimetres, most likely."""
    size = material_size(design.layers) if unit is None and design.layers else 0.0
    if size > _LARGE:
        warn(
            f"the design names no units, so its lengths are metres, and the drawing is {size:.3g} m wide: write "
            "units: mm if they are millimetres, units: m if not",
            design.places.of(),
        )
