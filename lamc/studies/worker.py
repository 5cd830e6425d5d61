"""A process that works on points for another: `python -c "from lamc.studies.worker import serve; serve()"`.

On stdin come pickles: the search path, the subject (its `bench` is what works), then lists of (number, point). On
stdout go pickles: READY, then a `Row` for each point in its order, or the exception that ends the study. Both are pipes
of the process that started this one: no pickle ever comes from a file. Whatever else prints on stdout goes to stderr.
It ends when stdin does, and leaves Ctrl-C to the process that started it.
"""

import os
import pickle
import signal
import sys
import warnings
from typing import Any

READY = "ready"


def serve() -> None:
    """Works until stdin ends."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    answers = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)
    questions: Any = sys.stdin.buffer

    def answer(what: object) -> None:
        pickle.dump(what, answers)
        answers.flush()

    try:
        sys.path[:] = pickle.load(questions)
        from lamc.basics.errors import DesignWarning  # found by this path

        warnings.simplefilter("ignore", DesignWarning)
        bench = pickle.loads(pickle.load(questions)).bench()
        answer(READY)
    except Exception as error:
        answer(RuntimeError(f"{type(error).__name__}: {error}"))
        return
    while True:
        try:
            chunk = pickle.load(questions)
        except EOFError:
            return
        for index, point in chunk:
            try:
                row: object = bench.row(index, point)
            except Exception as error:
                row = error
            answer(row)
