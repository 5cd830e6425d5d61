"""Ways out of a singular position: the branches on which a mechanism can go on from where its closure loses rank.

In: a `LoopGeometry` and a closed position. Out: `Branch`es, by ratios of the joints' rates. Never: integrates.

Branches are the common zeros of the quadratic forms of the second order (`tangents`, `zeros`). Of many free rates not
all are looked for, but those near the rates that loads ask for are.
"""

import itertools
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass

import numpy as np

from lamc.basics.readonly import ReadOnlyDict
from lamc.loops.closing import CLOSED, SOLVE, settle
from lamc.loops.geometry import LoopGeometry
from lamc.loops.least_constraint import FEW, least_constrained
from lamc.loops.linear import EXACT
from lamc.loops.local_forms import LocalForms
from lamc.loops.tangents import EXACTLY, FEW_FREE, Fit, Tangents, tangents
from lamc.loops.walks import walk
from lamc.loops.zeros import MOST, arrivals, binary, spherical, usual
from lamc.records.mechanism import Array

OUT = 1e-3  # rad, of the joint that turns most: how far a start is moved out of a singular position
BENDS = (
    50.0  # 1/rad: a branch bends by some radians per square radian; farther from the tangent is another one
)
FAINT = 1e-5  # of the largest singular value: of loops that hold so little, accelerations have six digits
# Rad, of the joint that turns most: how far a start is moved for that, by at most so many steps.
FARTHEST, MOST_STEPS = 0.05, 12
LOOKS = 3  # steps from one look to the next at how weak the closure is, where one takes seconds
BENT = 0.1  # of such a step: what is farther from the tangent is another motion
# Of what single loads do along rates: as little is round-off of loads that balance one another.
BALANCED = 1e-9
ASKED = 4  # directions about those that loads ask for, where not all branches are known
ABOUT = 0.3  # of each rate: as far apart are these, so that what is alike in two creases does not stay so
# Of a sheet of one family: of more, each way to the cone takes a second, and the first one serves.
FEW_JOINTS = 100
# Directions about what loads ask for that are tried where a zero is a corner of its family; of many free rates.
CORNERS, FEW_CORNERS = 8, 1
# Random directions of many free rates: where these lead to corners, so do 30, as vertices of narrow facets hold little
# at any zero.
FEW_BACK = 8
# Free rates of a sheet: of more, each ascent along the cone takes up to ten seconds and leads to a corner, as loads ask
# for next to nothing of most creases; and to look at what is weak at a place takes up to five.
MANY_FREE = 450


@dataclass(frozen=True)
class Lead:
    """What loads do from rest at closed angles (n,), rad.

    asked  accelerations (n,) of the joints, rad/s², which hold the loops to first order
    work   along rates (k, n): their power (k,), W, their inertia (k, k), and the powers of single loads, added up by
           their sizes (k,): as round-off goes; None: the inertia of the bodies tells
    """

    asked: Callable[[Array], Array]
    work: Callable[[Array, Array], tuple[Array, Array, Array]] | None = None


@dataclass(frozen=True)
class Branch:
    """One way out of a singular position, and the opposite one.

    rates    joint name → rate relative to the largest, which is +1; in the order of the mechanism's joints
    freedoms 1 for a branch by itself; more for one of a family of as many freedoms, by an example
    """

    rates: Mapping[str, float]
    freedoms: int = 1

    def row(self, names: tuple[str, ...]) -> Array:
        """The rates as an array in the order of `names`."""
        return np.array([self.rates[name] for name in names])


