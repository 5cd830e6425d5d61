"""Fixtures and options that many tests share."""

import os
from pathlib import Path

import pytest


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption(
        "--update-golden", action="store_true", help="rewrite tests/golden and print what changed as a diff"
    )


@pytest.fixture(scope="session")
def shared() -> Path:
    """The folder of reference answers and drawings beside the checkout; tests skip without it."""
    folder = Path(__file__).resolve().parent.parent.parent / "shared"
    if not (folder / "reference" / "dynamics.json").is_file():
        pytest.skip("the folder of reference answers (../shared) is not beside this checkout")
    return folder


@pytest.fixture(scope="session", autouse=True)
def cache_of_the_session(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A cache of compiled modules for this run: tests meet no old entry and leave none with the user.

    Parallel workers share it, so that each mechanism is compiled once.
    """
    base = tmp_path_factory.getbasetemp()
    folder = (base.parent if "PYTEST_XDIST_WORKER" in os.environ else base) / "lamc-cache"
    folder.mkdir(mode=0o700, exist_ok=True)
    os.environ["LAMC_CACHE_DIR"] = str(folder)
    return folder
