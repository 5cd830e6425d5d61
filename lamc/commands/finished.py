"""A finished `lamc run`, read back from its folder: to be looked at without running again.

In: the folder. Out: a `Result` with the rows of its files and the model of its design. Raises LamcError where the
design that the folder names is not there, or is not what was run.
"""

import json
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from lamc import examples
from lamc.basics.errors import LamcError
from lamc.basics.times import Times
from lamc.commands.inputs import SceneChanges, Source, changed_scene, load_source, mechanism_of
from lamc.commands.run_folder import MANIFEST
from lamc.commands.terminal import Progress
from lamc.pipeline import compile as compile_design
from lamc.run.request import Status
from lamc.run.result import Result
from lamc.run.run_record import Event, Provenance, RunStats
from lamc.run.simulator import Simulator


def finished_run(
    folder: Path, source: Source, times: Times, progress: Progress
) -> tuple[Result, tuple[str, ...]]:
    """The run in `folder`, or in the only folder of a run that it holds, as out/NAME holds out/NAME/SCENE; and what to
    say of it."""
    inside = sorted(path.parent for path in folder.glob(f"*/{MANIFEST}"))
    if not (folder / MANIFEST).exists() and len(inside) == 1:
        folder = inside[0]
    manifest = _manifest(folder)
    way_out = "run it again, or view the design itself"
    origin = str(manifest["source"])
    dimensions = manifest.get("design_parameters_set", {})
    named = _source(folder, origin, source)
    if manifest.get("facets") in ("rigid", "bend") and named.sheet.facets is None:
        named = replace(named, sheet=replace(named.sheet, facets=manifest["facets"]))
    loaded = load_source(named, times, progress, more=dimensions)
    mechanism = mechanism_of(loaded, times, progress)
    scene, _ = changed_scene(mechanism, SceneChanges(scene=manifest["scene"]))
    branch = manifest.get("branch", scene.branch)
    scene = replace(scene, angles=manifest["angles"], rates=manifest["rates"], branch=branch)
    simulator = compile_design(mechanism, scene, source.options, times)
    result = _result(folder, manifest, simulator)
    if result.provenance.digest != manifest["program_digest"]:
        raise LamcError(
            f"{folder}: it was run of another model than {origin!r} is now; the file has changed since, or effects "
            f"were added or left out by options: {way_out}"
        )
    notes = []
    if manifest.get("source_sha256") != loaded.digest:
        notes.append(f"{origin} was changed after this run: what is drawn may not be what ran; {way_out}.")
    return result, tuple(notes)


def _source(folder: Path, origin: str, source: Source) -> Source:
    """Where the design of a manifest is: a file, or an example that is made to a size."""
    if Path(origin).is_file():
        return replace(source, file=origin, example=None)
    try:
        examples.find(origin)
    except LamcError as error:
        raise LamcError(
            f"{folder}: its design, {origin!r}, is not there as seen from here; go to the folder where it was run, or "
            "view the design itself"
        ) from error
    return replace(source, file=None, example=origin)


def _manifest(folder: Path) -> Mapping[str, Any]:
    path = folder / MANIFEST
    try:
        manifest = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError) as error:
        raise LamcError(
            f"{folder} is no folder of a finished `lamc run`: {path.name} cannot be read; name a file"
        ) from error
    needed = (
        "source",
        "scene",
        "angles",
        "rates",
        "program_digest",
        "stats",
        "status",
        "message",
        "parameters",
    )
    if not isinstance(manifest, dict) or any(name not in manifest for name in needed):
        raise LamcError(f"{path} is no manifest of `lamc run`; name a file, or the folder of a run")
    return manifest


def _result(folder: Path, manifest: Mapping[str, Any], simulator: Simulator) -> Result:
    try:
        with np.load(folder / "results.npz", allow_pickle=False) as arrays:
            t, q, u = arrays["t"], arrays["q"], arrays["u"]
            happened = zip(arrays["event_times"].tolist(), arrays["event_names"].tolist(), strict=True)
            events = tuple(Event(instant, name) for instant, name in happened)
    except (OSError, ValueError, KeyError) as error:
        raise LamcError(f"{folder / 'results.npz'} cannot be read: {error}; run it again") from error
    given = {
        name: float(value) for name, value in manifest["parameters"].items() if name in simulator.parameters
    }
    changed = {name: value for name, value in given.items() if value != simulator.parameters[name]}
    # A run of no length gives all that does not come from the files.
    like = simulator.run(1e-9, parameters=changed)
    if (q.shape[1], u.shape[1]) != (like.q.shape[1], like.u.shape[1]):
        raise LamcError(
            f"{folder}: its results are of another mechanism than the design is now; run it again"
        )
    if manifest.get("series", {}) != dict(like.provenance.series):
        raise LamcError(
            f"{folder}: an input follows another series than when this was run; take that back, or run it again"
        )
    stats = RunStats(
        **{**manifest["stats"], "switches": tuple(tuple(each) for each in manifest["stats"]["switches"])}
    )
    provenance: Provenance = like.provenance
    return replace(
        like, t=t, q=q, u=u, stats=stats, provenance=provenance, events=events, message=str(manifest["message"]),
        status=Status[str(manifest["status"]).upper()],
    )  # fmt: skip
