"""Whatever a file holds, reading it ends soon, with a record or a LamcError, and runs nothing."""

import time
from pathlib import Path

import pytest
from hypothesis import HealthCheck, event, given, settings
from hypothesis import strategies as st

from lamc import examples
from lamc.basics.errors import LamcError
from lamc.mechanism.plan import plan
from lamc.readers.inert import Limits
from lamc.readers.load import load
from lamc.readers.mechanism_file import write_mechanism
from lamc.records.mechanism import Mechanism
from tests.support.quick import tries

# Small limits keep a case short; the largest real file here has 3000 values.
LIMITS = Limits(bytes=200_000, nodes=20_000, depth=100)
# A second is the promise; the machine may be busy with other tests at once, so the bound here is larger.
PATIENCE = 5.0
FEW = settings(
    max_examples=tries(60), deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture]
)

FRAGMENTS = (
    "!!python/object/apply:os.system ['touch pwned']",
    "!!python/object/new:subprocess.Popen [[touch, pwned]]",
    "!!python/object:popupcad.manufacturing.code_exec_op.CodeExecOp {id: 1}",
    *("&a [*a, *a]", "*id001", ".nan", "-.inf", "1e999", "'9'", "~", "[]", "{}", "[[[[", "? [", "9" * 500),
    *("\t", "\x00", "%TAG", "!", "!<tag:x>", "|\n  x", ": : :", "\u2028", "- - -", "<<: *x"),
    *("POLYGON ((0 0, 1 1))", "GEOMETRYCOLLECTION (" * 20),
)


def sources(shared: Path) -> list[str]:
    drawn = shared / "designs"
    files = [drawn / "popupcad" / "pendulum.cad", drawn / "flaps.joints", drawn / "flaps_old.joints"]
    return [file.read_text(encoding="utf-8") for file in (*files, *map(examples.path, examples.files()))]


def attempt(folder: Path, data: bytes) -> None:
    """Reads the bytes as a file; anything but a record or a LamcError escapes and fails the test."""
    file = folder / "fuzzed"
    file.write_bytes(data)
    began = time.process_time()
    message = "a record"
    try:
        load(file, limits=LIMITS)
    except LamcError as error:
        message = str(error)
    assert message
    assert all(len(line) < 2000 for line in message.splitlines())
    assert time.process_time() - began < PATIENCE
    assert not (folder / "pwned").exists()


@FEW
@given(text=st.text(max_size=200))
def test_any_text_is_a_record_or_an_error(tmp_path: Path, text: str) -> None:
    attempt(tmp_path, text.encode("utf-8", "surrogatepass"))


@FEW
@given(data=st.binary(max_size=200))
def test_any_bytes_are_a_record_or_an_error(tmp_path: Path, data: bytes) -> None:
    attempt(tmp_path, data)


@FEW
@given(
    pieces=st.lists(
        st.sampled_from(
            [*FRAGMENTS, "layers:", "shapes:", "kind: mechanism", "bodies:", "\n", " ", "- ", ", "]
        )
    )
)
def test_any_mixture_of_yaml_is_a_record_or_an_error(tmp_path: Path, pieces: list[str]) -> None:
    attempt(tmp_path, "".join(pieces).encode())


@FEW
@given(data=st.data())
def test_damaged_files_are_a_record_or_an_error(shared: Path, tmp_path: Path, data: st.DataObject) -> None:
    text = data.draw(st.sampled_from(sources(shared)))
    start = data.draw(st.integers(0, len(text)))
    length = data.draw(st.sampled_from([0, 1, 2, 5, 20, 100]))
    patch = data.draw(st.one_of(st.sampled_from(FRAGMENTS), st.text(max_size=5)))
    attempt(tmp_path, (text[:start] + patch + text[start + length :]).encode("utf-8", "surrogatepass"))


@FEW
@given(data=st.data())
def test_files_with_one_value_replaced_are_a_record_or_an_error(
    shared: Path, tmp_path: Path, data: st.DataObject
) -> None:
    """Replaces whole values, so that the file stays YAML and the damage reaches the readers behind it."""
    lines = data.draw(st.sampled_from(sources(shared))).splitlines()
    valued = [i for i, line in enumerate(lines) if ": " in line and not line.lstrip().startswith("#")]
    index = data.draw(st.sampled_from(valued))
    key = lines[index].split(": ")[0]
    lines[index] = f"{key}: {data.draw(st.sampled_from(FRAGMENTS))}"
    attempt(tmp_path, "\n".join(lines).encode())


