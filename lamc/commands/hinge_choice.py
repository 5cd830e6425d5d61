"""Stiffness of hinges from their material, as options and designs ask for it.

In: a design, and a choice. Out: the design with these stiffnesses, and where each comes from. Never: changes the
stiffness of a hinge that neither the file nor the option asks for.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from lamc.basics.errors import BuildError, DesignError
from lamc.commands.pairs import pairs_of
from lamc.records.design import Design
from lamc.records.mechanism import Mechanism

if TYPE_CHECKING:
    from lamc.plates.designs.hinges import MaterialHinge
    from lamc.plates.laminates.materials import Material


@dataclass(frozen=True)
class HingeChoice:
    """Where the stiffness of hinges comes from: "drawn" or "from-material"; and materials, as NAME=MATERIAL."""

    stiffness: str = "drawn"
    materials: Sequence[str] = ()

    @property
    def every(self) -> bool:
        """Whether all hinges are asked for, not only those of which the file says so."""
        return self.stiffness == "from-material"


AS_DRAWN = HingeChoice()


def stiffened(record: Design | Mechanism, choice: HingeChoice, origin: str) -> Design | Mechanism:
    """The design with the stiffness that the choice asks for. Raises DesignError for mechanisms, and without moduli."""
    replaced = _materials(choice)
    if not choice.every:
        return record
    from lamc.plates.designs.hinges import with_material_stiffness

    if isinstance(record, Mechanism):
        raise DesignError(
            f"{origin!r} holds a mechanism, which has no layers; --hinge-stiffness from-material needs the design that "
            "it was split from"
        )
    return with_material_stiffness(record, replaced)[0]


def account_of(design: Design, choice: HingeChoice, notes: list[str]) -> "tuple[MaterialHinge, ...]":
    """By formulas, and by finite elements beside them where there is a C compiler to make these; a note elsewhere."""
    if not choice.every and not any(hinges.from_material for hinges in design.hinges):
        return ()
    from lamc.plates.answers.hinge_stiffness import CELLS
    from lamc.plates.designs.hinges import with_material_stiffness

    replaced, only_asked = _materials(choice), not choice.every
    try:
        return with_material_stiffness(design, replaced, cells=CELLS, only_asked=only_asked)[1]
    except BuildError as error:
        notes.append(f"no finite elements stand beside the formulas of the hinges: {error.message}")
        return with_material_stiffness(design, replaced, only_asked=only_asked)[1]


def _materials(choice: HingeChoice) -> "dict[str, Material]":
    """Library materials by the names that they replace. Raises DesignError."""
    if choice.materials and not choice.every:
        raise DesignError("--material replaces the material of hinges; add --hinge-stiffness from-material")
    if not choice.materials:
        return {}
    from lamc.plates.laminates.library import material

    pairs = pairs_of(choice.materials, "--material", "'film=Kapton HN'")
    return {name: material(value) for name, value in pairs.items()}
