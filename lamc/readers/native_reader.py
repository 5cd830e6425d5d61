"""Native designs: from a validated model to the `Design` record.

In: a model of a file, and where its parts stand. Out: a Design, or DesignErrors with every problem and its place.
Checks here are those that need more than one entry (a layer's material exists) and geometry.
"""

import math
from collections.abc import Sequence
from functools import partial
from pathlib import PurePath

import shapely
from shapely.geometry import MultiPolygon, Point

from lamc.basics.errors import warn
from lamc.design import shapes
from lamc.design.work import MOST_LAYERS, Account
from lamc.readers.checking import Path, Problems, did_you_mean
from lamc.readers.fields import ALL_LAYERS
from lamc.readers.native_doubts import bending_board, vain_cuts
from lamc.readers.native_hinges import (
    check_angles,
    check_line_names,
    check_size,
    line_names,
    stiffened,
    tell_old_names,
)
from lamc.readers.native_shapes import Kept, Region
from lamc.readers.numbers import Numbers
from lamc.readers.parameters import SECTION
from lamc.readers.scene_file import read_scenes
from lamc.readers.schema import (
    DesignModel,
    DrawnModel,
    HingeModel,
    LayerModel,
    NamedBodyModel,
    OutlineModel,
    ShapeModel,
)
from lamc.records.design import BodyName, Design, HingeLine, HingeSet, Layer, Line, Material, Places
from lamc.records.drawing import Mend
from lamc.records.mechanism import checked_name
from lamc.records.scene import Scene


