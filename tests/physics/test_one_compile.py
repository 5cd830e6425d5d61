"""One compile per topology: a second drawing gives the same program other numbers, and nothing is derived for it.

The survey of a drawing (`lamc.mechanics.survey`) promises that drawings of one structure have one program. Here every
program is derived all the same, and the promise held against it: structures, numbers, then motions, to the last bit.
"""

import warnings
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import lamc
from lamc import examples
from lamc.basics.times import Times
from lamc.codegen.cache import Cache
from lamc.effects import Gravity
from lamc.loops.rank import count_loops
from lamc.mechanics.arranging import arrange
from lamc.mechanics.assembly import symbols_of
from lamc.mechanics.closure import close_cycles
from lamc.mechanics.closure_plan import pattern_of
from lamc.mechanics.derive import derive
from lamc.mechanics.lower import lower
from lamc.mechanics.survey import Survey, can_survey, survey_design
from lamc.mechanism.plan import plan
from lamc.readers.load import load_text
from lamc.records.effect import Effect
from lamc.records.mechanism import Mechanism
from lamc.symbolic.program import Program
from tests.support.closed_mechanisms import ClosedMechanism, closed_mechanisms
from tests.support.every_effect import SAMPLES
from tests.support.every_effect import mechanism as two_links
from tests.support.mechanisms import ALL_PASSIVE, chain, trees
from tests.support.quick import tries
from tests.support.sheets import folded_miura, sheet

NOT_TOLD = {
    "flexible_links",
    "twist_compliance",
}  # of which numbers come later: their designs are derived again
FACTORS = st.floats(0.3, 3.0)


def scaled(mechanism: Mechanism, length: float, mass: float) -> Mechanism:
    """All lengths times `length`, all masses times `mass`: a drawing of the same topology, and of the same zeros."""
    bodies = tuple(
        replace(b, com=length * b.com, mass=mass * b.mass, inertia=mass * length**2 * b.inertia)
        for b in mechanism.bodies
    )
    joints = tuple(replace(j, point=length * j.point, stiffness=1.3 * j.stiffness) for j in mechanism.joints)
    return replace(mechanism, bodies=bodies, joints=joints)


def shifted(mechanism: Mechanism, seed: int) -> Mechanism:
    """Each joint's line moved a little along x: lengths change one by one."""
    rng = np.random.default_rng(seed)
    joints = tuple(
        replace(j, point=np.add(j.point, (rng.uniform(-0.05, 0.05), 0.0, 0.0))) for j in mechanism.joints
    )
    return replace(mechanism, joints=joints)


def taken_apart(mechanism: Mechanism, effects: Sequence[Effect]) -> tuple[Survey, Program]:
    """The survey, and the program, derived."""
    tree = plan(mechanism)
    loops = count_loops(tree) if tree.cuts else None
    survey = survey_design(arrange(tree, effects), effects, loops, {})
    return survey, lower(derive(tree, effects, loops))


def check(first: Mechanism, second: Mechanism, effects: Sequence[Effect], *, must_agree: bool) -> None:
    """Where surveys agree, programs do, and the second's numbers are those that its survey tells."""
    (one, program), (other, derived) = taken_apart(first, effects), taken_apart(second, effects)
    if must_agree:
        assert one.structure == other.structure
    if one.structure == other.structure:
        assert program.structure == derived.structure
        assert other.parameters == derived.parameters
        keys = [number.key for number in program.geometry]
        if not other.knows(keys):
            assert {effect.name for effect in effects} & NOT_TOLD
            return
        told = other.inputs(keys)
        assert list(told) == derived.inputs  # to the last bit: nothing rounds on the way
        assert other.drawn == derived.drawn
        assert program.digest != derived.digest or list(one.inputs([])) == list(other.inputs([]))


