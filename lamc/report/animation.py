"""A film of the moving device: MP4 where PyAV or ffmpeg is installed, else GIF.

In: a `Result`. Out: one file, written whole or not at all. Short runs are slowed down and long ones sped up, and every
frame says by how much, and has the axes and a scale.
"""

import os
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path

import matplotlib as mpl
import numpy as np
from PIL import Image, ImageDraw, ImageFont

from lamc.basics.errors import LamcError
from lamc.basics.files import checked_path, replacing
from lamc.basics.numbers import length_text, shortened
from lamc.records.mechanism import Array
from lamc.report.film import Encoder, write_mp4
from lamc.report.folded import round_length
from lamc.report.look import Look, camera_of
from lamc.report.raster import Pixels
from lamc.report.stage import Stage, stage_of
from lamc.run.result import Result

FRAMES_PER_SECOND = 25  # the fastest that GIF players keep to: 40 ms a frame
LONGEST, SHORTEST = 10.0, 2.0  # s, of the film
SIDE = 560  # pixels
MARGIN = 26  # pixels above the picture, for the time
_FOOT = 84  # pixels below it, for axes and scale
_ARROW = 28  # pixels
_PAPER = 244  # of 255: colours as pale as this are white

Progress = Callable[[int, int], None]


def draw_animation(
    result: Result,
    folder: Path,
    progress: Progress | None = None,
    *,
    look: Look | None = None,
    encoders: Sequence[Encoder] | None = None,
) -> Path:
    """Writes animation.mp4 into `folder`, or animation.gif where nothing writes MP4. Returns its path.

    progress  told frames made and frames in all
    encoders  of MP4; None: those that are there

    Raises LamcError if the file cannot be written.
    """
    return filmed(_frames(result, progress, look), folder, "animation", encoders)


def animate(
    result: Result,
    path: str | os.PathLike[str],
    *,
    camera: str | Sequence[float] | None = None,
    size: int | None = None,
    progress: Progress | None = None,
) -> Path:
    """`Result.animate`."""
    target = film_path(path)
    if not len(result.t):
        raise LamcError("this result has no rows: there is nothing to film")
    return film_into(_frames(result, progress, Look(camera_of(camera), size)), target)


def filmed(frames: "Film", folder: Path, stem: str, encoders: Sequence[Encoder] | None = None) -> Path:
    """Writes STEM.mp4 into `folder`, or STEM.gif where nothing writes MP4. Returns its path."""
    path = folder / f"{stem}.mp4"
    if write_mp4(frames, path, FRAMES_PER_SECOND, encoders):
        return path
    return _write_gif(frames, folder / f"{stem}.gif")


def film_path(path: str | os.PathLike[str]) -> Path:
    """The path of a film. Raises LamcError for a suffix of none."""
    target = checked_path(path)
    if target.suffix.lower() not in (".mp4", ".gif"):
        raise LamcError(f"cannot film into {target.name!r}; the name must end in .mp4 or .gif")
    return target


def film_into(frames: "Film", target: Path) -> Path:
    """Writes the film that the suffix names. Raises LamcError where nothing here writes it."""
    if target.suffix.lower() == ".gif":
        return _write_gif(frames, target)
    if not write_mp4(frames, target, FRAMES_PER_SECOND):
        raise LamcError(f"nothing here writes {target.name!r}: pip install 'lamc[video]', or name a .gif")
    return target


def _frames(result: Result, progress: Progress | None, look: Look | None) -> "Film":
    times, speed = frame_times(result)
    look = look or Look()
    stage = stage_of(result, times, look.size or SIDE, look.camera)
    return Film(stage, times, speed, result.provenance.design, progress)


def frame_times(result: Result) -> tuple[Array, float]:
    """Times of the frames, s, and how many simulated seconds pass in one second of the film."""
    return times_between(float(result.t[0]), float(result.t[-1])) if len(result.t) else (np.zeros(0), 1.0)


def times_between(first: float, last: float) -> tuple[Array, float]:
    """The same, of a span of times, s."""
    span = last - first
    if span <= 0.0:
        return np.array([first]), 1.0
    plays = span if SHORTEST <= span <= LONGEST else LONGEST if span > LONGEST else 2 * SHORTEST
    count = max(2, round(plays * FRAMES_PER_SECOND))
    return np.linspace(first, last, count), span / plays


