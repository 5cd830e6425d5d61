"""Whatever a scene says, reading it ends soon, with scenes that can be written and read again or errors at their line,
and runs nothing."""

import json
import time
from dataclasses import fields
from pathlib import Path
from typing import Any

import pytest
from hypothesis import HealthCheck, event, given, settings
from hypothesis import strategies as st

import lamc
from lamc.basics.errors import LamcError
from lamc.effects.registry import EFFECTS, choose
from lamc.readers.inert import Limits
from lamc.readers.load_scene import load_scene, scene_of_text
from lamc.readers.mechanism_file import mechanism_text
from lamc.records.mechanism import Mechanism
from tests.support.mechanisms import chain
from tests.support.quick import tries
from tests.unit.test_fuzz_readers import FRAGMENTS, LIMITS, PATIENCE
from tests.unit.test_scenes import SCENES

FEW = settings(
    max_examples=tries(100), deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture]
)

FIELDS = {kind.name: [f.name for f in fields(kind)] for kind in EFFECTS}  # type: ignore[arg-type]
HOSTILE = [
    "__import__('os').system('touch pwned')",
    "t.__class__",
    "1/0",
    "sqrt(-1)",
    "9**9**9",
    "((((t))))" * 9,
]
ODD: list[Any] = [
    *(
        None,
        True,
        False,
        0,
        1,
        -1,
        1e300,
        -1e-300,
        10**400,
        "",
        "h0",
        "b",
        "3 N*mm",
        "1 m",
        "-2 deg",
        "nan",
        "1e999",
    ),
    *(
        [],
        [1],
        [0, 0, 1],
        [[0, 0], [1, 1]],
        {},
        {"h0": 1},
        {"h0": "sin(t)"},
        "sin(2*pi*t) - 0.1*rate",
        *HOSTILE,
    ),
]
VALUE = st.sampled_from(ODD) | st.recursive(
    st.sampled_from(ODD),
    lambda inner: (
        st.lists(inner, max_size=3) | st.dictionaries(st.sampled_from(["h0", "a", "x"]), inner, max_size=3)
    ),
    max_leaves=5,
)


@st.composite
def calls(draw: st.DrawFn) -> Any:
    """What stands under `effects` or `with`."""
    names = draw(st.lists(st.sampled_from([*FIELDS, "gravty"]), max_size=3))
    said: list[Any] = []
    for name in names:
        known = [*FIELDS.get(name, []), "stifness"]
        record = st.dictionaries(st.sampled_from(known), VALUE, max_size=4)
        said.append(
            draw(st.just(name) | (st.none() | VALUE | record).map(lambda value, name=name: {name: value}))
        )
    if draw(st.booleans()):
        return said
    return {key: value for each in said if isinstance(each, dict) for key, value in each.items()}


@st.composite
def scenes(draw: st.DrawFn) -> dict[str, Any]:
    """A file of scenes; each key is there or not."""
    names = draw(st.lists(st.sampled_from(["a", "b", "c", "d e", "1", "ä-2"]), max_size=4, unique=True))
    entries = {
        "like": st.sampled_from([*names, "x"]),
        "effects": calls(),
        "with": calls(),
        "without": st.lists(st.sampled_from([*FIELDS, "x"]), max_size=2) | VALUE,
        "angles": st.dictionaries(
            st.sampled_from(["h0", "h1", "x"]), st.sampled_from([0.1, "5 deg", "1 kg", None])
        ),
        "rates": st.dictionaries(st.sampled_from(["h0", "h1"]), st.sampled_from([0.1, "1 Hz", [1]])),
        "branch": st.sampled_from([1, 0, "1", None]),
        "closure_tolerance": st.sampled_from([1e-3, "1 mm", -1]),
        "duration": st.sampled_from([1, "1 h", 0, "5"]),
        "outputs": st.sampled_from([["h0"], ["body0.x", "h1"], ["zz"], [], "h0", [1]]),
        "odd": VALUE,
    }

    def one() -> dict[str, Any]:
        keys = draw(st.lists(st.sampled_from([k for k in entries if k != "odd"]), max_size=4, unique=True))
        keys += ["odd"] if draw(st.integers(0, 9)) == 0 else []
        return {key: draw(entries[key]) for key in keys}

    return {"scenes": {name: one() for name in names}} | ({"scene": one()} if draw(st.booleans()) else {})


