"""Generated C of small designs and a finite element against files read by eye; `pytest --update-golden` rewrites it.

A change of the C that nobody meant shows here as a diff.
"""

import difflib
import re
from collections.abc import Callable, Mapping
from pathlib import Path

import numpy as np
import pytest

import lamc
from lamc.codegen.emit_element import emit_element
from lamc.effects import Gravity, HingeDamping, HingeStiffness, NonlinearStiffness, Torque
from lamc.examples import __file__ as examples
from lamc.pipeline import effects_of, equations_of, sources_of
from lamc.plates.elements.build import element_program
from lamc.plates.elements.library import element
from lamc.records.effect import Effect
from lamc.records.mechanism import Body, Joint, Mechanism
from lamc.records.scene import Scene
from tests.support.paths import GOLDEN


def pendulum() -> tuple[Mechanism, tuple[Effect, ...]]:
    """popupCAD's own example: three plates on parallel hinges."""
    mechanism = lamc.split(lamc.load(Path(examples).parent / "pendulum.cad"))
    return mechanism, effects_of(mechanism, mechanism.scene or Scene())


def two_links_in_space() -> tuple[Mechanism, tuple[Effect, ...]]:
    bodies = (
        Body("ground", fixed=True),
        Body("upper", 1.0, [0.5, 0.0, 0.0], [[0.02, 0.001, 0.0], [0.001, 0.1, 0.0], [0.0, 0.0, 0.1]]),
        Body("lower", 0.5, [1.0, 0.25, 0.0], [[0.05, 0.0, 0.0], [0.0, 0.01, 0.0], [0.0, 0.0, 0.05]]),
    )
    joints = (
        Joint("shoulder", "ground", "upper", axis=[0.0, 1.0, 0.0], stiffness=2.0, damping=0.125),
        Joint("elbow", "upper", "lower", point=[1.0, 0.0, 0.0], axis=[0.0, 0.6, 0.8], stiffness=1.5),
    )
    effects = (Gravity((0.0, 0.0, -9.81)), HingeDamping(), HingeStiffness())
    return Mechanism(bodies, joints, name="two links in space"), effects


def driven() -> tuple[Mechanism, tuple[Effect, ...]]:
    bodies = (
        Body("ground", fixed=True),
        Body("flap", 0.25, [0.5, 0.0, 0.0], [[0.0, 0, 0], [0, 0.02, 0], [0, 0, 0.02]]),
    )
    joints = (Joint("hinge", "ground", "flap", axis=[0.0, 0.0, 1.0]),)
    torque = Torque({"hinge": "0.01*sin(2*pi*50*t) - 1e-4*rate*abs(rate) + max(angle, 0)^3"})
    return Mechanism(bodies, joints, name="driven"), (torque,)


def measured() -> tuple[Mechanism, tuple[Effect, ...]]:
    """A flap on a hinge whose torque was measured at five angles."""
    bodies = (Body("ground", fixed=True), Body("flap", 0.25, [0.5, 0.0, 0.0], np.diag([0.0, 0.02, 0.02])))
    joint = Joint("hinge", "ground", "flap", axis=[0.0, 0.0, 1.0], rest_angle=0.25)
    rows = [(-1.0, -0.5), (-0.25, -0.0625), (0.0, 0.0), (0.5, 0.125), (1.0, 0.75)]
    return Mechanism(bodies, (joint,), name="measured"), (NonlinearStiffness({"hinge": {"table": rows}}),)


CASES: Mapping[str, Callable[[], tuple[Mechanism, tuple[Effect, ...]]]] = {
    "pendulum": pendulum,
    "two_links_in_space": two_links_in_space,
    "driven": driven,
    "measured": measured,
}


ELEMENTS = ("cst",)


def generated(name: str) -> dict[str, str]:
    """The model's or element's own files; lamc's version is masked, so that a release changes nothing here."""
    if name in ELEMENTS:
        tree = emit_element(element_program(element(name)))
    else:
        mechanism, effects = CASES[name]()
        _, tree = sources_of(equations_of(mechanism, effects))
    return {
        file: re.sub(r"(Made by lamc) \S+", r"\1 VERSION", tree.files[file])
        for file in sorted(tree.files)
        if file.startswith(name)
    }


@pytest.mark.parametrize("name", sorted([*CASES, *ELEMENTS]))
def test_generated_c_is_what_was_read_by_eye(name: str, request: pytest.FixtureRequest) -> None:
    update = request.config.getoption("--update-golden")
    differences: list[str] = []
    for file, text in generated(name).items():
        path = GOLDEN / file
        kept = path.read_text(encoding="utf-8") if path.is_file() else ""
        if kept != text:
            lines = difflib.unified_diff(
                kept.splitlines(), text.splitlines(), f"golden/{file}", "generated", "", "", 3, ""
            )
            differences += lines
            if update:
                GOLDEN.mkdir(exist_ok=True)
                path.write_text(text, encoding="utf-8", newline="\n")
    if update and differences:
        with request.config.pluginmanager.getplugin("capturemanager").global_and_fixture_disabled():
            print("\n" + "\n".join(differences))
    elif differences:
        pytest.fail(
            "the C changed; if it was meant to, `pytest --update-golden` and read the diff:\n"
            + "\n".join(differences[:80])
        )


def test_no_golden_file_is_left_over() -> None:
    expected = [f"{n}.{k}" for n in (*CASES, *ELEMENTS) for k in ("c", "h")]
    expected += [f"{n}_equations.h" for n in ELEMENTS]
    assert sorted(p.name for p in GOLDEN.iterdir()) == sorted(expected)
