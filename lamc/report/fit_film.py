"""A film of a fit: recorded points and angles over the motion of the fitted model.

In: a `Fit`. Out: one file, MP4 or GIF. Frames fall on recorded rows where there are any; where a row has a gap, and
between rows, nothing recorded is drawn. Shapes tell recorded from modelled, not colours: a ring and a dot, an outline
and faces.
"""

import os
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
from PIL import ImageDraw

from lamc.basics.errors import RequestError
from lamc.basics.numbers import shortened
from lamc.fitting.answer import Fit
from lamc.fitting.overlaid import Overlaid, SeenHinge, overlaid, states_at
from lamc.fitting.sight import rotation_of
from lamc.records.mechanism import Array
from lamc.report.animation import (
    FRAMES_PER_SECOND,
    MARGIN,
    SHORTEST,
    SIDE,
    Film,
    film_into,
    film_path,
    filmed,
    times_between,
)
from lamc.report.film import Encoder
from lamc.report.look import Look, camera_of
from lamc.report.stage import Stage, poses_of

_RING, _DOT, _TRAIL = 7.0, 3.5, 2.0  # pixels, radii
_PAST = 12  # frames, of the trail
_LINE = 22  # pixels, of the legend
_INK, _HALO, _FILL = "#000000", "#FFFFFF", "#F0E442"

Progress = Callable[[int, int], None]


def draw_fit_film(
    fit: Fit,
    which: int,
    folder: Path,
    stem: str,
    progress: Progress | None = None,
    *,
    look: Look | None = None,
    encoders: Sequence[Encoder] | None = None,
) -> Path:
    """Writes STEM.mp4 of recording number `which` into `folder`, or STEM.gif where nothing writes MP4."""
    return filmed(_frames(fit, which, progress, look or Look()), folder, stem, encoders)


def animate(
    fit: Fit,
    path: str | os.PathLike[str],
    which: int | str = 0,
    *,
    camera: str | Sequence[float] | None = None,
    size: int | None = None,
    progress: Progress | None = None,
) -> Path:
    """`Fit.animate`."""
    target = film_path(path)
    return film_into(_frames(fit, fit.place_of(which), progress, Look(camera_of(camera), size)), target)


def _frames(fit: Fit, which: int, progress: Progress | None, look: Look) -> "_Overlay":
    seen = overlaid(fit, which)
    if not np.isfinite(seen.times).any() or not len(seen.times):
        raise RequestError("this recording has no rows within its run: there is nothing to film")
    even, speed = _even(fit.setting.runs[which].begin, seen.times)
    times, rows = _on_rows(even, seen.times)
    motion, states = states_at(fit, which, times)
    mechanism = seen.simulator.mechanism
    poses = poses_of(mechanism, motion, times, states)
    held = np.concatenate([np.zeros((0, 3)), *(_hull(point.modelled) for point in seen.points)])
    marks = fit.result_of(which).marks
    stage = Stage(mechanism, poses, look.size or SIDE, marks, camera=look.camera, beside=held)
    title = f"{shortened(mechanism.name, 24)}, {shortened(fit.setting.runs[which].name, 14)}"
    return _Overlay(stage, times, speed, title, progress, seen, rows)


def _hull(points: Array) -> Array:
    """Corners (8, 3) of the box around points (m, 3)."""
    ends = np.stack([points.min(axis=0), points.max(axis=0)])
    return np.stack(np.meshgrid(*ends.T, indexing="ij"), axis=-1).reshape(-1, 3)


