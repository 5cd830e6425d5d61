"""Names that a design does not have are reported, in trees, in loops and on floating bases: never a bug of lamc's."""

from collections.abc import Iterator, Mapping
from dataclasses import fields, replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner

import lamc
from lamc import examples
from lamc.basics.checks import did_you_mean
from lamc.basics.errors import LamcError
from lamc.cli import main
from lamc.records.effect import Effect
from lamc.records.mechanism import Body, Joint, Mechanism
from tests.support.every_effect import SAMPLES, mechanism

UNKNOWN = "nosuch"


def loop() -> Mechanism:
    """The bodies and joints of `mechanism()`, all axes parallel, closed to a square by a third link."""
    tree = mechanism()
    values = {"stiffness": 0.7, "damping": 0.03, "rest_angle": 0.2, "limits": (-1.0, 1.2)}
    places = {
        "h1": ("ground", "a", 0, 0),
        "h2": ("a", "b", 1, 0),
        "h3": ("b", "c", 1, 1),
        "h4": ("ground", "c", 0, 1),
    }
    joints = tuple(
        Joint(name, parent, child, (float(x), 0.0, float(z)), (0.0, 1.0, 0.0), **values)
        for name, (parent, child, x, z) in places.items()
    )
    third = Body("c", 1.0, (0.5, 0.0, 1.0), np.diag([0.01, 0.09, 0.1]))
    return Mechanism((*tree.bodies, third), joints, name="square")


def misnamed(value: Any, known: frozenset[str]) -> Iterator[Any]:
    """`value` with one of the names in it unknown, one after the other."""
    if isinstance(value, str):
        if value in known:
            yield UNKNOWN
    elif isinstance(value, Mapping):
        for name in value:
            if name in known:
                yield {UNKNOWN if key == name else key: each for key, each in value.items()}
    elif isinstance(value, tuple):
        for k, each in enumerate(value):
            for other in misnamed(each, known):
                yield (*value[:k], other, *value[k + 1 :])


def cases() -> list[Any]:
    """Every effect of lamc's with every name of a joint or body in it unknown."""
    known = frozenset(each.name for each in (*mechanism().bodies, *mechanism().joints))
    return [
        pytest.param(replace(effect, **{field.name: other}), id=f"{name}.{field.name}-{k}")  # type: ignore[type-var]
        for name, effect in SAMPLES.items()
        for field in fields(effect)  # type: ignore[arg-type]
        for k, other in enumerate(misnamed(getattr(effect, field.name), known))
    ]


@pytest.mark.parametrize("kind", ["tree", "loop", "floating"])
@pytest.mark.parametrize("effect", cases())
def test_an_effect_that_names_what_is_not_there_is_reported(effect: Effect, kind: str) -> None:
    made = loop() if kind == "loop" else mechanism()
    others = (lamc.FreeBase(),) if kind == "floating" else ()
    with pytest.raises(LamcError, match=rf"'{UNKNOWN}'") as caught:
        lamc.compile(made, lamc.Scene(effects=[effect, *others]))
    names = [each.name for each in (*made.bodies, *made.joints)]
    assert any(name in caught.value.message.split(UNKNOWN, 1)[1] for name in names)  # the way out


def test_there_is_a_case_of_every_effect_that_names_something() -> None:
    assert len(cases()) >= 15


BAD_SCENES = {
    "angles: {nosuch: 5 deg}": "'nosuch'",
    "rates: {nosuch: 5 deg/s}": "'nosuch'",
    "outputs: [nosuch]": "'nosuch'",
    "outputs: [nosuch.x]": "'nosuch.x'",
    "outputs: [{name: tip, body: nosuch, point: [0 mm, 0 mm, 0 mm]}]": "'nosuch'",
    "with: {torque: {torques: {nosuch: 1 N*mm}}}": "'nosuch'",
    "inputs: {nosuch: 0 N*mm}": "'nosuch'",
}


@pytest.mark.parametrize("example", ["flaps", "four_bar", "crawler", "waterbomb"])
@pytest.mark.parametrize("text", BAD_SCENES)
def test_a_scene_that_names_what_is_not_there_is_reported_with_its_line(
    example: str, text: str, tmp_path: Path
) -> None:
    scene = tmp_path / "s.yaml"
    scene.write_text(f"# a scene\n{text}\n")
    given = ["run", str(examples.path(example)), "--scene", str(scene), "--out", str(tmp_path / "o")]
    reported = CliRunner().invoke(main, [*given, "--quiet"])
    assert reported.exit_code == 2, reported.output
    assert f"{scene}:2:" in reported.output
    assert BAD_SCENES[text] in reported.output
    assert not (tmp_path / "o").exists()


@pytest.mark.parametrize("option", ["--angle", "--rate"])
def test_options_that_name_what_is_not_there_are_reported(option: str, tmp_path: Path) -> None:
    given = ["run", str(examples.path("four_bar")), option, "nosuch=0.1", "--out", str(tmp_path / "o")]
    reported = CliRunner().invoke(main, given)
    assert reported.exit_code == 2, reported.output
    assert "'nosuch'" in reported.output


@pytest.mark.parametrize("what", ["angles", "rates"])
def test_python_is_told_as_well(what: str) -> None:
    for made in (mechanism(), loop()):
        for effects in ([], [lamc.FreeBase()]):
            with pytest.raises(LamcError, match="'h22', which is not there; did you mean 'h2'"):
                lamc.compile(made, lamc.Scene(**{what: {"h22": 0.1}}, effects=effects))  # type: ignore[arg-type]


def test_a_name_in_other_letters_is_offered() -> None:
    """`W` for `w` is nearer to no name by its letters."""
    known = ["link_1.mass", "gravity.z", "w", "L1"]
    assert did_you_mean("W", known) == "did you mean 'w'?"
    assert did_you_mean("l1", known) == "did you mean 'L1'?"
    assert did_you_mean("x", known).startswith("known are link_1.mass")
