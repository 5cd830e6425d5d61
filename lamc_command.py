"""What the command `lamc` calls: it is outside the package, so that Ctrl-C while that is imported ends as later on.

In: the words of the command line. Out: the process's exit code, as `lamc.cli` has it. It imports no package
itself.
"""

import gc
import os
import sys


def main() -> None:
    """Runs the command line; Ctrl-C during the imports is told in one line and is exit code 130."""
    if sys.argv[1:2] == [
        "run"
    ]:  # its matrices are small: threads that OpenBLAS starts would cost more than the run
        os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    gc.disable()  # what imports make stays: looking through it again and again is a tenth of them
    try:
        from lamc.cli import main as work
    except KeyboardInterrupt:
        if sys.stderr is not None:  # daemons have none
            print("error: interrupted; nothing was written", file=sys.stderr)
        raise SystemExit(130) from None
    finally:
        gc.enable()
    work()
