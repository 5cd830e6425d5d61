"""Effects of any class have all hooks; a method that nothing would ask for is refused."""

from dataclasses import dataclass
from typing import Any, ClassVar

import pytest

import lamc
from lamc.basics.errors import DesignError
from lamc.effects.registry import EFFECTS
from lamc.records.effect import HOOKS, Effect, claims_of, conserves, hooked, marks_of, overrides
from tests.support.mechanisms import chain


@dataclass(frozen=True)
class Own(Effect):
    name: ClassVar[str] = "own"
    summary: ClassVar[str] = "An effect of one's own"

    def contribute(self, loads: Any) -> None:
        pass


class Foreign:
    name = "foreign"
    summary = "An object of another class"

    def contribute(self, loads: Any) -> None:
        pass

    def claims(self) -> tuple[str, ...]:
        return ("peace", "peace")


def test_hooks_do_nothing_unless_they_are_overridden() -> None:
    own = Own()
    assert claims_of(own) == ()
    assert marks_of((own,), {}) == ()
    assert not own.alternatives()
    assert conserves(own, {"own"})
    assert not conserves(own, set())
    assert not any(overrides(own, hook) for hook in HOOKS if hook != "contribute")


def test_an_object_of_another_class_has_the_hooks_that_it_brings_and_the_rest_by_default() -> None:
    foreign = Foreign()
    assert claims_of(foreign) == ("peace",)  # type: ignore[arg-type]
    assert overrides(foreign, "claims")
    assert not overrides(foreign, "arrange")
    assert list(hooked(foreign).drives()) == []
    assert hooked(foreign).source == ""
    lamc.Scene(effects=(foreign,))  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("written", "meant"),
    [("check_starts", "check_start"), ("claim", "claims"), ("drive", "drives"), ("carryover", "carry_over")],
)
@pytest.mark.parametrize("base", [Own, Foreign])
def test_a_method_named_nearly_as_a_hook_is_refused(base: type, written: str, meant: str) -> None:
    near = type("Near", (base,), {written: lambda self: ()})
    with pytest.raises(DesignError, match=f"{written!r}.*did you mean {meant!r}"):
        lamc.Scene(effects=(near(),))


@pytest.mark.parametrize(
    ("name", "value", "message"),
    [
        ("conservative", lambda self: False, r"conservative must be a property: write @property above it"),
        ("conservativ", property(lambda self: False), r"an attribute 'conservativ'.*mean 'conservative'"),
        ("repeatble", True, r"an attribute 'repeatble'.*mean 'repeatable'"),
        ("claims", ("peace",), r"claims must be a method: define claims\(self\)"),
        (
            "contribute",
            lambda self: None,
            r"contribute takes other arguments .*: define contribute\(self, loads\)",
        ),
        ("check_start", lambda self, angles: None, r"define check_start\(self, mechanism, angles\)"),
    ],
)
@pytest.mark.parametrize("base", [Own, Foreign])
def test_a_hook_that_cannot_be_asked_is_refused(base: type, name: str, value: Any, message: str) -> None:
    """A method in the place of a property had counted as true, and a missing argument ended in a TypeError."""
    with pytest.raises(DesignError, match=message):
        lamc.Scene(effects=(type("Odd", (base,), {name: value})(),))


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("conservative", False),
        ("conservative", property(lambda self: False)),
        ("contribute", lambda self, *all: None),
        ("claims", staticmethod(lambda: ())),
        ("claims", classmethod(lambda kind: ())),
    ],
)
def test_a_hook_may_be_written_in_any_way_that_can_be_asked(name: str, value: Any) -> None:
    effect = type("Odd", (Own,), {name: value})()
    lamc.Scene(effects=(effect,))
    assert claims_of(effect) == ()


def test_a_private_method_may_have_any_name() -> None:
    lamc.Scene(effects=(type("Private", (Own,), {"_claim": lambda self: ()})(),))


def test_an_effect_that_contributes_nothing_is_none() -> None:
    with pytest.raises(DesignError, match="'contribute'"):
        lamc.Scene(effects=(type("Empty", (Effect,), {"name": "empty", "summary": "nothing"})(),))


@pytest.mark.parametrize("kind", EFFECTS, ids=lambda kind: kind.name)
def test_effects_of_lamc_are_of_the_base_class(kind: type) -> None:
    assert issubclass(kind, lamc.Effect)


@pytest.mark.parametrize("hook", ["contribute", "arrange"])
@pytest.mark.parametrize("number", [lambda: 10.0**400, lambda: 1.0 / 0.0])
def test_numbers_that_overflow_are_an_error_of_the_effect(hook: str, number: Any) -> None:
    """They had been a bug of lamc."""
    effect = type("Large", (Own,), {hook: lambda self, what: number()})()
    with pytest.raises(DesignError, match="effect 'own' cannot compute with its numbers") as caught:
        lamc.compile(chain(1, "parallel", seed=1), lamc.Scene(effects=(effect,)))
    assert isinstance(caught.value.subject, Own)
