"""Commands and programs of the page for those who embed exports, and of the guide on exports, do what they say."""

import re
import shlex
import subprocess
from pathlib import Path

import pytest
from click.testing import CliRunner

import lamc
from lamc import plate
from lamc.cli import main
from lamc.examples import plates
from lamc.export import files_of
from tests.support.ctools import needs_cc
from tests.support.exported_folders import STRICT, cc, does, exported, mechanism_of, needs, put
from tests.support.paths import ROOT

TEXTS = {
    name: (ROOT / name).read_text(encoding="utf-8") for name in ("docs/guide/export.md", "docs/embedding.md")
}

pytestmark = needs_cc


def blocks(text: str, language: str) -> list[str]:
    return re.findall(rf"```{language}\n(.*?)```", text, re.DOTALL)


def script(name: str) -> list[str]:
    """Lines of the page's blocks in their order, less what test_readme.py runs and nothing here builds on."""
    lines = [
        line.split(" #")[0].strip() for block in blocks(TEXTS[name], "sh") for line in block.splitlines()
    ]
    built = " ".join(line for line in lines if not line.startswith("lamc "))
    is_guide = name.startswith("docs/guide/")
    return [
        line
        for line in lines
        if not (is_guide and line.startswith("lamc ")) or line.split("--out ")[-1].split()[0] in built
    ]


@pytest.mark.usefixtures("unpainted")
@pytest.mark.parametrize("name", sorted(TEXTS))
@pytest.mark.quick("docs/guide/export.md")
def test_commands_in_their_order_leave_a_program_that_prints(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    lines = script(name)
    assert lines[0].startswith("lamc export")
    assert "cc " in lines[1]
    for line in lines:
        if line.startswith("lamc "):
            done = CliRunner().invoke(main, shlex.split(line)[1:])
            assert done.exit_code == 0, done.output
        else:
            does(["sh", "-e", "-c", line.replace("-O2 ", "")], tmp_path)
    (program,) = [p for p in tmp_path.rglob("*") if p.name in ("example", "pendulum") and p.is_file()]
    assert len(does([program], tmp_path).splitlines()) == 2002  # a title and 200 rows a second of 10 s


@pytest.mark.parametrize("name", sorted(TEXTS))
@pytest.mark.quick("docs/guide/export.md")
def test_programs_compile_without_a_warning_and_run(name: str, tmp_path: Path) -> None:
    put(exported("pendulum"), tmp_path)
    put(files_of(plate.load_plate(plates.find("strip").path), "c"), tmp_path)
    programs = blocks(TEXTS[name], "c")
    assert programs
    for program in programs:
        whole = (
            program
            if "int main" in program
            else f"""
#include "pendulum.h"
int main(void) {{
pendulum_t it;
if (pendulum_init(&it, 0, 0) != PENDULUM_OK) return 1;
{program}
return 0;
}}
"""
        )
        (tmp_path / "program.c").write_text(whole)
        source = "strip.c" if '"strip.h"' in program else "pendulum.c"
        cc(tmp_path, "-std=c99", *STRICT, "program.c", source, "-lm", "-o", "program")
        does([tmp_path / "program"], tmp_path)


def test_cmake_lines_name_what_the_folder_has() -> None:
    lists = exported("pendulum")["CMakeLists.txt"].decode()
    for text in TEXTS.values():
        for block in blocks(text, "cmake"):
            assert "pendulum::pendulum" in block
            assert "add_library(pendulum::pendulum ALIAS" in lists


@needs("rustc", "ar")
@pytest.mark.slow
def test_the_program_in_rust_gets_the_bits_of_python(tmp_path: Path) -> None:
    put(exported("pendulum"), tmp_path)
    text = TEXTS["docs/embedding.md"]
    if subprocess.run(["rustc", "--version"], capture_output=True, check=False).returncode != 0:
        pytest.skip("rustc is there as rustup's name for it, without a toolchain")
    (program,) = blocks(text, "rust")
    (tmp_path / "main.rs").write_text(program)
    (command,) = re.findall(r"^`(cc .* rustc .*)`$", text, re.MULTILINE)
    does(["sh", "-e", "-c", command], tmp_path)
    t, angle, _ = map(
        float, does([tmp_path / "main"], tmp_path).split()
    )  # Rust prints what reads back exactly
    result = lamc.compile(mechanism_of("pendulum")).run(10.0, t_eval=[0.0, 0.5])
    assert (t, angle) == (0.5, result.q[1, 0])
    (room,) = re.findall(r"rest: \[u64; (\d+)\]", program)
    (reported,) = re.findall(r"one instance \| (\d+) bytes", exported("pendulum")["README.md"].decode())
    assert 7 * 8 + 8 * int(room) >= int(reported)
