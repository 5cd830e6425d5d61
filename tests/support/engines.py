"""Exported models in MuJoCo, for tests: the model as MuJoCo loads it, and its coordinates in lamc's order.

In: files as an export gives them, or a mechanism and a scene. Out: numbers of MuJoCo's. Skips where MuJoCo is missing.
"""

import importlib
from collections.abc import Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import lamc
from lamc.export import mjcf
from lamc.export.options import ExportOptions
from lamc.records.mechanism import Array, Mechanism

mujoco: Any = None
with suppress(ImportError):
    mujoco = importlib.import_module("mujoco")


def written(files: Mapping[str, bytes], folder: Path) -> Path:
    """The files in a folder; returns the model's."""
    for name, content in files.items():
        path = folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(content)
    (model,) = (folder / name for name in files if name.endswith((".xml", ".urdf")) and name != "package.xml")
    return model


def load(files: Mapping[str, bytes], folder: Path) -> Any:
    """The model as MuJoCo compiles it; skips the test where MuJoCo is missing."""
    if mujoco is None:
        pytest.skip("MuJoCo is not installed: pip install lamc[bench]")
    return mujoco.MjModel.from_xml_path(str(written(files, folder)))


class InMujoco:
    """A mechanism in its scene as MuJoCo simulates it. Joints of the design are of the same names here."""

    def __init__(
        self, mechanism: Mechanism, scene: lamc.Scene, folder: Path, options: ExportOptions | None = None
    ) -> None:
        self.files = mjcf.files(mechanism, scene, options or ExportOptions())
        self.readme = self.files["README.md"].decode()
        self.model = load(self.files, folder)
        self.data = mujoco.MjData(self.model)
        mujoco.mj_resetDataKeyframe(self.model, self.data, 0)

    def place(self, joint: str) -> tuple[int, int]:
        """Where the joint's angle is in qpos, and its rate in qvel."""
        index = self.model.joint(joint).id
        return self.model.jnt_qposadr[index], self.model.jnt_dofadr[index]

    def rates(self, names: tuple[str, ...]) -> list[int]:
        """Places in qvel of rates as lamc has them: joints by name, and a floating base's six, which end its list."""
        return [self.place(name)[1] for name in names if not name.startswith("base.")] + [
            k for k, name in enumerate(n for n in names if n.startswith("base."))
        ]

    def accelerations(self, simulator: lamc.Simulator, q: Array, u: Array) -> Array:
        """qacc in lamc's order at lamc's q and u."""
        self.put(simulator, q, u)
        mujoco.mj_forward(self.model, self.data)
        return np.array(self.data.qacc[self.rates(tuple(r.name for r in simulator.rates))])

    def mass_matrix(self, simulator: lamc.Simulator, q: Array) -> Array:
        """M in lamc's order."""
        self.put(simulator, q, np.zeros(len(simulator.rates)))
        mujoco.mj_forward(self.model, self.data)
        full = np.zeros((self.model.nv, self.model.nv))
        for column in range(self.model.nv):
            unit = np.zeros(self.model.nv)
            unit[column] = 1.0
            mujoco.mj_mulM(self.model, self.data, full[column], unit)
        order = self.rates(tuple(r.name for r in simulator.rates))
        return full[np.ix_(order, order)]

    def put(self, simulator: lamc.Simulator, q: Array, u: Array) -> None:
        """MuJoCo's state from lamc's."""
        count = len(simulator.joints)
        for k, name in enumerate(simulator.joints):
            angle, rate = self.place(name)
            self.data.qpos[angle], self.data.qvel[rate] = q[k], u[k]
        if len(q) > count:
            self.data.qpos[:7], self.data.qvel[:6] = q[count:], u[count:]

    def end(self, t_end: float, step: float) -> None:
        """Runs from the start to t_end, s."""
        mujoco.mj_resetDataKeyframe(self.model, self.data, 0)
        self.model.opt.timestep = step
        mujoco.mj_step(self.model, self.data, round(t_end / step))


def end_errors(
    mechanism: Mechanism, scene: lamc.Scene, folder: Path, t_end: float, steps: Sequence[float]
) -> list[float]:
    """Largest difference of any angle at t_end, s, rad, from lamc at round-off, for each step, s."""
    simulator = lamc.compile(mechanism, scene)
    result = simulator.run(t_end, rtol=1e-12, atol=1e-14, t_eval=[0.0, t_end])
    assert result.success
    engine = InMujoco(mechanism, scene, folder)
    errors = []
    for step in steps:
        engine.end(t_end, step)
        ends = [
            engine.data.qpos[engine.place(j.name)[0]] - result.angle(j.name)[-1] for j in mechanism.joints
        ]
        errors.append(float(np.abs(np.remainder(np.array(ends) + np.pi, 2.0 * np.pi) - np.pi).max()))
    return errors
