"""The `Program`: what `lower` gives and `emit` and the interpreter read.

A program is a handful of functions of straight-line assignments over numbered slots. It holds no sympy object,
no name from the design outside the string tables, and no text in any language.
"""

import hashlib
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from enum import Enum
from fractions import Fraction
from types import MappingProxyType
from typing import TYPE_CHECKING

from lamc.symbolic.pattern import Pattern

if TYPE_CHECKING:
    from lamc.symbolic.piecewise import Piecewise


class Space(Enum):
    """The arrays that a slot can lie in. The value is the letter that the C uses."""

    LOCAL = "z"  # intermediate values of one function
    CONSTANT = "c"  # parameter-only values, made by `setup`, kept for a run
    PARAMETER = "p"  # what a user can change without recompiling
    ANGLE = "q"  # coordinates: joint angles, rad, then others
    RATE = "u"  # rates: of joints, rad/s, then others
    TIME = "t"  # s
    ACCELERATION = "a"  # derivatives of the rates
    MULTIPLIER = "l"  # forces of the closure equations
    WEIGHT = "w"  # of values whose weighted sum is differentiated, or of inputs along a direction
    # of a finite element; units in `lamc/plate/elements/`
    CORNER = "xy"  # coordinates of the corners, x and y of one after the other, m
    SECTION = "s"  # unique entries of the section's stiffness
    AREAL_MASS = "rho"  # kg/m²
    MEMBRANE_FORCE = "n"  # N_x, N_y, N_xy, N/m, tension positive
    INTENSITY = "f"  # forces per area at the corners, N/m²: one field after the other
    RESULTANT = "r"  # membrane forces, N/m, and moments, N
    NATURAL = "xi"  # ξ and η
    UNKNOWN = "d"  # of the element, node by node
    PLY = "y"  # numbers of a ply; units in `lamc/plates/laminates/ply_terms.py`
    NUMBER = "#"  # a literal

    __hash__ = object.__hash__  # in C: slots of a large sheet are looked up millions of times


@dataclass(frozen=True, slots=True)
class Operand:
    """A slot (space, index), or a literal (Space.NUMBER, value)."""

    space: Space
    index: int = 0
    value: float | Fraction = 0.0  # a fraction only where no double holds it and its digits are asked for


# An expression shape: an int is the position of an operand; a tuple is (operation, argument, …). Operations:
# "+", "-", "*" with two arguments, "neg", "reciprocal", the names in `mechanics.functions` with one or two, and
# "table_<number>_<order>" with one: the derivative of that order of one of `Program.tables`.
Shape = int | tuple["str | Shape", ...]


@dataclass(frozen=True, slots=True)
class Statement:
    """`target = shape(operands)`; every slot is assigned once, before it is read."""

    target: Operand
    shape: Shape
    operands: tuple[Operand, ...]
    section: int  # index into Function.sections
    link: int = -1  # link of the tree that it is about; -1: none. Statements of like links become one kernel
    step: int = (
        0  # of what is done for the link; statements of like steps become one kernel where links are unlike
    )


@dataclass(frozen=True, slots=True)
class Section:
    """A run of statements with one origin: shown as a comment in the C."""

    title: str
    effect: str  # name of the effect that called for it; "" for the mechanism itself
    source: str  # the equation it comes from


@dataclass(frozen=True)
class Operations:
    """Counts of one function. `flops` counts + - * and reciprocals; library calls stand apart."""

    additions: int = 0
    multiplications: int = 0
    reciprocals: int = 0
    calls: int = 0

    @property
    def flops(self) -> int:
        return self.additions + self.multiplications + self.reciprocals

    def times(self, count: int) -> "Operations":
        """Of as many calls."""
        return Operations(
            count * self.additions, count * self.multiplications, count * self.reciprocals, count * self.calls
        )

    def __add__(self, other: "Operations") -> "Operations":
        return Operations(
            self.additions + other.additions,
            self.multiplications + other.multiplications,
            self.reciprocals + other.reciprocals,
            self.calls + other.calls,
        )


