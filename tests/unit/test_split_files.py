"""Splitting of drawings as they come from popupCAD, against the same devices built by hand."""

from pathlib import Path

import numpy as np
import pytest

from lamc.design.split import split
from lamc.readers.load import load
from lamc.records.design import Design
from lamc.records.mechanism import Mechanism
from tests.support.laminates import flaps, pendulum


def test_popupcad_drawing_splits_like_the_same_one_built_by_hand(shared: Path) -> None:
    design = load(shared / "designs" / "popupcad" / "pendulum.cad")
    assert isinstance(design, Design)
    mechanism = split(design)
    by_hand = split(pendulum())
    for read, built in zip(mechanism.bodies, by_hand.bodies, strict=True):
        assert read.mass == pytest.approx(built.mass, abs=1e-12)
        np.testing.assert_allclose(read.com, built.com, rtol=0, atol=1e-12)
    for drawn, made in zip(mechanism.joints, by_hand.joints, strict=True):
        assert (drawn.name, drawn.parent, drawn.child) == (made.name, made.parent, made.child)
        np.testing.assert_allclose(drawn.axis, made.axis, rtol=0.0, atol=1e-15)


@pytest.mark.parametrize("file", ["flaps.joints", "flaps_old.joints"])
def test_exported_joint_definition_is_what_splitting_gives(file: str, shared: Path) -> None:
    """popupCAD's own export of the cut device against our cut of the drawn one."""
    exported, ours = load(shared / "designs" / file), split(flaps())
    assert isinstance(exported, Mechanism)
    assert [b.fixed for b in exported.bodies] == [b.fixed for b in ours.bodies]
    for theirs, body in zip(exported.bodies, ours.bodies, strict=True):
        assert theirs.mass == pytest.approx(body.mass, rel=1e-12)
        # The file's coordinates have 16 decimals: round-off of 0.06 m.
        np.testing.assert_allclose(theirs.com, body.com, rtol=0, atol=1e-15)
    for theirs, joint in zip(exported.joints, ours.joints, strict=True):
        assert (theirs.name, theirs.parent, theirs.child) == (joint.name, joint.parent, joint.child)
        np.testing.assert_allclose(theirs.point, joint.point, rtol=0, atol=1e-15)
        np.testing.assert_allclose(theirs.axis, joint.axis, rtol=0, atol=1e-15)
        assert (theirs.stiffness, theirs.damping) == (joint.stiffness, joint.damping)
        np.testing.assert_allclose(theirs.limits, joint.limits, rtol=1e-15)
        assert theirs.rest_angle == pytest.approx(joint.rest_angle, rel=1e-15)
