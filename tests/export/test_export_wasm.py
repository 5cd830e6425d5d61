"""Exports to WebAssembly: the bits of the same C compiled for this machine, errors, states, memory, and the page."""

import json
import struct
from collections.abc import Iterator, Mapping
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import lamc
from lamc.basics.errors import BuildError, ExportError
from lamc.export import files_of
from lamc.export.wasm_module import find_wasm_tools
from tests.support.browser import Page, browser, needs_browser
from tests.support.ctools import needs_cc
from tests.support.exported import Exported
from tests.support.exported_folders import DURATION, KINDS, does, exported, mechanism_of, needs, put, scene_of
from tests.support.mechanisms import Array
from tests.support.wasm import needs_wasm

pytestmark = [needs_cc, needs_wasm]


@cache
def in_wasm(name: str, **options: object) -> Mapping[str, bytes]:
    return files_of(mechanism_of(name), "wasm", scene_of(name), lamc.ExportOptions(**options))  # type: ignore[arg-type]


def in_node(files: Mapping[str, bytes], folder: Path, prefix: str, script: str) -> Any:
    """What a script writes into `result`, where `model` is what the module loads."""
    put(files, folder)
    (folder / "script.mjs").write_text(
        f'import {{ load, SimulatorError }} from "./{prefix}.mjs";\n'
        "const model = await load();\nlet result = null;\n"
        "const told = (work) => {\n"
        "  try { work(); return null; } catch (error) { return [error.code, error.message]; } };\n"
        f"{script}\nconsole.log(JSON.stringify(result));\n"
    )
    return json.loads(does(["node", "script.mjs"], folder))


def sections(module: bytes) -> Iterator[int]:
    """Numbers of the sections of a module, as WebAssembly's core specification 5.5 lays them out."""
    assert module[:8] == b"\0asm\1\0\0\0"
    place = 8
    while place < len(module):
        yield module[place]
        place, size, shift = place + 1, 0, 0
        while True:  # LEB128
            byte = module[place]
            size, shift, place = size | (byte & 0x7F) << shift, shift + 7, place + 1
            if byte < 0x80:
                break
        place += size
    assert place == len(module)


def state_of(bits: list[str]) -> list[float]:
    return [struct.unpack("<d", bytes.fromhex(each))[0] for each in bits]


BITS = """
const bits = (row) => Array.from(row, (x) => Buffer.from(new Float64Array([x]).buffer).toString("hex"));
"""


def motion_in_node(name: str, times: Array, folder: Path) -> Array:
    rows = in_node(
        in_wasm(name), folder, name,
        f"{BITS} const it = model.create({{ settings: {{ tStop: {float(times[-1])!r} }} }});\n"
        f"result = {json.dumps(times.tolist())}.map((t) => {{ it.step(t); return bits([...it.q, ...it.u]); }});",
    )  # fmt: skip
    return np.array([state_of(row) for row in rows])


def motion_here(name: str, times: Array, folder: Path) -> Array:
    """The same C, compiled for this machine."""
    native = Exported(exported(name, libm=False), folder)
    return native.trajectory(native.instance(t_stop=float(times[-1])), times)


# --- the module -------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", KINDS)
@pytest.mark.quick("pendulum", others="campaign")
def test_it_imports_nothing(name: str) -> None:
    found = list(sections(in_wasm(name)[f"{name}.wasm"]))
    assert 2 not in found  # imports
    assert {1, 3, 5, 7, 10} <= set(found)  # types, functions, memory, exports, code


def test_the_triple_pendulum_with_all_integrators_is_at_most_60_000_bytes() -> None:
    assert len(in_wasm("pendulum")["pendulum.wasm"]) <= 60_000


@pytest.mark.slow
def test_the_same_design_gives_the_same_bytes() -> None:
    again = files_of(mechanism_of("pendulum"), "wasm", scene_of("pendulum"), lamc.ExportOptions())
    assert dict(again) == dict(in_wasm("pendulum"))


