"""Nonlinear stiffness against closed forms, scipy's curves and a cross-check that shares nothing; files and
refusals."""

import contextlib
import json
import math
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline, PchipInterpolator
from scipy.special import ellipj

import lamc
from lamc.basics.errors import DesignError, ExpressionError, LamcError
from lamc.effects import HingeStiffness, NonlinearStiffness, RestAngle
from lamc.effects.data import file_context
from lamc.effects.registry import choose
from lamc.effects.torque_laws import Table
from lamc.examples import __file__ as examples
from lamc.mechanics.loads import Loads
from lamc.mechanics.sympy_view import expression
from lamc.readers.load_scene import scene_of_text
from lamc.readers.scene_writer import scene_data
from lamc.records.mechanism import Joint, Mechanism
from lamc.records.scene import Scene
from lamc.reference.check import check
from lamc.symbolic.antiderivative import antiderivative
from lamc.symbolic.derivative import derivative
from lamc.symbolic.expression import stage
from lamc.symbolic.program import Space
from lamc.symbolic.staging import Store
from tests.physics.test_effects import ABOUT_HINGE, pendulum, simulator
from tests.support.ctools import needs_cc
from tests.support.mechanisms import chain
from tests.support.quick import tries

ALPHA, BETA = 0.3, 0.8  # N·m/rad, N·m/rad³
ANGLES = np.array([-1.1, -0.6, -0.25, 0.0, 0.1, 0.45, 0.5, 1.2])
SNAP = np.array([-0.9, -0.2, -0.35, 0.0, 0.25, 0.1, 0.3, 2.0])  # snaps through: falls between 0.1 and 0.45
CURVES = {
    "spline": lambda: CubicSpline(ANGLES, SNAP, bc_type="natural"),
    "monotone": lambda: PchipInterpolator(ANGLES, SNAP),
}


def table(between: str = "spline") -> dict[str, Any]:
    return {"table": list(zip(ANGLES.tolist(), SNAP.tolist(), strict=True)), "between": between}


# ---- closed forms ---------------------------------------------------------------------------------------------


@needs_cc
@pytest.mark.parametrize(
    "law",
    [[ALPHA, 0.0, BETA], f"{ALPHA}*angle + {BETA}*angle^3", {"energy": "0.15*angle^2 + 0.2*angle^4"}],
    ids=["polynomial", "expression", "energy"],
)
@pytest.mark.parametrize("rest", [0.0, 0.4])
def test_a_cubic_hinge_is_duffings_oscillator(law: Any, rest: float) -> None:
    """I ẍ + α x + β x³ = 0 from rest at x = A: x = A cn(ω t | m), I ω² = α + β A², m = β A² / (2 I ω²)."""
    amplitude = 0.9
    omega = math.sqrt((ALPHA + BETA * amplitude**2) / ABOUT_HINGE)
    m = BETA * amplitude**2 / (2 * ABOUT_HINGE * omega**2)
    mechanism = pendulum(stiffness=5.0, rest_angle=rest)
    sim = simulator(mechanism, NonlinearStiffness({"hip": law}), angle=rest + amplitude)
    t = np.linspace(0.0, 8.0, 41)
    result = sim.run(t_end=8.0, t_eval=t, rtol=1e-12, atol=1e-13)
    _, cn, _, _ = ellipj(omega * t, m)
    assert result.angle("hip") - rest == pytest.approx(
        amplitude * cn, abs=3e-9
    )  # rtol times some hundred steps
    x = result.angle("hip") - rest
    stored = 0.5 * ALPHA * x**2 + 0.25 * BETA * x**4
    assert result.energies["nonlinear_stiffness"] == pytest.approx(stored, abs=1e-15)  # round-off
    assert result.energy == pytest.approx(result.energy[0], abs=1e-10)


