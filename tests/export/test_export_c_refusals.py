"""What exported C refuses, and that it then leaves an instance as it was."""

import math
import subprocess
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from lamc import Body, FreeBase, Joint, Mechanism, Scene
from lamc.export.options import ExportOptions
from tests.support.ctools import needs_cc
from tests.support.exported import Exported, c_files
from tests.support.exported_folders import mechanism_of
from tests.support.floating import lone_body

pytestmark = needs_cc


@pytest.fixture(scope="module")
def pendulum(tmp_path_factory: pytest.TempPathFactory) -> Exported:
    return Exported(c_files(mechanism_of("pendulum")), tmp_path_factory.mktemp("pendulum"))


@pytest.fixture(scope="module")
def four_bar(tmp_path_factory: pytest.TempPathFactory) -> Exported:
    return Exported(c_files(mechanism_of("four_bar")), tmp_path_factory.mktemp("four_bar"))


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
    plausible = pendulum.ffi.new(f"{pendulum.prefix}_settings *", {"rtol": 1e-6, "max_steps": 1000})
    assert pendulum.call("init", it, null, plausible) == pendulum.status("BAD_DIGEST")
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


def test_parameters_that_nature_does_not_allow(pendulum: Exported) -> None:
    """A mass is above zero, a stiffness and a damping are not below it; the header says so beside each."""
    it = pendulum.instance()
    before = bytes_of(pendulum, it)
    text = (pendulum.folder / f"{pendulum.prefix}.h").read_text()
    for ending, values, least in (
        ("_mass", (0.0, -0.01), "> 0; "),
        ("_stiffness", (-1e-9,), ">= 0; "),
        ("_damping", (-1.0,), ">= 0; "),
        ("_inertia_xx", (-1e-12,), ">= 0; "),
    ):
        parameters = pendulum.new("parameters")
        pendulum.call("default_parameters", parameters)
        fields = [name for name, _ in pendulum.ffi.typeof(parameters[0]).fields if name.endswith(ending)]
        line = next(line for line in text.splitlines() if line.startswith(f"  double {fields[0]};"))
        assert least in line
        for value in values:
            setattr(parameters, fields[0], value)
            refused = pendulum.status("BAD_PARAMETER")
            assert pendulum.call("set_parameters", it, parameters) == refused
            assert pendulum.call("init", it, parameters, pendulum.ffi.NULL) == refused
        setattr(parameters, fields[0], 0.0 if ending != "_mass" else 1e-3)
        assert pendulum.call("set_parameters", pendulum.instance(), parameters) == 0
    assert bytes_of(pendulum, it) == before


def test_a_state_that_the_caller_spoilt_is_no_reason_for_shorter_steps(pendulum: Exported) -> None:
    it = pendulum.instance()
    it.q[0] = math.nan
    assert pendulum.call("step_fixed", it, 1e-3) == pendulum.status("NOT_FINITE")


def test_steps_of_fixed_length_go_beyond_the_stop(pendulum: Exported) -> None:
    """As the header says: they read no settings."""
    it = pendulum.instance(t_stop=1e-3)
    assert pendulum.call("step_fixed", it, 2e-3) == 0
    assert it.t == 2e-3
    assert pendulum.call("step", it, 3e-3) == pendulum.status("BAD_ARGUMENT")


def test_steps_of_fixed_length_that_blow_up(pendulum: Exported) -> None:
    """Half a second is far beyond the hinges' period. The instance stays as it was, and goes on from there."""
    it, calm = pendulum.instance(), pendulum.instance()
    assert pendulum.call("step", it, 0.1) == 0
    assert pendulum.call("step", calm, 0.1) == 0
    statuses = []
    for _ in range(20):
        before = bytes_of(pendulum, it)
        statuses.append(pendulum.call("step_fixed", it, 0.5))
        if statuses[-1] != 0:
            assert bytes_of(pendulum, it) == before
            break
    assert statuses[-1] == pendulum.status("STEP_TOO_LONG")
    assert max(map(abs, it.q)) < 20 * math.pi  # no more than the half turns that were let through
    if len(statuses) == 1:
        assert pendulum.call("step", it, 0.2) == 0
        assert pendulum.call("step", calm, 0.2) == 0
        assert pendulum.state(it) == pendulum.state(calm)


def spinning(kind: str) -> tuple[Mechanism, Scene]:
    """What nothing acts on: a plate on a hinge through its centre, or a sphere that floats."""
    if kind == "floating":
        return lone_body(1.0, np.eye(3)), Scene(effects=(FreeBase(),))
    bodies = (Body("ground", fixed=True), Body("plate", 1.0, np.zeros(3), np.diag([1.0, 1.0, 2.0]) / 12.0))
    return Mechanism(bodies, (Joint("h", "ground", "plate"),), name="plate"), Scene()


