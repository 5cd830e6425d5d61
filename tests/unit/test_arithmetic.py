"""Other arithmetic than plain double: fused operations, single precision and its floor."""

from pathlib import Path

import numpy as np
import pytest

import lamc
from lamc import CompileOptions, examples
from lamc.basics.errors import BuildError
from lamc.codegen import layout
from lamc.codegen.cache import Cache
from lamc.commands.examples import mechanism_of_example
from lamc.ledger.arithmetic import variants
from lamc.run.simulator import Simulator
from tests.physics.test_integrators import triple

FLOAT = CompileOptions(precision="float")
EPS32 = float(np.finfo(np.float32).eps)


def test_no_variant_takes_nan_for_a_number() -> None:
    for _, options in variants(CompileOptions()):
        assert not {"-ffast-math", "-Ofast", "-ffinite-math-only"} & set(options.flags)


def compiled(name: str, options: CompileOptions) -> Simulator:
    return lamc.compile(mechanism_of_example(examples.find(name)), options=options)


def states(sim: Simulator) -> tuple[np.ndarray, np.ndarray]:
    rows = sim.run(1.0, 1e-8, 1e-10, np.linspace(0.0, 1.0, 40))
    return rows.q, rows.u


@pytest.mark.parametrize("name", ["pendulum", "four_bar", "flaps"])
@pytest.mark.slow
def test_fast_accelerations_are_those_of_double(name: str) -> None:
    plain = compiled(name, CompileOptions())
    q, u = states(plain)
    fast = compiled(name, CompileOptions(fast=True))
    exact = plain.acceleration(q, u)
    # Round-off, as the mass matrix's condition makes of it: 1e4 at most in these.
    np.testing.assert_allclose(fast.acceleration(q, u), exact, rtol=0, atol=1e-12 * np.abs(exact).max())


@pytest.mark.parametrize("name", ["pendulum", "four_bar", "flaps"])
@pytest.mark.quick("four_bar", "flaps")
def test_single_precision_is_single(name: str) -> None:
    plain, single = compiled(name, CompileOptions()), compiled(name, FLOAT)
    q, u = states(plain)
    exact = plain.acceleration(q, u)
    off = np.abs(single.acceleration(q, u) - exact).max() / np.abs(exact).max()
    assert (
        EPS32 / 100 < off < 1e4 * EPS32
    )  # some digits go where the mass matrix is factored, and no double is left
    assert single.program.digest == plain.program.digest
    assert "-DLAMC_FLOAT" in single.run(0.01).provenance.flags


def test_single_precision_has_a_floor_that_tolerances_do_not_lower() -> None:
    """A pendulum's end after 2 s: errors of single accelerations stay, whatever the tolerance."""
    plain = triple(0.0)
    single = lamc.compile(plain.mechanism, plain.scene, FLOAT)
    exact = plain.run(2.0, 1e-12, 1e-14, [2.0], "dop853").q
    ends = [single.run(2.0, rtol, 1e-2 * rtol, [2.0], "rk45").q for rtol in (1e-6, 1e-7)]
    errors = [float(np.abs(end - exact).max()) for end in ends]
    assert all(1e-9 < error < 1e-3 for error in errors)
    double = plain.run(2.0, 1e-9, 1e-11, [2.0], "rk45").q
    assert np.abs(double - exact).max() < min(errors)


def test_loops_close_in_double_whatever_the_accelerations_are() -> None:
    sim = compiled("four_bar", FLOAT)
    result = sim.run(1.0, 1e-5, 1e-7)
    assert result.success, result.message
    assert result.constraint_error.max() <= 1e-9 * sim.mechanism.size  # what lamc promises for any run


@pytest.mark.slow
def test_kernels_are_single_too(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """Functions that are too long for one block, as those of a hundred hinges are."""
    mechanism = mechanism_of_example(examples.find("pendulum"))
    exact = lamc.compile(mechanism, options=CompileOptions())
    monkeypatch.setattr(layout, "MAX_BLOCK_AT_EVERY_STEP", 10)
    single = lamc.compile(mechanism, options=FLOAT, cache=Cache(tmp_path))
    text = "".join(path.read_text(encoding="utf-8") for path in single.source_dir.glob("pendulum.c"))
    assert "const float" in text
    q, u = states(exact)
    truth = exact.acceleration(q, u)
    off = np.abs(single.acceleration(q, u) - truth).max() / np.abs(truth).max()
    assert EPS32 / 100 < off < 1e4 * EPS32


def test_the_ledger_compares_double_fast_and_float() -> None:
    assert [name for name, _ in variants(CompileOptions())] == ["double", "fast", "float", "fast float"]


@pytest.mark.parametrize("precision", ["half", 32, None])
def test_an_unknown_precision_is_refused(precision: object) -> None:
    with pytest.raises(BuildError, match="it must be 'double' or 'float'"):
        CompileOptions(precision=precision)  # type: ignore[arg-type]