@needs_cc
@pytest.mark.parametrize("between", sorted(CURVES))
def test_a_table_is_scipys_curve_and_goes_on_straight(between: str) -> None:
    curve = CURVES[between]()
    sim = simulator(pendulum(), NonlinearStiffness({"hip": table(between)}))
    for angle in np.linspace(ANGLES[0], ANGLES[-1], 137):
        found = sim.acceleration([angle], [0.0])[0]
        # both curves hold their coefficients to round-off; those of second powers reach 20
        assert found == pytest.approx(-float(curve(angle)) / ABOUT_HINGE, abs=1e-12)
    for end, outside in ((ANGLES[0], -0.7), (ANGLES[-1], 1.9)):
        straight = float(curve(end) + outside * curve(end, 1))
        assert sim.acceleration([end + outside], [0.0])[0] == pytest.approx(
            -straight / ABOUT_HINGE, rel=1e-13
        )


@needs_cc
@pytest.mark.parametrize("between", sorted(CURVES))
@pytest.mark.parametrize("integrator", ["dop853", "radau5"])
@pytest.mark.quick("dop853-*")
def test_a_tables_energy_is_the_integral_of_its_torque(between: str, integrator: str) -> None:
    """Energy is conserved through every piece and outside, and is scipy's integral; the Jacobian is exact, or the
    implicit method would not converge to this tolerance."""
    sim = simulator(pendulum(), NonlinearStiffness({"hip": table(between)}), angle=-1.5, rate=-2.0)
    result = sim.run(t_end=6.0, rtol=1e-10, atol=1e-12, integrator=integrator)
    angle = result.angle("hip")
    assert angle.min() < ANGLES[0] < ANGLES[-1] < angle.max()
    # rtol times some thousand steps; a spline's kinks of the third derivative are passed unseen
    assert result.energy == pytest.approx(result.energy[0], abs=1e-8 if between == "monotone" else 3e-7)
    inside = (angle > ANGLES[0]) & (angle < ANGLES[-1])
    area = [float(CURVES[between]().integrate(0.0, x)) for x in angle[inside]]
    assert result.energies["nonlinear_stiffness"][inside] == pytest.approx(area, abs=1e-14)  # round-off


@needs_cc
def test_a_factor_and_coefficients_are_parameters() -> None:
    sim = simulator(pendulum(), NonlinearStiffness({"hip": table()}))
    once, twice = (sim.acceleration([0.3], [0.0], 0.0, {"hip.stiffness_factor": f})[0] for f in (1.0, 2.0))
    assert twice == 2.0 * once
    cubic = simulator(pendulum(rest_angle=0.1), NonlinearStiffness({"hip": [ALPHA, 0, BETA]}))
    assert {n: v for n, v in cubic.parameters.items() if n.startswith("hip")} == {
        "hip.rest_angle": 0.1,
        "hip.stiffness_1": ALPHA,
        "hip.stiffness_3": BETA,
    }
    assert cubic.parameter_units["hip.stiffness_3"] == "N·m/rad^3"


@needs_cc
def test_it_takes_the_place_of_the_linear_spring() -> None:
    mechanism = pendulum(stiffness=7.0, rest_angle=0.2)
    law = NonlinearStiffness({"hip": [ALPHA]})
    both = simulator(mechanism, HingeStiffness(), RestAngle(), law).acceleration([0.5], [0.0])[0]
    assert both == pytest.approx(-ALPHA * (0.5 - 0.2) / ABOUT_HINGE, rel=1e-14)
    reason = {c.name: c.reason for c in choose(mechanism, Scene(effects=(law,)))}["nonlinear_stiffness"]
    assert reason == "the scene calls for it; it alone gives the stiffness of hinge 'hip'"


LAWS: Mapping[str, Any] = {
    "h0": table("monotone"),
    "h1": "0.7*sin(2*angle) + 0.2*tanh(3*angle - 0.1)",
    "h2": {"energy": "1.5*cosh(angle/2) + 0.1*cos(4*angle)"},
    "h3": [0.4, -0.2, 1.1],
}


def with_rests(mechanism: Mechanism) -> Mechanism:
    joints = tuple(
        Joint(j.name, j.parent, j.child, point=j.point, axis=j.axis, stiffness=2.0, rest_angle=0.3 - 0.1 * k)
        for k, j in enumerate(mechanism.joints)
    )
    return Mechanism(mechanism.bodies, joints, name=mechanism.name)


