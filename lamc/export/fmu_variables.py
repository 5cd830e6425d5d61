"""The variables of an FMU: what a program and a start come to in FMI's words.

In: a `Program` and the state at which it starts. Out: `Variable`s in the order of their references, which is the order
in which `templates/export/fmu/slave.h` counts them. Never: writes XML or C.

Names follow FMI's structured convention, `h1.angle`, `link_1.position[1]`, `der(h1.rate)`: a part of a name that is no
identifier stands in quotes, and what quotes cannot hold becomes an underscore.
"""

import re
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import count
from math import inf

from lamc.export.fmu_dependencies import Slots, dependencies, named
from lamc.run.parameters import Bounds, bounds
from lamc.symbolic.program import Coordinate, Parameter, Program, Space

_AXES = (1, 2, 3)
_PLAIN = re.compile(r"[A-Za-z_][A-Za-z0-9_]*")
_UNQUOTABLE = re.compile(r"[^A-Za-z0-9_!#$%&()*+,\-./:;<>=?@\[\]^{}|~ ]")
UNBOUNDED = Bounds(-inf, False, inf)


@dataclass(frozen=True)
class Variable:
    """One scalar variable. Its reference is its place among the variables, from 0."""

    name: str
    unit: str  # as lamc writes it; "1": none
    description: str
    causality: str  # of FMI, as the next two
    variability: str = "continuous"
    initial: str = "calculated"
    start: float | None = None
    bounds: Bounds = UNBOUNDED
    derivative_of: int | None = None  # reference of the state whose derivative it is
    dependencies: tuple[int, ...] = ()  # references of the states and inputs behind it, while it steps


def variables(
    program: Program, parameters: Sequence[int], inputs: Sequence[int], start: Sequence[float]
) -> tuple[Variable, ...]:
    """All variables. parameters, inputs: places among the program's parameters; start: state (nq + nu,) at t = 0."""
    return tuple(_Listing(program, parameters, inputs, start).found)


