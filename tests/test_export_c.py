"""Exported C against the compiled module that Python runs: the same motion to the last bit, whatever a caller does
between two steps that does not concern the motion."""

from pathlib import Path

import numpy as np
import pytest

import lamc
from lamc.export import files_of
from tests.ctools import needs_cc
from tests.exported import Exported

pytestmark = needs_cc

EXAMPLES = Path(lamc.__file__).parent / "examples"
# name, end s: tree, stiff hinges, loops of each kind, limits with and without impact, contact and a floating base
SCENES = (
    ("pendulum.yaml", 2.0),
    ("stiff_triple.yaml", 0.3),
    ("four_bar.yaml", 1.0),
    ("vertex.yaml", 0.5),
    ("two_loops.yaml", 0.5),
    ("limit_stop.yaml", 1.0),
    ("flaps.yaml", 0.5),
    ("crawler.yaml", 0.2),
    ("flapping_wing.yaml", 0.02),
)


def example(name: str) -> lamc.Mechanism:
    design = lamc.load(EXAMPLES / name)
    return design if isinstance(design, lamc.Mechanism) else lamc.split(design)


@pytest.mark.parametrize(("name", "t_end"), SCENES)
def test_states_are_those_of_python_to_the_last_bit(name: str, t_end: float, tmp_path: Path) -> None:
    mechanism = example(name)
    times = np.linspace(0.0, t_end, 38)[1:]
    result = lamc.compile(mechanism).run(t_end, t_eval=times)
    assert result.success
    exported = Exported(files_of(mechanism), tmp_path)
    states = exported.trajectory(exported.instance(t_stop=t_end), times)
    assert states.tobytes() == np.hstack([result.q, result.u]).tobytes()
