"""What a fit leaves of a column's variance, in words."""

import numpy as np
import pytest

from lamc.fitting.compared import Compared, remarks
from lamc.fitting.neighbours import offset

T = np.linspace(0.0, 2.0, 201)
NOISE = 1e-3 * np.random.default_rng(0).normal(size=len(T))
SWING = 1.3 * np.cos(5.0 * T)  # 150 degrees from end to end


@pytest.mark.parametrize(
    ("measured", "predicted", "text"),
    [
        (SWING + NOISE, SWING, "0.00%"),
        (SWING + NOISE, 0.01 * SWING, "98."),  # a hopeless model: what was recorded swings all the same
        (SWING, np.full(len(T), np.mean(SWING)), "100.00%"),
        (NOISE, np.zeros(len(T)), "at rest"),
        (NOISE, 1e-4 * SWING, "at rest"),
        (np.zeros(len(T)), np.zeros(len(T)), "at rest"),
        (
            np.full(len(T), 0.1) + 1e-17 * (T > 1.0),
            np.full(len(T), 0.1 + 1e-6),
            "at rest",
        ),  # but for round-off
        # A dead sensor, or a hinge that does not move: nothing agrees.
        (np.full(len(T), 0.1), SWING, "stands still, and the model moves by 2.6 rad"),
        (np.where(T == 0.0, 0.1, np.nan), SWING, "at rest"),  # of one row there is no more to say
        (SWING, np.full(len(T), 50.0), "2"),  # it swings, however far away the model stands
        (np.where(T < 1.0, SWING, np.nan), 0.01 * SWING, "105."),  # as much as no model, and its mean besides
    ],
)
def test_only_what_was_recorded_at_rest_is_called_so(
    measured: np.ndarray, predicted: np.ndarray, text: str
) -> None:
    compared = Compared("run", T, ("h",), ("rad",), measured[:, None], predicted[:, None])
    assert compared.share_text("h").startswith(text)


@pytest.mark.parametrize(
    ("residual", "told"),
    [
        (0.02 + NOISE, True),
        (np.full(len(T), 0.1), True),  # a sensor that stands still elsewhere
        (1e-4 + 1e-5 * NOISE, False),  # of a swing of 1.3 rad: a recording of five digits
        (0.2 * np.exp(-5.0 * T), False),  # which is alike from row to row, and over at the end
        (NOISE, False),
        (np.full(5, 0.1), False),
    ],
)
def test_what_lies_to_one_side_all_along_has_an_offset(residual: np.ndarray, told: bool) -> None:
    found = offset(residual, 1.3)
    assert (found == pytest.approx(np.mean(residual))) if told else found == 0.0


def test_a_dead_column_is_named_and_nothing_else_is_blamed() -> None:
    """The offset that it forces on the others was said to be theirs."""
    measured = np.column_stack([SWING, np.full(len(T), 0.5)])
    predicted = np.column_stack([SWING + 0.3, np.gradient(SWING, T)])
    both = Compared("run", T, ("h", "h.rate"), ("rad", "rad/s"), measured, predicted)
    notes = remarks((both,))
    (dead,) = [note for note in notes if "sensor dead" in note]
    assert dead.startswith("run: h.rate stands still, and the model moves by")
    assert not any("throughout" in note for note in notes)
    alone = Compared("run", T, ("h",), ("rad",), measured[:, :1], predicted[:, :1])
    assert any("off h by" in note for note in remarks((alone,)))