@needs("node")
@pytest.mark.parametrize("name", KINDS)
@pytest.mark.quick("pendulum", others="campaign")
def test_the_motion_has_the_bits_of_the_native_one(name: str, tmp_path: Path) -> None:
    """Both have IEEE 754 arithmetic, no contraction and lamc's own functions: there is nothing to differ in."""
    times = np.linspace(0.0, DURATION[name], 21)[1:]
    there, here = motion_in_node(name, times, tmp_path / "node"), motion_here(name, times, tmp_path / "c")
    assert there.tobytes() == here.tobytes()


@needs("node")
def test_ten_seconds_of_the_triple_pendulum_have_the_bits_of_the_native_ones(tmp_path: Path) -> None:
    times = np.linspace(0.0, 10.0, 1001)[1:]
    there, here = (
        motion_in_node("pendulum", times, tmp_path / "node"),
        motion_here("pendulum", times, tmp_path / "c"),
    )
    assert there.tobytes() == here.tobytes()


@pytest.mark.slow
@needs("node")
def test_outputs_are_those_of_python(tmp_path: Path) -> None:
    """Of a mechanism with a loop, where it starts."""
    result = in_node(
        in_wasm("four_bar"), tmp_path, "four_bar",
        "const out = model.create().outputs();\n"
        "result = { ...out, angle: [...out.angle], pose: out.pose.map((p) => [...p]), energy: [...out.energy],\n"
        "  names: [model.joints, model.bodies, model.energies].map((all) => all.map((each) => each.name)) };",
    )  # fmt: skip
    simulator = lamc.compile(mechanism_of("four_bar"), scene_of("four_bar"))
    run = simulator.run(1e-3, t_eval=[0.0, 1e-3])
    joints, bodies, energies = result["names"]
    assert joints == list(simulator.joints)
    assert result["angle"] == [run.angle(name)[0] for name in joints]
    # Sums of energies come from products; round-off of each.
    assert result["totalEnergy"] == pytest.approx(sum(result["energy"]), rel=1e-14)
    for name, value in zip(energies, result["energy"], strict=True):
        assert value == pytest.approx(run.energies[name][0], rel=1e-12, abs=1e-18)
    assert len(bodies) == len(result["pose"])
    assert result["closure"] < 1e-9


# --- states, errors, memory -------------------------------------------------------------------------------------------


@needs("node")
@pytest.mark.slow
def test_a_state_goes_on_elsewhere_with_the_same_bits(tmp_path: Path) -> None:
    one, other = in_node(
        in_wasm("limit_stop"), tmp_path, "limit_stop",
        f"{BITS} const a = model.create(), b = model.create();\n"
        "a.step(0.2); const state = a.save(); a.step(0.4); b.restore(state); b.step(0.4);\n"
        "result = [a, b].map((it) => bits([it.t, ...it.q, ...it.u]));",
    )  # fmt: skip
    assert one == other


@needs("node")
def test_a_state_of_the_native_simulator_goes_on_in_node(tmp_path: Path) -> None:
    native = Exported(exported("pendulum", libm=False), tmp_path / "c")
    it, state = native.instance(), native.new("state")
    assert native.call("step", it, 0.3) == 0
    assert native.call("get_state", it, state) == 0
    (tmp_path / "state").write_bytes(bytes(native.ffi.buffer(state)))
    assert native.call("step", it, 0.7) == 0
    found = in_node(
        in_wasm("pendulum"), tmp_path / "node", "pendulum",
        f'{BITS} import {{ readFileSync }} from "node:fs";\nconst it = model.create();\n'
        'it.restore(new Uint8Array(readFileSync("../state"))); it.step(0.7); result = bits([...it.q, ...it.u]);',
    )  # fmt: skip
    assert state_of(found) == native.state(it)