class _Listing:
    """Makes the variables one kind after the other; references of what others depend on are known as soon as it is."""

    def __init__(
        self, program: Program, parameters: Sequence[int], inputs: Sequence[int], start: Sequence[float]
    ) -> None:
        self.program, self.start = program, start
        self.behind = dependencies(program)
        self.names = _Names()
        self.references: dict[tuple[Space, int], int] = {}
        self.found: list[Variable] = []
        self._add(Variable(self.names.take("time"), "s", "time", "independent", initial=""))
        self.add_parameters(parameters)
        self.add_inputs(inputs)
        self.add_states()
        self.add_derivatives()
        self.add_poses()
        self.add_energies()

    def _add(self, variable: Variable, slots: Slots = frozenset()) -> None:
        self.found.append(replace(variable, dependencies=named(slots, self.references)))

    def add_parameters(self, places: Sequence[int]) -> None:
        for place in places:
            # A guard that a parameter moves would pass zero without an event.
            moves_guards = (Space.PARAMETER, place) in self.behind.guards
            variability = "fixed" if moves_guards else "tunable"
            self._add(self._settable(self.program.parameters[place], "parameter", variability))

    def add_inputs(self, places: Sequence[int]) -> None:
        for place in places:
            self.references[Space.PARAMETER, place] = len(self.found)
            self._add(self._settable(self.program.parameters[place], "input", "continuous"))

    def _settable(self, parameter: Parameter, causality: str, variability: str) -> Variable:
        return Variable(
            self.names.take(".".join(map(_part, parameter.name.split(".")))),
            parameter.unit,
            parameter.meaning,
            causality,
            variability,
            "exact",
            parameter.default,
            bounds(parameter.name),
        )

    def add_states(self) -> None:
        """Coordinates, then rates. Where loops are to be closed, a start is a guess."""
        program = self.program
        joints, nq = len(program.joints), len(program.coordinates)
        initial = "approx" if program.cuts else "exact"
        for space, entries in ((Space.ANGLE, program.coordinates), (Space.RATE, program.rates)):
            self.references |= {(space, i): len(self.found) + i for i in range(len(entries))}
            is_angle = space is Space.ANGLE
            for i, entry in enumerate(entries):
                is_slope = not is_angle and "rates" not in program.functions
                variable = Variable(
                    self._state_name(entry, i < joints, is_angle),
                    entry.unit,
                    _state_meaning(i < joints, is_angle),
                    "output",
                    initial=initial,
                    start=float(self.start[i if is_angle else nq + i]),
                    derivative_of=self.references[Space.ANGLE, i] if is_slope else None,
                )
                self._add(variable, frozenset({(space, i)}))

    def _state_name(self, entry: Coordinate, is_joint: bool, is_angle: bool) -> str:
        if not is_joint:
            return self.names.take(".".join(map(_part, entry.name.split("."))))
        return self.names.take(f"{_part(entry.name)}.{'angle' if is_angle else 'rate'}")

    def add_derivatives(self) -> None:
        """Of coordinates, where they are not the rates, and of rates."""
        kinds = [(Space.RATE, self.behind.accelerations)]
        if "rates" in self.program.functions:
            kinds.insert(0, (Space.ANGLE, self.behind.slopes))
        for space, behind in kinds:
            for i, slots in enumerate(behind):
                state = self.references[space, i]
                known = self.found[state]
                unit = f"{known.unit}²" if known.unit.endswith("/s") else f"{known.unit}/s"
                variable = Variable(
                    self.names.take(f"der({known.name})"),
                    unit,
                    f"derivative of {known.name} by time",
                    "output",
                    derivative_of=state,
                )
                self._add(variable, slots)

    def add_poses(self) -> None:
        """Twelve of each moving body, as the C tells them."""
        places = [("position", f"[{i}]", "m") for i in _AXES]
        places += [("rotation", f"[{i},{j}]", "1") for i in _AXES for j in _AXES]
        meanings = {
            "position": "centre of mass in the world",
            "rotation": "rotation from axes of the drawing, row and column",
        }
        for b, body in enumerate(self.program.bodies):
            names = self.names.take_group(lambda p: [f"{p}.{w}{index}" for w, index, _ in places], body)
            for k, (what, _, unit) in enumerate(places):
                self._add(Variable(names[k], unit, meanings[what], "output"), self.behind.poses[12 * b + k])

    def add_energies(self) -> None:
        """Each, then their sum, then the gap of the loops if there are any."""
        for name, slots in zip(self.program.energies, self.behind.energies, strict=True):
            self._add(
                Variable(self.names.take(f"energy.{_part(name)}"), "J", f"energy: {name}", "output"), slots
            )
        total = frozenset().union(*self.behind.energies)
        self._add(
            Variable(self.names.take("energy.total"), "J", "kinetic and stored energy", "output"), total
        )
        if self.program.cuts:
            meaning = "largest gap at a joint that closes a loop"
            self._add(Variable(self.names.take("closure_gap"), "m", meaning, "output"), self.behind.gap)


class _Names:
    """Names given so far, each once."""

    def __init__(self) -> None:
        self._taken: set[str] = set()

    def take(self, name: str) -> str:
        """`name`, or the first of name_2, name_3, … that is free."""
        return next(self._free(lambda suffix: [_suffixed(name, suffix)]))[0]

    def take_group(self, make: Callable[[str], list[str]], text: str) -> list[str]:
        """The names that make(part) gives of the first part like `text` for which all of them are free."""
        return next(self._free(lambda suffix: make(_part(text + suffix))))

    def _free(self, names: Callable[[str], list[str]]) -> Iterator[list[str]]:
        for number in count(1):
            candidates = names("" if number == 1 else f"_{number}")
            if not self._taken.intersection(candidates):
                self._taken.update(candidates)
                yield candidates


def _suffixed(name: str, suffix: str) -> str:
    """`suffix` put into the last part of a name, inside its quote or bracket."""
    tail = re.search(r"['\])]*$", name)
    cut = tail.start() if tail else len(name)
    return name[:cut] + suffix + name[cut:]


def _part(text: str) -> str:
    """`text` as one part of a structured name."""
    if _PLAIN.fullmatch(text):
        return text
    return f"'{_UNQUOTABLE.sub('_', text) or '_'}'"


def _state_meaning(is_joint: bool, is_angle: bool) -> str:
    if is_joint:
        return "angle of the joint, zero as drawn" if is_angle else "rate of the joint"
    return "coordinate" if is_angle else "rate"
