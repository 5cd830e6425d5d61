"""What a finite element gives, for many cells at once: arrays in, arrays out.

In: an element and the corners of cells. Out: matrices, vectors, strains. Never: a mesh, supports, a sparse matrix.

All arrays are checked before C sees them, so that no input ends the process; numbers are not: NaN in gives NaN out, and
a cell without area gives infinities. The work is done without the GIL.
"""

from collections.abc import Sequence
from pathlib import Path
from typing import Any, Literal, Protocol, TypeAlias

import numpy as np
import numpy.typing as npt

from lamc.basics.checks import Array, shown
from lamc.basics.errors import DesignError, UnsupportedError
from lamc.plates.elements.definition import Element
from lamc.plates.elements.library import checked_element
from lamc.symbolic.program import ElementProgram

Backend = Literal["c", "interpreted"]
Numbers: TypeAlias = npt.NDArray[np.floating[Any]]  # float or long double


class Evaluator(Protocol):
    """Functions of an element on arrays that have been checked."""

    @property
    def source_dir(self) -> Path | None:
        """Where C lies, if there is any."""
        ...

    def values(
        self, name: str, inputs: Sequence[npt.NDArray[Any]], outputs: tuple[int, ...], dtype: Any
    ) -> npt.NDArray[Any]:
        """What function `name` gives, shape (m, *outputs), from contiguous inputs (m, size)."""
        ...


