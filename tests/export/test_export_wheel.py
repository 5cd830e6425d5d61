"""Exports as a wheel: it installs where there is neither lamc nor NumPy, and runs with the bits of lamc."""

import base64
import csv
import hashlib
import io
import json
import os
import subprocess
import sys
import zipfile
from collections.abc import Mapping
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

import cffi
import numpy as np
import pytest

import lamc
from lamc.basics.errors import ExportError
from lamc.export import files_of
from lamc.export.wheel import class_name
from tests.support.ctools import needs_cc
from tests.support.exported_folders import DURATION, KINDS, mechanism_of, scene_of

pytestmark = needs_cc


@cache
def wheel_of(name: str, **options: object) -> tuple[str, bytes]:
    """Name and bytes."""
    chosen = lamc.ExportOptions(**options)  # type: ignore[arg-type]
    files = files_of(mechanism_of(name), "wheel", scene_of(name), chosen)
    return the_wheel(files)


def the_wheel(files: Mapping[str, bytes]) -> tuple[str, bytes]:
    """Beside it there is what tells how to use it, and nothing else."""
    (path,) = files.keys() - {"README.md"}
    return path, files[path]


@pytest.fixture(scope="module")
def python(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A fresh environment, in which cffi alone can be imported besides what is installed there."""
    folder = tmp_path_factory.mktemp("fresh")
    subprocess.run([sys.executable, "-m", "venv", "--without-pip", str(folder / "venv")], check=True)
    installed = Path(cffi.__file__).parent.parent
    needed = folder / "needed"
    needed.mkdir()
    for path in [installed / "cffi", *installed.glob("_cffi_backend*")]:
        (needed / path.name).symlink_to(path)
    return folder / "venv" / "bin" / "python"


def install(python: Path, *wheels: tuple[str, bytes]) -> None:
    for name, content in wheels:
        path = python.parent.parent / name
        path.write_bytes(content)
        pip = [sys.executable, "-m", "pip", "--disable-pip-version-check", "--python", str(python), "install"]
        done = subprocess.run(
            [*pip, "--no-deps", "--no-index", str(path)], capture_output=True, text=True, check=False
        )
        assert done.returncode == 0, done.stderr


def run(python: Path, script: str) -> Any:
    """What a script there, far from lamc, leaves in `result`."""
    needed = python.parent.parent.parent / "needed"
    environment = {k: v for k, v in os.environ.items() if k != "PYTHONPATH"} | {"PYTHONPATH": str(needed)}
    whole = f"import json, sys\n{script}\njson.dump(result, sys.stdout)\n"
    done = subprocess.run(
        [str(python), "-c", whole],
        cwd=needed, capture_output=True, text=True, check=False, env=environment, timeout=300,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


REPORTED = """
def told(work, *arguments):
    try:
        work(*arguments)
    except Exception as error:
        return [type(error).__name__, getattr(error, "code", None), str(error)]
"""


@pytest.mark.parametrize("name", KINDS)
@pytest.mark.quick("four_bar")
@pytest.mark.ci("four_bar")
def test_it_runs_without_lamc_and_with_the_bits_of_a_run(name: str, python: Path) -> None:
    install(python, wheel_of(name))
    t_end = DURATION[name]
    times = np.linspace(0.0, t_end, 11)[1:].tolist()
    rows = run(
        python,
        f"import {name}\nit = {name}.{class_name(name)}(t_stop={t_end!r})\nresult = []\n"
        f"for t in {times!r}:\n    it.step(t)\n    result.append([x.hex() for x in (*it.q.values(), *it.u.values())])\n"
        "assert not {'lamc', 'numpy', 'sympy'} & set(sys.modules)\n",
    )
    simulator = lamc.compile(mechanism_of(name), scene_of(name))
    expected = simulator.run(t_end, t_eval=times, rtol=1e-9, atol=1e-11)
    found = np.array([[float.fromhex(x) for x in row] for row in rows])
    assert found.tobytes() == np.hstack([expected.q, expected.u]).tobytes()


@pytest.mark.slow
def test_states_copies_inputs_and_refusals(python: Path) -> None:
    install(python, wheel_of("pendulum"), wheel_of("limit_stop"))
    found = run(
        python,
        f"{REPORTED}\nimport copy, pickle, pendulum, limit_stop\n"
        f"it = pendulum.Pendulum({{'link_3.mass': 1.5}})\nit.step(0.3)\n"
        "state, twin, sent = it.save(), copy.deepcopy(it), pickle.loads(pickle.dumps(it))\n"
        "other = pendulum.Pendulum(); other.restore(state)\n"
        "for each in (it, twin, sent, other): each.step(0.6)\n"
        "same = it.q == twin.q == sent.q == other.q and it.u == other.u and other.parameters['link_3.mass'] == 1.5\n"
        "here = [*it.q.values(), *it.u.values()]\n"
        "free = it.rhs(it.t, here); it.set_inputs({'h1.torque': 2.0}); it.set_inputs({'h3.torque': -1.0})\n"
        "driven = it.rhs(it.t, here)\n"
        "before = it.save()\n"
        "refusals = dict(nan=told(it.step, float('nan')), past=told(it.step, 0.5), text=told(it.step, '1'),\n"
        "  other=told(it.restore, limit_stop.LimitStop().save()), zeros=told(it.restore, bytes(len(state))),\n"
        "  negative=told(it.step_fixed, -1.0), name=told(it.set_parameters, {'mass': 1.0}),\n"
        "  parameter=told(pendulum.Pendulum, {'link_1.mass': float('inf')}), row=told(it.rhs, 0.0, [1.0]),\n"
        "  input=told(it.set_inputs, {'h1.torque': float('nan')}))\n"
        "out = it.outputs()\n"
        "result = dict(same=same, free=free, driven=driven, by=it.jacobian()[2], inputs=it.inputs, refusals=refusals,\n"
        "  kept=it.save() == before, total=out.total_energy, energies=it.energies(), angles=out.angles, q=it.q,\n"
        "  bodies=list(out.poses))",
    )
    assert found["same"]
    assert found["kept"]
    assert found["inputs"] == {"h1.torque": 2.0, "h2.torque": 0.0, "h3.torque": -1.0}
    kinds = {what: tuple(reported[:2]) for what, reported in found["refusals"].items()}
    assert kinds == {
        "nan": ("SimulatorError", "BAD_ARGUMENT"),
        "past": ("SimulatorError", "IN_PAST"),
        "text": ("TypeError", None),
        "other": ("SimulatorError", "BAD_DIGEST"),
        "zeros": ("SimulatorError", "BAD_DIGEST"),
        "negative": ("SimulatorError", "BAD_ARGUMENT"),
        "name": ("UnknownNameError", None),
        "parameter": ("SimulatorError", "BAD_PARAMETER"),
        "row": ("ValueError", None),
        "input": ("SimulatorError", "BAD_INPUT"),
    }
    assert found["refusals"]["past"][2].startswith(
        "pendulum: step(0.5) at t = 0.6 s: the time asked for lies"
    )
    # Accelerations are linear in torques; the slopes are central differences, good to about 1e-9 of their size.
    change = np.subtract(found["driven"], found["free"])[3:]
    np.testing.assert_allclose(change, np.array(found["by"]) @ [2.0, 0.0, -1.0], rtol=1e-7)
    assert found["total"] == pytest.approx(sum(found["energies"].values()), rel=1e-14)
    assert found["angles"] == found["q"]
    assert found["bodies"] == ["link_1", "link_2", "link_3"]


@pytest.mark.slow
def test_what_is_no_name_and_no_number_is_reported_in_one_line(python: Path) -> None:
    install(python, wheel_of("pendulum"))
    calls = {
        "pendulum.Pendulum({'h1_damping': 1})": "pendulum has no parameter 'h1_damping'; did you mean 'h1.damping'?",
        "pendulum.Pendulum(5)": "parameters are numbers by name, not 5",
        "pendulum.Pendulum(rtol=2)": "pendulum: Pendulum(rtol=2): a number is not finite or outside its range",
        "pendulum.Pendulum(max_steps=1.5)": "max_steps is 1.5; pendulum takes a whole number",
        "it.step('1')": "t is '1'; pendulum takes a number",
        "it.set_inputs({'h1.torqe': 1.0})": "pendulum has no input 'h1.torqe'; did you mean 'h1.torque'?",
        "it.set_inputs({'drive': 1.0})": "pendulum has no input 'drive'; there are h1.torque, h2.torque, h3.torque",
        "it.set_parameters({'h1.stiffness': None})": "the parameter 'h1.stiffness' is None; pendulum takes a number",
        "it.q['h9']": "pendulum has no coordinate 'h9'; there are h1, h2, h3",
        "it.outputs().poses['link1']": "pendulum has no body 'link1'; did you mean 'link_1'?",
        "it.start(0.0, {'h1': 0.1}, [0.0] * 3)": "q lacks h2, h3",
        "it.start(0.0, 'abc', [0.0] * 3)": "q is 'abc'; pendulum takes 3 numbers",
        "it.restore('abc')": "restore takes the bytes that save gave, not 'abc'",
    }
    found = run(
        python,
        f"{REPORTED}\nimport pendulum\nit = pendulum.Pendulum()\n"
        f"result = [told(lambda: eval(call)) for call in {list(calls)!r}]\n",
    )
    assert [each[2] for each in found] == list(calls.values())
    names = {each[0] for each in found}
    assert names == {"UnknownNameError", "TypeError", "SimulatorError", "ValueError"}


@pytest.mark.slow
def test_it_starts_from_what_it_gave_and_shows_its_own_names_alone(python: Path) -> None:
    install(python, wheel_of("pendulum"))
    here, there, names, known = run(
        python,
        "import pendulum\na, b = pendulum.Pendulum(), pendulum.Pendulum()\na.step(0.3); b.start(a.t, a.q, a.u)\n"
        "result = [[a.t, a.q, a.u], [b.t, b.q, b.u], dir(pendulum), sorted(pendulum.__all__)]",
    )
    assert here == there
    assert names == known
    assert {"Pendulum", "COORDINATES", "SimulatorError"} < set(names)
    assert not {"Mapping", "TypedDict", "annotations", "dataclass"} & set(names)


@pytest.mark.slow
def test_types_hold_for_who_checks_them(tmp_path: Path) -> None:
    """The package itself, strictly, and a program that uses it; cffi has no types of its own."""
    (tmp_path / "it.whl").write_bytes(wheel_of("pendulum")[1])
    with zipfile.ZipFile(tmp_path / "it.whl") as archive:
        archive.extractall(tmp_path)
    assert (tmp_path / "pendulum" / "py.typed").is_file()
    (tmp_path / "use.py").write_text(
        "import pendulum\nit = pendulum.Pendulum({'link_1.mass': 1.0}, rtol=1e-8)\nit.start(0.0, it.q, it.u)\n"
        "x: float = it.outputs().poses['link_1'].centre[0] + it.q['h1']\nit.set_inputs({'h1.torque': 'much'})\n"
    )
    pytest.importorskip("mypy")
    mypy = [sys.executable, "-m", "mypy", "--strict", "--cache-dir", str(tmp_path / "cache")]
    mypy += ["--no-error-summary", "--disable-error-code", "import-untyped"]
    reported = [
        subprocess.run([*mypy, *what], cwd=tmp_path, capture_output=True, text=True, check=False).stdout
        for what in (["use.py"], ["-p", "pendulum"])
    ]
    assert reported[1] == ""
    (line,) = [line for line in reported[0].splitlines() if "error" in line]
    assert line.startswith("use.py:5: error:")


def test_a_wheel_is_as_its_format_has_it() -> None:
    """Names, tags and digests, PEP 427."""
    name, content = wheel_of("pendulum")
    with zipfile.ZipFile(io.BytesIO(content)) as archive:
        assert archive.testzip() is None
        files = {entry: archive.read(entry) for entry in archive.namelist()}
    distribution, version, python_tag, abi, platform = name.removesuffix(".whl").split("-")
    assert (distribution, python_tag, abi) == ("pendulum", "py3", "none")
    info = f"{distribution}-{version}.dist-info"
    reported = files[f"{info}/WHEEL"].decode().splitlines()
    assert f"Tag: py3-none-{platform}" in reported
    assert "Root-Is-Purelib: false" in reported
    metadata = files[f"{info}/METADATA"].decode()
    assert f"Version: {version}\n" in metadata
    assert [line for line in metadata.splitlines() if line.startswith("Requires-Dist")] == [
        "Requires-Dist: cffi>=1.16"
    ]
    rows = list(csv.reader(io.StringIO(files[f"{info}/RECORD"].decode())))
    assert [row[0] for row in rows] == list(files)
    for path, digest, size in rows[:-1]:
        assert size == str(len(files[path]))
        algorithm, _, code = digest.partition("=")
        assert base64.urlsafe_b64decode(code + "==") == hashlib.new(algorithm, files[path]).digest()
    assert rows[-1] == [f"{info}/RECORD", "", ""]


def test_the_same_design_gives_the_same_bytes() -> None:
    chosen = lamc.ExportOptions()
    again: Mapping[str, bytes] = files_of(mechanism_of("pendulum"), "wheel", scene_of("pendulum"), chosen)
    assert the_wheel(again) == wheel_of("pendulum")


@pytest.mark.slow
def test_what_the_readme_shows_runs(python: Path) -> None:
    files = files_of(mechanism_of("pendulum"), "wheel", scene_of("pendulum"))
    readme, wheel = files["README.md"].decode(), the_wheel(files)
    assert f"pip install {wheel[0]}\n" in readme
    assert "| coordinate | unit |\n|---|---|\n| h1 | rad |\n| h2 | rad |\n| h3 | rad |\n" in readme
    assert "| h1.torque | 0 | N·m |" in readme
    install(python, wheel)
    script = readme.split("```python\n")[1].split("```")[0].replace("print(", "result = (")
    q, u, _ = run(python, script)
    assert list(q) == list(u) == ["h1", "h2", "h3"]


@pytest.mark.slow
def test_steps_of_fixed_length_alone(python: Path) -> None:
    install(python, wheel_of("pendulum", real_time=True, prefix="pendulum_rt"))
    found = run(
        python,
        "import pendulum_rt\nit = pendulum_rt.PendulumRt()\nfor _ in range(100): it.step_fixed(1e-3)\n"
        "result = [it.t, it.q['h1'], hasattr(it, 'step')]",
    )
    assert found[0] == pytest.approx(0.1, abs=1e-15)
    simulator = lamc.compile(mechanism_of("pendulum"), scene_of("pendulum"))
    accurate = simulator.run(0.1, t_eval=[0.1], rtol=1e-9, atol=1e-11)
    # RK4 with h = 1 ms where the fastest time constant is about 10 ms: (h/τ)^4 = 1e-4 of a decay.
    assert found[1] == pytest.approx(accurate.q[0, 0], abs=1e-5)
    assert found[2] is False


@pytest.mark.parametrize("name", ["json", "lambda", "cffi"])
@pytest.mark.quick("json", "cffi")
def test_names_that_no_package_can_have_are_refused(name: str) -> None:
    with pytest.raises(ExportError, match=f"{name}_model"):
        files_of(replace(mechanism_of("pendulum"), name=name), "wheel", scene_of("pendulum"))


@pytest.mark.slow
def test_a_hostile_name_stays_a_name(python: Path) -> None:
    mechanism = replace(mechanism_of("pendulum"), name='""" + exit(1) + """ \\')
    files = files_of(mechanism, "wheel", scene_of("pendulum"), lamc.ExportOptions(prefix="type_error"))
    install(python, the_wheel(files))
    assert run(python, "import type_error\nresult = type_error.TypeErrorModel().t") == 0.0


def test_options_that_do_not_fit_are_refused() -> None:
    with pytest.raises(ExportError, match="single_header"):
        files_of(mechanism_of("pendulum"), "wheel", None, lamc.ExportOptions(single_header=True))
