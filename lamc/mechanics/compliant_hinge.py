"""`CompliantHinge`: a hinge that yields in more than its angle, as numbers.

Goes in: two 6×6 matrices and the frame that they are in. Comes out: a record, checked. Nothing here is symbolic.
"""

from dataclasses import dataclass

import numpy as np

from lamc.basics.checks import Array, checked_array
from lamc.basics.errors import DesignError

# Freedoms of a compliant hinge beyond its angle, in the order of the rows of its matrices, where the angle is third.
FREEDOMS = ("twist_x", "twist_y", "angle", "slide_x", "slide_y", "slide_z")
CROSS_FREEDOMS = tuple(f for f in FREEDOMS if f != "angle")


@dataclass(frozen=True, eq=False)
class CompliantHinge:
    """A hinge that yields across its axis as well, with potential ½ pᵀ stiffness p and forces -damping ṗ.

    p = (twist_x, twist_y, angle, slide_x, slide_y, slide_z), rad and m, child relative to parent; twists and slides
    are about and along `axes` at `point`, which ride on the parent; twist_x comes first, then twist_y, then the angle.

    point      on the hinge line, (3,), m, world, drawn: where the strip's middle is
    axes       (3, 3), columns x, y, z, world, drawn; z the joint's axis
    stiffness  (6, 6): N·m/rad, N/rad, N/m; symmetric. Its angle-angle entry adds to what HingeStiffness gives
    damping    (6, 6), the same by rates
    freedoms   which of the five move; the others stay rigid, and their rows are not looked at
    """

    joint: str
    point: Array
    axes: Array
    stiffness: Array
    damping: Array
    freedoms: tuple[str, ...] = CROSS_FREEDOMS
    effect: str = ""  # who asked for it, and stores its energy; `Arranging` fills it in

    def __post_init__(self) -> None:
        what = f"the compliant hinge {self.joint!r}"
        for name, shape in (("point", (3,)), ("axes", (3, 3)), ("stiffness", (6, 6)), ("damping", (6, 6))):
            object.__setattr__(self, name, checked_array(getattr(self, name), shape, f"{name} of {what}"))
        for name in ("stiffness", "damping"):
            matrix = getattr(self, name)
            size = float(np.abs(matrix).max())
            if not np.allclose(matrix, matrix.T, rtol=0.0, atol=1e-9 * size):
                raise DesignError(f"the {name} of {what} is not symmetric; energy would come from nothing")
        if not np.allclose(self.axes.T @ self.axes, np.eye(3), atol=1e-9) or np.linalg.det(self.axes) < 0:
            raise DesignError(
                f"axes of {what} are not a right-handed set of unit vectors; give x, y, z as columns"
            )
        unknown = [f for f in self.freedoms if f not in FREEDOMS or f == "angle"]
        if unknown:
            raise DesignError(f"{what} has no freedom {unknown[0]!r}; there are {', '.join(CROSS_FREEDOMS)}")
        for name in ("stiffness", "damping"):
            if _least(getattr(self, name), (*self.freedoms, "angle")) < -1e-9:
                raise DesignError(
                    f"the {name} of {what} is not positive semi-definite; a hinge that yields would give energy away"
                )


def _least(matrix: Array, freedoms: tuple[str, ...]) -> float:
    """The least eigenvalue of the freedoms' rows, in units in which their diagonal is 1; of one that has none, 0."""
    rows = [FREEDOMS.index(f) for f in freedoms]
    block = matrix[np.ix_(rows, rows)]
    diagonal = np.diag(block)
    most = float(diagonal.max())
    if diagonal.min() < -1e-12 * most:
        return -1.0
    scale = np.sqrt(np.where(diagonal > 1e-12 * most, diagonal, most or 1.0))
    return float(np.linalg.eigvalsh(block / np.outer(scale, scale))[0])


def check_bushing(hinge: CompliantHinge) -> None:
    """Nothing else holds the sides of a cut hinge: all five freedoms have to be stiff."""
    rigid = [f for f in CROSS_FREEDOMS if f not in hinge.freedoms]
    if rigid:
        raise DesignError(
            f"joint {hinge.joint!r} closes a loop and is compliant, but rigid in {', '.join(rigid)}; give it all "
            "five freedoms with their stiffness, or none"
        )
    rows = [FREEDOMS.index(f) for f in CROSS_FREEDOMS]
    block = hinge.stiffness[np.ix_(rows, rows)]
    scale = np.sqrt(np.maximum(np.diag(block), 0.0))
    loose = [f for f, s in zip(CROSS_FREEDOMS, scale, strict=True) if s == 0.0]
    if loose or float(np.linalg.eigvalsh(block / np.outer(scale, scale))[0]) <= 0.0:
        which = loose[0] if loose else "a combination of its freedoms"
        raise DesignError(
            f"joint {hinge.joint!r} closes a loop and is compliant, but {which} has no stiffness, so nothing would "
            "hold the loop; give the stiffness of every freedom"
        )
