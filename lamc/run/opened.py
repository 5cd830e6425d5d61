"""Memory that one call of compiled code has to itself.

In: a `Model` and the constants that its parameters give. Out: a `lamc_motion` whose constants and work space nobody
else touches until the call is over. Never: interprets a number.

The C writes to a motion while it evaluates it: modes of guards go into the constants, factors and residuals into the
work space, and cffi releases the GIL during every call. Two threads that ask one motion would therefore read each
other's numbers. A lock would be simpler, but would make every evaluation wait for a whole run.
"""

from types import TracebackType
from typing import TYPE_CHECKING, Any

import numpy as np

from lamc.run.request import Array

if TYPE_CHECKING:
    from lamc.run.following import Recorded
    from lamc.run.model import Model


class Opened:
    """A `lamc_motion` for one call at a time: `with pool.opened() as handle`."""

    def __init__(self, pool: "OpenedPool") -> None:
        self._pool = pool
        self.constants = pool.constants.copy()  # keeps the memory alive, as does `work`
        self.work = np.zeros(pool.work_size)
        model = pool.model
        self.handle: Any = model.ffi.new("lamc_motion *")
        self.handle.model = model.handle
        self.handle.constants = model.write(self.constants)
        self.handle.baumgarte = pool.baumgarte
        pool.follow(self.handle)
        if pool.work_size:
            self.handle.work = model.write(self.work)

    def __enter__(self) -> Any:
        return self.handle

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._pool.take_back(self)


class OpenedPool:
    """As many `Opened` as are in use at the same time, of one model with one set of constants.

    constants  (constant_count,), at least one, as the model's `setup` wrote them; never changed here
    work_size  doubles of work space, as this very model says: models of one mechanism with and without powers differ
    """

    def __init__(
        self, model: "Model", constants: Array, baumgarte: float, recorded: "Recorded | None" = None
    ) -> None:
        self.model = model
        self._recorded = recorded
        self.constants = constants
        self.baumgarte = baumgarte
        self.work_size = int(model.lib.lamc_motion_work_size(model.handle))
        self._free: list[Opened] = []  # `pop` and `append` are atomic

    def opened(self) -> Opened:
        """Memory as new, whatever earlier calls left in it: what a call answers does not depend on those before it."""
        try:
            found = self._free.pop()
        except IndexError:
            return Opened(self)
        found.constants[:] = self.constants
        self.follow(found.handle)
        found.work.fill(0.0)
        return found

    def follow(self, handle: Any) -> None:
        """Lets inputs follow their series, without breaks."""
        if self._recorded is not None:
            handle.recording = self._recorded.handle

    def take_back(self, opened: Opened) -> None:
        """Keeps the memory for a later call."""
        self._free.append(opened)
