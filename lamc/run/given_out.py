"""What a `Result` gives out: files, frames, and pictures, which `lamc.report` draws (`lamc.basics.drawing`).

In: names, axes, paths. Out: files and objects of other libraries. It computes and draws nothing itself.
"""

import os
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, cast

from lamc.basics.drawing import drawer
from lamc.basics.files import checked_path
from lamc.run import files, frames

if TYPE_CHECKING:
    import pandas
    import xarray
    from matplotlib.axes import Axes

    from lamc.run.result import Result


class GivenOut:
    """Base of `Result`."""

    @property
    def _result(self) -> "Result":
        return cast("Result", self)

    def to_csv(self, path: str | Path) -> Path:
        """Writes a table with one row per time: t, angles, rates, energies, outputs, units in the header; numbers read
        back exactly. A JSON manifest goes beside it. Both appear whole or not at all. Raises LamcError
        if it cannot."""
        return files.write_csv(self._result, checked_path(path))

    def to_npz(self, path: str | Path) -> Path:
        """Writes arrays t, q, u, energies, energy, constraint_error, joints, coordinates and rates (names), their units
        coordinate_units and rate_units, energy_names, with an energy balance work and work_names (no pickles), a JSON
        manifest beside it. Both appear whole or not at all. Raises LamcError if it cannot."""
        return files.write_npz(self._result, checked_path(path))

    def to_pandas(self) -> "pandas.DataFrame":
        """A DataFrame over t with the columns of `to_csv`. Raises LamcError without pandas."""
        return frames.to_pandas(self._result)

    def to_xarray(self) -> "xarray.Dataset":
        """A Dataset over (t, joint, energy_name). Raises LamcError without xarray."""
        return frames.to_xarray(self._result)

    def plot(
        self,
        *names: str,
        axes: "Axes | Sequence[Axes] | None" = None,
        path: "str | os.PathLike[str] | None" = None,
    ) -> "tuple[Axes, ...]":
        """Curves over time.

        names  quantities as `quantity` names them, "hinges" for all angles, "energies" for energies by effect and in
               all, a point or a body for its x, y and z; none: hinges and energies
        axes   Matplotlib axes to draw on, one, or one for each unit; None: a new figure
        path   a .png, .svg or .pdf file that the figure is written to, without opening a window

        Returns the axes, one for each unit (angles are in degrees). Raises KeyError for unknown names,
        RequestError for axes that do not fit, LamcError for what cannot be written.
        """
        drawn: tuple[Axes, ...] = drawer("Result", "plot")(self, *names, axes=axes, path=path)
        return drawn

    def animate(
        self,
        path: "str | os.PathLike[str]",
        *,
        camera: str | Sequence[float] | None = None,
        size: int | None = None,
        progress: Callable[[int, int], None] | None = None,
    ) -> Path:
        """A film of the moving device: .mp4 or .gif, as the suffix says.

        camera    "front", "top", "corner", … or (azimuth, elevation), degrees; None: where the motion is seen best
        size      pixels of the longer side
        progress  told frames made and frames in all

        Returns the path. An .mp4 needs the extra `video`, or ffmpeg on the search path. Raises LamcError without them,
        and for a suffix that is neither; RequestError for a camera or a size that there is not.
        """
        film: Path = drawer("Result", "animate")(self, path, camera=camera, size=size, progress=progress)
        return film