@settings(deadline=None, max_examples=tries(40))
@given(mechanism=trees(7), length=FACTORS, mass=FACTORS)
def test_a_scaled_tree_has_the_same_program(mechanism: Mechanism, length: float, mass: float) -> None:
    first = scaled(mechanism, 0.71, 1.0)  # lengths of exactly 1 m are left out of products: another program
    check(first, scaled(first, length, mass), ALL_PASSIVE, must_agree=abs(length - 1.0) > 0.01)


@settings(deadline=None, max_examples=tries(40))
@given(mechanism=trees(6), seed=st.integers(0, 2**32 - 1))
def test_a_tree_of_other_lengths_has_the_same_program_or_another_survey(
    mechanism: Mechanism, seed: int
) -> None:
    check(mechanism, shifted(mechanism, seed), ALL_PASSIVE, must_agree=False)


@settings(deadline=None, max_examples=tries(25))
@given(closed=closed_mechanisms(), length=FACTORS, mass=FACTORS)
def test_a_scaled_loop_has_the_same_program(closed: ClosedMechanism, length: float, mass: float) -> None:
    tree = plan(closed.mechanism)
    if can_survey(arrange(tree, ALL_PASSIVE)):
        check(closed.mechanism, scaled(closed.mechanism, length, mass), ALL_PASSIVE, must_agree=False)


@pytest.mark.parametrize("name", sorted(SAMPLES))
def test_numbers_of_every_effect_are_told(name: str) -> None:
    first, effects = scaled(two_links(), 0.97, 1.0), (SAMPLES[name],)
    check(first, scaled(first, 1.01, 1.2), effects, must_agree=False)


def test_a_spatial_chain_of_other_lengths_has_the_same_program() -> None:
    check(shifted(chain(5), 1), shifted(chain(5), 2), ALL_PASSIVE, must_agree=True)


def test_a_hinge_that_becomes_parallel_is_another_structure() -> None:
    first = two_links()
    turned = tuple(replace(j, axis=np.array([0.0, 1.0, 0.0])) for j in first.joints)
    one, _ = taken_apart(first, ALL_PASSIVE)
    other, _ = taken_apart(replace(first, joints=turned), ALL_PASSIVE)
    assert one.structure != other.structure


@pytest.mark.slow
def test_the_second_drawing_compiles_and_derives_nothing_and_moves_as_if_it_had(tmp_path: Path) -> None:
    for name in ("four_bar", "flapping_wing", "limit_stop"):
        made = lamc.load(examples.path(name))
        first = made if isinstance(made, Mechanism) else lamc.split(made)
        second = scaled(replace(first, design=None), 1.1, 1.3)
        shared, times = Cache(tmp_path / "shared"), Times()
        lamc.compile(replace(first, design=None), cache=shared)
        quick = lamc.compile(second, times=times, cache=shared)
        assert times.from_cache
        assert "derive" not in times.seconds
        alone = lamc.compile(second, cache=Cache(tmp_path / f"{name} alone"))
        a, b = quick.run(0.05), alone.run(0.05)
        for one, other in ((a.t, b.t), (a.q, b.q), (a.u, b.u)):
            assert np.array_equal(one, other)
        assert quick.model.digest == alone.model.digest == alone.program.digest == quick.program.digest
        assert dict(quick.parameters) == dict(alone.parameters)


def test_generated_c_has_no_number_of_the_design_but_its_defaults(tmp_path: Path) -> None:
    from lamc.codegen.emit import emit, without_numbers

    mechanism = scaled(replace(lamc.split(lamc.load(examples.path("four_bar"))), design=None), 0.9, 1.0)
    texts = []
    for each in (mechanism, scaled(mechanism, 1.7, 2.0)):
        tree = emit(lamc.compile(each, cache=Cache(tmp_path)).program)
        texts.append({name: without_numbers(tree.files[name]) for name in tree.compiled})
    assert texts[0] == texts[1]


