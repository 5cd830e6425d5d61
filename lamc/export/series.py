"""Inputs that follow series, in exports: as tables in the C, or driven by the importer.

In: a simulator or a scene, and options. Out: the tables that the C takes along; scenes whose inputs come from outside;
refusals of what has no form for them. Never: thins out a table.
"""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from lamc.basics.errors import ExportError
from lamc.codegen.recording import Recording
from lamc.export.options import ExportOptions
from lamc.records.effect import hooked
from lamc.records.inputs import is_of_effect
from lamc.records.scene import Scene
from lamc.records.series import Series
from lamc.run.defaults import RTOL
from lamc.run.following import Following, series_of
from lamc.run.simulator import Simulator
from lamc.symbolic.program import Program

MOST_ROWS = 100_000  # of all tables: some 10 MB of C, and seconds of a compiler


def recording_of(simulator: Simulator, options: ExportOptions) -> Recording | None:
    """The tables of all series, with the breaks of runs at lamc's usual tolerance; None where there is none.

    Raises ExportError for tables that are too long, and for times that single precision cannot tell apart.
    """
    return tables_of(simulator.model.motion({}).following, options)


def tables_of_scene(program: Program, scene: Scene) -> Recording | None:
    """The same of a program that nothing was compiled of."""
    own = series_of(scene)
    names, orders = (tuple(getattr(each, of) for each in program.series) for of in ("name", "order"))
    return tables_of(Following(names, tuple(own[name] for name in names), orders), ExportOptions())


def tables_of(following: Following, options: ExportOptions) -> Recording | None:
    """The tables of all series; None where there is none. Raises as `recording_of` does."""
    if not following.series:
        return None
    rows = sum(len(each.t) for each in following.series)
    if rows > MOST_ROWS:
        raise ExportError(
            f"the series of inputs {', '.join(map(repr, following.names))} have {rows} rows; an export takes "
            f"{MOST_ROWS} along at most: thin them out, or export the inputs as numbers that a program sets"
        )
    pieces = [each.pieces for each in following.series]
    if options.precision == "float":
        for name, each in zip(following.names, pieces, strict=True):
            if len(np.unique(each.t.astype(np.float32))) < len(each.t):
                raise ExportError(
                    f"rows of the series of the input {name!r} follow each other faster than single precision tells "
                    "times apart; thin it out, or export in doubles"
                )
    breaks = following.breaks(RTOL, -np.inf, np.inf)
    return Recording(following.names, pieces, breaks)


def from_outside(scene: Scene) -> Scene:
    """The scene whose series are inputs that an importer drives, with their values at t = 0 as defaults.

    Raises ExportError where an effect differentiates one: an importer tells no derivatives.
    """
    own = series_of(scene)
    for effect in (*(scene.effects or ()), *scene.added):
        for drive in hooked(effect).drives():
            for name in drive.inputs() if drive.smooth else ():
                if name in own:
                    raise ExportError(
                        f"{drive.what} differentiates the input {name!r} twice by time, and an importer, which drives "
                        "inputs of an FMU, tells values only; export as C, or give an expression in t"
                    )
    inputs = {
        name: replace(each, default=_first(each.series), series=None) if each.series is not None else each
        for name, each in scene.inputs.items()
        if not is_of_effect(name)
    }
    return replace(scene, inputs=inputs)


def resources(scene: Scene) -> Mapping[str, bytes]:
    """The series as CSV files by path, for an importer to follow."""
    found = {}
    for name, series in series_of(scene).items():
        rows = [f"{t!r},{v!r}" for t, v in zip(series.t.tolist(), series.values.tolist(), strict=True)]
        heading = f"# {series.hold} between rows\nt [s],{name} [{scene.inputs[name].unit}]"
        found[f"resources/{name}.csv"] = "\n".join([heading, *rows, ""]).encode()
    return found


def _first(series: Series) -> float:
    begin, end = series.pieces.begin, series.pieces.end
    return float(series.at(min(max(0.0, begin), end)))
