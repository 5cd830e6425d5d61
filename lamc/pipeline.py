"""The compiler on one page: each stage takes the previous stage's record.

load → split → plan → derive → lower → emit → build. Nothing is remembered between two calls but the cache.
"""

import hashlib
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field, fields, is_dataclass
from functools import cache as memoise
from pathlib import Path
from typing import TYPE_CHECKING

from lamc._version import __version__
from lamc.codegen.cache import Cache, cache_root
from lamc.codegen.module import load_module
from lamc.codegen.toolchain import Compiler, find_compiler
from lamc.design.records import Design
from lamc.design.split import split
from lamc.effects.base import Effect
from lamc.effects.registry import EFFECTS, choose
from lamc.errors import BuildError, DesignError
from lamc.loops.rank import LoopCount, count_loops
from lamc.loops.starts import loops_of
from lamc.mechanics.arrangement import arrange
from lamc.mechanism.checks import shown
from lamc.mechanism.records import Body, Joint, Mechanism
from lamc.mechanism.tree import plan
from lamc.options import CompileOptions
from lamc.places import told_at
from lamc.resources import data_dir, stamps
from lamc.run.simulator import Simulator
from lamc.scene import Scene

if TYPE_CHECKING:
    from lamc.codegen.emit import SourceTree
    from lamc.codegen.program import Program
    from lamc.mechanics.equations import Equations

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
            self.seconds[name] = self.seconds.get(name, 0.0) + time.perf_counter() - start


def effects_of(mechanism: Mechanism, scene: Scene) -> tuple[Effect, ...]:
    """The effects that act, in the order of their names."""
    return tuple(choice.effect for choice in choose(mechanism, scene) if choice.effect is not None)


def equations_of(
    mechanism: Mechanism,
    effects: tuple[Effect, ...],
    times: Times | None = None,
    loops: LoopCount | None = None,
) -> "Equations":
    """plan and derive. loops: what the mechanism's loops come to; None: counted here."""
    from lamc.mechanics.derive import derive

    times = times or Times()
    with times.stage("plan"):
        tree = plan(mechanism)
    with times.stage("derive"):
        return derive(tree, effects, loops)


def sources_of(equations: "Equations", times: Times | None = None) -> "tuple[Program, SourceTree]":
    """lower and emit."""
    from lamc.codegen.emit import emit
    from lamc.codegen.lower import lower

    times = times or Times()
    with times.stage("lower"):
        program = lower(equations)
    with times.stage("emit"):
        return program, emit(program)


def compile(  # noqa: A001  the public name is lamc.compile
    design: Design | Mechanism,
    scene: Scene | None = None,
    options: CompileOptions | None = None,
    times: Times | None = None,
    cache: Cache | None = None,
) -> Simulator:
    """A simulator of `design` in `scene` (None: the design's own, else what the design asks for).

    cache: where compiled modules are kept; None: the user's own.

    Raises DesignError and its leaves for what cannot be simulated, BuildError without a working compiler or cache.
    """
    _check_arguments(design, scene, options, times)
    options = options or CompileOptions()
    times = times or Times()
    if isinstance(design, Design):
        with times.stage("split"):
            mechanism = split(design)
    else:
        mechanism = design
    scene = scene or mechanism.scene or Scene()
    with told_at(scene.places):
        return _compiled(mechanism, scene, options, times, cache or Cache(cache_root()))


def _compiled(
    mechanism: Mechanism, scene: Scene, options: CompileOptions, times: Times, cache: Cache
) -> Simulator:
    effects = effects_of(mechanism, scene)
    loops = None
    if len(mechanism.joints) > sum(not body.fixed for body in mechanism.bodies):
        with times.stage("plan"):
            loops = _loops_of(mechanism, effects, scene)
    compiler = find_compiler(options.compiler)
    alias = _input_digest(mechanism, effects, loops, compiler, options)
    with times.stage("load from cache"):
        key = cache.recall(alias) if alias else None
        folder = cache.find(key) if key else None
        module = load_module(folder) if folder else None

    @memoise
    def equations() -> "Equations":
        return equations_of(mechanism, effects, times, loops)

    @memoise
    def sources() -> "tuple[Program, SourceTree]":
        return sources_of(equations(), times)

    if module is not None:
        times.from_cache = True
    else:
        program, tree = sources()
        from lamc.codegen.build import build

        with times.stage("compile"):
            key, module, times.from_cache = build(tree, program.digest, compiler, options, cache)
        if alias:
            cache.remember(alias, key)
    return Simulator(mechanism, scene, effects, equations, lambda: sources()[0], module, loops)


def _loops_of(mechanism: Mechanism, effects: tuple[Effect, ...], scene: Scene) -> LoopCount:
    """What the loops come to that no bushing holds. Where hinges or bodies yield, rigid loops may leave no freedom."""
    arrangement = arrange(plan(mechanism), effects)
    if arrangement.compliant or arrangement.flexible:
        return count_loops(arrangement.tree, scene.closure_tolerance)
    return loops_of(arrangement.tree, scene)


def _check_arguments(design: object, scene: object, options: object, times: object) -> None:
    """Raises DesignError or BuildError for an argument of another type."""
    if isinstance(design, str | Path):
        raise DesignError(
            f"{str(design)!r} is no design but a path; write lamc.compile(lamc.load({str(design)!r}))"
        )
    if not isinstance(design, Design | Mechanism):
        raise DesignError(
            f"the design is {shown(design)}; it must be a Design or a Mechanism, as lamc.load gives"
        )
    if not isinstance(scene, Scene | None):
        raise DesignError(f"the scene is {shown(scene)}; it must be a Scene, or None")
    if not isinstance(options, CompileOptions | None):
        raise BuildError(f"options is {shown(options)}; it must be CompileOptions(…), or None")
    if not isinstance(times, Times | None):
        raise BuildError(f"times is {shown(times)}; it must be a Times, or None")


def _input_digest(
    mechanism: Mechanism,
    effects: tuple[Effect, ...],
    loops: LoopCount | None,
    compiler: Compiler,
    options: CompileOptions,
) -> str | None:
    """Digest of all that the compiled module follows from; None if an effect is not lamc's own.

    It lets a compile skip the derivation. An effect from elsewhere may change between two runs under the same name.
    """
    if any(type(effect) not in EFFECTS for effect in effects):
        return None
    text = hashlib.sha256()
    closure = f"{loops.rank} {loops.accepted_gap!r}" if loops is not None else ""
    for part in (__version__, _own_sources(), compiler.identity, *options.flags, mechanism.name, closure):
        text.update(part.encode())
        text.update(b"\0")
    records: tuple[Body | Joint, ...] = (*mechanism.bodies, *mechanism.joints)
    for record in records:
        for entry in fields(record):
            if entry.name != "outline":
                value = getattr(record, entry.name)
                text.update(value.tobytes() if hasattr(value, "tobytes") else repr(value).encode())
                text.update(b"\0")
    for effect in effects:
        assert is_dataclass(effect)
        text.update(repr(effect).encode())
    return text.hexdigest()


@memoise
def _own_sources() -> str:
    """Names, sizes and times of the files that shape the C, so that work on lamc itself never meets stale code."""
    package = Path(__file__).parent
    folders = [package / name for name in ("mechanism", "loops", "mechanics", "effects", "codegen")]
    folders += [data_dir("templates"), data_dir("runtime_c") / "include", data_dir("runtime_c") / "src"]
    return stamps(folders)
