"""A pouch across a hinge that is blown up: a torque by its pressure, from its geometry or from a table."""

import math
from dataclasses import dataclass
from typing import Annotated, ClassVar

import numpy as np
from pydantic import Field

from lamc.basics.errors import DesignError, about
from lamc.basics.fields import Flag, Name
from lamc.basics.quantity_fields import Unit
from lamc.effects.drives import Drive, checked_drive
from lamc.effects.registered import RegisteredEffect
from lamc.effects.torque_laws import checked_rows
from lamc.mechanics.loads import Loads
from lamc.symbolic.expression import stage
from lamc.symbolic.piecewise import spline
from lamc.symbolic.scalars import Scalar, Value, cos

_GEOMETRY, _TABLE = ("length", "width"), ("angles", "pressures", "torques")
MOST_PRESSURES = 20  # each is a guard, which every step evaluates

# cos a sin(x/2) / (4 a) with sin a / a = cos(x/2), which has no closed form: Chebyshev series in 2 x²/π² - 1, |x| <= π,
# within 1e-14 (at 40 digits; tests/physics/test_pouch.py solves for a)
_FILM = (
    -0.008362001491601174,
    -0.10891420802057412,
    0.04042568942684285,
    -0.0030744025386529256,
    0.0003066054128195103,
    2.8405992619650717e-05,
    8.984042442987033e-06,
    2.458838278909555e-06,
    7.027324444142376e-07,
    2.0570481022505618e-07,
    6.140714897513956e-08,
    1.8626041734025746e-08,
    5.724744229703815e-09,
    1.7791328757630945e-09,
    5.581615684144556e-10,
    1.7653872806166157e-10,
    5.623255533519631e-11,
    1.802297408051942e-11,
    5.808230253833733e-12,
    1.88095653516068e-12,
    6.11801601297337e-13,
    1.997796798278799e-13,
    6.546954523110425e-14,
    2.1524589407020688e-14,
    7.097677285727591e-15,
    2.346803935161583e-15,
)


