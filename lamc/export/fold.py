"""FOLD 1.2: the flat sheet, and frames of its folded motion, as origami tools read them.

In: a mechanism whose bodies are facets of one card, side by side along its hinges, or a run of one. Out: NAME.fold.
`lamc.load` makes the same device of it, by fields "lamc:…" that others pass over. Never: leaves out a hinge or a mass
without being asked.
"""

import json
import math
import shlex
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree
from shapely.geometry import Polygon

from lamc.basics._version import __version__
from lamc.basics.errors import UnsupportedError
from lamc.codegen.names import identifier
from lamc.design.mass import body_properties
from lamc.export.options import ExportOptions
from lamc.pipeline import compile as compile_design
from lamc.readers.fold_groups import pieces_of
from lamc.readers.fold_own import BODIES, CARD, FIXED, HINGES
from lamc.records.card import Card
from lamc.records.mechanism import Array, Body, Joint, Mechanism
from lamc.records.network import listed_names
from lamc.records.scene import Scene
from lamc.run.result import Result

FRAMES = 61  # of a motion, of small sheets
MOST = 200_000  # numbers in all frames: half of what `lamc.load` reads by default
DURATION = 10.0  # s, of a scene that says none
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
    result = compile_design(mechanism, scene).run(
        t_end=scene.duration or DURATION, t_eval=np.linspace(0.0, scene.duration or DURATION, FRAMES)
    )
    return result_files(result, options, scene.angles)


