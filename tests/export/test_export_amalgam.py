"""C text as tokens and declarations, and several files made one."""

import subprocess
from pathlib import Path

import pytest

from lamc import Body, ExportError, Joint, Mechanism
from lamc.basics.resources import data_dir
from lamc.export import files_of
from lamc.export.amalgam.files import amalgamate
from lamc.export.amalgam.tokens import items, tokens
from lamc.export.options import ExportOptions, options_from
from lamc.export.run_fields import run_fields
from tests.support.ctools import needs_cc
from tests.support.exported import C99, CXX17, Exported, c_files

RUNTIME = sorted(data_dir("runtime_c").rglob("*.[ch]"))

FIRST = """/* first.c: about it */
#include "both.h"
static const int COUNT = 3; /* of something */
static int helper(int x) { return x + COUNT; }
static int unused(int x) { return x - COUNT; }
int lamc_first(const lamc_pair *p) {
  const char *s = "helper /* no comment */";
  return helper(p->helper) + (s[0] == '"');
}
"""
SECOND = """#include "both.h"
static int helper(int COUNT) { return 2 * COUNT; }
int entry(void) { const lamc_pair p = {helper(1), LAMC_SEVEN, {0}}; return lamc_first(&p) + lamc_inline(p.other); }
"""
BOTH = """#ifndef LAMC_BOTH_H
#define LAMC_BOTH_H
#ifdef __cplusplus
extern "C" {
#endif
enum { LAMC_SEVEN = 7, LAMC_EIGHT };
typedef struct lamc_pair { int helper; /* a member */ int other, more[LAMC_EIGHT]; } lamc_pair;
int lamc_first(const lamc_pair *p);
int lamc_nobody(void);
#define LAMC_ADD(x) ((x) + 1)
static inline int lamc_inline(int helper) { return LAMC_ADD(helper); }
#ifdef __cplusplus
}
#endif
#endif
"""


@pytest.mark.parametrize("path", RUNTIME, ids=lambda path: f"{path.parent.name}/{path.name}")
def test_tokens_give_the_text_back(path: Path) -> None:
    text = path.read_text(encoding="utf-8")
    assert "".join(token.text for token in tokens(text)) == text


def test_declarations_and_what_they_declare() -> None:
    text = """typedef enum colour { RED = 1, GREEN } colour;
struct point { double x; };
extern const int far_away;
static const double A = 1.0 / 2.0, B[2] = {A, 3.0}; /* halves */
double f(double (*g)(int), int n);
static double f(double (*g)(int), int n) { return g(n) + (n > 1 ? A : B[1]); }
"""
    found = [(item.kind, item.declares) for item in items("x", tokens(text))]
    assert found == [
        ("type", ("colour", "RED", "GREEN")),
        ("type", ("point",)),
        ("extern", ("far_away",)),
        ("object", ("A", "B")),
        ("prototype", ("f",)),
        ("function", ("f",)),
    ]


@needs_cc
def test_files_made_one_keep_their_meaning(tmp_path: Path) -> None:
    """Equal names of two files, a member of the same name, a string and a comment with it; C and C++."""
    files = {"first.c": FIRST, "second.c": SECOND, "both.h": BOTH}
    made = amalgamate(files, ["first.c", "second.c"], ["entry"], "m")
    assert "unused" not in made.text
    assert "nobody" not in made.text
    assert '"helper /* no comment */"' in made.text
    program = made.text + "#include <stdio.h>\nint main(void) { return entry() == 2 + 3 + 8 ? 0 : 1; }\n"
    (tmp_path / "one.c").write_text(program.replace("int entry", "int entry(void);\nint entry", 1))
    for flags in (C99, CXX17):
        subprocess.run(["cc", *flags, "one.c", "-o", "one"], cwd=tmp_path, check=True)
        assert subprocess.run([str(tmp_path / "one")], check=False).returncode == 0


def test_a_run_is_plain_numbers() -> None:
    fields = run_fields((data_dir("runtime_c") / "include" / "lamc.h").read_text(encoding="utf-8"))
    assert {"t", "h", "watch.pace", "event_gap"} <= set(fields.reals)
    assert {"steps", "side", "watch.backoff"} <= set(fields.integers)
    assert "steps" in fields.wide
    assert "side" not in fields.wide
    assert not {"work", "guards", "integrals", "ode", "t_eval"} & {*fields.reals, *fields.integers}


HOSTILE = (
    '"; system("x"); //', "*/ int x;", "lamc_run", "double", "pend_step", "digest_", "none", "t", "%s%n", "τ₁",
    "h 1", "h_1",
)  # fmt: skip


def hostile() -> Mechanism:
    """A chain whose names are C, comments, printf formats, no ASCII, or alike once they are C names."""
    wall = Body("wall", fixed=True)
    bodies = [wall, *(Body(f"{name} body", 0.1, (k + 0.5, 0.0, 0.0)) for k, name in enumerate(HOSTILE))]
    joints = [
        Joint(name, bodies[k].name, bodies[k + 1].name, (float(k), 0.0, 0.0), (0.0, 1.0, 0.0), stiffness=0.1)
        for k, name in enumerate(HOSTILE)
    ]
    return Mechanism(tuple(bodies), tuple(joints), name="/* %d */ int")


@needs_cc
def test_names_from_a_design_stay_names(tmp_path: Path) -> None:
    exported = Exported(
        c_files(hostile(), options=ExportOptions(integrator="rk45", jacobian=False)), tmp_path
    )
    names = [
        exported.ffi.string(exported.call("joint_name", i)).decode()
        for i in range(exported.constant("joint_count"))
    ]
    assert sorted(names) == sorted(HOSTILE)
    assert exported.call("step", exported.instance(), 0.01) == 0


@needs_cc
@pytest.mark.slow
def test_c_and_cxx_give_the_same_bits(tmp_path: Path) -> None:
    files = c_files(hostile(), options=ExportOptions(prefix="chain"))
    states = []
    for flags in (C99, CXX17):
        exported = Exported(files, tmp_path / flags[0], flags)
        it = exported.instance()
        assert exported.call("step", it, 0.1) == 0
        states.append(exported.state(it))
    assert states[0] == states[1]


@pytest.mark.parametrize(
    ("values", "reported"),
    [
        ({"prefix": "double"}, "C, C"),
        ({"prefix": "_x"}, "letter first"),
        ({"prefix": "a__b"}, "single _"),
        ({"prefix": "a" * 41}, "40 characters"),
        ({"prefix": 3}, "it must be a C name"),
        ({"integrator": "euler"}, "'rk45'"),
        ({"precision": "half"}, "'double'"),
        ({"real_time": 1}, "True or False"),
        ({"inputs": ["h1"]}, "tuple of names"),
        ({"speed": 1}, "no option 'speed'"),
    ],
)
def test_options_that_cannot_be(values: dict[str, object], reported: str) -> None:
    with pytest.raises(ExportError, match=reported):
        options_from(**values)


def test_an_unknown_target_names_those_there_are() -> None:
    with pytest.raises(ExportError, match="'fortran'; there are c, "):
        files_of(hostile(), "fortran")
