"""Exports whose inputs follow series: C has its table, an FMU's importer drives the input, others refuse by name."""

import io
import json
import zipfile
from pathlib import Path

import numpy as np
import pytest

import lamc
from lamc import Body, ExportError, Gravity, Input, Joint, Mechanism, Scene, Series, Torque
from lamc.basics.errors import UnsupportedError
from lamc.effects.base_motion import BaseMotion
from lamc.export import fmu, mjcf
from lamc.export.c import c_source
from lamc.export.driven import simulator_of
from lamc.export.options import ExportOptions
from tests.support.ctools import needs_cc
from tests.support.exported import Exported, c_files

INERTIA = 2e-5  # kg·m²
TIMES = np.array([0.0, 0.03, 0.05, 0.08, 0.1])
VALUES = np.array([1.0, -2.0, 0.5, 3.0, 0.0]) * 1e-3
HOLDS = ("previous", "linear", "cubic")


def flap(series: Series, *others: object) -> Mechanism:
    """One body about its own centre, that a recorded torque turns."""
    wall = Body("wall", fixed=True)
    body = Body("flap", 0.01, (0.0, 0.0, 0.0), np.diag([INERTIA] * 3))
    hinge = Joint("h", "wall", "flap", axis=(0.0, 0.0, 1.0))
    scene = Scene(
        effects=(Torque({"h": "command*(1 + 0.1*angle)"}), *others),  # type: ignore[arg-type]
        inputs={"command": Input(unit="N*m", series=series)},
        duration=0.1,
    )
    return Mechanism((wall, body), (hinge,), name="flap", scene=scene)


@needs_cc
@pytest.mark.parametrize("hold", HOLDS)
@pytest.mark.parametrize("integrator", ["auto", "rk45", "dop853", "rodas5p", "radau5"])
@pytest.mark.quick("auto-linear", "radau5-cubic", "rk45-previous", others="campaign")
def test_exported_c_moves_as_a_run_does(hold: str, integrator: str, tmp_path: Path) -> None:
    made = flap(Series(TIMES, VALUES, hold))
    exported = Exported(c_files(made, options=ExportOptions(integrator=integrator)), tmp_path)
    it = exported.instance(rtol=1e-9, atol=1e-11)
    times = np.linspace(0.0, 0.1, 41)
    run = lamc.compile(made).run(t_end=0.1, t_eval=times, integrator=integrator)
    rows = [exported.state(it)]
    for t in times[1:]:
        assert exported.call("step", it, float(t)) == 0
        outputs = exported.new("outputs")
        assert (
            exported.call("get_outputs", it, outputs) == 0
        )  # looks at a state within a step: leaves no trace
        rows.append(exported.state(it))
    # the same C; but an export does not know where it will end, from which first steps of implicit methods follow
    assert np.array(rows) == pytest.approx(np.hstack([run.q, run.u]), rel=1e-9, abs=1e-9)


@needs_cc
@pytest.mark.parametrize("hold", HOLDS)
def test_steps_of_one_length_end_at_rows_of_the_table(hold: str, tmp_path: Path) -> None:
    made = flap(Series(TIMES, VALUES, hold))
    exported = Exported(c_files(made, options=ExportOptions(real_time=True, integrator="rk45")), tmp_path)
    it = exported.instance()
    for _ in range(100):
        assert exported.call("step_fixed", it, 1e-3) == 0
    run = lamc.compile(made).run(t_end=0.1, rtol=1e-12, atol=1e-14)
    # The classical method at 1 ms errs by h⁴, a few 1e-9 of the largest angle. A step that saw a jump too early would
    # err by h / 6 of it: some 1e-3 rad here.
    assert it.q[0] == pytest.approx(run.q[-1, 0], abs=1e-8)


@needs_cc
def test_an_exported_run_does_not_go_beyond_its_table(tmp_path: Path) -> None:
    exported = Exported(c_files(flap(Series(TIMES, VALUES))), tmp_path)
    it = exported.instance()
    assert exported.call("step", it, 0.09) == 0
    assert exported.call("step", it, 0.2) == exported.status("NOT_FINITE")
    held = Exported(c_files(flap(Series(TIMES, VALUES, beyond="hold"))), tmp_path / "held")
    assert held.call("step", held.instance(), 0.2) == 0


@needs_cc
def test_floats_follow_a_table_too(tmp_path: Path) -> None:
    options = ExportOptions(real_time=True, integrator="rk45", precision="float")
    exported = Exported(c_files(flap(Series(TIMES, VALUES)), options=options), tmp_path)
    it = exported.instance()
    for _ in range(100):
        assert exported.call("step_fixed", it, 1e-3) == 0
    run = lamc.compile(flap(Series(TIMES, VALUES))).run(t_end=0.1)
    assert it.q[0] == pytest.approx(
        run.q[-1, 0], rel=1e-4
    )  # a hundred steps of 6e-8, and times that round as they add
    close = Series(1000.0 + np.array([-1000.0, 1e-6, 2e-6, 1.0]), np.zeros(4))
    with pytest.raises(ExportError, match="faster than single precision tells times apart"):
        c_files(flap(close), options=options)


def test_a_table_that_is_too_long_for_c_is_refused() -> None:
    long = Series(np.linspace(0.0, 1.0, 200_000), np.zeros(200_000))
    made = flap(long)
    with pytest.raises(ExportError, match="'command' have 200000 rows; an export takes 100000 along at most"):
        c_source(simulator_of(made, made.scene, ExportOptions()), ExportOptions())  # type: ignore[arg-type]


@needs_cc
def test_an_importer_drives_the_input_of_an_fmu() -> None:
    made = flap(Series(TIMES, VALUES), Gravity())
    assert made.scene is not None
    (content,) = fmu.files(made, made.scene, ExportOptions()).values()
    with zipfile.ZipFile(io.BytesIO(content)) as archive:
        described = archive.read("modelDescription.xml").decode()
        table = archive.read("resources/command.csv").decode().splitlines()
    assert 'name="command"' in described
    line = next(each for each in described.splitlines() if 'name="command"' in each)
    assert 'causality="input"' in line
    assert table[1] == "t [s],command [N·m]"
    assert [tuple(map(float, row.split(","))) for row in table[2:]] == list(zip(TIMES, VALUES, strict=True))
    moved = Scene(
        effects=(BaseMotion(displacement=("path", 0.0, 0.0)),),
        inputs={"path": Input(unit="m", series=Series(TIMES, VALUES, "cubic"))},
    )
    with pytest.raises(ExportError, match="differentiates the input 'path' twice"):
        fmu.files(made, moved, ExportOptions())


def test_other_engines_refuse_by_name() -> None:
    made = flap(Series(TIMES, VALUES))
    assert made.scene is not None
    with pytest.raises(
        UnsupportedError, match=r"MJCF has no place for .*the series that the input 'command' follows"
    ):
        mjcf.files(made, made.scene, ExportOptions())
    written = mjcf.files(made, made.scene, ExportOptions(lossy=True))
    assert "the series that the input" in written["README.md"].decode()
    assert json.loads(written["names.json"])
