"""Staged finite elements evaluated in numpy, with the methods of `lamc.reference.plate_elements.ReferenceElement`."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from lamc.codegen.program import Space
from lamc.mechanics.staging import Store, Symbol, Value
from lamc.plate.elements import Element, derive, element
from lamc.reference.operations import BATCHED

Numbers = NDArray[np.floating[Any]]


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
