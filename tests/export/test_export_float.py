"""Exports in single precision: no doubles, motion that differs by round-off, time that does not drift, refusals."""

import math
import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import lamc
from lamc.basics.errors import ExportError
from lamc.effects.gravity import Gravity
from lamc.export import files_of
from lamc.export.amalgam.tokens import tokens
from lamc.export.package import state_bytes
from lamc.export.precision import in_precision
from tests.support.ctools import needs_cc
from tests.support.exported import C99, Exported
from tests.support.exported_folders import (
    STRICT,
    cc,
    compilers,
    does,
    exported,
    mechanism_of,
    needs,
    put,
    scene_of,
)

EPSILON = float(np.finfo(np.float32).eps)
MODELS = ("pendulum", "four_bar", "limit_stop", "crawler", "stiff_triple")


def single(name: str, folder: Path) -> Exported:
    return Exported(
        exported(name, real_time=True, precision="float"), folder / "float", (*C99, "-Wdouble-promotion")
    )


def states(model: Exported, h: float, count: int) -> tuple[Any, np.ndarray[Any, Any]]:
    """The instance, and its states after each of `count` steps."""
    it = model.instance()
    rows = []
    for _ in range(count):
        assert model.call("step_fixed", it, h) == 0
        rows.append(model.state(it))
    return it, np.array(rows)


@pytest.mark.parametrize("name", MODELS)
@pytest.mark.quick("pendulum", "stiff_triple", others="campaign")
def test_no_double_is_in_the_text(name: str) -> None:
    files = exported(name, real_time=True, precision="float")
    for file in (f"{name}.h", f"{name}.c"):
        for token in tokens(files[file].decode()):
            assert token.text not in ("double", "DBL_EPSILON", "DBL_MIN", "DBL_MAX")
            if token.kind == "number" and not token.text.startswith("0x"):
                assert not re.search(r"[.eE]", token.text) or token.text.endswith("f")


@needs_cc
@pytest.mark.parametrize("compiler", compilers())
@pytest.mark.parametrize("name", MODELS)
@pytest.mark.quick("pendulum-*", others="campaign")
def test_no_compiler_makes_a_double_of_a_float(name: str, compiler: list[str], tmp_path: Path) -> None:
    folder = put(exported(name, real_time=True, precision="float"), tmp_path)
    flags = ("-std=c99", *STRICT, "-Wdouble-promotion", "-O2", "-c", f"{name}.c", "-o", "it.o")
    cc(folder, *flags, command=compiler)


@needs("g++")
@pytest.mark.slow
def test_it_is_cxx_too(tmp_path: Path) -> None:
    folder = put(exported("crawler", real_time=True, precision="float"), tmp_path)
    cc(folder, "-x", "c++", "-std=c++17", *STRICT, "-c", "crawler.c", "-o", "it.o", command=["g++"])


@needs_cc
@pytest.mark.parametrize(
    ("name", "h", "count"),
    [("pendulum", 2.0**-10, 2000), ("four_bar", 2.0**-10, 2000), ("stiff_triple", 2.0**-15, 2000),
     ("limit_stop", 2.0**-13, 2000), ("crawler", 2.0**-15, 100)],
)  # fmt: skip
@pytest.mark.quick("pendulum-*", "limit_stop-*", others="campaign")
def test_motion_differs_from_that_of_doubles_by_round_off(
    name: str, h: float, count: int, tmp_path: Path
) -> None:
    """The same steps, exact in both precisions. Each may round the state once, and in a chain of impacts or a singular
    direction nothing here grows by more than it shrinks; the crawler's contacts do grow, so it runs briefly."""
    other = Exported(exported(name, real_time=True, libm=False), tmp_path / "double")
    _, there = states(other, h, count)
    it, here = states(single(name, tmp_path), h, count)
    size = np.max(np.abs(there), axis=0)
    growing = np.arange(1, count + 1)[:, np.newaxis]
    # One rounding of half a unit for each step, all the same way; those of rates come into the angles over the time.
    bound = 0.5 * EPSILON * growing * max(1.0, float(size.max()))
    assert np.all(np.abs(here - there) <= bound)
    assert np.max(np.abs(here - there)) > 0.0  # it is single precision
    assert it.t == count * h


