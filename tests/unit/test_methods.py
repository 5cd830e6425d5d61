"""The table of methods against the C that it speaks of."""

import re
import runpy

import pytest

from lamc.run import methods
from lamc.run.methods import METHODS
from tests.support.paths import ROOT, RUNTIME


def source(name: str) -> str:
    return (RUNTIME / "src" / f"{name}.c").read_text(encoding="utf-8")


def entries(name: str) -> list[str]:
    """Of the method's record in C, in the order of `method` in method.h; constants of the file by their numbers."""
    text = source(name)
    (inside,) = re.findall(rf"const method lamc_method_{name} = {{(.*?)}};", text, re.DOTALL)
    numbers = dict(re.findall(r"\b([A-Z]\w*) = (\d+)\b", text))
    return [numbers.get(entry, entry) for entry in re.split(r",\s*", inside.strip().rstrip(","))]


def record(name: str) -> dict[str, str]:
    """Members by name."""
    text = (RUNTIME / "src" / "method.h").read_text(encoding="utf-8")
    (inside,) = re.findall(r"typedef struct method {(.*?)} method;", text, re.DOTALL)
    plain = re.sub(r"/\*.*?\*/", "", inside, flags=re.DOTALL)
    names = re.findall(r"\(\*(\w+)\)|(\w+)(?=[,;])(?![^(]*\)\s*;)", plain)
    return dict(zip([a or b for a, b in names], entries(name), strict=True))


def test_what_is_made_from_the_table_is_up_to_date() -> None:
    """Otherwise: make methods."""
    made = runpy.run_path(str(ROOT / "docs" / "make_methods.py"))["texts"]()
    assert {path.name: path.read_text(encoding="utf-8") for path in made} == {
        path.name: text for path, text in made.items()
    }


@pytest.mark.parametrize("name", METHODS)
def test_the_table_says_what_the_c_does(name: str) -> None:
    method, c = METHODS[name], record(name)
    assert method.is_implicit == (c["extra"] != "NULL")
    assert method.is_stiff == (float(c["stable_extent"]) == 0.0)
    assert method.least_evaluations <= int(c["evaluations"])
    assert not method.is_stiff or method.is_implicit


def test_steps_of_a_given_length_are_those_of_the_c_that_has_them() -> None:
    """`lamc_stiff_step` is written for one method; another takes code of its own (stiff.c, fixed.c, the exports)."""
    fixed = [name for name, method in METHODS.items() if method.has_fixed_steps]
    assert fixed == sorted(set(re.findall(r"lamc_method_(\w+)\.", source("stiff"))))


def test_a_table_of_an_export_may_lack_methods_that_users_alone_take() -> None:
    """`auto` asks every method of the table how much room it takes; the room of none was asked for, too."""
    asks = source("run").partition("static long long size_of_methods(")[2].partition("\n}")[0]
    assert "METHODS[i] == NULL ? 0" in asks


def test_auto_goes_by_the_same_numbers_in_python_and_in_c() -> None:
    reported = dict(re.findall(r"static const lamc_real (\w+) = ([^;]+);", source("watch")))
    for name in ("TIGHT", "TIGHT_FOR_RADAU", "LINEAR_ALGEBRA"):
        assert float(reported[name]) == getattr(methods, name)


def test_no_other_place_lists_the_methods() -> None:
    """Three names in one line are a list that the next method will be missing from. Prose may compare them."""
    named = re.compile(r'"(?:' + "|".join(METHODS) + r')"')
    found = [
        f"{path.relative_to(ROOT)}: {line.strip()}"
        for path in sorted((ROOT / "lamc").rglob("*.py"))
        if path.name != "methods.py"
        for line in path.read_text(encoding="utf-8").splitlines()
        if len(set(named.findall(line))) > 2
    ]
    assert not found
