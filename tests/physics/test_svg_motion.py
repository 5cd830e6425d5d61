"""A Miura drawn as SVG moves as the one from FOLD, however its lines are written."""

import json
import math
import warnings
from pathlib import Path

import pytest

import lamc
from lamc.basics.errors import DesignWarning
from lamc.records.mechanism import Mechanism
from tests.physics.test_fold_motion import CREASE, DENSITY, THICKNESS, by_hand, load
from tests.support import fold_corpus, svg_corpus
from tests.support.ctools import needs_cc
from tests.support.same_motion import assert_same_motion

pytestmark = needs_cc


def pattern() -> fold_corpus.Data:
    data = fold_corpus.miura(3, 3)
    data["edges_foldAngle"] = [{"M": -60.0, "V": 60.0}.get(kind) for kind in data["edges_assignment"]]
    return data


@pytest.mark.parametrize("way", svg_corpus.WAYS)
@pytest.mark.quick("groups", "classes", others="campaign")
def test_a_miura_from_svg_moves_as_one_from_fold_and_yaml(tmp_path: Path, way: str) -> None:
    (tmp_path / "miura.yaml").write_text(json.dumps(by_hand()))
    hand = lamc.load(tmp_path / "miura.yaml")
    fold = load(tmp_path / "miura.fold", pattern(), fixed=(0.012, 0.005))
    file = svg_corpus.write(tmp_path / "miura.svg", pattern(), way, head=svg_corpus.DOCTYPE)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DesignWarning)
        drawn = lamc.load(
            file, card=lamc.Card(THICKNESS, DENSITY), crease=CREASE, fixed=(0.012, 0.005), heal=0.0
        )
    assert isinstance(hand, Mechanism)
    assert isinstance(drawn, Mechanism)
    assert_same_motion(hand, fold, drawn)


@pytest.mark.parametrize("pattern_name", ["miura", "waterbomb", "yoshimura", "kresling", "box"])
@pytest.mark.quick("miura", "waterbomb", "box")
def test_every_pattern_folds_towards_its_angles(tmp_path: Path, pattern_name: str) -> None:
    """Stored energy falls: springs do the folding, and the damped sheet comes nearer to where they rest."""
    data = {
        "miura": fold_corpus.miura(2, 2),
        "waterbomb": fold_corpus.waterbomb(),
        "yoshimura": fold_corpus.yoshimura(2, 2),
        "kresling": fold_corpus.kresling(2, 2),
        "box": fold_corpus.box_net(),
    }[pattern_name]
    data["edges_foldAngle"] = [{"M": -45.0, "V": 45.0}.get(kind) for kind in data["edges_assignment"]]
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DesignWarning)
        drawn = lamc.load(svg_corpus.write(tmp_path / "sheet.svg", data, "styles"))
    assert isinstance(drawn, Mechanism)
    run = lamc.compile(drawn, lamc.Scene(without=("gravity",))).run(t_end=0.5)
    assert run.success, run.message

    def stored(k: int) -> float:
        return sum(0.5 * j.stiffness * (run.angle(j.name)[k] - j.rest_angle) ** 2 for j in drawn.joints)

    assert [abs(joint.rest_angle) for joint in drawn.joints] == pytest.approx(
        [math.pi / 4] * len(drawn.joints)
    )
    assert stored(-1) < 0.9 * stored(0)  # a waterbomb cannot come to 45 degrees everywhere