@needs_cc
def test_a_stop_too_stiff_for_the_step_ends_both_precisions_alike(tmp_path: Path) -> None:
    """The damper of the tongue's stop has an eigenvalue of 9300 /s, and the method is stable up to 2.785 over that,
    0.3 ms: in longer steps a contact grows, in doubles as in floats, until a step turns the tongue by more than half a
    turn. At 0.2 ms the motion comes to rest, where the two differ by round-off that the stops damp."""
    other = Exported(exported("limit_stop", real_time=True, libm=False), tmp_path / "double")
    model = single("limit_stop", tmp_path)
    for h in (2e-3, 1e-3, 5e-4):
        counts = []
        for each in (model, other):
            it, count, status = each.instance(), 0, 0
            while status == 0 and count < 1000:
                status = each.call("step_fixed", it, h)
                count += 1
            assert status == each.status("STEP_TOO_LONG")
            assert all(map(math.isfinite, each.state(it)))
            counts.append(count)
        assert counts[0] == counts[1]
    rest = [states(each, 2e-4, 10_000)[1][-1] for each in (model, other)]
    assert np.abs(rest[0] - rest[1])[:2].max() < 1e-4  # rad, of swings of 1 rad, after a dozen blows
    assert np.abs(rest).max() < 0.2  # the flap lies on its stop


@needs_cc
def test_a_step_to_infinity_is_too_long_and_a_slope_that_is_infinite_is_not_finite(tmp_path: Path) -> None:
    """Accelerations go with the square of rates: 1e18 rad/s give 1e36 rad/s^2, and no float at the next stage; 1e20
    rad/s give none at the start, which no step mends."""
    model = single("pendulum", tmp_path)
    for rate, reported in ((1e18, "STEP_TOO_LONG"), (1e20, "NOT_FINITE")):
        it = model.instance()
        q, u = model.ffi.new("float[3]", [0.3, 0.2, 0.1]), model.ffi.new("float[3]", [rate, 0.0, 0.0])
        assert model.call("start", it, 0.0, q, u) == 0
        before = model.state(it)
        assert model.call("step_fixed", it, 1e-3) == model.status(reported)
        assert model.state(it) == before


@needs_cc
def test_time_does_not_drift(tmp_path: Path) -> None:
    """A hundred thousand steps of 1 ms, which no float holds: a plain sum of floats would be off by some of them."""
    model = single("pendulum", tmp_path)
    h, count = float(np.float32(1e-3)), 100_000
    it = model.instance()
    plain = np.float32(0.0)
    for _ in range(count):
        model.call("step_fixed", it, h)
        plain += np.float32(h)
    assert it.t == np.float32(count * h)
    assert abs(float(plain) - count * h) > 0.01  # what would have come of it


@needs_cc
@pytest.mark.slow
def test_kept_states_go_on_with_the_same_bits(tmp_path: Path) -> None:
    model = single("four_bar", tmp_path)
    it, _ = states(model, 1e-3, 37)
    kept, other = model.new("state"), model.instance()
    assert model.call("get_state", it, kept) == 0
    assert model.call("set_state", other, kept) == 0
    for _ in range(50):
        assert model.call("step_fixed", it, 1e-3) == 0
        assert model.call("step_fixed", other, 1e-3) == 0
    assert model.state(it) == model.state(other)
    assert it.t == other.t


@needs_cc
def test_what_is_not_finite_is_refused(tmp_path: Path) -> None:
    model = single("pendulum", tmp_path)
    it = model.instance()
    before = model.state(it)
    for bad in (float("nan"), float("inf"), -float("inf"), 1e39):
        q = model.ffi.new("float[3]", [0.0, bad, 0.0])
        u = model.ffi.new("float[3]")
        assert model.call("start", it, 0.0, q, u) == model.status("BAD_STATE")
        assert model.call("step_fixed", it, bad) == model.status("BAD_ARGUMENT")
    assert model.state(it) == before


