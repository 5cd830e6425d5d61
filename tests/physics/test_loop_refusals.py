"""Bad input of mechanisms with loops: each is refused in one line with file and line, the value, and a way out.

By hand, as a mechanism file, as a drawing, as a joint definition and on the command line.
"""

import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import ClassVar

import numpy as np
import pytest
from click.testing import CliRunner

import lamc
from lamc.basics.errors import DesignError, LamcError, TopologyError
from lamc.cli import main
from lamc.examples import path as example
from lamc.mechanics.loads import Loads
from lamc.mechanism.limits import outside_limits
from tests.support.paths import FIXTURES

FOUR_BAR = """\
kind: mechanism
bodies:
  - {name: ground, fixed: true}
  - {name: crank, mass: 0.1, com: [0.05, 0, 0], inertia: [[1e-5, 0, 0], [0, 1e-4, 0], [0, 0, 1e-4]]}
  - {name: coupler, mass: 0.1, com: [0.2, 0.05, 0], inertia: [[1e-5, 0, 0], [0, 1e-4, 0], [0, 0, 1e-4]]}
  - {name: rocker, mass: 0.1, com: [0.3, 0.05, 0], inertia: [[1e-5, 0, 0], [0, 1e-4, 0], [0, 0, 1e-4]]}
joints:
  - {name: A, parent: ground, child: crank, point: [0, 0, 0], axis: [0, 0, 1]}
  - {name: B, parent: crank, child: coupler, point: [0.1, 0, 0], axis: [0, 0, 1]}
  - {name: C, parent: coupler, child: rocker, point: [0.3, 0.1, 0], axis: [0, 0, 1]}
  - {name: D, parent: ground, child: rocker, point: [0.3, 0, 0], axis: [0, 0, 1], limits: [-3, 3]}
"""
ANOTHER_B = "  - {name: E, parent: %s, child: %s, point: [0.1, %s, %s], axis: [0, 0, %s]}\n"
AFLOAT = """\
  - {name: p, mass: 0.1, com: [1, 0, 0], inertia: [[1e-5, 0, 0], [0, 1e-4, 0], [0, 0, 1e-4]]}
  - {name: q, mass: 0.1, com: [1, 1, 0], inertia: [[1e-5, 0, 0], [0, 1e-4, 0], [0, 0, 1e-4]]}
joints:
  - {name: F, parent: p, child: q, point: [1, 0.5, 0], axis: [0, 0, 1]}
  - {name: G, parent: p, child: q, point: [1, 0.7, 0], axis: [0, 0, 1]}
"""

