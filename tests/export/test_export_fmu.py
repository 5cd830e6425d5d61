"""FMUs do what the simulator does, in a tool that nobody here wrote."""

import html
import resource
import zipfile
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest

import lamc
from lamc.run.simulator import Simulator
from tests.support.ctools import needs_cc
from tests.support.exported_folders import mechanism_of
from tests.support.fmus import VERSIONS, Fmu, need_fmpy, written

pytestmark = needs_cc
T_END = 0.6  # s
TIMES = np.linspace(0.0, T_END, 13)
EXAMPLES = {  # what each has that the others have not
    "pendulum": "a tree",
    "stiff_triple": "hinges for which the integrator switches to an implicit method",
    "five_bar": "loops",
    "limit_stop": "limits, and events",
    "crawler": "a floating base on the ground, with a quaternion",
}


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory):
    """made(name, fmi) -> simulator, FMU file, unzipped folder; each made once."""
    known: dict[tuple[str, int], tuple[Simulator, Path, Path]] = {}
    simulators: dict[str, Simulator] = {}

    def make(name: str, fmi: int) -> tuple[Simulator, Path, Path]:
        if (name, fmi) not in known:
            if name not in simulators:
                simulators[name] = lamc.compile(mechanism_of(name))
            file = written(simulators[name], fmi, tmp_path_factory.mktemp(name))
            folder = file.with_suffix("")
            with zipfile.ZipFile(file) as archive:
                archive.extractall(folder)
            known[name, fmi] = (simulators[name], file, folder)
        return known[name, fmi]

    return make


def angles_of(simulator: Simulator) -> list[str]:
    return [f"{joint}.angle" for joint in simulator.joints]


def states_of(simulator: Simulator, fmu: Fmu) -> list[str]:
    """Names of all coordinates and rates: a state's number counts from the first angle."""
    names = list(fmu.by_name)
    first = names.index(f"{simulator.joints[0]}.angle")
    return names[first : first + len(simulator.coordinates) + len(simulator.rates)]


