"""Parameters of mechanisms as such: of a joint definition, of a sheet of creases, of a mechanism's own file.

In: what the file was read into. Out: the mechanism with other values. Sheets are healed once only.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

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
from lamc.readers.fold_file import FoldFrame
from lamc.readers.fold_hinges import CREASE
from lamc.readers.fold_own import HINGES, own_card
from lamc.readers.fold_sheet import sheet_mechanism, unit_of
from lamc.readers.joint_definition import DefinedJoint, JointDefinition, assemble
from lamc.records.card import Card, SheetOptions
from lamc.records.design import Line
from lamc.records.drawing import Mend
from lamc.records.mechanism import Mechanism, Slab
from lamc.records.parameters import DesignParameter

MASS = "mass"
_DENSITY = ("kg/m³", 0.0, None, "mass per volume")


@dataclass(frozen=True, eq=False)
class SheetAsSuch(AsSuch):
    """A sheet of creases, healed: scale, thickness and density of its card, stiffness of creases by their length."""

    frame: FoldFrame
    options: SheetOptions
    stem: str
    mends: tuple[Mend, ...] = ()

    def drawn(self) -> Mapping[str, DesignParameter]:
        card = self._card()
        found = {
            SCALE: scale_parameter(),
            "thickness": thickness_parameter(card.thickness, "the card"),
            "density": DesignParameter(card.density, *_DENSITY),
        }
        if (
            self.options.crease is not None or HINGES not in self.frame.own
        ):  # else each has a number of its own
            crease = CREASE if self.options.crease is None else self.options.crease
            found["crease"] = DesignParameter(crease, "N/rad", 0.0, None, "stiffness of creases, per length")
        return found

    def changed(self, values: Mapping[str, float]) -> Mechanism:
        scale, options = values[SCALE], self.options
        held = [
            each if isinstance(each, str) else (scale * each[0], scale * each[1]) for each in options.held
        ]
        unit = unit_of(self.frame, options, [])
        frame = replace(self.frame, unit=scale * unit, off=scale * self.frame.off)
        again = replace(
            options,
            units=None,
            fixed=held or None,
            card=Card(values["thickness"], values["density"]),
            crease=values.get("crease", options.crease),
        )
        return replace(sheet_mechanism(frame, again, self.stem)[0], mends=self.mends)

    def _card(self) -> Card:
        return self.options.card or own_card(self.frame.own) or Card()


@dataclass(frozen=True, eq=False)
class JointsAsSuch(AsSuch):
    """A joint definition: scale, thickness and density of its layers."""

    definition: JointDefinition

    def drawn(self) -> Mapping[str, DesignParameter]:
        found = {SCALE: scale_parameter()}
        for name, layer in zip(self._layers(), self.definition.layers, strict=True):
            found[named(name, "thickness", self._layers())] = thickness_parameter(
                layer.thickness, f"layer {name}"
            )
        for name, layer in zip(self._layers(), self.definition.layers, strict=True):
            density = DesignParameter(layer.material.density, *_DENSITY)
            found[named(name, "density", self._layers())] = density
        return found

    def changed(self, values: Mapping[str, float]) -> Mechanism:
        scale, names = values[SCALE], self._layers()
        layers = tuple(
            replace(
                layer,
                thickness=values[named(name, "thickness", names)],
                material=replace(layer.material, density=values[named(name, "density", names)]),
            )
            for name, layer in zip(names, self.definition.layers, strict=True)
        )
        before, after = (
            [0.0, *np.cumsum([each.thickness for each in of])] for of in (self.definition.layers, layers)
        )
        bodies = tuple(
            replace(
                body, polygons=tuple(tuple(scaled_shape(p, scale) for p in layer) for layer in body.polygons)
            )
            for body in self.definition.bodies
        )
        joints = tuple(_moved(joint, scale, before, after) for joint in self.definition.joints)
        return assemble(replace(self.definition, layers=layers, bodies=bodies, joints=joints))

    def _layers(self) -> list[str]:
        return numbered(layer.name for layer in self.definition.layers)


def _moved(joint: DefinedJoint, scale: float, before: list[float], after: list[float]) -> DefinedJoint:
    """Scaled, at the same share of its layer's thickness; beyond the layers as far as it was."""
    z = joint.z
    if before != after:
        inside = before[0] <= z <= before[-1]
        z = float(np.interp(z, before, after)) if inside else z + (after[-1] - before[-1]) * (z > 0.0)
    line: Line = tuple((scale * x, scale * y) for x, y in joint.line)  # type: ignore[assignment]
    return replace(joint, line=line, z=z)


@dataclass(frozen=True, eq=False)
class MechanismAsSuch(AsSuch):
    """A mechanism's own file: scale of its shape, and a factor of its masses."""

    base: Mechanism

    def drawn(self) -> Mapping[str, DesignParameter]:
        return {
            SCALE: scale_parameter("of all lengths; masses go with its cube, inertias with its fifth power"),
            MASS: DesignParameter(1.0, "1", 1e-6, 1e6, "factor of all masses and inertias"),
        }

    def changed(self, values: Mapping[str, float]) -> Mechanism:
        base, s, m = self.base, values[SCALE], values[MASS]
        bodies = tuple(
            replace(
                body,
                mass=m * s**3 * body.mass,
                com=s * body.com,
                inertia=m * s**5 * body.inertia,
                outline=tuple(
                    Slab(scaled_shape(p.polygon, s), s * p.z_bottom, s * p.z_top) for p in body.outline
                ),
            )
            for body in base.bodies
        )
        return replace(
            base,
            bodies=bodies,
            joints=tuple(replace(joint, point=s * joint.point) for joint in base.joints),
            contact_points=tuple((s * x, s * y) for x, y in base.contact_points),
            scene=scaled_scene(base.scene, (s, s, s)),
            scenes={name: scaled_scene(scene, (s, s, s)) for name, scene in base.scenes.items()},
            origin=None,
        )