@dataclass(frozen=True)
class Pouch(RegisteredEffect):
    """Torque on a joint's child about its axis: pressure times the rate of the pouch's volume by the angle, p dV/dφ.

    By its geometry: a flat pouch lies across the hinge, its one film bonded to both links as far as length/2 from the
    hinge line, the other film free. Films have no thickness and do not stretch; the free one becomes an arc of a circle
    from link to link (Niiyama et al., Soft Robotics 2, 2015, 59-70). With the hinge bent by φ towards the pouch, so
    that the ends of that arc come together, and sin α / α = cos(φ/2), its volume is V = length² width
    (sin φ / 8 + (α - sin α cos α) / (4 α²)), and dV/dφ = length² width (cos φ / 8 + cos α sin(φ/2) / (4 α)): 0.269
    length² width where it is flat, and less the more it bends. Bent the other way the hinge stands into the pouch: the
    first term of V is negative, the second that of |φ|. A flat one counts as bent towards the pouch. Beyond half a turn
    the torque is that at half a turn.

    By a table: torques, measured at angles of the joint and pressures, positive where they open the fold: between
    angles natural cubic splines, straight beyond them; between pressures, and beyond the last, straight lines, from no
    torque at no pressure.

    The pressure is a number, a parameter of the simulator, or an expression in t (s) and inputs of the scene; below
    zero the pouch is empty and there is no torque. What holds the pressure supplies p dV. Several may act in one scene.
    """

    joint: Annotated[Name, Field(description="the hinge that it bends")]
    pressure: Annotated[float | str, Unit("Pa", "above that around it", ge=0.0)]
    length: Annotated[
        float | None, Unit("m", "of the flat pouch across the hinge, half on either side", gt=0.0)
    ] = None
    width: Annotated[float | None, Unit("m", "of the pouch along the hinge", gt=0.0)] = None
    flat_angle: Annotated[float, Unit("rad", "of the joint where the pouch lies flat")] = 0.0
    reverse: Annotated[
        Flag, Field(description="true: it lies on the other side, and bends the joint to negative angles")
    ] = False
    angles: Annotated[
        tuple[float, ...] | None, Unit("rad", "of the joint, ascending: columns of torques")
    ] = None
    pressures: Annotated[
        tuple[float, ...] | None, Unit("Pa", "ascending, above 0: rows of torques", gt=0.0)
    ] = None
    torques: Annotated[
        tuple[tuple[float, ...], ...] | None, Unit("N*m", "a row for each pressure, with one for each angle")
    ] = None

    name: ClassVar[str] = "pouch"
    summary: ClassVar[str] = "Pouches on hinges"
    example: ClassVar[str] = 'pouch: {joint: knee, pressure: "20e3*min(t, 1)", length: 12 mm, width: 20 mm}'
    source: ClassVar[str] = "T = p dV/dangle, Niiyama et al. 2015"
    repeatable: ClassVar[bool] = True
    conservative: ClassVar[bool] = False
    absent: ClassVar[str] = "no pouch is called for"

    def __post_init__(self) -> None:
        super().__post_init__()
        for drive in self.drives():
            checked_drive(drive)
        given = tuple(name for name in (*_GEOMETRY, *_TABLE) if getattr(self, name) is not None)
        if given not in (_GEOMETRY, _TABLE):
            with about((given[-1],) if given else ()):
                raise DesignError(
                    f"the pouch on joint {self.joint!r} is given by {', '.join(given) or 'nothing'}; give "
                    f"{' and '.join(_GEOMETRY)}, or {', '.join(_TABLE[:2])} and {_TABLE[2]}"
                )
        if given == _TABLE:
            self._check_table()

    def _check_table(self) -> None:
        """Raises DesignError for tables that are none."""
        assert self.angles is not None
        assert self.pressures is not None
        assert self.torques is not None
        what = f"the pouch on joint {self.joint!r}"
        rows, columns = len(self.pressures), len(self.angles)
        with about(("torques",)):
            if len(self.torques) != rows or any(len(row) != columns for row in self.torques):
                raise DesignError(
                    f"{what} has {rows} pressures and {columns} angles; torques must have as many rows and columns"
                )
        with about(("pressures",)):
            if not 1 <= rows <= MOST_PRESSURES or (np.diff(self.pressures) <= 0.0).any():
                raise DesignError(
                    f"{what} has pressures {self.pressures}; give 1 to {MOST_PRESSURES}, ascending: sort the rows"
                )
        with about(("angles",)):
            for row in self.torques:
                checked_rows(list(zip(self.angles, row, strict=True)), what)

    def drives(self) -> tuple[Drive, ...]:
        """The pressure, if it is an expression."""
        what = f"the pressure of the pouch on joint {self.joint!r}"
        return (Drive(what, self.pressure, field=("pressure",)),) if isinstance(self.pressure, str) else ()

    def contribute(self, loads: Loads) -> None:
        hinge = loads.hinge(self.joint)
        label = self._label(loads.parameter_names)
        said = self._said_pressure(loads, label)
        pressure: Scalar = said
        if isinstance(self.pressure, str):
            pressure = loads.switch(f"{label} is under pressure", said) * said
        if self.torques is not None:
            assert isinstance(hinge.angle, Value)
            loads.hinge_torque(self.joint, self._measured(loads, label, said, pressure, hinge.angle))
            return
        flat = loads.parameter(
            f"{label}.flat_angle", self.flat_angle, "rad", "of the joint, where the pouch is flat"
        )
        length = loads.parameter(f"{label}.length", self.length or 0.0, "m", "of the pouch across the hinge")
        width = loads.parameter(f"{label}.width", self.width or 0.0, "m", "of the pouch along the hinge")
        side = -1.0 if self.reverse else 1.0
        bent = side * (hinge.angle - flat)
        slope = self._slope(loads, label, bent)
        loads.hinge_torque(self.joint, side * (pressure * (length * length * width * slope)))

    def _slope(self, loads: Loads, label: str, bent: Scalar) -> Scalar:
        """dV/dφ over length² width, at the angle φ by which the hinge is bent, rad."""
        away = loads.switch(f"{label} is bent away", -bent)
        closed = loads.switch(f"{label} is bent by half a turn", bent * bent - math.pi**2)
        square = (1 - closed) * (bent * bent) + closed * math.pi**2
        t = square * (2.0 / math.pi**2) - 1.0
        later: Scalar = 0.0
        film: Scalar = 0.0
        for coefficient in _FILM[:0:-1]:  # by Clenshaw's recurrence
            later, film = film, 2.0 * (t * film) - later + coefficient
        film = t * film - later + _FILM[0]
        links = (1 - closed) * cos(bent) - closed
        return 0.125 * links + (1 - 2 * away) * film

    def _measured(self, loads: Loads, label: str, said: Scalar, pressure: Scalar, angle: Value) -> Scalar:
        """Torque by the table: its slopes by pressure change at each pressure but the last. said: the pressure, below
        zero too, for guards, which must not depend on modes."""
        assert self.angles is not None
        assert self.pressures is not None
        assert self.torques is not None
        rows = np.vstack([np.zeros(len(self.angles)), np.array(self.torques)])
        knots = (0.0, *self.pressures)
        slopes = np.diff(rows, axis=0) / np.diff(knots)[:, None]
        changes = np.vstack([slopes[:1], np.diff(slopes, axis=0)])
        torque: Scalar = 0
        for knot, change in zip(knots, changes.tolist(), strict=False):
            beyond: Scalar = pressure
            if knot:
                beyond = loads.switch(f"{label} beyond {knot:g} Pa", said - knot) * (said - knot)
            torque = torque + beyond * angle.store.table(spline(self.angles, change), angle)
        return torque

    def _said_pressure(self, loads: Loads, label: str) -> Scalar:
        """Pressure, Pa, below zero too."""
        if isinstance(self.pressure, str):
            return stage(self.pressure, {"t": loads.time, **loads.inputs})
        return loads.parameter(f"{label}.pressure", self.pressure, "Pa", "in the pouch")

    def _label(self, taken: tuple[str, ...]) -> str:
        """What the pouch's parameters begin with; a second one on the same joint is number 2."""
        label = f"{self.joint}.pouch"
        used = {name.rsplit(".", 1)[0] for name in taken}
        number = 1
        while (f"{label}.{number}" if number > 1 else label) in used:
            number += 1
        return f"{label}.{number}" if number > 1 else label
