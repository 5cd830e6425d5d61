"""What exported C refuses, and that it then leaves an instance as it was."""

import math
import subprocess
from pathlib import Path

import numpy as np
import pytest

from lamc.export.options import ExportOptions
from tests.ctools import needs_cc
from tests.exported import Exported, c_files
from tests.test_export_c import example

pytestmark = needs_cc


@pytest.fixture(scope="module")
def pendulum(tmp_path_factory: pytest.TempPathFactory) -> Exported:
    return Exported(c_files(example("pendulum.yaml")), tmp_path_factory.mktemp("pendulum"))


@pytest.fixture(scope="module")
def four_bar(tmp_path_factory: pytest.TempPathFactory) -> Exported:
    return Exported(c_files(example("four_bar.yaml")), tmp_path_factory.mktemp("four_bar"))


def bytes_of(exported: Exported, struct: object) -> bytes:
    return bytes(exported.ffi.buffer(struct))


def test_wrong_times_and_steps(pendulum: Exported) -> None:
    it = pendulum.instance(t_stop=1.0)
    assert pendulum.call("step", it, 0.5) == 0
    before = bytes_of(pendulum, it)
    for target, status in (
        (0.4, "IN_PAST"),
        (math.nan, "BAD_ARGUMENT"),
        (math.inf, "BAD_ARGUMENT"),
        (1.5, "BAD_ARGUMENT"),  # beyond t_stop
        (0.5, "OK"),
    ):
        assert pendulum.call("step", it, target) == pendulum.status(status)
    for h in (0.0, -1e-3, math.nan, math.inf):
        assert pendulum.call("step_fixed", it, h) == pendulum.status("BAD_ARGUMENT")
    assert bytes_of(pendulum, it) == before


def test_null_and_structs_that_were_never_initialised(pendulum: Exported) -> None:
    null, it = pendulum.ffi.NULL, pendulum.instance()
    raw, numbers = pendulum.new("t"), pendulum.ffi.new("double[100]")
    calls = {
        "step": (0.1,),
        "step_fixed": (0.1,),
        "start": (0.0, numbers, numbers),
        "set_parameters": (null,),
        "set_inputs": (null,),
        "rhs": (0.0, numbers, numbers),
        "get_outputs": (pendulum.new("outputs"),),
        "energy": (numbers,),
        "jacobian": (numbers, numbers, null),
        "get_state": (pendulum.new("state"),),
    }
    for name, arguments in calls.items():
        assert pendulum.call(name, null, *arguments) == pendulum.status("BAD_ARGUMENT")
        assert pendulum.call(name, raw, *arguments) == pendulum.status("BAD_DIGEST")
        if arguments[-1] == null or name in ("rhs", "get_outputs", "energy", "get_state"):
            wanted = null if name != "jacobian" else numbers
            spoilt = (*arguments[:-1], null) if name != "jacobian" else (null, wanted, null)
            assert pendulum.call(name, it, *spoilt) == pendulum.status("BAD_ARGUMENT")
    assert pendulum.call("init", null, null, null) == pendulum.status("BAD_ARGUMENT")
    assert pendulum.call("set_state", it, pendulum.new("state")) == pendulum.status("BAD_DIGEST")
    assert pendulum.call("init", it, pendulum.new("parameters"), null) == pendulum.status("BAD_DIGEST")
    for name in ("parameters", "inputs", "settings"):
        pendulum.call(f"default_{name}", null)


def test_structs_of_another_design(pendulum: Exported, four_bar: Exported) -> None:
    """Also of the same design with another integrator, whose instances keep other numbers."""
    other = four_bar.instance()
    it, state = pendulum.instance(), pendulum.new("state")
    size = min(len(bytes_of(four_bar, other)), len(bytes_of(pendulum, state)))
    pendulum.ffi.memmove(state, bytes_of(four_bar, other)[:size], size)
    before = bytes_of(pendulum, it)
    assert pendulum.call("set_state", it, state) == pendulum.status("BAD_DIGEST")
    parameters = pendulum.new("parameters")
    pendulum.call("default_parameters", parameters)
    parameters.digest_[0] ^= 1
    assert pendulum.call("set_parameters", it, parameters) == pendulum.status("BAD_DIGEST")
    assert bytes_of(pendulum, it) == before


