"""`build`: compiles a SourceTree and loads it through cffi, by way of the cache.

Comes out: a Module. The runtime is the same for every model: its objects are compiled once for a compiler and its
flags, and are an entry of the cache of their own. The library is plain C and is opened by a binding that cffi makes
from the declarations of the same headers that C users include; neither needs Python's own headers. Nothing is written
outside the cache.
"""

import hashlib
import io
import re
import sys
from collections.abc import Callable, Mapping, Sequence
from functools import cache
from pathlib import Path

import cffi
from cffi import recompiler

from lamc.basics._version import __version__
from lamc.basics.errors import BuildError
from lamc.codegen.cache import Cache
from lamc.codegen.emit import EXAMPLE, SourceTree, without_numbers
from lamc.codegen.module import BINDING, LIBRARY, SOURCES, Module, load_module
from lamc.codegen.options import MACHINE, CompileOptions
from lamc.codegen.toolchain import Compiler, make_library, make_objects

# The unit of the library: the C of the model, the element or the ply, and the generic name under which the Python side
# asks for it, whatever its prefix is.
_THIS = """{text}
const lamc_{kind} *lamc_this_{kind}(void);

const lamc_{kind} *lamc_this_{kind}(void) {{ return {prefix}_{kind}(); }}
"""

# Characters of a model's C from which on it is compiled with -O1, measured with gcc 12: a Miura sheet of 16 x 16 facets
# (1.6 MB) takes 9 s of processor time in place of 14, and an evaluation 0.37 ms in place of 0.41, as so much straight
# code waits for memory; 5 x 5 waterbombs (1.4 MB) 10 s in place of 15, and 1.46 ms in place of 1.47. The runtime, in
# which dense parts are solved, keeps -O2: without it the waterbombs lose a fifth.
LARGE = 500_000
_COMMENT = re.compile(r"/\*.*?\*/", re.DOTALL)


def module_key(structure: str, compiler: Compiler, options: CompileOptions, tree: SourceTree) -> str:
    """Everything that can change the binary but numbers of a design, as one digest."""
    parts = [
        structure,
        __version__,
        compiler.identity,
        *_flags(tree, options),
        sys.implementation.cache_tag or "",
    ]
    for name in sorted(set(tree.files) - {EXAMPLE}):
        parts += [name, without_numbers(tree.files[name])]
    return hashlib.sha256("\0".join(parts).encode()).hexdigest()


def build(
    tree: SourceTree, structure: str, compiler: Compiler, options: CompileOptions, cache: Cache
) -> tuple[str, Module, bool]:
    """Compiles `tree` unless the cache has it. Returns (key, module, was it in the cache).

    Raises BuildError if the compiler fails or the cache cannot be used.
    """
    key = module_key(structure, compiler, options, tree)
    folder = cache.find(key)
    found = folder is not None
    if folder is None:
        noted = {
            "compiler": " ".join(compiler.command),
            "flags": " ".join(_flags(tree, options)),
            "lamc": __version__,
        }
        objects = _runtime_objects(tree, compiler, options, cache, noted)
        objects += _function_objects(tree, compiler, options, cache, noted)
        folder = cache.put(key, _maker(tree, objects, compiler, options), noted)
    return key, load_module(folder), found


def _runtime_objects(
    tree: SourceTree, compiler: Compiler, options: CompileOptions, cache: Cache, noted: Mapping[str, str]
) -> list[Path]:
    """Objects of the runtime, from the cache or compiled into it."""
    files = {name: tree.files[name] for name in tree.shared}
    units = [name for name in tree.compiled if name in tree.shared]
    if not units:
        return []
    parts = ["runtime", __version__, compiler.identity, *options.flags]
    digest = hashlib.sha256("\0".join([*parts, *files, *files.values()]).encode()).hexdigest()
    key, objects = f"runtime-{digest}", [f"{Path(name).stem}.o" for name in units]

    def make(folder: Path) -> None:
        for name, text in files.items():
            (folder / name).write_text(text, encoding="utf-8", newline="\n")
        make_objects(compiler, options.flags, units, folder)

    folder = cache.find(key) or cache.put(key, make, noted)
    return [folder / name for name in objects]


