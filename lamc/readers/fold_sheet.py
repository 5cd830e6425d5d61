"""A sheet of edges becomes a `Mechanism` that is drawn flat, facets its bodies and creases its hinges.

In: a frame of vertices, edges and perhaps faces, from FOLD or from a drawing, and what a user says of the sheet. Out:
a mechanism, and a line for each thing that was assumed. Never: reads a file.

Joints follow FOLD's sign: a positive angle is a valley, seen from the side from which faces run counterclockwise.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
import shapely

from lamc.basics.errors import DesignError
from lamc.basics.units import LENGTH, to_si
from lamc.design.mass import body_properties
from lamc.loops.work import MOST, SOON, Work
from lamc.readers.fold_bending import CREASED, FACET, NOWHERE, STIFFER, STILL, bending, obstacle
from lamc.readers.fold_faces import (
    Face,
    beside_edges,
    check_count,
    counterclockwise,
    faces_of,
    overlap,
    polygons_of,
)
from lamc.readers.fold_file import LINK, FoldFrame
from lamc.readers.fold_fixed import Placed, fixed_groups
from lamc.readers.fold_flat import Beside, Corners, angles_of, laid_flat, normals_of
from lamc.readers.fold_groups import grouped, joined_edges, pieces_of
from lamc.readers.fold_hinges import Hinges
from lamc.readers.fold_level import LEVEL, SIDED, is_level, levelled
from lamc.readers.fold_locked import locked_creases
from lamc.readers.fold_own import Own, own_of
from lamc.readers.fold_start import fitted
from lamc.records.card import Card, SheetOptions
from lamc.records.mechanism import Body, Joint, Mechanism, Slab
from lamc.records.network import listed_names
from lamc.records.scene import Scene

_SLIVER = 1e-2  # of the smaller facet: rounded corners of a folded sheet leave slivers where it is laid flat
# m: sheets that hands fold; where millimetres make no such sheet, the numbers are shares of one
HAND = (0.02, 2.0)
USUAL = 0.1  # m, the longer side of a sheet then
OFF = 1e-3  # of the sheet's size: loops of a drawn sheet that close so far are meant to close, and paper yields more
MOST_LOCKED = 0.5  # of the creases: beyond, what rigid facets fold is not what is drawn
_TURNED = 1e-6  # rad: less is round-off of a flat sheet's corners


def sheet_mechanism(frame: FoldFrame, options: SheetOptions, stem: str) -> tuple[Mechanism, list[str]]:
    """The mechanism of one frame, named as it is or `stem`, and what was assumed.

    Raises DesignError with edge, face or vertex for what cannot be.
    """
    sheet = _Sheet(frame, options)
    made, notes = sheet.mechanism(stem)
    if frame.own or options.facets == "rigid":
        return made, notes
    if options.facets == "bend":
        return _bending(frame, sheet).mechanism(stem)
    why = (obstacle(made) or sheet.locked_most) if any(kind in CREASED for kind in frame.kinds) else ""
    if not why:
        return made, notes
    bent, told = _bending(frame, sheet).mechanism(stem)
    if len(bent.joints) == len(made.joints):
        return made, notes
    # What does not run at all while it is rigid may take longer, and what takes long anyway.
    rigid = Work.of(made)
    limits = MOST if why in (STILL, NOWHERE) or not rigid.is_within(SOON) else SOON
    is_long = not options.large and not Work.of(bent).is_within(limits)
    if not sheet.locked_most and is_long and rigid.is_within(MOST):
        notes.append(
            f"{why}: facets that bend would take minutes until they run, and are left rigid (--facets bend, with "
            "--large, has them)"
        )
        return made, notes
    if obstacle(bent) in (STILL, NOWHERE):
        return made, notes
    told.append(
        f"{why}: they bend along diagonals and flat lines, {STIFFER:g} times as stiff as creases of the same length "
        "(--facets rigid leaves them rigid)"
    )
    return bent, told


def unit_of(frame: FoldFrame, options: SheetOptions, notes: list[str]) -> float:
    """m of the file's unit; what is assumed is added to `notes`."""
    if options.units is not None:
        return to_si(f"1 {options.units}", LENGTH)
    if frame.unit is not None:
        return frame.unit
    corners = frame.vertices[np.unique(np.array(frame.edges))]
    longest = float(np.ptp(corners, axis=0).max())
    if not longest or HAND[0] <= 1e-3 * longest <= HAND[1]:
        notes.append("the file says no unit: 1 is taken for 1 mm (--units says another)")
        return 1e-3
    notes.append(
        f"the file says no unit: its longer side, {longest:g}, is taken for {1e3 * USUAL:g} mm (--units says what "
        "1 is)"
    )
    return USUAL / longest