def find_branches(
    geometry: LoopGeometry,
    angles: Array,
    fit: Fit = EXACTLY,
    local: Tangents | None = None,
    lead: Lead | None = None,
    rank: int | None = None,
) -> tuple[Branch, ...]:
    """The branches at a singular closed position, in the order of their rates; each was followed for a step.

    Empty where the second order does not tell branches apart. local: `tangents` there, if they are known. lead: the
    rates that loads ask for; where there are more branches than are looked for, those near them come last, and where
    branches are examples of families, the one of them all on which loads do most work. Of a sheet that goes on in one
    family, its example lies there. rank: of the closure on that family; None: any.
    """
    local = local or tangents(geometry, angles, fit)
    if not local.count:
        return ()
    if local.is_one_family:
        return _one_of_many(geometry, angles, local, lead, rank)
    known, of = geometry.lately(
        ("branches", angles.tobytes(), fit), lambda: _known(geometry, angles, local, fit)
    )
    found = list(known)
    are_more = local.basis.shape[1] > FEW_FREE or of >= MOST
    # Examples know of no loads. What nearly is a zero may lie amid families, where loops hold less than on each.
    in_families = fit is EXACTLY and any(branch.freedoms > 1 + local.loose for branch in known)
    if lead is not None and (are_more or in_families):
        pushed = _pushed(geometry, angles, local, lead, fit, by_work=not are_more)
        zeros = [(x, local.freedoms(x, fit.family)) for x in itertools.islice(pushed, 1)]
        if are_more:
            zeros += _near(local, lead.asked(angles), fit)
        asked = _followed(geometry, angles, local, zeros, fit)
        found += [branch for branch in asked if not any(_are_same(branch, other, fit) for other in found)]
    return tuple(found)


def _known(
    geometry: LoopGeometry, angles: Array, tangents: Tangents, fit: Fit
) -> tuple[tuple[Branch, ...], int]:
    """Branches without a look at loads, and of how many zeros they are those that lead out."""
    few = tangents.basis.shape[1] == 2
    zeros = binary(tangents.forms, fit) if few else spherical(tangents, tangents.basis, fit)
    digits = 7 if fit is EXACTLY else 1  # numbered alike, whatever the rounding of the drawing
    found = sorted(
        _followed(geometry, angles, tangents, zeros, fit),
        key=lambda b: (b.freedoms, [round(r, digits) + 0.0 for r in b.rates.values()]),
    )
    return tuple(found), len(zeros)


def _followed(
    geometry: LoopGeometry, angles: Array, tangents: Tangents, zeros: list[tuple[Array, int]], fit: Fit
) -> list[Branch]:
    """The branches of those zeros that lead out."""
    rows = [(_normalised(tangents.basis @ x, geometry.order, fit.same), freedoms) for x, freedoms in zeros]
    return [
        _branch(geometry, rates, freedoms)
        for rates, freedoms in rows
        if _leads_out(geometry, angles, rates, fit)
    ]


def _pushed(
    geometry: LoopGeometry, angles: Array, tangents: Tangents, lead: Lead, fit: Fit, *, by_work: bool
) -> Iterator[Array]:
    """Zeros (d,) on which loads do much work; by_work: of few free rates most of it first. Rates that no form holds are
    no way of their own, and are still, as they are where branches are compared."""
    inner, held = tangents.inner, tangents.held
    if by_work and lead.work is not None and inner.basis.shape[1] <= FEW:
        pull, inertia, single = lead.work(angles, inner.basis.T)
        if not (np.abs(pull) > BALANCED * single).any():
            return iter(())
    else:
        inertia = geometry.inertia(angles, tangents.basis.T)
        pull = held.T @ inertia @ (tangents.basis.T @ lead.asked(angles))
        inertia = held.T @ inertia @ held
    zeros = least_constrained(inner, inertia, pull, fit, by_work=by_work)
    return (held @ x for x in zeros)


def _near(tangents: Tangents, led: Array, fit: Fit) -> list[tuple[Array, int]]:
    """Zeros (d,) near rates (n,) that loads ask for, with the dimensions of their cones; each but once."""
    random = np.random.default_rng(20260107)
    wanted = led * (
        1.0 + ABOUT * np.append(np.zeros((1, len(led))), random.normal(size=(ASKED - 1, len(led))), 0)
    )
    if not np.abs(wanted @ tangents.basis).max() > 0.0:
        return []
    points = arrivals(tangents, wanted @ tangents.basis, fit)
    found: list[tuple[Array, int]] = []
    for point in points:
        zero, freedoms = usual(tangents, point, random, fit)
        if all(min(np.abs(zero - x).max(), np.abs(zero + x).max()) > fit.same for x, _ in found):
            found.append((zero, freedoms))
    return found


