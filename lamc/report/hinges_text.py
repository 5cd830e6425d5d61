"""Where the stiffness of hinges comes from, as plain text and as plain data.

In: the account of each hinge. Out: a table for a terminal, and a list of dictionaries for JSON, SI. It prints nothing.
"""

from collections.abc import Sequence
from typing import TYPE_CHECKING

from lamc.basics.numbers import length_text
from lamc.design.cutting import SLIT
from lamc.report.split_text import names, short_name, table

if TYPE_CHECKING:
    from lamc.design.steps import Hinge
    from lamc.plates.designs.hinges import MaterialHinge


def cut_lines(hinges: "Sequence[Hinge]") -> str:
    """A line for each gap that is drawn: what is slit and what bends, and whose it is."""
    named: dict[float, list[str]] = {}
    for hinge in hinges:
        named.setdefault(hinge.properties.gap, []).append(short_name(hinge.name))
    lines = []
    for gap, joints in sorted(named.items()):
        whose = "all hinges" if len(named) == 1 else names(joints)
        lines.append(
            f"gap {length_text(gap)} of {whose}: so much film bends, from board to board; a slit of "
            f"{length_text(SLIT * gap)} is cut along the line, which the masses lack"
        )
    return "\n".join(lines)


def cut_data(hinges: "Sequence[Hinge]") -> list[dict[str, object]]:
    """The same as plain data, m."""
    return [
        {"joint": hinge.name, "gap": hinge.properties.gap, "slit": SLIT * hinge.properties.gap}
        for hinge in hinges
    ]


def hinge_table(account: "Sequence[MaterialHinge]") -> str:
    """One line per hinge, a legend and the notes; nothing for no hinges."""
    if not account:
        return ""
    heads = ["joint", "layer", "material", "E1 [GPa]", "E2 [GPa]", "fibres [°]", "t", "L", "b"]
    heads += ["k plate [N·m/rad]", "k beam [N·m/rad]", "k elements [N·m/rad]", "taken"]
    rows = [
        [
            short_name(hinge.joint),
            short_name(hinge.layer),
            short_name(hinge.material.name),
            f"{hinge.material.E1 / 1e9:.5g}",
            f"{hinge.material.E2 / 1e9:.5g}",
            "" if hinge.angle is None else f"{hinge.angle + 0.0:.4g}",
            *(length_text(x) for x in (hinge.thickness, hinge.stiffness.width, hinge.stiffness.length)),
            f"{hinge.stiffness.plate_formula:.6g}",
            f"{hinge.stiffness.beam_formula:.6g}",
            "" if hinge.stiffness.finite_element is None else f"{hinge.stiffness.finite_element:.6g}",
            hinge.stiffness.formula,
        ]
        for hinge in account
    ]
    reported = [
        "hinge stiffness from material, of a strip of the flexible layer: t thick, L = the gap from link to "
        "link, b along the axis; fibres from across the axis",
        table(heads, rows),
        *_notes(account),
    ]
    return "\n\n".join(reported)


def _notes(account: "Sequence[MaterialHinge]") -> list[str]:
    """Each note once, with the hinges that it is about."""
    noted: dict[str, list[str]] = {}
    for hinge in account:
        if hinge.note:
            noted.setdefault(hinge.note, []).append(short_name(hinge.joint))
    return [
        f"note: hinge{'s' if len(joints) > 1 else ''} {', '.join(joints)}: {note}"
        for note, joints in noted.items()
    ]


def hinge_data(account: "Sequence[MaterialHinge]") -> list[dict[str, object]]:
    """The same as plain data, SI, angles in degrees from across the axis."""
    return [
        {
            "joint": hinge.joint,
            "layer": hinge.layer,
            "material": hinge.material.name,
            "source": hinge.material.source,
            "E1": hinge.material.E1,
            "E2": hinge.material.E2,
            "nu12": hinge.material.nu12,
            "G12": hinge.material.G12,
            "angle": hinge.angle,
            "thickness": hinge.thickness,
            "width": hinge.stiffness.width,
            "length": hinge.stiffness.length,
            "plate_formula": hinge.stiffness.plate_formula,
            "beam_formula": hinge.stiffness.beam_formula,
            "finite_element": hinge.stiffness.finite_element,
            "taken": hinge.stiffness.formula,
            "note": hinge.note,
        }
        for hinge in account
    ]