@dataclass(frozen=True)
class _Facets:
    """Faces with what is beside them; corners in the plane, m; angles at the start, rad, by joined edge."""

    faces: tuple[Face, ...]
    beside: Beside
    joined: list[int]
    corners: Corners
    angles: dict[int, float]


class _Sheet:
    """One frame, and what is told of it."""

    def __init__(self, frame: FoldFrame, options: SheetOptions) -> None:
        self.frame, self.options = frame, options
        self.notes = list(frame.notes)
        self.points = frame.vertices * unit_of(frame, options, self.notes)
        used = self.points[np.unique(np.array(frame.edges))]
        self.size = float(np.linalg.norm(np.ptp(used, axis=0))) or 1.0
        self.seen: tuple[shapely.Polygon, ...] = ()  # faces along z, m, where they do not lie so in the sheet
        self.drawn = 0  # creases of a flat sheet
        self.locked_most = ""  # why rigid facets leave too little of the fold; empty: they do not

    def mechanism(self, stem: str) -> tuple[Mechanism, list[str]]:
        facets = self.found
        frame = self.frame
        own = own_of(frame.own, len(facets.faces), len(frame.edges))
        together: dict[str, list[int]] = {}
        for face, name in enumerate(own.bodies or ()):
            together.setdefault(name, []).append(face)
        groups, creases = grouped(
            frame,
            facets.beside,
            facets.joined,
            facets.corners,
            facets.angles,
            list(together.values()),
            self.size,
            self.notes,
        )
        turning = sum(self.frame.kinds[k] in CREASED for crease in creases for k in crease.edges)
        if turning < (1.0 - MOST_LOCKED) * self.drawn:
            self.locked_most = (
                f"rigid facets would stay flat along {self.drawn - turning} of {self.drawn} creases"
            )
        polygons = [
            shapely.Polygon([facets.corners[k][v] for v in face]) for k, face in enumerate(facets.faces)
        ]
        names = {group: (own.bodies[group] if own.bodies else f"F{group}") for group in groups}
        within = [crease.groups for crease in creases if self.frame.kinds[crease.edges[0]] == FACET]
        facets_by_group = Placed(groups, names, polygons, self.seen or polygons, bool(self.seen), within)
        fixed = fixed_groups(self.options.held, own.fixed, facets_by_group, creases, self.size, self.notes)
        bodies = self._bodies(groups, polygons, names, fixed, own)
        hinges = Hinges(frame, facets.beside, facets.corners, facets.angles, groups, self.options.crease, own)
        joints = hinges.joints(creases, fixed, names, {b.name: b for b in bodies})
        self.notes += hinges.notes
        start = {}
        for crease, joint in zip(creases, joints, strict=True):
            said = own.hinges[crease.edges[0]] if own.hinges else None
            angle = said.start_angle if said else facets.angles.get(crease.edges[0], 0.0)
            if abs(angle) > _TURNED:
                start[joint.name] = angle
        if not own.hinges:
            self._tell_other_side(joints, start)
        if not joints:
            self._tell_still(facets.joined)
        name = frame.title.strip() or stem or "sheet"
        name = "".join(c for c in name if c.isprintable())[:100] or "sheet"
        flat = Mechanism(tuple(bodies), tuple(joints), name)
        if start and not own.hinges:
            start = fitted(flat, start, self.notes)
        scene = Scene(angles=start, closure_tolerance=OFF * self.size)
        bent = (
            joint.name for c, joint in zip(creases, joints, strict=True) if frame.kinds[c.edges[0]] == FACET
        )
        return replace(flat, scene=scene, facet_creases=tuple(bent)), self.notes

    def _tell_other_side(self, joints: Sequence[Joint], start: Mapping[str, float]) -> None:
        """Creases that places fold to one side, and fold angles to the other."""
        apart = [
            joint.name
            for joint in joints
            if start.get(joint.name, 0.0) * joint.rest_angle < 0.0
            and min(abs(start[joint.name]), abs(joint.rest_angle)) > SIDED
        ]
        if apart:
            degrees = np.degrees(start[apart[0]])
            self.notes.append(
                f"{listed_names(apart)}: the vertices are folded to the other side than the fold angle says, "
                f"{apart[0]!r} by {degrees:.4g} degrees: the sheet starts there, and folds back through flat"
            )

    def _tell_still(self, joined: Sequence[int]) -> None:
        """That nothing folds, and why, unless that is told already."""
        frame = self.frame
        drawn = [k for k in joined if not frame.sources or frame.sources[k] != LINK]
        level = [k for k in drawn if frame.kinds[k] == "F"]
        if level:
            self.notes.append(
                f"nothing folds: {frame.edges_named(level)} flat (F), so that facets are one body; mark creases "
                "M, V or U, or let facets bend along them (--facets bend)"
            )
        elif not drawn and not frame.own:
            how = "red for mountains, blue for valleys" if frame.sources else "M, V or U"
            self.notes.append(
                f"nothing folds: no crease lies between two facets; draw creases from rim to rim ({how})"
            )

    @cached_property
    def found(self) -> _Facets:
        """Faces, flat or laid flat. Raises DesignError where they cannot be."""
        check_count(len(self.frame.edges), "edges", large=self.options.large)
        level = is_level(self.frame)
        if not level and self.frame.faces is not None and not self.frame.own:
            flat = levelled(self.frame, self.points, self.size, self.notes)
            if flat is not None:
                self.seen = self._along_z(self.frame.faces)
                self.points, level = flat, True
        frame, points = self.frame, self.points
        if frame.faces is None:
            if not level:
                spread = np.linalg.svd(points - points.mean(axis=0), compute_uv=False)
                if not (spread[2:] > LEVEL * spread[0]).any():
                    raise DesignError(
                        "the sheet lies flat in another plane than x and y, and lists no faces_vertices, which say "
                        "what is above: turn it into x and y, or list its faces"
                    )
                raise DesignError(
                    "the sheet is folded, in three dimensions, and lists no faces_vertices: list its faces, or draw it "
                    "flat"
                )
            faces = faces_of(frame.vertices[:, :2], frame.edges, frame.kinds, self.notes, frame.number)
            polygons = polygons_of(points[:, :2], faces)
        elif level:
            faces = tuple(counterclockwise(points[:, :2], face) for face in frame.faces)
            polygons = polygons_of(points[:, :2], faces)
        check_count(len(faces if level else frame.faces or ()), "facets", large=self.options.large)
        if level:
            pair = overlap(polygons)
            turned = sum(a != b for a, b in zip(faces, frame.faces or faces, strict=True))
            if pair is not None and not 0 < turned < len(faces):
                raise DesignError(
                    f"faces {pair[0]} and {pair[1]} lie over one another; a sheet that is folded flat has faces of "
                    "both orientations, and any other needs them side by side (an outline amid a facet: join it to the "
                    "facet's corners by two edges F, and a hole is read)"
                )
            if pair is None:
                folds = any(kind in "MV" for kind in frame.kinds) or any(frame.angles)
                if turned and folds:
                    which = "all faces are" if turned == len(faces) else f"{turned} of {len(faces)} faces are"
                    self.notes.append(
                        f"{which} listed clockwise: mountains and valleys of a flat sheet are taken as it is seen from "
                        "above, whichever way its faces run"
                    )
                return self._flat(faces)
        assert frame.faces is not None
        if not frame.own:
            self.seen = self._along_z(frame.faces)
        return self._folded(frame.faces)

    def _along_z(self, faces: tuple[Face, ...]) -> tuple[shapely.Polygon, ...]:
        """Faces as the file has them, seen along z."""
        return tuple(shapely.Polygon(self.points[list(face), :2]) for face in faces)

    def _flat(self, faces: tuple[Face, ...]) -> _Facets:
        beside = beside_edges(faces, self.frame.edges)
        joined = joined_edges(self.frame, beside, self.notes)
        if not self.frame.own:
            self._tell_of_angles()
            self._lock(joined)
        corners = [{v: self.points[v, :2] for v in face} for face in faces]
        return _Facets(faces, beside, joined, corners, {})

    def _tell_of_angles(self) -> None:
        """Angles of edges along which facets hold together."""
        angles = self.frame.angles
        level = [
            k for k, kind in enumerate(self.frame.kinds) if kind in "FJ" and abs(angles[k] or 0.0) > _TURNED
        ]
        if level:
            self.notes.append(
                f"{self.frame.edges_named(level)}: the fold angle is left out, as edges marked F or J do not fold; "
                "mark M, V or U"
            )

    def _lock(self, joined: list[int]) -> None:
        """Facets stay one body along creases that cannot fold."""
        locked = locked_creases(self.frame, joined, self.points[:, :2])
        told = [k for k in locked if self.frame.kinds[k] != FACET]
        self.drawn = sum(self.frame.kinds[k] in CREASED for k in joined)
        if told:
            self.notes.append(
                f"{self.frame.edges_named(told)}: no hinge, as at one end all creases lie to one side of a line, and "
                "rigid facets stay flat there"
            )
        kinds = "".join("F" if k in locked else kind for k, kind in enumerate(self.frame.kinds))
        self.frame = replace(self.frame, kinds=kinds)

    def _folded(self, faces: tuple[Face, ...]) -> _Facets:
        frame = self.frame
        normals = normals_of(self.points, faces, self.size)
        beside = beside_edges(faces, frame.edges)
        joined = joined_edges(frame, beside, self.notes)
        signs: dict[int, float] = {}
        for k, (kind, angle) in enumerate(zip(frame.kinds, frame.angles, strict=True)):
            if angle or kind in "MV":
                signs[k] = angle or (1.0 if kind == "V" else -1.0)
        angles = angles_of(self.points, normals, frame.edges, beside, joined, signs)
        roots = _roots(len(faces), [beside[k] for k in joined])
        corners = laid_flat(
            self.points, faces, normals, frame.edges, beside, joined, roots, self.size, frame.number
        )
        laid = [shapely.Polygon([corners[k][v] for v in face]) for k, face in enumerate(faces)]
        pair = overlap(laid, _SLIVER)
        if pair is not None:
            raise DesignError(
                f"laid flat, faces {pair[0]} and {pair[1]} lie over one another: the sheet was not folded from one "
                "flat piece; cut it along an edge (assignment C)"
            )
        return _Facets(faces, beside, joined, corners, angles)

    def _bodies(
        self,
        groups: Sequence[int],
        polygons: Sequence[shapely.Polygon],
        names: Mapping[int, str],
        fixed: Sequence[int],
        own: Own,
    ) -> list[Body]:
        card = self._card(own)
        members: dict[int, list[shapely.Polygon]] = {}
        for group, polygon in zip(groups, polygons, strict=True):
            members.setdefault(group, []).append(polygon)
        bodies, held = [], set(fixed)
        for group in sorted(members):
            slabs = tuple(Slab(polygon, 0.0, card.thickness) for polygon in members[group])
            mass, com, inertia = body_properties([(slab, card.density) for slab in slabs])
            bodies.append(Body(names[group], mass, com, inertia, group in held, slabs))
        return bodies

    def _card(self, own: Own) -> Card:
        card = self.options.card or own.card
        if card is None:
            card = Card()
            self.notes.append(
                f"facets are taken for card of {1e3 * card.thickness:g} mm and {card.density:g} kg/m^3 (--card "
                "'0.3 mm, 700 kg/m^3' says another)"
            )
        return card


def _bending(frame: FoldFrame, sheet: _Sheet) -> _Sheet:
    """The sheet of one frame with facets that bend; of the same frame, `sheet` has rigid ones."""
    facets = sheet.found
    return _Sheet(bending(frame, facets.faces, facets.corners), sheet.options)


def _roots(count: int, pairs: Sequence[tuple[int | None, int | None]]) -> list[int]:
    """The lowest face of each piece."""
    joined = [(a, b) for a, b in pairs if a is not None and b is not None]
    return [piece[0] for piece in pieces_of(range(count), joined)]
