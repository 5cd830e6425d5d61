"""The C: the same bytes every time, compiles by itself without a warning, means what the program means, hostile names
stay strings, and what a scene leaves out leaves no trace."""

import math
import random
import re
import shutil
import subprocess
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path
from typing import ClassVar

import numpy as np
import pytest

import lamc
from lamc.basics.errors import DesignError, EmitError
from lamc.codegen.build import write_sources
from lamc.codegen.emit import SourceTree, emit
from lamc.codegen.layout import MAX_BLOCK_AT_EVERY_STEP
from lamc.codegen.names import comment, identifier, identifiers, string_literal
from lamc.codegen.printer import ShapePrinter, literal
from lamc.effects import Gravity, HingeDamping, HingeStiffness, RestAngle, Torque
from lamc.effects import registry as effect_registry
from lamc.mechanics.loads import Loads
from lamc.mechanics.lower import lower
from lamc.pipeline import effects_of, equations_of, sources_of
from lamc.records.mechanism import Mechanism
from lamc.records.scene import Scene
from lamc.reference.interpreter import Interpreter
from lamc.symbolic.functions import FUNCTIONS
from lamc.symbolic.operations import SCALAR
from lamc.symbolic.program import Operand, Program, Shape, Space
from tests.support.ctools import STRICT, STRICT_CXX, cc, needs_cc, objects_of, output_of
from tests.support.mechanisms import ALL_PASSIVE, chain, random_state, random_tree, unit_plate_pendulum
from tests.support.paths import ROOT

EFFECTS = (*ALL_PASSIVE, Torque({"h0": "0.3*sin(2*pi*t) - 0.2*rate*abs(rate) + min(angle, 0.1)^2"}))
WITH_LOOPS = {"laminate40": chain(40, "laminate", seed=40), "parallel100": chain(100, "parallel", seed=1)}
MECHANISMS = {"small": chain(2, "space", seed=6), "tree": random_tree(14, seed=3, kind="mixed"), **WITH_LOOPS}


def made(mechanism: Mechanism) -> tuple[Program, SourceTree]:
    return sources_of(equations_of(mechanism, EFFECTS))


@cache
def tree_of(name: str) -> tuple[Program, SourceTree]:
    return made(MECHANISMS[name])


# ---- the same bytes -------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", ["small", "laminate40"])
@pytest.mark.quick("small")
def test_repeating_gives_the_same_bytes(name: str) -> None:
    (program, tree), (again, same) = made(MECHANISMS[name]), made(MECHANISMS[name])
    assert program.digest == again.digest
    assert dict(tree.files) == dict(same.files)


def test_order_of_the_input_leaves_the_c_alone() -> None:
    mechanism = MECHANISMS["tree"]
    rotated = replace(mechanism, bodies=mechanism.bodies[::-1], joints=mechanism.joints[::-1])
    assert dict(made(rotated)[1].files) == dict(made(mechanism)[1].files)


def test_no_date_and_no_path_gets_into_the_c() -> None:
    text = "".join(tree_of("small")[1].files.values())
    assert str(ROOT) not in text
    assert not re.search(r"\b(19|20)\d\d-\d\d-\d\d\b", text)


# ---- numbers and names ----------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "value",
    [0.1, 1 / 3, math.pi, 5e-324, 1.7976931348623157e308, -2.5e-17, 1e22, 123456789.123456789, 0.0, -0.0],
)
def test_printed_numbers_read_back_exactly(value: float) -> None:
    text = literal(value).strip("()")
    assert float(text) == value
    assert re.fullmatch(r"-?\d+(\.\d+)?(e[+-]?\d+)?", text)
    assert "." in text or "e" in text, "C would read an integer"


