"""How well a fit knows its numbers: covariance, intervals, correlations, and what the data cannot tell.

In: residuals and their Jacobian at the optimum. Out: an `Account`. Intervals are those of Student's t for the
linearised model (Seber & Wild, Nonlinear Regression, 1989, ch. 5), of logarithms where logarithms are sought; where
numbers stand at bounds, of its profile (`bounded`). With a robust loss the covariance is Huber's (1981, ch. 7). What
cannot be told is a direction of the unknowns along which the singular values of the Jacobian vanish, or in which noise
leaves more than the numbers themselves.
"""

import math
from dataclasses import dataclass
from itertools import combinations

import numpy as np

from lamc.fitting.bounded import within_bounds
from lamc.fitting.losses import weights_of
from lamc.fitting.trust import triangle_of
from lamc.fitting.unknowns import Unknown, Unknowns
from lamc.run.request import Array

LEVEL = 0.95
_LOST = (
    3.0  # standard errors along a direction, of the numbers' sizes, beyond which it is as good as not told
)
_VAGUE = 1.0  # of a number's size: it may be twice as large, or nothing
_PART = 0.05  # of the largest change of the data by one number along a direction, below which it has no part
_SHARE = 1e-3  # of the largest share of a direction: what is as good as none, however much it is felt
# Of the largest share: who changes as much along a direction is told no better than the others there, however little
# the data feel it, unless that is as little as the Jacobian's errors: so many times these are none of them.
_ALONG, _ABOVE = 0.1, 10.0
_SNAP = 0.02  # of an exponent: to whole numbers and halves
_ALIKE = 1e-3  # of shares: of two numbers that are as large, a product and a sum change alike
_AT_BOUND = 1e-6  # of a range


@dataclass(frozen=True)
class Combination:
    """What the data cannot tell apart. names; shares: of each, along the direction; text: in words."""

    names: tuple[str, ...]
    shares: tuple[float, ...]
    text: str

    def __str__(self) -> str:
        return self.text


@dataclass(frozen=True, eq=False)
class Account:
    """errors: standard errors (p,) of the solver's vector, inf where nothing is known; intervals (p, 2) of the values;
    correlations (p, p), NaN where there are none; at_bounds: names of those that stand at a bound."""

    errors: Array
    intervals: Array
    correlations: Array
    unidentifiable: tuple[Combination, ...]
    at_bounds: tuple[str, ...]
    noise: float  # standard deviation of weighted residuals
    freedom: int  # data less unknowns


def account_of(
    unknowns: Unknowns, inner: Array, residual: Array, jacobian: Array, loss: str, known_to: float
) -> Account:
    """residual (N,), jacobian (N, p): weighted, at the optimum `inner` (p,). known_to: errors of the Jacobian, of its
    size: a singular value below that is none."""
    p = len(inner)
    low, high = unknowns.bounds
    held = _held(inner, low, high)
    free = np.flatnonzero(~held)
    freedom = max(len(residual) - len(free), 1)
    weights, curves = weights_of(residual, loss)
    noise = math.sqrt(float(np.sum(weights * residual**2)) / freedom)
    sizes = np.array([_size(u, x) for u, x in zip(unknowns.all, inner, strict=True)])
    scaled = np.sqrt(curves)[:, None] * jacobian * sizes
    pushed = scaled * (weights * residual / np.sqrt(curves))[:, None] if loss != "linear" else None
    triangle = triangle_of(scaled[:, free])
    _, singular, right = np.linalg.svd(triangle)
    unknown = known_to * float(singular.max(initial=0.0))
    null = singular <= max(unknown, noise / _LOST)
    felt = np.linalg.norm(triangle, axis=0)
    found = _combinations(unknowns, inner, free, right[null], sizes, felt, _ABOVE * unknown)
    kept = right[~null]
    spread = (kept.T / singular[~null] ** 2) @ kept
    covariance = np.full((p, p), np.nan)
    inside = (
        spread * noise**2
        if pushed is None
        else spread @ (pushed[:, free].T @ pushed[:, free]) @ spread * len(residual) / freedom
    )
    covariance[np.ix_(free, free)] = inside * np.outer(sizes[free], sizes[free])
    errors = np.sqrt(np.diagonal(covariance)).copy()
    reached = _reached(unknowns.all, inner, (low, high), sizes)[free]
    hidden = sizes[free] * _hidden(right[null], singular[null], felt, noise, unknown, reached)
    errors[free] = np.where(hidden > _LOST * sizes[free], np.inf, np.hypot(errors[free], hidden))
    lost = {name for each in found for name in each.names}
    errors[[k for k in free if unknowns.names[k] in lost]] = np.inf
    found += _vague(unknowns, inner, free, errors, lost)
    with np.errstate(invalid="ignore", divide="ignore"):
        correlations = covariance / np.outer(
            np.sqrt(np.diagonal(covariance)), np.sqrt(np.diagonal(covariance))
        )
    names = tuple(n for n, h in zip(unknowns.names, held, strict=True) if h)
    reach = _reach(errors, freedom)
    reaches = np.column_stack([reach, reach])
    if held.any():
        rows = np.column_stack([scaled, weights * residual / np.sqrt(curves)])
        inverse = np.full(p, np.nan)
        inverse[free] = np.diagonal(spread)
        within = within_bounds(unknowns, inner, sizes, rows, reach / sizes, inverse, held)
        reaches = within * sizes[:, None]
    intervals = _intervals(unknowns, inner, reaches, held)
    return Account(errors, intervals, correlations, tuple(found), names, noise, freedom)


