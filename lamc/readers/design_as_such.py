"""Parameters of a design as such: scale, thickness of layers, constants of materials, width of hinges.

In: a Design of any origin that declares none of its own. Out: the design with others.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

from shapely.geometry import Point

from lamc.readers.as_such import (
    SCALE,
    AsSuch,
    named,
    numbered,
    scale_parameter,
    scaled_scene,
    scaled_shape,
    thickness_parameter,
)
from lamc.records.design import Design, HingeSet, Line, Material
from lamc.records.parameters import DesignParameter

_GAP = "half of the gap of hinges, before the scale"
_CONSTANTS = {  # of materials: unit, bounds and meaning
    "density": ("kg/m³", 0.0, None, "mass per volume"),
    "E1": ("Pa", 1e-3, None, "Young's modulus along the first axis"),
    "E2": ("Pa", 1e-3, None, "Young's modulus across it"),
    "poisson": ("1", -0.999999, 0.999999, "Poisson's ratio"),
    "G12": ("Pa", 1e-3, None, "shear modulus"),
}


def vary_design(design: Design) -> "DesignAsSuch":
    """The recipe of a design that has none."""
    return DesignAsSuch(design)


@dataclass(frozen=True, eq=False)
class DesignAsSuch(AsSuch):
    """base: as its file says."""

    base: Design

    def drawn(self) -> Mapping[str, DesignParameter]:
        found = {SCALE: scale_parameter()}
        for name, layer in zip(self._layers(), self.base.layers, strict=True):
            found[named(name, "thickness", self._layers())] = thickness_parameter(
                layer.thickness, f"layer {name}"
            )
        for label, name, value in self._constants():
            unit, low, high, meaning = _CONSTANTS[name]
            low = None if low is None else min(low, value)
            found[label] = DesignParameter(value, unit, low, high, meaning)
        for label, hinges in zip(self._hinges(), self.base.hinges, strict=True):
            found[label] = DesignParameter(hinges.width, "m", 0.0, None, _GAP)
        return found

    def changed(self, values: Mapping[str, float]) -> Design:
        base, scale = self.base, values[SCALE]
        layers = tuple(
            replace(
                layer,
                thickness=values[named(name, "thickness", self._layers())],
                material=self._material(layer.material, values),
                geometry=scaled_shape(layer.geometry, scale),
            )
            for name, layer in zip(self._layers(), base.layers, strict=True)
        )
        hinges = tuple(
            _scaled(each, values[label], scale)
            for label, each in zip(self._hinges(), base.hinges, strict=True)
        )
        factors = (scale, scale, 1.0)
        made = replace(
            base,
            layers=layers,
            hinges=hinges,
            fixed=tuple(scaled_shape(region, scale) for region in base.fixed),
            body_names=tuple(
                replace(each, point=Point(scale * each.point.x, scale * each.point.y))
                for each in base.body_names
            ),
            contact_points=tuple((scale * x, scale * y) for x, y in base.contact_points),
            scene=scaled_scene(base.scene, factors),
            scenes={name: scaled_scene(scene, factors) for name, scene in base.scenes.items()},
            origin=None,
        )
        return _stiffened(made)

    def _layers(self) -> list[str]:
        return numbered(layer.name for layer in self.base.layers)

    def _materials(self) -> dict[str, Material]:
        """By name, numbered where two that differ share one."""
        found: list[Material] = []
        for layer in self.base.layers:
            if layer.material not in found:
                found.append(layer.material)
        return dict(zip(numbered(each.name for each in found), found, strict=True))

    def _constants(self) -> Iterator[tuple[str, str, float]]:
        """Label, name and value of each."""
        materials = self._materials()
        for owner, material in materials.items():
            for name in _CONSTANTS:
                if getattr(material, name) is not None:
                    yield named(owner, name, materials), name, getattr(material, name)

    def _material(self, material: Material, values: Mapping[str, float]) -> Material:
        materials = self._materials()
        owner = next(name for name, each in materials.items() if each == material)
        labels = {name: named(owner, name, materials) for name in _CONSTANTS}
        changed: dict[str, Any] = {name: values[label] for name, label in labels.items() if label in values}
        return replace(material, **changed)

    def _hinges(self) -> list[str]:
        """A label for the width of each set: by its only line, else by its number."""
        sets: Sequence[HingeSet] = self.base.hinges
        names = [
            each.lines[0].name or f"hinge_{k}" if len(each.lines) == 1 else f"hinge_{k}"
            for k, each in enumerate(sets, start=1)
        ]
        return ["width"] if len(sets) == 1 else [f"{name}.width" for name in numbered(names)]


def _scaled(hinges: HingeSet, width: float, scale: float) -> HingeSet:
    if scale == 1.0 and width == hinges.width:
        return hinges
    lines = tuple(replace(each, line=_line(each.line, scale)) for each in hinges.lines)
    return replace(hinges, lines=lines, width=scale * width)


def _line(line: Line, scale: float) -> Line:
    (x0, y0), (x1, y1) = line
    return (scale * x0, scale * y0), (scale * x1, scale * y1)


def _stiffened(design: Design) -> Design:
    """With the stiffness of hinges that ask for it from their material."""
    if not any(hinges.from_material for hinges in design.hinges):
        return design
    from lamc.plates.designs.hinges import with_material_stiffness  # a tenth of a second, for few designs

    return with_material_stiffness(design, only_asked=True)[0]
