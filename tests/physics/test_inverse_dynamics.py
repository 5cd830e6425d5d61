"""Residuals and mass matrices of the general form against each other, with all that can move at once."""

import numpy as np
import pytest

from lamc.effects import Gravity, HingeDamping, HingeStiffness
from lamc.effects.free_base import FreeBase
from lamc.records.effect import Effect
from lamc.symbolic.derivative import derivatives
from lamc.symbolic.program import Space
from tests.physics.test_added_inertia import Fluid
from tests.physics.test_compliant_hinges import Compliance, all_compliant, compliant, ring
from tests.physics.test_flexible_bodies import Bending, closed, skewed
from tests.support.floating import with_base
from tests.support.general_motion import General, compiled
from tests.support.mechanisms import chain


def everything(floats: bool) -> General:
    """Strips that bend, in a row, on hinges that yield; on a base that floats or not."""
    mechanism, strips = skewed()
    hinges = tuple(compliant(joint, k) for k, joint in enumerate(mechanism.joints[:2]))
    effects: list[Effect] = [Gravity(), HingeStiffness(), HingeDamping(), Compliance(hinges)]
    effects += [Bending(tuple(s.flexible for s in strips)), *([FreeBase()] if floats else [])]
    return General(with_base(mechanism), effects)


@pytest.mark.quick("fluid", "loop", "ring")
@pytest.mark.parametrize("name", ["still", "floating", "ring", "loop", "fluid"])
def test_composite_bodies_give_the_derivative_of_the_residual(name: str) -> None:
    if name in ("still", "floating"):
        general = everything(name == "floating")
    elif name == "fluid":
        matrix = np.diag([0.1, 0.4, 2.0, 0.02, 0.03, 0.01])
        matrix[0, 4] = matrix[4, 0] = 0.05
        wet = with_base(chain(2, "space", seed=3))
        general = General(wet, (Fluid("body1", (0.1, 0.2, 0.3), matrix), FreeBase()))
    elif name == "ring":
        general = General(with_base(ring()), (all_compliant(ring()), FreeBase()))
    else:
        mechanism, coupler = closed()
        general = General(with_base(mechanism), (Bending((coupler.flexible,)), FreeBase()))
    equations, n = general.equations, general.n
    store = equations.store
    udot = [store.symbol(f"udot_{c.name}", Space.ACCELERATION, i) for i, c in enumerate(equations.rates)]
    residual = equations.problem.residual(udot)
    columns = [derivatives(residual, {symbol: 1}) for symbol in udot]
    differentiated = compiled(equations, [v for column in columns for v in column])
    value = compiled(equations, residual)
    rng = np.random.default_rng(3)
    for _ in range(3):
        q, u = rng.normal(size=len(general.coordinates)), rng.normal(size=n)
        matrix = differentiated(0.0, q, u, [0.0] * n).reshape(n, n)
        mass, force, _, _ = general.system(0.0, q, u)
        size = np.abs(mass).max()
        assert np.abs(matrix - matrix.T).max() <= 1e-13 * size  # reciprocity, but for round-off
        assert np.abs(mass - matrix).max() <= 1e-13 * size
        closing = [equations.joints.index(cut.joint.name) for cut in equations.tree.cuts]
        assert not mass[closing].any()  # hinges that close loops move no mass of their own
        moving = np.delete(np.delete(mass, closing, axis=0), closing, axis=1)
        assert np.linalg.eigvalsh(moving).min() > 0.0
        a = rng.normal(size=n)
        expected = mass @ a - force
        assert np.abs(value(0.0, q, u, a.tolist()) - expected).max() <= 1e-12 * np.abs(expected).max()