def _hidden(null: Array, singular: Array, felt: Array, noise: float, unknown: float, reached: Array) -> Array:
    """Standard errors (f,), of the numbers' sizes, by directions (d, f) that count as not told, whose singular values
    are (d,); infinite along those that are nil, as far as these are known: up to `unknown`.

    reached: (f,), how far each may go within its bounds, of its size. Who has a small share of a direction goes as far
    as the one with the largest may.
    """
    if not null.size:  # all is told, or nothing is free
        return np.zeros(null.shape[1])
    sizes = np.abs(null)
    real = sizes * felt > _ABOVE * unknown
    with np.errstate(divide="ignore", invalid="ignore"):
        along = np.where(singular > unknown, noise / singular, np.inf)[:, None]
        bounded = sizes / sizes.max(axis=1, keepdims=True) * 0.5 * reached[np.argmax(sizes, axis=1)][:, None]
        parts = np.where(sizes > _SHARE, sizes * along, np.minimum(sizes * along, bounded))
        return np.asarray(np.sqrt(np.sum(np.where(real, parts, 0.0) ** 2, axis=0)))


def _reached(unknowns: tuple[Unknown, ...], inner: Array, bounds: tuple[Array, Array], sizes: Array) -> Array:
    """How far numbers may go within their bounds (p,), of their sizes; of those sought by logarithms in their value."""
    low, high = bounds
    is_log = np.array([u.log for u in unknowns], dtype=bool)
    with np.errstate(over="ignore", invalid="ignore"):
        far = np.maximum(high - inner, inner - low) / sizes
        grown = np.maximum(np.expm1(high - inner), -np.expm1(low - inner))
    return np.asarray(np.where(is_log, grown, far))


def _held(inner: Array, low: Array, high: Array) -> "np.ndarray[tuple[int], np.dtype[np.bool_]]":
    with np.errstate(invalid="ignore"):
        width = np.where(np.isfinite(high - low), high - low, np.maximum(np.abs(inner), 1.0))
    return np.asarray((inner - low <= _AT_BOUND * width) | (high - inner <= _AT_BOUND * width))


def _size(unknown: Unknown, inner: float) -> float:
    """The change of the solver's number that counts as one: of logarithms one, else of the number's own size."""
    return (
        1.0
        if unknown.log
        else (
            abs(inner)
            if unknown.kind in ("parameter", "dimension", "gain", "scale") and inner
            else unknown.size
        )
    )


def _reach(errors: Array, freedom: int) -> Array:
    """How far intervals go from the middle (p,)."""
    from scipy.special import stdtrit  # `import lamc` does without it

    return np.asarray(float(stdtrit(freedom, 0.5 + 0.5 * LEVEL)) * errors)


def _intervals(
    unknowns: Unknowns,
    inner: Array,
    reaches: Array,
    held: "np.ndarray[tuple[int], np.dtype[np.bool_]]",
) -> Array:
    """reaches (p, 2): downwards and upwards."""
    found = np.zeros((len(inner), 2))
    for k, each in enumerate(unknowns.all):
        down, up = reaches[k].tolist()
        if held[k]:
            found[k] = np.nan
        elif math.isinf(down) and math.isinf(up):
            found[k] = (0.0, math.inf) if each.log else (-math.inf, math.inf)
        else:
            lowest = 0.0 if each.log else -math.inf
            found[k] = (
                lowest if math.isinf(down) else each.value(inner[k] - down),
                math.inf if math.isinf(up) else each.value(inner[k] + up),
            )
    return found


def _vague(
    unknowns: Unknowns,
    inner: Array,
    free: "np.ndarray[tuple[int], np.dtype[np.intp]]",
    errors: Array,
    lost: set[str],
) -> list[Combination]:
    """Numbers that noise leaves no digit of."""
    found = []
    for k in free:
        each = unknowns.all[k]
        size = _size(each, float(inner[k]))
        if (
            each.name not in lost
            and np.isfinite(errors[k])
            and errors[k] > _VAGUE * size
            and each.kind in ("parameter", "dimension")
        ):
            share = errors[k] / size
            text = (
                f"{each.name} is hardly told by these data: its standard error is {share:.2g} times its size"
            )
            found.append(Combination((each.name,), (1.0,), text))
    return found


