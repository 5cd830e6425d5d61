"""The pages hold together: they are short where they are read first, links lead somewhere, lists are complete."""

import os
import re
import runpy
import tomllib
from pathlib import Path

import pytest

import lamc
from tests.support.paths import ROOT

PAGES = sorted([*ROOT.glob("*.md"), *(ROOT / "docs").rglob("*.md")])
DECISIONS = sorted((ROOT / "docs" / "decisions").glob("[0-9]*.md"))
MOST = 8000  # bytes of a page that is read first: four screens


def name_of(path: Path) -> str:
    return path.relative_to(ROOT).as_posix()


def prose(path: Path) -> str:
    """The page without its blocks of code, whose brackets are no links."""
    return re.sub(r"^```.*?^```$", "", path.read_text(encoding="utf-8"), flags=re.DOTALL | re.MULTILINE)


def anchors(path: Path) -> set[str]:
    """What `#...` may name in a page: its headings as GitHub and mkdocs spell them."""
    titles = re.findall(r"^#+ (.*)$", prose(path), re.MULTILINE)
    return {re.sub(r"[^\w -]", "", title).strip().lower().replace(" ", "-") for title in titles}


@pytest.mark.parametrize("name", ["README.md", "ARCHITECTURE.md"])
def test_pages_that_are_read_first_are_short(name: str) -> None:
    assert (ROOT / name).stat().st_size <= MOST, f"{name}: move details to docs/guide or docs/inside.md"


@pytest.mark.parametrize("page", PAGES, ids=name_of)
def test_links_of_a_page_lead_to_files_and_headings(page: Path) -> None:
    text = prose(page)
    for target in re.findall(r"\]\(([^)\s]+)\)", text) + re.findall(r'<img src="([^"]+)"', text):
        if re.match(r"[a-z]+:", target):
            continue
        path, _, anchor = target.partition("#")
        there = Path(os.path.normpath(page.parent / path)) if path else page
        assert there.is_file(), f"{name_of(page)} links to {target}"
        assert not anchor or anchor in anchors(there), f"{name_of(page)} links to {target}"


def test_every_page_is_reached_from_the_readme() -> None:
    reached: set[Path] = set()
    waiting = [ROOT / "README.md"]
    while waiting:
        page = waiting.pop()
        if page not in reached:
            reached.add(page)
            found = re.findall(r"\]\(([^)\s#]+\.md)(?:#[^)]*)?\)", prose(page))
            waiting += [Path(os.path.normpath(page.parent / target)) for target in found]
    assert [name_of(page) for page in PAGES if page not in reached] == []


def test_the_first_screen_shows_what_it_does_with_two_commands_and_a_picture() -> None:
    first = "\n".join((ROOT / "README.md").read_text(encoding="utf-8").splitlines()[:16])
    assert len(re.findall(r"^make \w+", first, re.MULTILINE)) == 2
    assert "<img src=" in first


def test_the_map_lists_every_module_with_the_line_of_its_docstring() -> None:
    maker = runpy.run_path(str(ROOT / "docs" / "make_map.py"))
    written = (ROOT / "docs" / "map.md").read_text(encoding="utf-8")
    assert written == maker["whole"](), (
        "docs/map.md is not what the modules say of themselves: run `make map`"
    )
    modules = [path for path in (ROOT / "lamc").rglob("*.py") if path.name != "__init__.py"]
    packages = {path.relative_to(ROOT / "lamc").parts[0] for path in modules if path.parent != ROOT / "lamc"}
    for path in modules:
        parts = path.relative_to(ROOT / "lamc").parts
        assert f"| `{'/'.join(parts[1:] or parts)}` |" in written
    assert packages == set(re.findall(r"^## lamc/(\w+)$", written, re.MULTILINE))


def test_the_floors_of_the_architecture_are_those_of_the_contract_in_their_order() -> None:
    contracts = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["tool"]["importlinter"]
    (layers,) = [contract["layers"] for contract in contracts["contracts"] if contract["type"] == "layers"]
    held = [name for name in reversed(layers) if name != "__main__"]
    table = (ROOT / "ARCHITECTURE.md").read_text(encoding="utf-8").split("## Floors")[1].split("\n## ")[0]
    rows = re.findall(r"^\| (`[^|]*) \|", table, re.MULTILINE)
    assert [name for row in rows for name in re.findall(r"`(\w+)`", row)] == held


def test_each_decision_has_its_row_and_says_what_was_decided() -> None:
    index = (ROOT / "docs" / "decisions" / "index.md").read_text(encoding="utf-8")
    rows = re.findall(r"^\| (\d{3}) \| \[(.*)\]\((.*)\) \|$", index, re.MULTILINE)
    assert sorted(file for _, _, file in rows) == [path.name for path in DECISIONS]
    for number, title, file in rows:
        text = (ROOT / "docs" / "decisions" / file).read_text(encoding="utf-8")
        assert text.startswith(f"# {number} {title}\n")
        assert file.startswith(f"{number}-")
        assert "\n## Decision\n\n" in text
    numbers = [path.name[:3] for path in DECISIONS]
    assert numbers == [f"{k:03d}" for k in range(1, len(DECISIONS) + 1)]


def test_files_that_the_pages_name_by_their_path_exist() -> None:
    """Paths in backticks that begin with a folder of the repository; a star stands for any."""
    for page in PAGES:
        if page.name == "CHANGELOG.md":  # tells of what was
            continue
        for path in re.findall(
            r"`((?:lamc|tests|runtime_c|templates|benchmarks|docs|conda)/[\w./*-]*)`", prose(page)
        ):
            assert list(ROOT.glob(path.rstrip("/"))), f"{name_of(page)} names {path}"


def test_the_site_has_every_page() -> None:
    listed = set(
        re.findall(
            r"(?:- |: )([\w/-]+\.md)$", (ROOT / "mkdocs.yml").read_text(encoding="utf-8"), re.MULTILINE
        )
    )
    below = {path.relative_to(ROOT / "docs").as_posix() for path in (ROOT / "docs").rglob("*.md")}
    at_root = {path.name for path in ROOT.glob("*.md")} - {"README.md"}
    made = set(runpy.run_path(str(ROOT / "docs" / "make_reference.py"))["NAMES"])
    assert listed == below | at_root | made | {"index.md"}


def test_the_citation_has_the_version_of_the_code() -> None:
    citation = (ROOT / "CITATION.cff").read_text(encoding="utf-8")
    recipe = (ROOT / "conda" / "recipe" / "recipe.yaml").read_text(encoding="utf-8")
    version = lamc.__version__
    assert f"\nversion: {version}\n" in citation
    assert f'\n  version: "{version}"\n' in recipe


def test_the_recipe_asks_for_what_the_package_asks_for() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    recipe = (ROOT / "conda" / "recipe" / "recipe.yaml").read_text(encoding="utf-8").split("\n  run:\n")[1]
    asked = set(re.findall(r"^    - ([\w.-]+ [>=.\d]+)$", recipe.split("\ntests:")[0], re.MULTILINE))
    for wanted in project["dependencies"]:
        name, least = re.fullmatch(r"([\w.-]+)(>=[\d.]+)", wanted).groups()  # type: ignore[union-attr]
        assert f"{'matplotlib-base' if name == 'matplotlib' else name} {least}" in asked
