"""FOLD 1.2: the flat sheet, and frames of its folded motion, as origami tools read them.

In: a mechanism whose bodies are facets of one card, side by side along its hinges, or a run of one. Out: NAME.fold.
`lamc.load` makes the same device of it, by fields "lamc:…" that others pass over. Never: leaves out a hinge or a mass
without being asked.
"""

import json
import math
import shlex
from collections.abc import Mapping, Sequence

import numpy as np

from lamc.basics._version import __version__
from lamc.basics.errors import UnsupportedError, warn
from lamc.codegen.names import identifier
from lamc.export.creased import CreasedSheet
from lamc.export.options import ExportOptions
from lamc.pipeline import compile as compile_design
from lamc.readers.fold_own import BODIES, CARD, FIXED, HINGES
from lamc.records.mechanism import Joint, Mechanism
from lamc.records.scene import Scene
from lamc.run.length import length_of
from lamc.run.result import Result

FRAMES = 61  # of a motion, of small sheets
MOST = 200_000  # numbers in all frames: half of what `lamc.load` reads by default
_NEAR = 1e-9  # of the size: corners that are one
_SAME = 1e-9  # of masses and inertias: what is read back is the same device

Corner = tuple[int, int]  # a face, and which of its corners


def next_step(folder: str, files: Mapping[str, bytes], options: ExportOptions) -> str:
    """Shows it."""
    return f"lamc view {shlex.quote(f'{folder}/{next(iter(files))}')}"


def files(mechanism: Mechanism, scene: Scene, options: ExportOptions) -> dict[str, bytes]:
    """NAME.fold with up to `FRAMES` frames of a run of the scene.

    Raises UnsupportedError for what FOLD cannot hold, unless options.lossy, and as `compile` and `run` do.
    """
    _Sheet(mechanism, lossy=options.lossy)  # what cannot be is told before it runs
    simulator = compile_design(mechanism, scene)
    length = length_of(None, None, simulator)
    ran = length.run(simulator, FRAMES if length.rows(len(simulator.start)) else 0)
    if ran.remark:
        warn(ran.remark)
    return result_files(ran.result, options, scene.angles)


