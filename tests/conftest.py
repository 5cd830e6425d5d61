"""Fixtures and options that many tests share, and the environment that all of them run in."""

import gc
import os
import shutil
import signal
import sys
import tempfile
from collections.abc import Iterator
from fnmatch import fnmatchcase
from pathlib import Path

import pytest
from hypothesis import settings

from tests.support.quick import quick_compilation, unpainted_figures

FOREIGN = {  # variables of developers' machines
    *("CFLAGS", "CPPFLAGS", "LDFLAGS", "PYTHONDONTWRITEBYTECODE"),
    *("XDG_CACHE_HOME", "XDG_CONFIG_HOME", "XDG_DATA_HOME", "XDG_STATE_HOME"),
}
settings.register_profile("quick", derandomize=True)
settings.register_profile("thorough", derandomize=True)  # CI's answer goes by the change, and not by chance
settings.register_profile("new")
NOWHERE = "/proc/nowhere"  # a home that nobody can make or write to, root neither


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption(
        "--update-golden",
        action="store_true",
        help="rewrite tests/golden and tests/view/kept, and print what changed as a diff",
    )
    parser.addoption(
        "--hostile",
        action="store_true",
        help="run with umask 077 and with a home that cannot be written; `make test-hostile` closes stderr too",
    )
    parser.addoption(
        "--as-shipped",
        action="store_true",
        help="compile models and exports with the flags that users get; without it tests compile quickly",
    )
    parser.addoption(
        "--thorough",
        action="store_true",
        help="have hypothesis try five times as many examples, the same ones in each run",
    )
    parser.addoption(
        "--new-examples",
        action="store_true",
        help="have hypothesis try five times as many examples, other ones in each run",
    )


def pytest_configure(config: pytest.Config) -> None:
    """The plain environment of a user, for these tests and for the programs that they start.

    Home and cache are new and empty, and shared by parallel workers, so that tests meet no old entry, leave none with
    the user, and compile each mechanism once.
    """
    is_worker = "PYTEST_XDIST_WORKER" in os.environ
    for name in sorted(os.environ):
        of_lamc = (
            name.startswith("LAMC_") and name != "LAMC_CC" and not (is_worker and name == "LAMC_CACHE_DIR")
        )
        if name in FOREIGN or of_lamc:
            del os.environ[name]
    sys.dont_write_bytecode = False
    # Ignored in what a shell starts behind its back, and in all that is started from there: tests of Ctrl-C would wait.
    if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
        signal.signal(signal.SIGINT, signal.default_int_handler)
    thorough = "thorough" if config.getoption("--thorough") else "quick"
    settings.load_profile("new" if config.getoption("--new-examples") else thorough)
    hostile = config.getoption("--hostile")
    os.umask(0o077 if hostile else 0o022)
    if is_worker:
        return
    for name, place in (
        ("RUSTUP_HOME", ".rustup"),
        ("CARGO_HOME", ".cargo"),
    ):  # where these tools live themselves
        os.environ.setdefault(name, str(Path("~").expanduser() / place))
    folder = Path(tempfile.mkdtemp(prefix="lamc-tests-"))
    config.add_cleanup(lambda: shutil.rmtree(folder, ignore_errors=True))
    for name in ("home", "cache"):
        (folder / name).mkdir(mode=0o700)
    os.environ["LAMC_CACHE_DIR"] = str(folder / "cache")
    os.environ["HOME"] = NOWHERE if hostile else str(folder / "home")


@pytest.hookimpl(tryfirst=True)  # before pytest chooses by marks
def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """`quick` and `ci` name parameters of a test, by patterns of their ids: those that `make test` runs, and those that
    `.ci/run` runs. Others are slow, or campaigns, which are slow too; those of `quick` as its `others` says."""
    unmet: dict[tuple[str, str], set[str]] = {}  # patterns that no parameter has met, by test and mark
    for item in items:
        for name, otherwise in (("quick", "slow"), ("ci", "campaign")):
            mark = item.get_closest_marker(name)
            if mark is None or not isinstance(item, pytest.Function):
                continue
            met = {pattern for pattern in mark.args if fnmatchcase(item.callspec.id, pattern)}
            unmet.setdefault((item.nodeid.partition("[")[0], name), set(mark.args)).difference_update(met)
            if not met:
                item.add_marker(mark.kwargs.get("others", otherwise))
        if item.get_closest_marker("campaign") is not None:
            item.add_marker("slow")
    if not any("::" in argument for argument in config.args):  # all parameters were collected
        lost = [f"mark.{name} of {test}: {sorted(left)}" for (test, name), left in unmet.items() if left]
        if lost:
            raise pytest.UsageError(f"no parameter has an id like {'; '.join(lost)}")


def pytest_collection_finish() -> None:
    """What is there now, modules and seven thousand tests, stays to the end: the garbage collector need not walk
    through it again and again, which took a twentieth of the time."""
    gc.collect()
    gc.freeze()


@pytest.fixture(scope="session")
def shared() -> Path:
    """Reference answers and drawings: the folder beside the checkout if it is there, else the copies kept here."""
    tests = Path(__file__).resolve().parent
    beside = tests.parent.parent / "shared"
    return beside if (beside / "reference" / "dynamics.json").is_file() else tests / "fixtures"


@pytest.fixture(scope="session")
def cache_of_the_session() -> Path:
    """The cache of compiled modules that this run has for itself."""
    return Path(os.environ["LAMC_CACHE_DIR"])


@pytest.fixture(scope="session", autouse=True)
def _quick(request: pytest.FixtureRequest, cache_of_the_session: Path) -> Iterator[None]:
    if request.config.getoption("--as-shipped"):
        yield
        return
    with quick_compilation(cache_of_the_session):
        yield


@pytest.fixture
def unpainted() -> Iterator[None]:
    """Figures are composed and not painted, which takes a second each; for tests that do not look at pictures."""
    with unpainted_figures():
        yield


@pytest.fixture
def painted() -> None:
    """Figures are painted, in modules that leave it out elsewhere."""
