"""A mechanism in motion before a camera: poses, the choice of view, and the drawing of one instant.

In: a mechanism and its poses, or a `Result` and times. Out: pixels. It writes no files; numbers between two rows of the
result are interpolated for the eye, not for measurement.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import shapely

from lamc.records.effect import PlaneMark
from lamc.records.mechanism import Array, Mechanism
from lamc.report.planes import Sheet
from lamc.report.raster import Camera, Canvas, Pixels
from lamc.report.solid import Lines, Solid, solid_of
from lamc.report.style import body_colours
from lamc.run.model import Motion
from lamc.run.result import Result

_LIGHT = np.array([-0.35, 0.55, 0.76])  # towards the light: right, up, towards the viewer
_EDGE = (40, 40, 40)
HINGE = (213, 94, 0)
# The viewer stands on the side of negative y, so that x runs to the right, and above the ground.
_AZIMUTHS = (-60.0, -45.0, -30.0, -15.0, 15.0, 30.0, 45.0, 60.0)
_ELEVATIONS = (15.0, 25.0, 35.0)
_SAMPLES = 8  # instants that the choice of view looks at


@dataclass(frozen=True, eq=False)
class Poses:
    """Poses of all bodies, in the mechanism's order, at k instants: (k, bodies, 3), m, and (k, bodies, 3, 3)."""

    t: Array
    centres: Array
    rotations: Array

    def place(self, instant: int, points: Array, bodies: Array, drawn: Array) -> Array:
        """Where points (n, 3) or (n, k, 3), m, given as drawn, of bodies (n,), are at an instant.

        drawn  centres of mass as drawn, (bodies, 3), m
        """
        turns, centres = self.rotations[instant][bodies], self.centres[instant][bodies]
        per_item = points.shape[1] if points.ndim == 3 else 1
        flat = points.reshape(len(points), per_item, 3) - drawn[bodies][:, None]
        placed: Array = np.einsum("nij,nkj->nki", turns, flat) + centres[:, None]
        return placed.reshape(points.shape)


def poses_at(result: Result, times: Array) -> Poses:
    """Poses at the given times, s, by linear interpolation of the coordinates."""
    rows = np.zeros((len(times), result.motion.model.state_size))
    for k, values in enumerate(result.q.T):
        rows[:, k] = np.interp(times, result.t, values)
    return poses_of(result.mechanism, result.motion, times, rows)


def poses_of(mechanism: Mechanism, motion: Motion, times: Array, rows: Array) -> Poses:
    """Poses of states (k, n) at times (k,), s."""
    bodies, moving = mechanism.bodies, motion.model.bodies
    found = motion.poses(times, np.ascontiguousarray(rows))
    centres = np.tile(np.array([b.com for b in bodies]), (len(times), 1, 1))
    rotations = np.tile(np.eye(3), (len(times), len(bodies), 1, 1))
    for index, body in enumerate(bodies):
        if body.name in moving:
            pose = found[:, moving.index(body.name)]
            centres[:, index], rotations[:, index] = pose[:, :3], pose[:, 3:].reshape(-1, 3, 3)
    return Poses(times, centres, rotations)


def as_drawn(mechanism: Mechanism) -> Poses:
    """The one instant at which all angles are zero."""
    bodies = mechanism.bodies
    centres = np.array([[b.com for b in bodies]])
    return Poses(np.zeros(1), centres, np.tile(np.eye(3), (1, len(bodies), 1, 1)))


def stage_of(
    result: Result, times: Array, longest_side: int, camera: tuple[float, float] | None = None
) -> "Stage":
    """A run at the given times, s."""
    return Stage(result.mechanism, poses_at(result, times), longest_side, result.marks, camera=camera)