class ElementKernels:
    """The functions of one element on m cells with c corners, d unknowns, S section entries, E strains.

    Corners are (m, c, 2), m, counter-clockwise. Unknowns are node by node, at each node in the order u, v, w, w_x, w_y,
    w_xy; w is up. Sections are the unique entries (11, 12, 16, 22, 26, 66) of A where the element has u and v, of D
    where it has w; of A, B and D where it has all. Elements with shear through the thickness add the entries 11, 12,
    22 of H and the six of D - B A⁻¹ B, and read sections for strains and prestress as well. Strains are (ε_x, ε_y,
    γ_xy), then κ = -(w_xx, w_yy, 2 w_xy).

    Every method raises DesignError for arrays of another shape or without numbers.
    """

    def __init__(self, element: Element, evaluator: Evaluator) -> None:
        self.element = element
        self.evaluator = evaluator
        self.corner_count = element.corner_count
        self.unknown_count = len(element.dofs)
        self.strain_count = 3 * (element.stretches + element.bends)
        self.section_count = (18 if self.strain_count == 6 else 6) + 9 * element.shear

    @property
    def source_dir(self) -> Path | None:
        """Where the element's C lies; None where it is interpreted."""
        return self.evaluator.source_dir

    def stiffness(self, corners: npt.ArrayLike, sections: npt.ArrayLike) -> Array:
        """∫ Bᵀ S B dA, shape (m, d, d), from section stiffnesses (m, S): N/m, N, N·m."""
        return self._matrices("stiffness", corners, "sections", sections, (self.section_count,))

    def mass(self, corners: npt.ArrayLike, areal_mass: npt.ArrayLike) -> Array:
        """∫ ρ (u² + v² + w²) dA as a consistent matrix, shape (m, d, d), from masses per area (m,), kg/m²."""
        return self._matrices("mass", corners, "areal_mass", areal_mass, ())

    def geometric(self, corners: npt.ArrayLike, forces: npt.ArrayLike) -> Array:
        """∫ ∇wᵀ N ∇w dA, shape (m, d, d), from N_x, N_y, N_xy (m, 3), N/m, tension positive.

        Raises UnsupportedError for a membrane, which has no deflection.
        """
        self.check_bends()
        return self._matrices("geometric", corners, "forces", forces, (3,))

    def load(self, corners: npt.ArrayLike, intensity: npt.ArrayLike) -> Array:
        """Forces and moments on the unknowns, shape (m, d), of forces per area, N/m².

        intensity: values at the corners, linear or bilinear between them, shape (m, fields, c); fields in the order u,
        v, w of those that the element has.
        """
        return self._vectors(
            "load", corners, [("intensity", intensity, (len(self.element.fields), self.corner_count))]
        )

    def prestress(
        self, corners: npt.ArrayLike, resultants: npt.ArrayLike, sections: npt.ArrayLike | None = None
    ) -> Array:
        """∫ Bᵀ r dA, shape (m, d), from resultants (m, E): membrane forces, N/m, then moments, N."""
        name, first = self._in_section("prestress", sections)
        return self._vectors(name, corners, [*first, ("resultants", resultants, (self.strain_count,))])

    def strain(
        self,
        corners: npt.ArrayLike,
        xi: npt.ArrayLike,
        d: npt.ArrayLike,
        sections: npt.ArrayLike | None = None,
    ) -> Array:
        """Strains and curvatures (1/m), shape (m, E), at natural coordinates xi (m, 2) for unknowns d (m, d)."""
        name, first = self._in_section("strain", sections)
        inputs = [*first, ("xi", xi, (2,)), ("d", d, (self.unknown_count,))]
        return self._vectors(name, corners, inputs, self.strain_count)

    def shear(
        self, corners: npt.ArrayLike, xi: npt.ArrayLike, d: npt.ArrayLike, sections: npt.ArrayLike
    ) -> Array:
        """(γ_x, γ_y) through the thickness, shape (m, 2), at xi (m, 2) for unknowns d (m, d).

        Raises UnsupportedError for an element without shear.
        """
        if not self.element.shear:
            raise UnsupportedError(
                f"element {shown(self.element.name)} has no shear through the thickness; choose one that has, 'dkmt'"
            )
        name, first = self._in_section("shear", sections)
        return self._vectors(name, corners, [*first, ("xi", xi, (2,)), ("d", d, (self.unknown_count,))], 2)

    def _in_section(
        self, name: str, sections: npt.ArrayLike | None
    ) -> tuple[str, list[tuple[str, npt.ArrayLike, tuple[int, ...]]]]:
        """The function that is there, and the sections if it reads them."""
        if not self.element.shear:
            return name, []
        if sections is None:
            raise DesignError(
                f"element {shown(self.element.name)} has shear through the thickness, and its strains depend on the "
                "section; give sections"
            )
        return f"{name}_in_section", [("sections", sections, (self.section_count,))]

    def displacement(self, corners: npt.ArrayLike, xi: npt.ArrayLike, d: npt.ArrayLike) -> Array:
        """u, v if it has them, m, then w, m, and w_x, w_y if it has them, at xi (m, 2) for unknowns d (m, d)."""
        inputs = [("xi", xi, (2,)), ("d", d, (self.unknown_count,))]
        return self._vectors(
            "displacement", corners, inputs, 2 * self.element.stretches + 3 * self.element.bends
        )

    def force(
        self,
        corners: npt.ArrayLike,
        sections: npt.ArrayLike,
        d: npt.ArrayLike,
        dtype: type[float] | type[np.longdouble] = float,
    ) -> Numbers:
        """∫ Bᵀ (S (B d)) dA, shape (m, d): stiffness times unknowns by way of the strains.

        Rigid motions cancel in B d, before stiffness multiplies their round-off. dtype: float or numpy.longdouble, in
        which everything is computed.
        """
        if np.dtype(dtype) not in (np.dtype(float), np.dtype(np.longdouble)):
            raise DesignError(f"dtype is {shown(dtype)}; forces are computed in float or numpy.longdouble")
        inputs = [("sections", sections, (self.section_count,)), ("d", d, (self.unknown_count,))]
        return self._vectors("force", corners, inputs, dtype=dtype)

    def check_bends(self) -> None:
        """Raises UnsupportedError for a membrane."""
        if not self.element.bends:
            raise UnsupportedError(
                f"element {shown(self.element.name)} has no deflection, hence no geometric stiffness; choose one that "
                "bends, e.g. 'dkt'"
            )

    def _matrices(
        self, name: str, corners: npt.ArrayLike, label: str, values: npt.ArrayLike, shape: tuple[int, ...]
    ) -> Array:
        inputs = self._checked(corners, [(label, values, shape)], float)
        return self.evaluator.values(name, inputs, (self.unknown_count, self.unknown_count), float)

    def _vectors(
        self,
        name: str,
        corners: npt.ArrayLike,
        given: Sequence[tuple[str, npt.ArrayLike, tuple[int, ...]]],
        count: int | None = None,
        dtype: Any = float,
    ) -> npt.NDArray[Any]:
        inputs = self._checked(corners, given, dtype)
        return self.evaluator.values(name, inputs, (count or self.unknown_count,), dtype)

    def _checked(
        self, corners: npt.ArrayLike, given: Sequence[tuple[str, npt.ArrayLike, tuple[int, ...]]], dtype: Any
    ) -> list[npt.NDArray[Any]]:
        """Contiguous arrays (m, size) of one type."""
        first = numbers("corners", corners, (self.corner_count, 2), None, dtype)
        return [first, *(numbers(label, values, shape, len(first), dtype) for label, values, shape in given)]