@needs_cc
@pytest.mark.parametrize("kind", ["space", "laminate"])
@pytest.mark.quick("laminate", others="campaign")
def test_every_law_agrees_with_the_independent_cross_checks(kind: str) -> None:
    mechanism = with_rests(chain(5, kind, seed=4))
    scene = Scene(effects=(lamc.Gravity(), HingeStiffness(), RestAngle(), NonlinearStiffness(LAWS)))
    report = check(lamc.compile(mechanism, scene), states=20, t_end=0.5)
    assert report.passed, report


@needs_cc
def test_a_hinge_that_closes_a_loop_may_be_nonlinear() -> None:
    mechanism = lamc.split(lamc.load(Path(examples).parent / "four_bar.yaml"))
    assert mechanism.scene is not None
    law = NonlinearStiffness({j.name: [1e-4, 2e-5, 9e-4] for j in mechanism.joints})
    scene = Scene((law,), mechanism.scene.angles, mechanism.scene.rates, mechanism.scene.branch)
    sim = lamc.compile(mechanism, scene)
    result = sim.run(t_end=1.0, rtol=1e-10, atol=1e-12)
    assert result.energies["nonlinear_stiffness"][0] > 0.0
    # rtol times some hundred steps, of the energy that there is
    assert result.energy == pytest.approx(result.energy[0], rel=1e-8)


# ---- tables in the equations and in the C ---------------------------------------------------------------------


def test_tables_have_derivatives_in_sympy() -> None:
    store = Store()
    x = store.symbol("x", Space.ANGLE, 0)
    curve = CURVES["spline"]()
    torque = expression(store.table(Table(tuple(table()["table"])).potential(), x, 1), {})
    (symbol,) = torque.free_symbols
    assert float(torque.subs(symbol, 0.37).evalf()) == pytest.approx(float(curve(0.37)), rel=1e-13)
    slope = torque.diff(symbol)
    assert float(slope.subs(symbol, 0.37).evalf()) == pytest.approx(float(curve(0.37, 1)), rel=1e-13)
    assert torque.diff(symbol, 4) == 0


@needs_cc
def test_a_table_is_one_array_and_one_call_whatever_its_length() -> None:
    x = np.linspace(-1.0, 1.0, 1000)
    rows = list(zip(x.tolist(), np.sin(3.0 * x).tolist(), strict=True))
    long = simulator(pendulum(), NonlinearStiffness({"hip": {"table": rows}}))
    short = simulator(pendulum(), NonlinearStiffness({"hip": table()}))
    count = {s: s.program.functions["acceleration"].operations for s in (long, short)}
    assert count[long] == count[short]
    assert count[long].calls == 1
    text = (long.source_dir / "rod.c").read_text(encoding="utf-8")
    assert text.count("static const double table_") == 2  # breaks and pieces
    # h⁴ max|T''''| / 384 · 5 of the interior, h = 0.002: 4e-12; ends bend by T'' h² / 8 within a few points
    assert long.acceleration([0.41], [0.0])[0] == pytest.approx(-math.sin(1.23) / ABOUT_HINGE, abs=1e-9)


@needs_cc
@pytest.mark.parametrize(("between", "integrator"), [("monotone", "rk45"), ("spline", "dop853")])
def test_located_points_keep_the_order_of_the_integrator(between: str, integrator: str) -> None:
    """Against the same motion at a tolerance a thousand times smaller, and with steps that cross points unseen."""
    x = np.linspace(-1.0, 1.0, 21)
    rows = list(zip(x.tolist(), (ALPHA * x + BETA * x**3).tolist(), strict=True))
    errors = {}
    for located in (True, False):
        law = {"table": rows, "between": between, "located": located}
        sim = simulator(pendulum(), NonlinearStiffness({"hip": law}), angle=0.93)
        if located:
            truth = sim.run(t_end=20.0, t_eval=[20.0], rtol=1e-12, atol=1e-14).q[-1, 0]
        result = sim.run(t_end=20.0, t_eval=[20.0], rtol=1e-9, atol=1e-9, integrator=integrator)
        errors[located] = abs(result.q[-1, 0] - truth)
        assert bool(result.events) == located
    assert errors[True] < 1e-7  # some 15 swings of a hundred steps each at 1e-9
    assert errors[False] > 10.0 * errors[True]


