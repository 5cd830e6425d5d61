"""Materials and laminates of a plate file: from validated models to records.

In: models, and the collector of the file's problems. Out: `Material` and `Laminate` records; every problem is noted
at its place. Never: geometry.
"""

from collections.abc import Mapping
from dataclasses import replace
from functools import partial

from lamc.plates.laminates.laminate import Laminate
from lamc.plates.laminates.library import LIBRARY, material
from lamc.plates.laminates.materials import Material
from lamc.plates.laminates.plies import Ply
from lamc.readers.checking import Path, Problems, did_you_mean
from lamc.readers.plates.section_schema import LaminateModel, PlateMaterialModel, PlyModel


class Sections:
    """The materials and the named laminates of a file."""

    def __init__(
        self,
        materials: Mapping[str, PlateMaterialModel],
        laminates: Mapping[str, LaminateModel],
        problems: Problems,
    ) -> None:
        self._problems = problems
        self._materials = {
            name: problems.attempt(("materials", name), partial(_material, name, model))
            for name, model in materials.items()
        }
        self._models = laminates
        self._laminates: dict[str, Laminate | None] = {}
        for name, model in laminates.items():
            path: Path = ("laminates", name)
            if model.use is not None:
                problems.add(
                    path, "an entry of laminates has plies or one material; it cannot name another entry"
                )
                self._laminates[name] = None
            else:
                self._laminates[name] = self._made(model, path)

    @property
    def materials(self) -> dict[str, Material]:
        """The file's own, those without problems."""
        return {name: material for name, material in self._materials.items() if material is not None}

    def laminate(self, model: LaminateModel, path: Path) -> Laminate | None:
        """The laminate of a model, or None after a problem was noted."""
        if model.use is None:
            return self._made(model, path)
        if model.use not in self._laminates:
            hint = did_you_mean(model.use, sorted(self._laminates))
            self._problems.add(path, f"no laminate is named {model.use[:40]!r}; {hint}")
            return None
        return self._laminates[model.use]

    def _made(self, model: LaminateModel, path: Path) -> Laminate | None:
        if model.plies is not None:
            plies = [self._ply(ply, (*path, "plies", index)) for index, ply in enumerate(model.plies)]
            whole = [ply for ply in plies if ply is not None]
            if len(whole) < len(plies):
                return None
            return self._problems.attempt(path, lambda: Laminate(whole, model.reference))
        material = self._material(model.material or "", (*path, "material"))
        if material is None:
            return None
        layup, ply = model.layup, model.ply
        if layup is not None and ply is not None:
            return self._problems.attempt(
                (*path, "layup"), lambda: Laminate.parse(layup, material, ply, model.reference)
            )
        sheet = partial(Ply, material, model.thickness or 0.0, model.angle)
        return self._problems.attempt(path, lambda: Laminate([sheet()], model.reference))

    def _ply(self, model: PlyModel, path: Path) -> Ply | None:
        material = self._material(model.material, (*path, "material"))
        if material is None:
            return None
        return self._problems.attempt(path, lambda: Ply(material, model.thickness, model.angle))

    def _material(self, name: str, path: Path) -> Material | None:
        """One of the file's own, or else of the library."""
        if name in self._materials:
            return self._materials[name]
        if name in LIBRARY:
            return LIBRARY[name]
        hint = did_you_mean(name, [*self._materials, *sorted(LIBRARY)])
        self._problems.add(path, f"no material is named {name[:40]!r}, here or in lamc's library; {hint}")
        return None


def _material(name: str, model: PlateMaterialModel) -> Material:
    """Raises DesignError as Material does, and for a name that the library does not have."""
    if model.library is not None:
        return material(model.library)
    given = {key: value for key, value in model.model_dump().items() if value is not None}
    expansion = {key: given.pop(key, 0.0) for key in ("alpha", "beta")}
    if "E" not in given:
        return Material(name=name, **given)
    sheet = Material.isotropic(given.pop("E"), given.pop("nu"), given.pop("density"), name=name, **expansion)
    return replace(sheet, **given)
