"""What a design is but for its numbers, and the numbers: of a drawing whose equations are known already.

In: an `Arrangement`, effects, inputs, loops. Out: a `Survey`: the digest of a structure, and the value of each
parameter and of each number of the drawing. Two designs of one digest have one program but for those numbers, to the
last bit, so that nothing is derived, printed or compiled for the second. Effects have their turn here, as only they
know what they bring, and loops of many hinges are closed, as the plan of their elimination follows from numbers;
nothing is solved.

The digest is cautious: it holds more than equations follow from (zeros and ones of numbers that they may not hold, all
that effects stage). Designs that could share a program may differ in it; designs that could not never agree.
"""

import hashlib
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import TYPE_CHECKING

from lamc.loops.cycles import short_cycles
from lamc.loops.rank import LoopCount
from lamc.mechanics.arrangement import Arrangement
from lamc.mechanics.assembly import Symbols, symbols_of
from lamc.mechanics.closure import close_cycles
from lamc.mechanics.closure_plan import FEW, pattern_of
from lamc.mechanics.cycle_closure import Line, line_numbers, lines_of
from lamc.mechanics.derive import begin_plain
from lamc.mechanics.drawn import link_numbers
from lamc.mechanics.general import begin_general
from lamc.mechanics.loads import Loads
from lamc.mechanics.tangents import PACE
from lamc.mechanism.tree import WORLD, Tree
from lamc.records.inputs import Input
from lamc.records.mechanism import Array
from lamc.symbolic.allocation import collector_paused
from lamc.symbolic.program import Parameter
from lamc.symbolic.scalars import Value
from lamc.symbolic.staging import CONSTANT, DrawnKey, Store, Symbol

if TYPE_CHECKING:
    from lamc.records.effect import Effect


@dataclass(frozen=True)
class Survey:
    """A design, taken apart.

    structure   digest of all but numbers
    parameters  in the order of the program's
    values      of the numbers of the drawing, by their keys, in SI units; more than a program may hold
    drawn       state at rest as drawn, (nq + nu,); empty: all zero
    """

    structure: str
    parameters: tuple[Parameter, ...]
    values: Mapping[DrawnKey, float]
    drawn: tuple[float, ...]

    def knows(self, keys: Sequence[DrawnKey]) -> bool:
        """Whether it tells all of these; equations of bodies that bend hold numbers that come of solving."""
        return all(key in self.values or key[0] == PACE for key in keys)

    def inputs(self, keys: Sequence[DrawnKey]) -> tuple[float, ...]:
        """What `setup` takes of a program that holds the numbers of these keys; paces along dimensions are zero."""
        return (*(p.default for p in self.parameters), *(self.values.get(key, 0.0) for key in keys))


def can_survey(arrangement: Arrangement) -> bool:
    """Whether a survey tells all: not of loops in which something yields, whose rank follows from equations. They are
    derived, and their programs compared."""
    yields = len(arrangement.plain_coordinates) > len(arrangement.tree.hinges)
    return not (arrangement.tree.cuts and yields)


@collector_paused
def survey_design(
    arrangement: Arrangement,
    effects: "Sequence[Effect]",
    loops: LoopCount | None,
    inputs: Mapping[str, Input],
) -> Survey:
    """The survey of a design for which `can_survey` holds. Raises DesignError where an effect does not fit."""
    tree = arrangement.tree
    symbols = symbols_of(arrangement, inputs)
    begin = begin_plain if arrangement.is_plain else begin_general
    loads = begin(symbols, arrangement, effects)[-1]
    store, parameters = symbols.store, tuple(symbols.parameters.records)
    rings = lines_of(short_cycles(tree), tree.hinges, tree.mechanism.size) if tree.cuts else []
    drawn = dict((*link_numbers(tree), *line_numbers(rings), *_of_base(loads, tree)))
    text = hashlib.sha256()
    for part in (
        *_of_tree(tree, rings, loops),
        *map(_of_parameter, parameters),
        "".join(map(_kind, drawn.values())),
        *_of_store(store),
        *_of_loads(loads),
    ):
        text.update(part.encode())
        text.update(b"\n")
    values = drawn | {key: float(store.payloads[index]) for key, index in store.drawn.items()}  # type: ignore[arg-type]
    values |= {("size",): tree.mechanism.size, ("gap",): loops.accepted_gap if loops is not None else 0.0}
    if loops is not None and len(tree.hinges) > FEW:
        text.update(_of_plan(symbols, tree, loops).encode())
    return Survey(text.hexdigest(), parameters, MappingProxyType(values), arrangement.displaced)


