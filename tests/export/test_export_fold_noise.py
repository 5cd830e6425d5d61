"""Folded frames that differ by round-off read as one device: nothing is decided by the last digits of a place."""

import json
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
import shapely

from lamc.readers.fold_faces import overlap
from lamc.records.mechanism import Mechanism
from tests.export.test_export_fold import exported, load
from tests.support import fold_corpus as corpus

SHEETS = [
    lambda: corpus.miura(3, 3),
    corpus.waterbomb,
    lambda: corpus.yoshimura(3, 4),
    corpus.box_net,
    lambda: corpus.folded_pair(0.7),
]
NAMES = ["miura", "waterbomb", "yoshimura", "net", "folded"]
NOISE = 10.0 ** np.linspace(-15.0, -9.0, 20)  # of the sheet's size, one for each seed


def told(made: Mechanism) -> tuple[object, ...]:
    assert made.scene is not None
    return (
        [(body.name, body.fixed) for body in made.bodies],
        [(joint.name, joint.parent, joint.child) for joint in made.joints],
        sorted(made.scene.angles),
    )


@pytest.mark.parametrize("own", [True, False], ids=["own", "plain"])
@pytest.mark.parametrize("make", SHEETS, ids=NAMES)
@pytest.mark.quick("waterbomb-plain", "miura-own", "yoshimura-own", others="campaign")
def test_noise_in_a_folded_frame_is_noise_in_its_mechanism(
    tmp_path: Path, make: Callable[[], corpus.Data], own: bool
) -> None:
    file, _ = exported(tmp_path, load(corpus.write(tmp_path / "sheet.fold", make())))
    data = json.loads(file.read_text(encoding="utf-8"))
    last = {**data, **data["file_frames"][-1], "frame_inherit": False, "file_frames": []}
    left_out = ("lamc:edges_hinge", "edges_foldAngle")
    bare = {k: v for k, v in last.items() if k not in left_out and (own or not k.startswith("lamc:"))}
    places = np.array(bare["vertices_coords"])
    size = float(np.ptp(places, axis=0).max())
    first = load(corpus.write(tmp_path / "first.fold", bare))
    assert first.scene is not None
    for seed, noise in enumerate(NOISE):
        moved = places + noise * size * np.random.default_rng(seed).uniform(-1.0, 1.0, places.shape)
        made = load(corpus.write(tmp_path / "moved.fold", {**bare, "vertices_coords": moved.tolist()}))
        assert made.scene is not None
        assert told(made) == told(first)
        # Facets are a sixth of the sheet and more: their directions change by some ten times the noise, and sheets
        # add them up; the places of the first reading have some 1e-15 of round-off of their own.
        most = 100.0 * (noise + 1e-15)
        for joint in made.joints:
            same = first.joint(joint.name)
            np.testing.assert_allclose(joint.point, same.point, rtol=0.0, atol=most * size)
            np.testing.assert_allclose(joint.axis, same.axis, rtol=0.0, atol=most)
        for name, angle in made.scene.angles.items():
            assert angle == pytest.approx(first.scene.angles[name], rel=0.0, abs=most)


# m; triangles of 30 mm by 18 mm, as frames are laid flat. Overlays in floating point have all of the smaller one for
# the first pair, which has a side in common, and nothing for the second one, which is a triangle twice.
BESIDE = (
    [
        (0.06, -5.204170427930421e-18),
        (0.08999999999999996, -1.3704315460216776e-16),
        (0.07500000000000001, 0.017999999999999905),
    ],
    [
        (0.06, -5.204170427930421e-18),
        (0.07500000000000001, 0.01799999999999991),
        (0.045, 0.017999999999999995),
    ],
)
TWICE = (
    [
        (0.06, -2.0854762181707815e-17),
        (0.09000000000000001, -5.4073483837719e-18),
        (0.07500000000000001, 0.017999999999999967),
    ],
    [
        (0.09000000000000001, 4.449965124560834e-19),
        (0.07500000000000001, 0.017999999999999967),
        (0.06000000000000001, -1.9055536832321837e-17),
    ],
)


@pytest.mark.parametrize("far", [0.0, 1.0, 1e3])
def test_facets_that_all_but_share_a_side_overlap_by_what_they_do(far: float) -> None:
    beside, twice = ([shapely.Polygon(np.array(ring) + far) for ring in pair] for pair in (BESIDE, TWICE))
    assert overlap(beside) is None
    assert overlap(twice, 0.99) == (0, 1)


def test_a_true_overlap_is_told_whatever_the_noise() -> None:
    """A triangle over a hundredth of its neighbour's height, at noises of round-off and more."""
    ring = np.array([[0.06, 0.0], [0.09, 0.0], [0.075, 0.018]])
    over = np.array([[0.06, 0.00018], [0.09, 0.00018], [0.075, -0.018]])
    for seed, noise in enumerate(NOISE):
        moved = 0.03 * noise * np.random.default_rng(seed).uniform(-1.0, 1.0, (2, 3, 2))
        pair = [shapely.Polygon(ring + moved[0]), shapely.Polygon(over + moved[1])]
        assert overlap(pair, 1e-2) == (0, 1)
        assert overlap(pair, 3e-2) is None