def _are_same(branch: Branch, other: Branch, fit: Fit) -> bool:
    return all(abs(branch.rates[name] - other.rates[name]) <= fit.same for name in branch.rates)


def _one_of_many(
    geometry: LoopGeometry, angles: Array, tangents: Tangents, lead: Lead | None, rank: int | None
) -> tuple[Branch, ...]:
    """An example of the family on which a flat sheet of many free rates goes on. No corner of it, where two parts of
    the family meet: what loads ask for alike of two lines that cross at a vertex leads there, as only one of them can
    fold, and next to a corner the closure is as weak as in the flat position. So corners come last, and of very many
    vertices, of which some hardly hold at any zero, the one of which they hold most comes first."""
    local, basis = tangents.local, tangents.basis
    assert local is not None
    free = basis.shape[1]
    usual_freedoms = max(1, free - tangents.loose - local.forms) + tangents.loose
    if rank is not None:
        usual_freedoms = basis.shape[0] - rank
    corners: list[tuple[float, int, Array]] = []
    for rates in itertools.chain(
        _led(geometry, angles, tangents, lead), _anywhere(geometry, angles, local, basis)
    ):
        if rates is None:
            continue
        held, freedoms = local.holds(basis, rates, usual_freedoms, EXACTLY.family)
        rates = _normalised(rates, geometry.order, EXACTLY.same)
        if freedoms > usual_freedoms:
            corners.append((held, freedoms, rates))
        elif _goes_on(geometry, angles, rates, rank):
            return (_branch(geometry, rates, freedoms),)
    for _, freedoms, rates in sorted(corners, key=lambda corner: (-corner[0], corner[1])):
        if _goes_on(geometry, angles, rates, rank):
            return (_branch(geometry, rates, freedoms),)
    return ()


def _led(
    geometry: LoopGeometry, angles: Array, tangents: Tangents, lead: Lead | None
) -> Iterator[Array | None]:
    """Rates (n,) that the second order allows where loads lead; None where one of them leads nowhere."""
    local, basis = tangents.local, tangents.basis
    assert local is not None
    if lead is None:
        return
    many = basis.shape[1] > MANY_FREE
    if not many:
        pushed = _pushed(geometry, angles, tangents, lead, EXACTLY, by_work=len(angles) <= FEW_JOINTS)
        yield from (basis @ x for x in pushed)
    led = lead.asked(angles)
    for beside in [0.0, *local.random[: FEW_CORNERS if many else CORNERS]]:
        yield local.nearest(basis, led * (1.0 + ABOUT * beside))


def _anywhere(
    geometry: LoopGeometry, angles: Array, local: LocalForms, basis: Array
) -> Iterator[Array | None]:
    """The same near random rates, which are the same each time they are asked for."""
    tries = local.random[:FEW_BACK] if basis.shape[1] > MANY_FREE else local.random
    for number, row in enumerate(tries * local.held):
        question = ("near random rates", angles.tobytes(), number)
        yield geometry.lately(question, lambda row=row: local.nearest(basis, row))  # type: ignore[misc]


def _goes_on(geometry: LoopGeometry, angles: Array, rates: Array, rank: int | None) -> bool:
    """Whether closed positions lie along rates (n,), on the family whose closure has a rank; None: on any. Sheets have
    families of lower rank beside, such as folds along straight lines all across."""
    place = moved_out(geometry, angles, rates)
    return place is not None and (rank is None or geometry.linear(place).rank() == rank)


def _branch(geometry: LoopGeometry, rates: Array, freedoms: int) -> Branch:
    names = [joint.name for joint in geometry.tree.mechanism.joints]
    by_name = dict(zip(geometry.names, rates.tolist(), strict=True))
    return Branch(ReadOnlyDict({name: by_name[name] for name in names}), freedoms)


def _leads_out(geometry: LoopGeometry, angles: Array, rates: Array, fit: Fit) -> bool:
    ways = (1.0,) if fit is EXACTLY else (1.0, -1.0)
    return any(moved_out(geometry, angles, way * rates, fit) is not None for way in ways)


