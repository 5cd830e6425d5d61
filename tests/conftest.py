"""Fixtures that many tests share."""

from pathlib import Path

import pytest


@pytest.fixture(scope="session")
def shared() -> Path:
    """The folder of reference answers and drawings beside the checkout; tests skip without it."""
    folder = Path(__file__).resolve().parent.parent.parent / "shared"
    if not (folder / "reference" / "dynamics.json").is_file():
        pytest.skip("the folder of reference answers (../shared) is not beside this checkout")
    return folder
