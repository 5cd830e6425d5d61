"""Hard cases: what loops, redundancy, singular positions and stiffness cost, and how exact lamc is there.

    python -m benchmarks.hard_cases [--quick] [--out FOLDER]

First a table of the reference cases with loops and of the gallery, each run with lamc's defaults but for the tolerance.
Then 100 s of undamped motion beside MuJoCo (RK4, `connect` constraints, steps of 1 ms) in the same run. Prints tables
and writes JSON.
"""

import argparse
import json
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

import lamc
from benchmarks.measure import ROOT, environment, interleaved, write_json
from benchmarks.spine import fresh_folder, rows_in_c, show, target
from lamc import examples
from lamc.commands.examples import mechanism_of_example
from lamc.records.mechanism import Joint, Mechanism
from lamc.run.result import Result
from lamc.run.simulator import Simulator
from tests.support.mechanisms import from_reference

try:
    from benchmarks.peers import mujoco_peer
except ImportError:  # the bench extra is not installed; its rows are left out
    mujoco_peer = None  # type: ignore[assignment]

Array = npt.NDArray[np.float64]
Rows = list[dict[str, Any]]

RTOL = 1e-8
TIGHT = 1e-11  # of the run that stands for the truth where nothing else does
LOOSER = (1e-4, 1e-5, 1e-6, 1e-7, 1e-8)  # tried beside MuJoCo, the loosest first
REFERENCE = ROOT / "tests" / "fixtures" / "reference" / "dynamics.json"
WITH_LOOPS = ("fourbar_crank", "fivebar", "vertex4_flatfoldable", "waterbomb6", "miura22", "miura33")
WITH_LOOPS += ("bricard", "sarrus", "nfourbar2")
GALLERY = ("four_bar", "five_bar", "six_bar", "two_loops", "vertex", "waterbomb", "miura:3x3", "sarrus")
GALLERY += ("miura:4x5", "folding_box", "bricard", "n_four_bar:10")
GALLERY_END = 5.0  # s
UNDAMPED = ("fourbar_crank", "fivebar", "vertex4_flatfoldable")
LONG = 100.0  # s
SAMPLES = 1000
WHOLE = ", all springs"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quick", action="store_true", help="one repeat, and 10 s beside MuJoCo")
    parser.add_argument("--out", type=Path, default=Path(__file__).parent / "results")
    arguments = parser.parse_args()
    repeats = 1 if arguments.quick else 5
    cases = {c["id"]: c for c in json.loads(REFERENCE.read_text(encoding="utf-8"))["cases"]}
    report: dict[str, Any] = {"environment": environment(), "rtol": RTOL}
    with fresh_folder():
        title = f"Hard cases at rtol {RTOL:g}: closure / size, energy drift / largest kinetic energy, error in rad"
        report["cases"] = show(title, [row_of(case, repeats) for case in all_cases(cases)])
        t_end = 10.0 if arguments.quick else LONG
        title = f"{t_end:g} s undamped: closure / size, energy drift / largest kinetic energy"
        report["lock_up"] = lock_up()
        report["undamped"] = show(title, beside_mujoco(cases, t_end, repeats))
    report["targets"] = show("Targets", targets(report, t_end))
    write_json(arguments.out / "hard_cases.json", report)


@dataclass(frozen=True)
class Case:
    """What to run, to when (s), and `error`: the largest error of a run, "-" where unknown, and against what."""

    name: str
    sim: Simulator
    t_end: float
    times: Array  # (m,), s: when it is compared
    error: Callable[[Result], float | str]
    against: str


def all_cases(cases: Mapping[str, Any]) -> list[Case]:
    found = [_reference_case(name, cases[name]) for name in WITH_LOOPS]
    found.append(_stiff_case(cases["triple_stiff_smooth_k1e+04"]))
    return found + [_gallery_case(name) for name in GALLERY]


def _reference_case(name: str, case: Mapping[str, Any]) -> Case:
    sim = lamc.compile(*from_reference(case["spec"]))
    rows = case["expected"]

    def error(result: Result) -> float:
        return max(
            abs(math.remainder(result.angle(joint)[k] - angle, 2 * math.pi))
            for k, row in enumerate(rows)
            for joint, angle in row["theta"].items()
        )

    times = np.array([float(row["t"]) for row in rows])
    return Case(name, sim, times[-1], times, error, "reference")