@dataclass(frozen=True)
class Function:
    """One function: statements in order, then outputs[k] = ±operand, as (sign, operand)."""

    name: str
    purpose: str
    reads: tuple[Space, ...]
    statements: tuple[Statement, ...]
    outputs: tuple[tuple[int, Operand], ...]
    sections: tuple[Section, ...]
    operations: Operations


@dataclass(frozen=True, slots=True)
class Parameter:
    """A number that can change without recompiling."""

    name: str  # the user's name for it, e.g. "h1.stiffness"
    default: float
    unit: str
    meaning: str
    effect: str  # name of the effect that reads it; "" for the mechanism itself
    is_input: bool = field(default=False, repr=False)  # comes from outside while a model runs


@dataclass(frozen=True, slots=True)
class DrawnNumber:
    """A number of the drawing that `setup` is given behind the parameters, in SI units."""

    key: tuple[str | int, ...]  # what it is of the drawing
    value: float


@dataclass(frozen=True, slots=True)
class Coordinate:
    """A coordinate or a rate: its name and unit."""

    name: str
    unit: str


@dataclass(frozen=True, slots=True)
class SeriesInput:
    """An input that follows a series. Its value and its derivatives by time are constants that the runtime keeps."""

    name: str
    unit: str
    meaning: str
    order: int  # of the highest derivative that the accelerations hold


@dataclass(frozen=True, slots=True)
class Guard:
    """A condition whose passing of zero is an event."""

    name: str
    mode: (
        int  # slot in the constants that is 1 beyond the guard and 0 before; -1: an impact; TICKS: of a clock
    )


TICKS = -2


@dataclass(frozen=True)
class Clock:
    """What samples at each multiple of a period. All but the guard are slots in the constants."""

    guard: int  # among the guards
    tick: int  # time of the next sample, s
    held: tuple[int, ...]


