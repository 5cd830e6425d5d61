"""The hand-written C recursion (`hand_recursion.c`) as a peer: a Mechanism in, numbers out.

Nothing of the compiler is used: frames and offsets are computed here from the Mechanism with numpy.
"""

import ctypes
import subprocess
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from lamc.records.mechanism import Mechanism
from lamc.reference.kinematics import Link, walk
from lamc.reference.loads import NumericLoads, numeric_loads

Array = npt.NDArray[np.float64]
SOURCE = Path(__file__).with_name("hand_recursion.c")
MAX_BODIES = 128


def compile_library(folder: Path, compiler: str = "cc", flags: Sequence[str] = ("-O2",)) -> ctypes.CDLL:
    """The recursion as a shared library in `folder`."""
    library = folder / "hand_recursion.so"
    command = [compiler, "-std=c11", "-ffp-contract=off", *flags, "-fPIC", "-shared"]
    subprocess.run([*command, "-o", str(library), str(SOURCE), "-lm"], check=True)
    return ctypes.CDLL(str(library))


class _PlanarBody(ctypes.Structure):
    _fields_ = [
        ("inner", ctypes.c_int),
        ("mass", ctypes.c_double),
        ("offset", ctypes.c_double * 2),
        ("moment", ctypes.c_double * 2),
        ("inertia", ctypes.c_double),
        ("stiffness", ctypes.c_double),
        ("damping", ctypes.c_double),
        ("preload", ctypes.c_double),
    ]


class _PlanarModel(ctypes.Structure):
    _fields_ = [("n", ctypes.c_int), ("gravity", ctypes.c_double * 2), ("body", _PlanarBody * MAX_BODIES)]


class _SpaceBody(ctypes.Structure):
    _fields_ = [
        ("inner", ctypes.c_int),
        ("mass", ctypes.c_double),
        ("turn", ctypes.c_double * 9),
        ("offset", ctypes.c_double * 3),
        ("moment", ctypes.c_double * 3),
        ("inertia", ctypes.c_double * 6),
        ("stiffness", ctypes.c_double),
        ("damping", ctypes.c_double),
        ("preload", ctypes.c_double),
    ]


class _SpaceModel(ctypes.Structure):
    _fields_ = [("n", ctypes.c_int), ("gravity", ctypes.c_double * 3), ("body", _SpaceBody * MAX_BODIES)]


class HandRecursion:
    """The recursion on one mechanism: planar where all hinge lines are parallel, else in space.

    q and u are in the order of `joints`. Constant torques only.
    """

    def __init__(
        self,
        library: ctypes.CDLL,
        mechanism: Mechanism,
        effects: Iterable[Any],
        joints: Sequence[str],
        planar: bool | None = None,
    ) -> None:
        links = walk(mechanism, joints)
        loads = numeric_loads(mechanism, effects, joints)
        if not len(links) == len(joints) <= MAX_BODIES or loads.torques or loads.at_points:
            raise ValueError(
                "the hand recursion takes 128 bodies at most, no loops, constant torques only and no forces at points"
            )
        common = links[0].joint.axis
        parallel = all(np.linalg.norm(np.cross(common, link.joint.axis)) < 1e-12 for link in links)
        self.planar = parallel if planar is None else planar
        self._order = np.array([link.coordinate for link in links], dtype=int)
        if self.planar:
            self._sign = np.array([link.sign * np.sign(common @ link.joint.axis) for link in links])
            self._model: Any = _planar_model(links, loads, common, self._sign)
        else:
            self._sign = np.ones(len(links))
            self._model = _space_model(links, loads)
        prefix = "planar" if self.planar else "space"
        self._rows = getattr(library, f"{prefix}_rows")
        self._run = getattr(library, f"{prefix}_run")
        self._run.restype = ctypes.c_long

    def rows(self, q: Array, u: Array) -> Array:
        """States by row in the recursion's own order, ready for `accelerations_of`, shape (m, 2n)."""
        own = np.hstack([q[:, self._order] * self._sign, u[:, self._order] * self._sign])
        return np.ascontiguousarray(own)

    def accelerations_of(self, rows: Array, result: Array) -> None:
        """du/dt of each row, in the recursion's own order, into `result`, shape (m, n)."""
        self._rows(ctypes.byref(self._model), ctypes.c_long(len(rows)), _pointer(rows), _pointer(result))

    def acceleration(self, q: Array, u: Array) -> Array:
        """du/dt, shape (n,), rad/s²."""
        own = np.empty((1, len(q)))
        self.accelerations_of(self.rows(q[None, :], u[None, :]), own)
        return self.in_order_of_joints(own)[0]

    def in_order_of_joints(self, own: Array) -> Array:
        """Rows in the recursion's own order, shape (m, n), in the order of `joints`."""
        result = np.empty_like(own)
        result[:, self._order] = own * self._sign
        return result

    def run(self, q: Array, u: Array, t_end: float, rtol: float, atol: float) -> tuple[Array, int]:
        """Angles at t_end, shape (n,), and the number of accepted Dormand-Prince steps."""
        state = self.rows(q[None, :], u[None, :])
        number = ctypes.c_double
        steps = self._run(
            ctypes.byref(self._model), _pointer(state), number(t_end), number(rtol), number(atol)
        )
        if steps < 0:
            raise RuntimeError("the hand recursion's step underflows")
        return self.in_order_of_joints(state[:, : len(q)])[0], steps