def test_another_topology_is_compiled_anew_and_says_so(tmp_path: Path) -> None:
    made = lamc.load(examples.path("four_bar"))
    sim = lamc.compile(made, cache=Cache(tmp_path))
    assert isinstance(made, lamc.Design)
    longer = sim.with_design(made.with_parameters(arm_length=0.045))  # of one topology: nothing is said
    assert longer.structure == sim.structure
    assert longer.model.digest != sim.model.digest
    with pytest.warns(lamc.DesignWarning, match=r"compiled anew.*bodies gone: .*joints gone: "):
        other = sim.with_design(two_links(), lamc.Scene(effects=()))
    assert other.structure != sim.structure


def test_a_free_base_has_the_digest_of_a_compile_of_its_own(tmp_path: Path) -> None:
    """The state as drawn has numbers of the drawing too: where the base's centre of mass is."""
    scene = lamc.Scene(effects=(SAMPLES["free_base"],))
    first, shared, times = scaled(two_links(), 0.97, 1.0), Cache(tmp_path / "shared"), Times()
    lamc.compile(first, scene, cache=shared)
    quick = lamc.compile(scaled(first, 1.1, 1.2), scene, times=times, cache=shared)
    assert "derive" not in times.seconds
    assert quick.model.digest == quick.program.digest


def of_sheet(count: int, theta: float, gamma: float = 1.0) -> Mechanism:
    return sheet(folded_miura(count, theta, gamma))


@pytest.mark.parametrize("count", [3, 4, 5])
@pytest.mark.quick("4", others="campaign")
def test_sheets_of_one_plan_have_one_program(count: int) -> None:
    """Loops of many hinges are eliminated by a plan that follows from numbers; where it is the same, so is the
    program, and symmetry leaves many numbers that are equal but for round-off."""
    first = of_sheet(count, 1.0)
    for factor in (0.31, 1.3, 1.7):  # which of like vertices comes first must not be for round-off to choose
        check(first, scaled(first, factor, 0.6), ALL_PASSIVE, must_agree=True)
    check(first, of_sheet(count, 1.01), ALL_PASSIVE, must_agree=True)


@pytest.mark.parametrize("count", [3, 4, 5, 6])
@pytest.mark.quick("4", others="campaign")
def test_fold_angles_of_a_sheet_have_few_programs(count: int) -> None:
    """Of 12, flat to folded, where no number is one: two or three, whatever the size."""
    effects = (Gravity(),)
    structures = set()
    for theta in np.linspace(0.41, 1.44, 12):
        tree = plan(of_sheet(count, float(theta)))
        structures.add(survey_design(arrange(tree, effects), effects, count_loops(tree), {}).structure)
    assert len(structures) <= 3


@pytest.mark.slow
def test_another_fold_angle_runs_by_the_same_code(tmp_path: Path) -> None:
    sim = lamc.compile(of_sheet(3, 1.0), cache=Cache(tmp_path / "shared"))
    for theta in (0.85, 1.3):
        drawn = of_sheet(3, theta)
        other = sim.with_design(drawn)
        alone = lamc.compile(drawn, cache=Cache(tmp_path / "alone"))
        assert other.structure == sim.structure
        a, b = other.run(0.05), alone.run(0.05)
        for one, two in ((a.t, b.t), (a.q, b.q), (a.u, b.u)):
            assert np.array_equal(one, two)


@pytest.mark.parametrize(("theta", "gamma"), [(0.41, 1.05), (0.7, 1.0), (1.3, 1.0), (1.44, 1.05)])
@pytest.mark.parametrize("count", [3, 4, 5])
@pytest.mark.quick("3-0.41-1.05", "4-1.3-1.0", others="campaign")
def test_sheets_of_other_angles_have_the_program_of_their_survey(
    count: int, theta: float, gamma: float
) -> None:
    check(of_sheet(count, 1.0), of_sheet(count, theta, gamma), ALL_PASSIVE, must_agree=False)


