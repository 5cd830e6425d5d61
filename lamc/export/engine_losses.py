"""What a format cannot hold: refused, unless it was asked for.

In: what is lost. Out: an error that names all of it, or nothing. Never: decides what is lost.
"""

from collections.abc import Sequence

from lamc.basics.errors import UnsupportedError, about
from lamc.effects.engine_loads import Loss
from lamc.export.options import ExportOptions


def check_losses(target: str, lost: Sequence[Loss], options: ExportOptions, way_out: str = "") -> None:
    """Raises UnsupportedError if something is lost that was not given up. way_out: one more, if there is one."""
    if lost and not options.lossy:
        reported = "; ".join(loss.what for loss in lost)
        with about(lost[0].effect):
            raise UnsupportedError(
                f"{target} has no place for {reported}: leave it out of the scene, or export with lossy (on the "
                f"command "
                f"line --lossy), which leaves it out and lists it in the README{way_out}"
            )