def moved_out(geometry: LoopGeometry, angles: Array, rates: Array, fit: Fit = EXACTLY) -> Array | None:
    """The closed position (n,) that is OUT from a singular one along a branch, or farther where loops fit badly; None
    where none is near."""
    question = ("moved out", angles.tobytes(), rates.tobytes(), fit)
    place = geometry.lately(question, lambda: _moved_out(geometry, angles, rates, fit))
    return None if place is None else place.copy()


def _moved_out(geometry: LoopGeometry, angles: Array, rates: Array, fit: Fit) -> Array | None:
    held = int(np.argmax(np.abs(rates)))
    guess = angles + OUT / abs(rates[held]) * rates
    # Nearly, fading equations are as weak as a misfit is: the place stays open by the second order.
    cutoff = SOLVE if fit is EXACTLY else OUT * fit.weak
    # What of a misfit is weaker than all that large matrices tell apart is closed a little by each step: it creeps.
    enough = max(CLOSED, fit.zero * OUT**2 if fit is not EXACTLY else 0.0)
    place, error = settle(geometry, guess, np.arange(len(rates)) != held, cutoff, enough=enough)
    near = np.abs(place - guess).max() < BENDS * OUT**2
    if error <= enough and near:
        return place
    if fit is EXACTLY:
        return None
    places = walk(geometry, angles, rates, fit.weak, 1)  # farther out, where less is left of a misfit
    return places[0].angles if places else None


def clear_of(
    geometry: LoopGeometry, angles: Array, place: Array, cutoff: float = EXACT, most_open: float = CLOSED
) -> Array:
    """From a place (n,) beside a singular position on along its motion, until the closure is not as weak as next to
    that, or FARTHEST from there: of sheets of hundreds of creases, some vertices hardly fold while others do, and their
    equations are round-off. cutoff, most_open: what is no equation, and how far residuals may be open, of loops that
    fit badly."""
    if cutoff >= FAINT:  # all that is left holds more
        return place.copy()
    question = ("clear of", angles.tobytes(), place.tobytes(), cutoff, most_open)
    return geometry.lately(
        question, lambda: _clear_of(geometry, angles, place.copy(), cutoff, most_open)
    ).copy()


def _clear_of(geometry: LoopGeometry, angles: Array, place: Array, cutoff: float, most_open: float) -> Array:
    way, step, linear = place - angles, OUT, geometry.linear(place)
    free = linear.nullity(cutoff)
    looks = LOOKS if len(linear.weak[0]) > MANY_FREE else 1
    for number in range(MOST_STEPS):
        ahead, far = way, float(np.abs(place - angles).max())
        if far > 0.9 * FARTHEST:
            break
        if number % looks == 0:
            linear = geometry.linear(place).after(linear)
            motions, known = linear.free(cutoff), linear.weak[0]
            clear = float(known[free]) if free < len(known) else 1.0
            ahead = motions.T @ (motions @ way)
            if len(motions) != free or clear >= FAINT:
                break
        if not np.abs(ahead).max() > 0.0:
            break
        ahead = ahead * min(step, FARTHEST - far) / np.abs(ahead).max()
        held = int(np.argmax(np.abs(ahead)))
        following, error = settle(geometry, place + ahead, np.arange(len(place)) != held, max(cutoff, SOLVE))
        near = np.abs(following - place - ahead).max() < BENT * np.abs(ahead).max()
        if error <= most_open and near:
            way, place, step = following - place, following, 2.0 * step
        else:
            step *= 0.5
    return place


def _normalised(rates: Array, order: list[int], same: float) -> Array:
    """Rates over the largest; of several of that size the first joint's is +1. Round-off becomes zero."""
    largest = float(np.abs(rates).max())
    lead = next(index for index in order if abs(rates[index]) > (1.0 - same) * largest)
    scaled = rates / (largest * np.sign(rates[lead]))
    return np.where(np.abs(scaled) < 1e-13, 0.0, scaled)
