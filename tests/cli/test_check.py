"""`check` passes what is right and catches what is wrong. The interpreter plays the compiled side here."""

import importlib
import json
from types import SimpleNamespace
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest

from lamc.mechanics.derive import derive
from lamc.mechanics.lower import lower
from lamc.mechanism.plan import plan
from lamc.records.mechanism import Mechanism
from lamc.records.scene import Scene
from lamc.reference.check import Report, check
from lamc.reference.integrate import simulate
from lamc.reference.interpreter import Interpreter
from lamc.symbolic.program import Program
from tests.support.mechanisms import ALL_PASSIVE, chain, random_tree

Array = npt.NDArray[np.float64]


class Interpreted:
    """A simulator without a compiler: the program interpreted, scipy's RK45, and errors put in on purpose."""

    def __init__(self, mechanism: Mechanism, start: Array) -> None:
        self.mechanism = mechanism
        self.effects: tuple[Any, ...] = ALL_PASSIVE
        self.scene = Scene(effects=ALL_PASSIVE)
        self.program: Program = lower(derive(plan(mechanism), ALL_PASSIVE))
        self.start = start
        self.acceleration_factor = self.energy_factor = 1.0
        self._interpreter = Interpreter(self.program)
        self._constants = self._interpreter.constants()

    def acceleration(self, q: Array, u: Array, t: float = 0.0) -> Array:
        return self.acceleration_factor * self._interpreter.acceleration(t, q, u, self._constants)

    def run(self, t_end: float, *, rtol: float, atol: float, t_eval: Array) -> Any:
        joints = self.program.joints
        run = simulate(self.acceleration, self.start, joints, t_eval, rtol, atol)
        energy = [
            self._interpreter.energy(0.0, q, u, self._constants).sum()
            for q, u in zip(run.q, run.u, strict=True)
        ]
        return SimpleNamespace(
            t=run.t,
            q=run.q,
            u=run.u,
            energy=self.energy_factor * np.array(energy),
            pose=lambda body: self._poses(run.q, body),
            success=True,
            message="",
        )

    def _poses(self, q: Array, body: str) -> tuple[Array, Array]:
        centres, rotations = self._interpreter.poses(q, self._constants)
        k = self.program.bodies.index(body)
        return centres[:, k], rotations[:, k]


def failed(report: Report) -> set[str]:
    return {c.quantity for c in report.comparisons if not c.passed}


@pytest.mark.parametrize("kind", ["space", "mixed"])
def test_cross_checks_agree_on_a_random_tree(kind: str) -> None:
    n = 4
    report = check(
        Interpreted(random_tree(n, seed=8, kind=kind), np.linspace(-0.5, 0.5, 2 * n)), states=5, t_end=0.3
    )
    assert report.passed, report.table()
    assert {c.cross_checks[1] for c in report.comparisons} >= {"interpreter", "Newton-Euler", "maximal"}


def test_a_mechanism_at_rest_in_its_equilibrium_passes() -> None:
    """Accelerations that are nothing but round-off must not be compared with each other."""
    hanging = chain(1, "space", seed=2)
    still = Mechanism(
        hanging.bodies,
        (
            type(hanging.joints[0])(
                "h0", "ground", "body0", point=hanging.bodies[1].com, axis=np.array([0.0, 1.0, 0.0])
            ),
        ),
    )
    assert check(Interpreted(still, np.zeros(2)), states=3, t_end=0.1).passed


def test_a_wrong_acceleration_is_caught_and_located() -> None:
    subject = Interpreted(chain(2, "space", seed=1), np.zeros(4))
    subject.acceleration_factor = 1.0 + 1e-9
    report = check(subject, states=3, t_end=0.2)
    assert not report.passed
    assert failed(report) >= {"accelerations, random states", "accelerations, states of the run"}
    worst = next(c for c in report.comparisons if not c.passed)
    assert worst.at in ("h0", "h1")
    assert worst.where.startswith("state ")
    assert 0.5e-9 < worst.difference < 2e-9  # what was put in