@pytest.mark.parametrize(
    ("name", "fmi"), [*((name, 3) for name in EXAMPLES), ("pendulum", 2), ("crawler", 2)]
)
@pytest.mark.quick("*-3", "pendulum-2")
class TestEveryKind:
    def test_the_description_keeps_the_standard(self, made, name, fmi):
        need_fmpy()
        from fmpy.validation import validate_fmu

        _, file, _ = made(name, fmi)
        assert validate_fmu(str(file)) == []  # schema, names, units, starts, structure

    @pytest.mark.quick("pendulum-*", "limit_stop-3", others="campaign")
    def test_its_page_tells_every_variable_and_what_its_flags_say(self, made, name, fmi):
        _, _, folder = made(name, fmi)
        page = html.unescape((folder / "documentation" / "index.html").read_text(encoding="utf-8"))
        root = ElementTree.parse(folder / "modelDescription.xml").getroot()
        flags = root.find("CoSimulation").attrib
        variables = root.find("ModelVariables")
        for variable in variables:
            (real,) = variable if fmi == 2 else [variable]
            reported = f"<tr><td><code>{variable.get('name')}</code></td><td>"
            (row,) = [line for line in page.splitlines() if line.startswith(reported)]
            assert f"<td>{real.get('unit', '')}</td>" in row
            assert row.endswith(f"<td>{variable.get('description')}</td></tr>")
        assert ("adjoint" in page) == (flags.get("providesAdjointDerivatives") == "true")
        assert ("event mode" in page) == (flags.get("hasEventMode") == "false")
        assert "central differences" in page
        assert f"FMI {fmi}.0" in page

    @pytest.mark.quick("pendulum-*", "limit_stop-3")
    def test_trajectory_is_that_of_the_simulator_to_the_last_bit(self, made, name, fmi):
        simulator, _, folder = made(name, fmi)
        fmu = Fmu(folder).begin(stop=T_END)
        names = states_of(simulator, fmu)
        rows = np.array(fmu.walk(TIMES, *names))
        result = simulator.run(T_END, t_eval=TIMES)
        assert np.array_equal(rows, np.hstack([result.q, result.u]))
        assert fmu.said == []
        fmu.free()

    @pytest.mark.quick("pendulum-*", "limit_stop-3")
    def test_outputs_are_those_of_the_result(self, made, name, fmi):
        simulator, _, folder = made(name, fmi)
        fmu = Fmu(folder).begin(stop=T_END)
        bodies = [body.name for body in simulator.mechanism.bodies if not body.fixed]
        names = [f"{b}.position[{i}]" for b in bodies for i in (1, 2, 3)]
        names += [f"{b}.rotation[{i},{j}]" for b in bodies for i in (1, 2, 3) for j in (1, 2, 3)]
        rows = np.array(fmu.walk(TIMES, "energy.total", *names))
        result = simulator.run(T_END, t_eval=TIMES)
        # Energies are sums of the same terms, in an order of its own.
        scale = np.abs(result.energy).max() + 1e-12
        assert np.abs(rows[:, 0] - result.energy).max() <= 1e-13 * scale
        positions = np.hstack([result.pose(b)[0] for b in bodies])
        rotations = np.hstack([result.pose(b)[1].reshape(len(TIMES), 9) for b in bodies])
        assert np.array_equal(rows[:, 1:], np.hstack([positions, rotations]))
        fmu.free()

    @pytest.mark.quick("pendulum-*", "limit_stop-3")
    def test_a_saved_state_goes_on_with_the_same_bits(self, made, name, fmi):
        _, _, folder = made(name, fmi)
        whole, other = Fmu(folder).begin(stop=T_END), Fmu(folder, "two").begin(stop=T_END)
        middle = 6
        whole.walk(TIMES[: middle + 1])
        state = whole.fmu.getFMUState()
        content = whole.fmu.serializeFMUState(state)
        expected = whole.walk(TIMES[middle:], *whole.by_name)
        whole.fmu.setFMUState(state)
        assert whole.walk(TIMES[middle:], *whole.by_name) == expected
        restored = other.fmu.deserializeFMUState(content)
        other.fmu.setFMUState(restored)
        assert other.walk(TIMES[middle:], *other.by_name) == expected
        for fmu, kept in ((whole, state), (other, restored)):
            fmu.fmu.freeFMUState(kept)
            fmu.free()

    @pytest.mark.quick("pendulum-3", "pendulum-2", "limit_stop-3")
    def test_it_begins_anew_after_a_reset(self, made, name, fmi):
        _, _, folder = made(name, fmi)
        fmu = Fmu(folder).begin(stop=T_END)
        first = fmu.walk(TIMES[:4], *fmu.by_name)
        fmu.fmu.reset()
        assert fmu.begin(stop=T_END).walk(TIMES[:4], *fmu.by_name) == first
        fmu.free()

    def test_dependencies_leave_nothing_out(self, made, name, fmi):
        """What moves when a state is moved is in the lists of what depends on it."""
        simulator, _, folder = made(name, fmi)
        fmu = Fmu(folder).begin(stop=T_END)
        fmu.walk(TIMES[:3])
        states = states_of(simulator, fmu)
        outputs = [u.variable.name for u in fmu.description.outputs]
        listed = {u.variable.name: {d.name for d in u.dependencies} for u in fmu.description.outputs}
        for state in states:
            moved = fmu.derivative(outputs, [state], [1.0])
            scale = max(map(abs, moved))
            for output, slope in zip(outputs, moved, strict=True):
                if abs(slope) > 1e-7 * scale:  # far above what differences leave where nothing moves
                    assert state in listed[output], (state, output)
        fmu.free()


