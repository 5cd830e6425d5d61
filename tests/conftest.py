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
    """Reference answers and drawings: the folder beside the checkout if it is there, else the copies kept here."""
    tests = Path(__file__).resolve().parent
    beside = tests.parent.parent / "shared"
    return beside if (beside / "reference" / "dynamics.json").is_file() else tests / "fixtures"


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
