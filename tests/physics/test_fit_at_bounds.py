"""Intervals of a fit some of whose numbers stand at bounds: they hold what they say."""

import math
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

import lamc
from lamc.fitting.bounded import within_bounds
from lamc.fitting.unknowns import Unknown, Unknowns
from lamc.records.mechanism import Array
from lamc.records.recording import Free
from lamc.report.fit_text import interval_text
from tests.support.ctools import needs_cc

LEG = """units: mm
parameters:
  length: {default: 40 mm, min: 20 mm, max: 80 mm}
materials: {card: {density: 700, rigid: true}, film: {density: 1390, E1: 2.5 GPa, poisson: 0.34, flexible: true}}
layers:
  - {name: low, material: card, thickness: 0.3}
  - {name: hinge, material: film, thickness: 25 um}
  - {name: high, material: card, thickness: 0.6}
shapes: [{rect: [-20, 0, length, length/2]}]
hinges: [{name: knee, line: [[0, 0], [0, length/2]], layer: hinge, gap: 0.8, stiffness: from-material, damping: 1e-7}]
fixed: [{rect: [-20, 0, -10, length/2]}]
scene: {angles: {knee: 30 deg}}
"""
LENGTH, DAMPING, NOISE = 47e-3, 3e-7, 3e-3  # m, N m s/rad, rad


def of_two(log: bool, low: float, high: float, at: float) -> Unknowns:
    first = Unknown("a", "gain", "a", "1", Free(-math.inf, math.inf), 1.0)
    return Unknowns((first, Unknown("b", "parameter", "b", "1", Free(low, high), at, log)))


@pytest.mark.parametrize(("low", "high", "at"), [(1.0, 100.0, 1.0), (1.0, 1.5, 1.0), (1e-3, 2.0, 2.0)])
@pytest.mark.parametrize("log", [False, True])
def test_an_interval_is_the_profile_over_what_is_within(
    low: float, high: float, at: float, *, log: bool
) -> None:
    """Of a linear model with residuals r + A (Δa, Δb), searched through, b from bound to bound."""
    random = np.random.default_rng(3)
    columns = random.normal(size=(40, 1)) @ [[1.0, 0.6]] + 0.1 * random.normal(size=(40, 2))
    inward = 1.0 if at == low else -1.0
    pull = columns[:, 1] - columns[:, 0] * (columns[:, 0] @ columns[:, 1]) / (columns[:, 0] @ columns[:, 0])
    residual = inward * 0.4 * pull + 0.0  # its slope along b points out of the range, along a it has none
    unknowns, sizes = of_two(log, low, high, at), np.array([1.0, 1.0])
    inner = np.array([0.0, math.log(at) if log else at])
    by_solver = columns * [1.0, at if log else 1.0]
    inverse = np.array([1.0 / (columns[:, 0] @ columns[:, 0]), np.nan])
    reach = 2.0 * math.sqrt(inverse[0]) * 0.5
    rows = np.column_stack([by_solver, residual])
    held = np.array([False, True])
    down, up = within_bounds(unknowns, inner, sizes, rows, np.array([reach, np.inf]), inverse, held)[0]

    # Searched through: at each change of a the least sum over b.
    changes = np.linspace(low, high, 4001) - at

    def rise(a: float) -> float:
        sums = np.square(residual[:, None] + columns[:, :1] * a + columns[:, 1:] * changes).sum(axis=0)
        return float(sums.min() - residual @ residual)

    allowed = reach**2 / inverse[0]
    for end, sign in ((down, -1.0), (up, 1.0)):
        assert end >= reach * (1.0 - 1e-9)
        # The grid of b is off by 1e-3 of a step, which the sum feels as its square.
        assert rise(sign * end * (1.0 - 1e-3)) <= allowed * (1.0 + 1e-3)
        assert rise(sign * end * (1.0 + 1e-3)) >= allowed * (1.0 - 1e-3)
    assert max(down, up) > 1.05 * reach  # b moves


def leg(folder: Path) -> lamc.Design:
    (folder / "leg.yaml").write_text(LEG)
    made = lamc.load(folder / "leg.yaml")
    assert isinstance(made, lamc.Design)
    return made


@pytest.mark.slow
@needs_cc
def test_a_number_at_its_bound_may_be_within_for_the_others(tmp_path: Path) -> None:
    """Length and damping are told together by these data; where noise takes damping to its bound, the interval of the
    length held the true one in no case."""
    design, t = leg(tmp_path), np.linspace(0.0, 0.08, 80)
    true = lamc.compile(design.with_parameters(length=LENGTH)).run(
        t_end=t[-1], t_eval=t, parameters={"knee.damping": DAMPING}
    )
    found: dict[bool, list[bool]] = {False: [], True: []}
    for seed in range(12):
        noisy: Array = true.angle("knee") + NOISE * np.random.default_rng(seed).normal(size=len(t))
        fit = lamc.fit(
            design,
            [lamc.Recording(t, {"knee": noisy})],
            {"length": (0.03, 0.07), "knee.damping": (1e-8, 1e-5)},
        )
        low, high = fit.intervals["length"]
        is_held = "knee.damping" in fit.account.at_bounds
        assert (
            any("intervals of the others allow for its being within" in note for note in fit.notes) == is_held
        )
        found[is_held].append(low <= LENGTH <= high)
    assert len(found[True]) >= 2
    assert all(found[True])
    assert all(found[False])


@pytest.mark.parametrize(
    ("ends", "text"),
    [
        ((math.nan, math.nan), "at its bound"),
        ((-math.inf, math.inf), "any"),
        ((0.0, math.inf), "any"),
        ((-math.inf, 0.002), "at most 2 mm"),
        ((0.002, math.inf), "at least 2 mm"),
        ((0.002, 0.003), "2 mm … 3 mm"),
    ],
)
def test_an_interval_of_one_end_says_it(ends: tuple[float, float], text: str) -> None:
    fit = SimpleNamespace(intervals={"a": ends}, units={"a": "m"})
    assert interval_text(fit, "a") == text  # type: ignore[arg-type]