def _even(begin: float, recorded: Array) -> tuple[Array, float]:
    """Times of frames and simulated seconds in one of the film. Frames come no faster than rows do, or else what was
    recorded would flicker: each stands longer where that makes a film too short."""
    times, speed = times_between(begin, float(recorded[-1]))
    span, spacing = (
        float(recorded[-1]) - begin,
        float(np.median(np.diff(recorded))) if len(recorded) > 1 else 0.0,
    )
    count = round(span / spacing) + 1 if spacing > 0.0 else len(times)
    if count >= len(times):
        return times, speed
    stand = -(-round(SHORTEST * FRAMES_PER_SECOND) // count)
    times = np.repeat(np.linspace(begin, float(recorded[-1]), count), stand)
    return times, span / (len(times) / FRAMES_PER_SECOND)


def _on_rows(even: Array, recorded: Array) -> tuple[Array, Array]:
    """Times of frames, moved to the nearest recorded row where one is nearer than half a frame; and the row of each, -1
    where there is none."""
    half = 0.5 * float(np.max(np.diff(even), initial=0.0))
    after = np.minimum(np.searchsorted(recorded, even), len(recorded) - 1)
    before = np.maximum(after - 1, 0)
    near = np.where(even - recorded[before] <= recorded[after] - even, before, after)
    hits = np.abs(recorded[near] - even) <= half
    return np.where(hits, recorded[near], even), np.where(hits, near, -1)


class _Overlay(Film):
    """rows: which row of the recording each frame shows, -1: none."""

    def __init__(
        self,
        stage: Stage,
        times: Array,
        speed: float,
        name: str,
        progress: Progress | None,
        seen: Overlaid,
        rows: Array,
    ) -> None:
        self._seen, self._rows = seen, rows
        self._legend = _legend(seen)
        band = _LINE * len(self._legend)
        super().__init__(stage, times, speed, name, progress, band + band % 2)
        edges, sticks = stage.solid.edges, stage.solid.sticks
        self._segments = np.concatenate([edges.segments, sticks.segments])
        self._owners = np.concatenate([edges.bodies, sticks.bodies])

    def mark(self, pen: ImageDraw.ImageDraw, index: int) -> None:
        row = int(self._rows[index])
        past = [int(r) for r in self._rows[max(0, index - _PAST) : index] if r >= 0]
        for point in self._seen.points:
            for x, y in self._pixels(point.recorded[past]):
                _disc(pen, x, y, _TRAIL, _INK)
        for hinge in self._seen.hinges if row >= 0 else ():
            if np.isfinite(hinge.apart[row]):
                self._outline(pen, index, hinge)
        for point in self._seen.points if row >= 0 else ():
            if np.isfinite(point.recorded[row]).all():
                (x, y), (there_x, there_y) = self._pixels(
                    np.stack([point.recorded[row], point.modelled[row]])
                )
                pen.line([(x, y), (there_x, there_y)], fill=_INK, width=2)
                _disc(pen, there_x, there_y, _DOT, _FILL)
                _ring(pen, x, y)
        self._draw_legend(pen)

    def _pixels(self, points: Array) -> list[tuple[float, float]]:
        """Where points (k, 3), m, world, are in the frame; what is NaN is left out."""
        finite = points[np.isfinite(points).all(axis=1)]
        right, up = self.stage.camera.project(finite)[:, :2].T
        x, y = right + self.stage.width / 2, MARGIN + self.stage.height / 2 - up
        return list(zip(x.tolist(), y.tolist(), strict=True))

    def _outline(self, pen: ImageDraw.ImageDraw, index: int, hinge: SeenHinge) -> None:
        """The body behind a hinge, turned about it by what was recorded beyond the model's angle."""
        poses, mechanism = self.stage.poses, self._seen.simulator.mechanism
        joint = mechanism.joint(hinge.joint)
        names = [body.name for body in mechanism.bodies]
        child, parent = names.index(joint.child), names.index(joint.parent)
        moved, sign = (parent, -1.0) if mechanism.bodies[child].fixed else (child, 1.0)
        drawn = np.array([b.com for b in mechanism.bodies])
        mine = self._segments[self._owners == moved]
        placed = poses.place(index, mine, np.full(len(mine), moved), drawn)
        anchor = poses.place(index, joint.point[None], np.array([moved]), drawn)[0]
        axis = poses.rotations[index][moved] @ joint.axis
        turn = rotation_of(sign * float(hinge.apart[int(self._rows[index])]) * axis)
        turned = (placed - anchor) @ turn.T + anchor
        ends = [self._pixels(segment) for segment in turned]
        for width, colour in ((4, _HALO), (2, _INK)):
            for pair in ends:
                pen.line(pair, fill=colour, width=width)

    def _draw_legend(self, pen: ImageDraw.ImageDraw) -> None:
        for k, (sign, text) in enumerate(self._legend):
            x, y = 20.0, self.height - _LINE * (len(self._legend) - k - 0.5)
            if sign == "ring":
                _ring(pen, x, y)
            elif sign == "dot":
                _disc(pen, x, y, _DOT, _FILL)
            elif sign == "outline":
                pen.rectangle([x - 9, y - 5, x + 9, y + 5], outline=_INK, width=2)
            text = shortened(text, max(int((self.width - 44) / 8.6), 8))  # of the font's wider letters
            pen.text((38, y), text, fill="black", font=self.font, anchor="lm")


def _legend(seen: Overlaid) -> list[tuple[str, str]]:
    """Signs, and what they say."""
    found = []
    if seen.points:
        found += [("ring", "recorded, with its trail"), ("dot", "of the fitted model")]
    if seen.hinges:
        found.append(("outline", "as recorded, over the model"))
    if seen.others:
        found.append(("", f"not shown: {', '.join(seen.others)}"))
    return found


def _disc(pen: ImageDraw.ImageDraw, x: float, y: float, radius: float, colour: str) -> None:
    for r, fill in ((radius + 1.5, _HALO if colour == _INK else _INK), (radius, colour)):
        pen.ellipse([x - r, y - r, x + r, y + r], fill=fill)


def _ring(pen: ImageDraw.ImageDraw, x: float, y: float) -> None:
    for grown, width, colour in ((1.5, 5, _HALO), (0.0, 2, _INK)):
        r = _RING + grown
        pen.ellipse([x - r, y - r, x + r, y + r], outline=colour, width=width)
