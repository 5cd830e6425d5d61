"""Ground that a plate lies on and that gives way: a spring under every point, as E. Winkler has it (1867).

In: how stiff, and where. Out: a record, checked by itself. Never: meshes, ground that is left behind by a plate that
lifts off: it pulls as well as it pushes.
"""

from dataclasses import dataclass

import numpy as np
import shapely
from numpy.typing import NDArray
from shapely.geometry.base import BaseGeometry

from lamc.basics.checks import Array, checked_number, shown
from lamc.basics.errors import DesignError
from lamc.plates.supports import where_text


@dataclass(frozen=True, eq=False)
class ElasticFoundation:
    """A pressure -stiffness · w under the plate, everywhere or in an area.

    stiffness  N/m³: pressure per deflection
    where      a polygon, m; None: all of the plate. It is looked at 16 points of each cell, so a mesh that follows its
               border (a region of that shape) has it exactly, another one to a quarter of a cell

    Raises DesignError.
    """

    stiffness: float
    where: BaseGeometry | None = None

    def __post_init__(self) -> None:
        value = checked_number(self.stiffness, "the stiffness of an ElasticFoundation", minimum=0.0)
        if value == 0.0:
            raise DesignError("the stiffness of an ElasticFoundation is 0 N/m³; leave it out, or give it one")
        object.__setattr__(self, "stiffness", value)
        if self.where is None:
            return
        if not isinstance(self.where, BaseGeometry):
            raise DesignError(
                f"an ElasticFoundation is at {shown(self.where)}; it must be a shapely polygon, or None for all of the "
                "plate"
            )
        if not self.where.is_valid or not self.where.area > 0.0:
            raise DesignError(
                f"an ElasticFoundation is at a geometry without an area or not valid ({self.where.geom_type}); give a "
                "polygon: along a line or at a point a plate is held by supports"
            )

    @property
    def text(self) -> str:
        """As a message names it."""
        return "the ElasticFoundation" + ("" if self.where is None else f" at {where_text(self.where)}")

    def covers(self, points: Array) -> NDArray[np.bool_]:
        """Which of `points` (k, 2), m, lie on it, (k,)."""
        if self.where is None:
            return np.ones(len(points), dtype=bool)
        shapely.prepare(self.where)
        return np.asarray(shapely.intersects_xy(self.where, *points.T))