@pytest.mark.parametrize("kind", ["hinged", "floating"])
@pytest.mark.quick("hinged")
def test_a_fast_spin_that_steps_resolve(kind: str, tmp_path: Path) -> None:
    """1000 rad/s: one radian in a step of a millisecond, and four in one of four, which is more than half a turn. A
    rate that nothing changes stays but for round-off."""
    exported = Exported(c_files(*spinning(kind)), tmp_path)
    it, nu = exported.instance(), exported.constant("rate_count")
    q, u = exported.ffi.new("double[]", list(it.q)), exported.ffi.new("double[]", nu)
    u[nu - 1] = 1000.0
    assert exported.call("start", it, 0.0, q, u) == 0
    for _ in range(10):
        assert exported.call("step_fixed", it, 1e-3) == 0
    assert it.u[nu - 1] == pytest.approx(1000.0, rel=1e-12)
    before = bytes_of(exported, it)
    assert exported.call("step_fixed", it, 4e-3) == exported.status("STEP_TOO_LONG")
    assert bytes_of(exported, it) == before


def fnv_1a(data: bytes) -> int:
    """RFC 9923, 64 bits."""
    value = 0xCBF29CE484222325
    for byte in data:
        value = (value ^ byte) * 0x100000001B3 % 2**64
    return value


def test_a_saved_state_that_was_damaged(pendulum: Exported) -> None:
    """One byte anywhere. The sum is that of the RFC, whose vector for "foobar" is 85944171f73967e8."""
    assert fnv_1a(b"foobar") == 0x85944171F73967E8
    it, kept, other = pendulum.instance(t_stop=1.0), pendulum.new("state"), pendulum.instance()
    assert pendulum.call("step", it, 0.3) == 0
    assert pendulum.call("get_state", it, kept) == 0
    assert kept.sum_ == fnv_1a(bytes_of(pendulum, it))
    before, whole = bytes_of(pendulum, other), pendulum.ffi.buffer(kept)
    refused = {pendulum.status("BAD_STATE"), pendulum.status("BAD_DIGEST")}
    for place in range(len(whole)):
        good = whole[place]
        whole[place] = bytes([good[0] ^ 0x40])
        assert pendulum.call("set_state", other, kept) in refused
        whole[place] = good
    assert bytes_of(pendulum, other) == before
    assert pendulum.call("set_state", other, kept) == 0
    assert bytes_of(pendulum, other) == bytes_of(pendulum, it)


def test_a_saved_state_whose_sum_is_right_and_numbers_are_not(pendulum: Exported) -> None:
    """Nothing that leads beyond an array is taken, whoever made the state."""
    it, kept, other = pendulum.instance(t_stop=1.0), pendulum.new("state"), pendulum.instance()
    assert pendulum.call("step", it, 0.3) == 0
    assert pendulum.call("get_state", it, kept) == 0
    before = bytes_of(pendulum, other)

    def answer(spoil: Callable[[Any], None]) -> int:
        state = pendulum.new("state")
        state[0] = kept[0]
        spoil(state.instance_)
        state.sum_ = fnv_1a(bytes(pendulum.ffi.buffer(pendulum.ffi.addressof(state[0], "instance_"))))
        return int(pendulum.call("set_state", other, state))

    def put(name: str, i: int, value: float) -> Callable[[Any], None]:
        return lambda instance: getattr(instance, name).__setitem__(i, value)

    bad = pendulum.status("BAD_STATE")
    assert answer(lambda instance: setattr(instance, "t", math.nan)) == bad
    assert answer(put("q", 0, math.nan)) == bad
    assert answer(put("u", 0, math.inf)) == bad
    assert answer(put("parameters_", 0, math.nan)) == bad
    assert answer(lambda instance: setattr(instance.settings_, "rtol", math.nan)) == bad
    assert answer(put("flags_", 0, 3)) == bad
    assert answer(put("flags_", 1, -1)) == bad
    for i in range(len(kept.instance_.integers_)):
        for value in (-2, 2**62):
            assert answer(put("integers_", i, value)) == bad
    assert bytes_of(pendulum, other) == before
    assert answer(lambda instance: None) == 0


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


@pytest.mark.slow
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
        ("crawler", ExportOptions()),
        ("four_bar", ExportOptions(integrator="rk45")),
        ("pendulum", ExportOptions(real_time=True, jacobian=False)),
    ):
        files = c_files(mechanism_of(name), options=options)
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
