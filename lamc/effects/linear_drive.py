"""Which drives are linear: constant in time, and linear in the angle and rate of their joint.

In: an expression. Out: its three coefficients, or None. Never: knows who asks.
"""

from lamc.effects.drives import Drive
from lamc.symbolic.derivative import derivative
from lamc.symbolic.expression import stage
from lamc.symbolic.program import Space
from lamc.symbolic.scalars import Scalar, Value
from lamc.symbolic.staging import Store
from lamc.symbolic.substitution import substitute


def linear_drive(text: str) -> tuple[float, float, float] | None:
    """(constant, per angle, per rate) where the expression is constant + per_angle·angle + per_rate·rate as it stands;
    None for any other, for one that would be so after simplification only, and for one that holds inputs."""
    if Drive("", text, "").inputs():
        return None
    store = Store()
    time = store.symbol("t", Space.TIME, 0)
    angle = store.symbol("angle", Space.ANGLE, 0)
    rate = store.symbol("rate", Space.RATE, 0)
    value = stage(text, {"t": time, "angle": angle, "rate": rate})
    slopes: list[Scalar] = [derivative(value, {symbol: 1}) for symbol in (time, angle, rate)]
    (constant,) = substitute([value], {time: 0, angle: 0, rate: 0})
    numbers = [float(each) for each in (constant, *slopes) if not isinstance(each, Value)]
    if len(numbers) < 4 or numbers[1] != 0.0:
        return None
    return numbers[0], numbers[2], numbers[3]