@needs_cc
def test_random_numbers_survive_the_c_compiler(tmp_path: Path) -> None:
    rng = random.Random(5)
    values = [math.ldexp(rng.uniform(-1, 1), rng.randint(-1000, 1000)) for _ in range(300)]
    lines = ",\n".join(literal(v) for v in values)
    (tmp_path / "n.c").write_text(
        f"#include <stdio.h>\nstatic const double n[] = {{{lines}}};\n"
        'int main(void) { for (int i = 0; i < 300; ++i) printf("%a\\n", n[i]); return 0; }\n'
    )
    cc(tmp_path, *STRICT, "n.c", "-o", "n")
    assert [float.fromhex(line) for line in output_of(tmp_path / "n").split()] == values


HOSTILE = (
    '"; int main',
    "../../x",
    '*/ #include "/etc/passwd"',
    "/* never ended",
    "%s%n%d",
    "ends in a backslash\\",
    "what??/",
    "??=define x ??<",
    "🦊🪤",
    "double",
    "class",
    "h 1",
    "h-1",
    "H_1",
    "$(reboot)",
    "`id`",
    "a" * 200,
    "Δφ₁",
    "'",
    "\\u0022",
    "{{ 7*7 }}{% raw %}",
    "0",
    "__FILE__",
    "NULL",
    "n",
)


def hostile() -> Mechanism:
    base = chain(len(HOSTILE), "parallel", seed=2)
    bodies = [base.bodies[0]]
    joints = []
    parent = "ground"
    for name, body, joint in zip(HOSTILE, base.bodies[1:], base.joints, strict=True):
        bodies.append(replace(body, name=name))
        joints.append(replace(joint, name=name, parent=parent, child=name))
        parent = name
    return Mechanism(tuple(bodies), tuple(joints), name=HOSTILE[2])


@pytest.mark.slow
@needs_cc
def test_hostile_names_compile_and_come_back_unchanged(tmp_path: Path) -> None:
    mechanism = hostile()
    sim = lamc.compile(
        mechanism, Scene(effects=(HingeStiffness(), HingeDamping(), Torque(dict.fromkeys(HOSTILE, 0.1))))
    )
    assert set(sim.joints) == set(sim.bodies) - {"ground"} == set(HOSTILE)
    assert [p for p in sim.parameters if p.endswith(".torque")]
    for joint in mechanism.joints:
        assert sim.parameters[f"{joint.name}.stiffness"] == joint.stiffness
        assert sim.parameters[f"{joint.name}.torque"] == 0.1
    plain = chain(len(HOSTILE), "parallel", seed=2)
    effects = (HingeStiffness(), HingeDamping(), Torque({j.name: 0.1 for j in plain.joints}))
    q, u = random_state(len(HOSTILE), 1)
    expected = lamc.compile(plain, Scene(effects=effects)).acceleration(q, u)
    assert (sim.acceleration(q, u) == expected).all()
    tree = emit(sim.program)
    write_sources(tree, tmp_path)
    units = ("main.c", *(unit for unit in tree.compiled if unit not in tree.shared))
    cc(tmp_path, *STRICT, "-trigraphs", "-Wno-trigraphs", "-c", *units)


SYSTEM_HEADERS = ("float", "limits", "math", "stddef", "stdint", "stdio", "stdlib", "string", "tgmath")


def test_names_of_designs_never_reach_paths_or_code() -> None:
    _, tree = sources_of(equations_of(hostile(), EFFECTS[:3]))
    for file, text in tree.files.items():
        assert re.fullmatch(r"[a-z][a-z0-9_]*\.[ch]", file)
        code = re.sub(r"/\*.*?\*/|\"(\\.|[^\"\\])*\"", "", text, flags=re.DOTALL)
        assert "/etc/passwd" not in code
        assert "$" not in code
        assert set(re.findall(r"#include +([<\"]?\S+)", code)) <= {f"<{h}.h>" for h in SYSTEM_HEADERS}
        assert text.isascii()