@pytest.mark.parametrize("fmi", VERSIONS)
def test_fmpy_simulates_it_as_it_comes(made, fmi):
    simulator, file, _ = made("pendulum", fmi)
    rows = need_fmpy().simulate_fmu(
        str(file), stop_time=T_END, output_interval=T_END / 12, output=angles_of(simulator)
    )
    result = simulator.run(T_END, t_eval=np.minimum(rows["time"], T_END))
    assert np.array_equal(np.array([rows[name] for name in angles_of(simulator)]).T, result.q)


@pytest.mark.parametrize("fmi", VERSIONS)
def test_compiled_from_its_sources_it_is_the_same(made, fmi, tmp_path):
    need_fmpy()
    pytest.importorskip("cmake", reason="FMPy compiles with cmake")
    from fmpy.build import build_platform_binary

    _, file, folder = made("pendulum", fmi)
    mine = Fmu(folder).begin(stop=T_END)
    expected = mine.walk(TIMES, *mine.by_name)
    with zipfile.ZipFile(file) as archive:
        archive.extractall(tmp_path, [n for n in archive.namelist() if not n.startswith("binaries/")])
    build_platform_binary(tmp_path, all_warnings=True)
    theirs = Fmu(tmp_path).begin(stop=T_END)
    assert theirs.walk(TIMES, *theirs.by_name) == expected
    mine.free()
    theirs.free()


@pytest.mark.slow
@pytest.mark.parametrize("fmi", VERSIONS)
def test_a_thousand_instances_leave_nothing_behind(made, fmi):
    _, _, folder = made("pendulum", fmi)
    fmu = Fmu(folder)

    def memory_after(count: int) -> int:
        for _ in range(count):
            fmu.begin(stop=T_END).step(0.0, 0.01)
            fmu.fmu.freeFMUState(fmu.fmu.getFMUState())
            fmu.free()
            fmu.renew()
        pages = int(Path("/proc/self/statm").read_text().split()[1])
        return pages * resource.getpagesize()

    if not Path("/proc/self/statm").exists():
        pytest.skip("needs /proc to see memory")
    before = memory_after(100)  # what Python and FMPy keep of their own is there then
    grown = memory_after(1000) - before
    fmu.free()
    # An instance and its state have some 12 kB: one in ten left behind would be 1 MB.
    assert grown < 1_000_000


