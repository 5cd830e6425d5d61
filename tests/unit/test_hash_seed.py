"""Equal designs give equal bytes in processes with other orders of sets: two processes make everything once each."""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from tests.support.paths import ROOT
from tests.support.quick import QUICKLY, with_runtime

_DIGESTS = """
import hashlib, json
from lamc.codegen.emit_element import emit_element
from lamc.commands.examples import mechanism_of_example
from lamc.examples import find
from lamc.export import files_of
from lamc.plates.elements.build import element_program
from lamc.plates.elements.library import element
from tests.export.test_export_amalgam import hostile
from tests.unit.test_codegen import MECHANISMS, made

def digest(files):
    parts = [x if isinstance(x, bytes) else x.encode() for name in sorted(files) for x in (name, files[name])]
    return hashlib.sha256(b"/".join(parts)).hexdigest()

found = {}
for name in ("small", "tree"):
    program, tree = made(MECHANISMS[name])
    found[name] = [program.digest, digest(tree.files)]
found["element"] = digest(emit_element(element_program(element("bciz"))).files)
found["names of C"] = digest(files_of(hostile()))
found["folder with a picture"] = digest(files_of(mechanism_of_example(find("four_bar"))))
print(json.dumps(found))
"""


@pytest.fixture(scope="module")
def digests(tmp_path_factory: pytest.TempPathFactory, cache_of_the_session: Path) -> list[dict[str, object]]:
    """What two processes with different hash seeds make, by kind; neither finds what the other has made."""
    own = {
        seed: str(with_runtime(tmp_path_factory.mktemp("cache"), cache_of_the_session))
        for seed in ("1", "4242")
    }
    started = [
        subprocess.Popen(
            [sys.executable, "-c", QUICKLY + _DIGESTS],
            env={**os.environ, "PYTHONHASHSEED": seed, "PYTHONPATH": str(ROOT), "LAMC_CACHE_DIR": cache},
            stdout=subprocess.PIPE,
            text=True,
            cwd=ROOT,
        )
        for seed, cache in own.items()
    ]
    printed = [process.communicate(timeout=300)[0] for process in started]
    return [json.loads(text) for text in printed]


@pytest.mark.parametrize("kind", ["small", "tree", "element", "names of C", "folder with a picture"])
@pytest.mark.slow
def test_equal_designs_give_equal_bytes_on_every_hash_seed(
    kind: str, digests: list[dict[str, object]]
) -> None:
    one, other = digests
    assert one[kind] == other[kind]
