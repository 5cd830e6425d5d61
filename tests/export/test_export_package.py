"""An exported folder alone, anywhere: it builds with what a C engineer has, and prints what Python computes."""

import csv
import io
import re
import shutil
import struct
import subprocess
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import lamc
from lamc.run.defaults import default_rows
from tests.support.ctools import needs_cc
from tests.support.exported_folders import (
    DURATION,
    KINDS,
    STRICT,
    cc,
    compilers,
    does,
    exported,
    mechanism_of,
    needs,
    put,
    scene_of,
)

pytestmark = needs_cc


def table_of_python(name: str, folder: Path) -> str:
    """What `lamc run` writes, without the pictures and without positions that only the scene's outputs ask for."""
    t_end = DURATION[name]
    mechanism, scene = mechanism_of(name), scene_of(name)
    scene = replace(scene or mechanism.scene or lamc.Scene(), outputs=None)
    simulator = lamc.compile(mechanism, scene)
    rows = default_rows(t_end, len(simulator.start))
    result = simulator.run(t_end, t_eval=np.linspace(0.0, t_end, rows))
    assert result.success
    result.to_csv(folder / "python.csv")
    return (folder / "python.csv").read_text(encoding="utf-8")


def rows_of(text: str) -> tuple[list[str], bytes]:
    """Titles, and all numbers as the bytes of doubles."""
    titles, *rows = csv.reader(io.StringIO(text))
    numbers = [float(cell) for row in rows for cell in row]
    assert len(numbers) == len(titles) * len(rows) > 0
    return titles, struct.pack(f"{len(numbers)}d", *numbers)


@pytest.mark.parametrize("name", [*KINDS, pytest.param("stiff_triple", marks=pytest.mark.slow)])
@pytest.mark.quick("pendulum", "four_bar", others="campaign")
def test_the_example_prints_the_table_of_lamc_run_to_the_last_bit(name: str, tmp_path: Path) -> None:
    """With a compiler's defaults: nothing but -std=c99, which stops gcc from fusing products and sums. Numbers are
    printed as Python prints them, so that the text is the same."""
    folder = put(exported(name), tmp_path / "elsewhere")
    cc(folder, "-std=c99", "example_main.c", f"{name}.c", "-lm", "-o", "example")
    printed, expected = does([folder / "example"], folder), table_of_python(name, tmp_path)
    assert rows_of(printed) == rows_of(expected)
    assert printed == expected


@pytest.mark.parametrize("name", KINDS)
@pytest.mark.quick("pendulum", "limit_stop", others="campaign")
def test_the_example_of_fixed_steps_runs_to_its_end(name: str, tmp_path: Path) -> None:
    """The step that it begins with is stable, and where nothing strikes it is accurate, too: a step of 1 ms, short
    against periods of some 0.1 s and more, leaves RK4 an error of (0.001/0.1)^4 = 1e-8 of angles of about 1 rad."""
    folder = put(exported(name, real_time=True), tmp_path)
    cc(folder, "-std=c99", "example_main.c", f"{name}.c", "-lm", "-o", "example")
    printed, expected = (
        list(csv.reader(io.StringIO(text)))[1:]
        for text in (does([folder / "example"], folder), table_of_python(name, tmp_path))
    )
    assert [row[0] for row in printed] == [row[0] for row in expected]  # not the sum of a thousand steps
    fixed, exact = np.array(printed, dtype=float), np.array(expected, dtype=float)
    assert fixed.shape == exact.shape
    assert np.isfinite(fixed).all()
    if name in ("pendulum", "four_bar"):
        joints = len(mechanism_of(name).joints) - (name == "four_bar")
        assert np.abs(fixed - exact)[:, 1 : 1 + joints].max() < 1e-7


@pytest.mark.parametrize("name", KINDS)
@pytest.mark.quick("pendulum", "limit_stop")
def test_the_header_begins_with_a_step_that_is_stable(name: str) -> None:
    """Stops push back with dampers that 1 ms is too long for; the example's step is no longer than the header's."""
    files = exported(name, real_time=True)
    (reported,) = re.findall(rf"status = {name}_step_fixed\(&it, (\S+)\);", files[f"{name}.h"].decode())
    (taken,) = re.findall(r"h = \(double\)(\S+);", files["example_main.c"].decode())
    assert float(taken) <= float(reported)
    assert (float(reported) < 1e-3) == (name == "limit_stop")


