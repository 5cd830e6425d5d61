"""Materials of a design as materials of plates.

In: the layers of a design, and materials that replace its own. Out: a plate material for each name; or a DesignError
that names all whose moduli are not known. Never: invents a modulus; a placeholder in a file counts as none.
"""

import math
from collections.abc import Mapping, Sequence

from lamc.basics.checks import did_you_mean, shown
from lamc.basics.errors import DesignError
from lamc.plates.laminates.materials import Material
from lamc.records import design as records


def plate_materials(
    design: records.Design, layers: Sequence[int], overrides: Mapping[str, Material] | None = None
) -> dict[str, Material]:
    """The plate material of the material of each of some layers (indices), by name.

    overrides  materials that replace the design's own of the same name

    Isotropic where the design gives E1 and poisson, and E2 not or equal; with E2 it needs G12 too.
    Raises DesignError, once for all materials that lack something, and for a replacement of what the design has not.
    """
    given = dict(overrides or {})
    names = sorted({layer.material.name for layer in design.layers})
    for name, material in given.items():
        if name not in names:
            raise DesignError(
                f"design {design.name!r} has no material {shown(name)} to be replaced; {did_you_mean(str(name), names)}"
            )
        if not isinstance(material, Material):
            raise DesignError(
                f"the material for {shown(name)} is {shown(material)}; it must be a plate.Material: "
                "make one, or take one by plate.material(name)"
            )
    own = {design.layers[k].material.name: design.layers[k].material for k in layers}
    lacking = {name: _missing(m) for name, m in own.items() if name not in given and _missing(m)}
    if lacking:
        reported = "; ".join(
            f"{name!r} has no {', '.join(symbols)}" for name, symbols in sorted(lacking.items())
        )
        raise DesignError(
            f"moduli are needed for a plate, and those of the design are unknown or placeholders: {reported}: give "
            f"them in "
            f"the design's materials, as {min(lacking)}: {{E1: 2.5 GPa, poisson: 0.34}}, or replace the material: in "
            f'the materials of a plate file, by --material "{min(lacking)}=Kapton HN" of lamc split and lamc plate, '
            f'or in Python by materials={{{min(lacking)!r}: plate.material("Kapton HN")}}'
        )
    return {name: given[name] if name in given else _plate_material(m) for name, m in own.items()}


def _is_orthotropic(material: records.Material) -> bool:
    return material.G12 is not None or material.E2 not in (None, material.E1)


def _missing(material: records.Material) -> list[str]:
    needed = ["E1", "poisson", *(["E2", "G12"] if _is_orthotropic(material) else [])]
    return [symbol for symbol in needed if getattr(material, symbol) is None]


def _plate_material(material: records.Material) -> Material:
    E1, E2, nu, G12 = material.E1, material.E2, material.poisson, material.G12
    assert E1 is not None
    assert nu is not None
    what = f"the design's material {material.name!r}"
    if not _is_orthotropic(material):
        return Material.isotropic(E1, nu, material.density, name=material.name, source=what)
    assert E2 is not None
    assert G12 is not None
    return Material(E1, E2, nu, G12, material.density, name=material.name, source=what)


def ply_angle(layer: records.Layer, rotated: float = 0.0) -> float:
    """Degrees from an axis at `rotated` degrees from world x to the layer's fibres."""
    return math.degrees(layer.angle) - rotated