# what is replaced, by what, the line that the message must name (or what stands on it), and what it must say
Damage = tuple[str, str, int | str, str]
MECHANISM_FILES: dict[str, Damage] = {
    "one joint name twice": ("name: B", "name: A", 9, "two joints are named 'A'; names must differ"),
    "one body name twice": ("name: rocker", "name: crank", 6, "two bodies are named 'crank'"),
    "a hinge twice": (
        "[-3, 3]}\n",
        "[-3, 3]}\n" + ANOTHER_B % ("crank", "coupler", 0, 0, 1),
        12,
        "joints 'B' and 'E' are the same hinge: both join 'crank' and 'coupler' .*; remove one of them",
    ),
    "a hinge twice, the other way round": (
        "[-3, 3]}\n",
        "[-3, 3]}\n" + ANOTHER_B % ("coupler", "crank", 0, 0, -1),
        12,
        "joints 'B' and 'E' are the same hinge",
    ),
    "a body hinged to itself": (
        "parent: crank",
        "parent: coupler",
        9,
        "joins 'coupler' to itself; a hinge needs two",
    ),
    "a body that is not there": (
        "child: rocker, point: [0.3, 0, 0]",
        "child: roker, point: [0.3, 0, 0]",
        11,
        "joins body 'roker', which the mechanism does not have; its bodies are coupler, crank, ground, rocker",
    ),
    "no direction": ("[0, 0, 0], axis: [0, 0, 1]", "[0, 0, 0], axis: [0, 0, 0]", 8, "must have a direction"),
    "a direction that is no number": (
        "[0, 0, 0], axis: [0, 0, 1]",
        "[0, 0, 0], axis: [0, .nan, 1]",
        8,
        "is nan",
    ),
    "a loop of fixed bodies": (
        "name: crank",
        "fixed: true, name: crank",
        8,
        "joins two fixed bodies, 'ground' and",
    ),
    "nothing fixed": (
        "fixed: true",
        "mass: 1",
        3,
        "no body is fixed, so nothing holds the mechanism; fix one",
    ),
    "bodies that no hinge holds": (
        "joints:\n",
        AFLOAT,
        7,
        "body 'p' and 1 more has no path of hinges to a fixed body",
    ),
    "limits the wrong way round": (
        "[-3, 3]",
        "[3, -3]",
        11,
        r"limits of joint 'D' are \(3, -3\) rad; the lower must be",
    ),
    "limits that leave no angle": (
        "[-3, 3]",
        "[1, 1]",
        11,
        r"limits of joint 'D' are \(1, 1\) rad; the lower must be",
    ),
    "a limit that is no number": (
        "[-3, 3]",
        "[.nan, 3]",
        11,
        r"limits\[0\]: the angle is nan; it must be finite",
    ),
    "a limit without end": ("[-3, 3]", "[-3, .inf]", 11, r"limits\[1\]: the angle is inf; it must be finite"),
    "one limit": ("[-3, 3]", "[-3]", 11, r"limits\[1\]: a value is missing here"),
    "a word for limits": (
        "[-3, 3]",
        "wide",
        11,
        "limits: a list of values is expected here, and it is 'wide'",
    ),
    "an angle of no joint": (
        "[-3, 3]}",
        "[-3, 3]}\nscene: {angles: {K: 0.1}}",
        12,
        "no joint is named 'K'; known are A, B",
    ),
    "a rate of no joint": (
        "[-3, 3]}",
        "[-3, 3]}\nscene: {rates: {K: 0.1}}",
        12,
        "no joint is named 'K'; known are A, B",
    ),
    "an angle that is no number": (
        "[-3, 3]}",
        "[-3, 3]}\nscene: {angles: {A: .nan}}",
        12,
        "A: the angle is nan",
    ),
}

LEFT_LINE = "[[-20, 0], [-20, 12]]"
RIGHT_LINE = "[[20, 0], [20, 12]]"
MATERIALS = """\
  plate: {density: 1.8 g/cm^3, E1: 70 GPa, E2: 70 GPa, poisson: 0.3, rigid: true}
  film: {density: 1.42 g/cm^3,"""
LIMITS = "[-120 deg, 120 deg]"
ONE_MORE = "  - {name: again, line: %s, gap: 0.4}\n\nfixed:\n"
DRAWINGS: dict[str, Damage] = {
    "a hinge line twice": (
        "\nfixed:\n",
        ONE_MORE % RIGHT_LINE,
        "name: again",
        "'again' and hinge 'right' are drawn on the same line; keep",
    ),
    "a hinge line twice, backwards": (
        "\nfixed:\n",
        ONE_MORE % "[[20, 12], [20, 0]]",
        "name: again",
        "hinge 'again' and hinge 'right' are drawn on the same line; keep one",
    ),
    "one hinge name twice": (
        "name: right",
        "name: left # again",
        "name: left # again",
        "two hinges are named 'left'; names must differ",
    ),
    "a hinge line of no length": (
        RIGHT_LINE,
        "[[20, 5], [20, 5]]",
        "[[20, 5], [20, 5]]",
        "starts and ends at .*; it needs two different ends",
    ),
    "a hinge line of next to no length": (
        RIGHT_LINE,
        "[[20, 5], [20, 5.00001]]",
        "[[20, 5], [20, 5.00001]]",
        "1e-05 mm long .*; make it longer",
    ),
    "a hinge within one body": (
        RIGHT_LINE,
        "[[5, 2], [5, 8]]",
        "[[5, 2], [5, 8]]",
        "touches 1 body .*; a hinge needs exactly 2",
    ),
    "a hinge line beside the device": (
        RIGHT_LINE,
        "[[90, 0], [90, 12]]",
        "[[90, 0], [90, 12]]",
        "touches 0 bodies; .* outside the device",
    ),
    "limits the wrong way round": (
        LIMITS,
        "[120 deg, -120 deg]",
        "name: left",
        "limits run from .*; the lower comes first",
    ),
    "limits in bare degrees": (
        LIMITS,
        "[-1, 120]",
        "[-1, 120]",
        "bare angles are radians: write '120 deg' for degrees",
    ),
    "a limit that is no number": (
        LIMITS,
        "[.nan, 120 deg]",
        "[.nan, 120 deg]",
        r"limits\[0\]: the angle is nan; it must be finite",
    ),
    "no fixed region": (
        "fixed:\n  - rect: [-10, 2, 10, 10]",
        "",
        "kind: design",
        "'flaps' has no fixed region, .*; draw one over",
    ),
    "a fixed region beside the device": (
        "[-10, 2, 10, 10]",
        "[-10, 92, 10, 99]",
        "[-10, 92, 10, 99]",
        "meets no body, .*; draw it over",
    ),
    "a fixed region over a hinge": (
        "[-10, 2, 10, 10]",
        "[-30, 2, 10, 10]",
        LEFT_LINE,
        "which are both fixed, so it cannot turn: keep",
    ),
    "no density": (
        MATERIALS,
        MATERIALS.replace("1.8", "0").replace("1.42", "0"),
        "name: lower",
        "has zero mass: the density of .* is 0 kg/m³; give",
    ),
    "material that nothing holds": (
        "shapes:\n",
        "shapes:\n  - rect: [80, 0, 90, 9]\n",
        "kind: design",
        "no path to the world: .*; join each",
    ),
}

