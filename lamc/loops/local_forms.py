"""The second order of a flat sheet: one quadratic form for each vertex, in the rates of its own creases only.

In: a closed position at which some equations of the short cycles hold nothing to first order, and the others are
independent. Out: `LocalForms`, and rates that fulfil them near given ones. Never: forms a matrix of all rates by all
rates for each vertex: a sheet of a thousand creases has hundreds of free rates.

A flat vertex lets its creases' rates u go on where Σ_{i<j} sin(θ_j - θ_i) u_i u_j = 0, θ their directions; the rates of
its creases hold it in the plane to first order (T. Tachi, Simulation of rigid origami, 2009).
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import numpy.typing as npt

from lamc.loops.decompositions import singular_values
from lamc.loops.geometry import LoopGeometry
from lamc.records.mechanism import Array

NOTHING = 1e-9  # of a form, beside those of one: round-off of the drawing's corners
ROUNDS = 60  # of Newton's method, which needs ten
FRUITLESS = 20  # rounds in which forms come no nearer to nothing by half: others lead somewhere after a dozen
ARRIVED = 1e-12  # of a form, of rates of length one
AT_CORNER = (
    5e-6  # of the slopes: a corner is a double zero, and known to the root of ARRIVED and a few times that
)
RIDGE = 1e-14  # of the largest: forms that depend on one another are solved for all the same
FAINT = 3e-7  # of the slopes: what is less is hardly followed, where forms are more than unknowns
WIDE = 4  # times the usual number of joints: ways around holes have more, and stand apart, as matrices have its square
BACK = 30  # random directions that are tried where one leads nowhere


@dataclass(frozen=True, eq=False)
class LocalForms:
    """Forms Q_c of cycles, scaled to one.

    groups  of forms of about as many joints, one after the other: joints (c, w) of each, padded by 0, and matrices
            (c, w, w), padded by zeros
    held    (n,), of all joints: those of some loop; others, as those of flaps, are free by themselves
    """

    groups: tuple[tuple[npt.NDArray[np.int64], Array], ...]
    held: npt.NDArray[np.bool_]

    @property
    def count(self) -> int:
        """n, of all joints."""
        return len(self.held)

    @property
    def forms(self) -> int:
        """c, of all groups."""
        return sum(len(joints) for joints, _ in self.groups)

    def values(self, rates: Array) -> Array:
        """(c,): u Q u, of rates (n,)."""
        parts = [
            np.einsum("ca,cab,cb->c", u := rates[joints], matrices, u) for joints, matrices in self.groups
        ]
        return np.concatenate(parts)

    def slopes(self, rates: Array) -> Any:
        """(c, n), sparse: 2 Q u."""
        from scipy import sparse

        def part(joints: npt.NDArray[np.int64], matrices: Array) -> Any:
            entries = 2.0 * np.einsum("cab,cb->ca", matrices, rates[joints])
            rows = np.repeat(np.arange(len(joints)), joints.shape[1])
            shape = (len(joints), self.count)
            return sparse.csr_array((entries.ravel(), (rows, joints.ravel())), shape=shape)

        return sparse.vstack([part(*group) for group in self.groups], format="csr")

    def nearest(self, basis: Array, rates: Array, rounds: int = ROUNDS) -> Array | None:
        """Rates (n,) of length one in the span of `basis` (n, d), orthonormal, zeros of all forms, near `rates` (n,);
        None where Newton's method does not arrive. Rates that no loop holds stay beside the others as they are: among
        its unknowns all others would fade, as forms of next to nothing are nil."""
        within = basis @ (basis.T @ rates)
        loose = np.where(self.held, 0.0, within)
        x = basis.T @ (within - loose)
        length = float(np.linalg.norm(x))
        if not length > 0.0:
            return None
        x = x / length
        least, fruitless = np.inf, 0
        for _ in range(rounds):
            u = basis @ x
            missed = self.values(u)
            far = float(np.abs(missed).max())
            if far <= ARRIVED:
                found = length * u + loose
                return np.asarray(found / np.linalg.norm(found))
            least, fruitless = (far, 0) if far < 0.5 * least else (least, fruitless + 1)
            if fruitless == FRUITLESS:
                return None
            x = x - _least_step(self.slopes(u) @ basis, missed, x)
            if not self.held.all():  # round-off grows where all else fades
                x = basis.T @ np.where(self.held, basis @ x, 0.0)
            x = x / np.linalg.norm(x)
        return None

    def holds(self, basis: Array, rates: Array, usual: int, least: float) -> tuple[float, int]:
        """How much the slopes at zeros `rates` (n,) hold of the direction that they hold least, if they leave as many
        free as is `usual`, 0 at a corner; and the dimension of the family there, slopes of up to `least` taken for
        none."""
        strengths, held = singular_values(self.slopes(rates) @ basis), basis.shape[1] - usual
        weakest = float(strengths[held - 1]) if 0 < held <= len(strengths) else 0.0
        return weakest if weakest > AT_CORNER else 0.0, int(basis.shape[1] - (strengths > least).sum())

    @cached_property
    def random(self) -> Array:
        """(BACK, n): directions that are the same each time."""
        return np.random.default_rng(20260106).normal(size=(BACK, self.count))


def _least_step(slopes: Array, missed: Array, x: Array) -> Array:
    """The shortest change (d,) of x, of length one, that takes `missed` (c,) away to first order, or along the sphere
    most of it where there are more forms than unknowns. By products: the next round mends the digits."""
    if len(slopes) < slopes.shape[1]:
        squares = slopes @ slopes.T
        squares[np.diag_indices_from(squares)] += RIDGE * np.trace(squares)
        return np.asarray(slopes.T @ np.linalg.solve(squares, missed))
    slopes = slopes - 2.0 * np.outer(missed, x)
    squares = slopes.T @ slopes
    largest = np.trace(squares)
    if not largest > 0.0:  # no way leads down
        return np.zeros_like(x)
    squares[np.diag_indices_from(squares)] += FAINT**2 * largest
    return np.asarray(np.linalg.solve(squares, slopes.T @ missed))


def local_forms(geometry: LoopGeometry, angles: Array) -> LocalForms | None:
    """The forms at a closed position; None where its equations depend on one another otherwise than by holding
    nothing, as flat sheets' do not."""
    linear = geometry.linear(angles)
    if len(linear.used) != linear.rank():
        return None
    held = set(linear.used.tolist())
    joints, matrices = [], []
    for ring, bias in zip(geometry.rings.rings, geometry.rings.local_bias(angles), strict=True):
        for c, row in enumerate(ring.rows.tolist()):
            for k in range(6):
                size = float(np.abs(bias[c, k]).max())
                if 6 * row + k not in held and size > NOTHING:
                    joints.append(ring.joints[c])
                    matrices.append(bias[c, k] / np.linalg.norm(bias[c, k]))
    if not joints:
        return None
    in_loops = np.zeros(len(geometry.names), dtype=bool)
    for cycle in geometry.cycles:
        in_loops[list(cycle.joints)] = True
    usual = WIDE * int(np.median([len(each) for each in joints]))
    of_vertices = [k for k, each in enumerate(joints) if len(each) <= usual]
    of_holes = [k for k, each in enumerate(joints) if len(each) > usual]
    groups = tuple(_padded(joints, matrices, taken) for taken in (of_vertices, of_holes) if taken)
    return LocalForms(groups, in_loops)


def _padded(
    joints: Sequence[npt.NDArray[np.int64]], matrices: Sequence[Array], taken: Sequence[int]
) -> tuple[npt.NDArray[np.int64], Array]:
    """A group of some of the forms."""
    width = max(len(joints[k]) for k in taken)
    own, forms = np.zeros((len(taken), width), dtype=np.int64), np.zeros((len(taken), width, width))
    for row, k in enumerate(taken):
        size = len(joints[k])
        own[row, :size], forms[row, :size, :size] = joints[k], matrices[k]
    return own, forms
