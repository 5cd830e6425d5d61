"""Hinges whose gap is wider than the plate beside them: nothing of it would be left to be a link.

In: connections and their bodies. Out: a warning for each such hinge. Never: changes or refuses anything, as the masses
and axes are those of the drawing.
"""

from collections.abc import Sequence

import numpy as np
import shapely

from lamc.basics.checks import Array
from lamc.basics.errors import warn
from lamc.design.steps import Connection, SplitBody


def warn_of_wide_gaps(connections: Sequence[Connection], bodies: Sequence[SplitBody]) -> None:
    """Compares half of each gap with how far the two bodies reach from the line."""
    corners = {body.name: _corners(body) for body in bodies}
    lines = [connection.hinge.line for connection in connections]
    starts, ends = shapely.get_coordinates(lines).reshape(-1, 2, 2).transpose(1, 0, 2)
    across = (ends - starts)[:, ::-1] * [-1.0, 1.0] / shapely.length(lines)[:, None]
    for connection, start, normal in zip(connections, starts, across, strict=True):
        hinge = connection.hinge
        for name in (connection.parent, connection.child):
            reach = float(np.abs((corners[name] - start) @ normal).max())
            if reach < hinge.properties.width:
                gap, near = (f"{1e3 * length:.3g} mm" for length in (hinge.properties.gap, reach))
                warn(
                    f"hinge {hinge.name!r} is wider than its plate: half of its gap of {gap} lies to either side of "
                    f"its line, and body {name!r} reaches {near} from it; the gap is the length of bare film from "
                    "board to board",
                    hinge.place if hinge.place.line else None,
                )
                break


def _corners(body: SplitBody) -> Array:
    """Of all layers, shape (k, 2), m."""
    found: Array = shapely.get_coordinates([polygon for layer in body.polygons for polygon in layer])
    return found
