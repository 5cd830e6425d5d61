"""Exports that call no mathematical library: what is left to link, and how near their motion is to that with one."""

import re
from pathlib import Path

import numpy as np
import pytest

import lamc
from lamc.export import files_of
from tests.support.ctools import needs_cc
from tests.support.exported import Exported
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

MODELS = (*KINDS, "stiff_triple")


@needs("nm")
@pytest.mark.parametrize("compiler", compilers())
@pytest.mark.parametrize("name", MODELS)
@pytest.mark.slow
@pytest.mark.ci("pendulum-gcc")
def test_nothing_is_left_to_link(name: str, compiler: list[str], tmp_path: Path) -> None:
    """But blocks of memory, which compilers copy and clear by calls whether a program says so or not."""
    folder = put(exported(name, libm=False), tmp_path)
    included = set(re.findall(r"#include <(.*)>", (folder / f"{name}.c").read_text()))
    assert included <= {
        "float.h",
        "limits.h",
        "stddef.h",
        "stdint.h",
    }  # of a freestanding compiler, C99 section 4
    cc(folder, "-std=c99", *STRICT, "-O2", "-c", f"{name}.c", "-o", "it.o", command=compiler)
    left = {line.split()[-1] for line in does(["nm", "-u", "it.o"], folder).splitlines()}
    assert left <= {"memcpy", "memset", "memmove", "_GLOBAL_OFFSET_TABLE_"}


@needs("g++")
@pytest.mark.slow
def test_it_is_cxx_too(tmp_path: Path) -> None:
    folder = put(exported("crawler", libm=False), tmp_path)
    cc(folder, "-x", "c++", "-std=c++17", *STRICT, "-c", "crawler.c", "-o", "it.o", command=["g++"])


def test_what_the_model_does_not_call_is_not_there() -> None:
    source = exported("pendulum", libm=False)["pendulum.c"].decode()
    assert "_rt_sqrt(" in source  # of the norms of errors
    assert "_rt_tanh(" not in source
    assert "_rt_asin(" not in source


@pytest.mark.parametrize("name", ["pendulum", "four_bar", "limit_stop"])
@pytest.mark.quick("limit_stop", others="campaign")
def test_the_motion_is_that_with_a_library_to_the_tolerance(name: str, tmp_path: Path) -> None:
    """A first step comes of pow, whose last digits differ, and with it all steps; nothing else does."""
    t_end = DURATION[name]
    times = np.linspace(0.0, t_end, 21)[1:]
    mechanism, scene = mechanism_of(name), scene_of(name)
    result = lamc.compile(mechanism, scene).run(t_end, t_eval=times, rtol=1e-9, atol=1e-11)
    one = Exported(files_of(mechanism, "c", scene, lamc.ExportOptions(libm=False)), tmp_path)
    states = one.trajectory(one.instance(t_stop=t_end), times)
    expected = np.hstack([result.q, result.u])
    # Twice what each run may be off: its local errors of 1e-9, added up along a few hundred steps.
    assert np.max(np.abs(states - expected)) <= 1e-6 * max(1.0, float(np.max(np.abs(expected))))


@pytest.mark.parametrize("name", ["pendulum", "limit_stop", "stiff_triple"])
@pytest.mark.quick("pendulum", others="campaign")
def test_trees_of_hinges_have_the_bits_of_those_with_a_library_where_the_first_step_is_given(
    name: str, tmp_path: Path
) -> None:
    """Sine and cosine are lamc's own in both, square roots are rounded correctly in both, and what is left is pow,
    which chooses a first step. Hinges that close loops call atan2, contact exp and log: those may differ."""
    times = np.linspace(0.0, DURATION[name], 21)[1:]
    states = []
    for libm in (True, False):
        one = Exported(exported(name, libm=libm), tmp_path / str(libm))
        states.append(one.trajectory(one.instance(t_stop=DURATION[name], first_step=1e-5), times))
    assert states[0].tobytes() == states[1].tobytes()


@pytest.mark.parametrize("name", ["pendulum", pytest.param("crawler", marks=pytest.mark.slow)])
@pytest.mark.campaign
def test_compilers_agree_to_the_last_bit(name: str, tmp_path: Path) -> None:
    """The example of the folder prints all digits. Without contraction nothing is left that compilers may choose."""
    printed = []
    for parameter in compilers():
        if getattr(parameter, "marks", ()) and any(mark.args[0] for mark in parameter.marks):  # type: ignore[attr-defined]
            continue
        (command,) = parameter.values  # type: ignore[attr-defined]
        for level in ("-O0", "-O2", "-O3"):
            folder = put(exported(name, libm=False), tmp_path / f"{command[0].split('/')[-1]}{level}")
            flags = ("-std=c99", level, "-ffp-contract=off")
            cc(folder, *flags, "example_main.c", f"{name}.c", "-o", "example", command=command)
            printed.append(does([folder / "example"], folder))
    assert len(printed) >= 3
    assert len(set(printed)) == 1


def test_fast_math_is_refused_where_it_would_break_the_functions(tmp_path: Path) -> None:
    folder = put(exported("pendulum", libm=False), tmp_path)
    with pytest.raises(AssertionError, match="need IEEE 754"):
        cc(folder, "-std=c99", "-O2", "-ffast-math", "-c", "pendulum.c", "-o", "it.o")