@settings(FEW, max_examples=tries(200))
@given(data=scenes())
def test_scenes_of_any_kind_are_read_or_refused_at_their_line(tmp_path: Path, data: dict[str, Any]) -> None:
    text = json.dumps(data, indent=1)
    file = tmp_path / "s.yaml"
    file.write_text(text, encoding="utf-8")
    began = time.process_time()
    read: dict[str, lamc.Scene] = {}
    reported = ""
    for name in [*data["scenes"], None]:
        try:
            read[name or ""] = load_scene(file, name, limits=LIMITS)
        except LamcError as error:
            reported = str(error)
            assert all(line.startswith(f"{file}:") or "say which" in line or "has no scene" in line
                       for line in reported.splitlines()), reported  # fmt: skip
            assert all(len(line) < 2000 for line in reported.splitlines())
    assert time.process_time() - began < PATIENCE
    assert not (tmp_path / "pwned").exists()
    event("read" if read else "refused")
    for scene in read.values():
        _is_written_and_chosen(scene)


def _is_written_and_chosen(scene: lamc.Scene) -> None:
    plain = chain(2)
    mechanism = Mechanism(plain.bodies, plain.joints, "m", scene=scene, scenes={"same": scene})
    unknown = {*scene.angles, *scene.rates} - {joint.name for joint in plain.joints}
    if not unknown:  # a mechanism's file refuses those, with their place
        again = scene_of_text(mechanism_text(mechanism), "again.yaml", "same")
        assert again == scene
    reported = ""
    try:
        choose(mechanism, scene)
    except LamcError as error:
        reported = str(error)
    assert "\n" not in reported


@FEW
@given(data=st.data())
def test_damaged_scenes_are_scenes_or_errors(tmp_path: Path, data: st.DataObject) -> None:
    start = data.draw(st.integers(0, len(SCENES)))
    length = data.draw(st.sampled_from([0, 1, 2, 5, 20, 100]))
    patch = data.draw(st.one_of(st.sampled_from(FRAGMENTS), st.text(max_size=5)))
    file = tmp_path / "s.yaml"
    file.write_bytes((SCENES[:start] + patch + SCENES[start + length :]).encode("utf-8", "surrogatepass"))
    began = time.process_time()
    reported = "a scene"
    try:
        load_scene(file, "heavier", limits=LIMITS)
    except LamcError as error:
        reported = str(error)
    assert reported
    assert time.process_time() - began < PATIENCE
    assert not (tmp_path / "pwned").exists()


@pytest.mark.parametrize(
    "text",
    [
        # a chain of a thousand scenes, each with a joint of its own: all they have is half a million angles
        "scenes:\n  s0: {angles: {j0: 1}}\n"
        + "".join(f"  s{k}: {{like: s{k - 1}, angles: {{j{k}: 1}}}}\n" for k in range(1, 1000)),
        # many angles in one scene
        "angles: {" + ", ".join(f"j{k}: 1" for k in range(10_000)) + "}",
        # a large scene that a thousand are like
        "scenes:\n  s: {angles: {" + ", ".join(f"j{k}: 1" for k in range(2000)) + "}}\n"
        + "".join(f"  s{k}: {{like: s, duration: 1}}\n" for k in range(900)),
        "scenes:\n" + "".join(f"  s{k}: {{like: s{(k + 1) % 900}}}\n" for k in range(900)),  # one ring
        "with: {torque: {h0: " + "sin(" * 300 + "t" + ")" * 300 + "}}",
        "with: {torque: {h0: " + "1+" * 5000 + "t}}",
        "with: [" + "gravity, " * 5000 + "]",
        "without: [" + "gravity, " * 5000 + "]",
        "outputs: [" + ", ".join(f"o{k}" for k in range(3000)) + "]",
        "like: " + "x" * 100_000,
        "scenes: {" + "x" * 100_000 + ": {duration: 1}}",
        "a: &a [*a]\nscenes: *a",
    ],
)  # fmt: skip
@pytest.mark.quick("text[134579]", "text10", "a:*")
def test_scenes_made_to_exhaust_end_soon(text: str) -> None:
    began = time.process_time()
    reported = ""
    try:
        scene_of_text(text, "s.yaml", None, limits=Limits(bytes=2_000_000, nodes=200_000, depth=100))
    except LamcError as error:
        reported = str(error)
    assert all(len(line) < 2000 for line in reported.splitlines())
    assert time.process_time() - began < PATIENCE
