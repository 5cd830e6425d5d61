"""Every effect has a numeric cross-check of its own, which agrees with the C and would not if a number were another."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import pytest

import lamc
from lamc.records.effect import Effect
from lamc.records.mechanism import Mechanism
from lamc.records.scene import Scene
from lamc.reference import check
from lamc.reference.check_report import Report
from lamc.reference.lagrange import Lagrange
from lamc.run.simulator import Simulator
from tests.physics.test_compliant_hinges import all_compliant
from tests.support.ctools import needs_cc
from tests.support.every_effect import SAMPLES, mechanism
from tests.support.floating import with_base
from tests.support.general_motion import General
from tests.support.mechanisms import chain, random_tree

pytestmark = needs_cc

INDEPENDENT = {"Newton-Euler", "Lagrange"}
WITHOUT_A_CROSS_CHECK: Mapping[str, str] = {}  # name: why; every effect of lamc has one


def compiled(*effects: Effect, angles: Mapping[str, float] = {"h1": 0.9, "h2": -0.8}) -> Simulator:
    return lamc.compile(mechanism(), Scene(effects=effects, angles=angles))


def cross_checks_of(report: Report, quantity: str) -> set[str]:
    return {c.cross_checks[1] for c in report.comparisons if c.quantity == quantity and c.compared}


@pytest.mark.parametrize("name", sorted(SAMPLES))
@pytest.mark.quick(
    "base_motion", "flexible_links", "free_base", "gravity", "piezo_bender", "twist_compliance"
)
def test_every_effect_is_said_by_an_independent_cross_check(name: str) -> None:
    company = () if name == "gravity" else (SAMPLES["gravity"],)
    report = check(compiled(SAMPLES[name], *company), states=6, t_end=0.2)
    assert report.passed, report.table()
    for quantity in (
        "accelerations, random states",
        "accelerations, states of the run",
        "energies by effect",
    ):
        assert bool(cross_checks_of(report, quantity) & INDEPENDENT) is (name not in WITHOUT_A_CROSS_CHECK)


@pytest.mark.parametrize("base", ["free_base", "base_motion"])
@pytest.mark.quick("free_base", others="campaign")
def test_all_effects_together_are_said_alike(base: str) -> None:
    """The bender joins a body that bends, and the ground is touched by one on a hinge that yields."""
    without = {"free_base", "base_motion", "hinge_stiffness"} - {base}
    effects = [SAMPLES[name] for name in sorted(SAMPLES) if name not in without]
    report = check(compiled(*effects, angles={}), states=6, t_end=0.02)
    assert report.passed, report.table()
    assert "Lagrange" in cross_checks_of(report, "accelerations, random states")
    assert {"modal stiffness", "strip stiffness"} <= {c.quantity for c in report.comparisons}


@dataclass(frozen=True)
class Misread:
    """A simulator of one effect, which other cross-checks take for another."""

    simulator: Simulator
    effects: tuple[Effect, ...]

    def __getattr__(self, name: str) -> Any:
        return getattr(self.simulator, name)


WIND = replace(SAMPLES["blade_element_drag"], wind=(3.0, -1.0, 2.0))  # type: ignore[type-var]
DRY = replace(SAMPLES["blade_element_drag"], added_mass=False, lift_point=None)  # type: ignore[type-var]
PUSH = SAMPLES["piezo_bender"]
FOLD = replace(  # along x, across the hinge h1 at x = 0
    PUSH, body_a="ground", root=(-0.3, 0.0, 0.0), body_b="a", tip=(0.5, 0.0, 0.0), hinge="h1", extension=0.0
)  # type: ignore[type-var]
STRIP, PLATES, STOPS = (SAMPLES[n] for n in ("twist_compliance", "flexible_links", "joint_limits"))
OFF = 1.0 + 1e-6  # ten thousand times the limit: a number may count for little beside others
OTHERWISE: Mapping[str, tuple[Effect, Mapping[str, Any]]] = {
    "width of a bender": (PUSH, {"width": 0.1 * OFF}),
    "extension of a bender": (PUSH, {"extension": 0.0101}),
    "width of a bender across a hinge": (FOLD, {"width": 0.101}),
    "lift of a wing without the air's mass": (DRY, {"lift": 1.7 * OFF}),
    "voltage of a bender": (PUSH, {"voltage": f"9*{OFF!r}*cos(t)"}),
    "density of the air": (WIND, {"air_density": 1.3 * OFF}),
    "lift": (WIND, {"lift": 1.7 * OFF}),
    "drag edge-on": (WIND, {"drag_edge_on": 0.4 * OFF}),
    "rotation": (WIND, {"rotation": 3.0 * OFF}),
    "lift point": (WIND, {"lift_point": 0.4 * OFF}),
    "wind": (WIND, {"wind": (3.0, -1.0, 2.0 * OFF)}),
    "retardation of a strip": (STRIP, {"retardation": 1e-4 * OFF}),
    "normal of a strip": (STRIP, {"normal": (OFF - 1.0, 0.1, 1.0)}),
    "damping of modes": (PLATES, {"damping_ratio": 0.02 * OFF}),
    "stiffness of stops": (STOPS, {"stiffness": 3.0 * OFF}),
    "damping of stops": (STOPS, {"damping": 0.2 * OFF}),
}


@pytest.mark.parametrize("case", sorted(OTHERWISE))
@pytest.mark.quick(
    "damping of stops",
    "extension of a bender",
    "stiffness of stops",
    "voltage of a bender",
    "retardation of a strip",
    others="campaign",
)
def test_a_number_that_is_another_is_noticed(case: str) -> None:
    effect, changes = OTHERWISE[case]
    whole = (effect, SAMPLES["gravity"])
    reported = (replace(effect, **changes), SAMPLES["gravity"])  # type: ignore[type-var]
    simulator = compiled(*whole)
    assert check(Misread(simulator, whole), states=10, t_end=0.02).passed  # type: ignore[arg-type]
    report = check(Misread(simulator, reported), states=10, t_end=0.02)  # type: ignore[arg-type]
    failed = [c for c in report.comparisons if c.failed]
    assert failed
    assert {c.cross_checks[1] for c in failed} <= {"Newton-Euler", "maximal", "Lagrange"}


def test_plates_of_another_modulus_are_noticed() -> None:
    sheet = lamc.plate.Laminate(
        [lamc.plate.Ply(lamc.plate.Material.isotropic(2e9 * (1.0 + 1e-8), 0.3, 1500.0), 1e-3)]
    )
    report = check(Misread(compiled(PLATES), (replace(PLATES, laminate=sheet),)), states=2, t_end=0.01)  # type: ignore[type-var, arg-type]
    assert not report.passed


@pytest.mark.parametrize(
    "base", [(), (lamc.FreeBase(),), (SAMPLES["base_motion"],)], ids=["still", "free", "told"]
)
@pytest.mark.parametrize(
    "whole",
    [chain(2, "space", seed=1), random_tree(4, seed=4), random_tree(5, seed=9, kind="mixed")],
    ids=lambda m: m.name,
)
def test_yielding_trees_have_one_motion_in_the_symbolic_and_the_numeric_cross_check(
    whole: Mechanism, base: tuple[Effect, ...]
) -> None:
    """Full matrices of stiffness and damping at points and axes of any direction, entered by parent and by child."""
    whole, effects = with_base(whole), (all_compliant(whole), lamc.Gravity((0.4, -0.2, -9.81)), *base)
    general = General(whole, effects)
    cross_check = Lagrange(whole, effects, general.equations.joints, general.rates, effects[1:])
    rng = np.random.default_rng(3)
    for _ in range(3):
        q, u = rng.normal(size=len(general.coordinates)), rng.normal(size=general.n)
        expected = cross_check.acceleration(q, u, 0.3)
        found = general.acceleration(0.3, q, u)
        mass = general.system(0.3, q, u)[0]
        scale = 1.0 / np.sqrt(np.diag(mass))
        condition = float(np.linalg.cond(scale[:, np.newaxis] * mass * scale))
        # Round-off of some thousand operations, or of a number times the condition of the mass matrix, each rate in its
        # own unit: 4e5 for one of these trees
        limit = max(1e-11, float(np.finfo(float).eps) * condition)
        assert np.abs(found - expected).max() <= limit * np.abs(expected).max()
