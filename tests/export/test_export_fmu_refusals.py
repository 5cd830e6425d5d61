"""What an FMU refuses, what may change while it runs, and names that are hard to bear."""

import ctypes
import io
import re
import zipfile
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import lamc
from lamc.basics.errors import ExportError
from lamc.basics.resources import data_dir
from lamc.effects import FreeBase, Gravity, HingeDamping, HingeStiffness, JointLimits
from lamc.export import files_of
from lamc.export.fmu import fmu_files
from lamc.export.options import ExportOptions
from lamc.records.mechanism import Mechanism
from lamc.records.scene import Scene
from tests.support.ctools import needs_cc
from tests.support.fmus import VERSIONS, Fmu, need_fmpy, written
from tests.support.mechanisms import chain

pytestmark = needs_cc
SCENE = Scene(effects=(Gravity((0.0, 0.0, -9.81)), HingeStiffness(), HingeDamping()))
STEP = 0.05  # s


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory):
    """made(fmi) -> a chain of two hinges with limits: simulator and unzipped folder."""
    mechanism = chain(2, "parallel", seed=3)
    first, second = mechanism.joints
    limited = replace(mechanism, joints=(first, replace(second, limits=(-2.5, 2.5))))
    simulator = lamc.compile(
        limited, Scene(effects=(*SCENE.effects, JointLimits(stiffness=50.0, damping=0.5)))
    )
    known: dict[int, Path] = {}

    def make(fmi: int):
        if fmi not in known:
            file = written(simulator, fmi, tmp_path_factory.mktemp("refusing"))
            known[fmi] = file.with_suffix("")
            with zipfile.ZipFile(file) as archive:
                archive.extractall(known[fmi])
        return simulator, known[fmi]

    return make


@pytest.mark.parametrize("fmi", VERSIONS)
class TestRefusals:
    """Each with one sentence in the log, and none with a trace in the motion."""

    @pytest.fixture
    def fmu(self, made, fmi):
        _, folder = made(fmi)
        fmu = Fmu(folder).begin(stop=1.0)
        fmu.step(0.0, STEP)
        before = fmu.all_values()
        yield fmu
        assert fmu.all_values() == before
        untouched = Fmu(folder, "two").begin(stop=1.0)
        untouched.step(0.0, STEP)
        for each in (fmu, untouched):
            each.step(STEP, STEP)
        assert fmu.all_values() == untouched.all_values()
        fmu.free()
        untouched.free()

    @pytest.mark.parametrize("value", [float("nan"), float("inf"), -float("inf")])
    @pytest.mark.quick("*-3", others="campaign")
    def test_numbers_that_are_none(self, fmu, fmi, value):
        name = next(n for n in fmu.by_name if n.endswith(".stiffness"))
        with fmu.refusing(name, "finite"):
            fmu.put({name: value})

    @pytest.mark.quick("3")
    def test_one_bad_value_among_good_ones(self, fmu, fmi):
        names = [n for n in fmu.by_name if n.endswith((".stiffness", ".mass"))]
        values = dict.fromkeys(names, 1.0) | {names[-1]: float("nan")}
        with fmu.refusing(names[-1]):
            fmu.put(values)

    def test_values_that_nature_does_not_have(self, fmu, fmi):
        for ending, value in ((".mass", 0.0), (".mass", -1.0), (".damping", -1e-9), (".inertia_xx", -1.0)):
            name = next(n for n in fmu.by_name if n.endswith(ending))
            with fmu.refusing(name, "must be"):
                fmu.put({name: value})

    def test_what_is_calculated_or_fixed_or_a_start(self, fmu, fmi):
        limit = next(n for n in fmu.by_name if n.endswith(".upper_limit"))
        for name, word in (("energy.total", "calculated"), ("time", "calculated"), (limit, "fixed")):
            with fmu.refusing(name, word):
                fmu.put({name: 0.1})
        angle = next(n for n in fmu.by_name if n.endswith(".angle"))
        with fmu.refusing(angle, "start"):
            fmu.put({angle: 0.1})

    @pytest.mark.parametrize(
        ("t", "h", "word"),
        [
            (STEP, 0.0, "above zero"),
            (STEP, -STEP, "above zero"),
            (STEP, float("nan"), "above zero"),
            (STEP, float("inf"), "above zero"),
            (float("nan"), STEP, "finite"),
            (0.0, STEP, "stands at 0.05"),
            (2 * STEP, STEP, "stands at 0.05"),
            (STEP, 1.0, "stop time 1"),
        ],
    )
    def test_steps_that_cannot_be(self, fmu, fmi, t, h, word):
        with fmu.refusing(word):
            fmu.step(t, h)

    def test_calls_out_of_turn(self, fmu, fmi):
        with fmu.refusing("InitializationMode"):
            fmu.fmu.exitInitializationMode()
        with fmu.refusing("before initialisation"):
            fmu.enter()

    def test_references_of_nothing(self, fmu, fmi):
        read = fmu.fmu.getReal if fmi == 2 else fmu.fmu.getFloat64
        with fmu.refusing("no real variable has the reference 4000000000"):
            read([4_000_000_000])

    def test_values_of_other_types(self, fmu, fmi):
        with fmu.refusing("Real" if fmi == 2 else "Float64"):
            if fmi == 2:
                fmu.fmu.getInteger([0])
            else:
                fmu.fmu.getInt32([0])

    def test_bytes_that_are_no_state(self, fmu, fmi):
        state = fmu.fmu.getFMUState()
        content = bytearray(fmu.fmu.serializeFMUState(state))
        fmu.fmu.freeFMUState(state)
        damaged = bytes(content[:-9]) + bytes([content[-9] ^ 1]) + bytes(content[-8:])
        foreign = bytes([content[1] ^ 1]) + bytes(content[1:])
        for reported, word in (
            (damaged, "damaged"),
            (foreign, "no state of"),
            (bytes(content[:100]), "100 bytes"),
        ):
            with fmu.refusing(word):
                fmu.fmu.deserializeFMUState(reported)

    def test_nothing_instead_of_an_instance(self, fmu, fmi):
        """Null where the standard has an instance: refused, not followed."""
        names = ("fmi2GetReal", "fmi2SetReal", "fmi2DoStep", "fmi2Terminate", "fmi2GetFMUstate")
        if fmi == 3:
            names = ("fmi3GetFloat64", "fmi3SetFloat64", "fmi3DoStep", "fmi3Terminate", "fmi3GetFMUState")
        for name in names:
            arguments = [ctypes.c_void_p(None)] * 10
            if name.endswith("DoStep"):
                arguments[1:3] = [ctypes.c_double(0.0), ctypes.c_double(STEP)]
            assert fmu.function(name)(*arguments) == 3