@needs_cc
@pytest.mark.parametrize("rtol", [1e-7, 1e-9])
def test_auto_keeps_its_tolerance_with_a_table(rtol: float) -> None:
    """A spline without located points, of which estimates of high order do not see the jumps; another has none.

    Where steps fall among the points decides an error, so errors are those of nine tolerances side by side. They are
    held against the law that has no jumps, whose errors are those of rk45 alone: 3 to 11 rtol, and 40 at 1e-9. Jumps of
    the third derivative add once or twice as much where an estimate sees them, and a hundred times where it does not.
    """
    x = np.linspace(-1.0, 1.0, 21)
    rows = list(zip(x.tolist(), (ALPHA * x + BETA * x**3).tolist(), strict=True))
    plain = simulator(pendulum(), NonlinearStiffness({"hip": [ALPHA, 0, BETA]}), angle=0.93)
    assert plain.run(t_end=0.1, rtol=rtol).stats.integrator == "dop853"
    exact = simulator(pendulum(), NonlinearStiffness({"hip": {"table": rows, "located": True}}), angle=0.93)
    sim = simulator(pendulum(), NonlinearStiffness({"hip": {"table": rows}}), angle=0.93)
    assert sim.run(t_end=0.1, rtol=rtol).stats.integrator == "rk45"

    def errors(of: lamc.Simulator, truth: lamc.Simulator, integrator: str) -> NDArray[np.float64]:
        """In tolerances, at the end of some 15 swings of a hundred steps each."""
        end = truth.run(t_end=20.0, t_eval=[20.0], rtol=1e-12, atol=1e-14).q[-1, 0]
        near = rtol * np.logspace(-0.2, 0.2, 9)
        runs = [of.run(t_end=20.0, t_eval=[20.0], rtol=r, atol=r, integrator=integrator) for r in near]
        return (np.array([run.q[-1, 0] for run in runs]) - end) / near

    unavoidable = np.abs(errors(plain, plain, "rk45")).max()
    assert np.sqrt(np.mean(errors(sim, exact, "auto") ** 2)) < 5.0 * unavoidable
    assert np.sqrt(np.mean(errors(sim, exact, "dop853") ** 2)) > 10.0 * unavoidable


@needs_cc
@pytest.mark.parametrize(("t_end", "is_probed"), [(0.2, False), (150.0, True)])
def test_a_run_to_an_accuracy_takes_no_high_order_with_a_table(t_end: float, is_probed: bool) -> None:
    """As "auto", be the run long enough for probes or not; the same spring as a polynomial gets order 8."""
    x = np.linspace(-1.0, 1.0, 21)
    rows = list(zip(x.tolist(), (ALPHA * x + BETA * x**3).tolist(), strict=True))
    for law, name in (([ALPHA, 0, BETA], "dop853"), ({"table": rows}, "rk45")):
        facts = (
            simulator(pendulum(), NonlinearStiffness({"hip": law}), angle=0.93)
            .run(t_end, accuracy=1e-7)
            .accuracy
        )
        assert facts is not None
        assert facts.integrator == name
        assert bool(facts.candidates) == is_probed


@needs_cc
@pytest.mark.parametrize("rate", [0.0, 1.5])
def test_a_start_on_a_point_of_the_table_is_no_trouble(rate: float) -> None:
    sim = simulator(pendulum(), NonlinearStiffness({"hip": table("monotone")}), rate=rate)
    result = sim.run(t_end=2.0, rtol=1e-10, atol=1e-12)
    assert result.success
    assert result.energy == pytest.approx(result.energy[0], abs=1e-9)  # rtol times some hundred steps
    if rate:
        assert {e.name for e in result.events} <= {
            f"hip passes point {k + 1} of its table" for k in range(len(ANGLES))
        }
        assert result.events
    else:
        assert not np.abs(result.angle("hip")).any()


