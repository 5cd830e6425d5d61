"""Results and simulators go to other processes and back: compiled code is found again by its digest."""

import copy
import pickle
import subprocess
import sys
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from pathlib import Path

import numpy as np
import pytest

import lamc
from lamc.examples import path as example
from lamc.run.result import Result
from lamc.run.simulator import Simulator


@pytest.fixture(scope="module")
def simulator() -> Simulator:
    return lamc.compile(lamc.load(example("four_bar")))


def run(job: tuple[Simulator, float]) -> Result:
    simulator, stiffness = job
    return simulator.run(0.05, parameters={"arm.stiffness": stiffness})


@pytest.mark.quick("fork", others="campaign")
@pytest.mark.parametrize("kind", ["fork", "spawn"])
def test_pools_take_simulators_and_return_results(simulator: Simulator, kind: str) -> None:
    with ProcessPoolExecutor(1, mp_context=get_context(kind)) as pool:
        (there,) = pool.map(run, [(simulator, 3e-5)])
    here = run((simulator, 3e-5))
    assert np.array_equal(there.q, here.q)  # the same code: to the last bit
    assert np.array_equal(there.energy, here.energy)
    assert there.pose("shelf")[0] == pytest.approx(here.pose("shelf")[0], abs=0.0)
    assert there.provenance.parameters["arm.stiffness"] == 3e-5
    assert there.motion.model is simulator.model  # nothing was loaded twice


def test_a_result_is_read_in_a_process_that_compiled_nothing(simulator: Simulator, tmp_path: Path) -> None:
    result = simulator.run(0.05, energy_balance=True)
    (tmp_path / "r.pickle").write_bytes(pickle.dumps(result))
    code = (
        "import pickle, sys, numpy as np\n"
        "r = pickle.loads(open(sys.argv[1], 'rb').read())\n"
        "print(repr(float(r.energy[-1])), repr(float(r.powers['gravity'][-1])), r.hinges, r.q.flags.writeable)"
    )
    done = subprocess.run(
        [sys.executable, "-c", code, str(tmp_path / "r.pickle")], capture_output=True, text=True, check=True
    )
    power = float(result.powers["gravity"][-1])
    assert done.stdout.split(maxsplit=2)[:2] == [repr(float(result.energy[-1])), repr(power)]
    assert done.stdout.strip().endswith(f"{result.hinges} False")


def test_the_energy_balance_goes_along(simulator: Simulator) -> None:
    result = simulator.run(0.05, energy_balance=True)
    other = pickle.loads(pickle.dumps(result))
    assert other.energy_balance.balance == result.energy_balance.balance
    assert np.array_equal(other.work["gravity"], result.work["gravity"])


def test_runs_to_an_accuracy_and_copies_go_too(simulator: Simulator) -> None:
    result = simulator.run(0.05, accuracy=1e-3)
    assert pickle.loads(pickle.dumps(result)).error_estimate == result.error_estimate
    assert copy.deepcopy(simulator) is simulator


def test_a_model_of_another_program_is_refused(simulator: Simulator) -> None:
    text = pickle.dumps(simulator.run(0.01))
    digest = simulator.model.digest.encode()
    with pytest.raises(lamc.UnsupportedError, match="another program"):
        pickle.loads(text.replace(digest, digest[::-1]))
