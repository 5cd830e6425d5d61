"""Records that can be looked at as a page: `.view()`, and what notebooks show of them.

In: the record. Out: a page, by what `drawing` has been told of its kind. Never: knows what a page is.
"""

import html
from pathlib import Path

from lamc.basics import drawing
from lamc.basics.errors import LamcError


class Viewable:
    """Base of what a page can show."""

    def view(
        self, path: str | Path | None = None, *, open_browser: bool | None = None, live: bool = True
    ) -> Path:
        """Writes one HTML file that shows this in 3D, needs no network and opens by a double click. Returns its path.

        path          None: a file of the design's name in the system's folder for temporary files
        open_browser  whether a browser opens it; None: where no path is given
        live          whether the model is put into it, if a compiler for WebAssembly is found

        Raises LamcError if the file cannot be written.
        """
        written: Path = drawing.drawer(_kind(self, "view"), "view")(self, path, open_browser, live)
        return written

    def _repr_html_(self) -> str:
        """The page in a frame, for notebooks; without the model, so that it is there at once."""
        try:
            framed: str = drawing.drawer(_kind(self, "frame"), "frame")(self)
        except LamcError as error:
            return f"<pre>{html.escape(repr(self))}\n{html.escape(str(error))}</pre>"
        return framed


def _kind(record: object, verb: str) -> str:
    """The nearest class of the record of which `drawing` knows the verb."""
    names = [each.__name__ for each in type(record).__mro__]
    return next((name for name in names if (name, verb) in drawing.registered()), names[0])
