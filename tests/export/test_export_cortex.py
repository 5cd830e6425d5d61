"""Exports in single precision on a processor without doubles or system: a Cortex-M4F, which QEMU plays.

The board is an STM32F405 (`netduinoplus2`); `tests/cortex/` holds what a program needs there.
"""

import re
from collections import Counter
from pathlib import Path

import pytest

from lamc.codegen.names import identifier
from tests.support.ctools import CC, needs_cc
from tests.support.exported_folders import cc, does, exported, needs, put
from tests.support.paths import CORTEX

pytestmark = [needs_cc, needs("arm-none-eabi-gcc", "arm-none-eabi-nm")]
needs_board = needs("qemu-system-arm")

TARGET = (
    "-mcpu=cortex-m4", "-mthumb", "-mfloat-abi=hard", "-mfpu=fpv4-sp-d16", "-ffreestanding", "-nostdlib",
    "-std=c99", "-Wall", "-Wextra", "-Wconversion", "-Wdouble-promotion", "-Werror",
)  # fmt: skip
BOARD = (
    "qemu-system-arm", "-M", "netduinoplus2", "-nographic", "-monitor", "none", "-serial", "none", "-icount", "shift=0",
    "-semihosting-config", "enable=on,target=native,chardev=host", "-chardev", "stdio,id=host",
)  # fmt: skip
MEMORY = {"memcpy", "memmove", "memset"}  # that compilers call by themselves
STEPS = {"pendulum": "1e-3f", "four_bar": "1e-3f", "limit_stop": "1e-4f"}  # s


def folder_of(name: str, folder: Path) -> Path:
    return put(exported(name, real_time=True, precision="float"), folder)


def defined(name: str, steps: int, stride: int) -> list[str]:
    values = {"MODEL": identifier(name), "MODEL_H": f'"{name}.h"', "STEP": STEPS[name], "STEPS": steps}
    return [f"-D{key}={value}" for key, value in (values | {"STRIDE": stride}).items()]


def image_of(name: str, folder: Path, *flags: str, steps: int, stride: int) -> Path:
    sources = (f"{name}.c", str(CORTEX / "steps.c"), str(CORTEX / "startup.c"))
    given = [*TARGET, *flags, *defined(name, steps, stride), "-I.", *sources]
    cc(folder, *given, "-T", str(CORTEX / "stm32f405.ld"), "-lgcc", "-o", "it.elf",
       command=["arm-none-eabi-gcc"])  # fmt: skip
    return folder / "it.elf"


@pytest.mark.parametrize("name", STEPS)
def test_nothing_of_doubles_is_linked(name: str, tmp_path: Path) -> None:
    """Nor anything else but moves of memory and, with loops, a conversion to long long of the compiler's library."""
    folder = folder_of(name, tmp_path)
    cc(folder, *TARGET, "-O2", "-c", f"{name}.c", "-o", "it.o", command=["arm-none-eabi-gcc"])
    left = {line.split()[-1] for line in does(["arm-none-eabi-nm", "-u", "it.o"], folder).splitlines()}
    assert left <= MEMORY | ({"__aeabi_f2lz"} if name == "four_bar" else set())
    kinds = {line.split()[-2] for line in does(["arm-none-eabi-nm", "it.o"], folder).splitlines()}
    assert not kinds & set("dDbBC")  # globals that can be written


