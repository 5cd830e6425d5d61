"""Devices from several files that are to move alike, such as the Miura-ori of `tests.physics.test_fold_motion`."""

from collections.abc import Iterable

import numpy as np

import lamc
from lamc.records.mechanism import Mechanism

DAMPING = 2e-7  # N·m·s/rad, of each crease: drawings have one of their own
START = ("z1_0", 0.5)  # rad, out of the flat position


def joint_along(joint: lamc.Joint, among: Iterable[lamc.Joint]) -> str:
    """The name of the joint that lies along the same line, same way round."""
    found = []
    for other in among:
        offset = other.point - joint.point
        apart = np.linalg.norm(np.cross(offset, joint.axis))
        along = float(offset @ joint.axis)
        if apart < 1e-9 and other.axis @ joint.axis > 0.999 and -1e-9 < along < 1e-9:
            found.append(other.name)
    assert len(found) == 1, joint.name
    return str(found[0])


def assert_same_motion(first: Mechanism, *others: Mechanism) -> None:
    """Angles of all joints of `first` are those of the joints along the same lines, for half a second of
    folding."""
    when = np.linspace(0.0, 0.5, 51)
    runs = []
    for made in (first, *others):
        names = {joint.name: joint_along(joint, made.joints) for joint in first.joints}
        model = lamc.compile(made, lamc.Scene(angles={names[START[0]]: START[1]}))
        damping = {f"{name}.damping": DAMPING for name in names.values()}
        run = model.run(t_end=0.5, t_eval=when, rtol=1e-13, atol=1e-15, parameters=damping)
        runs.append({name: run.angle(other) for name, other in names.items()})
    for name, angle in runs[0].items():
        for run in runs[1:]:
            # 1e-9 rad is asked of the same device from two files. The motion passes the flat, singular position, where
            # errors of a run grow: of steps at 1e-11 up to 1.6e-9 is left, by the processor; at 1e-13 2e-11.
            np.testing.assert_allclose(run[name], angle, rtol=0.0, atol=1e-9, err_msg=name)
    assert max(float(np.ptp(angle)) for angle in runs[0].values()) > 0.1  # rad: it does fold
