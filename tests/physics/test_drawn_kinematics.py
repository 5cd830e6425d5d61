"""Drawn loops against closed forms: Freudenstein's equation, circles that meet, spherical trigonometry."""

import math
from dataclasses import dataclass

import numpy as np
import pytest

from tests.support.drawn import ANGLE, DIRECTIONS, FAR, HIGH, LOW, NEAR, ROWS, TOP, Array, motion, same_angle

Point = tuple[float, float]


@dataclass(frozen=True)
class FourBar:
    """A ring of four hinges: crank O2 A, coupler A B, follower O4 B, ground O2 O4; a name and a place, mm, each."""

    crank: tuple[str, Point]  # at O2
    coupler: tuple[str, Point]  # crank to coupler, at A
    follower: tuple[str, Point]  # at O4
    closing: tuple[str, Point]  # follower to coupler, at B


RINGS = {
    ("four_bar", 1): FourBar(
        ("arm", (0, LOW)), ("arm_shelf", (40, LOW)), ("link", (6, HIGH)), ("link_shelf", (54, HIGH))
    ),
    ("two_loops", 1): FourBar(
        ("arm_1", (0, LOW)), ("arm_1_step", (40, LOW)), ("link_1", (6, HIGH)), ("link_1_step", (54, HIGH))
    ),
    ("two_loops", 2): FourBar(
        ("arm_2", (80, LOW)), ("arm_2_step", (116, LOW)), ("link_2", (87, HIGH)), ("link_2_step", (129, HIGH))
    ),
    ("six_bar", 1): FourBar(
        ("arm", (0, LOW)), ("arm_scoop", (52, LOW)), ("link", (6, HIGH)), ("link_scoop", (70, HIGH))
    ),
    ("six_bar", 2): FourBar(
        ("link_scoop", (70, HIGH)), ("flap_scoop", (86, TOP)), ("link_lid", (34, TOP)), ("fold", (58, TOP))
    ),
}


def freudenstein(a: float, b: float, c: float, d: float, crank: Array, side: float) -> Array:
    """Follower angle of a four-bar with crank a, coupler b, follower c and ground d, from the ground line, rad.

    Freudenstein 1955: K1 cos θ4 - K2 cos θ2 + K3 = cos(θ2 - θ4), K1 = d/a, K2 = d/c, K3 = (a² - b² + c² + d²)/(2ac),
    as p cos θ4 + s sin θ4 = r, which has the two assemblies `side` = ±1.
    """
    k1, k2, k3 = d / a, d / c, (a * a - b * b + c * c + d * d) / (2 * a * c)
    p, s = k1 - np.cos(crank), -np.sin(crank)
    r = k2 * np.cos(crank) - k3
    return np.arctan2(s, p) + side * np.arccos(r / np.hypot(p, s))


def heading(start: Point, end: Point) -> float:
    return math.atan2(end[1] - start[1], end[0] - start[0])


@pytest.mark.parametrize(("name", "number"), sorted(RINGS))
@pytest.mark.quick("four_bar-1", "two_loops-*")
def test_rings_of_four_obey_freudenstein(name: str, number: int) -> None:
    ring, result = RINGS[name, number], motion(name)
    (_, o2), (_, a), (_, o4), (_, b) = ring.crank, ring.coupler, ring.follower, ring.closing
    ground = heading(o2, o4)
    crank = heading(o2, a) - ground - result.angle(ring.crank[0])
    follower = heading(o4, b) - ground - result.angle(ring.follower[0])
    lengths = (math.dist(o2, a), math.dist(a, b), math.dist(o4, b), math.dist(o2, o4))
    misses = [same_angle(freudenstein(*lengths, crank, side), follower) for side in (1.0, -1.0)]
    assert min(misses) <= ANGLE
    assert max(misses) > 0.1  # the other assembly is another motion, so the comparison tells them apart
    # The coupler's direction from the places of its ends, by way of the crank and of the follower.
    ends = [
        np.array([np.cos(angle), np.sin(angle)]) * length
        for angle, length in ((crank, lengths[0]), (follower, lengths[2]))
    ]
    across = ends[1] - ends[0] + np.array([[lengths[3]], [0.0]])
    rotated = heading(a, b) - ground - np.arctan2(across[1], across[0])
    for first, second in ((ring.crank, ring.coupler), (ring.follower, ring.closing)):
        assert same_angle(result.angle(first[0]) + result.angle(second[0]), rotated) <= ANGLE