@dataclass(frozen=True)
class Program:
    """Everything there is to emit.

    functions, by name:
      "setup"         parameters, then `geometry` → constants, shape (constant_count,); with loops the last two are the
                      mechanism's size, m, and the gap, m, that loops may keep where their equations disagree
      "rates"         where q̇ is not u: q, u → q̇, shape (nq,)
      "acceleration"  t, q, u → u̇, shape (nu,); joints on a fixed world, without loops
                      other mechanisms have instead of it:
      "system"        t, q, u → M, lower triangle by rows, then f of M u̇ = f without the loops
                      and with loops:
      "dynamics"      t, q, u → what "system" gives, then the entries of J and bias γ (m), 1/s², of J u̇ + γ = 0
      "closure"       q → residuals φ (m), rad or parts of the size, then the entries of J, by which φ̇ = J u
                      and in place of "system" and "dynamics", where loops are large:
      "constraints"   q, u → entries of J, γ (m)
      "residual"      t, q, u, u̇ → M u̇ - f (nu,), without the loops
      "momenta"       q, u̇ → M u̇ (nu,), of any rates
      "energy"        t, q, u → energies, J, in the order of `energies` ("kinetic" first)
      "inertia"       beside "acceleration", where impacts or the Jacobian need it: q → M, lower triangle by rows
      "jacobian"      t, q, u, u̇, λ → derivatives (nu + m, nq + nu + 1) by q, u and t of the residuals M u̇ - f - Jᵀλ
                      and J u̇ + γ, then, where there is "rates", (nq, nq + nu) of q̇; absent where it would be too long
      "guards"        where there are any: t, q, u → guards, then their rates
      "impacts"       where there are any: t, q → restitutions of the guards, then derivatives (nu,) of their rates by u
      "tangents"      where it is asked for: t, q, u, u̇, λ → derivatives (nu + m, nq + nu + k) by q, u and k columns of
                      the residuals as in "jacobian", then, where there is "rates", (nq, nq + nu) of q̇
      "directional_tangents"  beside it, where that is shorter: t, q, u, u̇, λ, a direction (nq + nu,) of q and u →
                      derivatives (nu + m,) along it; those of "tangents" are by columns only, then
      "closure_tangents"  beside it, with loops: q, u → derivatives (m, nq + k + nq + nu + k) of φ by q and columns,
                      then of J u by q, u and columns
      "sample_tangents"   beside it, with clocks: t, q, u → derivatives (held, nq + nu + k + held) of what they sample,
                      by q, u, columns and what is held; by that "tangents" and "guard_tangents" have columns then, too
      "guard_tangents"    beside it, with guards: t, q, u → derivatives (guards, nq + nu + 1 + k) by q, u, t and columns
      "motion_pullback"   where it is asked for: t, q, u, u̇, λ, weights of u̇ (nu), or of the residuals as in "jacobian",
                      less, then of q̇ (nq) where there is "rates" → derivatives of the weighted sum by q, u and sources:
                      values by parameters only, and what clocks hold
      "closure_pullback"  beside it, with loops: q, u, weights of φ (m) and of J u (m) → the same
      "guard_pullback"    beside it, with guards: t, q, u, weights of the guards → derivatives by q, u, t and sources
      "sample_pullback"   beside it, with clocks: t, q, u, weights of their periods and of samples → by q, u and sources
      "impact_pullback"   beside it, with impacts: t, q, u, weights of restitutions (guards) and of derivatives of the
                      guards' rates by u (guards, nu), 1, z (nu), x (nu), μ (m), η (m), of -zᵀMx + μJz + ηJx →
                      derivatives by q, u, t and sources
      "pose_pullback", "energy_pullback"  beside it: t, q, u, weights of poses, of energies → by q, u and sources
      "setup_pullback"    beside it: weights of the sources → derivatives by parameters, then by `geometry`
      "samples"       where there are clocks: t, q, u → their periods, s, then samples of what they hold
      "power"         where it is asked for: t, q, u, u̇ → power of each of `powers`, W
      "poses"         t, q → per moving body centre of mass (3, m) and rotation matrix (9, row by row, body axes
                      equal to world axes in the drawn configuration), shape (12 len(bodies),)
    """

    name: str
    joints: tuple[str, ...]  # names of the first coordinates
    coordinates: tuple[Coordinate, ...]  # of q, (nq,): the joints, then what effects add
    rates: tuple[Coordinate, ...]  # of u, (nu,)
    bodies: tuple[str, ...]  # names of the moving bodies, in the order of `poses`
    parameters: tuple[Parameter, ...]
    constant_count: int
    energies: tuple[str, ...]
    functions: Mapping[str, Function]
    geometry: tuple[DrawnNumber, ...] = ()
    notes: tuple[str, ...] = ()  # what a reader of the C should know, e.g. the solver chosen and why
    cuts: tuple[str, ...] = ()  # names of the last joints, which close loops
    closure_count: int = 0  # m, equations that hold the loops
    rank: int = 0  # of the closure at a generic position; the other equations are redundant
    pattern: Pattern | None = None  # of J; None: a tree
    guards: "tuple[Guard, ...]" = ()
    clocks: "tuple[Clock, ...]" = ()
    drawn: tuple[float, ...] = ()  # state at rest as drawn, (nq + nu,); empty: all zero
    series: tuple[SeriesInput, ...] = ()  # theirs are the first constants, four for each
    powers: tuple[str, ...] = ()  # names of the effects, in the order of "power"
    columns: tuple[str, ...] = ()  # k parameters and dimensions, in the order of the columns of "tangents"
    source_count: int = 0  # sources by which the pullbacks differentiate, without what clocks hold
    jacobian_cost: float = 0.0  # operations of "jacobian" over those of an acceleration
    tables: "Mapping[int, Piecewise]" = field(
        default_factory=lambda: MappingProxyType({})
    )  # by number, those that the functions look up
    structure: str = ""  # digest of what is above without defaults, `drawn` and values of `geometry`
    digest: str = ""  # of everything above

    @property
    def motion(self) -> Mapping[str, int]:
        """The functions that one evaluation of the accelerations calls, and how often each."""
        if "residual" in self.functions:  # along each free direction, and to solve
            return {"constraints": 1, "residual": 1, "momenta": len(self.rates) - self.rank}
        known = ("acceleration", "dynamics", "system")
        return {next(name for name in known if name in self.functions): 1}

    @property
    def inputs(self) -> list[float]:
        """What `setup` is given unless something is changed: defaults of parameters, then numbers of the drawing."""
        return [*(p.default for p in self.parameters), *(number.value for number in self.geometry)]

    @property
    def motion_operations(self) -> Operations:
        """Of one evaluation of the accelerations, without what the runtime solves."""
        counted = (self.functions[name].operations.times(count) for name, count in self.motion.items())
        return sum(counted, start=Operations())