@needs_cc
@pytest.mark.parametrize("damping", [0.02, 0.3, 2.0])
@pytest.mark.parametrize("integrator", ["auto", "rk45", "dop853", "rodas5p", "radau5"])
def test_a_hinge_comes_to_rest_on_a_point_of_its_table(damping: float, integrator: str) -> None:
    law = NonlinearStiffness({"hip": {**table("monotone"), "located": True}})
    sim = simulator(pendulum(damping=damping), law, lamc.HingeDamping(), angle=0.9)
    result = sim.run(t_end=500.0, integrator=integrator)
    assert result.success
    assert abs(result.q[-1, 0]) < 1e-8  # the tolerance of the run
    assert len(result.events) < 300  # it ends when the swing is too small for the event beside the rest


@dataclass(frozen=True)
class Zero:
    """An event, and nothing else, where the hinge comes to rest."""

    name: ClassVar[str] = "zero"
    summary: ClassVar[str] = "Passage of the hinge through zero"

    def contribute(self, loads: Loads) -> None:
        loads.switch("zero of hip", loads.hinge("hip").angle)


@needs_cc
@pytest.mark.parametrize("damping", [0.02, 0.3, 0.6])
@pytest.mark.parametrize("integrator", ["rk45", "dop853", "rodas5p", "radau5"])
def test_a_hinge_comes_to_rest_on_an_event(damping: float, integrator: str) -> None:
    """Of the angle only round-off is left there, and of the corrections of implicit stages too."""
    law = NonlinearStiffness({"hip": {**table("monotone"), "located": False}})
    sim = simulator(pendulum(damping=damping), law, Zero(), lamc.HingeDamping(), angle=0.9)
    result = sim.run(t_end=500.0, integrator=integrator)
    assert result.success, result.message
    assert abs(result.q[-1, 0]) < 1e-8  # the tolerance of the run


@needs_cc
def test_equal_tables_of_many_hinges_are_one() -> None:
    mechanism = chain(4, "laminate", seed=2)
    laws = {f"h{i}": table() for i in range(4)}
    sim = lamc.compile(mechanism, Scene(effects=(NonlinearStiffness(laws),)))
    assert list(sim.program.tables) == [0]


# ---- energies of expressions ----------------------------------------------------------------------------------

_LINES = st.builds(
    lambda a, b: f"({a}*angle + {b})", st.sampled_from([0.5, -1.5, 3.0]), st.sampled_from([-0.3, 0.0, 2.0])
)
_NAMES = ("sin", "cos", "tan", "atan", "sinh", "cosh", "tanh", "exp", "abs", "sqrt", "log", "asin", "acos")
_TERMS = st.one_of(
    st.builds(lambda f, y: f"{f}{y}", st.sampled_from(_NAMES), _LINES),
    st.builds(lambda y, n: f"{y}^{n}", _LINES, st.sampled_from(["2", "3", "5", "-1", "1.5", "0.3"])),
    st.builds(lambda f, y, z: f"{f}({y}, {z})", st.sampled_from(["min", "max"]), _LINES, _LINES),
    st.builds(lambda y, z: f"{y}*{z}*2", _LINES, _LINES),
)
_SUMS = st.lists(_TERMS, min_size=1, max_size=4).map(" - 0.7*".join)


@given(text=_SUMS, at=st.floats(-0.6, 0.6))
@settings(deadline=None, max_examples=tries(150))
def test_the_derivative_of_an_antiderivative_is_the_expression(text: str, at: float) -> None:
    store = Store()
    x = store.symbol("angle", Space.ANGLE, 0)
    value = stage(text, {"angle": x})
    integral = antiderivative(value, x)
    assert integral is not None
    both = [expression(v, {}) for v in (value, derivative(integral, {x: 1}))]
    numbers = [complex(e.subs("angle", at).evalf(30)) for e in both]
    if all(np.isfinite(numbers)) and abs(numbers[0].imag) == 0.0:
        # the coefficients are doubles: 17 digits, and products of a few of them
        assert abs(numbers[1] - numbers[0]) <= 1e-12 * (1.0 + abs(numbers[0]))