def result_files(
    result: Result, options: ExportOptions, start: Mapping[str, float] | None = None
) -> dict[str, bytes]:
    """The same of a run that has been made; start: angles by joint, rad, that its scene gives; None: where it began."""
    mechanism = result.mechanism
    sheet = _Sheet(mechanism, lossy=options.lossy)
    for lost in sheet.lost:
        warn(f"{identifier(mechanism.name)}.fold does not hold {lost}")
    if start is None:
        start = {name: float(result.angle(name)[0]) for name in result.hinges}
    count = max(2, min(FRAMES, len(result.t), MOST // (3 * len(sheet.vertices) + len(sheet.edges))))
    rows = np.unique(np.linspace(0, len(result.t) - 1, count).round().astype(int))
    data = sheet.key_frame(start)
    data["file_frames"] = sheet.frames(result, rows.tolist())
    return {f"{identifier(mechanism.name)}.fold": _bytes(data)}


def flat_bytes(mechanism: Mechanism) -> bytes:
    """The flat sheet alone, without a run; it starts where the mechanism's scene says."""
    start = mechanism.scene.angles if mechanism.scene else {}
    data = _Sheet(mechanism, lossy=True).key_frame(start)
    return _bytes({**data, "file_classes": ["singleModel"]})


def _bytes(data: Mapping[str, object]) -> bytes:
    return (json.dumps(data, allow_nan=False, separators=(",", ":")).replace(',"', ',\n"') + "\n").encode()


class _Sheet(CreasedSheet):
    """A creased sheet as FOLD says it."""

    def __init__(self, mechanism: Mechanism, *, lossy: bool) -> None:
        super().__init__(mechanism, "FOLD holds")
        if self.windows:
            self.lost.append(f"holes in facets: {len(self.windows)}")
        if self.lost and not lossy:
            raise UnsupportedError(
                f"FOLD cannot hold {'; '.join(self.lost[:4])}: leave it out with --lossy (lossy=True), or export to "
                "mjcf"
            )

    def key_frame(self, start: Mapping[str, float]) -> dict[str, object]:
        """The flat sheet; creases are marked by where they rest."""
        joints = self.mechanism.joints
        on = [None if edge.joint is None else joints[edge.joint] for edge in self.edges]
        rests = [
            None if joint is None else self.sign(edge) * joint.rest_angle
            for edge, joint in zip(self.edges, on, strict=True)
        ]
        bodies = self.mechanism.bodies
        own: dict[str, object] = {
            BODIES: [bodies[k].name for k in self.bodies],
            FIXED: [body.name for body in bodies if body.fixed],
            HINGES: [
                None if edge.joint is None else _hinge(joints[edge.joint], start, self.sign(edge))
                for edge in self.edges
            ],
        }
        if self.card is not None:
            own[CARD] = {"thickness": self.card.thickness, "density": self.card.density}
        return {
            "file_spec": 1.2,
            "file_creator": f"lamc {__version__}",
            "file_title": self.mechanism.name,
            "file_classes": ["animation"],
            "frame_title": self.mechanism.name,
            "frame_classes": ["creasePattern"],
            "frame_attributes": ["2D"],
            "frame_unit": "m",
            "vertices_coords": self.vertices.tolist(),
            "edges_vertices": [list(edge.ends) for edge in self.edges],
            "edges_assignment": [
                ("F" if edge.inner else "B") if joint is None else _kind(joint.stiffness, rest)
                for edge, joint, rest in zip(self.edges, on, rests, strict=True)
            ],
            "edges_foldAngle": [None if rest is None else _degrees(rest) for rest in rests],
            "faces_vertices": self.faces,
            **own,
        }

    def frames(self, result: Result, rows: Sequence[int]) -> list[dict[str, object]]:
        """The folded sheet at these rows of a run."""
        poses = {k: result.pose(self.mechanism.bodies[k].name) for k in sorted(set(self.bodies))}
        angles = {k: result.angle(joint.name) for k, joint in enumerate(self.mechanism.joints)}
        found = []
        for row in rows:
            places = []
            for vertex, face in zip(self.vertices, self.owner, strict=True):
                com, turn = (each[row] for each in poses[self.bodies[face]])
                drawn = np.array([*vertex, self.height]) - self.mechanism.bodies[self.bodies[face]].com
                places.append((com + turn @ drawn).tolist())
            folds = [
                None if e.joint is None else _degrees(self.sign(e) * float(angles[e.joint][row]))
                for e in self.edges
            ]
            found.append(
                {
                    "frame_title": f"t = {result.t[row]:.6g} s",
                    "frame_classes": ["foldedForm"],
                    "frame_attributes": ["3D"],
                    "frame_parent": 0,
                    "frame_inherit": True,
                    "vertices_coords": places,
                    "edges_foldAngle": folds,
                }
            )
        return found


def _hinge(joint: Joint, start: Mapping[str, float], sign: float) -> dict[str, object]:
    """sign: of angles, as the reader of FOLD turns the hinge."""
    numbers = {"stiffness": joint.stiffness, "damping": joint.damping, "rest_angle": sign * joint.rest_angle}
    return {"name": joint.name, **numbers, "start_angle": sign * start.get(joint.name, 0.0)}


def _kind(stiffness: float, rest_angle: float | None) -> str:
    if not stiffness or not rest_angle:
        return "U"
    return "V" if rest_angle > 0.0 else "M"


def _degrees(angle: float) -> float:
    """The spec's range is -180 to 180: turns are left out."""
    return (
        math.degrees(angle) if abs(angle) <= math.pi else math.degrees(math.remainder(angle, 2.0 * math.pi))
    )
