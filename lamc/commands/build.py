"""`lamc build`: leaves the generated C in a folder, and the equations as text if asked.

In: a design and a folder. Out: files, and an account of what the C costs. Files that lamc did not write, or that were
edited, are never overwritten.
"""

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from lamc.basics.numbers import duration
from lamc.basics.places import located_at
from lamc.basics.times import Times
from lamc.codegen.emit import SourceTree, emit
from lamc.commands.inputs import SceneChanges, Source, changed_scene, folder_name, load_source, mechanism_of
from lamc.commands.terminal import Terminal
from lamc.effects.registry import Choice
from lamc.export.folder import Origin, write_folder
from lamc.export.series import tables_of_scene
from lamc.pipeline import equations_of, sources_of
from lamc.report.equations_text import equations_tex, equations_txt, listing
from lamc.symbolic.program import Program

if TYPE_CHECKING:
    from lamc.mechanics.equations import Equations

_ALONE = "the mechanism alone"
_EQUATIONS = ("equations.txt", "equations.tex")


@dataclass(frozen=True, eq=False)
class Built:
    """What a build made."""

    folder: Path
    files: tuple[str, ...]
    tree: SourceTree
    program: Program
    equations: "Equations"
    account: tuple[Choice, ...]
    times: Times
    scenes: tuple[str, ...]  # there are in the design


def build(
    source: Source,
    changes: SceneChanges,
    out: str | None,
    *,
    equations: bool,
    force: bool,
    terminal: Terminal,
) -> int:
    """Writes the C of a design, and with `equations` also equations.txt and equations.tex."""
    times = Times()
    with terminal.progress() as progress:
        times.observer = progress.stage
        loaded = load_source(source, times, progress)
        mechanism = mechanism_of(loaded, times, progress)
        scene, account = changed_scene(mechanism, changes)
        with located_at(scene.places):
            derived = equations_of(mechanism, scene.effects or (), times, inputs=scene.inputs)
        program, tree = sources_of(derived, times)
        if program.series:
            tree = emit(program, recording=tables_of_scene(program, scene))
        texts = dict(sorted(tree.files.items()))
        if equations:
            with times.stage("write equations"):
                listed = listing(derived, mechanism.name)
                texts |= dict(zip(_EQUATIONS, (equations_txt(listed), equations_tex(listed)), strict=True))
        folder = Path(out) if out is not None else Path("out") / folder_name(f"{loaded.name[:50]}_build")
        contents = {name: text.encode() for name, text in texts.items()}
        files = write_folder(folder, contents, Origin(loaded.name, "build"), force=force)
    made = Built(folder, files, tree, program, derived, account, times, tuple(mechanism.scenes))
    terminal.say(_summary(made))
    terminal.result(_data(made))
    return 0


def _summary(made: Built) -> str:
    operations = made.equations.operations
    hinges = len(made.program.joints)
    per_hinge = f", {operations.flops / hinges:.1f} per hinge" if hinges else ""
    solvers = ", ".join(f"{way} {count}" for way, count in sorted(made.equations.solver_flops.items()))
    model = f"{made.tree.prefix}.c"
    size, lines = _size(made.tree.files[model])
    runtime = sum(len(text.encode()) for name, text in made.tree.files.items() if name != model)
    seconds = ", ".join(f"{name} {duration(value)}" for name, value in made.times.seconds.items())
    return "\n".join(
        [
            f"folder    {made.folder}",
            *(f"{'files' if k == 0 else '':<10}{name}" for k, name in enumerate(made.files)),
            *([f"scenes    {', '.join(made.scenes)} (--scene NAME)"] if made.scenes else []),
            f"effects   {', '.join(c.name for c in made.account if c.effect is not None) or 'none'}",
            f"solver    {made.equations.solver}" + (f" (operations: {solvers})" if solvers else ""),
            f"flops     {operations.flops} per right-hand side{per_hinge}: {_count(operations.additions, 'addition')}, "
            f"{_count(operations.multiplications, 'multiplication')}, {_count(operations.reciprocals, 'division')}; "
            f"and {_count(operations.calls, 'call')} of sin, cos and the like",
            *(f"{label:<10}{text}" for label, text in _costs(made.equations)),
            f"C size    {model} {size / 1000:.1f} kB, {lines} lines; runtime and headers {runtime / 1000:.1f} kB",
            f"times     {seconds}",
            f"compile   cd {made.folder} && cc -std=c11 -O2 *.c -lm -o {made.tree.prefix}",
        ]
    )


def _count(number: int, noun: str) -> str:
    return f"{number} {noun}{'' if number == 1 else 's'}"


def _size(text: str) -> tuple[int, int]:
    return len(text.encode()), text.count("\n")


def _costs(equations: "Equations") -> list[tuple[str, str]]:
    """What each effect adds to the operations of one right-hand side."""
    by_effect = equations.operations_by_effect
    width = max(len(name or _ALONE) for name in by_effect)
    whole = max(equations.operations.flops, 1)
    rows = []
    for name, cost in by_effect.items():
        calls = f", {_count(cost.calls, 'call')}" if cost.calls else ""
        rows.append(f"{name or _ALONE:<{width}}  {cost.flops:>6} flops, {cost.flops / whole:>6.1%}{calls}")
    return [("costs" if k == 0 else "", row) for k, row in enumerate(rows)]


def _data(made: Built) -> dict[str, Any]:
    operations = made.equations.operations
    hinges = len(made.program.joints)
    size, lines = _size(made.tree.files[f"{made.tree.prefix}.c"])
    return {
        "ok": True,
        "design": made.program.name,
        "folder": str(made.folder),
        "files": list(made.files),
        "prefix": made.tree.prefix,
        "digest": made.program.digest,
        "effects": [{"name": c.name, "in": c.effect is not None, "why": c.reason} for c in made.account],
        "solver": made.equations.solver,
        "solver_flops": dict(made.equations.solver_flops),
        "flops": operations.flops,
        "flops_per_hinge": operations.flops / hinges if hinges else None,
        "additions": operations.additions,
        "multiplications": operations.multiplications,
        "divisions": operations.reciprocals,
        "calls": operations.calls,
        "flops_by_effect": {
            name or _ALONE: c.flops for name, c in made.equations.operations_by_effect.items()
        },
        "model_bytes": size,
        "model_lines": lines,
        "parameters": [
            {
                "name": p.name,
                "default": p.default,
                "unit": p.unit,
                "meaning": p.meaning,
                "effect": p.effect,
                "input": p.is_input,
            }
            for p in made.program.parameters
        ],
        "seconds": dict(made.times.seconds),
    }
