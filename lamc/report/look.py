"""How a device in space is looked at: from where, how large, in which format.

In: words such as "top" or "30,20", numbers. Out: a `Look`, or errors that tell the rule. Never: draws.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass

from lamc.basics.checks import did_you_mean, shown
from lamc.basics.errors import RequestError

Camera = tuple[float, float]

# Azimuth, degrees, from the -y direction, positive to the viewer's right; elevation, degrees above the ground.
CAMERAS: dict[str, Camera] = {
    "front": (0.0, 0.0),
    "back": (180.0, 0.0),
    "right": (90.0, 0.0),
    "left": (-90.0, 0.0),
    "top": (0.0, 90.0),
    "bottom": (0.0, -90.0),
    "corner": (-45.0, 35.264),
}
SMALLEST, LARGEST = 64, 4096  # pixels
FORMATS = ("png", "svg", "pdf")


@dataclass(frozen=True)
class Look:
    """camera: azimuth and elevation, degrees; None: where the motion spreads widest.
    size: pixels of the longer side of a picture in space, of a film's frame too; None: each its own.
    format: of pictures: "png", "svg" or "pdf"."""

    camera: Camera | None = None
    size: int | None = None
    format: str = "png"

    def __post_init__(self) -> None:
        if self.size is not None and not SMALLEST <= self.size <= LARGEST:
            raise RequestError(f"size is {shown(self.size)}; it must be {SMALLEST} to {LARGEST} pixels")


def camera_of(given: str | Sequence[float] | None) -> Camera | None:
    """A camera of a name in `CAMERAS`, of "AZIMUTH,ELEVATION" or of these two numbers, degrees. Raises RequestError."""
    if given is None:
        return None
    if isinstance(given, str) and given in CAMERAS:
        return CAMERAS[given]
    parts = given.split(",") if isinstance(given, str) else given
    try:
        azimuth, elevation = (float(part) for part in parts)
    except (TypeError, ValueError):
        hint = did_you_mean(given, list(CAMERAS)) if isinstance(given, str) else f"such as {(30, 20)}"
        raise RequestError(
            f"camera is {shown(given)}; it must be AZIMUTH,ELEVATION in degrees, such as 30,20, or a name; {hint}"
        ) from None
    if not (math.isfinite(azimuth) and -90.0 <= elevation <= 90.0):
        raise RequestError(f"camera is {shown(given)}; its elevation must lie between -90 and 90 degrees")
    return azimuth, elevation
