"""The table of what draws what."""

import pytest

import lamc
from lamc.basics import drawing


@pytest.mark.parametrize("entry", sorted(drawing.registered()), ids="-".join)
def test_every_verb_of_a_record_has_its_function(entry: tuple[str, str]) -> None:
    assert callable(drawing.drawer(*entry))


def test_a_verb_without_a_function_is_refused_by_name() -> None:
    with pytest.raises(lamc.LamcError, match="nothing to sing a Result with"):
        drawing.drawer("Result", "sing")