def test_a_torque_without_a_closed_energy_is_refused_with_the_way_out() -> None:
    with pytest.raises(ExpressionError, match=r"stiffness of hinge 'h'.*no antiderivative.*give the energy"):
        NonlinearStiffness({"h": "angle*exp(-angle^2)"})
    NonlinearStiffness({"h": {"energy": "-exp(-angle^2)/2"}})


# ---- files and refusals ---------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("text", "rows"),
    [
        ("-1,-2\n0,0\n1,3\n", ((-1.0, -2.0), (0.0, 0.0), (1.0, 3.0))),
        (
            "\ufeff# made by hand\nangle; torque\n\n-1; -2\n0.5 ;1e-3 # a remark\n",
            ((-1.0, -2.0), (0.5, 1e-3)),
        ),
        ("angle [deg],torque [N*mm]\n-90,-2\n90,4\n", ((-math.pi / 2, -2e-3), (math.pi / 2, 4e-3))),
        ("angle (deg)\ttorque (mN*m)\r\n0\t0\r\n180\t5\r\n", ((0.0, 0.0), (math.pi, 5e-3))),
    ],
)
def test_tables_come_from_files(tmp_path: Path, text: str, rows: tuple[tuple[float, float], ...]) -> None:
    (tmp_path / "hinge.csv").write_text(text, encoding="utf-8", newline="")
    effect = NonlinearStiffness({"h": {"file": str(tmp_path / "hinge.csv")}})
    assert effect == NonlinearStiffness({"h": {"table": rows}})
    context = file_context(folder=tmp_path)
    assert NonlinearStiffness.from_data({"h": {"file": "hinge.csv"}}, "scene", context) == effect


@pytest.mark.parametrize(
    ("data", "words"),
    [
        (b"0,0\n1,nan\n", r"hinge\.csv:2: 'nan' is no number"),
        (b"0,0\n1,1,1\n", r"hinge\.csv:2: a line of 3 columns; give two, angle and torque"),
        (b"0,0\n1,0\n0.5,2\n", r"angle 0\.5 rad follows 1 rad in row 3.*must ascend"),
        (b"0,0\n0,1\n", r"angle 0 rad follows 0 rad"),
        (b"0,0\n", "2 to 10000 rows"),
        (b"", "2 to 10000 rows"),
        (b"0,0\n90,1\n", r"reaches 90 rad, more than two turns.*angle \[deg\]"),
        (b"angle [deg], torque [kg]\n0,0\n1,1\n", r"hinge\.csv:1: the heading's unit: .*kg.*torque"),
        ("angle,torque\n0,0\n1,1\n".encode("utf-16"), "not UTF-8 text: save it as CSV in UTF-8"),
        (b"0;0\n0,5;1\n", r"'0,5' is no number; write angle with a decimal point"),
        (b"0,0\n1,1_0\n", "'1_0' is no number"),
        (b"0,0\n1,1e999\n", "torque"),
        (b"0,0\n1e-320,1e20\n", "not finite; set them farther apart"),
        (b"x" * 1_000_001, "larger than the limit"),
        (b"\n".join(b"%d.0e-5,0" % k for k in range(10_002)), r"hinge\.csv:10001: more than 10000 rows"),
    ],
)
def test_tables_that_cannot_be_are_refused_with_their_place(tmp_path: Path, data: bytes, words: str) -> None:
    (tmp_path / "hinge.csv").write_bytes(data)
    with pytest.raises(DesignError, match=words) as caught:
        NonlinearStiffness.from_data({"h": {"file": "hinge.csv"}}, "here", file_context(folder=tmp_path))
    assert "\n" not in str(caught.value)


@given(data=st.binary(max_size=200))
@settings(deadline=None, max_examples=tries(200))
def test_any_bytes_are_a_table_or_an_error_of_lamcs_own(
    tmp_path_factory: pytest.TempPathFactory, data: bytes
) -> None:
    path = tmp_path_factory.mktemp("tables") / "hinge.csv"
    path.write_bytes(data)
    with contextlib.suppress(LamcError):
        NonlinearStiffness({"h": {"file": str(path)}})