@settings(deadline=None, max_examples=tries(15))
@given(seed=st.integers(0, 2**32 - 1))
def test_rough_sheets_have_the_program_of_their_survey(seed: int) -> None:
    """Vertices moved at random: plans of one and another differ or not, and the survey knows."""
    rng = np.random.default_rng(seed)
    vertices = folded_miura(3)
    rough = [sheet(vertices + rng.normal(0.0, 0.01, vertices.shape), diagonals=True) for _ in range(2)]
    check(*rough, ALL_PASSIVE, must_agree=False)


def test_the_plan_of_a_survey_is_that_of_the_equations() -> None:
    for mechanism in (of_sheet(4, 1.0), lamc.split(lamc.load(examples.path("folding_box")))):
        tree = plan(mechanism)
        loops = count_loops(tree)
        derived = derive(tree, ALL_PASSIVE, loops).pattern
        symbols = symbols_of(arrange(tree, ALL_PASSIVE), {})
        own = pattern_of(close_cycles(tree, symbols.q, symbols.u), symbols.q, loops)
        assert derived == own
        assert own.plan


def test_a_box_of_other_lengths_is_not_derived_again(tmp_path: Path) -> None:
    first = replace(lamc.split(lamc.load(examples.path("folding_box"))), design=None)
    second, shared, times = scaled(first, 1.1, 1.3), Cache(tmp_path / "shared"), Times()
    lamc.compile(first, cache=shared)
    quick = lamc.compile(second, times=times, cache=shared)
    assert times.from_cache
    assert "derive" not in times.seconds
    alone = lamc.compile(second, cache=Cache(tmp_path / "alone"))
    a, b = quick.run(0.02), alone.run(0.02)
    for one, other in ((a.t, b.t), (a.q, b.q), (a.u, b.u)):
        assert np.array_equal(one, other)
    assert quick.model.digest == alone.model.digest == alone.program.digest == quick.program.digest


SKEWED = """
units: mm
parameters: {length: {default: 60 mm, min: 40 mm}, skew: 0 mm, rise: {default: 0.3 mm, min: 0.1 mm}}
materials:
  card: {density: 700, rigid: true}
  film: {density: 1390, flexible: true}
layers: [{name: low, material: card, thickness: rise}, {name: film, material: film, thickness: 0.025}]
shapes: [{rect: [-20, 0, length, 10]}]
hinges:
  - {name: hip, line: [[0, 0], [0, 10]], gap: 0.5}
  - {name: knee, line: [[length/2, 0], [length/2 + skew, 10]], gap: 0.5}
fixed: [{rect: [-20, 0, -10, 10]}]
"""


@pytest.mark.slow
@settings(deadline=None, max_examples=6)
@given(
    points=st.lists(
        st.tuples(st.floats(0.045, 0.09), st.sampled_from([0.0, 0.0, 0.002, -0.003]), st.floats(1e-4, 1e-3)),
        min_size=2,
        max_size=6,
    )
)
def test_a_way_through_several_topologies_has_the_equations_of_each(
    points: list[tuple[float, float, float]], tmp_path_factory: pytest.TempPathFactory
) -> None:
    """What simulators made one of another have in common is looked for once: code, compiler. Hinges that are parallel
    at some points and not at others are other equations; each point has those that are derived for it."""
    root = tmp_path_factory.getbasetemp() / "skewed"
    design = load_text(SKEWED, "skewed.yaml")
    assert isinstance(design, lamc.Design)
    sim = lamc.compile(design, cache=Cache(root / "shared"))
    told = {}
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", lamc.DesignWarning)  # that another is compiled anew
        for length, skew, rise in points:
            drawn = design.with_parameters(length=length, skew=skew, rise=rise)
            sim = sim.with_design(drawn)
            alone = lamc.compile(drawn, cache=Cache(root / "alone"))
            derived = alone.program
            assert (sim.structure, sim.model.digest) == (derived.structure, derived.digest)
            told[skew == 0.0] = sim.structure
            a, b = sim.run(0.02), alone.run(0.02)
            assert np.array_equal(a.t, b.t)
            assert np.array_equal(a.q, b.q)
    assert len(set(told.values())) == len(told)
