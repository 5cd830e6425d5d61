"""What holds for every effect that lamc brings: absence without a trace, files, records, hostile data."""

import copy
import dataclasses
import json
import pickle
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from lamc.basics.errors import DesignError, DesignErrors, LamcError
from lamc.codegen.names import identifier
from lamc.effects import registry
from lamc.effects.registry import EFFECTS, by_name, choose
from lamc.mechanics.equations import Equations
from lamc.pipeline import effects_of, equations_of, sources_of
from lamc.readers.load_scene import scene_of_text
from lamc.readers.scene_writer import scene_data
from lamc.records.effect import Effect
from lamc.records.mechanism import Mechanism
from lamc.records.scene import Scene
from tests.support.every_effect import SAMPLES, mechanism
from tests.support.mechanisms import trees
from tests.support.quick import tries

each_effect = pytest.mark.parametrize("name", [kind.name for kind in EFFECTS])


def of(*effects: Effect) -> Equations:
    whole = mechanism()
    return equations_of(whole, effects_of(whole, Scene(effects=effects)))


def c_text(*effects: Effect) -> str:
    _, tree = sources_of(of(*effects))
    return tree.files[f"{tree.prefix}.c"] + tree.files[f"{tree.prefix}.h"]


def test_every_effect_has_a_sample() -> None:
    missing = sorted(set(by_name()) - set(SAMPLES))
    assert not missing, f"add samples of {missing} to tests/support/every_effect.py"


# ---- absence ------------------------------------------------------------------------------------------------------


@each_effect
def test_an_effect_that_is_not_called_for_leaves_no_trace(name: str) -> None:
    """None of its parameters, sections, energies, tables or guards; and with it there are some."""
    effect = SAMPLES[name]
    company: tuple[Effect, ...] = () if name == "gravity" else (SAMPLES["gravity"],)
    bare, with_it = of(*company), of(*company, effect)
    absent, present = c_text(*company), c_text(*company, effect)
    assert present != absent
    own = {p.name for p in with_it.parameters} - {p.name for p in bare.parameters}
    assert not own & {p.name for p in bare.parameters}
    traces = {identifier(p, taken=()) for p in own} | {f"[{name}]", effect.summary, "piecewise", "mode_"}
    traces -= {t for t in traces if t not in present}  # what it does not bring cannot be missing
    assert traces
    assert not [t for t in traces if t in absent]
    assert name not in bare.energies
    assert {s.effect for s in bare.store.sections} <= {"", *(e.name for e in company)}


@each_effect
def test_its_presence_changes_nothing_of_what_others_bring(name: str) -> None:
    """Parameters and energies of a scene stay, in their order, when an effect joins it that claims nothing."""
    effect = SAMPLES[name]
    others = tuple(SAMPLES[n] for n in ("gravity", "hinge_damping", "torque") if n != name)
    bare, joined = of(*others), of(*others, effect)
    own = [p for p in joined.parameters if p.name not in {b.name for b in bare.parameters}]
    assert {p.effect for p in own} <= {name, ""}
    assert [e for e in joined.energies if e != name] == [e for e in bare.energies if e != name]


