"""Small vector and matrix algebra on scalars: plain numbers fold, `Value`s are staged.

Rotations are elementary (about x or z) and cost what their zeros leave. No numpy: entries are symbolic.
"""

from collections.abc import Sequence
from typing import NamedTuple

from lamc.symbolic.scalars import Scalar

Vector3 = tuple[Scalar, Scalar, Scalar]
Matrix3 = tuple[Vector3, Vector3, Vector3]

ZERO: Vector3 = (0, 0, 0)


class Symmetric(NamedTuple):
    """A symmetric 3×3 matrix."""

    xx: Scalar
    yy: Scalar
    zz: Scalar
    xy: Scalar
    xz: Scalar
    yz: Scalar

    def entry(self, i: int, j: int) -> Scalar:
        return self[_SLOT[i][j]]

    def rows(self) -> Matrix3:
        return ((self.xx, self.xy, self.xz), (self.xy, self.yy, self.yz), (self.xz, self.yz, self.zz))


_SLOT = ((0, 3, 4), (3, 1, 5), (4, 5, 2))


class AxisRotation(NamedTuple):
    """A rotation about one coordinate axis, "x" or "z", by the angle with this cosine and sine."""

    axis: str
    cos: Scalar
    sin: Scalar


def total(terms: Sequence[Scalar]) -> Scalar:
    result: Scalar = 0
    for term in terms:
        result = result + term
    return result


def dot(a: Sequence[Scalar], b: Sequence[Scalar]) -> Scalar:
    return total([x * y for x, y in zip(a, b, strict=True)])


def cross(a: Vector3, b: Vector3) -> Vector3:
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def add(a: Vector3, b: Vector3) -> Vector3:
    return (a[0] + b[0], a[1] + b[1], a[2] + b[2])


def scale(k: Scalar, v: Vector3) -> Vector3:
    return (k * v[0], k * v[1], k * v[2])


def skew(v: Vector3) -> Matrix3:
    """[v]×, so that skew(v) w = v × w."""
    return ((0, -v[2], v[1]), (v[2], 0, -v[0]), (-v[1], v[0], 0))


def outward(rotation: AxisRotation, v: Vector3) -> Vector3:
    """Components in the turned frame of a vector given in the frame before the turn."""
    c, s = rotation.cos, rotation.sin
    if rotation.axis == "z":
        return (c * v[0] + s * v[1], c * v[1] - s * v[0], v[2])
    return (v[0], c * v[1] + s * v[2], c * v[2] - s * v[1])


def inward(rotation: AxisRotation, v: Vector3) -> Vector3:
    """Components in the frame before the turn of a vector given in the turned frame."""
    c, s = rotation.cos, rotation.sin
    if rotation.axis == "z":
        return (c * v[0] - s * v[1], s * v[0] + c * v[1], v[2])
    return (v[0], c * v[1] - s * v[2], s * v[1] + c * v[2])


def inward_symmetric(rotation: AxisRotation, a: Symmetric) -> Symmetric:
    """R a Rᵀ, with the 2×2 block by w = s (a - d) + 2 c b: (a - s w, d + s w, c w - b), 4 products for 7.

    2 c is shared by all tensors that take the same turn, and of a fold it is a constant.
    """
    c, s = rotation.cos, rotation.sin
    if rotation.axis == "z":
        w = s * (a.xx - a.yy) + (2 * c) * a.xy
        sw = s * w
        return Symmetric(a.xx - sw, a.yy + sw, a.zz, c * w - a.xy, c * a.xz - s * a.yz, s * a.xz + c * a.yz)
    w = s * (a.yy - a.zz) + (2 * c) * a.yz
    sw = s * w
    return Symmetric(a.xx, a.yy - sw, a.zz + sw, c * a.xy - s * a.xz, s * a.xy + c * a.xz, c * w - a.yz)


def inward_matrix(rotation: AxisRotation, m: Matrix3) -> Matrix3:
    """R m Rᵀ for any 3×3 matrix, in the same manner."""
    c, s = rotation.cos, rotation.sin
    if rotation.axis == "z":
        w = s * (m[0][0] - m[1][1]) + c * (m[0][1] + m[1][0])
        sw, cw = s * w, c * w
        return (
            (m[0][0] - sw, cw - m[1][0], c * m[0][2] - s * m[1][2]),
            (cw - m[0][1], m[1][1] + sw, s * m[0][2] + c * m[1][2]),
            (c * m[2][0] - s * m[2][1], s * m[2][0] + c * m[2][1], m[2][2]),
        )
    w = s * (m[1][1] - m[2][2]) + c * (m[1][2] + m[2][1])
    sw, cw = s * w, c * w
    return (
        (m[0][0], c * m[0][1] - s * m[0][2], s * m[0][1] + c * m[0][2]),
        (c * m[1][0] - s * m[2][0], m[1][1] - sw, cw - m[2][1]),
        (s * m[1][0] + c * m[2][0], cw - m[1][2], m[2][2] + sw),
    )
