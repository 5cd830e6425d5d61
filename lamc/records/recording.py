"""What was measured on a device: recordings, the points that were tracked, the camera that saw them.

In: plain values and arrays. Out: checked records. A number that is not known is a range, (low, high) or `Free`; whoever
fits chooses it within. Nothing here knows a mechanism, or reads a file.
"""

import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt

from lamc.basics.checks import checked_array, checked_kind, checked_name, checked_number, is_list, shown
from lamc.basics.errors import RequestError
from lamc.basics.readonly import ReadOnlyDict
from lamc.basics.units import LENGTH, to_si
from lamc.records.series import Series

Array = npt.NDArray[np.float64]

_POINT = re.compile(r"\s*(.+?)\s*@\s*\(([^()]*)\)\s*\Z")
_AXES = {
    "x": (1.0, 0.0, 0.0),
    "y": (0.0, 1.0, 0.0),
    "z": (0.0, 0.0, 1.0),
    "-x": (-1.0, 0.0, 0.0),
    "-y": (0.0, -1.0, 0.0),
    "-z": (0.0, 0.0, -1.0),
}


@dataclass(frozen=True)
class Free:
    """A number that is to be found.

    low, high  it lies within; infinite: no bound
    start      where to look first; None: where the design or the data have it, else in the middle
    prior      (mean, standard deviation) of what is known beforehand; None: nothing is
    log        whether its logarithm is sought; None: if it is positive and its range spans a decade

    Raises RequestError for a range that is empty and a start outside.
    """

    low: float = -math.inf
    high: float = math.inf
    start: float | None = None
    prior: tuple[float, float] | None = None
    log: bool | None = None

    def __post_init__(self) -> None:
        low, high = float(self.low), float(self.high)
        if math.isnan(low) or math.isnan(high) or not low < high:
            what = "is empty" if low == high else "runs backwards"
            raise RequestError(
                f"the range from {low:g} to {high:g} {what}; the first must be below the second"
            )
        if self.start is not None and not low <= float(self.start) <= high:
            raise RequestError(
                f"the start {float(self.start):g} lies outside of its bounds {low:g} … {high:g}; widen them, or move it"
            )
        if self.prior is not None:
            mean, deviation = (float(each) for each in self.prior)
            if not (math.isfinite(mean) and 0.0 < deviation < math.inf):
                raise RequestError(
                    f"the prior is {shown(self.prior)}; it must be (mean, standard deviation), the latter above zero"
                )
        if self.log and not low > 0.0:
            raise RequestError(f"a logarithm is sought from {low:g} on; the least must be above zero")


@dataclass(frozen=True)
class Marker:
    """A point of a body that was tracked. body: it moves with; point: (3,), m, where it is as drawn, world axes."""

    body: str
    point: tuple[float, float, float]

    def __post_init__(self) -> None:
        checked_name(self.body, "the body of a marker")
        x, y, z = (float(v) for v in checked_array(self.point, (3,), "the point of a marker", LENGTH))
        object.__setattr__(self, "point", (x, y, z))

    @staticmethod
    def of(given: object, name: str) -> "Marker":
        """A marker of one, or of text such as "link_2@(30mm, 0, 0)". Raises RequestError."""
        if isinstance(given, Marker):
            return given
        match = _POINT.match(given) if isinstance(given, str) and len(given) < 1000 else None
        parts = [each.strip() for each in match[2].split(",")] if match is not None else []
        if match is None or len(parts) != 3:
            raise RequestError(
                f"marker {name!r} is {shown(given)}; write BODY@(X, Y, Z), such as 'link_2@(30mm, 0, 0)': where it is "
                "as drawn, world axes"
            )
        x, y, z = (to_si(each, LENGTH) for each in parts)
        return Marker(match[1], (x, y, z))


