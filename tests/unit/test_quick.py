"""What tests compile quickly moves as what users get, to the last bit."""

from pathlib import Path

import pytest

import lamc
from lamc.codegen import build, toolchain
from lamc.codegen.cache import Cache
from tests.support.ctools import needs_cc
from tests.support.exported_folders import mechanism_of, scene_of
from tests.support.quick import LEVEL, quick_compilation, quickly


@needs_cc
@pytest.mark.campaign  # smaller models in each run: test_compilers_agree_to_the_last_bit
def test_the_level_of_optimisation_changes_no_bit(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The crawler: contact, a floating base, events. Each in a cache of its own, where keys are the same."""
    mechanism, scene = mechanism_of("crawler"), scene_of("crawler")
    with quick_compilation():
        quick = lamc.compile(mechanism, scene, cache=Cache(tmp_path / "quick")).run(0.1)
    monkeypatch.setattr(build, "make_library", toolchain.make_library)
    monkeypatch.setattr(build, "make_objects", toolchain.make_objects)
    shipped = lamc.compile(mechanism, scene, cache=Cache(tmp_path / "shipped")).run(0.1)
    assert shipped.success
    assert quick.t.tobytes() == shipped.t.tobytes()
    assert quick.q.tobytes() == shipped.q.tobytes()
    assert quick.u.tobytes() == shipped.u.tobytes()


def test_quick_flags_are_those_of_users_but_one() -> None:
    flags = lamc.CompileOptions().flags
    assert [a for a, b in zip(quickly(flags), flags, strict=True) if a != b] == [LEVEL]
