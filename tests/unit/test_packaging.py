"""The wheel holds all that lamc needs, and works outside the checkout."""

import ast
import importlib.metadata
import importlib.util
import os
import re
import shutil
import subprocess
import sys
import tomllib
import zipfile
from pathlib import Path

import pytest

from tests.support.ctools import needs_cc
from tests.support.paths import ROOT
from tests.support.quick import QUICKLY, with_runtime

CHECKOUT = ROOT
PARTS = (
    *("lamc", "lamc_command.py", "templates", "runtime_c"),
    *("pyproject.toml", "packaging_hook.py", "README.md", "LICENSE"),
)


@pytest.fixture(scope="module")
def wheel(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("wheel")
    source = folder / "source"
    for part in PARTS:
        ignored = shutil.ignore_patterns("__pycache__", "*.so", "*.o")
        if (CHECKOUT / part).is_dir():
            shutil.copytree(CHECKOUT / part, source / part, ignore=ignored)
        elif (CHECKOUT / part).is_file():
            source.mkdir(exist_ok=True)
            shutil.copy(CHECKOUT / part, source / part)
    command = [
        sys.executable,
        "-m",
        "pip",
        "wheel",
        "--quiet",
        "--no-deps",
        "--wheel-dir",
        str(folder),
        str(source),
    ]
    if importlib.util.find_spec("hatchling") is not None:
        command.insert(4, "--no-build-isolation")
    done = subprocess.run(command, capture_output=True, text=True, timeout=300, check=False)
    if done.returncode != 0 and "No matching distribution found for hatchling" in done.stderr:
        pytest.skip("hatchling is neither installed nor to be had from an index: pip install hatchling")
    assert done.returncode == 0, done.stderr[-3000:]
    (made,) = folder.glob("*.whl")
    return made


@pytest.mark.slow
def test_the_wheel_holds_templates_runtime_and_examples(wheel: Path) -> None:
    names = set(zipfile.ZipFile(wheel).namelist())
    for folder, target in (("templates", "lamc/_data/templates"), ("runtime_c", "lamc/_data/runtime_c")):
        for path in sorted((CHECKOUT / folder).rglob("*.[chj]*")):
            if path.is_file() and path.suffix in (".c", ".h", ".j2"):
                assert f"{target}/{path.relative_to(CHECKOUT / folder).as_posix()}" in names
    assert "lamc_command.py" in names
    assert "lamc/examples/pendulum.cad" in names
    assert "lamc/examples/plates/strip.yaml" in names
    assert "lamc/py.typed" in names or not (CHECKOUT / "lamc" / "py.typed").exists()
    assert not [name for name in names if name.startswith(("tests/", "benchmarks/"))]
    assert not [name for name in names if "__pycache__" in name or name.endswith((".so", ".o"))]


_USE = """
import json, sys
from pathlib import Path
import lamc, lamc.basics.resources
design = lamc.load(Path(lamc.__file__).parent / "examples" / "pendulum.cad")
result = lamc.compile(design).run(t_end=0.1)
print(json.dumps([lamc.__file__, str(lamc.basics.resources.data_dir("templates")), bool(result.success)]))
"""


@needs_cc
@pytest.mark.slow
def test_the_wheel_compiles_and_runs_a_design_outside_the_checkout(
    wheel: Path, tmp_path: Path, cache_of_the_session: Path
) -> None:
    site = tmp_path / "site"
    zipfile.ZipFile(wheel).extractall(site)
    cache = with_runtime(tmp_path / "cache", cache_of_the_session)
    environment = {**os.environ, "PYTHONPATH": str(site), "LAMC_CACHE_DIR": str(cache)}
    done = subprocess.run(
        [sys.executable, "-c", QUICKLY + _USE],
        env=environment,
        cwd=tmp_path,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr[-3000:]
    assert str(site / "lamc" / "__init__.py") in done.stdout
    assert str(site / "lamc" / "_data" / "templates") in done.stdout
    assert done.stdout.strip().endswith("true]")


@pytest.mark.slow
def test_tests_import_only_what_their_extra_installs() -> None:
    project = tomllib.loads((CHECKOUT / "pyproject.toml").read_text())["project"]
    asked = [*project["dependencies"], *project["optional-dependencies"]["test"]]
    declared = {re.split(r"[\[<>=~!]", requirement)[0].lower() for requirement in asked}
    provided = importlib.metadata.packages_distributions()
    for path in sorted((CHECKOUT / "tests").rglob("*.py")):
        for node in ast.parse(path.read_text()).body:
            if isinstance(node, ast.Import):
                roots = {name.name.partition(".")[0] for name in node.names}
            elif isinstance(node, ast.ImportFrom) and node.module is not None:
                roots = {node.module.partition(".")[0]}
            else:
                continue
            roots -= {"lamc", "lamc_command", "tests", "benchmarks"} | sys.stdlib_module_names
            unknown = {root for root in roots if not declared & {d.lower() for d in provided.get(root, [])}}
            assert not unknown, f"{path}:{node.lineno}: neither a dependency nor in the extra `test`"
