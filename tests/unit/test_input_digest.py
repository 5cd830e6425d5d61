"""The digest by which a compile from the cache knows that nothing changed: all that effects may look at is in it."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np
import pytest
from shapely.geometry import box

import lamc
from lamc.codegen.options import CompileOptions
from lamc.codegen.toolchain import find_compiler
from lamc.mechanics.loads import Loads
from lamc.records.effect import Effect
from lamc.records.mechanism import Mechanism, Slab
from lamc.run import input_digest as module
from lamc.run.input_digest import input_digest
from tests.support.every_effect import mechanism


@dataclass(frozen=True, eq=False)
class Sampled:
    """An effect with a long array, whose text is cut in the middle."""

    values: np.ndarray
    law: Callable[[float], float] | None = None

    name: ClassVar[str] = "sampled"
    summary: ClassVar[str] = "Values"

    def contribute(self, loads: Loads) -> None:
        """Nothing."""


def digest(made: Mechanism, *effects: Effect, energy_balance: bool = False, fast: bool = False) -> str | None:
    return input_digest(
        made, effects, None, find_compiler(None), CompileOptions(fast=fast), extras=str(energy_balance)
    )


def outlined(width: float) -> Mechanism:
    plate = Slab(box(0.0, 0.0, 1.0, width), 0.0, 0.01)
    bodies = tuple(b if b.fixed else replace(b, outline=(plate,)) for b in mechanism().bodies)
    return replace(mechanism(), bodies=bodies)


def test_the_same_input_has_the_same_digest() -> None:
    assert digest(mechanism(), lamc.Gravity()) == digest(mechanism(), lamc.Gravity())
    assert digest(outlined(0.1)) == digest(outlined(0.1))


def test_whatever_the_equations_may_depend_on_changes_it() -> None:
    """Outlines, where contact points come from; values of effects to the last bit; options; whether powers are
    reported."""
    gravity = lamc.Gravity()
    least = lamc.Gravity((0.0, 0.0, float(np.nextafter(-9.81, 0.0))))
    digests = [
        digest(mechanism()),
        digest(mechanism(), gravity),
        digest(mechanism(), least),
        digest(mechanism(), gravity, energy_balance=True),
        digest(mechanism(), gravity, fast=True),
        digest(outlined(0.1), gravity),
        digest(outlined(0.2), gravity),
        digest(mechanism(), lamc.FreeBase(velocity=(1.0, 0.0, 0.0))),
        digest(mechanism(), lamc.FreeBase(velocity=(2.0, 0.0, 0.0))),
    ]
    assert None not in digests
    assert len(set(digests)) == len(digests)


def test_lines_along_which_facets_bend_change_it() -> None:
    """A start leaves them flat: that of a sheet is not that of the same hinges, all of them creases."""
    plain = mechanism()
    bent = replace(plain, facet_creases=(plain.joints[0].name,))
    assert digest(plain) != digest(bent)
    scene = lamc.Scene()
    assert module.loops_digest(plain, (), scene) != module.loops_digest(bent, (), scene)


def test_an_array_counts_to_its_last_number(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "EFFECTS", (Sampled,))
    values = np.zeros(5000)
    other = values.copy()
    other[2500] = 1e-300
    assert repr(Sampled(values)) == repr(Sampled(other))
    assert digest(mechanism(), Sampled(values)) != digest(mechanism(), Sampled(other))


def test_there_is_none_for_what_nobody_can_tell(monkeypatch: pytest.MonkeyPatch) -> None:
    """Effects that are not lamc's own, and functions."""
    assert digest(mechanism(), Sampled(np.zeros(1))) is None
    monkeypatch.setattr(module, "EFFECTS", (Sampled,))
    assert digest(mechanism(), Sampled(np.zeros(1), abs)) is None
