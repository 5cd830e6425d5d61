"""The front door: what `lamc` offers, and what became of old names."""

import subprocess
import sys
import typing
import warnings
from importlib import import_module
from inspect import isclass, isfunction, signature
from pathlib import Path

import pytest

import lamc
from lamc import plate


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


def test_an_old_module_knows_no_other_names() -> None:
    with pytest.raises(AttributeError):
        import_module("lamc.errors").nothing  # noqa: B018


def test_lamc_itself_uses_no_old_name() -> None:
    run = [sys.executable, "-W", "error::DeprecationWarning:lamc", "-c", "import lamc, lamc.cli, lamc.plate"]
    assert subprocess.run(run, capture_output=True).returncode == 0


def _exposed() -> list[tuple[str, object]]:
    homes = ((lamc, "lamc"), (plate, "lamc.plate"))
    return [(f"{where}.{name}", getattr(home, name)) for home, where in homes for name in home.__all__]


FUNCTIONS = [pytest.param(name, thing, id=name) for name, thing in _exposed() if isfunction(thing)]
CLASSES = [pytest.param(name, thing, id=name) for name, thing in _exposed() if isclass(thing)]


@pytest.mark.parametrize(("name", "thing"), FUNCTIONS)
def test_public_functions_say_what_they_take_and_give(name: str, thing: typing.Any) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        parameters = signature(thing).parameters.values()
    assert all(p.annotation is not p.empty for p in parameters), name
    assert signature(thing).return_annotation is not signature(thing).empty, name


@pytest.mark.parametrize(("name", "thing"), CLASSES)
def test_public_classes_have_a_docstring(name: str, thing: type) -> None:
    assert thing.__doc__, name
