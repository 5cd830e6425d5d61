"""Staged finite elements evaluated in numpy, with the methods of `lamc.reference.plate_elements.ReferenceElement`, and
irregular cells, sections and motions to try elements on."""

from collections.abc import Callable
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lamc.plates.elements import Element, derive, element
from lamc.plates.elements.definition import CORNERS
from lamc.symbolic.operations import BATCHED
from lamc.symbolic.program import Space
from lamc.symbolic.scalars import Value
from lamc.symbolic.staging import Store, Symbol

Numbers = NDArray[np.floating[Any]]
Motion = dict[str, Callable[[Any, Any], Any]]  # by name of the unknown, functions of x and y

BENDING = ("bciz", "dkt", "specht", "bfs")
MEMBRANES = ("cst", "lst", "q4", "q8", "q9", "q12")
COUPLED = ("dkt+cst", "dkt+lst", "bciz+cst", "specht+lst", "bfs+q4", "bfs+q12")
ALL = (*BENDING, *MEMBRANES, *COUPLED)
COUNT = 6  # cells that are tried at once
_UPPER = np.triu_indices(3)


class StagedElement:
    """Matrices of m cells at once, from their corners (m, c, 2)."""

    def __init__(self, given: Element | str) -> None:
        self.element = element(given) if isinstance(given, str) else given
        self.equations = derive(self.element)

    def stiffness(self, corners: Numbers, sections: Numbers) -> Numbers:
        return self._matrix("stiffness", corners, {Space.SECTION: sections})

    def mass(self, corners: Numbers, areal_mass: Numbers) -> Numbers:
        return self._matrix("mass", corners, {Space.AREAL_MASS: np.asarray(areal_mass)[:, None]})

    def geometric(self, corners: Numbers, forces: Numbers) -> Numbers:
        return self._matrix("geometric", corners, {Space.MEMBRANE_FORCE: forces})

    def load(self, corners: Numbers, intensity: Numbers) -> Numbers:
        return self._rows("load", corners, {Space.INTENSITY: np.asarray(intensity).reshape(len(corners), -1)})

    def prestress(self, corners: Numbers, resultants: Numbers) -> Numbers:
        return self._rows("prestress", corners, {Space.RESULTANT: resultants})

    def strain(self, corners: Numbers, xi: Numbers, d: Numbers) -> Numbers:
        return self._rows("strain", corners, {Space.NATURAL: xi, Space.UNKNOWN: d})

    def displacement(self, corners: Numbers, xi: Numbers, d: Numbers) -> Numbers:
        return self._rows("displacement", corners, {Space.NATURAL: xi, Space.UNKNOWN: d})

    def force(self, corners: Numbers, sections: Numbers, d: Numbers) -> Numbers:
        return self._rows("force", corners, {Space.SECTION: sections, Space.UNKNOWN: d})

    def _matrix(self, name: str, corners: Numbers, inputs: dict[Space, Numbers]) -> Numbers:
        lower, count = self._rows(name, corners, inputs), len(self.element.dofs)
        i, j = np.tril_indices(count)
        result = np.zeros((len(lower), count, count))
        result[:, i, j] = result[:, j, i] = lower
        return result

    def _rows(self, name: str, corners: Numbers, inputs: dict[Space, Numbers]) -> Numbers:
        function, m = self.equations.functions[name], len(corners)
        assert set(function.reads) == {Space.CORNER, *inputs} | (
            {Space.NATURAL} if function.points else set()
        )
        slots = {space: list(np.asarray(value, dtype=float).T) for space, value in inputs.items()}
        slots[Space.CORNER] = list(np.asarray(corners, dtype=float).reshape(m, -1).T)
        total = np.zeros((m, len(function.outputs)))
        for point in function.points or (None,):
            if point is not None:
                slots[Space.NATURAL] = [np.asarray(number) for number in point]
            values = _evaluate(self.equations.store, function.outputs, slots)
            total += np.stack([np.broadcast_to(value, (m,)) for value in values], axis=1)
        return total


def _evaluate(store: Store, outputs: Any, slots: dict[Space, list[Numbers]]) -> list[Any]:
    memory: dict[int, Any] = {}
    for index in store.live(outputs):
        payload = store.payloads.get(index)
        if isinstance(payload, Symbol):
            memory[index] = slots[payload.space][payload.index]
        elif payload is not None:
            memory[index] = float(payload)
        else:
            arguments = [memory[k] for k in store.arguments[index]]
            memory[index] = BATCHED[store.operations[index]](*arguments)
    return [v.sign * memory[v.index] if isinstance(v, Value) else float(v) for v in outputs]


staged = cache(StagedElement)


