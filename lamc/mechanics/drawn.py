"""Numbers of the drawing that equations hold: what each is called, and what it is for a tree.

In: links, cycles, and what a number is of them. Out: constants of a store under their keys; and the values of all keys
of another drawing of the same topology, for which nothing is derived. Both read the same functions of a link or a
cycle, so that they cannot differ. Never: knows an equation.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from lamc.mechanism.rotations import ROUND_OFF
from lamc.mechanism.tree import WORLD
from lamc.records.mechanism import Array
from lamc.symbolic.scalars import Scalar
from lamc.symbolic.staging import DrawnKey, Store

if TYPE_CHECKING:
    from lamc.mechanism.tree import Link, Tree

Numbers = Sequence[float]


def numeric(matrix: Array) -> tuple[tuple[float, float, float], ...]:
    """A rotation matrix of plain numbers, with zeros and ±1 exact where they are so but for round-off."""
    rows = np.where(
        np.abs(matrix) < ROUND_OFF, 0.0, np.where(np.abs(matrix) > 1 - ROUND_OFF, np.sign(matrix), matrix)
    )
    return tuple((float(r[0]), float(r[1]), float(r[2])) for r in rows)


def _hinge_axis_in_parent(link: "Link") -> Numbers:
    """The link's hinge in its parent's frame: Rz(twist) Rx(fold) e_z."""
    (ct, st), (cf, sf) = link.twist, link.fold
    return (st * sf, -ct * sf, cf)


OF_LINK: Mapping[str, Callable[["Link"], Numbers]] = {
    "angle offset": lambda link: (link.angle_offset,),  # rad
    "twist": lambda link: link.twist,  # cosine, sine
    "fold": lambda link: link.fold,  # cosine, sine
    "offset": lambda link: link.offset.tolist(),  # m, parent's frame
    "axis": _hinge_axis_in_parent,
    "origin": lambda link: link.origin.tolist(),  # m, world
    "frame": lambda link: [v for row in numeric(link.frame) for v in row],  # world from link, by rows
}


def of_link(store: Store, kind: str, index: int, link: "Link") -> tuple[Scalar, ...]:
    """The numbers of a kind of `OF_LINK` as constants; index: of the link in its tree."""
    return keyed(store, (kind, index), OF_LINK[kind](link))


def keyed(store: Store, key: DrawnKey, values: Numbers) -> tuple[Scalar, ...]:
    """Numbers as constants under (*key, place); without a key, equal ones are one."""
    return tuple(store.constant(value, (*key, place) if key else ()) for place, value in enumerate(values))


def link_numbers(tree: "Tree") -> Iterator[tuple[DrawnKey, float]]:
    """All that equations may hold of the links, keys with values."""
    for kind, numbers in OF_LINK.items():
        for index, link in enumerate(tree.links):
            if kind == "origin" and link.parent != WORLD:  # follows from its parent's
                continue
            for place, value in enumerate(numbers(link)):
                yield (kind, index, place), value