def _function_objects(
    tree: SourceTree, compiler: Compiler, options: CompileOptions, cache: Cache, noted: Mapping[str, str]
) -> list[Path]:
    """Objects of a large model's functions, in as many units as two processors compile at once; none of a small one, of
    which it would take longer to read the headers twice. What its loops come to is no matter to them: on a branch of
    another rank they are found."""
    if not _is_apart(tree, options):
        return []
    _, includes, *functions, _ = tree.pieces
    header = f"{tree.prefix}.h"
    units = {f"functions_{k}.c": includes + text for k, text in enumerate(_halves(functions))}
    files = {name: tree.files[name] for name in (*tree.shared, header) if name.endswith(".h")}
    flags = _flags(tree, options)
    parts = ["functions", __version__, compiler.identity, *flags]
    known = [_COMMENT.sub("", text) for text in (*files.values(), *units.values())]
    digest = hashlib.sha256("\0".join([*parts, *files, *known]).encode()).hexdigest()
    key = f"functions-{digest}"

    def make(folder: Path) -> None:
        for name, text in {**files, **units}.items():
            (folder / name).write_text(text, encoding="utf-8", newline="\n")
        make_objects(compiler, flags, list(units), folder)
        for name in (*files, *units):
            (folder / name).unlink()

    folder = cache.find(key) or cache.put(key, make, noted)
    return [folder / f"{Path(name).stem}.o" for name in units]


def _is_apart(tree: SourceTree, options: CompileOptions) -> bool:
    """Whether the functions of a model are compiled apart from what it says of itself."""
    return len(tree.pieces) > 3 and _flags(tree, options) != list(options.flags)


def _halves(functions: Sequence[str]) -> list[str]:
    """Texts of functions in two parts of about equal length, the largest first."""
    halves: list[list[str]] = [[], []]
    for text in sorted(functions, key=len, reverse=True):
        min(halves, key=lambda half: sum(map(len, half))).append(text)
    return ["".join(half) for half in halves if half]


def _maker(
    tree: SourceTree, objects: list[Path], compiler: Compiler, options: CompileOptions
) -> Callable[[Path], None]:
    def make(folder: Path) -> None:
        source = folder / SOURCES
        source.mkdir()
        write_sources(tree, source)
        entry = f"_this_{tree.kind}.c"  # no unit of the runtime has such a name: objects are named after their units
        text = f'#include "{tree.prefix}.c"\n'
        if _is_apart(tree, options):
            text = tree.pieces[0] + tree.pieces[1] + tree.pieces[-1]
        this = _THIS.format(text=text, prefix=tree.prefix, kind=tree.kind)
        (folder / entry).write_text(this, encoding="utf-8")
        flags = [*options.flags, f"-I{SOURCES}"]
        own = [*_flags(tree, options), f"-I{SOURCES}"]
        beside = _beside(tree, compiler, flags, folder)
        make_library(compiler, own, [entry], LIBRARY, folder, [*objects, *beside])
        for path in beside:
            path.unlink()
        (folder / BINDING).write_text(_binding(tree.declarations, tree.kind), encoding="utf-8")
        try:
            cffi.FFI().dlopen(str(folder / LIBRARY))
        except OSError as error:
            raise BuildError(
                f"the C compiler {compiler.command[0]!r} made a library that does not load: {error}; "
                "it may compile for another machine"
            ) from error

    return make


def _flags(tree: SourceTree, options: CompileOptions) -> list[str]:
    """What the model itself is compiled with."""
    apart = {EXAMPLE, *tree.shared, *tree.beside, *tree.machine}
    size = sum(len(without_numbers(text)) for name, text in tree.files.items() if name not in apart)
    return ["-O1" if flag == "-O2" and size > LARGE else flag for flag in options.flags]


def _beside(tree: SourceTree, compiler: Compiler, flags: list[str], folder: Path) -> list[Path]:
    """Objects of what stands beside the model, such as lanes; none where nothing does."""
    beside, machine = ([f"{SOURCES}/{unit}" for unit in units] for units in (tree.beside, tree.machine))
    common = make_objects(compiler, flags, beside, folder) if beside else []
    if not machine:
        return common
    try:
        return common + make_objects(compiler, [*flags, *MACHINE], machine, folder)
    except BuildError:  # a compiler that does not know its machine: two lanes are right everywhere
        return common + make_objects(compiler, flags, machine, folder)


@cache
def _binding(declarations: str, kind: str) -> str:
    """Python's text of the binding, as FFI.emit_python_code writes it to a file. Parsing C in Python takes 50 ms, and
    models differ in nothing that Python calls."""
    binding = cffi.FFI()
    binding.cdef(declarations + f"const lamc_{kind} *lamc_this_{kind}(void);\n")
    binding.set_source("binding", None)
    writer, text = recompiler.Recompiler(binding, "binding", target_is_python=True), io.StringIO()
    writer.collect_type_table()
    writer.collect_step_tables()
    writer.write_source_to_f(text, None)
    return text.getvalue()


def write_sources(tree: SourceTree, folder: Path) -> list[Path]:
    """All files of `tree` into `folder`. Returns their paths."""
    paths = []
    for name, text in sorted(tree.files.items()):
        path = folder / name
        path.write_text(text, encoding="utf-8", newline="\n")
        paths.append(path)
    return paths