@pytest.mark.parametrize("fmi", VERSIONS)
def test_the_binary_of_another_description_is_refused(made, fmi):
    _, folder = made(fmi)
    said = []
    with pytest.raises(Exception, match="Failed to instantiate"):
        Fmu(folder, token="{00000000-0000-0000-0000-000000000000}", said=said)
    (status, _, message) = said[0]
    assert status == 3
    assert "different FMUs" in message


@pytest.mark.parametrize("fmi", VERSIONS)
@pytest.mark.quick("3", others="campaign")
def test_a_start_that_closes_no_loop_is_refused(fmi, tmp_path):
    examples = Path(lamc.__file__).parent / "examples"
    simulator = lamc.compile(lamc.load(examples / "five_bar.yaml"))
    file = written(simulator, fmi, tmp_path)
    with zipfile.ZipFile(file) as archive:
        archive.extractall(tmp_path / "unzipped")
    fmu = Fmu(tmp_path / "unzipped")
    fmu.enter()
    first, second = (f"{joint}.angle" for joint in simulator.joints[:2])
    fmu.put({first: 0.05})
    open_gap, angle = fmu.get("closure_gap", first)
    assert open_gap < 1e-12  # m, round-off of loops of 0.1 m: the guess was closed,
    assert angle not in (0.05, simulator.start[0])  # by moving what was given, too
    fmu.put({first: 1e3, second: -2e3})
    with fmu.refusing("cannot be had", "closes"):
        fmu.fmu.exitInitializationMode()
    fmu.free()