@pytest.mark.parametrize("options", [{}, {"real_time": True}, {"real_time": True, "precision": "float"}])
@pytest.mark.slow
@pytest.mark.ci("options0", "options2")
def test_the_example_measures_what_calls_cost(options: dict[str, object], tmp_path: Path) -> None:
    """A fixed step has four right-hand sides; a call to the next row of the table has one at least, of six a step."""
    folder = put(exported("pendulum", **options), tmp_path)
    example = folder / "example_main.c"
    text = example.read_text()
    assert text.count("< CLOCKS_PER_SEC)") == 2  # a second each
    example.write_text(text.replace("< CLOCKS_PER_SEC)", "< CLOCKS_PER_SEC / 5)"))
    cc(folder, "-std=c99", *STRICT, "example_main.c", "pendulum.c", "-lm", "-o", "example")
    reported = does([folder / "example", "--time"], folder)
    numbers = re.fullmatch(
        r"a right-hand side: (\d+) ns\na (?:step of|call to the next) \S+ s: (\d+) ns\n", reported
    )
    assert numbers is not None
    slope, step = map(int, numbers.groups())
    assert 0 < slope < step
    assert step > 2 * slope or "real_time" not in options  # 4, and clocks of busy machines


@pytest.mark.parametrize("compiler", compilers())
@pytest.mark.parametrize("name", KINDS)
@pytest.mark.slow
@pytest.mark.ci("pendulum-gcc", "limit_stop-clang")
def test_it_builds_without_a_warning_and_prints_the_same_bytes(
    name: str, compiler: Sequence[str], tmp_path: Path
) -> None:
    folder = put(exported(name), tmp_path)
    sources = ("example_main.c", f"{name}.c", "-lm")
    cc(folder, "-std=c99", "-O2", "-ffp-contract=off", *STRICT, *sources, "-o", "strict", command=compiler)
    cc(folder, "-std=c99", *sources, "-o", "plain")
    assert does([folder / "strict"], folder) == does([folder / "plain"], folder)


@pytest.mark.parametrize("options", [{"real_time": True}, {"integrator": "rk45"}, {"integrator": "radau5"}])
@pytest.mark.parametrize("compiler", compilers())
@pytest.mark.parametrize("name", KINDS)
@pytest.mark.quick("pendulum-*-options1", "four_bar-gcc-options0", others="campaign")
def test_what_is_left_out_leaves_no_warning(
    name: str, compiler: Sequence[str], options: dict[str, object], tmp_path: Path
) -> None:
    """Nothing unused stays behind in smaller exports either."""
    folder = put(exported(name, **options), tmp_path)
    for source in (f"{name}.c", "example_main.c"):
        cc(folder, "-std=c99", "-c", *STRICT, source, "-o", f"{source}.o", command=compiler)


@needs("clang++")
@pytest.mark.parametrize("options", [{}, {"real_time": True}, {"real_time": True, "precision": "float"}])
def test_it_is_cxx_to_clang_too(options: dict[str, object], tmp_path: Path) -> None:
    """clang++ warns of mixtures of enumerations and numbers of which g++ says nothing."""
    folder = put(exported("pendulum", **options), tmp_path)
    for source in ("pendulum.c", "example_main.c"):
        cc(folder, "-x", "c++", "-std=c++17", "-c", *STRICT, source, "-o", "it.o", command=["clang++"])


def test_the_example_refuses_words_that_it_does_not_know(tmp_path: Path) -> None:
    folder = put(exported("pendulum"), tmp_path)
    cc(folder, "-std=c99", "example_main.c", "pendulum.c", "-lm", "-o", "example")
    for words in (["--tiem"], ["--time", "5"]):
        done = subprocess.run([folder / "example", *words], capture_output=True, text=True, check=False)
        assert (done.returncode, done.stdout) == (2, "")
        assert done.stderr == f"{words[-1]}: --time or nothing\n"


@needs("g++")
@pytest.mark.parametrize("name", KINDS)
@pytest.mark.quick("pendulum", others="campaign")
def test_it_is_valid_cxx_too(name: str, tmp_path: Path) -> None:
    folder = put(exported(name), tmp_path)
    cc(folder, "-x", "c++", "-std=c++17", "-c", *STRICT, f"{name}.c", "-o", "c.o", command=["g++"])
    cc(folder, "-x", "c++", "-std=c++17", "-c", *STRICT, "example_main.c", "-o", "e.o", command=["g++"])
    cc(folder, "c.o", "e.o", "-o", "example", command=["g++"])
    cc(folder, "-std=c99", "example_main.c", f"{name}.c", "-lm", "-o", "plain")
    assert does([folder / "example"], folder) == does([folder / "plain"], folder)


