"""`lamc bench`: symbolic against generated on a user's own design. Out: a table, bench.json and bench.png."""

import json

from lamc.basics.files import write_text
from lamc.basics.renewal import digests, renewed
from lamc.basics.times import Times
from lamc.commands.inputs import SceneChanges, Source, changed_scene, load_source, mechanism_of, output_folder
from lamc.commands.terminal import Terminal, plain
from lamc.ledger.bench import measure
from lamc.report.bench import bench_table, draw_bench


def bench(source: Source, changes: SceneChanges, out: str | None, terminal: Terminal) -> int:
    """Measures, writes, prints."""
    times = Times()
    with terminal.progress() as progress:
        times.observer = progress.stage
        loaded = load_source(source, times, progress)
        with output_folder(out, loaded.name) as folder:
            mechanism = mechanism_of(loaded, times, progress)
            scene, _ = changed_scene(mechanism, changes)
            measured = measure(mechanism, scene, source.options, progress.stage)
            data = {"ok": True, **measured.to_dict(), "files": ["bench.json", "bench.png"]}
            with renewed(folder, "bench.json", lambda _: set()) as staged:
                draw_bench(measured, staged / "bench.png")
                sums = digests(staged, ["bench.png"])
                write_text(staged / "bench.json", json.dumps(plain(data | {"sha256": sums}), indent=2) + "\n")
    terminal.say(f"{bench_table(measured)}\n\nfiles   {folder}: bench.json, bench.png")
    terminal.result(data | {"folder": str(folder)})
    return 0