@pytest.mark.parametrize(
    ("law", "words"),
    [
        ([], "has 0 coefficients; give 1 to 16"),
        ([0.0, 0.0], "all 0; leave the hinge out"),
        ([1.0, math.nan], r"laws\.h\[1\]: the stiffness is nan"),
        ({"tabel": [[0, 0], [1, 1]]}, "no field 'tabel'; did you mean 'table'"),
        ({}, "gives nothing; give one of table, file and energy"),
        ({"table": [[0, 0], [1, 1]], "file": "x.csv"}, "gives table and file; give one"),
        ({"energy": "angle^2", "between": "spline"}, "give one of"),
        ({"energy": 3}, "give an expression in angle"),
        ({"table": [[0, 0], [1, 1]], "between": "linear"}, "kinks.*lose their order"),
        ({"table": [[0, 0], [1, math.inf]]}, r"table\[1\]\[1\]: the torque is inf"),
        ({"table": [0, 1]}, r"the row is 0; give \[angle, torque\]"),
        (
            {"table": [[0.01 * k, k] for k in range(51)], "located": True},
            "51 points cannot be located; at most 50",
        ),
        ({"table": [[0, 0], [1, 1]], "located": 1}, "must be True or False"),
        ({"table": "x"}, "give rows of two numbers"),
        ({"file": "nowhere.csv"}, "nowhere.csv: there is no such file"),
        ({"file": 3}, "give the name of a CSV file"),
        ("torque", "'torque' is not known; known are pi, angle"),
        ("1/angle", "no finite"),
        (None, "must be a number"),
    ],
)
def test_laws_that_cannot_be_are_refused(law: object, words: str) -> None:
    with pytest.raises(DesignError, match=words) as caught:
        NonlinearStiffness({"h": law})  # type: ignore[dict-item]
    assert "\n" not in str(caught.value)


def read_scene(data: object) -> Scene:
    """Plain data as a file; JSON is YAML."""
    return scene_of_text(json.dumps(data), "scene.yaml")


def test_a_scene_file_names_tables_beside_it(tmp_path: Path) -> None:
    (tmp_path / "hinge.csv").write_text("0,0\n1,1\n", encoding="utf-8")
    scene = tmp_path / "scene.yaml"
    scene.write_text("effects: {nonlinear_stiffness: {h: {file: hinge.csv}}}", encoding="utf-8")
    law = NonlinearStiffness({"h": {"table": [(0, 0), (1, 1)]}})
    assert lamc.load_scene(scene).effects == (law,)


def test_scene_files_give_laws_with_units_and_take_them_back() -> None:
    data = {
        "a": "3 N*mm/deg",
        "b": ["3 N*mm/deg", 0, "2 N*m/rad^3"],
        "c": {"table": [["-10 deg", "-1 N*mm"], [0, 0], ["10 deg", "2 N*mm"]]},
        "d": {"energy": "angle^2"},
        "e": "sin(angle)",
    }
    scene = read_scene({"effects": {"nonlinear_stiffness": data}})
    assert scene.effects is not None
    (effect,) = scene.effects
    linear = 3e-3 * 180.0 / math.pi
    assert isinstance(effect, NonlinearStiffness)
    assert effect.laws["a"] == pytest.approx((linear,), rel=1e-15)
    assert effect.laws["b"] == pytest.approx((linear, 0.0, 2.0), rel=1e-15)
    assert read_scene(scene_data(scene)).effects == (effect,)
    assert hash(effect) == hash(NonlinearStiffness(effect.laws))
    with pytest.raises(DesignError, match=r"nonlinear_stiffness\.c\.table\[0\]\[0\].*not a unit of angle"):
        read_scene({"effects": {"nonlinear_stiffness": {"c": {"table": [["10 kg", 0], [1, 1]]}}}})


def test_a_joint_that_is_not_there_is_refused_by_name() -> None:
    with pytest.raises(DesignError, match="no joint is named 'knee'; the joints are h0"):
        lamc.compile(chain(1), Scene(effects=(NonlinearStiffness({"knee": [1.0]}),)))