_TWO_IN_CXX = """
#include <cstdio>
#include <vector>
@includes
#include "pendulum.h"
#include "four_bar.h"

int main() {
  std::vector<pendulum_t> pendulums(2);
  std::vector<four_bar_t> bars(2);
  for (auto &it : pendulums) if (pendulum_init(&it, nullptr, nullptr) != PENDULUM_OK) return 1;
  for (auto &it : bars) if (four_bar_init(&it, nullptr, nullptr) != FOUR_BAR_OK) return 2;
  for (int k = 1; k <= 20; k++) {
    for (auto &it : pendulums) if (pendulum_step(&it, 0.01 * k) != PENDULUM_OK) return 3;
    for (auto &it : bars) if (four_bar_step(&it, 0.01 * k) != FOUR_BAR_OK) return 4;
  }
  for (auto &it : pendulums) std::printf("%a %a\\n", it.q[0], it.u[0]);
  for (auto &it : bars) std::printf("%a %a\\n", it.q[0], it.u[0]);
}
"""


@needs("g++")
@pytest.mark.parametrize("single", [False, True])
@pytest.mark.slow
def test_two_models_live_in_one_cxx_program(single: bool, tmp_path: Path) -> None:
    """As C objects and as single headers in one file of C++; both ways the same bits."""
    names = ("pendulum", "four_bar")
    for name in names:
        put(exported(name, single_header=single), tmp_path)
    if single:
        includes = "\n".join(f"#define {name.upper()}_IMPLEMENTATION" for name in names)
        objects = []
    else:
        includes = ""
        objects = [f"{name}.o" for name in names]
        for name in names:
            cc(tmp_path, "-std=c99", "-c", f"{name}.c")
    (tmp_path / "main.cpp").write_text(_TWO_IN_CXX.replace("@includes", includes))
    flags = ("-std=c++17", "-ffp-contract=off", *STRICT)
    cc(tmp_path, *flags, "main.cpp", *objects, "-o", "two", command=["g++"])
    rows = does([tmp_path / "two"], tmp_path).split()
    pendulum, bar = (
        lamc.compile(mechanism_of(name), scene_of(name)).run(10.0, t_eval=[0.0, 0.2]) for name in names
    )
    wanted = [pendulum.q[1, 0], pendulum.u[1, 0]] * 2 + [bar.q[1, 0], bar.u[1, 0]] * 2
    assert [float.fromhex(row) for row in rows] == wanted


@pytest.mark.parametrize("compiler", compilers())
@pytest.mark.quick("gcc", others="campaign")
def test_the_single_header_is_all_there_is(compiler: Sequence[str], tmp_path: Path) -> None:
    files = exported("pendulum", single_header=True)
    assert {name for name in files if name.endswith((".c", ".h"))} == {
        "example_main.c",
        "pendulum.h",
        "pendulum_params.h",
    }
    folder = put(files, tmp_path / "one")
    cc(folder, "-std=c99", *STRICT, "example_main.c", "-lm", "-o", "example", command=compiler)
    two = put(exported("pendulum"), tmp_path / "two")
    cc(two, "-std=c99", "example_main.c", "pendulum.c", "-lm", "-o", "example")
    assert does([folder / "example"], folder) == does([two / "example"], two)
    (folder / "twice.c").write_text(
        '#define PENDULUM_IMPLEMENTATION\n#include "pendulum.h"\n#include "pendulum.h"\n'
    )
    cc(folder, "-std=c99", "-c", *STRICT, "twice.c", command=compiler)


@pytest.mark.parametrize(
    "options",
    [
        {},
        {"single_header": True},
        {"real_time": True},
        {"libm": False},
        {"libm": False, "single_header": True},
    ],
)
@pytest.mark.quick("options0", others="campaign")
def test_the_commands_of_its_readme_build_it(options: dict[str, object], tmp_path: Path) -> None:
    """And the first lines of code that it shows, in a program of two lines more."""
    files = exported("pendulum", **options)
    folder = put(files, tmp_path)
    readme = files["README.md"].decode()
    (command,) = re.findall(r"```sh\n(cc .*)\n```", readme)
    assert ("-lm" in command.split()) == options.get("libm", True)
    command = command.replace("-O2 ", "")  # seconds, twice
    does(["sh", "-e", "-c", command], folder)
    assert len(does([folder / "example"], folder).splitlines()) == 2002
    (usage,) = re.findall(r"```c\n(.*?)```", readme, re.DOTALL)
    single = "#define PENDULUM_IMPLEMENTATION\n" if options.get("single_header") else ""
    include, _, rest = usage.partition("\n")
    (folder / "example_main.c").write_text(
        f"{single}{include}\n#include <stdio.h>\nint main(void) {{\n{rest}return status != PENDULUM_OK;\n}}\n"
    )
    does(["sh", "-e", "-c", command], folder)
    does([folder / "example"], folder)


# --- CMake and pkg-config -----------------------------------------------------------------------------------------