def result_files(
    result: Result, options: ExportOptions, start: Mapping[str, float] | None = None
) -> dict[str, bytes]:
    """The same of a run that has been made; start: angles by joint, rad, that its scene gives; None: where it began."""
    mechanism = result.mechanism
    sheet = _Sheet(mechanism, lossy=options.lossy)
    if start is None:
        start = {name: float(result.angle(name)[0]) for name in result.hinges}
    count = max(2, min(FRAMES, len(result.t), MOST // (3 * len(sheet.vertices) + len(sheet.edges))))
    rows = np.unique(np.linspace(0, len(result.t) - 1, count).round().astype(int))
    data = sheet.key_frame(start)
    data["file_frames"] = sheet.frames(result, rows.tolist())
    text = json.dumps(data, allow_nan=False, separators=(",", ":")).replace(',"', ',\n"') + "\n"
    return {f"{identifier(mechanism.name)}.fold": text.encode()}


@dataclass(frozen=True)
class _Edge:
    """joint: index of the mechanism's; None: within a body, or on the rim."""

    ends: tuple[int, int]
    joint: int | None
    inner: bool


class _Sheet:
    """Facets of a mechanism with their common corners."""

    def __init__(self, mechanism: Mechanism, *, lossy: bool) -> None:
        self.mechanism = mechanism
        outlined = [(k, p) for k, body in enumerate(mechanism.bodies) for p in _facets(body)]
        if not outlined:
            raise UnsupportedError(
                "no body has an outline, so there is nothing to draw; FOLD holds flat facets"
            )
        self.bodies = [k for k, _ in outlined]
        self.rings = [np.array(p.exterior.coords)[:-1, :2] for _, p in outlined]
        self.card, lost = _card(mechanism)
        self.height = 0.5 * self.card.thickness if self.card else 0.0
        self._join()
        drawn = {edge.joint for edge in self.edges}
        bare = [joint.name for k, joint in enumerate(mechanism.joints) if k not in drawn]
        if bare:
            lost.append(
                f"hinges without a common side of their bodies, as gaps leave them: {listed_names(bare)}"
            )
        lost += [f"limits of hinge {joint.name!r}" for joint in mechanism.joints if joint.is_limited]
        if lost and not lossy:
            raise UnsupportedError(
                f"FOLD cannot hold {'; '.join(lost[:4])}: leave it out with --lossy (lossy=True), or export to mjcf"
            )

    def _join(self) -> None:
        """`vertices` (n, 2), m; `faces`, by vertices; `edges`."""
        corners = [(f, k) for f, ring in enumerate(self.rings) for k in range(len(ring))]
        index = {corner: k for k, corner in enumerate(corners)}
        places = np.concatenate(self.rings)
        size = float(np.linalg.norm(np.ptp(places, axis=0)))
        near = cKDTree(places).query_pairs(_NEAR * size)
        spot = {k: group[0] for group in pieces_of(range(len(corners)), near) for k in group}
        sides: dict[tuple[int, int], tuple[Corner, Corner]] = {}
        for face, ring in enumerate(self.rings):
            for k in range(len(ring)):
                a, b = (face, k), (face, (k + 1) % len(ring))
                sides[spot[index[a]], spot[index[b]]] = (a, b)
        pairs: list[tuple[int, int]] = []
        joined: dict[tuple[Corner, Corner], int | None] = {}
        for (p, q), (a, b) in sides.items():
            other = sides.get((q, p))
            if other is None:
                continue
            one, two = self.bodies[a[0]], self.bodies[other[0][0]]
            joint = None if one == two else self._joint(one, two, places[p], places[q], size)
            if one == two or joint is not None:
                pairs += [(index[a], index[other[1]]), (index[b], index[other[0]])]
                joined[a, b] = joint
        number: dict[int, int] = {}
        for group, found in enumerate(pieces_of(range(len(corners)), pairs)):
            number |= dict.fromkeys(found, group)
        first = {number[k]: k for k in reversed(range(len(corners)))}
        self.vertices = places[[first[v] for v in range(len(first))]]
        self.owner = [corners[first[v]][0] for v in range(len(first))]
        self.faces = [[number[index[f, k]] for k in range(len(ring))] for f, ring in enumerate(self.rings)]
        edges: dict[tuple[int, int], _Edge] = {}
        for a, b in sides.values():
            ends = (number[index[a]], number[index[b]])
            key = (min(ends), max(ends))
            if key not in edges or (a, b) in joined:
                known = (a, b) in joined
                edges[key] = _Edge(key, joined.get((a, b)), known)
        self.edges = list(edges.values())

    def _joint(self, one: int, two: int, start: Array, end: Array, size: float) -> int | None:
        names = {self.mechanism.bodies[k].name for k in (one, two)}
        along = np.array([*(end - start), 0.0])
        for k, joint in enumerate(self.mechanism.joints):
            if {joint.parent, joint.child} == names:
                arm = np.array([*start, joint.point[2]]) - joint.point
                apart = np.linalg.norm(np.cross(arm, joint.axis)) + np.linalg.norm(
                    np.cross(along, joint.axis)
                )
                if apart <= 1e-6 * size:
                    return k
        return None

    def key_frame(self, start: Mapping[str, float]) -> dict[str, object]:
        """The flat sheet; creases are marked by where they rest."""
        joints = self.mechanism.joints
        on = [None if edge.joint is None else joints[edge.joint] for edge in self.edges]
        bodies = self.mechanism.bodies
        own: dict[str, object] = {
            BODIES: [bodies[k].name for k in self.bodies],
            FIXED: [body.name for body in bodies if body.fixed],
            HINGES: [None if joint is None else _hinge(joint, start) for joint in on],
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
                ("F" if edge.inner else "B") if joint is None else _kind(joint)
                for edge, joint in zip(self.edges, on, strict=True)
            ],
            "edges_foldAngle": [None if joint is None else _degrees(joint.rest_angle) for joint in on],
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
            folds = [None if e.joint is None else _degrees(float(angles[e.joint][row])) for e in self.edges]
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


def _facets(body: Body) -> list[Polygon]:
    """Polygons of a body as seen from above: the slabs between two heights that have the largest area in all."""
    levels: dict[tuple[float, float], list[Polygon]] = {}
    for slab in body.outline:
        levels.setdefault((slab.z_bottom, slab.z_top), []).append(slab.polygon)
    return max(levels.values(), key=lambda found: sum(p.area for p in found), default=[])


def _card(mechanism: Mechanism) -> tuple[Card | None, list[str]]:
    """The card that all bodies are of, and what keeps them from it."""
    slabs = [slab for body in mechanism.bodies for slab in body.outline]
    heights = {(slab.z_bottom, slab.z_top) for slab in slabs}
    holes = sum(bool(slab.polygon.interiors) for slab in slabs)
    if len(heights) > 1 or holes:
        return None, [f"holes in {holes} facets" if holes else "layers of several heights"]
    (bottom, top) = next(iter(heights))
    masses = [
        (b.mass, sum(s.polygon.area for s in b.outline)) for b in mechanism.bodies if b.mass and b.outline
    ]
    density = masses[0][0] / (masses[0][1] * (top - bottom)) if masses else Card().density
    other = []
    for body in mechanism.bodies:
        if not body.fixed and body.outline:
            mass, com, inertia = body_properties([(slab, density) for slab in body.outline])
            scale = float(np.abs(inertia).max())
            same = abs(mass - body.mass) <= _SAME * mass and np.abs(com - body.com).max() <= _SAME
            if not (same and np.abs(inertia - body.inertia).max() <= _SAME * scale):
                other.append(body.name)
    lost = [f"masses that are not those of one card: {listed_names(other)}"] if other else []
    if bottom != 0.0:
        lost.append("facets that do not lie on z = 0")
    return Card(top - bottom, density), lost


def _hinge(joint: Joint, start: Mapping[str, float]) -> dict[str, object]:
    numbers = {"stiffness": joint.stiffness, "damping": joint.damping, "rest_angle": joint.rest_angle}
    return {"name": joint.name, **numbers, "start_angle": start.get(joint.name, 0.0)}


def _kind(joint: Joint) -> str:
    if not joint.stiffness or not joint.rest_angle:
        return "U"
    return "V" if joint.rest_angle > 0.0 else "M"


def _degrees(angle: float) -> float:
    """The spec's range is -180 to 180: turns are left out."""
    return (
        math.degrees(angle) if abs(angle) <= math.pi else math.degrees(math.remainder(angle, 2.0 * math.pi))
    )
