"""Starts of loops at given angles are in the way of assembly that was drawn, and count turns: by plane geometry."""

import math

import numpy as np
import pytest
from scipy.optimize import fsolve

import lamc
from lamc.records.mechanism import Array
from tests.support.ctools import needs_cc

pytestmark = needs_cc

# Ground, crank, coupler, rocker, mm, and the crank's angle as drawn, rad: the ground is shortest in a double crank, of
# which no motion leads from one way of assembly to the other.
DOUBLE_CRANK = (28.9, 43.1, 46.2, 38.5, 2.48)
ANOTHER = (27.3, 53.8, 54.4, 36.2, 0.04)
CRANK_ROCKER = (55.0, 20.0, 60.0, 40.0, 0.5)


def four_bar(
    ground: float, crank: float, coupler: float, rocker: float, drawn: float
) -> tuple[lamc.Mechanism, Array]:
    """The mechanism in the plane of x and z, angles positive from x to z; and the angles of coupler and rocker, rad."""
    base, foot = np.zeros(2), 1e-3 * np.array([ground, 0.0])
    pin = 1e-3 * crank * np.array([math.cos(drawn), math.sin(drawn)])
    across = foot - pin
    far = float(np.hypot(*across))
    along = ((1e-3 * coupler) ** 2 - (1e-3 * rocker) ** 2 + far**2) / (2.0 * far)
    height = math.sqrt((1e-3 * coupler) ** 2 - along**2)
    unit = across / far
    top = pin + along * unit + height * np.array([-unit[1], unit[0]])

    def at(point: Array) -> tuple[float, float, float]:
        return (float(point[0]), 0.0, float(point[1]))

    def bar(name: str, start: Array, end: Array) -> lamc.Body:
        return lamc.Body(name=name, mass=0.01, com=at(0.5 * (start + end)), inertia=1e-6 * np.eye(3))

    bodies = (
        lamc.Body(name="ground", fixed=True),
        bar("crank", base, pin),
        bar("coupler", pin, top),
        bar("rocker", top, foot),
    )
    joints = tuple(
        lamc.Joint(name=name, parent=parent, child=child, point=at(point), axis=(0.0, -1.0, 0.0))
        for name, parent, child, point in (
            ("a", "ground", "crank", base),
            ("b", "crank", "coupler", pin),
            ("c", "coupler", "rocker", top),
            ("d", "ground", "rocker", foot),
        )
    )
    angles = np.array([math.atan2(*(top - pin)[::-1]), math.atan2(*(top - foot)[::-1])])
    return lamc.Mechanism(name="bars", bodies=bodies, joints=joints), angles


def followed(sizes: tuple[float, ...], angles: Array, turned: float) -> float:
    """How far the rocker has turned, rad, when the crank has, by small steps of the closure of two lengths."""
    ground, crank, coupler, rocker, drawn = sizes

    def gap(found: Array, at: float) -> list[float]:
        return [
            crank * math.cos(at) + coupler * math.cos(found[0]) - ground - rocker * math.cos(found[1]),
            crank * math.sin(at) + coupler * math.sin(found[0]) - rocker * math.sin(found[1]),
        ]

    found = angles
    for at in drawn + np.linspace(0.0, turned, 1 + math.ceil(abs(turned) / 0.01)):
        found = fsolve(gap, found, args=(at,), xtol=1e-13)
    return float(found[1] - angles[1])


@pytest.mark.parametrize(
    "sizes", [DOUBLE_CRANK, ANOTHER, CRANK_ROCKER], ids=["double crank", "another", "crank-rocker"]
)
@pytest.mark.parametrize("turned", [50.0, 118.0, 200.0, 240.0, 350.0, -170.0, -300.0])
def test_a_start_is_where_the_drawn_linkage_moves_to(sizes: tuple[float, ...], turned: float) -> None:
    """Beyond 195 degrees it had been the other way of assembly, or a whole turn away, without a word."""
    mechanism, angles = four_bar(*sizes)
    simulator = lamc.compile(mechanism, lamc.Scene(effects=(), angles={"a": f"{turned} deg"}))
    start = simulator.run(t_end=1e-9, t_eval=[0.0, 1e-9]).angle("d")[0]
    assert start == pytest.approx(
        followed(sizes, angles, math.radians(turned)), abs=1e-9
    )  # of fsolve, some 1e-12