@needs("node")
@pytest.mark.slow
def test_refusals_name_what_is_wrong_and_leave_the_simulator_as_it_was(tmp_path: Path) -> None:
    put({f"other_{n}": c for n, c in in_wasm("limit_stop").items() if n.endswith(".mjs")}, tmp_path)
    put(in_wasm("limit_stop"), tmp_path)
    result = in_node(
        in_wasm("pendulum"), tmp_path, "pendulum",
        'import * as others from "./limit_stop.mjs";\nconst stranger = (await others.load()).create();\n'
        "const it = model.create(); it.step(0.5); const before = [it.t, ...it.q, ...it.u];\n"
        "const marked = it.save(); marked.fill(0);\n"
        "result = { nan: told(() => it.step(NaN)), past: told(() => it.step(0.4)),\n"
        "  other: told(() => it.restore(stranger.save())),\n"
        "  zeros: told(() => it.restore(marked)), negative: told(() => it.stepFixed(-1e-3)),\n"
        "  state: told(() => it.start(0, [NaN, 0, 0], [0, 0, 0])), short: told(() => it.start(0, [0], [0, 0, 0])),\n"
        "  parameter: told(() => it.setParameters({ link_1_mass: Infinity })),\n"
        "  unknown: told(() => it.setParameters({ mass: 1 })),\n"
        "  input: told(() => it.setInputs({ h1_torque: NaN })),\n"
        "  setting: told(() => model.create({ settings: { rtol: 2 } })),\n"
        '  text: told(() => it.step("1")),\n'
        '  same: JSON.stringify(before) === JSON.stringify([it.t, ...it.q, ...it.u]) };\n'
        "it.free(); result.freed = told(() => it.step(1));",
    )  # fmt: skip
    codes = {what: found[0] for what, found in result.items() if isinstance(found, list)}
    assert codes == {
        "nan": "BAD_ARGUMENT",
        "past": "IN_PAST",
        "other": "BAD_DIGEST",
        "zeros": "BAD_DIGEST",
        "negative": "BAD_ARGUMENT",
        "state": "BAD_STATE",
        "short": None,
        "parameter": "BAD_PARAMETER",
        "unknown": None,
        "input": "BAD_INPUT",
        "setting": "BAD_ARGUMENT",
        "text": None,
        "freed": None,
    }
    assert "lies before the present one" in result["past"][1]
    assert '"mass"' in result["unknown"][1]
    assert "link_1_mass" in result["unknown"][1]
    assert "q has length 1; it takes 3 numbers" in result["short"][1]
    assert result["same"] is True


@pytest.mark.slow
@needs("node")
def test_what_is_no_name_and_no_number_is_reported_in_one_line(tmp_path: Path) -> None:
    calls = {
        "model.create({ parms: {} })": 'there is no option "parms"; did you mean "parameters"?',
        "model.create({ inputs: {} })": 'there is no option "inputs"; there are parameters, settings',
        "model.create(null)": "options are an object of names and values, not null",
        "model.create({ parameters: [1] })": "parameters are an object of names and values, not [1]",
        'it.setParameters({ "h1.damping": 1 })': 'there is no parameter "h1.damping"; did you mean "h1_damping"?',
        "model.create({ settings: { rtoll: 1 } })": 'there is no setting "rtoll"; did you mean "rtol"?',
        "model.create({ settings: { rtol: 2 } })": "create({settings: {rtol: 2}}): a number is not finite or outside",
        "it.step()": "the time is missing; give a number",
        "it.step(NaN)": "step(NaN) at t = 0.5 s: a number is not finite or outside its range",
        'it.step("1")': 'the time is "1"; give a number',
        "it.step(0.4)": "step(0.4) at t = 0.5 s: the time asked for lies before the present one",
        "it.stepFixed()": "the step is missing; give a number",
        "it.start(0)": "q is missing; it takes 3 numbers",
        'it.start(0, [0, 0, "a"], [0, 0, 0])': 'q[2] is "a"; give a number',
        "it.setParameters()": "parameters are an object of names and values, not undefined",
        "it.setInputs({ h1_torqe: 1 })": 'there is no input "h1_torqe"; did you mean "h1_torque"?',
        "it.setInputs({ h1_torque: NaN })": "setInputs({h1_torque: NaN}): an input is not finite",
        "it.rhs(0, [1])": "y has length 1; it takes 6 numbers",
        "it.restore([1, 2])": "restore takes the Uint8Array that save gave, not [1, 2]",
        "it.restore(new Uint8Array(4))": "restore(4 bytes): a state of another design, or none",
        "load(5)": "load takes an address, bytes or a module of WebAssembly, not 5",
        'load(readFileSync("limit_stop.wasm"))': "the module is that of another export, limit_stop, digest ",
        "load(Uint8Array.of(0, 97, 115, 109, 1, 0, 0, 0))": "the module is none that lamc made",
    }
    put({n: c for n, c in in_wasm("limit_stop").items() if n.endswith(".wasm")}, tmp_path)
    found = in_node(
        in_wasm("pendulum"), tmp_path, "pendulum",
        'import { readFileSync } from "node:fs";\nconst it = model.create(); it.step(0.5); result = [];\n'
        f"for (const call of {json.dumps(list(calls))}) {{\n"
        "  try { await eval(call); result.push(null); } catch (error) { result.push(error.message); }\n}",
    )  # fmt: skip
    for call, reported, expected in zip(calls, found, calls.values(), strict=True):
        assert reported is not None, call
        assert reported.startswith(f"pendulum: {expected}"), call
        assert "\n" not in reported


