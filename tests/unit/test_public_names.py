"""The front door: what `lamc` offers, and what became of old names."""

import subprocess
import sys
import typing
import warnings
from collections.abc import Callable
from importlib import import_module
from inspect import isclass, isfunction, signature
from pathlib import Path

import numpy as np
import numpy.typing as npt
import pytest

import lamc
from lamc import plate
from lamc.plates import records
from tests.support.public_names import DOORS, exposed, has_any, signatures


def test_the_front_door_shows_what_users_need_and_nothing_else() -> None:
    assert dir(lamc) == sorted(lamc.__all__)
    assert all(hasattr(lamc, name) for name in lamc.__all__)
    assert {"Material", "Limits", "Times", "OutputPoint"} <= set(lamc.__all__)
    assert Path(lamc.__file__).with_name("py.typed").is_file()


@pytest.mark.parametrize(
    ("module", "name", "there"),
    [
        ("errors", "DesignError", "lamc.DesignError"),
        ("scene", "Scene", "lamc.Scene"),
        ("inputs", "Input", "lamc.Input"),
        ("options", "PRECISIONS", "lamc.codegen.options.PRECISIONS"),
    ],
)
def test_an_old_name_gives_the_same_object_and_the_new_name(module: str, name: str, there: str) -> None:
    old = import_module(f"lamc.{module}")
    with pytest.warns(DeprecationWarning, match=f"is {there} now"):
        value = getattr(old, name)
    home, leaf = there.rsplit(".", 1)
    assert value is getattr(import_module(home), leaf)


@pytest.mark.parametrize(
    ("old", "there"),
    [
        ("lamc.Plate", "lamc.Slab"),
        ("lamc.plate.Gravity", "lamc.plate.SelfWeight"),
        ("lamc.plate.Model", "lamc.plate.FactoredPlate"),
        ("lamc.plate.HingeTurn", "lamc.plates.records.HingeRotation"),
        ("lamc.plate.Modes", "lamc.plates.records.PlateModes"),
        ("lamc.plates.records.HingeStiffness", "lamc.plates.records.FilmStiffness"),
        *((f"lamc.plate.{name}", f"lamc.plates.records.{name}") for name in records.__all__),
    ],
)
def test_an_old_public_name_gives_the_same_object_and_the_new_name(old: str, there: str) -> None:
    homes = [(import_module(path.rsplit(".", 1)[0]), path.rsplit(".", 1)[1]) for path in (old, there)]
    with pytest.warns(DeprecationWarning, match=f"^{old} is {there} now$"):
        value = getattr(*homes[0])
    assert value is getattr(*homes[1])


def test_a_name_that_never_was_is_an_error_as_of_any_module() -> None:
    with pytest.raises(AttributeError, match="has no attribute 'Plates'"):
        lamc.Plates  # noqa: B018  # type: ignore[attr-defined]


def test_an_old_module_knows_no_other_names() -> None:
    with pytest.raises(AttributeError):
        import_module("lamc.errors").nothing  # noqa: B018


def test_the_door_to_plates_shows_what_users_call_and_make_and_no_records_of_results() -> None:
    assert dir(plate) == sorted(plate.__all__)
    assert not set(plate.__all__) & set(records.__all__)
    assert sorted(records.__all__) == records.__all__


def test_no_name_means_two_things() -> None:
    """But `Material`, of a design's layer and of a ply: each is the field's word, and both names are fixed."""
    assert set(lamc.__all__) & set(plate.__all__) == {"Material"}
    assert not set(records.__all__) & {*lamc.__all__, *plate.__all__}
    assert not {name.lower() for name in lamc.__all__} & {"plate", "plates"}


@pytest.mark.slow
def test_lamc_itself_uses_no_old_name() -> None:
    run = [sys.executable, "-W", "error::DeprecationWarning:lamc", "-c", "import lamc, lamc.cli, lamc.plate"]
    assert subprocess.run(run, capture_output=True).returncode == 0


FUNCTIONS = [pytest.param(name, thing, id=name) for name, thing in exposed(*DOORS) if isfunction(thing)]
CLASSES = [pytest.param(name, thing, id=name) for name, thing in exposed(*DOORS) if isclass(thing)]


@pytest.mark.parametrize(("name", "thing"), FUNCTIONS)
def test_public_functions_say_what_they_take_and_give(name: str, thing: typing.Any) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        parameters = signature(thing).parameters.values()
    assert all(p.annotation is not p.empty for p in parameters), name
    assert signature(thing).return_annotation is not signature(thing).empty, name


def test_public_signatures_hold_no_any() -> None:
    """What may be anything is `object`: a type checker then still looks at what is done with it."""
    found = [(name, key) for name, hints in signatures() for key, hint in hints.items() if has_any(hint)]
    assert found == []


@pytest.mark.parametrize(
    ("hint", "expected"),
    [
        (typing.Any, True),
        (dict[str, typing.Any], True),
        (Callable[[typing.Any], float], True),
        (npt.NDArray[typing.Any], True),
        (npt.NDArray[np.float64], False),
        (npt.NDArray[np.floating[typing.Any]], False),
        (npt.ArrayLike | None, False),
        (object, False),
    ],
)
def test_any_is_found_wherever_it_stands(hint: object, expected: bool) -> None:
    assert has_any(hint) == expected


@pytest.mark.parametrize(("name", "thing"), CLASSES)
def test_public_classes_have_a_docstring(name: str, thing: type) -> None:
    assert thing.__doc__, name
