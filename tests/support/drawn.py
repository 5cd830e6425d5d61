"""The drawn mechanisms with loops, simulated once for all tests, and what is read off their drawings.

Positions are those of the drawings (mm, in the plane x, z across parallel hinges), never asked of lamc. A positive
angle about +y turns x towards -z, so directions in that plane lose the joint's angle.
"""

import math
from functools import cache

import numpy as np
import numpy.typing as npt

import lamc
from lamc import examples
from lamc.run.result import Result
from lamc.run.simulator import Simulator

Array = npt.NDArray[np.float64]

MM = 1e-3
END, ROWS = 2.0, 8001  # s
LOW, HIGH, TOP = (
    0.0125,
    4.3375,
    7.6625,
)  # mm, mid-planes: 25/2 um; 25 um + 1 + 2.3 + 1 + 25/2 um; and 3.325 more
NEAR, FAR = 0.2125, 5.6375  # mm, five_bar: 0.2 + 25/2 um; 0.425 + 5 + 0.2125
DIRECTIONS = {  # degrees, of the creases as drawn, by the right hand
    "vertex": {"c1": 0, "c2": 60, "c3": 135, "c4": 255},
    "waterbomb": {
        "east": 0, "north_east": 45, "north_west": 135, "west": 180, "south_west": 225, "south_east": 315,
    },
}  # fmt: skip
# Closure holds to 1e-12 of the size in every row; the shortest link is a twentieth of the size, and where links come
# within some degrees of one line the angle between them is ten times as sensitive.
ANGLE = 1e-9  # rad


@cache
def simulator(name: str) -> Simulator:
    return lamc.compile(lamc.load(examples.path(name)))


@cache
def motion(name: str) -> Result:
    result = simulator(name).run(t_end=END, rtol=1e-9, atol=1e-11, t_eval=np.linspace(0.0, END, ROWS))
    assert result.success, result.message
    return result


def same_angle(a: Array, b: Array) -> float:
    """Largest difference of two angles, rad, modulo whole turns."""
    return float(np.abs(np.remainder(a - b + math.pi, 2 * math.pi) - math.pi).max())