@needs_cc
@pytest.mark.parametrize(
    "name",
    [
        "rk45",
        "main",
        "lamc_math",
        "lamc",
        "motion",
        "status",
        "implicit",
        "this_model",
        "double",
        "1",
        "π",
    ],
)
@pytest.mark.quick("status", "double", "*03c0", others="campaign")
def test_designs_named_like_files_and_words_of_c_compile_alone_and_as_a_library(
    name: str, tmp_path: Path
) -> None:
    mechanism = replace(chain(1), name=name)
    sim = lamc.compile(mechanism, Scene(effects=(Gravity(),)))
    assert sim.run(t_end=0.01).provenance.design == name
    tree = emit(sim.program)
    assert len(tree.files) == len({f.lower() for f in tree.files})
    write_sources(tree, tmp_path)
    cc(tmp_path, *STRICT, "main.c", *objects_of(tree, tmp_path, *STRICT), "-lm", "-o", "run")
    assert output_of(tmp_path / "run").startswith("t_s,q0_rad")


def test_names_that_are_too_long_or_do_not_print_are_refused() -> None:
    for name in ("a" * 201, "🦊" * 2600, "two\nlines", "bell\a", "", " "):
        with pytest.raises(DesignError):
            replace(chain(1), name=name)
        with pytest.raises(DesignError):
            replace(chain(1).joints[0], name=name)


def test_identifiers_differ_and_are_c() -> None:
    names = [*HOSTILE, "h_1", "H 1", "h.1", "h_1_2", "h_1_2"]
    made_of = identifiers(names)
    assert len(set(made_of)) == len(names)
    assert all(re.fullmatch(r"[a-z][a-z0-9_]*", i) for i in made_of)
    assert identifier("int") != "int"
    assert identifier("rk45", taken=["rk45"]) != "rk45"


def test_strings_and_comments_cannot_be_left() -> None:
    for name in HOSTILE:
        text = string_literal(name)
        assert re.fullmatch(r'"([ !#->@-\[\]-~]|\\[0-7]{3})*"', text)
        octal = re.sub(r"\\([0-7]{3})", lambda m: chr(int(m[1], 8)), text[1:-1])
        assert octal.encode("latin-1").decode() == name
        for hidden in (name, name + "/", "*" + name, name + "*", "**//" + name, "/" + name):
            assert "*/" not in comment(hidden)
            assert "/*" not in comment(hidden)
            assert comment(hidden).isascii()


# ---- compiles by itself ---------------------------------------------------------------------------------------

_DRIVER = """
#include "{prefix}.h"
#include <stdio.h>
#include <stdlib.h>
int main(void) {{
  const lamc_model *m = {prefix}_model();
  static double c[{prefix}_constant_count], q[{n}], u[{n}], out[12 * {n} + 16];
  {prefix}_parameters p;
  {prefix}_default_parameters(&p);
  {prefix}_setup(&p, c);
  double t;
  if (scanf("%lf", &t) != 1) return 1;
  for (int i = 0; i < {n}; ++i) if (scanf("%lf", &q[i]) != 1) return 1;
  for (int i = 0; i < {n}; ++i) if (scanf("%lf", &u[i]) != 1) return 1;
  {prefix}_acceleration(c, t, q, u, out);
  for (int i = 0; i < m->joint_count; ++i) printf("%a\\n", out[i]);
  {prefix}_energy(c, t, q, u, out);
  for (int i = 0; i < m->energy_count; ++i) printf("%a\\n", out[i]);
  {prefix}_poses(c, 0.0, q, out);
  for (int i = 0; i < 12 * m->body_count; ++i) printf("%a\\n", out[i]);
  return 0;
}}
"""


