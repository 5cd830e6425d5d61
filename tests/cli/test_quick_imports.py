"""What a command that draws imports, and how."""

import subprocess
import sys
from pathlib import Path

import pytest

from tests.support.ctools import needs_cc


@pytest.mark.slow
@needs_cc
def test_a_run_imports_matplotlib_without_what_nobody_reads(tmp_path: Path) -> None:
    """In a process of its own, as a command is: setters' docstrings name no properties, and all else is as before."""
    words = (
        "import gc, sys\n"
        "from lamc.cli import main\n"
        f"sys.argv = ['lamc', 'run', '--example', 'pendulum', '--t-end', '0.1', '--out', {str(tmp_path / 'out')!r}]\n"
        "try: main()\n"
        "except SystemExit as ended: assert not ended.code\n"
        "from matplotlib import artist, lines\n"
        "print('LISTED', 'antialiased' in (lines.Line2D.set.__doc__ or ''), gc.isenabled(), artist.kwdoc.__name__)\n"
    )
    done = subprocess.run([sys.executable, "-c", words], capture_output=True, text=True, check=True)
    assert done.stdout.splitlines()[-1] == "LISTED False True kwdoc"