def _stiff_case(case: Mapping[str, Any]) -> Case:
    """The gallery's stiff triple pendulum, which is the reference's with k = 10^4 m g L; angles from the vertical."""
    sim = lamc.compile(mechanism_of_example(examples.find("stiff_triple")))
    expected = case["expected"]

    def error(result: Result) -> float:
        angles = np.cumsum([result.angle(joint)[-1] for joint in ("hip", "knee", "ankle")])
        return float(np.abs(angles - expected["abs_angles"]).max())

    return Case("stiff_triple", sim, expected["t"], np.array([expected["t"]]), error, "reference")


def _gallery_case(name: str) -> Case:
    sim = lamc.compile(mechanism_of_example(examples.find(name)))
    times = np.linspace(0.0, GALLERY_END, 51)
    truth = sim.run(GALLERY_END, rtol=TIGHT, atol=1e-2 * TIGHT, t_eval=times)

    def error(result: Result) -> float | str:
        return float(np.abs(result.q - truth.q).max()) if truth.success else "-"

    against = "tighter run" if truth.success else f"tighter run: {truth.status.name.lower()}"
    return Case(f"{name} (gallery)", sim, GALLERY_END, times, error, against)


def row_of(case: Case, repeats: int) -> dict[str, Any]:
    sim = case.sim
    result = sim.run(case.t_end, rtol=RTOL, atol=1e-2 * RTOL, t_eval=case.times)
    every = sim.run(case.t_end, rtol=RTOL, atol=1e-2 * RTOL)  # a row after each step
    conservative = all(effect.name in result.energies for effect in sim.effects)
    loops = sim.loops
    return {
        "case": case.name,
        "loops": loops.loops,
        "equations": loops.equations,
        "rank": loops.rank,
        "ended": "yes" if result.success else result.status.name.lower(),
        "steps": every.stats.accepted,
        "rejected": every.stats.rejected,
        "closure": float(every.constraint_error.max()) / sim.mechanism.size,
        "drift": _drift(every.energy, every) if conservative else "damped",
        "error": case.error(result) if result.success else "-",
        "against": case.against,
        "ms": 1e3 * _wall_time(sim, case.t_end, RTOL, repeats),
    }


def _drift(energy: Array, result: Result) -> float:
    """Largest change of the energy over the largest kinetic energy: no matter where potential energy is zero."""
    return float(np.abs(energy - energy[0]).max() / result.energies["kinetic"].max())


def _wall_time(sim: Simulator, t_end: float, rtol: float, repeats: int) -> float:
    jobs = {"run": lambda: sim.run(t_end, rtol=rtol, atol=1e-2 * rtol, t_eval=[t_end])}
    return interleaved(jobs, repeats)["run"]


def undamped(spec: Mapping[str, Any], *, as_in_mujoco: bool = True) -> tuple[Mechanism, lamc.Scene]:
    """A reference case without damping and torques; as in MuJoCo also without a spring in the hinge that is replaced
    by a constraint there, since a constraint holds none."""
    damped, scene = from_reference(spec)
    cuts = lamc.compile(damped, scene).cut_joints if as_in_mujoco else ()
    joints = tuple(_frictionless(joint, sprung=joint.name not in cuts) for joint in damped.joints)
    kept = tuple(e for e in scene.effects or () if e.name not in ("hinge_damping", "torque"))
    return replace(damped, joints=joints), lamc.Scene(effects=kept, angles=scene.angles, rates=scene.rates)


def _frictionless(joint: Joint, *, sprung: bool) -> Joint:
    return replace(joint, damping=0.0, stiffness=joint.stiffness if sprung else 0.0)


def beside_mujoco(cases: Mapping[str, Any], t_end: float, repeats: int) -> Rows:
    """For each case lamc at RTOL with all springs; then, without the spring of the cut hinge, lamc, MuJoCo with its
    default constraint and with the stiffest, and lamc once more at the loosest tolerance whose errors are no larger
    than those of MuJoCo's stiffest."""
    rows: Rows = []
    for name in UNDAMPED:
        gravity = cases[name]["spec"]["gravity"]
        whole = lamc.compile(*undamped(cases[name]["spec"], as_in_mujoco=False))
        rows.append(_own_row(f"{name}{WHOLE}", whole, RTOL, t_end, repeats))
        sim = lamc.compile(*undamped(cases[name]["spec"]))
        rows.append(_own_row(name, sim, RTOL, t_end, repeats))
        if mujoco_peer is None:
            continue
        peers = [
            _peer_row(name, sim, gravity, each, t_end) for each in (mujoco_peer.DEFAULT, mujoco_peer.STIFFEST)
        ]
        rows += peers
        for rtol in LOOSER:
            row = _own_row(name, sim, rtol, t_end, repeats)
            if row["closure"] <= peers[-1]["closure"] and row["drift"] <= peers[-1]["drift"]:
                rows.append(row)
                break
    return rows