@needs_cc
@pytest.mark.parametrize("name", sorted(MECHANISMS))
@pytest.mark.quick("small", others="campaign")
def test_c_compiles_by_itself_without_a_warning_and_equals_the_library(name: str, tmp_path: Path) -> None:
    program, tree = tree_of(name)
    assert (name in WITH_LOOPS) == (
        len(program.functions["acceleration"].statements) > MAX_BLOCK_AT_EVERY_STEP
    )
    assert (name in WITH_LOOPS) == ("acceleration_kernel_0(" in tree.files[f"{tree.prefix}.c"])
    write_sources(tree, tmp_path)
    strict = (*STRICT, "-O1", "-ffp-contract=off")
    objects = objects_of(tree, tmp_path, *strict)
    cc(tmp_path, *strict, "main.c", *objects, "-lm", "-o", "example")
    rows = output_of(tmp_path / "example").splitlines()
    assert len(rows) == 102  # a header, then 0 … 1 s
    n = len(program.joints)
    sim = lamc.compile(MECHANISMS[name], Scene(effects=EFFECTS))
    result = sim.run(t_end=1.0, rtol=1e-6, atol=1e-9, t_eval=[1.0])
    final = [float(x) for x in rows[-1].split(",")[1:]]
    assert final == pytest.approx(result.q[0], abs=1e-9)  # same step control, other optimisation
    (tmp_path / "driver.c").write_text(_DRIVER.format(prefix=tree.prefix, n=n))
    cc(tmp_path, *strict, "driver.c", *objects, "-lm", "-o", "driver")
    q, u = random_state(n, 3)
    given = " ".join(map(repr, [0.3, *q.tolist(), *u.tolist()]))
    done = subprocess.run([tmp_path / "driver"], input=given, capture_output=True, text=True, check=True)
    found = np.array([float.fromhex(line) for line in done.stdout.split()])
    energies = len(program.energies)
    assert (found[:n] == sim.acceleration(q, u, 0.3)).all()  # -ffp-contract=off: the same bits at -O1 and -O2
    assert found[n : n + energies].sum() == pytest.approx(sim.energy(q, u, 0.3), rel=1e-14)
    interpreter = Interpreter(program)
    com, rotation = interpreter.poses(q, interpreter.constants())
    poses = found[n + energies :].reshape(n, 12)
    # rotations one after the other, up to a hundred; positions of up to 100 m
    assert np.abs(poses[:, :3] - com).max() < 1e-11
    assert np.abs(poses[:, 3:].reshape(n, 3, 3) - rotation).max() < 1e-12


@pytest.mark.skipif(shutil.which("g++") is None, reason="needs g++")
@pytest.mark.parametrize("name", ["small", "laminate40"])
@pytest.mark.slow  # in each run: test_it_is_valid_cxx_too, of exports
def test_c_is_cxx_as_well(name: str, tmp_path: Path) -> None:
    tree = tree_of(name)[1]
    write_sources(tree, tmp_path)
    flags = ("-x", "c++", *STRICT_CXX)
    objects = objects_of(tree, tmp_path, *flags, compiler="g++")
    cc(tmp_path, *flags, "-c", "main.c", compiler="g++")
    cc(tmp_path, "main.o", *objects, "-lm", "-o", "run", compiler="g++")
    assert len(output_of(tmp_path / "run").splitlines()) == 102


@needs_cc
def test_headers_stand_alone(tmp_path: Path) -> None:
    tree = tree_of("small")[1]
    write_sources(tree, tmp_path)
    for header in sorted(p.name for p in tmp_path.glob("*.h")):
        (tmp_path / "alone.c").write_text(f'#include "{header}"\n#include "{header}"\nextern int x;\n')
        cc(tmp_path, *STRICT, "-Wno-unused-function", "-fsyntax-only", "alone.c")


# ---- the printer ----------------------------------------------------------------------------------------------

_ARITHMETIC = {"+": 2, "-": 2, "*": 2, "neg": 1, "reciprocal": 1}
_ARITY = {**_ARITHMETIC, **{name: f.arity for name, f in FUNCTIONS.items()}}


def random_shape(rng: random.Random, depth: int, count: list[int]) -> Shape:
    """Any operation at the top, arithmetic within, as the store makes them; operands numbered from the left."""
    if depth == 0 or (depth < 3 and rng.random() < 0.3):
        count[0] += 1
        return count[0] - 1
    operations = sorted(_ARITY) if depth == 3 else ["+", "-", "*", "neg"]
    operation = rng.choice(operations)
    return (operation, *(random_shape(rng, depth - 1, count) for _ in range(_ARITY[operation])))


