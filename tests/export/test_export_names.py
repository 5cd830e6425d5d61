"""Exports of designs whose names are no names: they build without a warning, and say what the names were."""

import csv
import io
import re
from pathlib import Path

import numpy as np
import pytest

import lamc
from lamc.export import files_of
from lamc.export.markdown import markdown
from tests.support.ctools import needs_cc
from tests.support.exported_folders import STRICT, cc, does, put

pytestmark = needs_cc

HOSTILE = 'a"; system("x") /* */ // \\ ??/ %s %n ${x} @x@ `x` <b>|</b> #define, y'
STEP = "int main(void) { static @_t it; return @_init(&it, 0, 0) || @_step(&it, 0.01); }\n"
# A program that uses whatever C has; -I. puts the export's header before the system's.
HEADERS = """
    assert complex ctype errno fenv inttypes locale math setjmp signal stddef stdint stdio stdlib string time wchar
    pthread sys/types unistd
"""
ALL_HEADERS = "".join(f"#include <{name}.h>\n" for name in HEADERS.split())


def double_pendulum(name: str = "pend", joints: tuple[str, str] = ("h1", "h2")) -> lamc.Mechanism:
    inertia = np.diag([1e-7, 2e-6, 2e-6])
    links = [
        lamc.Body(f"link {joint}", mass=0.01, com=(0.02 + 0.04 * k, 0, 0), inertia=inertia)
        for k, joint in enumerate(joints)
    ]
    ground = lamc.Body(f"ground of {name}", fixed=True)
    hinges = [
        lamc.Joint(joints[0], ground.name, links[0].name, point=(0, 0, 0), axis=(0, 1, 0), stiffness=1e-3),
        lamc.Joint(joints[1], links[0].name, links[1].name, point=(0.04, 0, 0), axis=(0, 1, 0)),
    ]
    return lamc.Mechanism((ground, *links), tuple(hinges), name=name, scene=lamc.Scene(duration=0.1))


def built(mechanism: lamc.Mechanism, folder: Path, **options: object) -> tuple[str, str]:
    """The prefix, and what the example prints. Builds with all of C's headers around it."""
    files = files_of(mechanism, "c", options=lamc.ExportOptions(**options))  # type: ignore[arg-type]
    (prefix,) = (name.removesuffix("_params.h") for name in files if name.endswith("_params.h"))
    put(files, folder)
    (folder / "all.c").write_text(ALL_HEADERS + f'#include "{prefix}.h"\n' + STEP.replace("@", prefix))
    cc(folder, "-std=c99", *STRICT, "-c", f"{prefix}.c", "-o", "model.o")
    cc(folder, "-std=gnu99", "-I.", *STRICT, "all.c", "model.o", "-lm", "-o", "all")
    does([folder / "all"], folder)
    cc(folder, "-std=c99", *STRICT, "example_main.c", "model.o", "-lm", "-o", "example")
    return prefix, does([folder / "example"], folder)


NAMES = (
    *(HOSTILE, "math", "size", "int", "time", "main", "m", "test", "pthread", "lamc", "example_main"),
    *("3d", "_", "Ä🦋", "x" * 120),
)


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.quick('a"; system*', "math", others="campaign")
def test_any_design_name_gives_a_prefix_that_meets_nothing(name: str, tmp_path: Path) -> None:
    prefix, table = built(double_pendulum(name), tmp_path)
    assert re.fullmatch(r"[a-z][a-z0-9_]{0,43}", prefix)
    assert len(table.splitlines()) == 2002  # a title, and 2001 rows of a short run


@pytest.mark.parametrize(
    ("joints", "fields"),
    [
        (("a-b", "a b"), {"a_b_stiffness", "a_b_2_com_y"}),
        (("double", "class"), {"double_stiffness", "class_com_y"}),
        ((HOSTILE, HOSTILE + "2"), set()),
    ],
)
@pytest.mark.slow
def test_names_that_are_no_names_or_equal_ones_stay_apart(
    joints: tuple[str, str], fields: set[str], tmp_path: Path
) -> None:
    mechanism = double_pendulum(joints=joints)
    prefix, table = built(mechanism, tmp_path)
    titles = next(csv.reader(io.StringIO(table)))
    assert titles[1:3] == [f"{joint} angle (rad)" for joint in joints]
    header = (tmp_path / f"{prefix}.h").read_text(encoding="utf-8")
    members = re.findall(r"^  double (\w+); /\*", header, re.MULTILINE)
    assert len(members) == len(set(members))
    assert header.isascii()
    (tmp_path / "names.c").write_text(
        f'#include "{prefix}.h"\n#include <stdio.h>\n'
        f"int main(void) {{ fputs({prefix}_joint_name(0), stdout); return {prefix}_joint_name(2) != NULL; }}\n"
    )
    cc(tmp_path, "-std=c99", *STRICT, "names.c", "model.o", "-lm", "-o", "names")
    assert does([tmp_path / "names"], tmp_path) == joints[0]


def test_hostile_names_stay_text_in_the_readme(tmp_path: Path) -> None:
    mechanism = double_pendulum(HOSTILE, (HOSTILE, "h2"))
    readme = files_of(mechanism, "c")["README.md"].decode()
    assert "<b>" not in re.sub(r"\\.", "", readme)
    bars = [len(re.findall(r"(?<!\\)\|", line)) for line in readme.splitlines() if line.startswith("| `q[")]
    assert set(bars) == {6}  # five cells
    assert markdown("*a_b_*") == "\\*a_b\\_\\*"
    assert markdown("a\n\u202e|") == "a  \\|"


@pytest.mark.parametrize(
    "prefix",
    [
        *("", "3d", "a b", "_a", "a__b", "a_", "ä", "int", "math", "size", "Time", "main", "a" * 41, "a\n"),
        3,
    ],
)
def test_prefixes_that_cannot_be_are_refused_by_name(prefix: object) -> None:
    with pytest.raises(lamc.ExportError, match=r"--prefix \(prefix\) is"):
        lamc.ExportOptions(prefix=prefix)  # type: ignore[arg-type]


def test_a_prefix_of_ones_own_is_taken_as_it_is(tmp_path: Path) -> None:
    assert built(double_pendulum(), tmp_path, prefix="LeftArm")[0] == "LeftArm"
