"""Bars of progress for `progress=True`: in notebooks and on terminals by tqdm where it is installed, else by rich.

In: a title, what is done of how much. Out: a bar, taken away when the work ends. Never: shows anything unasked.
"""

from collections.abc import Callable, Iterator
from contextlib import contextmanager, nullcontext
from importlib import import_module
from typing import Any

Part = Callable[[float, float], None]


@contextmanager
def bar(title: str) -> Iterator[tuple[Callable[[str], None], Part]]:
    """Gives what is told the name of what is being done, and what is told how much of how much is done."""
    try:
        tqdm: Any = import_module("tqdm.auto").tqdm  # the widget in notebooks, a line of text on terminals
    except ImportError:
        yield from _by_rich(title)
        return
    with tqdm(
        total=1.0,
        desc=title,
        leave=False,
        bar_format="{desc} {percentage:3.0f}%|{bar}| {elapsed}, {remaining} left",
    ) as shown:

        def stage(name: str) -> None:
            shown.set_description_str(f"{title}: {name}")

        def part(done: float, total: float) -> None:
            shown.update((done / total if total > 0.0 else 1.0) - shown.n)

        yield stage, part


@contextmanager
def part_told(title: str, progress: Part | bool | None) -> Iterator[Part | None]:
    """What is told how much of how much is done: `progress` itself, or for True a bar while it lasts."""
    if not isinstance(progress, bool):
        yield progress
        return
    with bar(title) if progress else nullcontext((None, None)) as (_, part):
        yield part


def _by_rich(title: str) -> Iterator[tuple[Callable[[str], None], Part]]:
    from rich.console import Console
    from rich.progress import Progress

    with Progress(console=Console(stderr=True), transient=True) as shown:  # with the time left
        task: Any = shown.add_task(title, total=1.0)
        yield (
            lambda name: shown.update(task, description=f"{title}: {name}"),
            lambda done, total: shown.update(task, completed=done / total if total > 0.0 else 1.0),
        )
