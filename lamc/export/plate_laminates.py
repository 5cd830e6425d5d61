"""The laminates of a plate as arrays of parameters: materials, plies, reference surfaces.

In: a problem. Out: numbers with names and the structure that C needs to take a laminate's stiffness from them. Never:
stiffness itself.
"""

from collections.abc import Sequence
from dataclasses import dataclass

from lamc.codegen.names import comment
from lamc.plates.laminates.laminate import Laminate
from lamc.plates.laminates.materials import Material
from lamc.plates.problem import Problem

MODULI = ("E1", "E2", "nu12", "G12", "density")  # of every material; Pa, Pa, -, Pa, kg/m³
_SURFACES = {"bottom": -0.5, "middle": 0.0, "top": 0.5}  # as in `Laminate`


@dataclass(frozen=True)
class PlyRow:
    laminate: str
    material: int
    angle: float  # degrees
    thickness: float  # m
    gap: float  # m, below it


@dataclass(frozen=True)
class LaminateTables:
    """materials  (name, numbers); plies of all laminates, bottom to top, one laminate after the other.

    begins     where each laminate's plies begin, and the end
    surface    height of each reference surface above the middle in thicknesses; `reference` m, added to it
    of_region  laminate of each region of the mesh
    """

    materials: tuple[tuple[str, tuple[float, ...]], ...]
    plies: tuple[PlyRow, ...]
    begins: tuple[int, ...]
    names: tuple[str, ...]
    surface: tuple[float, ...]
    reference: tuple[float, ...]
    of_region: tuple[int, ...]


def laminate_tables(problem: Problem, fields: Sequence[str]) -> LaminateTables:
    """Of all laminates of `problem`; one that serves several regions is there once, and so is a material, of which C
    has `fields`."""
    laminates: list[Laminate] = []
    of_region: list[int] = []
    names: list[str] = []
    for region, laminate in zip(problem.mesh.region_names, problem.laminates, strict=True):
        found = next((k for k, other in enumerate(laminates) if other is laminate), len(laminates))
        if found == len(laminates):
            laminates.append(laminate)
            names.append(comment(region) or "the plate")
        of_region.append(found)
    materials: list[Material] = []
    plies: list[PlyRow] = []
    begins = [0]
    for name, laminate in zip(names, laminates, strict=True):
        for ply in laminate.plies:
            if ply.material not in materials:
                materials.append(ply.material)
            number = materials.index(ply.material)
            plies.append(PlyRow(name, number, ply.angle, ply.thickness, ply.gap))
        begins.append(len(plies))
    return LaminateTables(
        tuple(
            (comment(m.name) or f"material {k + 1}", tuple(float(getattr(m, field)) for field in fields))
            for k, m in enumerate(materials)
        ),
        tuple(plies),
        tuple(begins),
        tuple(names),
        tuple(_SURFACES[each.reference] if isinstance(each.reference, str) else 0.0 for each in laminates),
        tuple(0.0 if isinstance(each.reference, str) else float(each.reference) for each in laminates),
        tuple(of_region),
    )