class Stage:
    """A mechanism's shape, its poses, and one camera for all of them. `draw` gives the picture of an instant.

    camera: azimuth and elevation, degrees; None: where the motion spreads widest
    beside: (k, 3), m, world: what else the picture must hold"""

    def __init__(
        self,
        mechanism: Mechanism,
        poses: Poses,
        longest_side: int,
        marks: Sequence[PlaneMark] = (),
        *,
        oversampling: int = 2,
        camera: tuple[float, float] | None = None,
        beside: Array | None = None,
    ) -> None:
        self.poses = poses
        self._beside = np.zeros((0, 3)) if beside is None else beside
        self.solid: Solid = solid_of(mechanism)
        self._drawn = np.array([b.com for b in mechanism.bodies])
        self._oversampling = oversampling
        spans = np.linalg.norm(np.diff(self.solid.hinges.segments, axis=1), axis=2)
        # m: of a sheet of square facets, their sides
        area = sum(
            max((slab.polygon.area for slab in body.outline), default=0.0) for body in mechanism.bodies
        )
        apart = 2.0 * area / float(spans.sum()) if area and spans.sum() else np.inf
        self._hinge_length = min(float(np.median(spans)), apart) if spans.size else 0.0
        self._gather()
        self._colours = _rgb(mechanism)
        above = np.concatenate([self._outline(k) for k in range(len(poses.t))])
        self._sheets = [Sheet(mark, above) for mark in marks]
        self.camera, self.width, self.height = self._compose(longest_side, camera)

    def _gather(self) -> None:
        """All vertices of all faces in one array, so that posing is one product; `_rings` cuts it up again."""
        faces = self.solid.faces
        vertices = [ring for face in faces for ring in face.rings]
        self._vertices = np.concatenate(vertices) if vertices else np.zeros((0, 3))
        counts = [sum(len(ring) for ring in face.rings) for face in faces]
        self._owner = np.repeat(np.array([f.body for f in faces], dtype=int), counts)
        self._normals = np.array([f.normal for f in faces]).reshape(-1, 3)
        self._faces_of = np.array([f.body for f in faces], dtype=int)
        self._rings: list[list[slice]] = []
        start = 0
        for face in faces:
            slices = []
            for ring in face.rings:
                slices.append(slice(start, start + len(ring)))
                start += len(ring)
            self._rings.append(slices)

    def _outline(self, instant: int) -> Array:
        """All points that the picture must hold at an instant, (n, 3), m."""
        lines = (self.solid.sticks, self.solid.hinges)
        parts = [self.poses.place(instant, self._vertices, self._owner, self._drawn)]
        parts += [self._place(instant, each).reshape(-1, 3) for each in lines]
        return np.concatenate([*parts, self.poses.centres[instant], self._beside])

    def _ground(self) -> Array:
        """Corners of the planes that the picture must hold, (n, 3), m."""
        return np.concatenate([np.zeros((0, 3)), *(sheet.corners for sheet in self._sheets)])

    def _place(self, instant: int, lines: Lines) -> Array:
        return self.poses.place(instant, lines.segments, lines.bodies, self._drawn)

    def project(self, instant: int, lines: Lines) -> Array:
        """Ends of lines at an instant, (k, 2, 3): pixels to the right and up from the middle, and depth."""
        return self.camera.project(self._place(instant, lines))

    def _compose(self, longest_side: int, asked: tuple[float, float] | None) -> tuple[Camera, int, int]:
        """The camera, and width and height of the image in pixels, both even."""
        count = len(self.poses.t)
        chosen = sorted({int(k) for k in np.linspace(0, count - 1, min(_SAMPLES, count))})
        right, up, towards = self._best_view(chosen) if asked is None else _axes(*asked)
        axes = np.stack([right, up, towards], axis=1)
        seen = [np.concatenate([self._outline(k), self._ground()]) @ axes for k in range(count)]
        low = np.min([s.min(axis=0) for s in seen], axis=0)
        high = np.max([s.max(axis=0) for s in seen], axis=0)
        extent = np.maximum((high - low)[:2], 0.05 * self.solid.size) * 1.08
        ratio = float(np.clip(extent[1] / extent[0], 0.2, 1.6))
        width = longest_side if ratio <= 1.0 else int(longest_side / ratio)
        height = int(width * ratio)
        width, height = width - width % 2, height - height % 2
        scale = float(min(width / extent[0], height / extent[1]))
        centre = axes @ ((low + high) / 2)
        return Camera(right, up, towards, centre, scale), width, height

    def _best_view(self, instants: list[int]) -> tuple[Array, Array, Array]:
        """The view in which the motion spreads widest while the faces are not seen edge on."""
        points = [self._outline(k) for k in instants]
        outline = np.concatenate([*points, points[0][:1]])  # a line, which has two points at least
        areas = np.array([face.area for face in self.solid.faces])
        best, found = -1.0, _axes(_AZIMUTHS[2], _ELEVATIONS[1])
        for elevation in _ELEVATIONS:
            for azimuth in _AZIMUTHS:
                axes = _axes(azimuth, elevation)
                flat = outline @ np.stack(axes[:2], axis=1)
                spread = float(shapely.area(shapely.convex_hull(shapely.linestrings(flat))))
                visible = 1.0
                if areas.sum() > 0.0:
                    facing = [np.abs(self._rotated_normals(k) @ axes[2]) @ areas for k in instants]
                    visible = float(np.mean(facing)) / float(areas.sum())
                score = spread * (0.15 + visible)
                if score > best * (1 + 1e-9):
                    best, found = score, axes
        return found

    def _rotated_normals(self, instant: int) -> Array:
        rotated: Array = np.einsum("nij,nj->ni", self.poses.rotations[instant][self._faces_of], self._normals)
        return rotated

    def draw(self, instant: int) -> Pixels:
        """The picture of one instant, (height, width, 3)."""
        canvas = Canvas(self.width, self.height, self._oversampling)
        camera = self.camera
        placed = self.poses.place(instant, self._vertices, self._owner, self._drawn)
        for sheet in self._sheets:
            sheet.draw(canvas, camera, [[placed[s] for s in rings] for rings in self._rings])
        vertices = camera.project(placed)
        normals = self._rotated_normals(instant) @ np.stack([camera.right, camera.up, camera.towards], axis=1)
        shades = 0.62 + 0.38 * np.clip(normals @ _LIGHT, 0.0, 1.0)
        for k in np.flatnonzero(normals[:, 2] > 1e-6):
            colour = self._colours[self._faces_of[k]] * shades[k]
            red, green, blue = (int(c) for c in colour)
            canvas.face([vertices[s] for s in self._rings[k]], normals[k], (red, green, blue))
        self._draw_lines(canvas, instant)
        return canvas.finish()

    def _draw_lines(self, canvas: Canvas, instant: int) -> None:
        solid = self.solid
        sticks = self._colours[solid.sticks.bodies].astype(np.uint8)
        canvas.lines(self.project(instant, solid.sticks), sticks, width=5.0, bias=0.0, solid=True)
        edges = np.tile(np.array(_EDGE, dtype=np.uint8), (len(solid.edges.segments), 1))
        canvas.lines(self.project(instant, solid.edges), edges, width=0.8, bias=1.5)
        hinges = np.tile(np.array(HINGE, dtype=np.uint8), (len(solid.hinges.segments), 1))
        # Hinge lines lie at the mid-plane, inside the material; they are shown through it, short or close ones thinner.
        width = float(np.clip(self._hinge_length * self.camera.scale / 16, 0.5, 1.8))
        canvas.lines(self.project(instant, solid.hinges), hinges, width=width, bias=np.inf)


def _axes(azimuth: float, elevation: float) -> tuple[Array, Array, Array]:
    """Right, up and towards the viewer. Azimuth, degrees, from the -y direction, positive to the viewer's right."""
    a, e = np.radians(azimuth), np.radians(elevation)
    towards = np.array([np.sin(a) * np.cos(e), -np.cos(a) * np.cos(e), np.sin(e)])
    right = np.array([np.cos(a), np.sin(a), 0.0])
    return right, np.cross(towards, right), towards


def _rgb(mechanism: Mechanism) -> Array:
    """Colours of the bodies, (bodies, 3), 0 to 255."""
    colours = body_colours(mechanism)
    return np.array(
        [[int(colours[b.name][k : k + 2], 16) for k in (1, 3, 5)] for b in mechanism.bodies], float
    )
