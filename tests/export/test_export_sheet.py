"""A sheet of 4 x 4 facets for a controller: it fits one, and moves as the simulator does."""

from pathlib import Path

import numpy as np
import pytest

import lamc
from lamc.examples.miura import miura
from lamc.readers.load import load_text
from tests.support.ctools import needs_cc
from tests.support.exported import C99, Exported, c_files
from tests.support.exported_folders import does, needs

pytestmark = [needs_cc, pytest.mark.slow]

STEP = 1e-3  # s
FLASH, RAM = (
    512 * 1024,
    256 * 1024,
)  # bytes, of the smallest Cortex-M7 (STM32F722); code for x86-64 is no smaller


@needs("size")
def test_a_sheet_of_sixteen_facets_fits_a_cortex_m7_in_double(tmp_path: Path) -> None:
    mechanism = lamc.split(load_text(miura(4, 4), "miura"))
    options = lamc.ExportOptions(real_time=True, prefix="sheet", jacobian=False)
    model = Exported(c_files(mechanism, options=options), tmp_path, (*C99, "-Os"))
    text, data, bss = map(int, does(["size", "model.so"], tmp_path).splitlines()[1].split()[:3])
    assert text + data <= FLASH
    assert bss + model.ffi.sizeof("sheet_t") + model.ffi.sizeof("sheet_parameters") <= RAM
    it = model.instance()
    for _ in range(200):
        assert model.call("step_fixed", it, STEP) == 0
    sim = lamc.compile(mechanism)
    exact = sim.run(t_end=200 * STEP, rtol=1e-10, atol=1e-12)
    found = np.array(model.state(it))[: len(sim.joints)]
    # Classical Runge-Kutta steps of a millisecond, of motions of some 20 rad/s: (20e-3)^4 in 0.2 s
    assert np.abs(found - exact.q[-1]).max() <= 1e-6
