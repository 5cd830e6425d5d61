"""`lamc convert`: what a file holds, as another format.

In: a file and what a user says of its sheet, a file to write. Out: that file, and lines of what it does not hold.
"""

from pathlib import Path

from lamc.basics.times import Times
from lamc.commands.inputs import Source, load_source
from lamc.commands.terminal import Terminal
from lamc.export.conversions import check_place, converted, design_beside, write


def convert(source: Source, target: str, terminal: Terminal, *, force: bool) -> int:
    """Writes the file, and says what is lost."""
    path, read = Path(target), Path(source.file or "")
    check_place(read, path, force=force)
    times = Times()
    with terminal.progress() as progress:
        times.observer = progress.stage
        loaded = load_source(source, times, progress)
        with times.stage("convert"):
            made = converted(loaded.record, path, read)
            write(made, path, force=force)
    lines = [f"file      {path}  {len(made.content) / 1000:.1f} kB"]
    lines += [f"{'lost' if k == 0 else '':<10}{what}" for k, what in enumerate(made.lost)]
    if made.again:
        read_so = "the same device" if made.same else "it, but for what is lost"
        lines.append(f"options   {made.again}: with these lamc reads {read_so}")
    if made.design is not None:
        lines.insert(
            1, f"design    {design_beside(path)}  takes its shapes from it: lamc reads the same device"
        )
    terminal.say("\n".join(lines))
    data = {"ok": True, "file": str(path), "bytes": len(made.content), "lost": list(made.lost)}
    beside = str(design_beside(path)) if made.design is not None else None
    terminal.result({**data, "options": made.again, "same": made.same, "design": beside})
    return 0
