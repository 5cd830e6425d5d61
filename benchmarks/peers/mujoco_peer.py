"""A mechanism with loops in MuJoCo: hinges of a tree, `connect` constraints where loops close.

In: a Mechanism, the hinges at which its loops are cut, gravity, and angles and rates of the other hinges. Out: gaps and
energies. A cut hinge keeps no spring. It shares nothing with lamc but the records.

All body frames coincide with the world's in the drawn configuration, so that every number of the mechanism is used as
it is. A `connect` holds one point of two bodies together. On a plane loop the cut hinge's own point does; where all
axes meet in one point (a vertex), a point further out on the cut hinge's axis.
"""

import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import mujoco
import numpy as np
import numpy.typing as npt

from lamc.records.mechanism import Body, Joint, Mechanism

Array = npt.NDArray[np.float64]

TIMESTEP = 1e-3  # s
# The constraint's own spring: MuJoCo's default, and the stiffest that it allows, two steps, with an impedance near 1.
DEFAULT = 'solref="0.02 1"'
STIFFEST = f'solref="{2 * TIMESTEP:g} 1" solimp="0.9999 0.9999 0.001"'


@dataclass(frozen=True)
class MujocoRun:
    """What a run came to.

    gap     the largest at the cut hinges, m, as `Result.constraint_error`
    energy  (m,), J; angles  at the end, rad, in the order of `tree`
    """

    seconds: float  # of wall time, in MuJoCo's own steps
    gap: float
    energy: Array
    angles: Array


@dataclass(frozen=True)
class _Edge:
    joint: Joint
    body: Body
    sign: float  # of the axis: +1 if the body that hangs on the joint is its child


class MujocoPeer:
    """A compiled model. `tree` names its hinges in the order of MuJoCo's coordinates."""

    def __init__(
        self, mechanism: Mechanism, cuts: Sequence[str], gravity: Sequence[float], constraint: str
    ) -> None:
        self.mechanism = mechanism
        self.cuts = [mechanism.joint(name) for name in cuts]
        self._edges = _hanging(mechanism, [joint for joint in mechanism.joints if joint.name not in cuts])
        self.model = mujoco.MjModel.from_xml_string(self._xml(gravity, constraint))
        self.tree = tuple(self.model.joint(k).name for k in range(self.model.njnt))

    def run(
        self, angles: Mapping[str, float], rates: Mapping[str, float], t_end: float, samples: int
    ) -> MujocoRun:
        """t_end seconds from angles (rad) and rates (rad/s) of the tree's hinges, looked at `samples` times."""
        data = mujoco.MjData(self.model)
        data.qpos[:] = [angles[name] for name in self.tree]
        data.qvel[:] = [rates[name] for name in self.tree]
        mujoco.mj_forward(self.model, data)
        steps = round(t_end / TIMESTEP / samples)
        energy, gap, seconds = [float(data.energy.sum())], 0.0, 0.0
        for _ in range(samples):
            started = time.perf_counter()
            mujoco.mj_step(self.model, data, steps)
            seconds += time.perf_counter() - started
            mujoco.mj_forward(self.model, data)  # poses and energies of the state that the step ended in
            energy.append(float(data.energy.sum()))
            gap = max(gap, *(self._gap(data, joint) for joint in self.cuts))
        return MujocoRun(seconds, gap, np.array(energy), np.array(data.qpos))

    def _gap(self, data: "mujoco.MjData", joint: Joint) -> float:
        points, axes = [], []
        for name in (joint.parent, joint.child):
            if self.mechanism.body(name).fixed:
                points.append(joint.point)
                axes.append(joint.axis)
            else:
                rotation = data.body(name).xmat.reshape(3, 3)
                points.append(data.body(name).xpos + rotation @ joint.point)
                axes.append(rotation @ joint.axis)
        angle = np.arctan2(np.linalg.norm(np.cross(axes[0], axes[1])), axes[0] @ axes[1])
        return max(float(np.linalg.norm(points[1] - points[0])), self.mechanism.size * float(angle))

    def _xml(self, gravity: Sequence[float], constraint: str) -> str:
        """The model in MJCF."""
        fixed = [body.name for body in self.mechanism.bodies if body.fixed]
        bodies = "".join(self._body_xml(edge) for name in fixed for edge in self._edges.get(name, []))
        cuts = "".join(
            f'<connect body1="{_mujoco_name(self.mechanism, joint.parent)}" '
            f'body2="{_mujoco_name(self.mechanism, joint.child)}" '
            f'anchor="{_row(self._anchor(joint))}" {constraint}/>'
            for joint in self.cuts
        )
        return (
            '<mujoco><compiler angle="radian"/>'
            f'<option timestep="{TIMESTEP:g}" integrator="RK4" gravity="{_row(gravity)}">'
            '<flag contact="disable" energy="enable"/></option>'
            f"<worldbody>{bodies}</worldbody><equality>{cuts}</equality></mujoco>"
        )

    def _anchor(self, joint: Joint) -> Array:
        """Where the two sides of a cut hinge are held together, m, on its line."""
        others = [other for other in self.mechanism.joints if other is not joint]
        meet = all(np.linalg.norm(np.cross(j.axis, joint.point - j.point)) < 1e-9 for j in others)
        return joint.point + self.mechanism.size * joint.axis if meet else joint.point

    def _body_xml(self, edge: _Edge) -> str:
        body, joint = edge.body, edge.joint
        # Thin plates have A + B = C to round-off, which MuJoCo refuses; a part in 10^9 more on each axis passes.
        solid = body.inertia + 1e-9 * float(np.abs(body.inertia).max()) * np.eye(3)
        inertia = solid[[0, 1, 2, 0, 0, 1], [0, 1, 2, 1, 2, 2]]
        inner = "".join(self._body_xml(below) for below in self._edges.get(body.name, []))
        return (
            f'<body name="{body.name}"><inertial pos="{_row(body.com)}" mass="{body.mass!r}" '
            f'fullinertia="{_row(inertia)}"/>'
            f'<joint name="{joint.name}" type="hinge" pos="{_row(joint.point)}" '
            f'axis="{_row(edge.sign * joint.axis)}" stiffness="{joint.stiffness!r}" '
            f'springref="{joint.rest_angle!r}"/>{inner}</body>'
        )


def _mujoco_name(mechanism: Mechanism, name: str) -> str:
    return "world" if mechanism.body(name).fixed else name


def _row(values: Sequence[float] | Array) -> str:
    return " ".join(repr(float(value)) for value in values)


def _hanging(mechanism: Mechanism, joints: Sequence[Joint]) -> dict[str, list[_Edge]]:
    """The tree of these joints: edges by the name of the body that they hang on."""
    edges: dict[str, list[_Edge]] = {}
    reached = [body.name for body in mechanism.bodies if body.fixed]
    for name in reached:  # grows as bodies are reached
        for joint in joints:
            for near, far, sign in ((joint.parent, joint.child, 1.0), (joint.child, joint.parent, -1.0)):
                if near == name and far not in reached:
                    edges.setdefault(name, []).append(_Edge(joint, mechanism.body(far), sign))
                    reached.append(far)
    return edges
