"""Names follow geometry: not the order of the input, and not its last bits."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from lamc.basics.errors import DesignError
from lamc.design.naming import BodyMark, JointMark, name_bodies, name_joints
from tests.support.quick import tries


def body(x: float, y: float = 0.0, *, fixed: bool = False, mass: float = 1.0) -> BodyMark:
    return BodyMark(fixed, np.array([x, y, 0.0]), mass, mass * np.eye(3))


def hinge(*ends: tuple[float, float]) -> JointMark:
    (x0, y0), (x1, y1) = ends
    return JointMark(np.array([x0, y0, 0.0]), np.array([x1, y1, 0.0]))


def test_bodies_are_numbered_from_left_to_right() -> None:
    assert name_bodies([body(3), body(0, fixed=True), body(1)]) == ("link_2", "ground", "link_1")


def test_several_fixed_bodies_are_numbered() -> None:
    marks = [body(3, fixed=True), body(0, fixed=True), body(1)]
    assert name_bodies(marks) == ("ground_2", "ground_1", "link_1")


def test_given_names_are_kept_and_rename_nothing_else() -> None:
    marks = [hinge((x, 0), (x, 1)) for x in (0.0, 1.0, 2.0)]
    assert name_joints(marks) == ("h1", "h2", "h3")
    assert name_joints(marks, [None, "knee", None]) == ("h1", "knee", "h3")
    assert name_bodies([body(0), body(1), body(2)], ["foot", None, None]) == ("foot", "link_2", "link_3")


def test_a_given_name_that_looks_made_up_is_not_used_twice() -> None:
    marks = [hinge((x, 0), (x, 1)) for x in (0.0, 1.0, 2.0)]
    assert name_joints(marks, [None, None, "h1"]) == ("h4", "h2", "h1")
    assert name_bodies([body(0, fixed=True), body(1)], [None, "ground"]) == ("ground_1", "ground")


def test_a_name_given_twice_is_refused() -> None:
    with pytest.raises(DesignError, match="two hinges are named 'a'"):
        name_joints([hinge((0, 0), (0, 1)), hinge((1, 0), (1, 1))], ["a", "a"])


def test_nothing_has_no_names() -> None:
    assert name_bodies([]) == ()
    assert name_joints([]) == ()


def test_concentric_bodies_are_told_apart_by_mass() -> None:
    assert name_bodies([body(0, mass=2.0), body(0, mass=1.0)]) == ("link_2", "link_1")


def test_crossing_hinges_are_told_apart_by_slope() -> None:
    along_x, along_y = hinge((-1, 0), (1, 0)), hinge((0, -1), (0, 1))
    assert name_joints([along_x, along_y]) == ("h2", "h1")
    assert name_joints([along_y, along_x]) == ("h1", "h2")


grid = st.lists(
    st.tuples(st.integers(0, 4), st.integers(0, 4), st.booleans()),
    min_size=1,
    max_size=12,
    unique_by=lambda p: p[:2],
)


@settings(max_examples=tries(100), deadline=None)
@given(grid, st.randoms(), st.floats(1e-6, 1e3))
def test_order_and_round_off_do_not_change_names(
    points: list[tuple[int, int, bool]], random: object, scale: float
) -> None:
    """Many bodies share an x or y exactly; noise of 1e-12 of the size must not decide between them."""
    clean = [body(scale * x / 3, scale * y / 3, fixed=f) for x, y, f in points]
    names = dict(zip(points, name_bodies(clean), strict=True))
    lines = dict(
        zip(
            points,
            name_joints(
                [hinge((scale * x, scale * y), (scale * x, scale * y + scale)) for x, y, _ in points]
            ),
            strict=True,
        )
    )
    shuffled = list(points)
    random.shuffle(shuffled)  # type: ignore[attr-defined]
    noise = np.random.default_rng(len(points)).uniform(-1e-12, 1e-12, (len(points), 2)) * scale
    noisy = [
        body(scale * x / 3 + dx, scale * y / 3 + dy, fixed=f)
        for (x, y, f), (dx, dy) in zip(shuffled, noise, strict=True)
    ]
    assert dict(zip(shuffled, name_bodies(noisy), strict=True)) == names
    moved = [
        hinge((scale * x + dx, scale * y), (scale * x + dx, scale * (y + 1) + dy))
        for (x, y, _), (dx, dy) in zip(shuffled, noise, strict=True)
    ]
    assert dict(zip(shuffled, name_joints(moved), strict=True)) == lines
