"""Mechanisms with loops that come out of drawings: hinges in several flexible layers, sheets joined by adhesive, and
creases that meet in a point. Each runs from its file as it is, all with the same call.
"""

import math
from collections.abc import Mapping

import numpy as np
import pytest

import lamc
from lamc.records.mechanism import Body, Joint, Mechanism
from lamc.reference import check
from tests.support.drawn import (
    DIRECTIONS,
    END,
    FAR,
    HIGH,
    LOW,
    MM,
    NEAR,
    ROWS,
    TOP,
    motion,
    same_angle,
    simulator,
)

RING = {"four_bar": (4, 4), "five_bar": (5, 5), "six_bar": (6, 7), "two_loops": (7, 8)}  # bodies, hinges
VERTEX = {"vertex": (4, 4), "waterbomb": (6, 6)}
COUNTS = RING | VERTEX
HEIGHTS = {
    "four_bar": {LOW, HIGH},
    "five_bar": {NEAR, FAR},
    "six_bar": {LOW, HIGH, TOP},
    "two_loops": {LOW, HIGH},
    "vertex": {0.425},
    "waterbomb": {0.425},
}


@pytest.mark.parametrize("name", sorted(COUNTS))
def test_freedoms_are_those_of_gruebler(name: str) -> None:
    """Parallel hinges and hinges through one point both leave three freedoms to a body, of which a hinge takes two."""
    bodies, hinges = COUNTS[name]
    mechanism, loops = simulator(name).mechanism, simulator(name).loops
    assert (len(mechanism.bodies), len(mechanism.joints)) == (bodies, hinges)
    assert loops.freedoms == 3 * (bodies - 1) - 2 * hinges
    assert loops.loops == hinges - (bodies - 1)
    assert (loops.rank, loops.redundant) == (3 * loops.loops, 3 * loops.loops)


@pytest.mark.parametrize("name", sorted(COUNTS))
def test_drawings_run_far_and_stay_closed(name: str) -> None:
    sim, result = simulator(name), motion(name)
    assert max(np.ptp(result.angle(j.name)) for j in sim.mechanism.joints) > math.radians(40)
    assert result.constraint_error.max() <= 1e-9 * sim.mechanism.size  # what lamc promises for any run
    assert result.stats.rejected is not None
    assert result.stats.rejected < result.stats.accepted / 3  # beyond, redundant equations lock it up


@pytest.mark.parametrize("name", sorted(COUNTS))
def test_what_the_energy_loses_is_what_the_hinges_take(name: str) -> None:
    """E(t) - E(0) = -∫ Σ c ω² dt over all hinges, those that close loops included; Simpson's rule on the rows."""
    result = motion(name)
    power = sum(j.damping * result.rate(j.name) ** 2 for j in result.mechanism.joints)

    def lost(step: int) -> float:
        p, h = power[::step], step * END / (ROWS - 1)
        return float(h / 3 * (p[0] + 4 * p[1::2].sum() + 2 * p[2:-1:2].sum() + p[-1]))

    whole = lost(1)
    # The error of Simpson's rule, from half the rows, and of some hundreds of steps, 1e-9 each, partly cancelling.
    limit = abs(whole - lost(2)) + 1e-7 * float(np.ptp(result.energies["kinetic"]))
    assert whole > 1e-2 * float(np.ptp(result.energies["kinetic"]))
    assert abs(result.energy[-1] - result.energy[0] + whole) <= limit


@pytest.mark.parametrize("name", sorted(COUNTS))
@pytest.mark.quick("four_bar")
@pytest.mark.ci("[!f]*", "four_bar")
def test_three_cross_checks_agree_on_drawn_loops(name: str) -> None:
    assert check(simulator(name), states=5, t_end=0.1).passed


@pytest.mark.parametrize("name", sorted(COUNTS))
def test_axes_lie_in_the_middle_of_their_films(name: str) -> None:
    """To round-off of the heights. In rings the centres of mass lie beside every axis that the bodies turn about."""
    mechanism = simulator(name).mechanism
    heights = sorted({round(float(j.point[2]) / MM, 9) for j in mechanism.joints})
    assert heights == pytest.approx(sorted(HEIGHTS[name]), abs=1e-12)
    if name not in RING:
        return
    for joint in mechanism.joints:
        for body in (mechanism.body(joint.parent), mechanism.body(joint.child)):
            assert np.linalg.norm(np.cross(body.com - joint.point, joint.axis)) > 1 * MM


@pytest.mark.parametrize("name", sorted(DIRECTIONS))
def test_creases_that_meet_as_drawn_are_concurrent(name: str) -> None:
    mechanism = simulator(name).mechanism
    centre = np.array([0.0, 0.0, 0.425 * MM])
    for joint in mechanism.joints:
        miss = np.linalg.norm(np.cross(centre - joint.point, joint.axis))
        assert miss <= 1e-15 * mechanism.size  # a few units of round-off