def _pointer(array: Array) -> Any:
    return array.ctypes.data_as(ctypes.POINTER(ctypes.c_double))


def _planar_model(links: Sequence[Link], loads: NumericLoads, normal: Array, sign: Array) -> _PlanarModel:
    across = _frame(normal)[:, :2].T
    model = _PlanarModel(n=len(links))
    model.gravity[:] = across @ loads.gravity
    for i, link in enumerate(links):
        inner_point = links[link.inner].joint.point if link.inner >= 0 else np.zeros(3)
        arm = across @ (link.body.com - link.joint.point)
        body = model.body[i]
        body.inner, body.mass = link.inner, link.body.mass
        body.offset[:] = across @ (link.joint.point - inner_point)
        body.moment[:] = link.body.mass * arm
        body.inertia = normal @ link.body.inertia @ normal + link.body.mass * (arm @ arm)
        body.stiffness, body.damping = loads.stiffness[link.coordinate], loads.damping[link.coordinate]
        body.preload = sign[i] * (loads.preload + loads.applied)[link.coordinate]
    return model


def _space_model(links: Sequence[Link], loads: NumericLoads) -> _SpaceModel:
    frames = [_frame(link.sign * link.joint.axis) for link in links]
    model = _SpaceModel(n=len(links))
    model.gravity[:] = loads.gravity
    for i, link in enumerate(links):
        inner_frame = frames[link.inner] if link.inner >= 0 else np.eye(3)
        inner_point = links[link.inner].joint.point if link.inner >= 0 else np.zeros(3)
        arm = frames[i].T @ (link.body.com - link.joint.point)
        inertia = frames[i].T @ link.body.inertia @ frames[i]
        inertia += link.body.mass * ((arm @ arm) * np.eye(3) - np.outer(arm, arm))
        body = model.body[i]
        body.inner, body.mass = link.inner, link.body.mass
        body.turn[:] = (inner_frame.T @ frames[i]).ravel()
        body.offset[:] = inner_frame.T @ (link.joint.point - inner_point)
        body.moment[:] = link.body.mass * arm
        body.inertia[:] = [inertia[r, c] for r, c in ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))]
        body.stiffness, body.damping = loads.stiffness[link.coordinate], loads.damping[link.coordinate]
        body.preload = (loads.preload + loads.applied)[link.coordinate]
    return model


def _frame(axis: Array) -> Array:
    """Right-handed unit vectors as columns, the third along `axis`, shape (3, 3)."""
    helper = np.eye(3)[int(np.argmin(np.abs(axis)))]
    first = np.cross(helper, axis)
    first /= np.linalg.norm(first)
    return np.column_stack([first, np.cross(axis, first), axis])
