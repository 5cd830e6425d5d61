"""URDF read back: as XML by what its elements mean, and by MuJoCo's own loader."""

from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest

import lamc
from lamc.basics.errors import TopologyError, UnsupportedError
from lamc.export import urdf
from lamc.export.options import ExportOptions
from lamc.records.mechanism import Body, Joint, Mechanism
from lamc.reference.newton_euler import NewtonEuler
from tests.support.closed_mechanisms import closed_mechanism
from tests.support.engines import load, mujoco
from tests.support.every_effect import mechanism as two_links
from tests.support.floating import with_base
from tests.support.mechanisms import random_state, random_tree

GRAVITY = lamc.Gravity((0.0, 0.0, -9.81))  # MuJoCo's own where a model says nothing
BARE = lamc.Scene(effects=(GRAVITY, lamc.HingeDamping()))


def test_trees_accelerate_in_mujoco_as_they_do_in_lamc(tmp_path: Path) -> None:
    for n, kind in ((1, "space"), (6, "mixed"), (5, "laminate")):
        mechanism = random_tree(n, n, kind)
        model = load(urdf.files(mechanism, BARE, ExportOptions()), tmp_path / kind)
        data = mujoco.MjData(model)
        joints = tuple(joint.name for joint in mechanism.joints)
        assert list(model.dof_damping) == [mechanism.joint(model.joint(k).name).damping for k in range(n)]
        q, u = random_state(n, n)
        for k, name in enumerate(joints):
            index = model.joint(name).id
            data.qpos[model.jnt_qposadr[index]], data.qvel[model.jnt_dofadr[index]] = q[k], u[k]
        mujoco.mj_forward(model, data)
        expected = NewtonEuler(mechanism, BARE.effects or (), joints).acceleration(q, u)
        found = np.array([data.qacc[model.joint(name).dofadr[0]] for name in joints])
        # 1e-6: MuJoCo turns inertias to principal axes, in 3.3 to 1e-8, times the condition of M; that the file itself
        # is exact is the next test's
        assert np.abs(found - expected).max() < 1e-6 * np.abs(expected).max()


def test_links_have_the_masses_centres_and_inertias_of_the_bodies() -> None:
    mechanism = random_tree(5, 3, "space")
    root = ElementTree.fromstring(_text(urdf.files(mechanism, BARE, ExportOptions())))
    joints = {joint.find("child").get("link"): joint for joint in root.findall("joint")}  # type: ignore[union-attr]
    for body in mechanism.bodies:
        link = next(each for each in root.findall("link") if each.get("name") == body.name)
        place, at = np.zeros(3), body.name
        while at in joints:  # from the link to the world: all turns are nil as drawn
            place += _vector(joints[at].find("origin"))
            at = joints[at].find("parent").get("link")  # type: ignore[union-attr,assignment]
        assert at == "world"
        if not body.fixed:
            inertial = link.find("inertial")
            assert inertial is not None
            # 1e-15 m per joint on the way
            assert np.allclose(place + _vector(inertial.find("origin")), body.com, rtol=0.0, atol=1e-14)
            assert float(inertial.find("mass").get("value")) == body.mass  # type: ignore[union-attr,arg-type]
            moments = inertial.find("inertia")
            assert moments is not None
            found = [[float(moments.get(f"i{min(a, b)}{max(a, b)}", "")) for b in "xyz"] for a in "xyz"]
            assert np.array_equal(found, 0.5 * (body.inertia + body.inertia.T))


def test_limits_are_the_joints_and_joints_without_turn_for_ever() -> None:
    limited = urdf.files(two_links(), lamc.Scene(effects=(lamc.JointLimits(),)), ExportOptions())
    joint = ElementTree.fromstring(_text(limited)).find("joint[@name='h1']")
    assert joint is not None
    assert joint.get("type") == "revolute"
    limit = joint.find("limit")
    assert limit is not None
    assert [float(limit.get(side, "")) for side in ("lower", "upper")] == [-1.0, 1.2]
    free = ElementTree.fromstring(_text(urdf.files(two_links(), BARE, ExportOptions()))).find(
        "joint[@name='h1']"
    )
    assert free is not None
    assert free.get("type") == "continuous"


def test_loops_are_refused_with_the_joints_that_close_them() -> None:
    mechanism = closed_mechanism("planar", 1).mechanism
    with pytest.raises(TopologyError, match=r"joint '\w+' closes a loop: .*--to mjcf") as refusal:
        urdf.files(mechanism, lamc.Scene(), ExportOptions(lossy=True))
    simulator = lamc.compile(mechanism)
    assert all(repr(name) in str(refusal.value) for name in simulator.cut_joints)


def test_springs_are_refused_unless_they_may_be_lost() -> None:
    with pytest.raises(UnsupportedError, match=r"the stiffness of hinges 'h1', 'h2'.*lossy.*--to mjcf"):
        urdf.files(two_links(), lamc.Scene(), ExportOptions())
    files = urdf.files(two_links(), lamc.Scene(), ExportOptions(lossy=True))
    assert "- the stiffness of hinges 'h1', 'h2'" in files["README.md"].decode()


def test_a_floating_base_is_the_root() -> None:
    mechanism = with_base(random_tree(3, 2, "space"))
    scene = lamc.Scene(effects=(GRAVITY, lamc.FreeBase()))
    root = ElementTree.fromstring(_text(urdf.files(mechanism, scene, ExportOptions())))
    children = {joint.find("child").get("link") for joint in root.findall("joint")}  # type: ignore[union-attr]
    (base,) = [link for link in root.findall("link") if link.get("name") not in children]
    assert base.get("name") == "ground"
    assert float(base.find("inertial/mass").get("value")) == 2.0  # type: ignore[union-attr,arg-type]


def test_hostile_names_are_told_apart(tmp_path: Path) -> None:
    bodies = (
        Body('g"<', fixed=True),
        Body("a<b", 1.0, (1, 0, 0), np.eye(3)),
        Body("a>b", 1.0, (2, 0, 0), np.eye(3)),
    )
    joints = (
        Joint("g_fixed", 'g"<', "a<b", (0, 0, 0), (0, 1, 0)),
        Joint("🦋", "a<b", "a>b", (1, 0, 0), (0, 1, 0)),
    )
    files = urdf.files(Mechanism(bodies, joints, name="💥 & co"), BARE, ExportOptions())
    root = ElementTree.fromstring(_text(files))
    for tag in ("link", "joint"):
        names = [each.get("name") for each in root.findall(tag)]
        assert len(set(names)) == len(names)
    assert ElementTree.fromstring(files["package.xml"].decode()).find("name").text == "co"  # type: ignore[union-attr]
    assert load(files, tmp_path).njnt == 2


def _text(files: dict[str, bytes]) -> str:
    (text,) = (content for name, content in files.items() if name.endswith(".urdf"))
    return text.decode()


def _vector(element: "ElementTree.Element | None") -> "np.typing.NDArray[np.float64]":
    """xyz of an origin; zero where there is none."""
    return np.zeros(3) if element is None else np.array([float(x) for x in element.get("xyz", "").split()])