CONNECTIONS = "[1002, 1001]"
JOINT_DEFINITIONS: dict[str, Damage] = {
    "a body hinged to itself": (
        CONNECTIONS,
        "[1001, 1001]",
        28,
        "joins body '1001' to itself; a hinge needs two",
    ),
    "a body that is not there": (
        CONNECTIONS,
        "[1009, 1001]",
        28,
        "body '1009', .*; its bodies are 1001, 1002, 1003",
    ),
    "a loop of fixed bodies": ("newtonian_ids:\n", "newtonian_ids:\n- 1002\n", 28, "joins two fixed bodies"),
    "nothing fixed": ("newtonian_ids:\n- 1001", "newtonian_ids: []", 1, "no body is fixed"),
    "a fixed body that is not there": (
        "newtonian_ids:\n",
        "newtonian_ids:\n- 77\n",
        1,
        "the fixed body '77' is not among",
    ),
    "a hinge line of no length": ("[-0.02, 0.012]", "[-0.02, 0.0]", 28, "it needs two different ends"),
    "a hinge twice": (
        "[0.02, 0.0]\n    - !!python/tuple [0.02, 0.012]\n  - !!python/tuple [1001, 1003]",
        "[-0.02, 0.0]\n    - !!python/tuple [-0.02, 0.012]\n  - !!python/tuple [1001, 1002]",
        35,
        "are the same hinge: both join",
    ),
    "limits the wrong way round": (
        "limit_neg: -120, limit_pos: 120",
        "limit_neg: 120, limit_pos: -120",
        28,
        "the lower must",
    ),
    "a limit that is no number": (
        "limit_neg: -120",
        "limit_neg: .nan",
        34,
        "limit_neg is nan; it must be finite",
    ),
}


def damaged(text: str, damage: Damage) -> str:
    old, new, _, _ = damage
    assert old in text, old
    return text.replace(old, new, 1)


def refused(file: Path, damage: Damage) -> None:
    """By `lamc.compile`, and by the command line with exit code 2 and the same line."""
    _, _, line, message = damage
    if isinstance(line, str):
        lines = file.read_text(encoding="utf-8").splitlines()
        line = next(number for number, text in enumerate(lines, 1) if line in text)
    with pytest.raises(LamcError, match=message) as caught:
        lamc.compile(lamc.load(file))
    assert str(caught.value).splitlines()[0].startswith(f"{file}:{line}:"), str(caught.value)
    result = CliRunner().invoke(main, ["run", str(file), "--out", str(file.parent / "out")])
    assert result.exit_code == 2, result.output
    errors = [each for each in result.stderr.splitlines() if each.startswith("error:")]
    assert errors[0].startswith(f"error: {file}:{line}:"), result.stderr
    assert re.search(message, errors[0])
    assert "Traceback" not in result.output


@pytest.mark.parametrize("name", list(MECHANISM_FILES))
def test_mechanism_files_are_refused_with_their_line(tmp_path: Path, name: str) -> None:
    file = tmp_path / "bar.yaml"
    file.write_text(damaged(FOUR_BAR, MECHANISM_FILES[name]), encoding="utf-8")
    refused(file, MECHANISM_FILES[name])