def test_c_stays_the_same_byte_for_byte_when_an_effect_is_added_to_lamc(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    scenes = [
        (SAMPLES["gravity"],),
        (SAMPLES["spring"], SAMPLES["nonlinear_stiffness"]),
        (SAMPLES["free_base"],),
    ]
    before = [c_text(*effects) for effects in scenes]

    class Newcomer:
        name = "newcomer"
        summary = "A newcomer"

        @classmethod
        def default_for(cls, mechanism: Mechanism) -> tuple[None, str]:
            return None, "nobody calls for it"

    monkeypatch.setattr(registry, "EFFECTS", (Newcomer, *EFFECTS))
    assert "newcomer" in {c.name for c in choose(mechanism(), Scene())}
    assert [c_text(*effects) for effects in scenes] == before


def test_c_does_not_depend_on_the_order_in_which_effects_are_called_for() -> None:
    effects = [SAMPLES[n] for n in ("torque", "gravity", "piezo_bender", "hinge_stiffness", "linear_motor")]
    assert c_text(*effects) == c_text(*effects[::-1])


# ---- records and files --------------------------------------------------------------------------------------------


@each_effect
def test_effects_are_values(name: str) -> None:
    effect = SAMPLES[name]
    for other in (copy.deepcopy(effect), pickle.loads(pickle.dumps(effect)), dataclasses.replace(effect)):
        assert other == effect
        assert hash(other) == hash(effect)
        assert repr(other) == repr(effect)
    for field in [f.name for f in dataclasses.fields(effect)] or ["anything"]:  # type: ignore[arg-type]
        with pytest.raises((dataclasses.FrozenInstanceError, TypeError)):
            setattr(effect, field, 1)
    assert {effect: 1}[effect] == 1
    assert all(f.name in repr(effect) for f in dataclasses.fields(effect))  # type: ignore[arg-type]


@each_effect
def test_scene_files_hold_every_effect_whole(name: str) -> None:
    scene = Scene(effects=(SAMPLES[name],))
    text = json.dumps(scene_data(scene))  # JSON is YAML
    again = scene_of_text(text, "scene.yaml")
    assert again.effects == scene.effects
    assert again == scene
    assert repr(again.effects) == repr(scene.effects)
    assert json.dumps(scene_data(again)) == text


@each_effect
def test_defaults_are_an_effect_or_none_and_why(name: str) -> None:
    @given(made=trees(4))
    @settings(deadline=None, max_examples=15)
    def every(made: Mechanism) -> None:
        effect, reason = by_name()[name].default_for(made)
        assert effect is None or type(effect) is by_name()[name]
        assert reason
        assert "\n" not in reason

    every()


@each_effect
def test_what_it_names_must_be_there(name: str) -> None:
    """On a mechanism with other names it acts, or is refused by an error of one line."""
    whole = mechanism()
    bodies = [dataclasses.replace(b, name=f"other {b.name}") for b in whole.bodies]
    joints = [
        dataclasses.replace(j, name=f"other {j.name}", parent=f"other {j.parent}", child=f"other {j.child}")
        for j in whole.joints
    ]
    renamed = Mechanism(tuple(bodies), tuple(joints))
    scene = Scene(effects=(SAMPLES[name],))
    reported = outcome(lambda: equations_of(renamed, effects_of(renamed, scene)))
    assert "\n" not in reported
    assert not reported or any(word in reported for word in ("named", "joint", "body"))


# ---- hostile data -------------------------------------------------------------------------------------------------

LEAVES = st.one_of(
    st.none(),
    st.booleans(),
    st.integers(),
    st.floats(),
    st.text(max_size=20),
    st.sampled_from(
        [
            "1e999",
            "-1 kg",
            "3 N*mm/deg",
            "t",
            "1/0",
            "sin(",
            "9" * 500,
            "../../etc/passwd",
            "\x00",
            "m^9^9^9",
            10**400,
        ]
    ),
    st.binary(max_size=4),
)
NAMES = st.one_of(
    st.text(max_size=12),
    st.sampled_from(sorted({f.name for kind in EFFECTS for f in dataclasses.fields(kind)})),  # type: ignore[arg-type]
    st.sampled_from(["h1", "a", "table", "file", "energy", "between", "material", "thickness"]),
)
DATA = st.recursive(
    LEAVES,
    lambda inner: st.one_of(st.lists(inner, max_size=4), st.dictionaries(NAMES, inner, max_size=4)),
    max_leaves=12,
)
PATIENT = settings(
    deadline=None,
    max_examples=tries(60),
    suppress_health_check=[HealthCheck.too_slow, HealthCheck.data_too_large],
)


def plain(name: str) -> Any:
    """The data of the sample as a file holds it."""
    ((entry),) = scene_data(Scene(effects=(SAMPLES[name],)))["effects"]
    return entry[name]


def outcome(make: Callable[[], object]) -> str:
    """ "" for a record, or the message of the LamcError, of several the longest; anything else escapes and fails the
    test."""
    try:
        make()
    except DesignErrors as errors:
        reported = [str(error) for error in errors.problems]
        assert "\n" not in "".join(reported)
        return max(reported, key=len)
    except LamcError as error:
        return str(error)
    return ""


def attempt(name: str, data: object, *, acts: bool = False) -> None:
    """From data to an effect, and on to equations where it acts; or an error of one line."""
    whole, made = mechanism(), list[Effect]()
    reported = outcome(lambda: made.append(by_name()[name].from_data(data, "scene.effects.it")))
    if made:
        assert type(made[0]) is by_name()[name]
        assert isinstance(hash(made[0]), int)
        if acts:
            reported = outcome(lambda: equations_of(whole, effects_of(whole, Scene(effects=tuple(made)))))
    assert "\n" not in reported
    assert len(reported) < 2000


@each_effect
@pytest.mark.quick("ground_contact", "linear_motor", "spring", "torque")
def test_any_data_is_an_effect_or_an_error_of_one_line(name: str) -> None:
    @given(data=DATA)
    @PATIENT
    def every(data: object) -> None:
        attempt(name, data)

    every()


EXTREMES = (
    *(np.array(1.0), np.array([]), np.arange(3.0), np.array([[np.nan]]), np.float32(2.0), np.bool_(True)),
    *(1e300, -1e300, 1e-320, 1j, b"x", object(), {}, {"h1": 1e300}, (1e300,) * 3, ("h1", "h1")),
)


@each_effect
def test_any_value_of_a_field_in_python_acts_or_is_an_error_of_one_line(name: str) -> None:
    """Arrays of any shape, and numbers at the ends of what floats hold."""
    effect, whole = SAMPLES[name], mechanism()
    for field in [f.name for f in dataclasses.fields(effect)]:  # type: ignore[arg-type]
        for value in EXTREMES:
            made: list[Effect] = []
            reported = outcome(
                lambda f=field, v=value, m=made: m.append(dataclasses.replace(effect, **{f: v}))
            )  # type: ignore[misc]
            if made:
                assert isinstance(hash(made[0]), int)
                with np.errstate(all="ignore"):
                    reported = outcome(
                        lambda m=made: equations_of(whole, effects_of(whole, Scene(effects=(*m,))))
                    )  # type: ignore[misc]
            assert "\n" not in reported
            assert len(reported) < 1000


@each_effect
@pytest.mark.quick("gravity", "joint_limits", "nonlinear_stiffness", "torque")
def test_data_with_one_part_spoilt_is_an_effect_or_an_error_of_one_line(name: str) -> None:
    good = plain(name)
    places = list(parts(good))

    @given(place=st.sampled_from(places), bad=DATA)
    @PATIENT
    def every(place: tuple[Any, ...], bad: object) -> None:
        attempt(name, spoilt(good, place, bad), acts=True)

    every()


def fields_in_files(name: str) -> list[str]:
    """Fields that files name; not those of effects without any, or whose data are names of joints."""
    names = [f.name for f in dataclasses.fields(by_name()[name])]  # type: ignore[arg-type]
    data = plain(name)
    return names if isinstance(data, dict) and set(data) <= set(names) else []


@pytest.mark.parametrize("name", [kind.name for kind in EFFECTS if fields_in_files(kind.name)])
def test_a_misspelt_field_is_reported_with_the_nearest_name(name: str) -> None:
    for field in fields_in_files(name):
        with pytest.raises(DesignError, match=f"did you mean '{field}'"):
            by_name()[name].from_data({**plain(name), f"{field}x": 1}, "here")


def parts(data: object, path: tuple[Any, ...] = ()) -> Iterator[tuple[Any, ...]]:
    """Paths of all parts of plain data."""
    yield path
    if isinstance(data, dict | list):
        for key in data if isinstance(data, dict) else range(len(data)):
            yield from parts(data[key], (*path, key))  # type: ignore[index]


def spoilt(data: Any, path: tuple[Any, ...], bad: object) -> Any:
    """`data` with another part at `path`."""
    if not path:
        return bad
    whole = copy.copy(data)
    whole[path[0]] = spoilt(whole[path[0]], path[1:], bad)
    return whole
