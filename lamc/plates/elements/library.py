"""The elements that come with lamc, by name, and how one that bends and one that stretches become one.

In: names. Out: elements. Never: formulas, which are in `triangles.py` and `squares.py`.
"""

from collections.abc import Mapping, Sequence
from difflib import get_close_matches

import sympy as sp

from lamc.basics.checks import shown
from lamc.basics.errors import DesignError
from lamc.basics.once import remembered
from lamc.basics.readonly import ReadOnlyDict
from lamc.plates.elements.definition import DOFS, Element, Node, symbols_of
from lamc.plates.elements.squares import BFS, Q4, Q8, Q9, Q12
from lamc.plates.elements.triangles import BCIZ, CST, DKMT, DKT, LST, SPECHT

ELEMENTS: Mapping[str, Element] = ReadOnlyDict(
    {e.name: e for e in (BCIZ, DKT, SPECHT, DKMT, CST, LST, Q4, Q8, Q9, Q12, BFS)}
)


def element(name: str) -> Element:
    """The element of that name: one of `ELEMENTS`, or two with a plus between, as in "dkt+cst".

    Raises DesignError for a name that is not there, and as `combine` does.
    """
    if not isinstance(name, str):
        raise DesignError(f"the element is {shown(name)}; it must be an Element, or the name of one")
    names = [part.strip().lower() for part in name.split("+")]
    for part in names:
        if part not in ELEMENTS:
            close = get_close_matches(part, ELEMENTS, 1)
            hint = f"did you mean {close[0]!r}?" if close else f"there are {', '.join(ELEMENTS)}"
            raise DesignError(f"there is no element {shown(part)}; {hint}")
    if len(names) > 2:
        raise DesignError(
            f"the element {shown(name)} has {len(names)} parts; one that bends and one that stretches do"
        )
    if len(names) == 1:
        return ELEMENTS[names[0]]
    first, second = (ELEMENTS[part] for part in names)
    return combine(first, second) if first.bends else combine(second, first)


def checked_element(given: Element | str) -> Element:
    """`given`, or the element of that name. Raises DesignError for anything else."""
    return given if isinstance(given, Element) else element(given)


def combine(bending: Element | str, membrane: Element | str) -> Element:
    """One element with the unknowns of both, for laminates that bend when they are stretched; each may be a name.

    Nodes of both that are at the same place are one; corners come first, then edges, then the inside. Raises
    DesignError unless one only bends, the other only stretches, and both have the same cell.
    """
    bending, membrane = checked_element(bending), checked_element(membrane)
    if all(ELEMENTS.get(part.name) is part for part in (bending, membrane)):
        return _own_pair(bending.name, membrane.name)
    return _combined(bending, membrane)


@remembered  # what sympy writes of an element for the cache's key is kept with it
def _own_pair(bending: str, membrane: str) -> Element:
    return _combined(ELEMENTS[bending], ELEMENTS[membrane])


def _combined(bending: Element, membrane: Element) -> Element:
    for part, does, wrong in (
        (bending, bending.bends, bending.stretches),
        (membrane, membrane.stretches, membrane.bends),
    ):
        if not does or wrong:
            what = "bends only" if part is bending else "stretches only"
            raise DesignError(
                f"{part.name!r} cannot be combined: of {bending.name}+{membrane.name}, it must be one that {what}"
            )
    if bending.cell != membrane.cell:
        raise DesignError(
            f"{bending.name!r} is for {bending.cell}s and {membrane.name!r} for {membrane.cell}s; "
            "combine elements of one kind of cell"
        )
    for symbol, expr in bending.geometry.items():
        if membrane.geometry.get(symbol, expr) != expr:
            raise DesignError(
                f"{bending.name!r} and {membrane.name!r} both define {symbol}, differently; rename one"
            )
    places = [node.at for node in membrane.nodes]
    places += [node.at for node in bending.nodes if node.at not in places]
    found = [{node.at: node.dofs for node in part.nodes} for part in (membrane, bending)]
    nodes = tuple(
        Node(at, tuple(sorted((*found[0].get(at, ()), *found[1].get(at, ())), key=DOFS.index)))
        for at in places
    )
    places_of = [(node.at, dof) for node in nodes for dof in node.dofs]
    own = [(node.at, dof) for node in bending.nodes for dof in node.dofs]
    symbols = dict(zip(places_of, symbols_of(nodes), strict=True))
    renamed = {old: symbols[place] for old, place in zip(bending.unknowns, own, strict=True)}

    def spread(part: Element, functions: Sequence[sp.Expr]) -> tuple[sp.Expr, ...]:
        keys = [(node.at, dof) for node in part.nodes for dof in node.dofs]
        found = dict(zip(keys, functions, strict=True))
        return tuple(found.get(place, sp.Integer(0)) for place in places_of)

    slopes = bending.slopes
    if slopes and not bending.amounts:
        slopes = tuple(spread(bending, component) for component in slopes)
    return Element(
        f"{bending.name}+{membrane.name}",
        bending.cell,
        nodes,
        u=spread(membrane, membrane.u),
        v=spread(membrane, membrane.v),
        w=spread(bending, bending.w),
        slopes=slopes,
        degree=max(bending.degree, membrane.degree),
        source="; ".join(text for text in (bending.source, membrane.source) if text),
        geometry={**membrane.geometry, **bending.geometry},
        amounts=tuple(amount.xreplace(renamed) for amount in bending.amounts),
        shear=bending.shear,
    )