def numbers(
    label: str,
    values: npt.ArrayLike,
    shape: tuple[int, ...],
    count: int | None,
    dtype: Any,
    row: str = "one row per cell",
) -> npt.NDArray[Any]:
    """`values` as a contiguous array (m, size) of `dtype`; they must have shape (m, *shape), with m = count if given.

    Raises DesignError for anything else.
    """
    try:
        array = np.asarray(values)
        if array.dtype.kind not in "fiub":
            raise TypeError(f"they are of type {array.dtype}")
        array = np.ascontiguousarray(array, dtype=dtype)
    except (TypeError, ValueError, OverflowError) as error:
        raise DesignError(f"{label} must be real numbers: {error}") from error
    wanted = "m" if count is None else str(count)
    if array.ndim != 1 + len(shape) or array.shape[1:] != shape or count not in (None, len(array)):
        full = ", ".join([wanted, *map(str, shape)])
        raise DesignError(f"{label} have shape {array.shape}; it must be ({full}{',' * (not shape)}), {row}")
    return array.reshape(len(array), int(np.prod(shape, dtype=int)))


class _Interpreted:
    """The element's program walked through in Python, whole arrays at a time."""

    source_dir = None

    def __init__(self, program: ElementProgram) -> None:
        from lamc.plates.elements.interpreted import (
            InterpretedElement,  # the road itself never imports a reference
        )

        self._element = InterpretedElement(program)

    def values(
        self, name: str, inputs: Sequence[npt.NDArray[Any]], outputs: tuple[int, ...], dtype: Any
    ) -> npt.NDArray[Any]:
        found = self._element.values(name, inputs, dtype)
        if len(outputs) == 1:
            return found
        rows, columns = np.tril_indices(outputs[0])
        full = np.empty((len(found), *outputs), dtype=dtype)
        full[:, rows, columns] = found
        full[:, columns, rows] = found
        return full


def kernels(element: Element | str, backend: Backend = "c") -> ElementKernels:
    """The functions of `element`, compiled (and cached like a simulator) or interpreted.

    Raises DesignError for an element that is not known or has no sound shape functions, BuildError without a working
    compiler or cache.
    """
    from lamc.plates.elements.build import element_module, element_program
    from lamc.plates.elements.native import CompiledElement

    element = checked_element(element)
    if backend == "c":
        return ElementKernels(element, CompiledElement(element_module(element)))
    if backend == "interpreted":
        return ElementKernels(element, _Interpreted(element_program(element)))
    raise DesignError(f"the backend is {shown(backend)}; it must be 'c' or 'interpreted'")