@pytest.mark.quick("pendulum")
@needs_cc
@pytest.mark.parametrize("name", ["pendulum", "four_bar"])
def test_derivatives_are_those_of_doubles_to_their_digits(name: str, tmp_path: Path) -> None:
    found = []
    for model in (
        single(name, tmp_path),
        Exported(exported(name, real_time=True, libm=False), tmp_path / "double"),
    ):
        real = "float" if not found else "double"
        nq, nu, ni = (model.constant(f"{what}_count") for what in ("coordinate", "rate", "input"))
        parts = [model.ffi.new(f"{real}[]", nu * n) for n in (nq, nu, ni)]
        assert model.call("jacobian", model.instance(), *parts) == 0
        found.append([np.array(list(part)) for part in parts])
    for here, there, part in zip(*found, ("q", "u", "inputs"), strict=True):
        # Analytic ones: some hundred roundings. By inputs: round-off over a step that is its cube root, and the
        # accelerations are linear in them.
        tolerance = 100 * EPSILON if part != "inputs" else 100 * EPSILON ** (2.0 / 3.0)
        assert np.max(np.abs(here - there)) <= tolerance * max(1.0, float(np.max(np.abs(there))))


@needs_cc
@pytest.mark.parametrize("name", MODELS)
@pytest.mark.quick("pendulum", "stiff_triple")
def test_bytes_of_an_instance_are_those_told(name: str, tmp_path: Path) -> None:
    from lamc.export.c import c_source
    from lamc.export.driven import simulator_of

    model = single(name, tmp_path)
    options = lamc.ExportOptions(real_time=True, precision="float")
    source = c_source(simulator_of(mechanism_of(name), scene_of(name), options), options)
    assert model.ffi.sizeof(f"{model.prefix}_t") == state_bytes(source)


@needs_cc
@pytest.mark.parametrize("name", ["pendulum", pytest.param("four_bar", marks=pytest.mark.slow)])
@pytest.mark.slow
@pytest.mark.ci("pendulum")
def test_compilers_agree_to_the_last_bit(name: str, tmp_path: Path) -> None:
    """The example of the folder prints all digits."""
    printed = []
    for parameter in compilers():
        if any(mark.args[0] for mark in parameter.marks):  # type: ignore[attr-defined]
            continue
        (command,) = parameter.values  # type: ignore[attr-defined]
        for level in ("-O0", "-O2", "-O3"):
            folder = put(exported(name, real_time=True, precision="float"), tmp_path / f"{len(printed)}")
            flags = ("-std=c99", level, "-ffp-contract=off", "example_main.c", f"{name}.c", "-o", "example")
            cc(folder, *flags, command=command)
            printed.append(does([folder / "example"], folder))
    assert len(printed) >= 3
    assert len(set(printed)) == 1


def test_steps_that_control_errors_are_refused() -> None:
    with pytest.raises(ExportError, match="--real-time"):
        files_of(mechanism_of("pendulum"), options=lamc.ExportOptions(precision="float"))


@pytest.mark.parametrize("value", [1e-42, 1e-60])
def test_parameters_that_no_float_holds_are_refused(value: float) -> None:
    mechanism = mechanism_of("pendulum")
    scene = replace(scene_of("pendulum"), effects=(Gravity((0.0, 0.0, value)),))
    with pytest.raises(ExportError, match="gravity"):
        files_of(mechanism, "c", scene, lamc.ExportOptions(real_time=True, precision="float"))


def test_constants_become_the_nearest_floats() -> None:
    text = "lamc_real a = LAMC_R(0.1), b = 3; /* 0.1 */"
    assert in_precision(text, "float", "it.c") == "float a = 0.1f, b = 3; /* 0.1 */"
    assert in_precision(text, "double", "it.c") == "double a = 0.1, b = 3; /* 0.1 */"
    assert in_precision("(LAMC_R(-1e3))", "float", "it.c") == "(-1000.0f)"
    with pytest.raises(ExportError, match=r"it\.c"):
        in_precision("x = LAMC_R(1e-300);", "float", "it.c")