def _own_row(name: str, sim: Simulator, rtol: float, t_end: float, repeats: int) -> dict[str, Any]:
    times = np.linspace(0.0, t_end, SAMPLES + 1)
    result = sim.run(t_end, rtol=rtol, atol=1e-2 * rtol, t_eval=times)
    assert result.success, result.message
    return {
        "case": name,
        "simulator": f"lamc, rtol {rtol:g}, {result.stats.integrator}",
        "seconds": _wall_time(sim, t_end, rtol, repeats),
        "closure": float(result.constraint_error.max()) / sim.mechanism.size,
        "drift": _drift(result.energy, result),
        "one evaluation ns": 1e9 * _right_hand_side(sim, repeats),
    }


def _peer_row(
    name: str, sim: Simulator, gravity: Sequence[float], constraint: str, t_end: float
) -> dict[str, Any]:
    mechanism = sim.mechanism
    moving = sim.run(1.0, rtol=RTOL, atol=1e-2 * RTOL)
    angles = {joint.name: float(moving.angle(joint.name)[0]) for joint in mechanism.joints}
    rates = {joint.name: float(moving.rate(joint.name)[0]) for joint in mechanism.joints}
    peer = mujoco_peer.MujocoPeer(mechanism, sim.cut_joints, gravity, constraint)
    run = peer.run(angles, rates, t_end, SAMPLES)
    label = "default" if constraint == mujoco_peer.DEFAULT else "stiffest"
    change = float(np.abs(run.energy - run.energy[0]).max())
    return {
        "case": name,
        "simulator": f"MuJoCo, 1 ms, {label} constraint",
        "seconds": run.seconds,
        "closure": run.gap / mechanism.size,
        "drift": change / float(moving.energies["kinetic"].max()),
        "one evaluation ns": "-",
    }


def _right_hand_side(sim: Simulator, repeats: int) -> float:
    """Seconds of one evaluation of the accelerations, over states of a run."""
    result = sim.run(1.0, rtol=RTOL, atol=1e-2 * RTOL, t_eval=np.linspace(0.0, 1.0, 1000))
    evaluate, _ = rows_in_c(sim, np.hstack([result.q, result.u]))
    return interleaved({"rows": evaluate}, max(repeats, 3))["rows"] / len(result.t)


def lock_up() -> dict[str, float]:
    """Rejected over accepted steps at rtol 1e-6: redundant equations that lock show in ratios far above one."""
    ratios = {}
    for name in ("miura:3x3", "bricard"):
        sim = lamc.compile(mechanism_of_example(examples.find(name)))
        stats = sim.run(10.0, rtol=1e-6, atol=1e-8).stats
        ratios[name] = (stats.rejected or 0) / stats.accepted
    return ratios


def targets(report: Mapping[str, Any], t_end: float) -> Rows:
    """What was set out to reach, and what this run found. Time limits are those of 100 s, scaled to t_end."""
    rows: Rows = []
    for row in report["cases"]:
        if row["loops"]:
            rows.append(target(f"{row['case']}: closure / size", row["closure"], 1e-9, at_most=True))
    for name, ratio in report["lock_up"].items():
        rows.append(target(f"{name} at 1e-6: rejected / accepted steps", ratio, 1 / 3, at_most=True))
    for name in UNDAMPED:
        found = [row for row in report["undamped"] if row["case"] == name]
        exact, *others = found
        (whole,) = (row for row in report["undamped"] if row["case"] == f"{name}{WHOLE}")
        rows.append(target(f"{name}, {t_end:g} s: closure / size", whole["closure"], 1e-9, at_most=True))
        rows.append(target(f"{name}, {t_end:g} s: energy drift", whole["drift"], 1e-6, at_most=True))
        limit = 0.1 * t_end / LONG
        rows.append(target(f"{name}, {t_end:g} s: seconds", whole["seconds"], limit, at_most=True))
        if others:
            stiffest = others[1]
            quickest = min(exact, found[-1], key=lambda row: row["seconds"])
            for label, row in ((f"rtol {RTOL:g}", exact), ("errors no larger", quickest)):
                ratio = stiffest["seconds"] / row["seconds"]
                rows.append(target(f"{name}: MuJoCo / lamc at {label}", ratio, 20.0, at_most=False))
    vertex = [row for row in report["undamped"] if row["case"] == "vertex4_flatfoldable"]
    rows.append(target("vertex: one evaluation, ns", vertex[0]["one evaluation ns"], 600.0, at_most=True))
    return rows


if __name__ == "__main__":
    main()