def _of_base(loads: Loads, tree: Tree) -> Iterator[tuple[DrawnKey, float]]:
    """Arms of a base that moves, to the links on it and to the centres of its bodies."""
    base = loads.placement.base
    if base is None:
        return
    points: dict[DrawnKey, Array] = {
        ("arm", index): link.origin for index, link in enumerate(tree.links) if link.parent == WORLD
    }
    points |= {("base body", body.name): body.com for body in tree.mechanism.bodies if body.fixed}
    for key, point in points.items():
        for place, value in enumerate((point - base.reference).tolist()):
            yield (*key, place), value


def _of_plan(symbols: Symbols, tree: Tree, loops: LoopCount) -> str:
    """How loops of many hinges are eliminated, which follows from numbers: they are closed as equations close them, in
    the same operations, so that the same plan comes of it to the last bit."""
    count = len(tree.hinges)
    closure = close_cycles(tree, symbols.q[:count], symbols.u[:count])
    return repr(pattern_of(closure, symbols.q, loops))


def _kind(value: float) -> str:
    """Zeros and ±1 are structure; what else a number is, equations do not see."""
    return {0.0: "0", 1.0: "+", -1.0: "-"}.get(value, "x")


def _of_parameter(parameter: Parameter) -> str:
    given = parameter.is_input and parameter.default != 0.0
    return repr(
        (parameter.name, parameter.unit, parameter.meaning, parameter.effect, parameter.is_input, given)
    )


def _of_tree(tree: Tree, rings: Sequence[Sequence[Line]], loops: LoopCount | None) -> Iterator[str]:
    yield repr((tree.mechanism.name, [(b.name, b.fixed) for b in tree.mechanism.bodies]))
    for link in tree.links:
        joint = link.joint
        yield repr((link.body.name, joint.name, joint.parent, joint.child, link.parent))
        yield repr((link.angle_sign, link.parallel, [_kind(v) for v in (*link.twist, *link.fold, *link.com)]))
    yield repr([(cut.joint.name, cut.joint.parent, cut.joint.child) for cut in tree.cuts])
    yield repr([[(line.joint, line.key) for line in ring] for ring in rings])
    yield repr((loops.rank, loops.equations)) if loops is not None else ""


def _of_store(store: Store) -> Iterator[str]:
    """All nodes that there are by now; of numbers of the drawing what they are."""
    yield repr(store.operations)
    yield repr(store.arguments)
    yield repr(store.link_of)
    yield repr((store.section_of, store.sections))
    for index, payload in store.payloads.items():
        if isinstance(payload, Symbol):
            yield f"{index} {payload.name} {payload.space} {payload.index}"
        elif store.operations[index] != CONSTANT:
            yield f"{index} {payload!r}"
    yield repr(list(store.drawn.items()))
    yield repr(store.tables)


def _of_loads(loads: Loads) -> Iterator[str]:
    """What effects left, by nodes and signs."""
    yield _texts(loads.hinge_torques)
    yield _texts(loads.field)
    for link, (force, moment) in sorted(loads.wrenches.items()):
        yield f"{link} {_texts(force)} {_texts(moment)}"
    yield repr([(name, _texts([value])) for name, value in loads.energies.items()])
    yield repr([(name, _texts(field)) for name, field in loads.field_effects])
    yield repr([(index, _texts([force])) for index, force in sorted(loads.generalised.items())])
    for name, account in loads.accounts.items():
        rows = (*sorted(account.torques.items()), *sorted(account.generalised.items()))
        yield repr((name, [(index, _texts([load])) for index, load in rows]))
        yield repr([(index, _texts((*f, *m))) for index, (f, m) in sorted(account.wrenches.items())])
    for added in loads.added:
        yield repr((added.effect, added.link, _texts(added.arm), [_texts(row) for row in added.matrix]))
    for place, reflected in sorted(loads.reflected.items()):
        yield repr([(place, effect, _texts([inertia])) for effect, inertia in reflected])
    for guard in loads.guards:
        yield repr((guard.name, _texts([guard.value, guard.mode, guard.restitution])))
        if guard.clock is not None:
            held = [*guard.clock.held, *guard.clock.held.values()]
            yield _texts([guard.clock.period, guard.clock.tick, *held])


def _texts(values: Iterable[object]) -> str:
    """Nodes with their signs; plain numbers as they are."""
    return " ".join(f"{v.sign}#{v.index}" if isinstance(v, Value) else repr(v) for v in values)
