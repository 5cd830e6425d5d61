"""Which facets of a sheet the world holds: what the user names or points at, and one in the middle of each other piece.

In: faces as bodies, where they lie. Out: groups. Never: moves a facet.
"""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import shapely

from lamc.basics.errors import DesignError
from lamc.readers.fold_groups import IN_LINE, Crease, pieces_of
from lamc.records.card import Fixed
from lamc.records.network import listed_names


@dataclass(frozen=True)
class Placed:
    """Faces of a sheet.

    groups    the lowest face of each face's body
    names     of bodies, by group
    polygons  as the sheet lies flat, m
    seen      as the file has them, along z, m
    may_lie_over  whether the latter may lie over one another, as those of a folded sheet do
    within    pairs of groups that are parts of one facet as it is drawn, which bends
    """

    groups: Sequence[int]
    names: Mapping[int, str]
    polygons: Sequence[shapely.Polygon]
    seen: Sequence[shapely.Polygon]
    may_lie_over: bool
    within: Sequence[tuple[int, int]] = ()


def fixed_groups(
    given: Sequence[Fixed],
    own: Collection[str] | None,
    faces: Placed,
    creases: Sequence[Crease],
    size: float,
    notes: list[str],
) -> list[int]:
    """Groups that are fixed: those that are given, and one in each other piece of the sheet. given: facets' names, or
    places, m; own: names that the file says where nobody else does. Raises DesignError for a facet that there is not,
    and a place in none or in several."""
    groups, names = faces.groups, faces.names
    chosen = [
        _named(each, faces) if isinstance(each, str) else groups[_at(each, faces, size)] for each in given
    ]
    if not given and own is not None:
        chosen = sorted({group for group, name in names.items() if name in own})
    pieces = pieces_of(sorted(set(groups)), [crease.groups for crease in creases])
    free = [piece for piece in pieces if not set(piece) & set(chosen)]
    if len(pieces) > 1 and free:
        notes.append(
            f"the sheet falls into {len(pieces)} pieces that no crease joins; {len(free)} of them "
            + (
                "is fixed by a facet in its middle"
                if len(free) == 1
                else "are fixed by a facet in their middle"
            )
        )
    return [*dict.fromkeys(chosen), *(groups[_amid(set(piece), faces, size)] for piece in free)]


def _named(given: str, faces: Placed) -> int:
    by_name = {f"F{face}": group for face, group in enumerate(faces.groups)}
    by_name |= {name: group for group, name in faces.names.items()}
    if given not in by_name:
        raise DesignError(f"no facet is named {given[:40]!r}; they are F0 to F{len(faces.groups) - 1}")
    return by_name[given]


def _at(given: tuple[float, float], faces: Placed, size: float) -> int:
    """The face at a place of the file; size: of the sheet, m."""
    point, place = shapely.Point(given), f"({given[0]:g}, {given[1]:g}) m"
    within = [k for k, each in enumerate(faces.seen) if each.is_valid and each.covers(point)]
    if not within:
        raise DesignError(
            f"no facet is at {place}; fixed must lie inside one, in the file's own x and y, or name one: F0 to "
            f"F{len(faces.groups) - 1}"
        )
    over = [k for k in within if faces.seen[k].contains(point)] if faces.may_lie_over else []
    met = [k for k, each in enumerate(faces.seen) if shapely.distance(each, point) <= IN_LINE * size]
    parts = {faces.groups[k] for k in met}
    inside = [pair for pair in faces.within if set(pair) <= parts]
    if not over and len(parts) > 1 and len(pieces_of(parts, inside)) > 1:
        names = [faces.names[faces.groups[k]] for k in met]
        raise DesignError(
            f"{place} lies where facets meet, {listed_names(names)}: give a place amid one, or name it, as --fixed "
            f"{names[0]}"
        )
    if len(over) > 1:
        listed = listed_names([faces.names[faces.groups[k]] for k in over])
        raise DesignError(
            f"at {place} several facets lie over one another, {listed}: name one, as --fixed F1"
        )
    return (over or within)[0]


def _amid(piece: set[int], faces: Placed, size: float) -> int:
    """The face of a piece that is nearest to its middle."""
    members = [k for k, group in enumerate(faces.groups) if group in piece]
    polygons = [faces.polygons[k] for k in members]
    middle = shapely.linestrings(
        shapely.get_coordinates(shapely.get_exterior_ring(polygons))
    ).envelope.centroid
    away = shapely.distance(polygons, middle)
    # The lowest of those alike: the middle of a regular sheet is on an edge or a vertex, but for round-off.
    return members[int(np.argmax(away <= away.min() + IN_LINE * size))]
