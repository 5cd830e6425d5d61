"""The first failure of a plate in a line: how many times what acts, which ply, where, and how.

In: a `PlateFailure`. Out: text. Never: computes anything.
"""

import math

from lamc.basics.numbers import place_text
from lamc.plates.answers.failure import PlateFailure

_NAMES = {"tsai-wu": "Tsai-Wu", "max-stress": "maximum stress"}


def failure_text(failure: PlateFailure, size: float) -> str:
    """`size` of the plate, m, decides the unit of the place; regions whose strengths are unknown are named."""
    unknown = ", ".join(repr(name or "the rest") for name in failure.unjudged)
    beside = f"; not judged, since strengths are unknown: {unknown}" if unknown else ""
    if not math.isfinite(failure.ratio):
        return f"under no multiple of what acts: nothing stresses a ply{beside}"
    region = f" of region {failure.region!r}" if failure.region else ""
    times = f"at {failure.ratio:.4g} times what acts ({_NAMES[failure.criterion]})"
    ply = f"ply {failure.number} from the bottom{region} ({failure.ply.angle:g}°)"
    return f"{times}: {ply}, {failure.face} face at {place_text(failure.at, size)}, {failure.mode}{beside}"