_APP = """
#include "pendulum.h"
#include "four_bar.h"
#include <stdio.h>
int main(void) {
  pendulum_t p;
  four_bar_t f;
  if (pendulum_init(&p, NULL, NULL) != PENDULUM_OK || four_bar_init(&f, NULL, NULL) != FOUR_BAR_OK) return 1;
  if (pendulum_step(&p, 0.1) != PENDULUM_OK || four_bar_step(&f, 0.1) != FOUR_BAR_OK) return 2;
  puts("steps");
  return 0;
}
"""
_FOUND = """
cmake_minimum_required(VERSION 3.14)
project(app LANGUAGES C)
find_package(pendulum CONFIG REQUIRED)
find_package(four_bar CONFIG REQUIRED)
add_executable(app app.c)
target_link_libraries(app PRIVATE pendulum::pendulum four_bar::four_bar)
"""
_BELOW = """
cmake_minimum_required(VERSION 3.14)
project(app LANGUAGES C)
add_subdirectory(../pendulum pendulum)
add_subdirectory(../four_bar four_bar)
add_executable(app app.c)
target_link_libraries(app PRIVATE pendulum::pendulum four_bar::four_bar)
"""
MODELS = ("pendulum", "four_bar")


def application(folder: Path, cmake: str) -> Path:
    folder.mkdir()
    (folder / "app.c").write_text(_APP)
    (folder / "CMakeLists.txt").write_text(cmake)
    return folder


@pytest.fixture(scope="module", params=["OFF", "ON"])
def built(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with both models, built by CMake as static or shared libraries."""
    above = tmp_path_factory.mktemp(f"built{request.param}")
    for name in MODELS:
        folder = put(exported(name, single_header=name == "four_bar"), above / name)
        quickly = "-DCMAKE_C_FLAGS_RELEASE="  # what is optimised is no matter of CMake
        does(["cmake", "-S", ".", "-B", "build", f"-DBUILD_SHARED_LIBS={request.param}", quickly], folder)
        does(["cmake", "--build", "build"], folder)
    return above


@needs("cmake")
@pytest.mark.slow
@pytest.mark.ci("OFF")
def test_cmake_finds_it_installed_and_in_its_build_tree(built: Path, tmp_path: Path) -> None:
    prefix = tmp_path / "prefix"
    for name in MODELS:
        does(["cmake", "--install", "build", "--prefix", prefix], built / name)
        assert len(does([f"build/{name}_example"], built / name).splitlines()) > 100
    moved = tmp_path / "moved"
    prefix.rename(moved)  # what is installed may be moved
    app = application(tmp_path / "app", _FOUND)
    does(["cmake", "-S", ".", "-B", "installed", f"-DCMAKE_PREFIX_PATH={moved}"], app)
    does(["cmake", "--build", "installed"], app)
    assert does(["installed/app"], app) == "steps\n"
    places = [f"-D{name}_DIR={built / name / 'build'}" for name in MODELS]
    does(["cmake", "-S", ".", "-B", "tree", *places], app)
    does(["cmake", "--build", "tree"], app)
    assert does(["tree/app"], app) == "steps\n"


@needs("cmake")
@pytest.mark.slow
def test_cmake_takes_several_folders_into_one_project(tmp_path: Path) -> None:
    for name in MODELS:
        put(exported(name), tmp_path / name)
    app = application(tmp_path / "app", _BELOW)
    does(["cmake", "-S", ".", "-B", "build"], app)
    does(["cmake", "--build", "build"], app)
    assert does(["build/app"], app) == "steps\n"


@needs("cmake", "pkg-config")
@pytest.mark.slow
@pytest.mark.ci("OFF")
def test_pkg_config_finds_it_wherever_it_was_moved(built: Path, tmp_path: Path) -> None:
    prefix, moved = tmp_path / "prefix", tmp_path / "moved here"
    for name in MODELS:
        there = built / name
        does(["cmake", "-S", ".", "-B", "build", "-DCMAKE_INSTALL_LIBDIR=lib/any-linux-gnu"], there)
        does(["cmake", "--install", "build", "--prefix", prefix], there)
    prefix.rename(moved)
    (tmp_path / "app.c").write_text(_APP)
    command = f"{shutil.which('cc')} app.c $(pkg-config --cflags --libs pendulum four_bar) -o app"
    place = {"PKG_CONFIG_PATH": str(moved / "lib" / "any-linux-gnu" / "pkgconfig")}
    words = does(["pkg-config", "--cflags", "--libs", *MODELS], tmp_path, **place)
    assert str(tmp_path / "prefix") not in words
    does(["sh", "-c", f'eval "{command}"'], tmp_path, **place)
    assert (
        does([tmp_path / "app"], tmp_path, LD_LIBRARY_PATH=str(moved / "lib" / "any-linux-gnu")) == "steps\n"
    )