# Flat pieces of bodies as drawn: (x0, x1, y0, y1, z0, z1) in mm and the density; slits take 0.1 mm to either side of a
# hinge from the films, and boards end 1 mm from it.
Box = tuple[float, float, float, float, float, float, float]
FILM, BOARD, CARBON = 1420.0, 700.0, 1600.0
PIECES: Mapping[tuple[str, str], tuple[Box, ...]] = {
    ("four_bar", "arm"): ((1, 39, 0, 14, 0.025, 1.025, BOARD), (0.1, 39.9, 0, 14, 0, 0.025, FILM)),
    ("four_bar", "link"): ((7, 53, 16, 30, 3.325, 4.325, BOARD), (6.1, 53.9, 16, 30, 4.325, 4.35, FILM)),
    ("five_bar", "shin_b"): (
        (13, 33, 13, 24, 5.425, 5.625, CARBON),
        (12.1, 33.9, 13, 24, 5.625, 5.65, FILM),
        (13, 33, 13, 24, 5.65, 5.85, CARBON),
    ),
    ("six_bar", "lid"): ((35, 57, 16, 30, 6.65, 7.65, BOARD), (34.1, 57.9, 16, 30, 7.65, 7.675, FILM)),
    ("two_loops", "arm_2"): ((81, 115, 0, 14, 0.025, 1.025, BOARD), (80.1, 115.9, 0, 14, 0, 0.025, FILM)),
    # Less quarter discs of 0.1 mm that the round ends of two slits take from film and board at (40, 14) and (54, 16).
    ("four_bar", "shelf"): (
        (41, 70, 0, 14, 0.025, 1.025, BOARD),
        (40, 70, 14, 30, 0.025, 1.025, BOARD),
        (40.1, 70, 0, 14, 0, 0.025, FILM),
        (40, 70, 14, 30, 0, 0.025, FILM),
        (57, 70, 0, 30, 1.025, 3.325, 720.0),
        (54, 70, 0, 16, 3.325, 4.325, BOARD),
        (55, 70, 16, 30, 3.325, 4.325, BOARD),
        (54, 70, 0, 16, 4.325, 4.35, FILM),
        (54.1, 70, 16, 30, 4.325, 4.35, FILM),
    ),
}
CORNERS = (
    2 * math.pi / 4 * (0.1 * MM) ** 2 * (1 * BOARD + 0.025 * FILM) * MM
)  # kg: what the quarter discs weigh


def body_of(name: str, boxes: tuple[Box, ...]) -> Body:
    """Mass, centre and inertia of a body of boxes, by the textbook formula of a box and the parallel-axis theorem."""
    sides = np.array([[x1 - x0, y1 - y0, z1 - z0] for x0, x1, y0, y1, z0, z1, _ in boxes]) * MM
    centres = np.array([[x0 + x1, y0 + y1, z0 + z1] for x0, x1, y0, y1, z0, z1, _ in boxes]) * MM / 2
    masses = np.prod(sides, axis=1) * np.array([box[6] for box in boxes])
    com = masses @ centres / masses.sum()
    inertia = np.zeros((3, 3))
    for mass, side, centre in zip(masses, sides, centres, strict=True):
        r = centre - com
        inertia += mass / 12 * np.diag((side**2).sum() - side**2) + mass * (
            r @ r * np.eye(3) - np.outer(r, r)
        )
    return Body(name, float(masses.sum()), com, inertia)


@pytest.mark.parametrize(("name", "body"), sorted(PIECES))
def test_bodies_weigh_what_their_pieces_weigh(name: str, body: str) -> None:
    expected, found = body_of(body, PIECES[name, body]), simulator(name).mechanism.body(body)
    missing = CORNERS if body == "shelf" else 0.0
    part = missing / expected.mass + 1e-12  # round-off of coordinates
    assert found.mass == pytest.approx(expected.mass, rel=part)
    assert found.com == pytest.approx(expected.com, abs=part * 0.07)  # lengths in the drawing are below 70 mm
    assert found.inertia == pytest.approx(expected.inertia, abs=part * expected.mass * 0.07**2)


def test_a_mechanism_by_hand_with_the_drawings_numbers_moves_alike() -> None:
    def hinge(name: str, parent: str, child: str, x: float, z: float) -> Joint:
        return Joint(name, parent, child, (x * MM, 0, z * MM), (0, 1, 0), stiffness=2.3e-5, damping=1e-6)  # type: ignore[arg-type]

    moving = tuple(body_of(n, PIECES["four_bar", n]) for n in ("arm", "link", "shelf"))
    hinges = (
        hinge("arm", "ground", "arm", 0, LOW),
        hinge("arm_shelf", "arm", "shelf", 40, LOW),
        hinge("link", "ground", "link", 6, HIGH),
        hinge("link_shelf", "link", "shelf", 54, HIGH),
    )
    by_hand = Mechanism((Body("ground", fixed=True), *moving), hinges)
    scene = lamc.Scene(angles={"arm": math.radians(20)})
    result = lamc.compile(by_hand, scene).run(t_end=1.0, rtol=1e-9, atol=1e-11, t_eval=[0.25, 0.5, 0.75, 1.0])
    drawn = motion("four_bar")
    rows = [round(t / END * (ROWS - 1)) for t in result.t]
    for joint in hinges:
        # The shelf's missing corners are a part of 1e-5 of its mass, and two swings add up no more than ten of that.
        assert (
            same_angle(result.angle(joint.name), drawn.angle(joint.name)[rows])
            <= 10 * CORNERS / moving[2].mass
        )
