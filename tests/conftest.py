"""Fixtures and options that many tests share, and the environment that all of them run in."""

import os
import signal
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import BinaryIO

import pytest
from matplotlib.figure import Figure

from tests.support.quick import quick_compilation

FOREIGN = {"CFLAGS", "CPPFLAGS", "LDFLAGS", "PYTHONDONTWRITEBYTECODE"}  # variables of developers' machines


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption(
        "--update-golden", action="store_true", help="rewrite tests/golden and print what changed as a diff"
    )
    parser.addoption(
        "--as-shipped",
        action="store_true",
        help="compile models and exports with the flags that users get; without it tests compile quickly",
    )


def pytest_configure() -> None:
    """The plain environment of a user, for these tests and for the programs that they start."""
    for name in sorted(os.environ):
        if name in FOREIGN or (name.startswith("LAMC_") and name != "LAMC_CC"):
            del os.environ[name]
    sys.dont_write_bytecode = False
    # Ignored in what a shell starts behind its back, and in all that is started from there: tests of Ctrl-C would wait.
    if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
        signal.signal(signal.SIGINT, signal.default_int_handler)
    os.umask(0o022)


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
    folder = _of_the_session(tmp_path_factory, "lamc-cache")
    os.environ["LAMC_CACHE_DIR"] = str(folder)
    return folder


@pytest.fixture(scope="session", autouse=True)
def home_of_the_session(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A home that nothing was ever written to, and no folders named elsewhere; parallel workers share it."""
    folder = _of_the_session(tmp_path_factory, "home")
    for name in ("XDG_CACHE_HOME", "XDG_CONFIG_HOME", "XDG_DATA_HOME", "XDG_STATE_HOME"):
        os.environ.pop(name, None)
    for name, place in (
        ("RUSTUP_HOME", ".rustup"),
        ("CARGO_HOME", ".cargo"),
    ):  # where these tools live themselves
        os.environ.setdefault(name, str(Path.home() / place))
    os.environ["HOME"] = str(folder)
    return folder


@pytest.fixture(scope="session", autouse=True)
def _quick(request: pytest.FixtureRequest, cache_of_the_session: Path) -> Iterator[None]:
    if request.config.getoption("--as-shipped"):
        yield
        return
    with quick_compilation(cache_of_the_session):
        yield


@pytest.fixture
def unpainted(monkeypatch: pytest.MonkeyPatch) -> None:
    """Figures are composed and not painted, which takes a second each; for tests that do not look at pictures."""

    def savefig(_figure: Figure, stream: BinaryIO, **_settings: object) -> None:
        stream.write(b"\x89PNG\r\n\x1a\n")

    monkeypatch.setattr(Figure, "savefig", savefig)


@pytest.fixture
def painted() -> None:
    """Figures are painted, in modules that leave it out elsewhere."""


def _of_the_session(factory: pytest.TempPathFactory, name: str) -> Path:
    base = factory.getbasetemp()
    folder = (base.parent if "PYTEST_XDIST_WORKER" in os.environ else base) / name
    folder.mkdir(mode=0o700, exist_ok=True)
    return folder