@pytest.mark.parametrize("name", list(DRAWINGS))
def test_drawings_are_refused_with_their_line(tmp_path: Path, name: str) -> None:
    file = tmp_path / "flaps.yaml"
    file.write_text(damaged(example("flaps").read_text(encoding="utf-8"), DRAWINGS[name]), encoding="utf-8")
    refused(file, DRAWINGS[name])


@pytest.mark.parametrize("name", list(JOINT_DEFINITIONS))
def test_joint_definitions_are_refused_with_their_line(tmp_path: Path, name: str) -> None:
    file = tmp_path / "flaps.joints"
    text = (FIXTURES / "designs" / "flaps.joints").read_text(encoding="utf-8")
    file.write_text(damaged(text, JOINT_DEFINITIONS[name]), encoding="utf-8")
    refused(file, JOINT_DEFINITIONS[name])


def bar(name: str, **changes: object) -> lamc.Body:
    values = {"mass": 0.1, "inertia": np.diag([1e-5, 1e-4, 1e-4]), **changes}
    return lamc.Body(name, **values)  # type: ignore[arg-type]


def pin(name: str, parent: str, child: str, x: float, **changes: object) -> lamc.Joint:
    return lamc.Joint(name, parent, child, point=(x, 0.0, 0.0), **changes)  # type: ignore[arg-type]


def pair(*joints: lamc.Joint) -> lamc.Mechanism:
    return lamc.Mechanism((bar("wall", fixed=True), bar("arm"), bar("tip")), joints)


BY_HAND: dict[str, tuple[Callable[[], object], str]] = {
    "one joint name twice": (
        lambda: pair(pin("a", "wall", "arm", 0), pin("a", "arm", "tip", 1)),
        "two joints are named 'a'; names must differ",
    ),
    "a hinge twice": (
        lambda: pair(pin("a", "wall", "arm", 0), pin("b", "arm", "tip", 1), pin("c", "tip", "arm", 1)),
        "joints 'b' and 'c' are the same hinge: .*; remove one of them",
    ),
    "a body hinged to itself": (
        lambda: pin("a", "arm", "arm", 0),
        "joins 'arm' to itself; a hinge needs two",
    ),
    "no direction": (lambda: pin("a", "wall", "arm", 0, axis=(0, 0, 0)), "must have a direction"),
    "limits the wrong way round": (
        lambda: pin("a", "wall", "arm", 0, limits=(1, -1)),
        "the lower must be below",
    ),
    "a limit that is no number": (
        lambda: pin("a", "wall", "arm", 0, limits=(np.nan, 1)),
        "is nan; it must be finite",
    ),
    "a limit without end": (
        lambda: pin("a", "wall", "arm", 0, limits=(-1, np.inf)),
        "the upper limit of joint 'a' is inf; it must be finite: leave limits out where there are none",
    ),
    "a body that is not there": (
        lambda: pair(pin("a", "wall", "leg", 0)),
        "joins body 'leg', which the mechanism does",
    ),
    "bodies that no hinge holds": (
        lambda: lamc.compile(pair(pin("a", "arm", "tip", 0))),
        "body 'arm' and 1 more has no path of hinges to a fixed body",
    ),
    "a start of no joint": (
        lambda: lamc.compile(
            pair(pin("a", "wall", "arm", 0), pin("b", "arm", "tip", 1)), lamc.Scene(angles={"c": 1})
        ),
        "an initial angle to joint 'c', which is not there; there are a, b",
    ),
}


@pytest.mark.parametrize("name", list(BY_HAND))
def test_what_is_made_by_hand_is_refused(name: str) -> None:
    make, message = BY_HAND[name]
    with pytest.raises(LamcError, match=message) as caught:
        make()
    assert "\n" not in str(caught.value)


def test_two_hinges_of_a_door_are_one_freedom(tmp_path: Path) -> None:
    """On one line, apart: redundant, and no fault."""
    file = tmp_path / "door.yaml"
    file.write_text(FOUR_BAR + ANOTHER_B % ("crank", "coupler", 0, 0.03, 1), encoding="utf-8")
    sim = lamc.compile(lamc.load(file))
    assert (sim.loops.loops, sim.loops.freedoms) == (2, 1)
    result = sim.run(t_end=0.1, rtol=1e-9)
    assert result.success, result.message
    assert result.constraint_error.max() <= 1e-9 * sim.mechanism.size  # as for any loop