@pytest.mark.parametrize("fmi", VERSIONS)
class TestTuning:
    def test_a_start_and_parameters_can_be_given(self, made, fmi):
        simulator, folder = made(fmi)
        a, b = simulator.joints
        mass = next(name for name in simulator.parameters if name.endswith(".mass"))
        chosen = {f"{a}.stiffness": 3.0, mass: 0.7}
        fmu = Fmu(folder)
        fmu.put({f"{a}.angle": 0.1, f"{b}.rate": -0.3, **chosen})
        rows = fmu.begin(stop=1.0).walk(np.linspace(0.0, 1.0, 11), f"{a}.angle", f"{b}.angle")
        scene = replace(simulator.scene, angles={a: 0.1}, rates={b: -0.3})
        result = lamc.compile(simulator.mechanism, scene).run(
            1.0, t_eval=np.linspace(0.0, 1.0, 11), parameters=chosen
        )
        assert np.array_equal(rows, result.q)
        fmu.free()

    def test_a_stiffness_changed_on_the_way(self, made, fmi):
        """As two runs, the second of which starts where the first ends."""
        simulator, folder = made(fmi)
        a, b = simulator.joints
        name = f"{a}.stiffness"
        fmu = Fmu(folder)
        fmu.put({f"{a}.angle": 0.1})
        fmu.begin(stop=1.0)
        fmu.step(0.0, 0.5)
        reported = fmu.get(f"{a}.angle", f"{b}.angle", f"{a}.rate", f"{b}.rate")
        fmu.put({name: 4.0})
        assert fmu.get(name) == [4.0]
        fmu.step(0.5, 0.5)
        there = Scene(
            effects=simulator.scene.effects,
            angles=dict(zip((a, b), reported[:2], strict=True)),
            rates=dict(zip((a, b), reported[2:], strict=True)),
        )
        result = lamc.compile(simulator.mechanism, there).run(0.5, parameters={name: 4.0})
        # steps differ: 1e-9 per step, some 100 of them, on angles and rates of 1
        assert fmu.get(f"{a}.angle", f"{b}.angle") == pytest.approx(result.q[-1].tolist(), abs=1e-7)
        fmu.free()

    def test_values_set_again_change_no_bit(self, made, fmi):
        """Importers set inputs and parameters at every point, changed or not."""
        _, folder = made(fmi)
        one, two = Fmu(folder).begin(stop=1.0), Fmu(folder, "two").begin(stop=1.0)
        settable = [v.name for v in one.by_name.values() if v.variability == "tunable"]
        assert settable
        for k in range(10):
            two.put(dict(zip(settable, two.get(*settable), strict=True)))
            for fmu in (one, two):
                fmu.step(0.1 * k, 0.1 * (k + 1) - 0.1 * k)
        assert one.all_values() == two.all_values()
        for fmu in (one, two):
            fmu.free()

    def test_a_tolerance_is_kept(self, made, fmi):
        simulator, folder = made(fmi)
        fmu = Fmu(folder).begin(stop=1.0, tolerance=1e-5)
        (row,) = fmu.walk([0.0, 1.0], *(f"{j}.angle" for j in simulator.joints))[1:]
        assert row == simulator.run(1.0, rtol=1e-5, atol=1e-7).q[-1].tolist()
        fmu.free()
        fmu = Fmu(folder)
        with fmu.refusing("tolerance is 2"):
            fmu.enter(tolerance=2.0)
        fmu.free()

    def test_time_may_begin_anywhere(self, made, fmi):
        simulator, folder = made(fmi)
        fmu = Fmu(folder).begin(start=100.0, stop=101.0)
        assert fmu.get("time") == [100.0]
        fmu.step(100.0, 1.0)
        result = simulator.run(1.0)  # nothing in the scene depends on time
        reported = fmu.get(*(f"{j}.angle" for j in simulator.joints))
        # steps end at other times by the round-off of 100 s, 1e-14 s, and 1e-9 per step
        assert reported == pytest.approx(result.q[-1].tolist(), abs=1e-8)
        fmu.free()


@pytest.mark.slow
def test_the_same_design_gives_the_same_bytes(made):
    simulator, _ = made(2)
    for fmi in VERSIONS:
        once, again = (fmu_files(simulator, ExportOptions(fmi=fmi)) for _ in range(2))
        assert once == again  # binaries too: the compiler sees the same text in folders of different names
        (content,) = once.values()
        with zipfile.ZipFile(io.BytesIO(content)) as archive:
            assert {entry.date_time for entry in archive.infolist()} == {(1980, 1, 1, 0, 0, 0)}
            assert archive.namelist() == sorted(archive.namelist())


def test_every_function_of_the_standard_is_there(made):
    headers = data_dir("templates") / "export" / "fmu" / "headers"
    for fmi in VERSIONS:
        need_fmpy()
        _, folder = made(fmi)
        text = (headers / f"fmi{fmi}Functions.h").read_text()
        declared = re.findall(rf"FMI{fmi}_Export\s+\w+TYPE\s+(\w+);", text)
        assert len(declared) > 40
        fmu = Fmu(folder)
        for name in declared:
            assert fmu.function(name)
        fmu.free()