@dataclass(frozen=True)
class Camera:
    """The frame that coordinates of markers are told in: s R A p + c, of a point p, (3,), m, world.

    axes      A: world axes along the frame's own, such as ("x", "z") of a picture, or ("x", "-z") where the second
              coordinate counts downwards; three of a frame in space
    scale     s, 1/m in the unit of the coordinates: pixels a metre; 1: they are metres
    rotation  R: one angle, rad, in the plane of the picture, from the first axis to the second; of a frame in space,
              or of a picture that is seen at a slant, a rotation vector (3,), rad
    origin    c: coordinates of the world's origin, two or three
    name      that its unknowns begin with; recordings with one camera share them

    Numbers may be ranges. Parallel projection: a lens far away. `Camera.unknown` has all free.
    """

    axes: tuple[str, ...] = ("x", "z")
    scale: object = 1.0
    rotation: object = 0.0
    origin: object = ()
    name: str = "camera"

    def __post_init__(self) -> None:
        if not is_list(self.axes) or len(self.axes) not in (2, 3) or any(a not in _AXES for a in self.axes):
            raise RequestError(
                f"the axes of a camera are {shown(self.axes)}; give two or three of {', '.join(_AXES)}, such "
                "as ('x', 'z')"
            )
        object.__setattr__(self, "axes", tuple(self.axes))
        if len({a[-1] for a in self.axes}) != len(self.axes):
            raise RequestError(f"the axes of a camera are {self.axes}; each must be another")
        if len(self.axes) == 3 and np.linalg.det(np.array([_AXES[a] for a in self.axes])) < 0.0:
            raise RequestError(f"the axes {self.axes} are left-handed; turn one of them round, such as '-z'")
        origin = tuple(self.origin) if is_list(self.origin) else ()
        if origin and len(origin) != len(self.axes):
            raise RequestError(
                f"the origin of a camera has {len(origin)} coordinates, of {len(self.axes)} axes"
            )
        object.__setattr__(self, "origin", origin or (0.0,) * len(self.axes))
        checked_name(self.name, "a camera")

    @staticmethod
    def unknown(axes: Sequence[str] = ("x", "z"), name: str = "camera") -> "Camera":
        """Scale, rotation and origin are all free; where they begin follows from the data."""
        count = len(axes)
        rotation: object = Free() if count == 2 else (Free(),) * 3
        return Camera(tuple(axes), Free(0.0), rotation, (Free(),) * count, name)

    @property
    def basis(self) -> Array:
        """A, (3, 3), right-handed: the rows are the axes; of a picture, the last looks out of it."""
        rows = [_AXES[a] for a in self.axes]
        if len(rows) == 2:
            rows.append(tuple(np.cross(rows[0], rows[1])))
        return np.array(rows)