@pytest.mark.parametrize(("level", "code"), [("-O2", 24_000), ("-Os", 19_000)])
def test_memory_is_that_of_a_small_board(level: str, code: int, tmp_path: Path) -> None:
    """A loop, which takes most of all: all functions of the header, before a linker drops those that nobody calls.

    Code and tables: a tenth above what gcc 12.2 makes, for other compilers; 64 kB, the least flash of an STM32F4, hold
    two such models. Stack: no function calls itself, so none stands on it twice, and the frames of a step and of all
    that is not in the header are more than any chain of calls from a step can take; the chain that is taken needs a
    fourth of it (docs/embedding.md). A task of 4 KiB has room for that and for as much of its own.
    """
    folder = folder_of("four_bar", tmp_path)
    cc(
        folder,
        *TARGET,
        level,
        "-fstack-usage",
        "-c",
        "four_bar.c",
        "-o",
        "it.o",
        command=["arm-none-eabi-gcc"],
    )
    text, data, bss = map(int, does(["arm-none-eabi-size", "it.o"], folder).splitlines()[-1].split()[:3])
    assert text <= code
    assert data == bss == 0
    usage = [line.split("\t") for line in (folder / "it.su").read_text().splitlines()]
    assert {kind for _, _, kind in usage} == {"static"}  # nothing grows with what is computed
    frames = {place.split(":")[-1]: int(size) for place, size, _ in usage}
    inner = sum(size for name, size in frames.items() if name.startswith("four_bar_rt_"))
    assert frames["four_bar_step_fixed"] + inner <= 2048 + 512
    assert max(frames.values()) <= 1024  # the derivatives' own


@needs_board
@pytest.mark.parametrize("level", ["-O2", "-Os"])
@pytest.mark.parametrize("name", STEPS)
def test_states_are_those_of_this_machine_to_the_last_bit(name: str, level: str, tmp_path: Path) -> None:
    """Here square roots are taken digit by digit, there by an instruction: both are rounded correctly."""
    folder = folder_of(name, tmp_path)
    image = image_of(name, folder, level, steps=1000, stride=50)
    there = does([*BOARD, "-kernel", str(image)], folder)
    flags = ("-std=c99", "-O2", "-DHOSTED", *defined(name, 1000, 50), "-I.")
    cc(folder, *flags, f"{name}.c", str(CORTEX / "steps.c"), "-o", "here", command=[CC])
    here = does([folder / "here"], folder)
    rows = [line for line in there.splitlines() if not line.startswith("ticks")]
    assert len(rows) == 21
    assert rows == here.splitlines()


@needs_board
def test_a_step_takes_no_more_operations_than_the_header_says(tmp_path: Path) -> None:
    """Every instruction of one step is counted: arithmetic outside of sines, and pairs of sine and cosine."""
    folder = folder_of("pendulum", tmp_path)
    said = re.search(r"takes at most (\d+) operations .*, (\d+) calls", (folder / "pendulum.h").read_text())
    assert said is not None
    operations, calls = map(int, said.groups())
    image = image_of("pendulum", folder, "-O1", "-fno-inline", steps=1, stride=1)
    does([*BOARD, "-kernel", str(image), "-singlestep", "-d", "exec,nochain", "-D", "log"], folder)
    executed = [
        (int(place, 16), symbol)
        for place, symbol in re.findall(
            r"\[\w+/(\w+)/.*\] (\w+)$", (folder / "log").read_text(), re.MULTILINE
        )
    ]
    inside = [k for k, (_, symbol) in enumerate(executed) if symbol == "pendulum_step_fixed"]
    step = Counter(executed[inside[0] : inside[-1]])
    listing = does(["arm-none-eabi-objdump", "-d", str(image)], folder)
    mnemonics = {
        int(place, 16): what for place, what in re.findall(r"^ (\w+):\t.*\t(v\w+)", listing, re.MULTILINE)
    }
    arithmetic = [
        count
        for (place, symbol), count in step.items()
        if re.match(r"v(add|sub|mul|div|nmul)", mnemonics.get(place, "")) and "_turn" not in symbol
        if "_trig" not in symbol
    ]
    assert not [what for what in mnemonics.values() if re.match(r"v(n?mla|n?mls|fn?ma|fn?ms)", what)]
    assert sum(arithmetic) <= operations
    assert sum(arithmetic) >= 0.8 * operations  # the bound is no idle one
    entry = re.search(r"^(\w+) <pendulum_rt_turn>:", listing, re.MULTILINE)
    assert entry is not None
    assert 2 * step[(int(entry.group(1), 16), "pendulum_rt_turn")] <= calls