ODD = [
    "0",
    "1",
    "-1",
    "1e-300",
    "1e300",
    "-0.0",
    ".nan",
    ".inf",
    "~",
    "x",
    "90 deg",
    "[]",
    "[1]",
    "[1, -1]",
    "{}",
]
RIGID = "mass: 1, com: [0, 0, 0], inertia: [[1, 0, 0], [0, 1, 0], [0, 0, 1]]"


@st.composite
def networks(draw: st.DrawFn) -> tuple[list[str], int]:
    """Lines of a mechanism file, and how many joints it has: loops of every kind, and at most two values spoilt."""
    bodies = [f"b{i}" for i in range(draw(st.integers(1, 4)))]
    ends = [(draw(st.sampled_from(["world", *bodies[:i]])), body) for i, body in enumerate(bodies)]
    ends += draw(st.lists(st.sampled_from([(a, b) for a in ("world", *bodies) for b in bodies]), max_size=3))
    joints = []
    for i, (parent, child) in enumerate(ends):
        point = draw(st.sampled_from(["[0, 0, 0]", "[1, 0, 0]", "[0, 1, 2]"]))
        axis = draw(st.sampled_from(["[0, 0, 1]", "[0, 0, -2]", "[1, 1, 0]"]))
        limits = draw(st.sampled_from(["[-1, 1]", "[-20 deg, 1]", "[0.5, 0.6]", "[-9, 9]"]))
        keys = {
            "name": f"h{i}",
            "parent": parent,
            "child": child,
            "point": point,
            "axis": axis,
            "limits": limits,
        }
        joints.append(keys)
    for joint in draw(st.lists(st.sampled_from(joints), max_size=2)):
        key = draw(st.sampled_from(sorted(joint)))
        others = [each[key] for each in joints]
        joint[key] = draw(st.sampled_from([*others, *ODD]))
    angles = draw(st.sampled_from(["{}", "{h0: 0.1}", "{h0: 9}", "{h0: .nan}", "{h9: 0.1}"]))
    lines = ["kind: mechanism", "bodies:", "  - {name: world, fixed: true}"]
    lines += [f"  - {{name: {name}, {RIGID}}}" for name in bodies]
    lines += ["joints:", *("  - {" + ", ".join(f"{k}: {v}" for k, v in j.items()) + "}" for j in joints)]
    return [*lines, f"scene: {{angles: {angles}}}"], len(joints)


@settings(FEW, max_examples=tries(150))
@given(network=networks())
def test_networks_of_any_shape_are_mechanisms_or_errors_with_their_line(
    tmp_path: Path, network: tuple[list[str], int]
) -> None:
    """Loops, doors, repeated hinges, loose bodies, hinges of a body to itself, limits of all kinds."""
    lines, joints = network
    file, copy = tmp_path / "network.yaml", tmp_path / "copy.yaml"
    file.write_text("\n".join(lines), encoding="utf-8")
    reported = ""
    try:
        mechanism = load(file)
    except LamcError as error:
        reported = str(error)
    assert all(line.startswith(f"{file}:") for line in reported.splitlines())
    event("refused" if reported else "read")
    if reported:
        return
    assert isinstance(mechanism, Mechanism)
    tree = plan(mechanism)  # what a file may hold can be planned
    assert len(tree.links) + len(tree.cuts) == joints
    write_mechanism(mechanism, copy)
    again = load(copy)
    assert isinstance(again, Mechanism)
    assert (again.bodies, again.joints) == (mechanism.bodies, mechanism.joints)


@pytest.mark.slow
def test_truncated_files_are_a_record_or_an_error(shared: Path, tmp_path: Path) -> None:
    for text in sources(shared):
        for part in range(23):
            attempt(tmp_path, text[: len(text) * part // 23].encode())


@pytest.mark.parametrize(
    "text",
    [
        "[" * 50_000,
        "{" * 50_000,
        "- " * 50_000,
        "? " * 20_000,
        "a: &a " * 5_000,
        "!!python/tuple " * 5_000,
        "'" + "x" * 100_000,
        "- &x [1]\n" + "- *x\n" * 20_000,
        "&a [" + "1," * 90 + "]\n",
        "layers: &a [&b [&c [1, 1], *c, *c], *b, *b]\n",
        "%" + "x" * 10_000,
        "#" * 100_000,
        "|" + "\n" * 100_000,
        "units: " + "m" * 100_000 + "\nlayers: []\nshapes: []\nmaterials: {}\n",
    ],
)
def test_files_made_to_exhaust_are_refused_soon(tmp_path: Path, text: str) -> None:
    attempt(tmp_path, text.encode())
