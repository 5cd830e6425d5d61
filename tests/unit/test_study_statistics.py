"""What a table says of its measures: quantiles, and Sobol' indices of a function whose indices are known."""

import math

import numpy as np
import pytest

from lamc.basics.readonly import ReadOnlyDict
from lamc.studies.axes import axis_of
from lamc.studies.bench import OK, STATUSES
from lamc.studies.plans import grid_of, sampled
from lamc.studies.statistics import indices, quantiles
from lamc.studies.table import Table


def table(plan, values) -> Table:
    statuses = np.full(plan.count, STATUSES.index(OK), dtype=np.uint8)
    units = {**dict.fromkeys(plan.names, "1"), "f": "1"}
    return Table(plan, ReadOnlyDict(units), {"f": values}, statuses, {}, "none")


def test_sobol_indices_of_ishigamis_function():
    """Ishigami and Homma (1990), with a = 7, b = 0.1: closed forms of the variances."""
    a, b = 7.0, 0.1
    axes = {name: axis_of(name, f"uniform({-math.pi}, {math.pi})", "1") for name in ("x", "y", "z")}
    plan = sampled(axes, "saltelli", 4096, 1)
    x, y, z = plan.values.T
    shares = indices(table(plan, np.sin(x) + a * np.sin(y) ** 2 + b * z**4 * np.sin(x)))["f"]
    by_x = 0.5 * (1.0 + b * math.pi**4 / 5.0) ** 2
    by_y = a**2 / 8.0
    by_both = 8.0 * b**2 * math.pi**8 / 225.0
    whole = by_x + by_y + by_both
    # Errors of the estimators fall with the number of samples: 0.01 is three times what 4096 give at other seeds.
    assert shares.first == pytest.approx([by_x / whole, by_y / whole, 0.0], abs=0.01)
    assert shares.total == pytest.approx([(by_x + by_both) / whole, by_y / whole, by_both / whole], abs=0.01)


def test_indices_need_every_point_and_the_plan():
    axes = {name: axis_of(name, "0:1", "1") for name in ("x", "y")}
    plan = sampled(axes, "saltelli", 8, 0)
    values = plan.values[:, 0].copy()
    values[3] = math.nan
    assert np.isnan(indices(table(plan, values))["f"].first).all()
    assert np.isnan(indices(table(plan, np.ones(plan.count)))["f"].total).all()
    assert indices(table(sampled(axes, "lhs", 8, 0), np.ones(8))) == {}


def test_quantiles_are_of_the_points_that_have_the_measure():
    plan = grid_of({"x": axis_of("x", "1:5:5", "1")})
    found = quantiles(table(plan, np.array([1.0, math.nan, 3.0, 2.0, math.nan])), "f", (0.0, 0.5, 1.0))
    assert found.tolist() == [1.0, 2.0, 3.0]
    assert np.isnan(quantiles(table(plan, np.full(5, math.nan)), "f")).all()
