"""Which expressions are linear in angle and rate and constant in time, against coefficients read by eye."""

import pytest

from lamc.effects.linear_drive import linear_drive


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("0.5", (0.5, 0.0, 0.0)),
        ("sin(pi/2)", (1.0, 0.0, 0.0)),
        ("angle", (0.0, 1.0, 0.0)),
        ("1 - 2*(angle - 3) - rate/4", (7.0, -2.0, -0.25)),
        ("0*t", (0.0, 0.0, 0.0)),
        ("t - t", (0.0, 0.0, 0.0)),
        ("t", None),
        ("angle*rate", None),
        ("angle**2", None),
        ("sin(angle)", None),
        ("abs(rate)", None),
        ("max(angle, 0)", None),
        ("1/(1 + angle)", None),
        ("drive - 2*rate", None),  # an input, which whoever runs the engine knows
    ],
)
def test_linear_torques_are_found(text: str, expected: tuple[float, float, float] | None) -> None:
    assert linear_drive(text) == expected
