"""Equal in, equal out: what a stage gives does not depend on what was read of the stage before."""

import itertools
from functools import cache
from pathlib import Path

import pytest

import lamc
from lamc.examples import files, find, names
from lamc.loops.rank import LoopCount, count_loops
from lamc.mechanics.equations import Equations
from lamc.mechanics.lower import lower
from lamc.mechanism.plan import plan
from lamc.pipeline import effects_of, equations_of
from lamc.readers.load import load_text
from lamc.records.mechanism import Mechanism
from lamc.records.scene import Scene
from lamc.symbolic.program import Space

EXAMPLES = sorted(
    [
        *Path(lamc.__file__).parent.joinpath("examples").glob("*.yaml"),
        *Path(lamc.__file__).parent.joinpath("examples").glob("*.cad"),
    ]
)
MADE = sorted(set(names()) - set(files()))
READ = ("inertia", "forces", "powers", "assignments", "mass_matrix", "operations")


@cache
def _mechanism(path: Path | str) -> Mechanism:
    """Of a file, or of an example that is made to a size."""
    loaded = lamc.load(path) if isinstance(path, Path) else load_text(find(path).text, path)
    return lamc.split(loaded) if isinstance(loaded, lamc.Design) else loaded


def _equations(path: Path | str, loops: LoopCount | None = None) -> Equations:
    mechanism = _mechanism(path)
    scene = mechanism.scene or Scene()
    return equations_of(mechanism, effects_of(mechanism, scene), loops=loops, inputs=scene.inputs)


@pytest.mark.parametrize("path", [*EXAMPLES, *MADE], ids=lambda path: getattr(path, "name", path))
@pytest.mark.quick(
    "bricard*",
    "flapping_wing*",
    "flaps*",
    "four_bar*",
    "limit_stop*",
    "n_four_bar*",
    "pendulum*",
    "shutter*",
    "stiff_triple*",
    "vertex*",
)
def test_programs_do_not_depend_on_what_was_read_of_the_equations(path: Path | str) -> None:
    equations = _equations(path)
    untouched = lower(equations).digest
    with_balance = lower(equations, energy_balance=True).digest
    nodes = len(equations.store)
    for name in (*READ, "passes") if equations.is_plain else READ:
        getattr(equations, name)
    with pytest.raises(TypeError):
        equations.inertia[0, 0] = 0  # type: ignore[index]
    assert len(equations.store) == nodes
    assert lower(equations).digest == untouched
    assert lower(equations, energy_balance=True).digest == with_balance


@pytest.mark.slow
def test_what_is_read_does_not_depend_on_the_order_of_reading() -> None:
    texts, path = set(), next(path for path in EXAMPLES if path.stem == "four_bar")
    loops = count_loops(plan(_mechanism(path)))
    for order in itertools.permutations(("inertia", "forces", "powers", "assignments")):
        equations = _equations(path, loops)
        for name in order:
            getattr(equations, name)
        texts.add("\n".join(map(str, (*equations.assignments, *equations.mass_assignments))))
    assert len(texts) == 1


def test_finished_equations_take_no_new_nodes() -> None:
    equations = _equations(next(path for path in EXAMPLES if path.stem == "pendulum"))
    with pytest.raises(RuntimeError, match="forked"):
        equations.store.symbol("another", Space.ANGLE, 99)
    equations.forked().store.symbol("another", Space.ANGLE, 99)
    assert len(equations.forked().store) == len(equations.store)
