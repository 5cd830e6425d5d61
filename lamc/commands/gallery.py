"""`lamc examples --picture FILE`: every example, run for a while and drawn folded, on one sheet.

In: the file to write. Out: a PNG file.
"""

from pathlib import Path

from lamc import examples
from lamc.commands.examples import mechanism_of_example
from lamc.commands.terminal import Terminal
from lamc.pipeline import compile as compile_design
from lamc.report.contact_sheet import draw_contact_sheet


def picture(path: str, terminal: Terminal) -> int:
    """Runs every example for a while and draws them, folded, on one sheet."""
    target = Path(path)
    with terminal.progress() as progress:
        runs = []
        for name in examples.names():
            if Path(name).suffix:  # somebody else's file of a device that is there already
                continue
            progress.stage(f"run {name}")
            simulator = compile_design(mechanism_of_example(examples.find(name)))
            runs.append((name, simulator.run(t_end=1.0, rtol=1e-6, atol=1e-8)))
        progress.stage("draw")
        draw_contact_sheet(runs, target)
    terminal.say(f"file    {target}")
    terminal.result({"ok": True, "picture": str(target), "examples": [name for name, _ in runs]})
    return 0
