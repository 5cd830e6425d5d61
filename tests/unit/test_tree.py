"""The spanning tree: least depth, independence of order, frames that reproduce the drawing, refusals by name."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from lamc.basics.errors import TopologyError
from lamc.mechanism.hinge_frames import cross
from lamc.mechanism.plan import plan
from lamc.mechanism.tree import WORLD, Link, Tree
from lamc.records.mechanism import Body, Joint, Mechanism
from tests.support.mechanisms import Array, chain, random_tree, trees
from tests.support.quick import tries


def body(name: str, *com: float) -> Body:
    return Body(name, 1.0, np.array(com), np.diag([0.1, 0.2, 0.25]))


def hinge(name: str, parent: str, child: str, point: tuple[float, ...], axis: tuple[float, ...]) -> Joint:
    return Joint(name, parent, child, np.array(point, dtype=float), np.array(axis, dtype=float))


def star(order: tuple[int, ...] = (0, 1, 2)) -> Mechanism:
    """Ground with three flaps along x."""
    bodies = [body(f"flap{i}", i, 1.0, 0.0) for i in range(3)]
    joints = [hinge(f"j{i}", "ground", f"flap{i}", (i, 0, 0), (1, 0, 0)) for i in range(3)]
    return Mechanism(
        (*(bodies[i] for i in order), Body("ground", fixed=True)), tuple(joints[i] for i in reversed(order))
    )


def rebuilt(tree: Tree) -> list[tuple[Array, Array]]:
    """World frame and origin of each link as drawn, from the numbers that the equations use."""

    def rz(c: float, s: float) -> Array:
        return np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])

    def rx(c: float, s: float) -> Array:
        return np.array([[1, 0, 0], [0, c, -s], [0, s, c]])

    frames: list[tuple[Array, Array]] = []
    for link in tree.links:
        if link.parent == WORLD:
            frames.append((link.frame, link.origin))
            continue
        parent_frame, parent_origin = frames[link.parent]
        own = rz(math.cos(link.angle_offset), math.sin(link.angle_offset))
        frames.append(
            (
                parent_frame @ rz(*link.twist) @ rx(*link.fold) @ own,
                parent_origin + parent_frame @ link.offset,
            )
        )
    return frames


def shape(tree: Tree) -> list[tuple[str, str, int]]:
    return [(link.joint.name, link.body.name, link.parent) for link in tree.links]


# ---- topology -------------------------------------------------------------------------------------------------


def test_parents_precede_children_and_siblings_follow_their_place() -> None:
    assert shape(plan(star())) == [("j0", "flap0", -1), ("j1", "flap1", -1), ("j2", "flap2", -1)]


@pytest.mark.parametrize("order", [(0, 1, 2), (2, 1, 0), (1, 2, 0)])
def test_order_of_the_input_does_not_matter(order: tuple[int, ...]) -> None:
    assert shape(plan(star(order))) == shape(plan(star()))


def test_names_decide_where_geometry_does_not() -> None:
    joints = [hinge(name, "ground", f"arm_{name}", (0, 0, 0), (0, 0, 1)) for name in ("b", "a", "c")]
    bodies = [body(f"arm_{name}", 1.0, 0.0, 0.0) for name in ("c", "b", "a")]
    tree = plan(Mechanism((Body("ground", fixed=True), *bodies), tuple(joints)))
    assert tree.joint_names == ("a", "b", "c")


@settings(max_examples=tries(30), deadline=None)
@given(mechanism=trees(12), seed=st.integers(0, 2**31))
def test_any_shuffling_gives_the_same_tree(mechanism: Mechanism, seed: int) -> None:
    rng = np.random.default_rng(seed)
    shuffled = replace(
        mechanism,
        bodies=tuple(mechanism.bodies[i] for i in rng.permutation(len(mechanism.bodies))),
        joints=tuple(mechanism.joints[i] for i in rng.permutation(len(mechanism.joints))),
    )
    first, second = plan(mechanism), plan(shuffled)
    assert shape(first) == shape(second)
    for a, b in zip(first.links, second.links, strict=True):
        assert (a.frame == b.frame).all()
        assert (a.offset == b.offset).all()
        assert (a.twist, a.fold, a.angle_offset) == (b.twist, b.fold, b.angle_offset)


@pytest.mark.parametrize("n", [1, 2, 7])
def test_depth_of_a_chain_held_at_one_end_and_of_a_star(n: int) -> None:
    assert plan(chain(n)).depth == n
    assert plan(star()).depth == 1


def test_each_body_hangs_from_the_world_by_the_shortest_way() -> None:
    # Five bodies between two fixed ones: the middle one is three hinges from either side.
    names = ["left", *(f"b{i}" for i in range(4)), "right"]
    bodies = [Body("left", fixed=True), *(body(f"b{i}", i + 0.5, 0, 0) for i in range(4))]
    joints = [hinge(f"h{i}", names[i], names[i + 1], (i, 0, 0), (0, 1, 0)) for i in range(4)]
    tree = plan(Mechanism(tuple(bodies), tuple(joints)))
    assert tree.depth == 4
    second = Mechanism(
        (*bodies, Body("right", fixed=True)),
        (
            *joints[:2],
            *[
                hinge("h3", "b2", "b3", (3, 0, 0), (0, 1, 0)),
                hinge("h4", "b3", "right", (4, 0, 0), (0, 1, 0)),
            ],
        ),
    )
    assert plan(second).depth == 2
    assert [link.parent for link in plan(second).links].count(WORLD) == 2


# ---- frames ---------------------------------------------------------------------------------------------------


@settings(max_examples=tries(40), deadline=None)
@given(mechanism=trees(15))
def test_frames_reproduce_the_drawing(mechanism: Mechanism) -> None:
    tree = plan(mechanism)
    for link, (frame, origin) in zip(tree.links, rebuilt(tree), strict=True):
        # a dozen rotations one after the other, lengths of some m (an origin may be slid by three sizes)
        assert np.abs(frame - link.frame).max() < 1e-13
        assert np.abs(origin - link.origin).max() < 1e-11
        assert np.abs(link.frame.T @ link.frame - np.eye(3)).max() < 1e-14
        assert np.linalg.det(link.frame) == pytest.approx(1.0)
        sign = link.angle_sign if link.joint.child == link.body.name else -link.angle_sign
        assert np.abs(link.frame[:, 2] - sign * link.joint.axis).max() < 1e-12  # z along the hinge
        assert np.abs(np.cross(link.origin - link.joint.point, link.joint.axis)).max() < 1e-12  # on its line
        assert np.abs(frame @ link.com + origin - link.body.com).max() < 1e-11
        assert np.abs(link.frame @ link.inertia @ link.frame.T - link.body.inertia).max() < 1e-13


def test_hinges_of_one_plate_need_one_fold_and_one_offset() -> None:
    """The reason for the choice of frames: coplanar hinge lines cost a turn about x and one component."""
    tree = plan(chain(6, "laminate", seed=2))
    for link in tree.links[1:]:
        assert link.twist == (1.0, 0.0)
        # slid to where the lines meet, unless that is far away: then two components
        assert np.count_nonzero(link.offset) <= 2
    assert sum(np.count_nonzero(link.offset) == 1 for link in tree.links[1:]) >= 3


def test_parallel_hinges_share_a_carrier_whichever_way_they_are_drawn() -> None:
    joints = [
        hinge("h0", "ground", "a", (0, 0, 0), (0, 1, 0)),
        hinge("h1", "a", "b", (1, 0, 0), (0, -1, 0)),
        hinge("h2", "c", "b", (2, 0, 0), (0, 1, 0)),
    ]
    bodies = [Body("ground", fixed=True), *(body(n, i + 0.5, 0, 0) for i, n in enumerate("abc"))]
    links = plan(Mechanism(tuple(bodies), tuple(joints))).links
    assert [link.parallel for link in links] == [False, True, True]
    # h1 is drawn against the others; h2 is drawn with them, but from the tip to the root.
    assert [link.angle_sign for link in links] == [1, -1, -1]
    assert all((link.frame[:, 2] == links[0].frame[:, 2]).all() for link in links)


def test_a_reversed_joint_turns_the_other_way() -> None:
    forward = hinge("h", "ground", "arm", (0, 0, 0), (0, 0, 1))
    backward = hinge("h", "arm", "ground", (0, 0, 0), (0, 0, 1))
    bodies = (Body("ground", fixed=True), body("arm", 1, 0, 0))
    (a,), (b,) = (plan(Mechanism(bodies, (j,))).links for j in (forward, backward))
    assert (a.frame[:, 2] * a.angle_sign == -b.frame[:, 2] * b.angle_sign).all()


@pytest.mark.parametrize("tilt", [0.3, 1.5, math.pi / 2, 3.0])
def test_a_second_hinge_out_of_the_plane_takes_a_twist(tilt: float) -> None:
    """x is normal to the body's own hinge and its first child's; other children need not lie in that plane."""
    axis = (math.sin(tilt), 0.0, math.cos(tilt))
    joints = (
        hinge("h0", "ground", "a", (0, 0, 0), (0, 0, 1)),
        hinge("h1", "a", "b", (0.2, 1.0, 0.4), axis),
        hinge("h2", "a", "c", (0.9, 1.5, 1.0), (0.48, 0.6, 0.64)),
    )
    bodies = (Body("ground", fixed=True), body("a", 0, 0.5, 0), body("b", 0.3, 1.2, 0.5), body("c", 1, 1, 2))
    tree = plan(Mechanism(bodies, joints))
    assert any(link.twist != (1.0, 0.0) for link in tree.links)
    for link, (frame, origin) in zip(tree.links, rebuilt(tree), strict=True):
        assert np.abs(frame - link.frame).max() < 1e-14
        assert np.abs(origin - link.origin).max() < 1e-14


def nearly_parallel(angle: float) -> Link:
    joints = (
        hinge("h0", "ground", "a", (0, 0, 0), (0, 0, 1)),
        hinge("h1", "a", "b", (1, 0, 0), (math.sin(angle), 0.0, math.cos(angle))),
    )
    return plan(
        Mechanism((Body("ground", fixed=True), body("a", 0.5, 0, 0), body("b", 1.5, 0, 0)), joints)
    ).links[1]


@pytest.mark.parametrize("angle", [0.0, 1e-14, 1e-10, 1e-7, 1e-5, 1e-3, 0.1])
def test_nearly_parallel_hinges_keep_short_levers(angle: float) -> None:
    link = nearly_parallel(angle)
    size = math.hypot(1.0, 0.5)
    assert np.linalg.norm(link.offset) <= 1.0 + 3.0 * 1.5 * size  # tree.MAX_SLIDE sizes at most
    assert link.parallel == (angle < 1e-12)


# ---- refusals -------------------------------------------------------------------------------------------------


def test_a_loop_is_cut_at_the_joint_furthest_from_the_world() -> None:
    mechanism = chain(3, "laminate")
    closing = Joint("closing", "body2", "ground", axis=np.array([1.0, 0, 0]))
    tree = plan(replace(mechanism, joints=(*mechanism.joints, closing)))
    assert len(tree.links) == 3
    assert len(tree.cuts) == 1
    assert tree.depth == 2


def test_two_hinges_between_the_same_bodies_are_a_loop() -> None:
    mechanism = chain(1)
    second = replace(mechanism.joints[0], name="second", point=np.array([0.5, 0, 0]))
    tree = plan(replace(mechanism, joints=(*mechanism.joints, second)))
    assert len(tree.cuts) == 1


def test_a_body_without_a_way_to_the_world_is_refused_by_name() -> None:
    mechanism = chain(2)
    lost = (*mechanism.bodies, body("adrift", 5, 5, 5), body("apart", 6, 5, 5))
    with pytest.raises(TopologyError, match="body 'adrift' and 1 more has no path of hinges to a fixed body"):
        plan(replace(mechanism, bodies=lost))


def test_a_hinge_between_two_fixed_bodies_is_refused_by_name() -> None:
    mechanism = chain(1)
    bodies = (*mechanism.bodies, Body("wall", fixed=True))
    with pytest.raises(TopologyError, match="joint 'stuck' joins two fixed bodies, 'ground' and 'wall'"):
        plan(replace(mechanism, bodies=bodies, joints=(*mechanism.joints, Joint("stuck", "ground", "wall"))))


def test_nothing_but_the_world_is_a_tree() -> None:
    tree = plan(Mechanism((Body("ground", fixed=True),), ()))
    assert tree.links == ()
    assert tree.depth == 0


def test_a_random_tree_has_every_body_once() -> None:
    mechanism = random_tree(25, seed=4)
    names = [link.body.name for link in plan(mechanism).links]
    assert sorted(names) == sorted(b.name for b in mechanism.bodies if not b.fixed)


def test_cross_products_are_numpys_to_the_bit() -> None:
    pairs = np.random.default_rng(5).normal(size=(200, 2, 3)) * 10.0 ** np.arange(-9, 11, 0.1)[:, None, None]
    for a, b in pairs:
        assert cross(a, b).tobytes() == np.cross(a, b).tobytes()