@pytest.mark.parametrize("fmi", VERSIONS)
class TestDerivatives:
    """A chain of three, in the middle of a motion."""

    @pytest.fixture
    def fmu(self, made, fmi):
        simulator, _, folder = made("pendulum", fmi)
        fmu = Fmu(folder).begin(stop=T_END)
        fmu.walk(TIMES[:6])
        yield simulator, fmu
        fmu.free()

    def test_accelerations_against_differences_of_the_simulator(self, fmu, fmi):
        simulator, fmu = fmu
        n = len(simulator.joints)
        states, t = states_of(simulator, fmu), fmu.get("time")[0]
        y = np.array(fmu.get(*states))
        unknowns = [f"der({joint}.rate)" for joint in simulator.joints]
        seed = np.array([0.3, -1.0, 0.5, 0.2, 0.7, -0.4])
        reported = np.array(fmu.derivative(unknowns, states, seed))
        h = 1e-4  # error of this formula: h⁴ f⁽⁵⁾ / 30, some 1e-16 f⁽⁵⁾, and round-off of 1e-16 / h
        values = [simulator.acceleration(*np.split(y + k * h * seed, [n]), t) for k in (-2, -1, 1, 2)]
        expected = (values[0] - 8 * values[1] + 8 * values[2] - values[3]) / (12 * h)
        assert reported == pytest.approx(expected, rel=1e-9, abs=1e-9 * np.abs(expected).max())

    def test_poses_turn_about_the_first_hinge(self, fmu, fmi):
        """∂r/∂q = axis × (r - point) for all that hangs on a hinge that is fixed in the world."""
        simulator, fmu = fmu
        joint = next(j for j in simulator.mechanism.joints if j.name == simulator.joints[0])
        for body in (b.name for b in simulator.mechanism.bodies if not b.fixed):
            names = [f"{body}.position[{i}]" for i in (1, 2, 3)]
            r = np.array(fmu.get(*names))
            reported = fmu.derivative(names, [f"{joint.name}.angle"], [1.0])
            axis = np.array(joint.axis) / np.linalg.norm(joint.axis)
            # central differences over 6e-6: h² / 6 of the arm, and round-off of 1e-16 / h
            assert reported == pytest.approx(np.cross(axis, r - np.array(joint.point)), abs=1e-9)

    def test_energy_changes_by_the_power_of_the_dampers(self, fmu, fmi):
        simulator, fmu = fmu
        states = states_of(simulator, fmu)
        n = len(simulator.joints)
        slope = fmu.get(*states[n:], *(f"der({joint}.rate)" for joint in simulator.joints))
        (change,) = fmu.derivative(["energy.total"], states, slope)
        rates = np.array(fmu.get(*states[n:]))
        dampings = np.array([simulator.parameters.get(f"{j}.damping", 0.0) for j in simulator.joints])
        power = -float(dampings @ rates**2)
        kinetic = fmu.derivative(["energy.kinetic"], states, slope)[0]
        assert change == pytest.approx(power, abs=1e-8 * abs(kinetic))  # differences, of terms that cancel

    def test_stored_energy_is_half_k_of_the_angle_squared(self, fmu, fmi):
        simulator, fmu = fmu
        name = simulator.joints[1]
        angle, k = fmu.get(f"{name}.angle", f"{name}.stiffness")
        reported = fmu.derivative(["energy.hinge_stiffness"], [f"{name}.stiffness"], [2.0])
        assert reported == pytest.approx(
            [angle**2], rel=1e-9
        )  # linear in k: round-off of 1e-16 / 6e-6 is left
        reported = fmu.derivative(["energy.hinge_stiffness"], [f"{name}.angle"], [1.0])
        assert reported == pytest.approx([k * angle], rel=1e-8)

    def test_the_adjoint_is_the_transpose(self, fmu, fmi):
        if fmi == 2:
            pytest.skip("FMI 2.0 has no adjoint derivatives")
        simulator, fmu = fmu
        states = states_of(simulator, fmu)
        unknowns = [f"der({joint}.rate)" for joint in simulator.joints] + ["energy.total"]
        matrix = np.array([fmu.derivative(unknowns, [state], [1.0]) for state in states]).T
        seed = [1.0, -2.0, 0.5, 3.0]
        reported = fmu.fmu.getAdjointDerivative(
            fmu.references(unknowns), fmu.references(states), seed, nSensitivity=len(states)
        )
        assert reported == pytest.approx(np.array(seed) @ matrix, rel=1e-12, abs=1e-12 * np.abs(matrix).max())

    def test_they_change_nothing(self, fmu, fmi):
        simulator, fmu = fmu
        before = fmu.all_values()
        states = states_of(simulator, fmu)
        fmu.derivative(["energy.total"], [*states, "link_1.mass"], [1.0] * (len(states) + 1))
        assert fmu.all_values() == before
        after = fmu.walk(TIMES[5:], *states)[-1]
        result = simulator.run(T_END, t_eval=TIMES)
        assert after == [*result.q[-1], *result.u[-1]]

    def test_what_is_no_known_or_unknown_is_refused(self, fmu, fmi):
        _, fmu = fmu
        with fmu.refusing("no known"):
            fmu.derivative(["energy.total"], ["energy.kinetic"], [1.0])
        with fmu.refusing("no unknown"):
            fmu.derivative(["link_1.mass"], ["h1.angle"], [1.0])
        with fmu.refusing("seed is nan"):
            fmu.derivative(["energy.total"], ["h1.angle"], [float("nan")])
