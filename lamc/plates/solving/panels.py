"""A piece of a plate and its panels: rigid motions, those of them that nothing prevents, and their names.

In: the nodes of a piece, by panel; rows of unknowns that do not change. Out: a `Piece`. Never: which pieces there are.
"""

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp

from lamc.basics.checks import Array
from lamc.plates.dofs import Dofs
from lamc.plates.elements.definition import DOFS
from lamc.plates.meshing.mesh import Integers

_HELD = 1e-8  # of the supports' lever arms over the piece's size: below it a motion is not held
_ZERO = 1e-6  # of the components of a motion, for its name


@dataclass(frozen=True, eq=False)
class Piece:
    """What hangs together.

    number, count  1, 2, … of so many
    centre         (2,), m: mean of its nodes
    size           m: diagonal of its bounding box
    nodes, dofs    numbers
    units          (dofs,): what each unknown is counted in: `size`, 1, or 1/`size`
    motions        (dofs, k): those not held, as changes of its unknowns where the piece turns by 1 rad or moves by its
                   size
    names          (k,): "rise", "turn about x", …; "fold along the HingeLine …" where panels turn against each other
    folds          how many of these, the first ones, are such
    """

    number: int
    count: int
    centre: Array
    size: float
    nodes: Integers
    dofs: Integers
    units: Array
    motions: Array
    names: tuple[str, ...]
    folds: int = 0

    @property
    def text(self) -> str:
        """As a message names it."""
        x, y = self.centre
        return f"piece {self.number} of {self.count} at ({x:.4g}, {y:.4g})"


class Panels:
    """Rigid motions of the panels of one piece, each about its own centre.

    numbers      of the unknowns of `nodes`; `units` of each, by the size of its panel
    rigid        (dofs, panels times motions); `coordinates` names those of one panel
    """

    def __init__(self, dofs: Dofs, nodes: Integers, panel: Integers) -> None:
        self.nodes, at, table = nodes, dofs.points[nodes], dofs.table[nodes]
        self.centre, self.size = _box(at)
        there = table >= 0
        self.numbers = table[there]
        own = np.unique(panel, return_inverse=True)[1][np.nonzero(there)[0]]
        self.units = np.empty(len(self.numbers))
        self.boxes: list[tuple[Array, float]] = []
        blocks: list[Array] = []
        for p in np.unique(panel):
            mine = panel == p
            centre, size = _box(at[mine])
            units = np.broadcast_to([size, size, size, 1.0, 1.0, 1.0 / size], table[mine].shape)
            rows = own == len(blocks)
            self.units[rows] = units[there[mine]]
            motions, self.coordinates = _rigid(at[mine] - centre, size, table[mine])
            block = np.zeros((len(self.numbers), motions.shape[1]))
            block[rows] = motions
            blocks.append(block)
            self.boxes.append((centre, size))
        self.rigid = np.concatenate(blocks, axis=1)

    def of_first(self, kernel: Array) -> Array:
        """Motions of the first panel, counted about the centre of the piece and in its size."""
        (x, y), size = self.boxes[0]
        right, up = self.centre - (x, y)
        rotation = dict(zip(self.coordinates, kernel[: len(self.coordinates)], strict=True))
        found = dict(rotation)
        if "up" in rotation:
            found["up"] = (
                rotation["about x"] * up - rotation["about y"] * right + rotation["up"] * size
            ) / self.size
        if "in plane" in rotation:
            found["along x"] = (rotation["along x"] * size - rotation["in plane"] * up) / self.size
            found["along y"] = (rotation["along y"] * size + rotation["in plane"] * right) / self.size
        return np.array([found[name] for name in self.coordinates])


def _box(at: Array) -> tuple[Array, float]:
    """Centre and diagonal of the box around points."""
    low, high = at.min(axis=0), at.max(axis=0)
    return 0.5 * (low + high), float(np.hypot(*(high - low)))