@dataclass(frozen=True, eq=False)
class Recording:
    """What was measured in one go.

    t       (m,), s, ascending; the run that it is compared with has its start at t = 0 of this clock
    values  (m,) each by name: hinges ("h1", rad), rates ("h1.rate", rad/s), coordinates ("base.z"), points by axis
            ("tip.x", m), markers by axis ("marker1.x"; with a camera in its frame: .x, .y, and .z in space);
            NaN: nothing was seen
    name    that its unknowns begin with; "": run1, run2, … in the order of recordings
    start   "known": the run begins as the scene says, at t = 0; "estimated": with any angles and rates, at the first
            row (without loops: of all coordinates; with: those of the independent hinges that `angles` names as ranges)
    angles, rates  at the start, by hinge, rad and rad/s, in place of the scene's: numbers, or ranges
    parameters  of the model in this recording, such as a command: numbers by name
    series  what inputs follow in this recording, by name, as of `Simulator.run`: its command
    markers by name: Marker, or text such as "link_2@(30mm, 0, 0)"
    camera  whose frame the markers are told in; None: the world's, m
    delay   s, by which times are late: a row shows the device as it was `delay` before; a number, or a range
    gain, bias  by name of values: measured = gain * true + bias; numbers, or ranges
    sigma   standard deviation of the noise: one number, or by name of values; None: told by the fit

    Raises RequestError for times that do not ascend and arrays that do not fit.
    """

    t: Array
    values: Mapping[str, Array]
    name: str = ""
    start: str = "known"
    angles: Mapping[str, object] = field(default_factory=dict)
    rates: Mapping[str, object] = field(default_factory=dict)
    parameters: Mapping[str, float] = field(default_factory=dict)
    series: Mapping[str, Series] = field(default_factory=dict)
    markers: Mapping[str, object] = field(default_factory=dict)
    camera: Camera | None = None
    delay: object = 0.0
    gain: Mapping[str, object] = field(default_factory=dict)
    bias: Mapping[str, object] = field(default_factory=dict)
    sigma: object = None

    def __post_init__(self) -> None:
        what = f"recording {self.name!r}" if self.name else "a recording"
        t = _column(self.t, f"the times of {what}")
        if len(t) < 2:
            raise RequestError(f"{what} has {len(t)} rows; two or more are needed")
        check_times(t, what)
        if not isinstance(self.values, Mapping) or not self.values:
            raise RequestError(f"{what} holds no values; give them by name, {{'h1': angles}}")
        values = {}
        for name, given in self.values.items():
            column = _column(given, f"{name!r} of {what}")
            if len(column) != len(t):
                raise RequestError(
                    f"{name!r} of {what} has {len(column)} values, and there are {len(t)} times"
                )
            if np.isinf(column).any():
                raise RequestError(
                    f"{name!r} of {what} is infinite at {t[np.isinf(column)][0]:g} s; gaps are NaN"
                )
            values[str(name)] = column
        if self.start not in ("known", "estimated"):
            raise RequestError(f"the start of {what} is {shown(self.start)}; it is 'known' or 'estimated'")
        if self.camera is not None:
            checked_kind(self.camera, Camera, f"the camera of {what}", "make one with lamc.Camera(…)")
        for each in ("angles", "rates", "parameters", "series", "markers", "gain", "bias"):
            if not isinstance(getattr(self, each), Mapping):
                raise RequestError(
                    f"{each} of {what} is {shown(getattr(self, each))}; it must map names to values"
                )
            object.__setattr__(self, each, ReadOnlyDict(getattr(self, each)))
        object.__setattr__(
            self, "markers", ReadOnlyDict({n: Marker.of(m, n) for n, m in self.markers.items()})
        )
        object.__setattr__(self, "t", t)
        object.__setattr__(self, "values", ReadOnlyDict(values))

    def __repr__(self) -> str:
        return f"<Recording {self.name or '?'}: {len(self.t)} rows of {', '.join(self.values)}>"

    def sigma_of(self, name: str) -> float | None:
        """Standard deviation of the noise of a column, in its unit; None where it is not said."""
        given = self.sigma.get(name) if isinstance(self.sigma, Mapping) else self.sigma
        if given is None:
            return None
        number = checked_number(given, f"sigma of {name!r}")
        if number <= 0.0:
            raise RequestError(f"sigma of {name!r} is {number:g}; noise has a standard deviation above zero")
        return number


def check_times(t: Array, what: str) -> None:
    """Raises RequestError unless times (m,) are finite and ascend."""
    if not np.isfinite(t).all():
        raise RequestError(
            f"the time of {what} in row {int(np.flatnonzero(~np.isfinite(t))[0]) + 1} is no finite number"
        )
    falling = np.flatnonzero(np.diff(t) <= 0.0)
    if falling.size:
        k = int(falling[0])
        word = "stands still" if t[k + 1] == t[k] else "runs backwards"
        raise RequestError(
            f"time {word} in {what}: from {t[k]:g} to {t[k + 1]:g} s at row {k + 2}; times must ascend: sort the rows, "
            "and drop repeated ones"
        )


def _column(given: object, what: str) -> Array:
    """A column as floats, read-only. Raises RequestError."""
    try:
        column = np.array(given, dtype=np.float64)
    except (TypeError, ValueError, OverflowError) as error:
        raise RequestError(f"{what} are {shown(given)}; they must be numbers") from error
    if column.ndim != 1:
        raise RequestError(f"{what} have shape {column.shape}; they must be one column")
    column.flags.writeable = False
    return column
