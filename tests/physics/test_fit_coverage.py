"""95 % intervals hold what they say: ten numbers, three recordings, 1 % noise, 200 times."""

import numpy as np
import pytest

import lamc
from lamc import examples

REPEATS = 200
FREE = [f"h{k}.{what}" for k in (1, 2, 3) for what in ("stiffness", "damping")]
FREE += ["link_2.mass", "link_3.mass", "link_2.inertia_zz", "link_3.inertia_zz"]
T = np.linspace(0.0, 2.0, 61)[1:]


def fits(repeats: int) -> tuple[np.ndarray, list[int]]:
    """Whether each interval holds the true number, (repeats, p), and runs of each recording by fit."""
    design = lamc.load(examples.find("pendulum").path)
    assert isinstance(design, lamc.Design)
    usual = lamc.compile(design)
    true = {name: usual.parameters[name] * np.exp(0.2 * np.sin(k)) for k, name in enumerate(FREE)}
    starts = [{"h1": 0.3 * k, "h2": 0.2 - 0.4 * k, "h3": 0.5} for k in range(3)]
    runs = [
        lamc.compile(design, lamc.Scene(angles=start)).run(t_end=2.0, t_eval=T, parameters=true)
        for start in starts
    ]
    clean = [{name: run.angle(name) for name in run.joints} for run in runs]
    noise = 0.01 * np.std([list(each.values()) for each in clean])  # 1 % of what angles vary by
    rng = np.random.default_rng(0)
    held, counts = [], []
    for _ in range(repeats):
        data = [
            lamc.Recording(T, {n: v + noise * rng.normal(size=len(T)) for n, v in each.items()}, angles=start)
            for each, start in zip(clean, starts, strict=True)
        ]
        fit = lamc.fit(design, data, FREE)
        held.append([fit.intervals[name][0] <= true[name] <= fit.intervals[name][1] for name in FREE])
        counts.append(fit.runs // 3)
    return np.array(held), counts


@pytest.mark.parametrize(("repeats", "least"), [(4, 0.75), (20, 0.85)])
@pytest.mark.quick("4-*", others="campaign")
def test_intervals_of_a_few_fits(repeats: int, least: float) -> None:
    held, counts = fits(repeats)
    # Each interval is beyond in one case of 20: of 40 more than ten in one of 100 000; of 200 ten, with a deviation of
    # 3.1 were those of one fit independent, and thirty are six deviations off.
    assert held.mean() >= least
    assert max(counts) <= 30


@pytest.mark.campaign
def test_95_percent_intervals_hold_95_percent() -> None:
    held, counts = fits(REPEATS)
    # 2000 intervals, those of one fit correlated: the share is known to 1 %.
    assert 0.93 <= held.mean() <= 0.97
    assert max(counts) <= 30  # runs of each recording
