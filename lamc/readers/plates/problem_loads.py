"""Supports and loads of a plate file: from validated models to records.

In: models, places, and the collector of the file's problems. Out: records of `supports` and `loads`, SI. Never:
evaluates an expression by Python.
"""

from collections.abc import Mapping, Sequence
from functools import partial

from lamc.basics import units
from lamc.basics.errors import DesignError, Place
from lamc.basics.units import Quantity, to_si
from lamc.plates.foundations import ElasticFoundation
from lamc.plates.hinge_lines import HingeLine
from lamc.plates.loads import (
    EdgeLoad,
    EdgeMoment,
    ElectricField,
    LoadRecord,
    Moisture,
    PointLoad,
    Pressure,
    SelfWeight,
    Temperature,
)
from lamc.plates.supports import Clamped, Hinged, SimplySupported, Support, SupportRecord, Symmetry, Value
from lamc.readers.checking import Path, Problems
from lamc.readers.plates.amounts import read_amount
from lamc.readers.plates.expression import Field, depends_on_place
from lamc.readers.plates.problem_drawing import DrawnGeometry
from lamc.readers.plates.problem_schema import FoundationModel, HingeLineModel, LoadModel, SupportModel
from lamc.records.mechanism import checked_name


class Actions:
    """Reads supports and loads; `bare` is the unit of a length without one."""

    def __init__(self, places: DrawnGeometry, problems: Problems, bare: str | None) -> None:
        self._places = places
        self._problems = problems
        self._bare = bare
        self._step = to_si(1.0, units.LENGTH, bare)  # m, of a bare length
        self.origins: list[tuple[object, Place]] = []  # every record that was made, and its place

    def supports(self, models: Sequence[SupportModel]) -> tuple[SupportRecord, ...]:
        """Those of the file, in order."""
        made: list[SupportRecord] = []
        for index, model in enumerate(models):
            path: Path = ("supports", index)
            found = self._support(model, path)
            self.origins += [(support, self._problems.place(path)) for support in found]
            made += found
        return tuple(made)

    def foundations(self, models: Sequence[FoundationModel]) -> tuple[ElasticFoundation, ...]:
        """Elastic ground, in order."""
        made = []
        for index, model in enumerate(models):
            path: Path = ("foundation", index)
            found = self._problems.attempt(path, partial(self._foundation, model, path))
            if found is not None:
                self.origins.append((found, self._problems.place(path)))
                made.append(found)
        return tuple(made)

    def _foundation(self, model: FoundationModel, path: Path) -> ElasticFoundation | None:
        if model.where is None:
            return ElasticFoundation(model.stiffness)
        where = self._places.where(model.where, (*path, "where"))
        if isinstance(where, str):
            raise DesignError(
                "an elastic foundation is under an area, and the boundary is none: leave where out"
            )
        return None if where is None else ElasticFoundation(model.stiffness, where)

    def hinges(self, models: Sequence[HingeLineModel]) -> tuple[HingeLine, ...]:
        """Those of the design, where it has hinges between bodies of the plate, then those of the file. An entry of the
        file along a hinge of the design replaces it."""
        body = self._places.body
        found = dict(body.lines) if body is not None else {}
        for index, model in enumerate(models):
            path: Path = ("hinges", index)
            made = self._problems.attempt(path, partial(self._hinge_line, model, path))
            if made is not None:
                self.origins.append((made, self._problems.place(path)))
                found[model.along.hinge or f"{index} of the file"] = made
        return tuple(found.values())

    def _hinge_line(self, model: HingeLineModel, path: Path) -> HingeLine | None:
        name, body = model.along.hinge, self._places.body
        if name is not None and body is not None and name in body.hinges:
            raise DesignError(
                f"hinge {name!r} joins the plate to a body outside; hold it by supports: {{hinged: {{hinge: {name}}}}}"
            )
        where = self._places.where(model.along, (*path, "along"))
        if where is None or isinstance(where, str):
            return None
        return HingeLine(where, model.stiffness, model.name or name or "")

    def cases(
        self, common: Sequence[LoadModel], cases: Mapping[str, Sequence[LoadModel]]
    ) -> dict[str, tuple[LoadRecord, ...]]:
        """Loads by case, one of the name "" where the file has none; the common ones belong to every case."""
        everywhere = self._loads(("loads",), common)
        for name in cases:
            self._problems.attempt(("cases", name), partial(checked_name, name, "a case"))
        found = {name: (*everywhere, *self._loads(("cases", name), own)) for name, own in cases.items()}
        return found or {"": everywhere}

    def _support(self, model: SupportModel, path: Path) -> list[SupportRecord]:
        if model.fixed is not None:
            assert model.where is not None
            where = self._places.where(model.where, (*path, "where"))
            value = self._problems.attempt((*path, "value"), lambda: self._support_value(model))
            return [] if where is None or value is None else [Support(where, tuple(model.fixed), value)]
        kind = next(k for k in ("clamped", "simply_supported", "hinged", "symmetry") if getattr(model, k))
        where = self._places.where(getattr(model, kind), (*path, kind))
        if where is None:
            return []
        if kind == "clamped":
            return [Clamped(where)]
        if kind == "symmetry":
            return [Symmetry(where)]
        if kind == "hinged":
            return [Hinged(where, model.stiffness)]
        return [SimplySupported(where, kind=model.kind)]

    def _support_value(self, model: SupportModel) -> Value:
        """The value of fixed unknowns: m, or of slopes without unit; an expression counts as a bare number does."""
        names = model.fixed or []
        slopes = [name for name in names if name.startswith("w_")]
        if slopes and len(slopes) < len(names) and model.value != 0:
            raise DesignError("displacements and slopes have different units; fix them in two entries")
        if isinstance(model.value, str) and depends_on_place(model.value):
            return Field(model.value, self._step, 1.0 if slopes else self._step)
        return to_si(model.value, units.RATIO) if slopes else to_si(model.value, units.LENGTH, self._bare)

    def _loads(self, path: Path, models: Sequence[LoadModel]) -> tuple[LoadRecord, ...]:
        made: list[LoadRecord] = []
        for index, model in enumerate(models):
            here: Path = (*path, index)
            load = self._problems.attempt(here, partial(self._load, model, here))
            if load is not None:
                self.origins.append((load, self._problems.place(here)))
                made.append(load)
        return tuple(made)

    def _load(self, model: LoadModel, path: Path) -> LoadRecord | None:
        region = model.region
        if region is not None:
            self._problems.attempt((*path, "region"), lambda: self._places.named(region))
        if model.point is not None:
            force = self._vector(model.force, units.FORCE, (*path, "force"))
            return None if force is None else PointLoad(model.point, force)
        if model.edge is not None:
            return self._edge_load(model, path)
        if model.pressure is not None:
            return Pressure(self._amount(model.pressure), region)
        if model.gravity is not None:
            return SelfWeight(model.gravity)
        if model.temperature is not None:
            slope = self._gradient(model, units.WARMING_GRADIENT, path)
            return Temperature(self._amount(model.temperature), region, slope)
        if model.moisture is not None:
            slope = self._gradient(model, units.MOISTURE_GRADIENT, path)
            return Moisture(self._amount(model.moisture), region, slope)
        assert model.field is not None
        if isinstance(model.field, list):
            return ElectricField([self._amount(one) for one in model.field], region)
        return ElectricField(self._amount(model.field), region)

    def _gradient(self, model: LoadModel, quantity: Quantity, path: Path) -> float | Field:
        """Through the thickness, SI; 0 after a problem was noted."""
        if model.gradient is None:
            return 0.0
        value = self._problems.attempt((*path, "gradient"), lambda: read_amount(model.gradient, quantity))
        return 0.0 if value is None else self._amount(value)

    def _amount(self, value: float | str) -> float | Field:
        """A number, or the function that an expression stands for."""
        return Field(value, self._step) if isinstance(value, str) else value

    def _edge_load(self, model: LoadModel, path: Path) -> LoadRecord | None:
        assert model.edge is not None
        where = self._places.where(model.edge, (*path, "edge"))
        if where is None:
            return None
        if model.moment is not None:
            return EdgeMoment(where, model.moment)
        if model.force is not None:
            force = self._vector(model.force, units.LINE_FORCE, (*path, "force"))
            return None if force is None else EdgeLoad(where, force)
        total = self._vector(model.total, units.FORCE, (*path, "total"))
        length = self._problems.attempt((*path, "edge"), lambda: self._places.edge_length(where))
        if total is None or length is None:
            return None
        return EdgeLoad(where, tuple(part / length for part in total))

    def _vector(self, value: object, quantity: Quantity, path: Path) -> tuple[float, float, float] | None:
        """A force along z, or three components."""
        given = value if isinstance(value, list) else [0.0, 0.0, value]
        if len(given) != 3:
            self._problems.add(path, f"a force is one number, along z, or three; this one has {len(given)}")
            return None
        x, y, z = (
            self._problems.attempt((*path, index) if given is value else path, partial(to_si, part, quantity))
            for index, part in enumerate(given)
        )
        return None if x is None or y is None or z is None else (x, y, z)
