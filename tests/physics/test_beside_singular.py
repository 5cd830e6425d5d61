"""States beside a singular position, of loops with several freedoms: accelerations against those by fifty digits.

A five-bar whose bars fold into one line has two freedoms, and passes beside that line by any distance. Its
accelerations turn with the state there: from places a hundredth of a radian away nothing is known of them. The
reference is written by absolute angles of the bars with Lagrange multipliers, in numbers of mpmath.
"""

from pathlib import Path
from typing import Any

import mpmath
import numpy as np
import pytest
from numpy.typing import NDArray

import lamc
from tests.support.ctools import needs_cc

Array = NDArray[np.float64]

LENGTHS, GROUND = (1.0, 1.5, 1.0, 0.5), 2.0  # m: 1 + 1.5 - 1 + 0.5 = 2, a line with the third bar turned back
LINE = np.array([0.0, 0.0, np.pi, 0.0])  # angles of the bars there, rad
STIFFNESS = 1.0  # N·m/rad of each hinge
THIN = 1e-7  # kg·m²

pytestmark = needs_cc


def ends(angles: Any) -> Any:
    """Where each bar begins, and the last one ends (5, 2), m."""
    steps = [[length * np.cos(a), length * np.sin(a)] for length, a in zip(LENGTHS, angles, strict=True)]
    return np.vstack([[0.0, 0.0], np.cumsum(steps, axis=0)])


def closed(angles: Array) -> Array:
    """The closed position near angles (4,), rad, by Newton's method with fifty digits, rounded."""
    theta = mpmath.matrix(list(map(mpmath.mpf, angles)))
    for _ in range(60):
        gap, rows = closure(theta)
        if mpmath.norm(gap) < mpmath.mpf(10) ** -40:
            break
        theta -= rows.T * mpmath.lu_solve(rows * rows.T, gap)
    return np.array([float(value) for value in theta])


def closure(theta: Any) -> tuple[Any, Any]:
    """Gap (2,) and its derivatives (2, 4)."""
    gap, rows = mpmath.matrix([-GROUND, 0.0]), mpmath.matrix(2, 4)
    for k, length in enumerate(LENGTHS):
        cos, sin = mpmath.cos(theta[k]), mpmath.sin(theta[k])
        gap += mpmath.matrix([length * cos, length * sin])
        rows[0, k], rows[1, k] = -length * sin, length * cos
    return gap, rows


DRAWN = closed(np.array([1.0, 0.2, -1.5, -0.8]))


def accelerations(angles: Array, rates: Array) -> Array:
    """Of the bars (4,), rad/s²: thin rods of 1 kg/m, springs at all five hinges, by M a + J^T λ = f, J a = -γ."""
    theta, omega = ([mpmath.mpf(float(x)) for x in row] for row in (angles, rates))
    mass, force = mpmath.matrix(4, 4), mpmath.matrix(4, 1)
    for bar, length in enumerate(LENGTHS):
        arms = [*LENGTHS[:bar], 0.5 * length]
        for a, first in enumerate(arms):
            for b, second in enumerate(arms):
                turned = theta[a] - theta[b]
                mass[a, b] += length * first * second * mpmath.cos(turned)
                force[a] -= length * first * second * mpmath.sin(turned) * omega[b] ** 2
        mass[bar, bar] += mpmath.mpf(length) ** 3 / 12
    bent = [theta[k] - mpmath.mpf(float(DRAWN[k])) for k in range(4)]
    for k in range(4):
        force[k] -= STIFFNESS * (bent[k] - (bent[k - 1] if k else 0))
        force[k] += STIFFNESS * (bent[k + 1] - bent[k]) if k < 3 else -STIFFNESS * bent[k]
    _, rows = closure(theta)
    gamma = mpmath.matrix(2, 1)
    for k, length in enumerate(LENGTHS):
        gamma -= length * omega[k] ** 2 * mpmath.matrix([mpmath.cos(theta[k]), mpmath.sin(theta[k])])
    system = mpmath.matrix(6, 6)
    for a in range(4):
        for b in range(4):
            system[a, b] = mass[a, b]
        for r in range(2):
            system[a, 4 + r] = system[4 + r, a] = rows[r, a]
    found = mpmath.lu_solve(system, mpmath.matrix([*force, *(-gamma)]))
    return np.array([float(value) for value in found[:4]])


def five_bar(folder: Path) -> lamc.Simulator:
    places = ends(DRAWN)
    text = ["kind: mechanism", "name: five_bar", "bodies:", "  - {name: ground, fixed: true}"]
    for k, length in enumerate(LENGTHS):
        middle, along = 0.5 * (places[k] + places[k + 1]), np.append(places[k + 1] - places[k], 0.0) / length
        inertia = length**3 / 12.0 * (np.eye(3) - np.outer(along, along)) + THIN * np.outer(along, along)
        com = [*middle.tolist(), 0.0]
        text.append(f"  - {{name: b{k}, mass: {length}, com: {com}, inertia: {inertia.tolist()}}}")
    text.append("joints:")
    names = ["ground", "b0", "b1", "b2", "b3"]
    for k in range(5):
        pair = f"parent: {names[k]}, child: {names[k + 1]}" if k < 4 else "parent: ground, child: b3"
        point = [*places[k].tolist(), 0.0] if k < 4 else [GROUND, 0.0, 0.0]
        text.append(f"  - {{name: j{k}, {pair}, point: {point}, axis: [0, 0, 1], stiffness: {STIFFNESS}}}")
    file = folder / "five_bar.yaml"
    file.write_text("\n".join(text) + "\n", encoding="utf-8")
    design = lamc.load(file)
    return lamc.compile(design)


def of_joints(simulator: lamc.Simulator, bars: Array) -> Array:
    """What the bars turn by, as angles of the joints in their order."""
    by_name = {f"j{k}": bars[k] - (bars[k - 1] if k else 0.0) for k in range(4)} | {"j4": bars[3]}
    return np.array([by_name[name] for name in simulator.joints])


@pytest.mark.parametrize("distance", [1e-3, 3e-3, 1e-2, 0.1])
def test_accelerations_beside_the_line_are_those_of_the_state(distance: float, tmp_path: Path) -> None:
    """At rest, creeping and moving. One of two equations holds there by `distance` or so: what 1e-10 of closure turns
    (OUT_OF_NOTHING) and 1e-15 by the square of that. Places around are taken where they agree to 1e-5 (ALIKE). From
    3e-5 on (PASSING) an equation is let go."""
    simulator = five_bar(tmp_path)
    generator = np.random.default_rng(20260302)
    with mpmath.workdps(50):
        for _ in range(8):
            angles = closed(LINE + distance * generator.uniform(-1.0, 1.0, 4))
            _, rows = closure([mpmath.mpf(float(x)) for x in angles])
            held = np.array(rows.tolist(), dtype=float)
            motion = generator.normal(size=4)
            motion -= np.linalg.pinv(held, rcond=1e-12) @ (held @ motion)
            for speed in (0.0, 1e-6, 1.0):
                rates = speed * motion / np.abs(motion).max()
                expected = of_joints(simulator, accelerations(angles, rates))
                found = simulator.acceleration(
                    of_joints(simulator, angles - DRAWN), of_joints(simulator, rates)
                )
                assert np.abs(found - expected).max() <= 1e-5 * np.abs(expected).max()
