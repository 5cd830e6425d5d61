"""Modes: how a mechanism moves by itself next to an equilibrium.

In: an `Equilibrium`. Out: `Modes`: frequencies, damping and shapes, undamped or with the damping there is. Never:
integrates.

Each mode is q(t) = q0 + Re(shape e^{λt}) of the linear model. Without damping and with conservative loads λ² is minus
an eigenvalue of the projected Hessian over the inertia, both symmetric; else λ is one of the state matrix.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, fields
from functools import partial
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
import numpy.typing as npt

from lamc.basics.checks import shown
from lamc.basics.errors import RequestError, SimulationError
from lamc.basics.once import lazy
from lamc.basics.threads import on_one_thread
from lamc.mechanism.plan import plan
from lamc.records.effect import bandwidth_of
from lamc.run.as_result import as_result
from lamc.run.at_rest import Stand
from lamc.run.chart import chart_of
from lamc.run.equilibrium import Equilibrium
from lamc.run.linear_model import check_point
from lamc.run.model import Unchanging
from lamc.run.request import Array, finite
from lamc.run.result import Result
from lamc.run.stability import is_symmetric, system

if TYPE_CHECKING:
    from lamc.run.simulator import Simulator

Complex = npt.NDArray[np.complex128]
Kind = Literal["vibration", "decay", "growth", "free"]
AMPLITUDE = 0.35  # rad, or of the size: of the coordinate that moves most, for the eye
_NOUGHT = (
    1e-6  # of the fastest eigenvalue: stiffnesses are known to 1e-12 of the largest, and these to the root
)
_STRIDE = 0.05  # rad, or of the size: of one step along the closed positions
_CORRECTIONS = 3  # of Newton's, at each phase: from a stride's 1e-3 to round-off
_FRAMES = 48  # of a cycle
_SAME_MODE = 1e-3  # relative: the body by itself, but for round-off
_REAL = 1e-6  # of a shape: a smaller imaginary part is round-off


@dataclass(frozen=True, eq=False)
class Mode:
    """One mode.

    eigenvalue  λ, 1/s; of a vibration the one with the positive imaginary part
    kind        "vibration"; "decay" or "growth" without turning round; "free": nothing pulls back
    shape       (nq,), complex, in the order of the coordinates: of the one that moves most 1 rad, or the mechanism's
                size, and real; arguments are phases ahead of it
    names       of the coordinates
    """

    eigenvalue: complex
    kind: Kind
    shape: Complex
    names: tuple[str, ...]

    @property
    def angular_frequency(self) -> float:
        """|λ|, rad/s: that of the undamped vibration where damping is proportional; 0 of what does not vibrate."""
        return abs(self.eigenvalue) if self.kind == "vibration" else 0.0

    @property
    def frequency(self) -> float:
        """|λ| / 2π, Hz."""
        return self.angular_frequency / (2.0 * np.pi)

    @property
    def damped_frequency(self) -> float:
        """Im λ / 2π, Hz: how often it passes in a second."""
        return self.eigenvalue.imag / (2.0 * np.pi)

    @property
    def damping(self) -> float:
        """Damping ratio, -Re λ / |λ|: 1 is critical; below zero it grows. NaN of what is free."""
        return 0.0 - self.eigenvalue.real / abs(self.eigenvalue) if self.kind != "free" else float("nan")

    @lazy
    def amplitudes(self) -> Mapping[str, float]:
        """By coordinate, signed: the real part of the shape."""
        return MappingProxyType(dict(zip(self.names, self.shape.real.tolist(), strict=True)))

    @lazy
    def phases(self) -> Mapping[str, float]:
        """By coordinate, degrees ahead of the one that moves most; 0 or 180 where all move together."""
        angles = np.degrees(np.angle(np.where(np.abs(self.shape) < 1e-12, 0.0, self.shape)))
        return MappingProxyType(dict(zip(self.names, angles.tolist(), strict=True)))

    @property
    def is_standing(self) -> bool:
        """Whether all coordinates pass through the middle together, as without damping."""
        return bool(np.abs(self.shape.imag).max(initial=0.0) <= _REAL)


@dataclass(frozen=True, eq=False)
class Modes(Unchanging):
    """The modes about an equilibrium, free ones first, then by |λ|. `modes[0]` is the first."""

    point: Equilibrium
    modes: tuple[Mode, ...]
    has_damping: bool
    simulator: "Simulator" = field(repr=False)

    def __reduce__(self) -> tuple[Any, ...]:
        return partial(type(self), **{each.name: getattr(self, each.name) for each in fields(self)}), ()

    def __len__(self) -> int:
        return len(self.modes)

    def __getitem__(self, index: int) -> Mode:
        return self.modes[index]

    @lazy
    def notes(self) -> tuple[str, ...]:
        """What a reader of these should know: above which frequency they are those of the reduction of what bends."""
        limit = bandwidth_of(self.simulator.effects, plan(self.simulator.mechanism))
        above = [
            k + 1 for k, mode in enumerate(self.modes) if mode.angular_frequency > limit * (1.0 + _SAME_MODE)
        ]
        if not above:
            return ()
        in_a_row = above[-1] - above[0] + 1 == len(above)
        several = f"modes {above[0]} to {above[-1]}" if in_a_row else f"{len(above)} modes from {above[0]} on"
        modes = f"mode {above[0]} is" if len(above) == 1 else f"{several} are"
        return (
            f"{modes} above {limit / (2.0 * math.pi):.4g} Hz, up to which the shapes of bodies that bend have all of "
            "their motion: frequencies there may be too high, or of no plate; more modes of flexible_links tell",
        )

    @property
    def frequencies(self) -> Array:
        """Hz."""
        return np.array([mode.frequency for mode in self.modes])

    @property
    def angular_frequencies(self) -> Array:
        """rad/s."""
        return np.array([mode.angular_frequency for mode in self.modes])

    @property
    def damping(self) -> Array:
        """Damping ratios."""
        return np.array([mode.damping for mode in self.modes])

    @property
    def shapes(self) -> Complex:
        """(modes, nq)."""
        return np.array([mode.shape for mode in self.modes])

    def result(self, index: int, amplitude: float | str = AMPLITUDE) -> Result:
        """A cycle of one mode as if it were a run, for `animate`, `view` and `plot`; without decay or growth, and
        closed at every row. amplitude: rad, or of the size, of what moves most: far larger than where the linear model
        holds.

        Raises SimulationError where loops do not close so far out."""
        if isinstance(index, bool) or not isinstance(index, int) or not 0 <= index < len(self.modes):
            raise RequestError(
                f"index is {shown(index)}; it must be a whole number from 0 to {len(self) - 1}"
            )
        size = finite(amplitude, "amplitude", "an angle in rad")
        angles = np.linspace(0.0, 2.0 * np.pi, _FRAMES + 1)
        found = cycle(self.point.stand, self.modes[index], size, angles)
        period = 1.0 / (self.modes[index].frequency or 1.0)
        rows = np.vstack([self.point.stand.rest.row(q) for q in found])
        message = f"a cycle of mode {index + 1}, its size made up for the eye"
        return as_result(self.simulator, self.point.motion, angles / (2.0 * np.pi) * period, rows, message)

    def __repr__(self) -> str:
        first = ", ".join(f"{mode.frequency:.4g}" for mode in self.modes[:4])
        return f"<Modes: {len(self)}, at {first}{', …' * (len(self) > 4)} Hz, {self.point.kind}>"


@on_one_thread
def modes_of(simulator: "Simulator", point: Equilibrium | None, *, damping: bool) -> Modes:
    """As `Simulator.modes`."""
    if point is None:
        point = simulator.equilibrium()
    check_point(simulator, point)
    stiffness, damper = point.resistance.stiffness, point.resistance.damping
    if not len(stiffness):
        raise SimulationError("nothing can move; there are no modes")
    is_damped = damping and bool(np.abs(damper).max() > 0.0)
    if not is_damped and is_symmetric(stiffness):
        values, vectors = _undamped(stiffness)
    else:
        values, vectors = _damped(stiffness, damper if is_damped else np.zeros_like(damper))
    names = tuple(c.name for c in point.motion.model.coordinates)
    found = [
        Mode(complex(value), _kind(value), _shape(point.stand, vector), names)
        for value, vector in zip(values, vectors.T, strict=True)
    ]
    return Modes(point, tuple(found), is_damped, simulator)


def cycle(stand: Stand, mode: Mode, amplitude: float, angles: Array) -> list[Array]:
    """Closed positions (nq,) at phases (m,), rad, of a mode: independent coordinates follow it, all others closure."""
    chosen = list(chart_of(stand).chosen)
    flow, model = stand.flow, stand.rest.motion.model
    rates = np.linalg.lstsq(flow, mode.shape.astype(complex), rcond=None)[0]
    along = amplitude * (stand.tangent @ rates)[chosen]
    names = [c.name for c in model.coordinates]
    own = [names.index(model.rates[k].name) if model.rates[k].name in names else None for k in chosen]
    here, place, found = stand, np.zeros(len(chosen)), []
    for angle in angles:
        goal = (along * np.exp(1j * angle)).real
        count = max(1, int(np.ceil(np.abs((goal - place) / stand.rest.per_radian[chosen]).max() / _STRIDE)))
        start = place
        for part in [*np.arange(1, count + 1) / count, *([1.0] * _CORRECTIONS)]:
            aim = start + part * (goal - start)
            # What closure moved the independent ones by is made good where they are coordinates.
            place = np.array(
                [place[k] if i is None else here.q[i] - stand.q[i] for k, i in enumerate(own)], dtype=float
            )
            step = here.flow @ np.linalg.solve(here.tangent[chosen], aim - place)
            q = stand.rest.closed(here.q + step)
            there = None if q is None else stand.rest.stand(q)
            if there is None:
                raise SimulationError(
                    f"{model.name!r} does not close at {np.degrees(amplitude):.3g} deg of this mode; ask for less"
                )
            here, place = there, aim
        found.append(here.q)
    return found


def _undamped(stiffness: Array) -> tuple[Complex, Complex]:
    squares, vectors = np.linalg.eigh(0.5 * (stiffness + stiffness.T))
    tiny = np.abs(squares) <= _NOUGHT**2 * np.abs(squares).max()
    values = np.where(tiny, 0.0, np.sqrt(np.abs(squares))) * np.where(squares < 0.0, 1.0, 1j)
    order = np.argsort(np.abs(values), kind="stable")
    return values[order], vectors[:, order].astype(complex)


def _damped(stiffness: Array, damper: Array) -> tuple[Complex, Complex]:
    """By the state matrix; free directions by the stiffness, as the state matrix has them twice, or parallel."""
    k = len(stiffness)
    pace = float(np.sqrt(np.linalg.norm(stiffness)) or np.linalg.norm(damper) or 1.0)
    values, vectors = np.linalg.eig(system(stiffness / pace**2, damper / pace))
    values = values.astype(complex)
    largest = float(np.abs(values).max())
    values.imag[np.abs(values.imag) <= 1e-12 * largest] = 0.0
    kept = np.flatnonzero((values.imag >= 0.0) & (np.abs(values) > _NOUGHT * largest))
    order = kept[np.lexsort((-values[kept].real, np.round(np.abs(values[kept]), 9)))]
    held, directions = np.linalg.svd(stiffness)[1:]
    free = directions[held <= _NOUGHT**2 * held.max()].T
    found = np.append(np.zeros(free.shape[1]), pace * values[order])
    return found, np.hstack([free.astype(complex), vectors[:k, order]])


def _kind(value: complex) -> Kind:
    if value == 0.0:
        return "free"
    if value.imag > 0.0:
        return "vibration"
    return "growth" if value.real > 0.0 else "decay"


def _shape(stand: Stand, vector: Complex) -> Complex:
    """(nq,) of a vector (k,) in the axes of `push`."""
    along = stand.flow @ np.linalg.solve(stand.factor.T, vector)
    units = [c.unit for c in stand.rest.motion.model.coordinates]
    scale = np.array([stand.rest.size or 1.0 if unit == "m" else 1.0 for unit in units])
    sizes = np.abs(along / scale)
    most = int(np.flatnonzero(sizes >= (1.0 - 1e-6) * sizes.max())[0])  # the first of equal ones
    found = along * (scale[most] / along[most])
    found.imag[np.abs(found.imag) <= _REAL**2 * scale] = 0.0
    return np.asarray(found)