def test_the_ring_of_five_closes_as_two_circles_meet() -> None:
    """With both thighs given, the upper ankle is where circles about the knee and about the lower ankle meet."""
    hip_a, ankle_a, hip_b, knee, ankle_b = (0.0, NEAR), (25.0, NEAR), (-5.0, FAR), (12.0, FAR), (34.0, FAR)
    result = motion("five_bar")

    def placed(at: Point, length: float, drawn: float, rotation: Array) -> Array:
        return np.array(
            [at[0] + length * np.cos(drawn - rotation), at[1] + length * np.sin(drawn - rotation)]
        )

    lower = placed(hip_a, 25.0, heading(hip_a, ankle_a), result.angle("hip_a"))
    upper = placed(hip_b, 17.0, heading(hip_b, knee), result.angle("hip_b"))
    shin, foot = math.dist(knee, ankle_b), math.dist(ankle_a, ankle_b)
    gap = lower - upper
    distance = np.hypot(*gap)
    along = (shin**2 - foot**2 + distance**2) / (2 * distance)
    across = np.sqrt(shin**2 - along**2)
    misses = []
    for side in (1.0, -1.0):
        meeting = upper + (along * gap + side * across * np.array([-gap[1], gap[0]])) / distance
        shin_rotation = heading(knee, ankle_b) - np.arctan2(*(meeting - upper)[::-1])
        foot_rotation = heading(ankle_a, ankle_b) - np.arctan2(*(meeting - lower)[::-1])
        misses.append(
            max(
                same_angle(result.angle("hip_b") + result.angle("knee_b"), shin_rotation),
                same_angle(result.angle("hip_a") + result.angle("ankle_a"), foot_rotation),
                same_angle(result.angle("ankle_b"), shin_rotation - foot_rotation),
            )
        )
    assert min(misses) <= ANGLE
    assert max(misses) > 0.1  # the other meeting point is another posture


def rotation_about(direction: float, angle: float) -> Array:
    """Rotation by `angle`, rad, about a direction in the plane, degrees (Rodrigues)."""
    x, y = math.cos(math.radians(direction)), math.sin(math.radians(direction))
    k = np.array([[0.0, 0.0, y], [0.0, 0.0, -x], [-y, x, 0.0]])
    return np.eye(3) + math.sin(angle) * k + (1 - math.cos(angle)) * (k @ k)


@pytest.mark.parametrize("name", sorted(DIRECTIONS))
def test_folds_at_a_vertex_compose_to_nothing(name: str) -> None:
    """Belcastro and Hull 2002: the turns about the drawn creases, one after the other around the vertex, cancel."""
    result = motion(name)
    for row in range(0, ROWS, 400):
        product = np.eye(3)
        for crease, direction in DIRECTIONS[name].items():
            product = product @ rotation_about(direction, float(result.angle(crease)[row]))
        assert np.abs(product - np.eye(3)).max() <= ANGLE


def test_the_vertex_folds_as_spherical_trigonometry_says() -> None:
    """Sectors 60, 75, 120, 105 degrees: fold angles from the law of cosines, and the half-angle relation of the
    flat-foldable vertex (Tachi 2009; Evans et al. 2015)."""
    result = motion("vertex")
    q1, q2, q3, q4 = (result.angle(f"c{i}") for i in (1, 2, 3, 4))
    s1, s2, s3, s4 = (math.radians(a) for a in (60, 75, 120, 105))
    # The arc from crease 2 to crease 4, over the two sectors at crease 1; the interior angle there is π less the fold.
    arc = np.arccos(math.cos(s1) * math.cos(s4) - math.sin(s1) * math.sin(s4) * np.cos(q1))
    near = np.arccos((math.cos(s4) - math.cos(s1) * np.cos(arc)) / (math.sin(s1) * np.sin(arc)))
    far = np.arccos((math.cos(s3) - math.cos(s2) * np.cos(arc)) / (math.sin(s2) * np.sin(arc)))
    opposite = np.arccos((math.cos(s2) * math.cos(s3) - np.cos(arc)) / (math.sin(s2) * math.sin(s3)))
    assert same_angle(np.abs(q3), opposite) <= ANGLE
    assert min(same_angle(np.abs(q2), np.abs(math.pi - near - sign * far)) for sign in (1, -1)) <= ANGLE
    ratio = math.cos((s1 + s2) / 2) / math.cos((s1 - s2) / 2)
    assert same_angle(2 * np.arctan(-ratio * np.tan(q1 / 2)), q2) <= ANGLE
    assert same_angle(q1, q3) <= ANGLE
    assert same_angle(q2, -q4) <= ANGLE
