"""How sensors tell what is to be seen: cameras, gains, biases.

In: signals of the model, numbers of the sensors by name. Out: what the sensors tell, and its derivatives by signals and
by numbers. measured = gain * seen + bias, and a camera sees s R A p + c of a point p (see `Camera`).
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from lamc.basics.checks import is_list
from lamc.basics.errors import RequestError
from lamc.records.recording import Camera, Recording
from lamc.run.request import Array

_FRAME = ("x", "y", "z")
_STEP = 1e-4  # rad: four points miss 1e-17 of a rotation


@dataclass(frozen=True)
class Told:
    """Where a column comes from. base: its signal, or the first of the three of its point; axis: of the camera's frame;
    None: no camera."""

    base: int
    axis: int | None = None


@dataclass(frozen=True, eq=False)
class Sight:
    """The sensors of a recording.

    columns  names, in the order of what is told
    signals  names of what they see, in the order of the signals
    told     for each column
    numbers  of the sensors, as given, by name: numbers and ranges
    """

    recording: Recording
    name: str
    columns: tuple[str, ...]
    signals: tuple[str, ...]
    told: tuple[Told, ...]
    numbers: Mapping[str, object]

    def tells(self, seen: Array, numbers: Mapping[str, float]) -> tuple[Array, Array, dict[str, Array]]:
        """Columns (m, k), their derivatives by signals (m, k, K), and by numbers, (m, k) each, of signals (m, K)."""
        m, count = seen.shape
        found = np.zeros((m, len(self.columns)))
        by_signal = np.zeros((m, len(self.columns), count))
        by_number: dict[str, Array] = {}
        camera = self._camera(numbers)
        for k, (column, told) in enumerate(zip(self.columns, self.told, strict=True)):
            slopes: dict[str, Array] = {}
            if told.axis is None or camera is None:
                value = seen[:, told.base]
                by_signal[:, k, told.base] = 1.0
            else:
                value, by_point, slopes = camera.tells(seen[:, told.base : told.base + 3], told.axis)
                by_signal[:, k, told.base : told.base + 3] = by_point
            gain, bias = (
                numbers.get(f"{self.name}.{column}.{what}", usual)
                for what, usual in (("gain", 1.0), ("bias", 0.0))
            )
            found[:, k] = gain * value + bias
            by_signal[:, k] *= gain
            slopes = {name: gain * slope for name, slope in slopes.items()}
            slopes[f"{self.name}.{column}.gain"], slopes[f"{self.name}.{column}.bias"] = value, np.ones(m)
            for name, slope in slopes.items():
                by_number.setdefault(name, np.zeros((m, len(self.columns))))[:, k] = slope
        return found, by_signal, by_number

    def _camera(self, numbers: Mapping[str, float]) -> "_Seen | None":
        camera = self.recording.camera
        if camera is None or all(told.axis is None for told in self.told):
            return None
        return _Seen(camera.name, camera.basis, *_numbers_of(camera, numbers))


def _numbers_of(camera: Camera, numbers: Mapping[str, float]) -> tuple[float, Array, Array]:
    """Scale, rotation vector (3,) and origin of a camera."""
    turn = [numbers.get(f"{camera.name}.rotation_{axis}", 0.0) for axis in _FRAME]
    origin = [numbers[f"{camera.name}.origin_{a}"] for a in _FRAME[: len(camera.axes)]]
    return numbers[f"{camera.name}.scale"], np.array(turn), np.array(origin)


def frame_of(camera: Camera, numbers: Mapping[str, float]) -> tuple[Array, float, Array]:
    """R A, (3, 3), of a camera with its numbers, its scale and its origin."""
    scale, turn, origin = _numbers_of(camera, numbers)
    return rotation_of(turn) @ camera.basis, scale, origin


@dataclass(frozen=True, eq=False)
class _Seen:
    """A camera with its numbers."""

    name: str
    basis: Array
    scale: float
    turn: Array
    origin: Array

    def tells(self, point: Array, axis: int) -> tuple[Array, Array, dict[str, Array]]:
        """One coordinate (m,) of points (m, 3), its derivatives by the point (3,) and by numbers, (m,) each."""
        row = (rotation_of(self.turn) @ self.basis)[axis]
        slopes = {
            f"{self.name}.scale": point @ row,
            f"{self.name}.origin_{_FRAME[axis]}": np.ones(len(point)),
        }
        for j, each in enumerate(_FRAME):
            moved = [
                rotation_of(self.turn + h * _STEP * np.eye(3)[j])[axis] @ self.basis
                for h in (-2.0, -1.0, 1.0, 2.0)
            ]
            slope = (moved[0] - 8.0 * moved[1] + 8.0 * moved[2] - moved[3]) / (12.0 * _STEP)
            slopes[f"{self.name}.rotation_{each}"] = self.scale * (point @ slope)
        return self.scale * (point @ row) + self.origin[axis], self.scale * row, slopes


def rotation_of(turn: Array) -> Array:
    """The rotation (3, 3) of a rotation vector (3,), rad (Rodrigues)."""
    angle = float(np.linalg.norm(turn))
    x, y, z = turn
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    first = np.sinc(angle / np.pi)
    second = 0.5 * np.sinc(0.5 * angle / np.pi) ** 2
    return np.asarray(np.eye(3) + first * cross + second * (cross @ cross))


def sight_of(recording: Recording, name: str) -> Sight:
    """The sensors of a recording, by its columns. Raises RequestError for columns that a camera does not have, and
    gains of none."""
    camera, markers = recording.camera, recording.markers
    signals: list[str] = []
    told: list[Told] = []
    for column in recording.values:
        owner, _, axis = column.rpartition(".")
        if camera is not None and owner in markers:
            frame = _FRAME[: len(camera.axes)]
            if axis not in frame:
                raise RequestError(
                    f"{name} has {column!r}, and its camera tells {' and '.join(frame)} only; give it other axes, "
                    "or leave the column out"
                )
            if f"{owner}.x" not in signals:
                signals += [f"{owner}.{each}" for each in _FRAME]
            told.append(Told(signals.index(f"{owner}.x"), frame.index(axis)))
        else:
            signals.append(column)
            told.append(Told(len(signals) - 1))
    _refuse_pixels(recording, name)
    for what in ("gain", "bias"):
        for column in getattr(recording, what):
            if column not in recording.values:
                raise RequestError(f"{name} gives {column!r} a {what}, and has no such column")
    return Sight(
        recording, name, tuple(recording.values), tuple(signals), tuple(told), _numbers(recording, name, told)
    )


def _numbers(recording: Recording, name: str, told: list[Told]) -> dict[str, object]:
    """Numbers of the sensors by name, as given."""
    found: dict[str, object] = {}
    for column, gain in recording.gain.items():
        found[f"{name}.{column}.gain"] = gain
    for column, bias in recording.bias.items():
        found[f"{name}.{column}.bias"] = bias
    camera = recording.camera
    if camera is None or all(each.axis is None for each in told):
        return found
    found |= _camera_numbers(camera)
    return found


def _camera_numbers(camera: Camera) -> dict[str, object]:
    rotation = camera.rotation
    turns = tuple(rotation) if is_list(rotation) and len(rotation) == 3 else None
    if turns is None and len(camera.axes) == 3:
        turns = (0.0, 0.0, rotation)
    found: dict[str, object] = {f"{camera.name}.scale": camera.scale}
    if turns is None:
        found[f"{camera.name}.rotation_z"] = rotation
    else:
        found |= {f"{camera.name}.rotation_{a}": turn for a, turn in zip(_FRAME, turns, strict=True)}
    assert isinstance(camera.origin, tuple)
    return found | {f"{camera.name}.origin_{a}": c for a, c in zip(_FRAME, camera.origin, strict=False)}


def _refuse_pixels(recording: Recording, name: str) -> None:
    """Raises RequestError for coordinates of points that no laminate device has in metres."""
    if recording.camera is not None:
        return
    points = [c for c in recording.values if c.rpartition(".")[0] in recording.markers]
    values = np.concatenate([recording.values[c] for c in points]) if points else np.zeros(0)
    values = np.abs(values[np.isfinite(values)])
    if len(values) and float(np.median(values)) > _FAR_OFF:
        raise RequestError(
            f"coordinates of markers of {name} are {np.median(values):g} m and the like (half of them above "
            f"{_FAR_OFF:g} m); "
            "is this mm or pixels? give metres (of a file: --unit mm, or [mm] in its heading), or a camera "
            "whose scale is found (--frame x,-z)"
        )


_FAR_OFF = 10.0  # m


def sees(camera: Camera, basis_points: Array, coordinates: Array) -> tuple[float, Array, Array]:
    """Scale, rotation vector (3,) and origin (k,) with which a camera sees points (m, 3), world, m, nearest to
    coordinates (m, k): where a fit begins (Umeyama 1991, IEEE PAMI 13, 376-380). NaN rows are left out."""
    good = np.isfinite(coordinates).all(axis=1) & np.isfinite(basis_points).all(axis=1)
    k = len(camera.axes)
    p = (basis_points[good] @ camera.basis.T)[:, :k]
    c = coordinates[good]
    p0, c0 = p.mean(axis=0), c.mean(axis=0)
    u, d, vt = np.linalg.svd((c - c0).T @ (p - p0))
    sign = np.ones(k)
    sign[-1] = np.sign(np.linalg.det(u @ vt)) or 1.0
    turn = u @ np.diag(sign) @ vt
    spread = float(((p - p0) ** 2).sum())
    scale = float((d * sign).sum()) / spread if spread > 0.0 else 1.0
    full = np.eye(3)
    full[:k, :k] = turn
    return scale, _vector_of(full), np.asarray(c0 - scale * turn @ p0)


def _vector_of(rotation: Array) -> Array:
    """The rotation vector (3,) of a rotation (3, 3)."""
    from scipy.spatial.transform import Rotation

    return np.asarray(Rotation.from_matrix(rotation).as_rotvec())
