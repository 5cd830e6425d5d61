"""Pictures of solids by depth buffer: faces and lines in a camera's axes become pixels.

In: faces (plane polygons with holes) and lines, in pixels and depth. Out: an image, (height, width, 3) of bytes. A
depth buffer shows folded sheets right where sorting whole faces by distance, as plotting libraries do, does not: sheets
that lie on one another, cross, or are seen nearly edge on. It knows nothing of bodies, and writes no files.
"""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from PIL import Image, ImageDraw

from lamc.records.mechanism import Array

Pixels = npt.NDArray[np.uint8]

# Pixels. Faces of two bodies may lie in one plane; without it, round-off would draw stripes of both.
_TIE = 0.05


@dataclass(frozen=True, eq=False)
class Camera:
    """A parallel projection: unit vectors to the right, up and towards the viewer.

    centre   what the middle of the image shows, m, world
    scale    pixels per metre
    """

    right: Array
    up: Array
    towards: Array
    centre: Array
    scale: float

    def project(self, points: Array) -> Array:
        """World points (…, 3), m, as (x to the right, y up, depth towards the viewer), in pixels from the middle."""
        axes = np.stack([self.right, self.up, self.towards], axis=1)
        projected: Array = (points - self.centre) @ axes * self.scale
        return projected


class Canvas:
    """An image and its depth buffer. `finish` gives the picture, smoothed by `oversampling`."""

    def __init__(self, width: int, height: int, oversampling: int = 2) -> None:
        self.oversampling = oversampling
        self.width, self.height = width * oversampling, height * oversampling
        # Pixels hold numbers of colours, which are looked up at the end: one array to write instead of three.
        self.paint = np.zeros((self.height, self.width), dtype=np.uint16)
        self._numbers: dict[tuple[int, ...], int] = {(255, 255, 255): 0}
        self.depth = np.full((self.height, self.width), -np.inf, dtype=np.float32)

    def _to_image(self, points: Array) -> Array:
        """Pixels from the middle, y up, to columns and rows of the fine image; depth likewise."""
        fine = points * self.oversampling
        fine[..., 0] += self.width / 2
        fine[..., 1] = self.height / 2 - fine[..., 1]
        return fine

    def _colour(self, colour: tuple[int, ...]) -> int:
        return self._numbers.setdefault(colour, len(self._numbers))

    def face(self, rings: list[Array], normal: Array, colour: tuple[int, int, int]) -> None:
        """One plane face: outer ring and holes, each (k, 3) in pixels; unit normal in the camera's axes."""
        if normal[2] < 1e-6:
            return
        outer, *holes = [self._to_image(ring) for ring in rings]
        low = np.maximum(np.floor(outer[:, :2].min(axis=0)).astype(int), 0)
        high = np.minimum(np.ceil(outer[:, :2].max(axis=0)).astype(int) + 1, (self.width, self.height))
        if (high <= low).any():
            return
        columns, rows = (int(v) for v in high - low)
        mask = Image.new("L", (columns, rows))
        pen = ImageDraw.Draw(mask)
        pen.polygon([(float(x), float(y)) for x, y in outer[:, :2] - low], fill=1)
        for hole in holes:
            pen.polygon([(float(x), float(y)) for x, y in hole[:, :2] - low], fill=0)
        inside = np.asarray(mask).view(np.bool_)
        # The face's plane: depth falls by nx/nz for each pixel to the right, and rises by ny/nz for each row down.
        slope_x, slope_y = -normal[0] / normal[2], normal[1] / normal[2]
        x = np.arange(low[0], high[0], dtype=np.float32) + 0.5 - outer[0, 0]
        y = np.arange(low[1], high[1], dtype=np.float32) + 0.5 - outer[0, 1]
        depth = (np.float32(outer[0, 2]) + np.float32(slope_x) * x)[None, :] + (np.float32(slope_y) * y)[
            :, None
        ]
        # Seen nearly edge on, the plane runs off far beyond the face within one pixel.
        np.clip(depth, outer[:, 2].min(), outer[:, 2].max(), out=depth)
        window = np.s_[low[1] : high[1], low[0] : high[0]]
        nearer = depth > self.depth[window]
        nearer &= inside
        np.copyto(self.depth[window], depth + _TIE, where=nearer)
        np.copyto(self.paint[window], self._colour(colour), where=nearer)

    def lines(
        self, segments: Array, colours: Pixels, width: float, bias: float = 2.0, *, solid: bool = False
    ) -> None:
        """Lines (k, 2, 3), in pixels, with colours (k, 3), where nothing lies more than `bias` pixels in front of them.

        solid  the lines hide what is drawn later behind them
        """
        if not len(segments):
            return
        fine = self._to_image(segments.astype(float))
        length = np.linalg.norm(fine[:, 1, :2] - fine[:, 0, :2], axis=1)
        counts = np.minimum(np.ceil(length / 0.7).astype(int) + 1, 4 * (self.width + self.height))
        which = np.repeat(np.arange(len(fine)), counts)
        first = np.repeat(np.cumsum(counts) - counts, counts)
        part = ((np.arange(len(which)) - first) / np.maximum(counts[which] - 1, 1))[:, None]
        points = fine[which, 0] * (1 - part) + fine[which, 1] * part
        numbers = np.array([self._colour(tuple(c)) for c in colours.tolist()], dtype=np.uint16)
        half = width * self.oversampling / 2
        reach = int(np.ceil(half))
        for dx in range(-reach, reach + 1):
            for dy in range(-reach, reach + 1):
                if dx * dx + dy * dy <= half * half:
                    self._dots(points, (dx, dy), which, numbers, bias * self.oversampling, solid)

    def _dots(
        self,
        points: Array,
        shift: tuple[int, int],
        which: npt.NDArray[np.int_],
        colours: npt.NDArray[np.uint16],
        bias: float,
        solid: bool,
    ) -> None:
        column = np.floor(points[:, 0]).astype(int) + shift[0]
        row = np.floor(points[:, 1]).astype(int) + shift[1]
        seen = (column >= 0) & (column < self.width) & (row >= 0) & (row < self.height)
        column, row, depth, which = column[seen], row[seen], points[seen, 2], which[seen]
        front = depth + bias >= self.depth[row, column]
        column, row = column[front], row[front]
        self.paint[row, column] = colours[which[front]]
        if solid:
            self.depth[row, column] = depth[front]

    def finish(self) -> Pixels:
        """The picture, (height, width, 3)."""
        k = self.oversampling
        palette = np.array(list(self._numbers), dtype=np.uint8)
        parts = [self.paint[row::k, column::k] for row in range(k) for column in range(k)]
        picture: Pixels = palette[parts[0]]
        mixed = np.zeros(picture.shape[:2], dtype=np.bool_)  # few pixels are: those at edges
        for part in parts[1:]:
            mixed |= part != parts[0]
        total = sum(palette[part[mixed]].astype(np.uint16) for part in parts)
        picture[mixed] = total // (k * k)
        return picture