@needs("node")
def test_inputs_act_and_stay_with_a_state(tmp_path: Path) -> None:
    result = in_node(
        in_wasm("pendulum"), tmp_path, "pendulum",
        "const it = model.create(); const free = it.rhs(0, [0, 0, 0, 0, 0, 0]);\n"
        "it.setInputs({ h1_torque: 2 }); it.setInputs({ h3_torque: -1 });\n"
        "const driven = it.rhs(0, [0, 0, 0, 0, 0, 0]); const { byInputs } = it.jacobian();\n"
        "const other = model.create(); other.restore(it.save());\n"
        "result = { free: [...free], driven: [...driven], byInputs: [...byInputs], kept: other.inputs };",
    )  # fmt: skip
    assert result["kept"] == {"h1_torque": 2.0, "h2_torque": 0.0, "h3_torque": -1.0}
    slopes = np.array(result["byInputs"]).reshape(3, 3)
    change = np.subtract(result["driven"], result["free"])[3:]
    # Accelerations are linear in torques; the slopes are central differences, good to about 1e-9 of their size.
    np.testing.assert_allclose(change, slopes @ [2.0, 0.0, -1.0], rtol=1e-7)


@needs("node")
def test_a_hundred_simulators_take_the_memory_of_a_hundred_states(tmp_path: Path) -> None:
    result = in_node(
        in_wasm("pendulum"), tmp_path, "pendulum",
        "const before = model.memoryBytes; const all = Array.from({ length: 100 }, () => model.create());\n"
        "all.forEach((it, k) => it.step(0.001 * (k + 1)));\n"
        "const after = model.memoryBytes; all.forEach((it) => it.free());\n"
        "for (let k = 0; k < 1000; k++) { const it = model.create(); it.step(1e-3); it.free(); }\n"
        "result = [before, after, model.memoryBytes, model.stateBytes, all.length];",
    )  # fmt: skip
    before, after, later, each, _ = result
    assert after - before <= 100 * (each + 16) + 65536  # memory grows by pages
    assert later == after


# --- the page ---------------------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def tab() -> Iterator[Page]:
    with browser() as page:
        yield page


def opened(tab: Page, name: str, folder: Path, fragment: str = "") -> None:
    tab.console.clear()
    tab.open(put(in_wasm(name), folder) / "index.html", fragment=fragment)
    assert tab.value("document.body.dataset.ready") == "yes"


def shown(tab: Page, group: str) -> dict[str, float]:
    """Values of the curves at the cursor, SI."""
    pairs = tab.value(
        "(() => { const s = lamcView.shows[0]; return s.data.curves.flatMap((c, k) =>"
        f" (c.group === '{group}' ? [[c.name, s.motion.curve(k, lamcView.player.time)]] : [])); }})()"
    )
    return dict(pairs)


@needs_browser
def test_a_page_opened_from_a_file_simulates(tab: Page, tmp_path: Path) -> None:
    opened(tab, "pendulum", tmp_path / "page", "#t=0.5")
    assert tab.value("lamcView.player.told.textContent") == "0.500 s"
    state = motion_here("pendulum", np.array([0.5]), tmp_path / "c")[0]
    # The last row is a state of the same bits; a run without an end takes its steps a little differently.
    np.testing.assert_allclose(list(shown(tab, "angles").values()), state[:3], rtol=0.0, atol=1e-9)
    assert tab.console == []


