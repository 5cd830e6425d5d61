"""Films as MP4: by PyAV, which the extra `video` brings, or by the ffmpeg of this machine.

In: frames, a path. Out: a file, written whole or not at all; or the word that nothing here writes it. It draws nothing.
"""

import shutil
import subprocess
from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from importlib import import_module
from pathlib import Path
from typing import Any, Protocol

from PIL import Image

from lamc.basics.files import replacing

_TIMEOUT = 300  # s, for ffmpeg to end once it has all frames
_CODECS = ("libx264", "h264", "mpeg4")  # the first that PyAV was built with


class Frames(Protocol):
    """Pictures of one size, width and height even, drawn one by one."""

    width: int
    height: int

    def __iter__(self) -> Iterator[Image.Image]: ...


Encoder = Callable[[Frames, Path, int], bool]


class _UnwrittenError(Exception):
    """An encoder cannot."""


def write_mp4(frames: Frames, path: Path, rate: int, encoders: Sequence[Encoder] | None = None) -> bool:
    """Writes the frames by the first encoder that can, None: PyAV, then ffmpeg; `rate` a second. False where none can,
    and then `path` is as it was."""
    for encode in (by_pyav, by_ffmpeg) if encoders is None else encoders:
        with suppress(_UnwrittenError), replacing(path) as temporary:
            if not encode(frames, temporary, rate):
                raise _UnwrittenError  # leaves a film that was there before as it was
            return True
    return False


def by_pyav(frames: Frames, path: Path, rate: int) -> bool:
    """False without PyAV, or with one that has no encoder."""
    try:
        av: Any = import_module("av")
    except ImportError:
        return False
    codec = next((name for name in _CODECS if _encodes(av, name)), None)
    if codec is None:
        return False
    with av.open(str(path), "w", format="mp4", options={"movflags": "+faststart"}) as film:
        stream = film.add_stream(codec, rate=rate)
        stream.width, stream.height, stream.pix_fmt = frames.width, frames.height, "yuv420p"
        for picture in frames:
            film.mux(stream.encode(av.VideoFrame.from_image(picture)))
        film.mux(stream.encode(None))
    return True


def _encodes(av: Any, name: str) -> bool:
    """`av.codecs_available` has decoders too, and h264 is one in a build that cannot write it."""
    try:
        return bool(av.Codec(name, "w").is_encoder)
    except ValueError:  # UnknownCodecError
        return False


def by_ffmpeg(frames: Frames, path: Path, rate: int, program: str | None = None) -> bool:
    """Pipes the frames to ffmpeg. False without it, and if it fails: one without encoders is no reason to stop."""
    program = program or shutil.which("ffmpeg")
    if program is None:
        return False
    command = [program, "-y", "-loglevel", "error", "-f", "rawvideo", "-pix_fmt", "rgb24"]
    command += ["-s", f"{frames.width}x{frames.height}", "-r", str(rate), "-i", "-", "-an"]
    command += ["-pix_fmt", "yuv420p", "-movflags", "+faststart", "-f", "mp4", str(path)]
    try:
        with subprocess.Popen(
            command, stdin=subprocess.PIPE, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL
        ) as process:
            assert process.stdin is not None
            try:
                for frame in frames:
                    process.stdin.write(frame.tobytes())
                process.stdin.close()
                return process.wait(_TIMEOUT) == 0
            except BaseException:
                process.kill()
                raise
    except (OSError, subprocess.TimeoutExpired):
        return False
