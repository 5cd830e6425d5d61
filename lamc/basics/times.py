"""How long the stages of a piece of work take, and who is told of them."""

import logging
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, nullcontext
from dataclasses import dataclass, field

from lamc.basics.progress import bar

logger = logging.getLogger("lamc")  # stages with their times
Observer = Callable[[str], None]  # told the name of each stage as it begins


@dataclass
class Times:
    """Seconds per stage, in the order in which they ran; `from_cache` if nothing had to be compiled."""

    seconds: dict[str, float] = field(default_factory=dict)
    from_cache: bool = False
    observer: Observer | None = None

    @contextmanager
    def stage(self, name: str) -> Iterator[None]:
        if self.observer is not None:
            self.observer(name)
        start = time.perf_counter()
        try:
            yield
        finally:
            taken = time.perf_counter() - start
            self.seconds[name] = self.seconds.get(name, 0.0) + taken
            logger.debug("%s: %.3g s", name, taken)

    @contextmanager
    def reported_to(self, progress: Observer | bool | None) -> Iterator[None]:
        """Tells `progress` of stages too while it lasts; True: a bar."""
        if not progress:
            yield
            return
        before = self.observer
        with nullcontext((progress, None)) if callable(progress) else bar("compile") as (stage, _):

            def both(name: str) -> None:
                stage(name)
                if before is not None:
                    before(name)

            self.observer = both
            try:
                yield
            finally:
                self.observer = before