def all_shapes() -> list[tuple[Shape, int]]:
    shapes: list[tuple[Shape, int]] = []
    inner = [("+", 0, 1), ("-", 0, 1), ("*", 0, 1), ("neg", 0), ("neg", ("-", 0, 1)), ("-", 0, ("neg", 1))]
    for operation, arity in sorted(_ARITY.items()):
        shapes.append(((operation, *range(arity)), arity))
        for nested in inner:
            if arity == 1:
                shapes.append(((operation, nested), 2))
            else:
                shapes.append(((operation, nested, 2), 3))
                shapes.append(((operation, 2, nested), 3))
    rng = random.Random(11)
    for _ in range(400):
        count = [0]
        shape = random_shape(rng, 3, count)
        shapes.append((shape, count[0]))
    return shapes


def meaning(shape: Shape, values: list[float]) -> float:
    if isinstance(shape, int):
        return values[shape]
    name, *arguments = shape
    assert isinstance(name, str)
    return SCALAR[name](*(meaning(a, values) for a in arguments if not isinstance(a, str)))


def condition(shape: Shape, values: list[float]) -> float:
    """Size of what is added up inside, in which round-off is measured."""
    if isinstance(shape, int):
        return abs(values[shape])
    name, *arguments = shape
    sizes = [condition(a, values) for a in arguments if not isinstance(a, str)]
    return (
        sum(sizes) if name in ("+", "-", "neg") else math.prod(sizes) if name == "*" else max(1.0, sum(sizes))
    )


@needs_cc
def test_every_shape_prints_as_what_it_means(tmp_path: Path) -> None:
    printer = ShapePrinter()
    rng = random.Random(3)
    lines, expected = [], []
    for shape, count in all_shapes():
        values = [rng.uniform(0.15, 0.45) for _ in range(count)]
        operands = tuple(Operand(Space.LOCAL, k) for k in range(count))
        text = printer.text(shape, operands, lambda o, values=values: literal(values[o.index]))
        lines.append(f"  show({text});")
        expected.append((shape, values, text))
    (tmp_path / "shapes.c").write_text(
        "#include <math.h>\n#include <stdio.h>\n"
        'static void show(double x) { printf("%a\\n", x); }\n'
        "int main(void) {\n" + "\n".join(lines) + "\n  return 0;\n}\n"
    )
    cc(tmp_path, *STRICT, "-O0", "shapes.c", "-lm", "-o", "shapes")
    found = [float.fromhex(line) for line in output_of(tmp_path / "shapes").split()]
    for value, (shape, values, text) in zip(found, expected, strict=True):
        wanted = meaning(shape, values)
        if math.isnan(wanted):
            assert math.isnan(value), (shape, text)
            continue
        # C may take the terms of one sum or product in another order: a few roundings, amplified by steep functions
        # (log, reciprocal, pow) near their poles at most a thousandfold
        slack = 1e-15 if isinstance(shape, tuple) and shape[0] in ("+", "-", "*", "neg") else 1e-12
        assert abs(value - wanted) <= slack * max(abs(wanted), condition(shape, values)), (shape, text)


def test_small_powers_are_products_and_unknown_operations_are_refused() -> None:
    printer = ShapePrinter()
    operands = (Operand(Space.LOCAL, 0), Operand(Space.LOCAL, 1))
    assert "pow" not in printer.text(("*", 0, 1), operands, lambda o: "x")
    for shape in (("system", 0), ("gamma", 0), ("Piecewise", 0, 1)):
        with pytest.raises(EmitError, match="no C form"):
            printer.text(shape, operands, lambda o: "x")


# ---- effects leave traces only where they act -----------------------------------------------------------------

OPTIONAL = {
    HingeStiffness: ("hinge_stiffness", "stiffness", "eq. 15"),
    RestAngle: ("rest_angle", "rest"),
    HingeDamping: ("hinge_damping", "damping", "eq. 16"),
    Gravity: ("gravity",),
    Torque: ("torque", "applied"),
}
FULL = (Gravity(), HingeStiffness(), HingeDamping(), RestAngle(), Torque({"h0": 0.2, "h1": 0.1}))


