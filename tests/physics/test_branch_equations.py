"""Where a start takes a branch of another rank, the equations of the first pass serve: as if they were derived anew."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import lamc
from lamc.codegen.cache import Cache
from lamc.codegen.emit import emit
from lamc.codegen.options import CompileOptions
from lamc.effects import BaseMotion, Gravity, TwistCompliance
from lamc.loops.at_start import drawn_loops
from lamc.mechanics.derive import derive
from lamc.mechanics.lower import lower
from lamc.mechanics.tangents import Columns
from lamc.mechanism.plan import plan
from lamc.pipeline import job, stages
from lamc.records.mechanism import Mechanism
from lamc.records.scene import Scene
from tests.physics.test_flat_sheets import loaded
from tests.support.ctools import needs_cc
from tests.support.fold_corpus import miura
from tests.support.sheets import sheet

pytestmark = needs_cc

UP = Gravity((0.0, 0.0, 9.81))


def flat(columns: int, rows: int) -> Mechanism:
    """Facets of 10 mm, all creases straight."""
    return sheet(1e-2 * np.array([[[j, i, 0.0] for j in range(columns + 1)] for i in range(rows + 1)]))


def along_the_lowest(mechanism: Mechanism) -> Mechanism:
    """With creases that push along the branch of least rank alone."""
    count, branches = drawn_loops(plan(mechanism))
    assert min(count.branch_ranks) < count.rank, "the pattern has branches of several ranks"
    branch = branches[count.branch_ranks.index(min(count.branch_ranks))]
    names = tuple(joint.name for joint in mechanism.joints)
    row = dict(zip(names, branch.row(names).tolist(), strict=True))
    joints = tuple(
        replace(
            joint,
            stiffness=1e-3 if abs(row[joint.name]) > 1e-9 else 0.0,
            rest_angle=0.3 * row[joint.name],
        )
        for joint in mechanism.joints
    )
    return replace(mechanism, joints=joints, scene=None)


def map_sheet(_: Path) -> tuple[Mechanism, Scene]:
    return flat(3, 2), Scene()


def wide_map(_: Path) -> tuple[Mechanism, Scene]:
    return flat(5, 2), Scene(effects=(UP,))


def miura_sheet(folder: Path) -> tuple[Mechanism, Scene]:
    return along_the_lowest(loaded(folder, miura(4, 5))), Scene()


def shaken(_: Path) -> tuple[Mechanism, Scene]:
    return flat(3, 2), Scene(effects=(Gravity(), BaseMotion(displacement=(0.0, 0.0, "1e-4*t^2"))))


SHEETS: dict[str, Callable[[Path], tuple[Mechanism, Scene]]] = {
    "map of 3 x 2": map_sheet,
    "map of 5 x 2": wide_map,
    "Miura": miura_sheet,
    "map on a base that moves": shaken,
}


@pytest.fixture
def passes(monkeypatch: pytest.MonkeyPatch) -> list[bool]:
    """Of each time that equations are derived, whether."""
    derived: list[bool] = []
    own = stages.equations_of

    def counted(*args: object) -> object:
        derived.append(True)
        return own(*args)  # type: ignore[arg-type]

    monkeypatch.setattr(job, "equations_of", counted)
    return derived


@pytest.mark.parametrize("name", SHEETS)
@pytest.mark.quick("map of 3 x 2", others="campaign")
def test_equations_on_a_branch_are_those_derived_for_it(
    name: str, tmp_path: Path, passes: list[bool]
) -> None:
    """C, numbers and digests, with powers, with derivatives and in single precision, byte for byte."""
    mechanism, scene = SHEETS[name](tmp_path)
    sim = lamc.compile(mechanism, scene)
    assert sim.loops.pushed is not None, "the start takes a branch of another rank"
    anew = derive(plan(mechanism), sim.effects, sim.loops, scene.inputs)
    kept = sim.equations
    assert len(passes) <= 1
    assert kept.loops == anew.loops
    assert kept.pattern == anew.pattern
    columns = Columns((next(p.name for p in anew.parameters if not p.is_input),))
    assert sim.program == lower(anew)
    for asked in ({}, {"energy_balance": True}, {"columns": columns}):
        one, other = lower(kept, **asked), lower(anew, **asked)
        assert (one.digest, one.structure) == (other.digest, other.structure)
        for precision in ("double", "float"):
            assert emit(one, precision) == emit(other, precision)


@pytest.mark.slow
def test_what_runs_on_a_branch_is_compiled_from_such_equations(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Both roads from empty caches make the same module and the same motion, also with the energy balance."""
    mechanism = along_the_lowest(loaded(tmp_path, miura(4, 4)))
    runs = []
    for reuse in (True, False):
        with monkeypatch.context() as patched:
            patched.setenv("LAMC_CACHE_DIR", str(tmp_path / f"cache{reuse}"))
            if not reuse:
                patched.setattr(job.Job, "on_branch", lambda of, loops: replace(of, branch=loops))
            sim = lamc.compile(mechanism, Scene())
            run = sim.run(0.05, rtol=1e-8, energy_balance=True)
            assert run.success, run.message
            runs.append((sim.structure, run.y.tobytes(), repr(run.energy_balance)))
    assert runs[0] == runs[1]


@pytest.mark.parametrize("precision", ["double", "float"])
@pytest.mark.quick("double")
def test_the_second_pass_derives_nothing(precision: str, tmp_path: Path, passes: list[bool]) -> None:
    sim = lamc.compile(
        flat(3, 2), options=CompileOptions(precision=precision), cache=Cache(tmp_path / "cache")
    )
    assert sim.loops.pushed is not None
    assert len(passes) == 1


def test_loops_that_yield_are_derived_for_their_own_count(tmp_path: Path, passes: list[bool]) -> None:
    """Their equations count them as they are derived: nothing is taken over."""
    strip = TwistCompliance(("s1_0",), width=1e-3, length=8e-3, thickness=5e-5, E=2e9, nu=0.3)
    scene = Scene(effects=(strip,))
    sim = lamc.compile(flat(3, 2), scene, cache=Cache(tmp_path / "cache"))
    assert len(passes) == (1 if sim.loops.pushed is None else 2)
    assert sim.equations.loops == derive(plan(sim.mechanism), sim.effects, sim.loops, {}).loops
