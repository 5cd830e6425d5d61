"""Imports of matplotlib for a command that ends soon: without what only a reader of its documentation needs.

In, out: nothing; what is imported within `quick_imports` is imported sooner. Never: changes what is drawn.
"""

import gc
from collections.abc import Iterator
from contextlib import contextmanager


@contextmanager
def quick_imports() -> Iterator[None]:
    """Within it, matplotlib's artists get no docstrings that list their properties, which take a third of its import,
    and nothing is collected: what imports make stays."""
    from matplotlib import artist

    kept = artist.kwdoc
    artist.kwdoc = lambda _artist: ""  # type: ignore[assignment]
    collecting = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        artist.kwdoc = kept
        if collecting:
            gc.enable()