def test_numbers_that_are_none(pendulum: Exported) -> None:
    it, parameters = pendulum.instance(), pendulum.new("parameters")
    pendulum.call("default_parameters", parameters)
    before = bytes_of(pendulum, it)
    field = pendulum.ffi.typeof(parameters[0]).fields[1][0]
    setattr(parameters, field, math.nan)
    assert pendulum.call("set_parameters", it, parameters) == pendulum.status("BAD_PARAMETER")
    numbers = pendulum.ffi.new("double[]", [math.inf] * 20)
    fine = pendulum.ffi.new("double[20]")
    assert pendulum.call("start", it, 0.0, numbers, fine) == pendulum.status("BAD_STATE")
    assert pendulum.call("start", it, math.nan, fine, fine) == pendulum.status("BAD_ARGUMENT")
    assert pendulum.call("rhs", it, 0.0, numbers, fine) == pendulum.status("BAD_STATE")
    assert bytes_of(pendulum, it) == before
    for name, value in (("rtol", 0.0), ("atol", -1.0), ("max_step", math.nan), ("t_stop", math.nan)):
        settings = pendulum.new("settings")
        pendulum.call("default_settings", settings)
        setattr(settings, name, value)
        assert pendulum.call("init", it, pendulum.ffi.NULL, settings) == pendulum.status("BAD_ARGUMENT")
    assert bytes_of(pendulum, it) == before


def test_a_start_is_closed_or_refused(four_bar: Exported) -> None:
    """Of starts all over the place each is either brought to closure or leaves the instance alone; those a little off
    are closed."""
    rng = np.random.default_rng(1)
    drawn, count = four_bar.state(four_bar.instance()), four_bar.constant("coordinate_count")
    outcomes = set()
    for spread in (1e-3, 3.0):
        for _ in range(20):
            it, outputs = four_bar.instance(), four_bar.new("outputs")
            before = bytes_of(four_bar, it)
            q = four_bar.ffi.new("double[]", list(np.array(drawn[:count]) + spread * rng.normal(size=count)))
            status = four_bar.call("start", it, 0.5, q, four_bar.ffi.new("double[]", drawn[count:]))
            if status == 0:
                assert four_bar.call("get_outputs", it, outputs) == 0
                assert outputs.closure < 1e-10  # m; settled to 1e-13 of some centimetres
                assert it.t == 0.5
            else:
                assert status == four_bar.status("BAD_STATE")
                assert bytes_of(four_bar, it) == before
            outcomes.add((spread, status))
    assert (1e-3, 0) in outcomes
    assert (1e-3, four_bar.status("BAD_STATE")) not in outcomes


def test_messages_and_names_out_of_range(pendulum: Exported) -> None:
    ffi = pendulum.ffi
    for number in (*range(-30, 5), 12345):
        status = ffi.cast(f"{pendulum.prefix}_status", number)
        assert ffi.string(pendulum.call("status_message", status))
    for what in ("joint", "coordinate", "rate", "parameter", "input", "body", "energy"):
        for i in (-1, 10_000):
            assert pendulum.call(f"{what}_name", i) == ffi.NULL


def test_no_writable_data_and_nothing_but_libm(tmp_path: Path) -> None:
    """memcpy and memset are what compilers make of copies, whatever the source says."""
    allowed = {"memcpy", "memset", "memmove"}
    libm = {
        "sin",
        "cos",
        "sincos",
        "tan",
        "exp",
        "log",
        "pow",
        "sqrt",
        "fmax",
        "fmin",
        "atan2",
        "floor",
        "hypot",
    }
    for name, options in (
        ("crawler.yaml", ExportOptions()),
        ("four_bar.yaml", ExportOptions(integrator="rk45")),
        ("pendulum.yaml", ExportOptions(real_time=True, jacobian=False)),
    ):
        files = c_files(example(name), options=options)
        source = next(n for n in files if n.endswith(".c"))
        text = files[source].decode()
        assert "malloc" not in text
        included = {
            line.split("<")[1].rstrip(">") for line in text.splitlines() if line.startswith("#include <")
        }
        assert included <= {"float.h", "limits.h", "math.h", "stddef.h", "stdint.h"}
        for n, content in files.items():
            (tmp_path / n).write_bytes(content)
        subprocess.run(
            ["cc", "-std=c99", "-O2", "-fno-pic", "-c", source, "-o", "x.o"], cwd=tmp_path, check=True
        )
        table = subprocess.run(["nm", "x.o"], cwd=tmp_path, capture_output=True, text=True, check=True).stdout
        symbols = [line.split()[-2:] for line in table.splitlines()]
        assert {s for kind, s in symbols if kind == "U"} <= allowed | libm
        assert not [s for kind, s in symbols if kind in "dDbBcC"]
        prefix = source.removesuffix(".c")
        assert all(s.startswith(f"{prefix}_") for kind, s in symbols if kind.isupper() and kind != "U")