def _combinations(
    unknowns: Unknowns,
    inner: Array,
    free: "np.ndarray[tuple[int], np.dtype[np.intp]]",
    null: Array,
    sizes: Array,
    felt: Array,
    least: float,
) -> list[Combination]:
    """Directions (d, f) without effect, each with as few unknowns as can be, in words. felt: (f,), of each unknown by
    the data: along such a direction changes of the data cancel, and who takes part is who changes them, by `least` at
    least, which is above the errors of what is felt."""
    found = []
    for direction in _sparse(null):
        changes = np.abs(direction) * felt
        shares = np.abs(direction) / float(np.max(np.abs(direction)))
        much = (changes > _PART * float(np.max(changes))) & (shares > _SHARE)
        part = much | ((changes > least) & (shares > _ALONG)) | (shares == 1.0)
        at = free[part]
        values = unknowns.values(inner)[at]
        chosen = [unknowns.all[k] for k in at]
        relative = direction[part] * np.array(
            [
                1.0 if u.log else sizes[k] / v if v else np.inf
                for u, k, v in zip(chosen, at, values, strict=True)
            ]
        )
        plain = (
            direction[part]
            * sizes[at]
            * np.array([v if u.log else 1.0 for u, v in zip(chosen, values, strict=True)])
        )
        names = tuple(u.name for u in chosen)
        text = _words(names, relative, plain, is_one_unit=len({u.unit for u in chosen}) == 1)
        found.append(Combination(names, tuple(direction[part].tolist()), text))
    return found


def _sparse(null: Array) -> list[Array]:
    """A basis of the same space by elimination with full pivoting: rows with as few numbers as can be."""
    rows = null.copy()
    done: list[int] = []
    for k in range(len(rows)):
        rest = np.abs(rows[k:].copy())
        rest[:, done] = 0.0
        at = np.unravel_index(int(np.argmax(rest)), rest.shape)
        pivot, column = k + int(at[0]), int(at[1])
        rows[[k, pivot]] = rows[[pivot, k]]
        rows[k] /= rows[k, column]
        for other in range(len(rows)):
            if other != k:
                rows[other] -= rows[other, column] * rows[k]
        done.append(column)
    return list(rows)


def _words(names: tuple[str, ...], shares: Array, plain: Array, *, is_one_unit: bool = True) -> str:
    """shares: relative changes along the direction; plain: changes, in SI units, of which sums are made if they are
    one."""
    whole = " and ".join([", ".join(names[:-1]), names[-1]]) if len(names) > 1 else names[0]
    if len(names) == 1:
        return f"{whole}: these data say nothing of it"
    (ratio, off), (difference, apart) = _snapped(shares), _snapped(plain)
    if len(names) == 2:
        kinds = {-1.0: "sum", 1.0: "difference"}
        kind = kinds.get(difference[1] / difference[0]) if difference is not None and is_one_unit else None
        if ratio is not None and kind is not None and max(off, apart) < _ALIKE:
            if abs(ratio[0]) == abs(ratio[1]):
                power = _of_two(names, ratio)
                return f"{whole}: only their {power} or {kind}, which are alike here, as both are as large"
            return f"{whole}: only their {kind}, or {_of_two(names, ratio)}: they are alike here"  # a sum of 2 and 1
        if kind is not None and apart < off:  # it misses the changes by less
            return f"{whole}: only their {kind}"
        if ratio is not None:
            return f"{whole}: only their {_of_two(names, ratio)}"
        a, b = plain[1] / plain[0], 1.0
        return f"{whole}: only {a:+.3g} · {names[0]} {-b:+.3g} · {names[1]} (here, in SI units)"
    if ratio is not None and len(set(ratio)) == 1:
        return f"{whole}: only their ratios"
    if ratio is not None:
        told = [f"{n} to the power of {each:g}" for n, each in zip(names, ratio, strict=True)]
        return (
            f"{whole}: all of them may grow together, {', '.join(told)} (here); "
            f"{len(names) - 1} combinations are told"
        )
    return f"{whole}: only {len(names) - 1} combinations of the {len(names)}"


def _of_two(names: tuple[str, ...], ratio: tuple[float, ...]) -> str:
    a, b = ratio
    if a == -b:
        return "product"
    if a == b:
        return "ratio"
    first = -b / a  # names[0]**first * names[1] stays
    if first > 0.0:
        return f"product {names[0]}^{first:.3g} · {names[1]} (here)"
    return f"ratio {names[1]} / {names[0]}^{-first:.3g} (here)"


def _snapped(shares: Array) -> tuple[tuple[float, ...] | None, float]:
    """Small whole numbers in the ratio of shares, and how far off these are; None where there are none."""
    if not np.isfinite(shares).all() or not np.all(shares):
        return None, np.inf
    for unit in sorted(np.abs(shares)):
        for part in (1.0, 0.5):
            found = shares / (unit * part)
            whole = np.round(found)
            if (
                np.all(np.abs(found - whole) <= _SNAP * np.maximum(np.abs(whole), 1.0))
                and np.max(np.abs(whole)) <= 4.0
                and np.all(whole)
            ):
                return tuple(float(each) for each in whole), float(np.abs(found / whole - 1.0).max())
    return None, np.inf


def correlated(
    names: tuple[str, ...], correlations: Array, above: float = 0.95
) -> list[tuple[str, str, float]]:
    """Pairs that the data tell apart with difficulty."""
    return [
        (names[i], names[j], float(correlations[i, j]))
        for i, j in combinations(range(len(names)), 2)
        if np.isfinite(correlations[i, j]) and abs(correlations[i, j]) > above
    ]
