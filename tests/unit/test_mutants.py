"""Whatever is done to a file that can be read, reading it ends within seconds: with a record, or with a LamcError.

Files are damaged as trees, so that they stay YAML and the damage reaches what lies behind the parser: splitting,
overlays, supports, scenes. `MUTANTS=3000 pytest -m slow tests/unit/test_mutants.py` tries more of them.
"""

import os
import random
import time
from collections.abc import Callable, Sequence
from functools import cache
from pathlib import Path

import pytest

from lamc import examples
from lamc.basics.errors import LamcError
from lamc.design.split import split_steps
from lamc.effects.registry import choose
from lamc.examples import plates as plate_examples
from lamc.mechanism.plan import plan
from lamc.plates.designs.from_design import plate_of
from lamc.readers.inert import compose
from lamc.readers.load import load_text
from lamc.readers.load_scene import scene_of_text
from lamc.readers.nodes import Node
from lamc.readers.plates import problem_make
from lamc.readers.plates.problem_file import plate_of_text
from lamc.readers.plates.problem_make import problem_of
from lamc.records.design import Design
from lamc.records.mechanism import Mechanism
from tests.support.mechanisms import chain
from tests.support.mutants import mutant
from tests.unit.test_popupcad import buffer_operation, cad, laminate_operation, sketch_operation
from tests.unit.test_popupcad_forms import FROM, TO, internal, line_sketch, with_inner
from tests.unit.test_popupcad_kinds import BOTH, JOINED, frozen, operation
from tests.unit.test_scenes import SCENES

FIXTURES = Path(__file__).resolve().parents[1] / "fixtures" / "designs"
MUTANTS = int(os.environ.get("MUTANTS", "150"))  # of each kind
PROMISE = 5.0  # s of processor time, of one thread, on the machine on which limits were measured
PATIENCE = 3.0 * PROMISE  # machines that run tests are slower, and their caches are shared with other tests
CELLS = (
    20_000  # of plates here; the limit of cells has tests of its own, and meshing takes long before it is met
)


def _cads() -> list[str]:
    changed = (
        buffer_operation(7, 8, "[-0.5, 5]")
        + operation("Cleanup2", "operation_links: {parent: [[7, 0]]}, values: [0.5, 5]").replace("id: 7", "id: 21")
        + operation("Simplify2", "operation_links: {parent: [[21, 0]]}, values: [0.01]").replace("id: 7", "id: 22")
        + laminate_operation(23, "difference", "[[22, 0]]", "[[6, 0]]")
        + laminate_operation(24, "symmetric_difference", "[[23, 0]]", "[[1, 0]]")
        + laminate_operation(25, "union", "[[24, 0], [1, 0], [6, 0]]", "[]")
    )  # fmt: skip
    layers = "unary_layer_links: [11], pair_layer_links: [12], output_layer_links: [11, 12]"
    layered = operation("LayerOp2", f"operation_links: {{parent: [[8, 0]]}}, function: union, {layers}")
    return [
        (FIXTURES / "popupcad" / "pendulum.cad").read_text(encoding="utf-8"),
        cad(),
        cad(BOTH + JOINED + changed, parent=25),
        cad(BOTH + JOINED + layered, parent=7),
        cad(frozen(wrapped=False) + laminate_operation(8, "union", "[[7, 0], [1, 0]]", "[]"), parent=8),
        cad(sketch_operation(5, 201) + internal(), parent=7, sketches=FROM + line_sketch(202, TO)),
        with_inner("PlaceOperation8", "sketch_links: {place: [202]}"),
    ]


def _shipped(kind: type) -> list[str]:
    files = [examples.path(name) for name in examples.files()]
    texts = [file.read_text(encoding="utf-8") for file in files if file.suffix == ".yaml"]
    return [text for text in texts if isinstance(load_text(text, "shipped.yaml"), kind)]


SOURCES: dict[str, Callable[[], Sequence[str]]] = {
    "cad": _cads,
    "joints": lambda: [file.read_text(encoding="utf-8") for file in sorted(FIXTURES.glob("*.joints"))],
    "design": lambda: _shipped(Design),
    "mechanism": lambda: _shipped(Mechanism),
    "plate": lambda: [plate_examples.find(name).text for name in plate_examples.names()],
    "scene": lambda: [SCENES],
}


@cache
def trees(kind: str) -> tuple[Node, ...]:
    return tuple(compose(text, f"{kind}.yaml") for text in SOURCES[kind]())


def _design_road(text: str) -> None:
    record = load_text(text, "mutant.yaml")
    if isinstance(record, Design):
        steps = split_steps(record)
        plan(steps.mechanism)
        for hinges in ("strips", "lines"):
            plate_of(steps, "all", hinges=hinges)
    else:
        plan(record)


def _plate_road(text: str) -> None:
    problem_of(plate_of_text(text, "mutant.yaml"))


def _scene_road(text: str) -> None:
    plain = chain(2)
    for name in (None, "heavier"):
        choose(Mechanism(plain.bodies, plain.joints, "m"), scene_of_text(text, "mutant.yaml", name))


ROADS: dict[str, Callable[[str], None]] = dict.fromkeys(
    ("cad", "joints", "design", "mechanism"), _design_road
)
ROADS |= {"plate": _plate_road, "scene": _scene_road}


@pytest.mark.campaign
@pytest.mark.parametrize("kind", sorted(SOURCES))
def test_mutants_are_records_or_errors_within_seconds(kind: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(problem_make, "MOST", CELLS)
    for seed in range(MUTANTS):
        dice = random.Random(seed)
        text = mutant(dice.choice(trees(kind)), dice)
        began = time.thread_time()
        reported = "a record"
        try:
            ROADS[kind](text)
        except LamcError as error:
            reported = str(error)
        assert reported, seed
        assert time.thread_time() - began < PATIENCE, seed
