"""A file with other values of its parameters: what is validated again gives what validating all of it gives."""

from pathlib import Path
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import lamc
from lamc import examples
from lamc.basics.errors import DesignError
from lamc.basics.fields import EXPRESSIONS
from lamc.readers.checking import validated
from lamc.readers.fields import LENGTH_UNIT
from lamc.readers.inert import compose, plain
from lamc.readers.kept_model import KeptModel
from lamc.readers.native import length_unit_of
from lamc.readers.numbers import Numbers
from lamc.readers.parameters_section import read_parameters
from lamc.readers.schema import DesignModel

# Names within names, in names of layers, in defaults of one another.
TEXT = """
units: mm
parameters: {x: {default: 30 mm, min: 1 mm, max: 99 mm}, xx: 2*x, e1: 3, w: 10 mm}
materials:
  card: {density: 100*e1 + 400, rigid: true}
  film: {density: 1390, E1: 2.5 GPa, poisson: 0.34, flexible: true}
layers:
  - {name: low, material: card, thickness: 0.3}
  - {name: x_film, material: film, thickness: x/1000}
shapes:
  - {rect: [-20, 0, x, w], layers: all}
  - {cut: {rect: [xx/4, 0, xx/4 + 1, "min(w, 20 mm)/2"]}}
  - {circle: {center: [-10, 5], radius: 1}}
hinges:
  - {name: knee, line: [[0, 0], [0, w]], layer: x_film, gap: 0.5, limits: [-1, 1]}
fixed:
  - {rect: [-20, 0, -10, w]}
bodies: {leg: [x/2, w/4], root: {at: [-15, 1], layer: low}}
contact_points: [[1, 1]]
scene: {angles: {knee: 0.1}}
"""


class Read:
    """A file, its model kept and its model from nothing."""

    def __init__(self, text: str) -> None:
        self.node = compose(text, "drawn.yaml")
        self.unit = length_unit_of(self.node)
        self.declared = read_parameters(self.node, self.unit)
        self.data: Any = plain(self.node)
        self.kept = KeptModel()

    def both(self, values: dict[str, float]) -> tuple[object, object]:
        def attempt(make: Any) -> object:
            numbers = Numbers(self.declared, values)
            context = {LENGTH_UNIT: self.unit, EXPRESSIONS: numbers}
            try:
                return make(context, numbers)
            except DesignError as error:
                return str(error)

        kept = attempt(lambda context, numbers: self.kept.model(self.node, self.data, context, numbers))
        return kept, attempt(lambda context, _: validated(DesignModel, self.node, self.data, context))


LENGTHS = st.one_of(st.sampled_from([0.03, 0.001, 0.099]), st.floats(0.001, 0.099))


@settings(deadline=None, max_examples=60)
@given(
    points=st.lists(
        st.fixed_dictionaries(
            {}, optional={"x": LENGTHS, "w": st.floats(-0.01, 0.05), "e1": st.floats(-6.0, 9.0)}
        ),
        max_size=6,
    )
)
def test_what_is_validated_again_is_the_whole(points: list[dict[str, float]]) -> None:
    """Densities below nought are refused, by the same words."""
    file = Read(TEXT)
    for values in points:
        kept, whole = file.both(values)
        assert kept == whole


def test_entries_that_no_parameter_moves_are_kept() -> None:
    file = Read(TEXT)
    first, _ = file.both({})
    other, _ = file.both({"e1": 4.0})
    assert isinstance(first, DesignModel)
    assert isinstance(other, DesignModel)
    assert other.materials["film"] is first.materials["film"]
    assert other.materials["card"].density == 800.0
    assert all(a is b for a, b in zip(other.hinges, first.hinges, strict=True))


def test_a_scene_that_follows_from_a_parameter_does() -> None:
    file = Read(TEXT.replace("knee: 0.1", "knee: e1/10"))
    for e1 in (1.0, 2.0):
        kept, whole = file.both({"e1": e1})
        assert kept == whole
        assert isinstance(kept, DesignModel)
        assert kept.scene is not None
        assert kept.scene.angles == {"knee": e1 / 10}


@pytest.mark.slow
@pytest.mark.parametrize("name", ["four_bar", "flapping_wing"])
@settings(deadline=None, max_examples=10)
@given(data=st.data())
def test_designs_are_those_of_a_file_read_afresh(name: str, data: st.DataObject) -> None:
    """To the last bit: masses and centres of what is drawn."""
    design = lamc.load(examples.path(name))
    assert isinstance(design, lamc.Design)
    for _ in range(3):
        values = {
            each: data.draw(st.floats(0.97, 1.03)) * known.default
            for each, known in design.parameters.items()
            if data.draw(st.booleans())
        }
        try:
            design = design.with_parameters(values)
        except DesignError:
            continue
        given_ = {each: known.default for each, known in design.parameters.items()}
        fresh = lamc.load(Path(examples.path(name)), set=given_)
        assert isinstance(fresh, lamc.Design)
        assert fresh == design