@needs_browser
def test_a_page_tells_the_angle_of_the_hinge_that_closes_a_loop(tab: Page, tmp_path: Path) -> None:
    opened(tab, "four_bar", tmp_path / "page", "#t=0.1")
    simulator = lamc.compile(mechanism_of("four_bar"), scene_of("four_bar"))
    (cut,) = simulator.cut_joints
    run = simulator.run(0.1, t_eval=[0.1], rtol=1e-9, atol=1e-11)
    assert shown(tab, "angles")[cut] == pytest.approx(run.angle(cut)[0], abs=1e-8)  # of the tolerances


@needs_browser
def test_inputs_act_at_once_and_a_run_that_stopped_says_so(tab: Page, tmp_path: Path) -> None:
    opened(tab, "pendulum", tmp_path / "page", "#t=0.1")
    assert tab.value("lamcView.shows[0].driver !== null")
    take = "lamcView.shows[0].sliders.model.find((each) => each.name === 'h1.torque').take({}, true)"
    tab.value(take.format("0.5"))
    assert tab.value("lamcView.shows[0].driver.inputs.h1_torque") == 0.5
    tab.value(take.format("1e300"))
    tab.value("lamcView.player.advance(0.05)")
    assert tab.value("lamcView.shows[0].status.textContent").startswith("Stopped at t = 0.1 s: ")
    assert tab.value("lamcView.player.playing") is False
    tab.value("lamcView.shows[0].reset()")
    assert tab.value("lamcView.shows[0].status.textContent") == ""
    assert tab.value("lamcView.shows[0].driver.t") == 0.0
    assert tab.console == []


@needs_browser
def test_what_ran_on_is_kept_within_bounds(tab: Page, tmp_path: Path) -> None:
    opened(tab, "pendulum", tmp_path / "page", "#t=0")
    rows = tab.value("lamcView.shows[0].motion.rows")
    tab.value(f"for (let k = 0; k < {rows} + 10; k++) lamcView.shows[0].advance(1e-3)")
    filled, first, last = tab.value(
        "(() => { const m = lamcView.shows[0].motion; return [m.filled, m.t[0], m.t[m.filled - 1]]; })()"
    )
    assert filled <= rows
    assert last == pytest.approx(1e-3 * (rows + 10))
    assert last - first == pytest.approx(1e-3 * (filled - 1))


@needs("node")
def test_the_classic_script_is_the_same_simulator(tmp_path: Path) -> None:
    put(in_wasm("pendulum"), tmp_path)
    (tmp_path / "run.cjs").write_text(
        'require("./pendulum.js");\nlamc["pendulum"].load().then((model) => {\n'
        "const it = model.create({ settings: { tStop: 0.5 } }); it.step(0.5);\n"
        "console.log(JSON.stringify([...it.q])); });\n"
    )
    found = json.loads(does(["node", "run.cjs"], tmp_path))
    assert found == motion_here("pendulum", np.array([0.5]), tmp_path / "c")[0][:3].tolist()


@needs("node")
@pytest.mark.slow
def test_a_hostile_name_stays_a_name(tmp_path: Path) -> None:
    from dataclasses import replace

    name = '</script><script>alert(1)</script> */ ` ${x} "'
    mechanism = replace(mechanism_of("pendulum"), name=name)
    files = files_of(mechanism, "wasm", scene_of("pendulum"), lamc.ExportOptions(prefix="mine"))
    page = files["index.html"].decode()
    assert page.count("</script>") == 4  # data, engine, worker, page
    assert "<script>alert" not in page
    assert in_node(files, tmp_path, "mine", "result = model.name;") == "mine"


def test_options_that_do_not_fit_are_refused() -> None:
    for options, reported in (({"real_time": True}, "real_time"), ({"single_header": True}, "single_header")):
        with pytest.raises(ExportError, match=reported):
            files_of(mechanism_of("pendulum"), "wasm", None, lamc.ExportOptions(**options))


def test_without_a_compiler_it_says_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("importlib.util.find_spec", lambda *_: None)
    monkeypatch.setattr("shutil.which", lambda *_: None)
    with pytest.raises(BuildError, match=r"clang and wasm-ld are missing; `pip install lamc\[cc\]`"):
        find_wasm_tools()