class Film:
    """The frames, drawn one by one as they are asked for.

    speed  simulated seconds that pass in one of the film
    band   pixels below all that a subclass draws on, in `mark`
    """

    def __init__(
        self, stage: Stage, times: Array, speed: float, name: str, progress: Progress | None, band: int = 0
    ) -> None:
        self.stage = stage
        self._progress = progress
        self._times = times
        self._name = shortened(name, 40)
        self._pace = "real time" if abs(speed - 1.0) < 1e-9 else f"{speed:.3g} × real time"
        # matplotlib brings this font, so that the film looks alike everywhere
        self.font = ImageFont.truetype(Path(mpl.get_data_path()) / "fonts" / "ttf" / "DejaVuSans.ttf", 14)
        self._foot_at = self.stage.height + MARGIN + _FOOT
        self.width, self.height = self.stage.width, self._foot_at + band

    def __len__(self) -> int:
        return len(self._times)

    def frame(self, index: int) -> Image.Image:
        sheet = Image.new("RGB", (self.width, self.height), "white")
        picture: Pixels = self.stage.draw(index)
        sheet.paste(Image.fromarray(picture), (0, MARGIN))
        pen = ImageDraw.Draw(sheet)
        pen.text((8, 5), self._name, fill="black", font=self.font)
        text = f"t = {self._times[index]:.3f} s   {self._pace}"
        pen.text((self.width - 8, 5), text, fill="black", font=self.font, anchor="ra")
        self._draw_axes(pen)
        self._draw_scale(pen)
        self.mark(pen, index)
        return sheet

    def mark(self, pen: ImageDraw.ImageDraw, index: int) -> None:
        """What else a frame has; here nothing."""

    def _draw_axes(self, pen: ImageDraw.ImageDraw) -> None:
        """The world's axes at the lower left, as the camera sees them."""
        camera = self.stage.camera
        arrows = np.column_stack([camera.right, -camera.up]) * _ARROW  # (3, 2)
        low, high = np.minimum(arrows.min(axis=0), 0.0), np.maximum(arrows.max(axis=0), 0.0)
        origin = np.array([24.0 - low[0], self._foot_at - (_FOOT + low[1] + high[1]) / 2])
        for arrow, name in zip(arrows, "xyz", strict=True):
            tip, along = origin + arrow, arrow / max(float(np.hypot(*arrow)), 1.0)
            across = 3.0 * np.array([-along[1], along[0]])
            head = [tip + 4.0 * along, tip - 4.0 * along + across, tip - 4.0 * along - across]
            pen.line([*origin, *tip], fill="black", width=2)
            pen.polygon([(float(x), float(y)) for x, y in head], fill="black")
            x, y = tip + 13.0 * along
            pen.text((float(x), float(y)), name, fill="black", font=self.font, anchor="mm")

    def _draw_scale(self, pen: ImageDraw.ImageDraw) -> None:
        """A bar of a round length at the lower right; in a parallel projection it holds everywhere across the view."""
        scale = self.stage.camera.scale
        length = round_length(0.25 * self.width / scale)
        right, y = self.width - 16, self._foot_at - 18
        left = right - length * scale
        pen.line([(left, y), (right, y)], fill="black", width=4)
        pen.text(((left + right) / 2, y - 6), length_text(length), fill="black", font=self.font, anchor="mb")

    def __iter__(self) -> Iterator[Image.Image]:
        for index in range(len(self)):
            yield self.frame(index)
            if self._progress is not None:
                self._progress(index + 1, len(self))


def _write_gif(frames: Film, path: Path) -> Path:
    """One palette for all frames, made from a few of them, so that colours do not flicker."""
    samples = [frames.frame(k) for k in np.unique(np.linspace(0, len(frames) - 1, 6).astype(int))]
    strip = Image.new("RGB", (frames.width, frames.height * len(samples)))
    for k, sample in enumerate(samples):
        strip.paste(sample, (0, k * frames.height))
    palette = strip.quantize(colors=128, method=Image.Quantize.MEDIANCUT)
    colours = np.array(palette.getpalette()).reshape(-1, 3)
    colours[colours.min(axis=1) > _PAPER] = (
        255  # a mean of white and what is nearly white would be grey paper
    )
    palette.putpalette(colours.ravel().tolist())
    pictures = [frame.quantize(palette=palette, dither=Image.Dither.NONE) for frame in frames]
    duration = 1000 // FRAMES_PER_SECOND
    with replacing(path) as temporary, temporary.open("wb") as file:
        try:
            pictures[0].save(
                file,
                format="GIF",
                save_all=True,
                append_images=pictures[1:],
                duration=duration,
                loop=0,
                optimize=False,
            )
        except ValueError as error:
            raise LamcError(f"cannot write {str(path)!r}: {error}") from error
    return path