def design_digest(structure: str, inputs: Iterable[float], drawn: Iterable[float] = ()) -> str:
    """The digest of a program of this structure with these numbers: what `setup` is given, and the state as drawn."""
    text = hashlib.sha256(structure.encode())
    for part in (inputs, drawn):
        text.update(b"\n" + " ".join(map(float.hex, map(float, part))).encode())
    return text.hexdigest()


@dataclass(frozen=True)
class ElementProgram:
    """A finite element: everything there is to emit.

    functions, by name; those that make no sense for the element are absent:
      "stiffness"     xy, s → ∫ BᵀSB dA, lower triangle by rows
      "mass"          xy, rho → consistent mass, lower triangle by rows
      "geometric"     xy, n → ∫ ∇wᵀN∇w dA, lower triangle by rows
      "load"          xy, f → forces and moments on the unknowns
      "prestress"     xy, r → ∫ Bᵀr dA
      "strain"        xy, xi, d → membrane strains, then curvatures, at one point
      "displacement"  xy, xi, d → u, v, then w, w_x, w_y, at one point
      "force"         xy, s, d → ∫ BᵀSBd dA by way of the strains

    points  of functions that are to be summed up: (ξ, η, weight) each, which they read as three slots of NATURAL
    """

    name: str
    nodes: tuple[tuple[str, ...], ...]  # names of the unknowns of each node
    corner_count: int
    fields: tuple[str, ...]  # of u, v, w
    functions: Mapping[str, Function]
    points: Mapping[str, tuple[tuple[float, float, float], ...]]
    source: str = ""  # where the element comes from
    shear: bool = False  # through the thickness
    digest: str = ""  # of everything above

    @property
    def unknown_count(self) -> int:
        return sum(map(len, self.nodes))

    def inputs(self, name: str) -> tuple[Space, ...]:
        """What a function is given for each cell."""
        return tuple(
            s for s in self.functions[name].reads if s is not Space.NATURAL or name not in self.points
        )

    @property
    def strain_count(self) -> int:
        """Membrane strains where it has u and v, curvatures where it has w; three of each."""
        return 3 * (("u" in self.fields) + ("w" in self.fields))

    @property
    def section_count(self) -> int:
        """Unique entries of D or A, or of A, B and D; with shear, of H and of D about the neutral surface as well."""
        return (18 if self.strain_count == 6 else 6) + 9 * self.shear

    def size(self, space: Space) -> int:
        """How many values a cell has of an input."""
        return {
            Space.CORNER: 2 * self.corner_count,
            Space.SECTION: self.section_count,
            Space.AREAL_MASS: 1,
            Space.MEMBRANE_FORCE: 3,
            Space.INTENSITY: len(self.fields) * self.corner_count,
            Space.RESULTANT: self.strain_count,
            Space.NATURAL: 2,
            Space.UNKNOWN: self.unknown_count,
        }[space]
