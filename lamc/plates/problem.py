"""A plate problem: a mesh, what it is made of, how it is held, what acts on it.

In: records that a user makes. Out: the same, checked against each other, with the element that they call for. Never:
assembles or solves; `model.py` does.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from lamc.basics.brief import brief, counted
from lamc.basics.checks import checked_name, checked_number, shown
from lamc.basics.errors import DesignError, about
from lamc.basics.seen import Viewable
from lamc.plates.dofs import Dofs
from lamc.plates.edge_parts import edge_parts_on
from lamc.plates.elements.definition import TRIANGLE, Element
from lamc.plates.elements.library import checked_element, combine, element
from lamc.plates.followed import check_followed
from lamc.plates.foundations import ElasticFoundation
from lamc.plates.hinge_lines import HingeLine, hinge_edges
from lamc.plates.laminates.climate import climates, pulls
from lamc.plates.laminates.laminate import Laminate
from lamc.plates.laminates.sections import couples
from lamc.plates.loads import LOADS, EdgeLoad, EdgeMoment, LoadRecord, PointLoad, Pressure, SelfWeight
from lamc.plates.locator import MeshLocator
from lamc.plates.meshing.mesh import Integers, Mesh
from lamc.plates.mirrors import check_mirror
from lamc.plates.pinches import check_pinches
from lamc.plates.supports import SUPPORTS, Hinged, Support, SupportRecord, Symmetry, support_text, where_text

_COMPANIONS = {TRIANGLE: "cst"}  # what an element that only bends takes for the plane; "q4" for squares
_IN_PLANE = ("u", "v")


@dataclass(frozen=True, eq=False)
class Problem(Viewable):
    """A plate, its supports and its loads.

    mesh       cells, and the regions they belong to
    laminate   one for all regions, or one for each by name
    element    a name of `plate.ELEMENTS`, two joined by "+" ("dkt+lst"), or an Element. One that only bends gets a
               membrane by itself ("dkt" becomes "dkt+cst") where a laminate couples bending and stretching (B is not
               zero), and where supports or loads concern the plane
    supports   records of `supports.py`
    loads      records of `loads.py`; they act in every case
    cases      more loads by the name of a case; they are solved together
    tolerance  of `where`, over the mesh's size (the diagonal of its bounding box)
    hinges     records of `hinge_lines.py`: lines inside the plate along which it may fold
    foundations  records of `foundations.py`: elastic ground under the plate
    remarks    sentences that are reported with every solution, such as why this element

    laminates  (regions,), in the order of the mesh's regions
    dofs       unknowns of the element that was chosen: `problem.dofs.element`

    Raises DesignError where anything is missing, unknown, or touches nothing.
    """

    mesh: Mesh
    laminate: Laminate | Mapping[str, Laminate]
    element: str | Element = "dkt"
    supports: Sequence[SupportRecord] = ()
    loads: Sequence[LoadRecord] = ()
    cases: Mapping[str, Sequence[LoadRecord]] = field(default_factory=dict)
    tolerance: float = 1e-6
    hinges: Sequence[HingeLine] = ()
    foundations: Sequence[ElasticFoundation] = ()
    remarks: Sequence[str] = ()
    laminates: tuple[Laminate, ...] = field(init=False, repr=False)
    dofs: Dofs = field(init=False, repr=False)
    places: MeshLocator = field(init=False, repr=False)
    hinge_edges: tuple[Integers, ...] = field(
        init=False, repr=False
    )  # of each hinge, numbers of `mesh.edges`

    def __post_init__(self) -> None:
        if not isinstance(self.mesh, Mesh):
            raise DesignError(
                f"the mesh of a Problem is {shown(self.mesh)}; make one by plate.grid or plate.mesh"
            )
        self._put("tolerance", checked_number(self.tolerance, "the tolerance of a Problem", minimum=0.0))
        self._put("supports", checked_kinds(self.supports, SUPPORTS, "supports of a Problem"))
        self._put("loads", checked_kinds(self.loads, LOADS, "loads of a Problem"))
        self._put("cases", _checked_cases(self.cases))
        self._put("laminates", laminates_of(self.laminate, self.mesh))
        self._put("remarks", tuple(self.remarks))
        self._put("hinges", checked_kinds(self.hinges, (HingeLine,), "hinges of a Problem"))
        found = checked_kinds(self.foundations, (ElasticFoundation,), "foundations of a Problem")
        self._put("foundations", found)
        self._number(Dofs(self.mesh, self._chosen_element()))
        if found and not self.dofs.element.bends:
            raise DesignError(
                f"an ElasticFoundation holds deflections, and element {self.dofs.element.name!r} has none; choose one "
                "that bends"
            )
        self._put("hinge_edges", hinge_edges(self.places, self.hinges))
        if self.hinges:
            lines = np.unique(np.concatenate(self.hinge_edges))
            self._number(Dofs(self.mesh, self.dofs.element, lines))
        check_pinches(self.mesh)
        for support in self.supports:
            with about(support):
                self._check_support(support)
        for load in self.all_loads:
            with about(load):
                check_load(self, load)

    def _put(self, name: str, value: Any) -> None:
        object.__setattr__(self, name, value)

    def _number(self, dofs: Dofs) -> None:
        self._put("dofs", dofs)
        self._put("places", MeshLocator(dofs, self.tolerance * self.size))

    def __repr__(self) -> str:
        return brief(
            "Problem",
            "",
            f"element {self.dofs.element.name!r}",
            counted(len(self.mesh.cells), "cell"),
            counted(len(self.supports), "support"),
            counted(len(self.loads), "load"),
            counted(len(self.cases), "case") if self.cases else "",
        )

    @property
    def all_loads(self) -> tuple[LoadRecord, ...]:
        """Those of every case, then those of each."""
        return (*self.loads, *(load for case in self.cases.values() for load in case))

    def with_laminate(self, laminate: Laminate | Mapping[str, Laminate]) -> "Problem":
        """The same with other laminates. Raises DesignError where they call for another element, or where a symmetry
        does not mirror them."""
        other = object.__new__(Problem)
        vars(other).update(vars(self))
        other._put("laminate", laminate)
        other._put("laminates", laminates_of(laminate, self.mesh))
        chosen = other._chosen_element()
        if chosen.name != self.dofs.element.name:
            raise DesignError(
                f"these laminates call for element {chosen.name!r}, and the model has {self.dofs.element.name!r}; "
                "make a new Problem"
            )
        for support in self.supports:
            if isinstance(support, Symmetry):
                check_mirror(self.places, other.laminates, support.where)
        return other

    @property
    def size(self) -> float:
        """Of the mesh: the diagonal of its bounding box, m."""
        return float(np.hypot(*np.ptp(self.mesh.points, axis=0)))

    def _chosen_element(self) -> Element:
        chosen = checked_element(self.element)
        if chosen.bends and not chosen.stretches and self._concerns_plane():
            return combine(chosen, element(_COMPANIONS.get(chosen.cell, "q4")))
        return chosen

    def _concerns_plane(self) -> bool:
        return (
            any(couples(laminate) for laminate in self.laminates)
            or any(_holds_plane(support) for support in self.supports)
            or any(self._pulls_plane(load) for load in self.all_loads)
        )

    def _pulls_plane(self, load: LoadRecord) -> bool:
        if isinstance(load, PointLoad | EdgeLoad):
            return any(_vector(load.force)[:2])
        if isinstance(load, SelfWeight):
            return any(load.acceleration[:2])
        if isinstance(load, Pressure | EdgeMoment):
            return False
        found = climates(self.laminates, [load], self.mesh.region_names)
        return any(pulls(laminate, own) for laminate, own in zip(self.laminates, found, strict=True))

    def _check_support(self, support: SupportRecord) -> None:
        what = support_text(support)
        nodes = self.places.nodes(support.where, what)
        check_followed(self.places, support.where, what)
        if isinstance(support, Symmetry):
            self.places.checked_edges_on(support.where, what)
            check_mirror(self.places, self.laminates, support.where)
        if isinstance(support, Hinged) and support.stiffness > 0.0:
            cells, local = edge_parts_on(self.places, support.where, what).edges.T
            if np.isin(self.mesh.cell_edges[cells, local], self.dofs.hinges).any():
                raise DesignError(
                    f"{what} at {where_text(support.where)} has a stiffness and lies along a HingeLine, whose sides "
                    "turn apart; give the stiffness to the HingeLine, and hold the line by a Hinged support without one"
                )
        if isinstance(support, Support):
            missing = [name for name in support.dofs if name not in self.dofs.names]
            if missing:
                raise DesignError(
                    f"a Support holds {missing[0]!r}, which element {self.dofs.element.name!r} does not have (it has "
                    f"{', '.join(self.dofs.names)}); leave it out, or choose another element"
                )
            there = [self.dofs.of(name)[nodes] >= 0 for name in support.dofs]
            for name, has in zip(support.dofs, there, strict=True):
                if not has.any():
                    raise DesignError(
                        f"a Support holds {name!r} at {where_text(support.where)}, and none of the {len(nodes)} nodes "
                        f"there has it: element {self.dofs.element.name!r} has it at corners of cells only; move it to "
                        "one, or leave it out"
                    )


def check_load(problem: Problem, load: LoadRecord) -> None:
    """Raises DesignError where `load` touches nothing, names no region, or pulls where the element has no unknown."""
    region = getattr(load, "region", None)
    if region is not None and region not in problem.mesh.region_names:
        raise DesignError(
            f"a {type(load).__name__} acts on region {region!r}, which the mesh does not have; it has "
            f"{', '.join(repr(name) for name in problem.mesh.region_names)}"
        )
    chosen = problem.dofs.element
    if isinstance(load, EdgeLoad | EdgeMoment):
        edge_parts_on(problem.places, load.where, f"the {type(load).__name__}")
    across = isinstance(load, Pressure | EdgeMoment) or (
        isinstance(load, PointLoad | EdgeLoad) and _vector(load.force)[2] != 0.0
    )
    if across and not chosen.bends:
        raise DesignError(
            f"a {type(load).__name__} acts across the plate, and element {chosen.name!r} has no deflection; choose one "
            f"that bends, such as 'dkt+{chosen.name}'"
        )
    if problem._pulls_plane(load) and not chosen.stretches:
        raise DesignError(
            f"a {type(load).__name__} acts in the plane, and element {chosen.name!r} of the model only bends; give it "
            "with the problem, or choose an element with a membrane, such as 'dkt+cst'"
        )


def laminates_of(laminate: Laminate | Mapping[str, Laminate], mesh: Mesh) -> tuple[Laminate, ...]:
    """One per region of the mesh. Raises DesignError, naming the region, where one has none."""
    names = mesh.region_names
    if isinstance(laminate, Laminate):
        return (laminate,) * len(names)
    if not isinstance(laminate, Mapping):
        raise DesignError(
            f"the laminate of a Problem is {shown(laminate)}; it must be a Laminate, or one by region: "
            f"{{{names[0]!r}: Laminate(…)}}"
        )
    for name, value in laminate.items():
        if name not in names:
            raise DesignError(
                f"a laminate is given for region {shown(name)}, which the mesh does not have; it has "
                f"{', '.join(repr(n) for n in names)}"
            )
        if not isinstance(value, Laminate):
            raise DesignError(f"the laminate of region {name!r} is {shown(value)}; it must be a Laminate")
    for name in names:
        if name not in laminate:
            raise DesignError(
                f"region {name!r} of the mesh has no laminate; give one: laminate={{{name!r}: …}}"
            )
    return tuple(laminate[name] for name in names)


def checked_kinds(values: Any, kinds: tuple[type, ...], what: str) -> tuple[Any, ...]:
    """`values` as a tuple of records of any of `kinds`, or DesignError."""
    names = ", ".join(kind.__name__ for kind in kinds)
    if isinstance(values, kinds):
        raise DesignError(f"{what} are a single {type(values).__name__}; put it into a list")
    if isinstance(values, Mapping | str | bytes) or not hasattr(values, "__iter__"):
        raise DesignError(f"{what} are {shown(values)}; they must be a list of {names}")
    items = tuple(values)
    for item in items:
        if not isinstance(item, kinds):
            raise DesignError(f"{what} hold {shown(item)}; each must be one of {names}")
    return items


def _checked_cases(cases: Any) -> dict[str, tuple[LoadRecord, ...]]:
    if not isinstance(cases, Mapping):
        raise DesignError(
            f"cases of a Problem are {shown(cases)}; they must be loads by name: {{'wind': [Pressure(5.0)]}}"
        )
    return {
        checked_name(name, "a case of a Problem"): checked_kinds(loads, LOADS, f"loads of case {shown(name)}")
        for name, loads in cases.items()
    }


def _holds_plane(support: SupportRecord) -> bool:
    return isinstance(support, Support) and any(name in _IN_PLANE for name in support.dofs)


def _vector(force: Any) -> tuple[float, float, float]:
    return force  # type: ignore[no-any-return]  # a record has made it three numbers
