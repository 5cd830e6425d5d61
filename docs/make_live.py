"""Pages of the gallery that run, for the site: each example as `lamc view --example NAME` shows it.

In: nothing. Out: HTML by name. What is compiled is kept in lamc's cache. Raises LamcError where an example
does not run.
"""

import lamc
from lamc import examples
from lamc.export.pages import result_show
from lamc.readers.load import load_text
from lamc.view.document import page


def live_pages() -> dict[str, str]:
    """The text of each example's page."""
    return {name: live_page(name) for name in examples.names()}


def live_page(name: str) -> str:
    example = examples.find(name)
    simulator = lamc.compile(load_text(example.text, example.file_name))
    return page([result_show(simulator.run(), live=True)])