def cells(name: str, count: int = COUNT) -> Numbers:
    """Corners of irregular cells, away from the origin: triangles, quadrilaterals, or rectangles for bending."""
    rng = np.random.default_rng(7)
    own = element(name)
    base = np.array(CORNERS[own.cell], dtype=float)
    if own.cell == "square" and own.bends:
        return base * np.exp(rng.normal(scale=0.6, size=(count, 1, 2))) + rng.normal(size=(count, 1, 2))
    return base + rng.normal(scale=0.12, size=(count, len(base), 2)) + np.array([2.0, -1.0])


def sections(name: str, count: int = COUNT) -> Numbers:
    """Unique entries of positive definite sections, (count, 6 or 18)."""
    rng = np.random.default_rng(8)
    own = element(name)
    size = 6 if own.bends and own.stretches else 3
    root = rng.normal(size=(count, size, size))
    whole = root @ root.transpose(0, 2, 1)
    if size == 3:
        return whole[:, _UPPER[0], _UPPER[1]]
    coupling = 0.5 * (whole[:, :3, 3:] + whole[:, 3:, :3])
    blocks = (whole[:, :3, :3], 0.3 * coupling, whole[:, 3:, 3:])
    return np.concatenate([block[:, _UPPER[0], _UPPER[1]] for block in blocks], axis=1)


def matrix(entries: Numbers) -> Numbers:
    """The section, (m, 3, 3) or (m, 6, 6), of its unique entries."""
    blocks = []
    for k in range(entries.shape[1] // 6):
        block = np.zeros((len(entries), 3, 3))
        block[:, _UPPER[0], _UPPER[1]] = block[:, _UPPER[1], _UPPER[0]] = entries[:, 6 * k : 6 * k + 6]
        blocks.append(block)
    if len(blocks) == 1:
        return blocks[0]
    A, B, D = blocks
    return np.concatenate([np.concatenate([A, B], 2), np.concatenate([B, D], 2)], 1)


def node_places(name: str, corners: Numbers) -> Numbers:
    """Coordinates of the nodes, (m, nodes, 2): linear or bilinear between the corners."""
    own = element(name)
    at = np.array([[float(c) for c in node.at] for node in own.nodes])
    if own.cell == "triangle":
        shares = np.stack([1.0 - at.sum(axis=1), at[:, 0], at[:, 1]], axis=1)
    else:
        signs = np.array(CORNERS["square"], dtype=float)
        shares = np.prod(1.0 + at[:, None] * signs, axis=2) / 4.0
    return np.einsum("nc,mcd->mnd", shares, corners)


def nodal(name: str, corners: Numbers, motion: Motion) -> Numbers:
    """Unknowns (m, nd) where the plate moves as `motion`: functions of x and y by name of the unknown."""
    own = element(name)
    places = node_places(name, corners)
    columns = [
        np.broadcast_to(motion.get(dof, lambda x, y: 0.0 * x)(*places[:, k].T), len(corners))
        for k, node in enumerate(own.nodes)
        for dof in node.dofs
    ]
    return np.stack(columns, axis=1)


def constant_strain(k: int) -> Motion:
    """A motion of unit strain k: ε_x, ε_y, γ_xy, κ_x, κ_y, κ_xy, with a rigid motion on top."""
    e = np.eye(6)[k]
    return {
        "u": lambda x, y: e[0] * x + e[2] * y + 0.3 - 0.2 * y,
        "v": lambda x, y: e[1] * y - 0.1 + 0.2 * x,
        "w": lambda x, y: -0.5 * (e[3] * x * x + e[4] * y * y + e[5] * x * y) + 0.2 - 0.4 * x + 0.7 * y,
        "w_x": lambda x, y: -e[3] * x - 0.5 * e[5] * y - 0.4,
        "w_y": lambda x, y: -e[4] * y - 0.5 * e[5] * x + 0.7,
        "w_xy": lambda x, y: -0.5 * e[5] + 0.0 * x,
    }


def strain_rows(name: str) -> list[int]:
    own = element(name)
    return [*range(3)] * own.stretches + [*range(3, 6)] * own.bends


def relative(found: Numbers, expected: Numbers) -> float:
    """Largest difference over the largest entry, cell by cell."""
    m = len(expected)
    scale = np.abs(expected).reshape(m, -1).max(axis=1)
    return float((np.abs(found - expected).reshape(m, -1).max(axis=1) / scale).max())


def isotropic(nu: float) -> Numbers:
    """Plane stress, unit modulus and thickness: unique entries, (1, 6)."""
    return np.array([[1.0, nu, 0.0, 1.0, 0.0, 0.5 * (1.0 - nu)]]) / (1.0 - nu * nu)
