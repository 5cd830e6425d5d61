"""A run as few and short numbers: what a page plays where no model is in it.

In: a `Result`. Out: instants, poses of the moving bodies and curves, each as 16 bits, and by how much they are off.
Instants are kept where a straight line between those around them would err by more than a tolerance; the eye sees no
thousandth of the picture. Never: integrates.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
import numpy.typing as npt

from lamc.records.mechanism import Array, Mechanism
from lamc.records.scene import OutputPoint
from lamc.report.stage import poses_at
from lamc.run.result import Result
from lamc.symbolic.program import Coordinate

MOST_INSTANTS = 6000  # that are looked at
_TURN = 0.1  # rad: joints that turn farther from row to row get instants between, by interpolation of their angles
_LEVELS = 65535  # of 16 bits
FINEST, COARSEST = 1e-3, 5e-2  # of the size, and of the range of a curve


@dataclass(frozen=True, eq=False)
class RecordedMotion:
    """A run at k instants: centres (k, b, 3), m, and quaternions (k, b, 4) of the b moving bodies, curves (k, c)."""

    t: Array
    centres: Array
    turns: Array
    curves: Array
    radii: Array  # (b,), m: of each body about its centre of mass


class Named(Protocol):
    """What a result and a simulator both tell of what they are about."""

    @property
    def joints(self) -> tuple[str, ...]: ...
    @property
    def coordinates(self) -> tuple[Coordinate, ...]: ...


def curve_specs(
    named: Named,
    mechanism: Mechanism,
    outputs: Iterable[str | OutputPoint],
    energies: Iterable[str],
) -> list[dict[str, Any]]:
    """What curves there are: name, unit, group, and where a model in the page has it from."""
    joints, names = named.joints, [c.name for c in named.coordinates]
    specs: list[dict[str, Any]] = [
        {"name": joint.name, "unit": "rad", "group": "angles", "from": ["angle", joints.index(joint.name)]}
        for joint in mechanism.joints
        if joint.name in joints
    ]
    specs += [
        {"name": c.name, "unit": c.unit, "group": "coordinates", "from": ["q", k]}
        for k, c in enumerate(named.coordinates)
        if k >= len(joints)
    ]
    specs += _outputs(mechanism, outputs, names)
    specs += [
        {"name": name, "unit": "J", "group": "energies", "from": ["energy", k]}
        for k, name in enumerate(energies)
    ]
    return [*specs, {"name": "total", "unit": "J", "group": "energies", "from": ["total", 0]}]


def _outputs(
    mechanism: Mechanism, outputs: Iterable[str | OutputPoint], known: Sequence[str]
) -> list[dict[str, Any]]:
    """Points and centres of mass that a scene names; joints and coordinates have their curves already."""
    bodies = {body.name: k for k, body in enumerate(mechanism.bodies)}
    specs = []
    for each in outputs:
        if isinstance(each, OutputPoint):
            place = [bodies[each.body], *each.point]
            specs += [_point(f"{each.name}.{axis}", place, k) for k, axis in enumerate("xyz")]
        elif each not in known:
            body, _, axis = each.rpartition(".")
            centre = mechanism.body(body).com.tolist()
            specs.append(_point(each, [bodies[body], *centre], "xyz".index(axis)))
    return specs


def _point(name: str, place: list[Any], axis: int) -> dict[str, Any]:
    return {"name": name, "unit": "m", "group": "outputs", "from": ["point", axis, *place]}


def moving_bodies(mechanism: Mechanism, moving: Sequence[str]) -> list[int]:
    """Places in the mechanism of a model's bodies, in the model's order: that in which its poses come."""
    places = {body.name: k for k, body in enumerate(mechanism.bodies)}
    return [places[name] for name in moving]


def motion_of(result: Result, specs: Sequence[dict[str, Any]], size: float) -> RecordedMotion:
    """The run at its rows, and between those that lie far apart."""
    times = _instants(result)
    poses = poses_at(result, times)
    bodies = moving_bodies(result.mechanism, result.motion.model.bodies)
    turns = quaternions(poses.rotations[:, bodies])
    rows = np.column_stack([_values(result, spec) for spec in specs])
    keep = np.concatenate([[True], np.diff(result.t) > 0.0]) if len(result.t) else np.zeros(0, dtype=bool)
    curves = np.column_stack([np.interp(times, result.t[keep], values) for values in rows[keep].T])
    radii = np.array([_radius(result.mechanism, k, size) for k in bodies])
    return RecordedMotion(times, poses.centres[:, bodies], turns, curves, radii)


def _instants(result: Result) -> Array:
    """Its rows, and as many between them as keep bodies on arcs."""
    t = np.unique(result.t)
    if len(t) < 2:
        return t
    joints = len(result.joints)
    q = result.q[np.searchsorted(result.t, t), :joints]
    turned = np.abs(np.diff(q, axis=0)).max(axis=1, initial=0.0)
    pieces = np.clip(np.ceil(turned / _TURN), 1, max(1, MOST_INSTANTS // len(t))).astype(int)
    parts = [np.linspace(a, b, n, endpoint=False) for a, b, n in zip(t[:-1], t[1:], pieces, strict=True)]
    times = np.concatenate([*parts, t[-1:]])
    chosen: Array = times[np.unique(np.linspace(0, len(times) - 1, MOST_INSTANTS).astype(int))]
    return chosen


def _values(result: Result, spec: dict[str, Any]) -> Array:
    kind, index, *place = spec["from"]
    if kind == "angle":
        return result.angle(spec["name"])
    if kind == "q":
        return result.q[:, index]
    if kind == "energy":
        return result.energies[spec["name"]]
    if kind == "total":
        return result.energy
    body = result.mechanism.bodies[place[0]]
    centre, rotation = result.pose(body.name)
    path: Array = centre + rotation @ (np.array(place[1:]) - body.com)
    return path[:, index]


def _radius(mechanism: Mechanism, index: int, size: float) -> float:
    body = mechanism.bodies[index]
    points = [j.point for j in mechanism.joints if body.name in (j.parent, j.child)]
    for plate in body.outline:
        x0, y0, x1, y1 = plate.polygon.bounds
        points += [np.array([x, y, plate.z_top]) for x in (x0, x1) for y in (y0, y1)]
    return max((float(np.linalg.norm(p - body.com)) for p in points), default=size / 10)


def quaternions(rotations: Array) -> Array:
    """(w, x, y, z) of rotations (k, b, 3, 3), each on the side of the sphere of the one before, so that they can be
    interpolated."""
    flat = rotations.reshape(-1, 3, 3)
    m = flat.transpose(1, 2, 0)
    # Of the four forms (Shepperd 1978) the one that divides by the largest part.
    squares = np.array(
        [
            1 + m[0, 0] + m[1, 1] + m[2, 2],
            1 + m[0, 0] - m[1, 1] - m[2, 2],
            1 - m[0, 0] + m[1, 1] - m[2, 2],
            1 - m[0, 0] - m[1, 1] + m[2, 2],
        ]
    )
    a, b, c = m[2, 1] - m[1, 2], m[0, 2] - m[2, 0], m[1, 0] - m[0, 1]
    d, e, f = m[0, 1] + m[1, 0], m[0, 2] + m[2, 0], m[1, 2] + m[2, 1]
    forms = np.array(
        [[squares[0], a, b, c], [a, squares[1], d, e], [b, d, squares[2], f], [c, e, f, squares[3]]]
    )
    best = squares.argmax(axis=0)
    found = forms[best, :, np.arange(len(flat))]
    found = (found / np.linalg.norm(found, axis=1, keepdims=True)).reshape(*rotations.shape[:2], 4)
    if len(found) > 1:
        flips = np.where((found[1:] * found[:-1]).sum(axis=2) < 0.0, -1.0, 1.0)
        found[1:] *= np.cumprod(flips, axis=0)[:, :, None]
    return np.asarray(found)


def knots(t: Array, channels: Array) -> npt.NDArray[np.intp]:
    """Places of the instants (indices) from which straight lines give all of `channels` (k, c) to within one."""
    if len(t) < 3:
        return np.arange(len(t))
    kept = np.zeros(len(t), dtype=bool)
    kept[[0, -1]] = True
    open_pieces = [(0, len(t) - 1)]
    while open_pieces:
        first, last = open_pieces.pop()
        if last - first < 2:
            continue
        share = ((t[first + 1 : last] - t[first]) / (t[last] - t[first]))[:, None]
        line = channels[first] + share * (channels[last] - channels[first])
        error = np.abs(channels[first + 1 : last] - line).max(axis=1)
        worst = int(error.argmax())
        if error[worst] > 1.0:
            middle = first + 1 + worst
            kept[middle] = True
            open_pieces += [(first, middle), (middle, last)]
    return np.flatnonzero(kept)


def recording_data(motion: RecordedMotion, tolerance: float, size: float) -> dict[str, Any]:
    """The run for the page: arrays, and the errors that decimation and rounding leave, m and of a curve's range."""
    count = len(motion.t)
    spans = np.ptp(motion.curves, axis=0) if count else np.zeros(0)
    scaled = [
        motion.centres.reshape(count, -1) / (tolerance * size),
        (2.0 * motion.turns * motion.radii[:, None]).reshape(count, -1) / (tolerance * size),
        motion.curves / np.where(spans > 0.0, tolerance * spans, 1.0),
    ]
    chosen = knots(motion.t, np.concatenate(scaled, axis=1))
    centres, centres_back = _short(motion.centres[chosen].reshape(len(chosen), -1), shared=True)
    turns, turns_back = _short(motion.turns[chosen].reshape(len(chosen), -1), shared=True)
    curves, curves_back = _short(motion.curves[chosen], shared=False)
    t = motion.t[chosen]
    back = np.concatenate([centres_back, 2.0 * turns_back * np.repeat(motion.radii, 4), curves_back], axis=1)
    exact = np.concatenate(
        [scaled[0] * tolerance * size, scaled[1] * tolerance * size, motion.curves], axis=1
    )
    errors = np.array(
        [np.abs(np.interp(motion.t, t, b) - e).max() for b, e in zip(back.T, exact.T, strict=True)]
    )
    lengths = errors[: len(errors) - len(spans)]
    shares = errors[len(lengths) :] / np.where(spans > 0.0, spans, np.inf)
    return {
        "t": t,
        "centres": centres,
        "turns": turns,
        "curves": curves,
        "error": {
            "length": float(lengths.max(initial=0.0)),
            "share": float(shares.max(initial=0.0)),
            "rows": count,
        },
    }


def _short(values: Array, *, shared: bool) -> tuple[dict[str, Any], Array]:
    """Columns in 16 bits, as differences along time, which deflate well; and what comes of them again. shared: one
    range for all columns."""
    low, high = (values.min(axis=0), values.max(axis=0)) if len(values) else (values.sum(axis=0),) * 2
    if shared:
        low, high = (
            np.full_like(x, y) for x, y in ((low, low.min(initial=0.0)), (high, high.max(initial=0.0)))
        )
    step = np.where(high > low, (high - low) / _LEVELS, 1.0)
    levels = np.rint((values - low) / step).astype("i4")
    differences = np.diff(levels, axis=0, prepend=0).astype("u2")  # modulo 2^16
    bytes_ = np.ascontiguousarray(differences.T, dtype="<u2").view("u1").reshape(-1, 2)
    planes = np.concatenate([bytes_[:, 0], bytes_[:, 1]])  # low bytes, then high ones: these hardly change
    data = {"columns": values.shape[1], "low": low.astype("f8"), "step": step.astype("f8"), "bytes": planes}
    return data, low + step * levels