STARTS = {
    "angles that contradict": ("angles: {A: 1.5, B: 1.5, C: 1.5}", r"A = 1.5, B = 1.5, C = 1.5"),
    "an angle beyond reach": ("angles: {A: 2.5}", r"A = 2.5"),
    "rates that contradict": ("rates: {A: 1, D: -7}", "no motion of the loops has the rates given"),
}


@pytest.mark.parametrize("name", list(STARTS))
def test_starts_that_no_position_has_are_refused(tmp_path: Path, name: str) -> None:
    scene, message = STARTS[name]
    file = tmp_path / "bar.yaml"
    # At 2.5 rad the crank's end is 0.38 m from D, and coupler and rocker together reach 0.324 m.
    file.write_text(f"{FOUR_BAR}scene: {{{scene}}}\n", encoding="utf-8")
    with pytest.raises(DesignError, match=message) as caught:
        lamc.compile(lamc.load(file)).run(t_end=0.1)
    assert "\n" not in str(caught.value)
    result = CliRunner().invoke(main, ["run", str(file), "--out", str(tmp_path / "out")])
    assert result.exit_code == 2, result.output
    assert re.search(message, result.stderr.splitlines()[-1])
    assert not (tmp_path / "out").exists()


def test_a_start_outside_limits_is_told_where_nothing_enforces_them(tmp_path: Path) -> None:
    """Of a joint of the tree, and of the one that closes the loop; a start on a limit is inside."""
    third = "point: [0.3, 0.1, 0], axis: [0, 0, 1]"
    text = FOUR_BAR.replace("[-3, 3]", "[-0.2, 0.2]").replace(third, f"{third}, limits: [0.5, 1]")
    file = tmp_path / "bar.yaml"
    file.write_text(f"{text}scene: {{effects: {{gravity: }}, angles: {{D: 0.4}}}}\n", encoding="utf-8")
    result = CliRunner().invoke(main, ["run", str(file), "--t-end", "0.01", "--out", str(tmp_path)])
    assert result.exit_code == 0, result.output
    assert "joint 'D' starts at 0.4 rad, outside its limits (-0.2, 0.2)" in result.stdout
    assert re.search(r"joint 'C' starts at \S+ rad, outside its limits \(0.5, 1\)", result.stdout)
    on_it = lamc.Mechanism(
        (bar("wall", fixed=True), bar("arm")), (pin("a", "wall", "arm", 0, limits=(-0.2, 0.2)),)
    )
    assert outside_limits(on_it, {"a": 0.2}) == ()
    assert len(outside_limits(on_it, {"a": 0.2001})) == 1


@dataclass(frozen=True)
class Shy:
    """An effect without forces that refuses every start, and keeps what it was shown."""

    seen: dict[str, float] = field(default_factory=dict)

    name: ClassVar[str] = "shy"
    summary: ClassVar[str] = "Nothing"

    def contribute(self, loads: Loads) -> None: ...

    def check_start(self, mechanism: lamc.Mechanism, angles: Mapping[str, float]) -> None:
        self.seen.update(angles)
        raise DesignError("; ".join(outside_limits(mechanism, angles)))


def test_an_effect_may_refuse_a_start_and_sees_all_joints_of_a_loop(tmp_path: Path) -> None:
    file = tmp_path / "bar.yaml"
    file.write_text(FOUR_BAR.replace("[-3, 3]", "[-0.2, 0.2]"), encoding="utf-8")
    shy = Shy()
    sim = lamc.compile(lamc.load(file), lamc.Scene(effects=(shy,), angles={"D": 0.4}))
    with pytest.raises(DesignError, match=r"'D' starts at 0\.4 rad, outside its limits"):
        sim.run(t_end=0.1)
    assert sorted(shy.seen) == ["A", "B", "C", "D"]
    # Angles of a plane loop: A + B + C, coupler and rocker apart by C, is what D turns.
    assert shy.seen["A"] + shy.seen["B"] + shy.seen["C"] == pytest.approx(0.4, abs=1e-9)  # closure


def test_topology_errors_keep_their_kind() -> None:
    with pytest.raises(TopologyError):
        pair(pin("a", "wall", "arm", 0), pin("b", "wall", "arm", 0))
