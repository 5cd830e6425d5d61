"""Plate files: `kind: plate` in YAML, from nodes to a `PlateFile`.

In: nodes of a file. Out: a PlateFile, or DesignErrors with every problem of the file and its place. Checks here are
those that need more than one entry, and geometry. Never: meshes, solves.
"""

import math
import re
from dataclasses import replace
from functools import partial
from pathlib import Path as FilePath
from pathlib import PurePath

from lamc.basics import units
from lamc.basics.errors import DesignError, Place
from lamc.basics.units import Quantity, to_si
from lamc.plates.laminates.laminate import Laminate
from lamc.readers.checking import Problems, validate
from lamc.readers.fields import LENGTH_UNIT
from lamc.readers.inert import MapNode, Node, ScalarNode, compose
from lamc.readers.load import file_text
from lamc.readers.native import length_unit_of
from lamc.readers.plates import expression
from lamc.readers.plates.origins import Origins
from lamc.readers.plates.problem_drawing import DrawnGeometry
from lamc.readers.plates.problem_loads import Actions
from lamc.readers.plates.problem_records import Drawing, Geometry, Output, PlateFile
from lamc.readers.plates.problem_schema import OutputModel, PlateFileModel
from lamc.readers.plates.section_file import Sections
from lamc.readers.plates.work import check_work
from lamc.records.mechanism import checked_name

_MOST_MODES = 1000
_NAMED = re.compile(r"\b([ABD][126]{2}|h)\b", re.ASCII)  # what makes a text an expression
_QUANTITIES: dict[str, Quantity] = {
    **dict.fromkeys(("u", "v", "w"), units.LENGTH),
    **dict.fromkeys(("w_x", "w_y"), units.RATIO),
    **dict.fromkeys(("kappa_x", "kappa_y", "kappa_xy"), units.CURVATURE),
    **dict.fromkeys(("M_x", "M_y", "M_xy"), units.LINE_MOMENT),
    **dict.fromkeys(("N_x", "N_y", "N_xy"), units.LINE_FORCE),
}


def load_plate(path: FilePath | str) -> PlateFile:
    """The plate problem in the file at `path`.

    Raises DesignError (DesignErrors for several problems) for a file that is missing, unreadable, malformed or
    impossible.
    """
    return plate_of_text(file_text(path), str(path))


def plate_of_text(text: str, name: str) -> PlateFile:
    """The plate problem in a text; messages call it `name`. Raises as `load_plate` does."""
    return read_plate(compose(text, name))


def is_plate(node: Node) -> bool:
    """Whether the file says that it is a plate problem, or has what only such a problem has."""
    if not isinstance(node, MapNode):
        return False
    kind = node.get("kind")
    if isinstance(kind, ScalarNode):
        return kind.text == "plate"
    return kind is None and node.get("geometry") is not None and node.get("layers") is None


def read_plate(node: Node, drawn: tuple[float, int] | None = None) -> PlateFile:
    """The plate problem in `node`; `drawn` as `DrawnGeometry` takes it. Raises DesignErrors with every problem."""
    bare = length_unit_of(node)
    model = validate(PlateFileModel, node, {LENGTH_UNIT: bare})
    problems = Problems(node)
    check_work(model, problems)
    name = model.name or PurePath(node.place.file).stem or "plate"
    problems.attempt(("name",), lambda: checked_name(name, "the plate"))
    for key in ("modes", "buckling"):
        count = getattr(model, key)
        if not 0 <= count <= _MOST_MODES:
            problems.add((key,), f"{key} is {count}; it must be 0 to {_MOST_MODES}")
    sections = Sections(model.materials, model.laminates, problems)
    laminate = sections.laminate(model.laminate, ("laminate",)) if model.laminate is not None else None
    places = DrawnGeometry(model, sections, problems, to_si(1.0, units.LENGTH, bare), drawn)
    if model.laminate is not None and model.geometry.design is not None:
        problems.add(("laminate",), "the laminates come from the design; take this away")
    if model.laminate is None and problems.none and not places.covered():
        problems.add((), "the plate has no laminate; give laminate: {material: …, thickness: …}, or plies")
    actions = Actions(places, problems, bare)
    supports = actions.supports(model.supports)
    hinges = actions.hinges(model.hinges)
    foundations = actions.foundations(model.foundation)
    cases = actions.cases(model.loads, model.cases)
    outputs = [
        problems.attempt(("outputs", index), partial(_output, entry, index, places, laminate, bare))
        for index, entry in enumerate(model.outputs)
    ]
    follow = places.followed(model.geometry)
    problems.raise_if_any()
    records = [*actions.origins, *((o, problems.place(("outputs", k))) for k, o in enumerate(outputs))]
    shape = model.geometry
    file = PlateFile(
        name=name,
        geometry=Geometry(
            places.outline, shape.grid, shape.pattern, shape.size, places.regions, tuple(follow)
        ),
        laminate=laminate,
        element=model.element,
        supports=supports,
        cases=cases,
        outputs=tuple(output for output in outputs if output is not None),
        modes=model.modes,
        buckling=model.buckling,
        story=model.story.strip(),
        origins=Origins(Place(node.file), _keys(node), records),
        hinges=hinges,
        foundations=foundations,
        notes=() if places.body is None else places.body.notes,
    )
    return file if not places.has_circles else replace(file, drawing=_drawing(node, drawn, file))


def _drawing(node: Node, drawn: tuple[float, int] | None, file: PlateFile) -> Drawing:
    """How `file` is read again with other circles."""
    return Drawing(
        lambda size, finer: read_plate(node, (size, finer)),
        drawn,
        file.geometry,
        file.supports,
        file.cases,
        file.hinges,
        file.outputs,
    )


def _keys(node: Node) -> dict[str, Place]:
    """Places of what stands under the keys at the top."""
    assert isinstance(node, MapNode)
    return {key.text: value.place for key, value in node.pairs if isinstance(key, ScalarNode)}


def _output(
    model: OutputModel, index: int, places: DrawnGeometry, laminate: Laminate | None, bare: str | None
) -> Output:
    """Raises DesignError for a point beside the plate, and for an expectation that is no number."""
    value = str(model.value)
    name = checked_name(model.name or f"{value} {index + 1}", "an output")
    x, y = model.at
    if not places.holds(x, y):
        distance = places.distance(x, y)
        raise DesignError(f"the point ({x:g}, {y:g}) m is {distance:.3g} m off the plate; name a point on it")
    expected = None if model.expected is None else _expected(model.expected, value, laminate, bare)
    return Output(name, model.at, value, expected)


def _expected(value: object, of: str, laminate: Laminate | None, bare: str | None) -> float:
    """A number, a number with a unit, or an expression of the laminate's numbers, SI."""
    quantity = _QUANTITIES[of]
    if not isinstance(value, str):
        return to_si(value, quantity, bare if quantity is units.LENGTH else None)
    if not _NAMED.search(value):
        return to_si(value, quantity)
    result = expression.number(value, _constants(laminate))
    if not math.isfinite(result):
        raise DesignError(f"{value!r} is {result}; it must be finite")
    return result


def _constants(laminate: Laminate | None) -> dict[str, float]:
    """A11 to D66 and the thickness h of a laminate, by name."""
    if laminate is None:
        return {}
    axes = {"11": (0, 0), "12": (0, 1), "16": (0, 2), "22": (1, 1), "26": (1, 2), "66": (2, 2)}
    named = {
        f"{letter}{pair}": float(matrix[at])
        for letter, matrix in zip("ABD", (laminate.A, laminate.B, laminate.D), strict=True)
        for pair, at in axes.items()
    }
    return named | {"h": laminate.thickness}
