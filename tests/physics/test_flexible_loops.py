"""Loops in which links bend: what closure asks of them, a run to its end, the rigid limit, independent cross-checks."""

from dataclasses import replace
from importlib.resources import files

import numpy as np
import pytest

import lamc
from lamc import Design, FlexibleLinks, FreeBase, Simulator
from lamc.readers.load import load_text
from lamc.records.effect import Effect
from lamc.reference import check
from tests.support.ctools import needs_cc

pytestmark = needs_cc


def four_bar(*added: Effect, moduli: str = "GPa") -> Simulator:
    """A plane four-bar of boards: a shelf on an arm and a link, let go at 20 degrees. moduli: their unit."""
    text = (files("lamc.examples") / "four_bar.yaml").read_text(encoding="utf-8")
    design = load_text(text.replace("GPa", moduli), "four_bar.yaml")
    assert isinstance(design, Design)
    return lamc.compile(design, replace(design.scene, added=added))


@pytest.mark.parametrize("bodies", [("arm",), ("arm", "link")])
@pytest.mark.quick("bodies0", others="campaign")
def test_a_plane_loop_asks_of_each_bending_link_not_to_twist(bodies: tuple[str, ...]) -> None:
    """Two equations hold a plane loop in its plane, one tells an angle by the others, and there is one more for each
    link that could twist its axes out of parallel.
    Were it the rank of deflections as large as the mechanism, all positions of the motion would pass for singular, and
    a run would end among the first of them."""
    sim = four_bar(FlexibleLinks(bodies=bodies))
    assert len(sim.rates) - sim.freedoms == 3 + len(bodies)
    result = sim.run(0.05, rtol=1e-6)
    assert result.success, result.message
    assert result.t[-1] == 0.05


@pytest.mark.slow
def test_stiff_links_of_a_loop_are_rigid_ones() -> None:
    """E times 1e6: boards that sag by some 1e-3 of their length, with the shelf on them, sag by 1e-9. The limit is for
    what the integrator is off, at 1e-8 in each step."""
    stiff = four_bar(FlexibleLinks(bodies=("arm",), modes=2, damping_ratio=0.5), moduli="PPa")
    times = np.linspace(0.0, 0.05, 5)
    bent = stiff.run(0.05, t_eval=times, rtol=1e-8, atol=1e-10, integrator="radau5")
    rigid = four_bar().run(0.05, t_eval=times, rtol=1e-10, atol=1e-12)
    assert bent.success, bent.message
    for hinge in ("arm", "arm_shelf", "link", "link_shelf"):
        assert bent.angle(hinge) == pytest.approx(rigid.angle(hinge), abs=1e-6)


@pytest.mark.parametrize("base", [(), (FreeBase(),)])
@pytest.mark.ci("base1")
@pytest.mark.slow
def test_a_loop_whose_links_bend_moves_as_the_independent_cross_check_says(base: tuple[Effect, ...]) -> None:
    """Also at the start, where stiff modes would show any move by a last digit as an acceleration."""
    report = check(four_bar(FlexibleLinks(bodies=("arm", "link")), *base), states=4, t_end=0.05)
    assert report.passed, report.table()
    assert not any("did not reach" in note for note in report.notes), report.notes