@pytest.mark.parametrize("fmi", VERSIONS)
def test_names_that_are_hard_to_bear(fmi, tmp_path):
    need_fmpy()
    from fmpy.validation import validate_fmu

    plain = chain(3, "parallel", seed=1)
    bodies = {
        b.name: n for b, n in zip([b for b in plain.bodies if not b.fixed], HOSTILE_BODIES, strict=True)
    }
    mechanism = Mechanism(
        name='a "design" <&> */ \' \\ %s \N{GREEK SMALL LETTER OMEGA}',
        bodies=tuple(replace(b, name=bodies.get(b.name, b.name)) for b in plain.bodies),
        joints=tuple(
            replace(j, name=n, parent=bodies.get(j.parent, j.parent), child=bodies.get(j.child, j.child))
            for j, n in zip(plain.joints, HOSTILE_JOINTS, strict=True)
        ),
    )
    simulator = lamc.compile(mechanism, SCENE)
    file = written(simulator, fmi, tmp_path)
    assert validate_fmu(str(file)) == []
    with zipfile.ZipFile(file) as archive:
        archive.extractall(tmp_path / "unzipped")
    fmu = Fmu(tmp_path / "unzipped")
    assert len(fmu.by_name) == len(fmu.description.modelVariables)  # no two alike
    rows = fmu.begin(stop=0.5).walk([0.0, 0.25, 0.5], *[v.name for v in angles(fmu)])
    assert np.array_equal(rows, simulator.run(0.5, t_eval=[0.0, 0.25, 0.5]).q)
    # To FMI 2.0 a message is a format, in which # begins a reference.
    with fmu.refusing("%%n##r1##" if fmi == 2 else "%n#r1#", "finite"):
        fmu.put({next(n for n in fmu.by_name if "%n#r1#" in n and n.endswith(".stiffness")): float("nan")})
    fmu.free()


@pytest.mark.parametrize("fmi", VERSIONS)
@pytest.mark.quick("3")
def test_a_body_without_a_hinge_falls(fmi, tmp_path):
    """A mechanism of no joints: coordinates and rates are the base's alone."""
    plain = chain(1, "parallel", seed=1)
    body = next(b for b in plain.bodies if not b.fixed)
    mechanism = Mechanism(name="stone", bodies=(replace(body, fixed=True),), joints=())
    scene = Scene(effects=(Gravity((0.0, 0.0, -9.81)), FreeBase()))
    file = written(lamc.compile(mechanism, scene), fmi, tmp_path)
    with zipfile.ZipFile(file) as archive:
        archive.extractall(tmp_path / "unzipped")
    fmu = Fmu(tmp_path / "unzipped").begin(stop=1.0)
    names = [f"{body.name}.position[{i}]" for i in (1, 2, 3)]
    first, last = fmu.walk([0.0, 0.3, 1.0], *names)[::2]
    # Runge-Kutta is exact for parabolas, but for round-off
    assert np.subtract(last, first) == pytest.approx([0.0, 0.0, -9.81 / 2], abs=1e-12)
    fmu.free()


def test_the_time_reached_can_be_asked_for(made):
    _, folder = made(2)
    fmu = Fmu(folder).begin(stop=1.0)
    fmu.step(0.0, STEP)
    with fmu.refusing("stands at"):
        fmu.step(0.5, STEP)
    last_successful_time, terminated, do_step_status = 2, 3, 0  # fmi2StatusKind
    assert fmu.fmu.getRealStatus(last_successful_time) == STEP
    assert fmu.fmu.getBooleanStatus(terminated) is False
    instance = ctypes.c_void_p(fmu.fmu.component)
    discard = 2
    assert (
        fmu.function("fmi2GetRealStatus")(instance, do_step_status, ctypes.byref(ctypes.c_double()))
        == discard
    )
    assert fmu.function("fmi2GetStatus")(instance, do_step_status, ctypes.byref(ctypes.c_int())) == discard
    fmu.free()


HOSTILE_JOINTS = ("energy.total", "h\"1'<&>%n#r1#", "h\N{GREEK SMALL LETTER OMEGA} ?\\")
HOSTILE_BODIES = ("time", "a.b[1]", "h?1")


def angles(fmu: Fmu) -> list:
    """The variables of the first three coordinates: they come with their starts, after the parameters."""
    return [v for v in fmu.description.modelVariables if v.name.endswith(".angle")]


@pytest.mark.parametrize("value", [1, 4, "2", True])
def test_versions_that_are_none(value):
    with pytest.raises(ExportError, match=r"--fmi \(fmi\) is .*; it must be 2 or 3, the version"):
        ExportOptions(fmi=value)


@pytest.mark.parametrize("options", [{"real_time": True}, {"jacobian": False}, {"single_header": True}])
def test_options_that_an_fmu_cannot_have(options):
    with pytest.raises(ExportError, match=rf"{next(iter(options))}\)?: fmu has no use"):
        files_of(chain(2, "parallel", seed=3), "fmu", SCENE, ExportOptions(**options))


def test_the_version_of_the_standard_is_2_unless_it_is_said():
    assert ExportOptions().fmi_version == 2
    assert ExportOptions(fmi=3).fmi_version == 3