def model_text(mechanism: Mechanism, effects: tuple) -> str:
    tree = sources_of(equations_of(mechanism, effects))[1]
    return (tree.files[f"{tree.prefix}.c"] + tree.files[f"{tree.prefix}.h"]).lower()


@needs_cc
@pytest.mark.parametrize("left_out", OPTIONAL, ids=lambda kind: kind.name)
@pytest.mark.quick("gravity", "hinge_stiffness", "torque")
def test_an_effect_left_out_leaves_no_trace_and_equals_zero_parameters(left_out: type) -> None:
    mechanism = chain(3, "space", seed=7)
    rest = tuple(e for e in FULL if type(e) is not left_out)
    if left_out is HingeStiffness:
        rest = tuple(e for e in rest if not isinstance(e, RestAngle))  # which is a part of the spring
    text = model_text(mechanism, rest)
    for word in OPTIONAL[left_out]:
        assert word not in text.replace("hinge torques", "").replace("applied loads", ""), word
    full_text = model_text(mechanism, FULL)
    assert all(word in full_text for word in OPTIONAL[left_out][1:2])
    with_it, without = (lamc.compile(mechanism, Scene(effects=e)) for e in (FULL, rest))
    gone = set(with_it.parameters) - set(without.parameters)
    assert gone
    assert set(without.parameters) < set(with_it.parameters)
    assert without.program.functions["acceleration"].operations.flops < (
        with_it.program.functions["acceleration"].operations.flops
    )
    for seed in range(3):
        q, u = random_state(3, seed)
        zeroed = with_it.acceleration(q, u, 0.0, dict.fromkeys(gone, 0.0))
        found = without.acceleration(q, u)
        assert np.abs(zeroed - found).max() <= 1e-13 * np.abs(found).max()  # round-off of zeros added


@dataclass(frozen=True)
class Dummy:
    """An effect that would shout if anything called for it."""

    name: ClassVar[str] = "dummy"
    summary: ClassVar[str] = "DUMMY"

    def contribute(self, loads: Loads) -> None:
        raise AssertionError("nothing asked for this effect")

    @classmethod
    def default_for(cls, mechanism: Mechanism) -> tuple[None, str]:
        return None, "nobody wants it"


@pytest.mark.parametrize("effects", [None, FULL, ()], ids=["default", "full", "none"])
def test_adding_an_effect_to_lamc_changes_no_byte_of_scenes_without_it(
    effects: tuple | None, monkeypatch: pytest.MonkeyPatch
) -> None:
    mechanism, scene = chain(3, "laminate", seed=7), Scene(effects=effects)

    def files() -> dict[str, str]:
        return dict(sources_of(equations_of(mechanism, effects_of(mechanism, scene)))[1].files)

    before = files()
    for order in ((*effect_registry.EFFECTS, Dummy), (Dummy, *effect_registry.EFFECTS)):
        monkeypatch.setattr(effect_registry, "EFFECTS", order)
        assert any(choice.name == "dummy" for choice in effect_registry.choose(mechanism, scene))
        assert files() == before
    assert "dummy" not in "".join(before.values()).lower()


def test_order_in_which_a_scene_lists_effects_does_not_matter() -> None:
    mechanism = chain(3)
    texts = [
        sources_of(equations_of(mechanism, effects_of(mechanism, Scene(effects=order))))[1].files
        for order in (FULL, FULL[::-1], (FULL[2], *FULL[:2], *FULL[3:]))
    ]
    assert dict(texts[0]) == dict(texts[1]) == dict(texts[2])


def test_parameters_and_sizes_are_documented_in_the_header() -> None:
    mechanism, scene = unit_plate_pendulum()
    assert scene.effects is not None
    program = lower(equations_of(mechanism, scene.effects))
    tree = emit(program)
    header = tree.files[f"{tree.prefix}.h"]
    for parameter in program.parameters:
        assert f"/* {comment(parameter.name)}: " in header
        assert comment(parameter.unit) in header
    assert f"{tree.prefix}_joint_count = 3," in header
    assert program.structure in header