def test_a_wrong_energy_is_caught_alone() -> None:
    subject = Interpreted(chain(2, "space", seed=1), np.zeros(4))
    subject.energy_factor = 1.0 + 1e-6
    assert failed(check(subject, states=3, t_end=0.2)) == {"energy"}


def test_a_nan_is_a_failure() -> None:
    subject = Interpreted(chain(1, "space", seed=1), np.zeros(2))
    plain = subject.acceleration

    def poisoned(q: Array, u: Array, t: float = 0.0) -> Array:
        return plain(q, u, t) * (np.nan if abs(q[0]) > 2.0 else 1.0)

    subject.acceleration = poisoned  # type: ignore[method-assign]
    assert "accelerations, random states" in failed(check(subject, states=20, t_end=0.01))


def test_the_report_prints_and_goes_to_json() -> None:
    report = check(Interpreted(chain(2, "mixed", seed=1), np.zeros(4)), states=2, t_end=0.1)
    assert "Newton-Euler" in report.table()
    data = json.loads(json.dumps(report.to_dict()))
    assert data["passed"] is True
    assert len(data["comparisons"]) == len(report.comparisons)
    assert all(c["reason"] for c in data["comparisons"])


def test_effects_that_the_numeric_cross_checks_do_not_know_are_named_and_the_rest_is_compared() -> None:
    subject = Interpreted(chain(1, "space", seed=1), np.zeros(2))
    subject.effects = (*ALL_PASSIVE, SimpleNamespace(name="wind"), SimpleNamespace(name="rain"))
    report = check(subject, states=2, t_end=0.1)
    assert report.passed, report.table()
    (note,) = report.notes
    assert "do not know the effects 'rain', 'wind'" in note
    compared = {(c.quantity, c.cross_checks) for c in report.comparisons}
    assert ("accelerations, random states", ("C", "interpreter")) in compared
    assert ("angles of the run", ("C", "interpreter")) in compared
    assert {q for q, cross_checks in compared if "Newton-Euler" in cross_checks} == {
        "centres of mass",
        "rotations",
    }


def test_a_run_that_is_too_slow_is_not_called_exact(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(importlib.import_module("lamc.reference.check"), "SECONDS", 1e-9)
    stages: list[str] = []
    report = check(
        Interpreted(chain(2, "space", seed=1), np.zeros(4)),
        states=2,
        t_end=0.2,
        progress=lambda stage, fraction: stages.append(stage) if 0.0 <= fraction <= 1.0 else None,
    )
    rows = [c for c in report.comparisons if c.quantity == "angles of the run"]
    assert [(c.compared, c.failed) for c in rows] == [(False, False)] * 2
    assert "exact" not in next(line for line in report.table().splitlines() if "not compared" in line)
    assert report.passed
    assert json.loads(json.dumps(report.to_dict(), allow_nan=False))["comparisons"][-1]["passed"] is None
    assert {"compare random states", "compare states of the run"} <= set(stages)


def test_a_value_that_is_not_finite_is_reported_with_its_place() -> None:
    subject = Interpreted(chain(1, "space", seed=1), np.zeros(2))
    plain = subject.acceleration

    def poisoned(q: Array, u: Array, t: float = 0.0) -> Array:
        return plain(q, u, t) * (np.nan if abs(q[0]) > 2.0 else 1.0)

    subject.acceleration = poisoned  # type: ignore[method-assign]
    report = check(subject, states=20, t_end=0.01)
    (note,) = report.notes
    assert "not finite at state" in note
    assert "by C;" in note
    assert "slow" not in report.table()


def test_a_cross_check_that_is_left_out_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(importlib.import_module("lamc.reference.check"), "MAXIMAL_BODIES", 1)
    report = check(Interpreted(chain(2, "space", seed=1), np.zeros(4)), states=1, t_end=0.01)
    assert any('"maximal" is left out' in note for note in report.notes)
    assert "maximal" not in {c.cross_checks[1] for c in report.comparisons}