def piece_of(
    number: tuple[int, int], panels: Panels, held: sp.csr_array, folds: sp.csr_array, texts: list[str]
) -> Piece:
    """`held` (c, N) does not change, and `folds` (h, N) turn the hinge lines called `texts`."""
    own, rigid = held[:, panels.numbers], panels.rigid
    weight = (
        np.sqrt((own @ sp.diags_array(panels.units)).power(2).sum(axis=1)) if own.shape[0] else np.ones(0)
    )
    kernel = _null((own @ rigid) / np.asarray(weight).reshape(-1, 1), rigid.shape[1])
    rotated = (folds[:, panels.numbers] @ rigid) @ kernel
    whole = panels.of_first(kernel)
    parts = _echelon(np.concatenate([rotated, whole, kernel]), len(rotated) + len(whole))
    rotated, whole, kernel = np.split(parts, [len(rotated), len(rotated) + len(whole)])
    names = []
    for fold, motion in zip(rotated.T, whole.T, strict=True):
        lines = list(dict.fromkeys(texts[k] for k in np.flatnonzero(np.abs(fold) > _ZERO)))
        of = dict(zip(panels.coordinates, motion, strict=True))
        names.append(f"fold along {' and '.join(lines)}" if lines else _name(of, panels.centre, panels.size))
    return Piece(
        *number,
        panels.centre,
        panels.size,
        panels.nodes,
        panels.numbers,
        panels.units,
        rigid @ kernel,
        tuple(names),
        sum(name.startswith("fold") for name in names),
    )


def _rigid(at: Array, size: float, table: Integers) -> tuple[Array, tuple[str, ...]]:
    """Rigid motions of a piece with nodes `at` from its centre, (dofs, 3 or 6), and what they are."""
    x, y = at.T
    none, one = np.zeros(len(at)), np.ones(len(at))
    motions = {
        "about x": [none, none, y, none, one, none],
        "about y": [none, none, -x, -one, none, none],
        "up": [none, none, size * one, none, none, none],
        "in plane": [-y, x, none, none, none, none],
        "along x": [size * one, none, none, none, none, none],
        "along y": [none, size * one, none, none, none, none],
    }
    bends, stretches = (table[:, DOFS.index("w")] >= 0).any(), (table[:, DOFS.index("u")] >= 0).any()
    names = tuple(motions)[0 if bends else 3 : 6 if stretches else 3]
    there = table >= 0
    return np.stack([np.stack(motions[name], axis=1)[there] for name in names], axis=1), names


def _null(levers: Array, count: int) -> Array:
    """Combinations of motions that move no row of `levers`, (count, k)."""
    if not len(levers):
        return np.eye(count)
    triangle = np.linalg.qr(levers, mode="r") if len(levers) > count else levers
    _, values, right = np.linalg.svd(triangle)
    return np.asarray(right[int(np.count_nonzero(values > _HELD)) :].T)


def _echelon(kernel: Array, coordinates: int) -> Array:
    """The same space, by columns that have as few of the first `coordinates` components as can be: turns first, as the
    rest depends on them."""
    rows = kernel.T.copy()
    done = 0
    for column in range(coordinates):
        if done == len(rows):
            break
        pivot = done + int(np.argmax(np.abs(rows[done:, column])))
        if abs(rows[pivot, column]) < _ZERO:
            continue
        rows[[done, pivot]] = rows[[pivot, done]]
        rows[done] /= rows[done, column]
        others = np.arange(len(rows)) != done
        rows[others] -= np.outer(rows[others, column], rows[done])
        done += 1
    rows[np.abs(rows) < _ZERO * 1e-3] = 0.0
    return np.asarray(rows.T)


def _name(of: dict[str, float], centre: Array, size: float) -> str:
    """A motion as a message names it."""
    a, b, up = of.get("about x", 0.0), of.get("about y", 0.0), of.get("up", 0.0)
    if max(abs(a), abs(b)) > _ZERO:
        shift = size * up / (a * a + b * b)
        through = np.array([centre[0] + shift * b, centre[1] - shift * a])
        x, y = np.where(np.abs(through) < _ZERO * size, 0.0, through)
        if abs(b) < _ZERO:
            return "turn about x" + (f" (the line y = {y:.4g})" if up else "")
        if abs(a) < _ZERO:
            return "turn about y" + (f" (the line x = {x:.4g})" if up else "")
        length = float(np.hypot(a, b))
        return f"turn about the line through ({x:.4g}, {y:.4g}) along ({a / length:.3f}, {b / length:.3f})"
    if abs(up) > _ZERO:
        return "rise"
    if abs(of.get("in plane", 0.0)) > _ZERO:
        return "turn in its plane"
    sx, sy = of.get("along x", 0.0), of.get("along y", 0.0)
    if abs(sy) < _ZERO:
        return "slide along x"
    if abs(sx) < _ZERO:
        return "slide along y"
    return f"slide along ({sx:.3f}, {sy:.3f})"