class DesignReader:
    """One design file on its way to a record; every step adds to `problems` and goes on."""

    def __init__(
        self,
        model: DesignModel,
        problems: Problems,
        file: str,
        length_unit: str | None,
        numbers: Numbers,
        kept: Kept,
    ) -> None:
        self.model = model
        self.problems = problems
        self.file = file
        self.length_unit = length_unit
        self.numbers = numbers
        self.layer_names = [layer.name for layer in model.layers]
        self.account = Account()
        self.kept = kept
        self.drawings = kept.drawings
        self.mends: list[Mend] = []
        self.hinge_names: set[str] = set()

    def design(self) -> Design:
        model, problems = self.model, self.problems
        name = model.name or PurePath(self.file).stem or "design"
        problems.attempt(("name",), lambda: checked_name(name, "the design"))
        self._check_names()
        geometry = self._draw()
        fixed = self._fixed()
        found = [self._hinge(i, hinge, geometry) for i, hinge in enumerate(model.hinges)]
        hinges = tuple(hinge for hinge in found if hinge is not None)
        names = tuple(self._body_name(name, body) for name, body in model.bodies.items())
        scene, scenes = read_scenes(
            model.scene,
            model.scenes,
            problems,
            self.length_unit,
            numbers=self.numbers,
            kept=self.kept.effects,
        )
        self._check_inputs([*scenes.values(), *([scene] if scene is not None else [])])
        problems.raise_if_any()
        materials = {
            name: Material(
                name, m.density, m.E1, m.E2, m.poisson, m.rigid, m.flexible, m.adhesive, m.conductive, m.G12
            )
            for name, m in model.materials.items()
        }
        layers = tuple(
            Layer(entry.name, materials[entry.material], entry.thickness, sheet, entry.angle)
            for entry, sheet in zip(model.layers, geometry, strict=True)
        )
        source = PurePath(self.file).name
        tell_old_names(model.hinges, problems)
        check_angles(model.hinges, problems)
        design = Design(
            name,
            layers,
            hinges,
            tuple(fixed),
            names,
            scene,
            source,
            model.story.strip(),
            self._places(),
            scenes,
            tuple(model.contact_points),
            facet_creases=model.facet_creases.record() if model.facet_creases else None,
            beside=tuple(sorted(self.drawings.beside.digests.items())),
            mends=tuple(self.mends),
        )
        check_size(design, self.length_unit)
        return stiffened(design, model.hinges, problems)

    def _places(self) -> Places:
        """The places that a message about the whole drawing may need."""
        paths: list[Path] = [(), ("fixed",), ("hinges",)]
        paths += [("layers", index) for index in range(len(self.layer_names))]
        found = [(path, self.problems.place(path)) for path in paths]
        bodies = self.problems.places(("bodies",))
        return Places((*found, *((("bodies", name), bodies[name]) for name in self.model.bodies)))

    def _check_names(self) -> None:
        model, problems = self.model, self.problems
        if len(model.layers) > MOST_LAYERS:
            problems.add(
                ("layers",),
                f"the design has {len(model.layers)} layers; at most {MOST_LAYERS} are split: join neighbours of one "
                "material",
            )
            problems.raise_if_any()  # every shape and hinge would be looked for in all of them
        if not model.layers:
            problems.add(("layers",), "the design has no layers; list at least one, from the bottom up")
        if not model.shapes:
            problems.add(("shapes",), "the design has no shapes; draw at least one")
        for index, layer in enumerate(model.layers):
            self._check_layer(index, layer)
        for section, entries in (("materials", model.materials), ("bodies", model.bodies)):
            for name in entries:
                problems.attempt((section, name), partial(checked_name, name, f"an entry of {section}"))

    def _check_inputs(self, scenes: Sequence[Scene]) -> None:
        """Notes a parameter that is named as an input of a scene: --set could mean either."""
        for name in sorted({name for scene in scenes for name in scene.inputs} & set(self.numbers.values)):
            text = f"an input of a scene is named {name!r} too; rename one of them"
            self.problems.add((SECTION, name), text)

    def _check_layer(self, index: int, layer: LayerModel) -> None:
        path: Path = ("layers", index)
        self.problems.attempt((*path, "name"), lambda: checked_name(layer.name, "a layer"))
        if layer.name == ALL_LAYERS:
            self.problems.add(
                (*path, "name"), f"{ALL_LAYERS!r} means every layer and cannot name one; rename it"
            )
        if layer.name in self.layer_names[:index]:
            self.problems.add((*path, "name"), f"two layers are named {layer.name!r}; names must differ")
        if layer.material not in self.model.materials:
            hint = did_you_mean(layer.material, sorted(self.model.materials))
            self.problems.add((*path, "material"), f"no material is named {layer.material[:40]!r}; {hint}")

    def _draw(self) -> list[MultiPolygon]:
        """The sheets: shapes in order, each added to or cut from the layers it names."""
        drawn_in: list[list[int]] = [[] for _ in self.layer_names]
        regions: list[Region | None] = []
        for index, shape in enumerate(self.model.shapes):
            path: Path = ("shapes", index)
            regions.append(self._region(path, shape))
            for layer in self._layers(shape.layers, (*path, "layers")):
                if regions[-1] is not None:
                    drawn_in[layer].append(index)
        cuts = [shape.cut is not None for shape in self.model.shapes]
        sheets = self._overlaid(("shapes",), drawn_in, regions, cuts)
        for index, text in vain_cuts(drawn_in, regions, cuts):
            warn(text, self.problems.place(("shapes", index)))
        is_drawn = any(shape.cut is None for shape in self.model.shapes)
        if self.model.shapes and not is_drawn:
            self.problems.add(("shapes",), "every shape is a cut, so there is nothing to cut from; draw one")
        elif is_drawn and self.problems.none and all(s.is_empty for s in sheets):
            self.problems.add(("shapes",), "nothing is left of the drawn shapes after the cuts")
        return sheets

    def _region(self, path: Path, shape: OutlineModel) -> Region | None:
        if isinstance(shape, ShapeModel) and shape.cut is not None:
            return self._region((*path, "cut"), shape.cut)
        if shape.shape is None:
            return self.problems.attempt(path, partial(self.kept.region, path, shape))
        at: Path = (*path, "shape")
        return self.problems.attempt(
            at, partial(self.drawings.region, shape.shape, self.problems.place(at), self.mends)
        )

    def _fixed(self) -> list[MultiPolygon]:
        drawn_in: list[list[int]] = [[] for _ in self.layer_names]
        regions = []
        for index, entry in enumerate(self.model.fixed):
            regions.append(self._region(("fixed", index), entry))
            for layer in self._layers(entry.layers, ("fixed", index, "layers")):
                if regions[-1] is not None:
                    drawn_in[layer].append(index)
        return self._overlaid(("fixed",), drawn_in, regions, [False] * len(regions))

    def _overlaid(
        self,
        path: Path,
        drawn_in: Sequence[Sequence[int]],
        regions: Sequence[Region | None],
        cuts: Sequence[bool],
    ) -> list[MultiPolygon]:
        """For each layer the regions drawn in it, or cut from it, by index; layers are mostly drawn alike."""
        made: dict[tuple[int, ...], MultiPolygon] = {}
        for name, indices in zip(self.layer_names, map(tuple, drawn_in), strict=True):
            if indices not in made:
                entries = [(region, cuts[k]) for k in indices if (region := regions[k])]
                sheet = self.problems.attempt(
                    path, partial(self.kept.sheet, (*path, *indices), entries, name, self.account)
                )
                made[indices] = MultiPolygon() if sheet is None else sheet
        return [made[tuple(indices)] for indices in drawn_in]

    def _body_name(self, name: str, body: NamedBodyModel) -> BodyName:
        found = [] if body.layer is None else self._layers([body.layer], ("bodies", name, "layer"))
        return BodyName(name, Point(body.at), found[0] if len(found) == 1 else None)

    def _hinge(self, index: int, hinge: HingeModel, sheets: Sequence[MultiPolygon]) -> HingeSet | None:
        path: Path = ("hinges", index)
        ends, line_paths = self._lines(path, hinge)
        layer = self._hinge_layer(path, hinge.layer)
        through = self._layers(hinge.layers, (*path, "layers"))
        if isinstance(hinge.lines, DrawnModel) and layer is not None and ends:
            at: Path = (*path, "lines")
            material = shapely.union_all([sheets[k] for k in sorted({layer, *through})])
            take = partial(
                self.drawings.lengthened, hinge.lines, self.problems.place(at), ends, material, self.mends
            )
            ends = self.problems.attempt(at, take) or ends
        names = line_names(hinge, len(ends))
        check_line_names(names, self.hinge_names, path, self.problems)
        lines: list[HingeLine] = []
        for at, (start, end), name in zip(line_paths, ends, names, strict=True):
            line = self.problems.attempt(at, partial(shapes.line, start, end))
            if line is not None:
                lines.append(HingeLine(line, name, self.problems.place(at)))
        if layer is None or not lines:
            return None
        limits = hinge.limits or (-math.pi, math.pi)
        return HingeSet(
            tuple(lines),
            hinge.half_gap,
            layer,
            tuple(through),
            0.0 if isinstance(hinge.stiffness, str) else hinge.stiffness,
            hinge.damping,
            hinge.rest_angle,
            limits,
            from_material=isinstance(hinge.stiffness, str),
        )

    def _lines(self, path: Path, hinge: HingeModel) -> tuple[Sequence[Line], list[Path]]:
        """Its lines as drawn, and where each stands in the file."""
        if hinge.line is not None:
            return [hinge.line], [(*path, "line")]
        at: Path = (*path, "lines")
        if not isinstance(hinge.lines, DrawnModel):
            return hinge.lines or [], [(*at, i) for i in range(len(hinge.lines or []))]
        rests = "rest_angle" in hinge.model_fields_set
        take = partial(self.drawings.lines, hinge.lines, self.problems.place(at), self.mends, rests=rests)
        found = self.problems.attempt(at, take) or ()
        return found, [at] * len(found)

    def _hinge_layer(self, path: Path, name: str | None) -> int | None:
        """Index of the layer that bends: the named one, or the only flexible one."""
        if name is not None:
            found = self._layers([name], (*path, "layer"))
            if name == ALL_LAYERS:
                self.problems.add(
                    (*path, "layer"), f"a hinge bends in one layer: {', '.join(self.layer_names)}"
                )
            if not found or name == ALL_LAYERS:
                return None
            doubt = bending_board(self.model, found[0])
            if doubt:
                warn(doubt, self.problems.place((*path, "layer")))
            return found[0]
        materials = self.model.materials
        flexible = [
            i
            for i, layer in enumerate(self.model.layers)
            if layer.material in materials and materials[layer.material].flexible
        ]
        if len(flexible) == 1:
            return flexible[0]
        if any(layer.material not in materials for layer in self.model.layers):
            return None  # a problem already, and perhaps the cause
        self.problems.add(
            path,
            f"the hinge names no layer, and {len(flexible)} layers are flexible; say which bends: layer: …",
        )
        return None

    def _layers(self, names: Sequence[str], path: Path) -> list[int]:
        """Indices of the named layers, ascending; unknown names become problems."""
        if list(names) == [ALL_LAYERS]:
            return list(range(len(self.layer_names)))
        indices: set[int] = set()
        for name in names:
            if name in self.layer_names:
                indices.add(self.layer_names.index(name))
            else:
                hint = did_you_mean(name, self.layer_names)
                self.problems.add(path, f"no layer is named {name[:40]!r}; {hint}")
        return sorted(indices)
