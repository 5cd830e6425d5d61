"""`lamc.export`: a mechanism in its scene, or a plate, as files for programs that have neither Python nor lamc.

In: a design or a plate, what to make of it, options. Out: files, as a mapping first and as a folder then. The same
design gives the same bytes. Never: writes over what it did not write.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Protocol, TypeAlias, Union, cast

from lamc.basics.errors import ExportError, warn
from lamc.basics.files import checked_path
from lamc.codegen.names import identifier
from lamc.design.split import split
from lamc.export.folder import Origin, write_folder
from lamc.export.options import ExportOptions, check_used, options_from
from lamc.readers.load import load
from lamc.records.design import Design
from lamc.records.mechanism import Mechanism
from lamc.records.scene import Scene

if TYPE_CHECKING:
    from lamc.plates.problem import Problem
    from lamc.readers.plates.problem_records import PlateFile
    from lamc.run.result import Result

Files = Mapping[str, bytes]  # relative path, parts joined by / → content
Exported: TypeAlias = Union[Design, Mechanism, "Result", "PlateFile", "Problem"]


class Making(Protocol):
    """What the module of a target has to have; it may have `notes(files)` too, lines for the command line."""

    def files(self, mechanism: Mechanism, scene: Scene, options: ExportOptions) -> Files:
        """The export itself: pure but for temporary files of a compiler."""

    def next_step(self, folder: str, files: Files, options: ExportOptions) -> str:
        """One line of a shell, or a sentence, that comes next: of the folder as it was written to."""


@dataclass(frozen=True)
class Target:
    """Something that a mechanism can be exported to.

    users   who takes it, in a word or two
    uses    fields of `ExportOptions` that it reads; others are refused where they differ from their defaults
    module  of `lamc.export`, imported when it is asked for: see `Making`
    moves   whether what is exported depends on a scene
    """

    name: str
    users: str
    summary: str
    uses: tuple[str, ...]
    module: str
    moves: bool = True

    @property
    def making(self) -> Making:
        """The module, imported."""
        return cast(Making, import_module(f"{__name__}.{self.module}"))

    def files(self, mechanism: Mechanism, scene: Scene, options: ExportOptions) -> Files:
        """Raises ExportError for options that it does not read, and as its module does."""
        check_used(options, self.name, self.uses, _uses())
        return self.making.files(mechanism, scene, options)

    def notes(self, files: Files) -> list[str]:
        """What the command line says of the files beside their names."""
        tell = getattr(self.making, "notes", None)
        return tell(files) if tell else []

    def effects(self, mechanism: Mechanism, scene: Scene, options: ExportOptions) -> list[str] | None:
        """Names of what acts in the export, torques from outside among them; None where nothing moves."""
        if not self.moves:
            return None
        from lamc.export.driven import driven_scene
        from lamc.pipeline import effects_of

        acting = driven_scene(mechanism, scene, options) if "inputs" in self.uses else scene
        return [effect.name for effect in effects_of(mechanism, acting)]


# wasm calls no mathematical library, so that `libm` leaves it as it is.
_SIMULATOR = ("prefix", "integrator", "inputs")
_TARGETS = (
    Target(
        "c",
        "C and C++",
        "sources in C99, valid C++ too, with build files, an example and a README",
        (*_SIMULATOR, "libm", "precision", "real_time", "jacobian", "single_header"),
        "package",
    ),
    Target(
        "mjcf",
        "MuJoCo",
        "a model for MuJoCo, loops included, with meshes",
        ("prefix", "lossy", "step"),
        "mjcf",
    ),
    Target(
        "urdf",
        "ROS",
        "links, hinges and inertias of a mechanism without loops, as a ROS package",
        ("prefix", "lossy"),
        "urdf",
    ),
    Target(
        "fmu",
        "co-simulation",
        "a functional mock-up unit for co-simulation, FMI 2.0 or 3.0",
        (*_SIMULATOR, "libm", "fmi"),
        "fmu",
    ),
    Target(
        "wasm",
        "browsers, node",
        "WebAssembly for node and browsers, with a page that shows it move",
        (*_SIMULATOR, "jacobian"),
        "wasm",
    ),
    Target(
        "wheel",
        "Python",
        "a Python package of its own, without lamc and NumPy",
        (*_SIMULATOR, "libm", "real_time", "jacobian"),
        "wheel",
    ),
    Target(
        "fold",
        "origami tools",
        "a FOLD file of a creased sheet, flat and in frames of its motion",
        ("lossy",),
        "fold",
    ),
    Target(
        "cut",
        "laser cutters",
        "DXF and SVG of each layer in real size, for laser cutters and CAD",
        ("hinge_style", "hinge_width", "kerf", "pins", "stock"),
        "cut",
        moves=False,
    ),
)
TARGETS: Mapping[str, Target] = MappingProxyType({target.name: target for target in _TARGETS})
PLATE_USES = ("prefix", "libm", "single_header", "lossy", "edge_length")  # of a plate to c


def _uses() -> dict[str, tuple[str, ...]]:
    """What reads which options."""
    return {**{name: target.uses for name, target in TARGETS.items()}, "a plate": PLATE_USES}


def files_of(
    design: Exported,
    to: str = "c",
    scene: Scene | None = None,
    options: ExportOptions | None = None,
) -> Files:
    """The files of an export, by relative path. Raises ExportError for an unknown target, for options that it does not
    read, and for a plate to another target than "c" or in a scene."""
    if to not in TARGETS:
        raise ExportError(f"there is no export to {to!r}; there are {', '.join(TARGETS)}")
    run = _run_files(design, to, scene, options or ExportOptions())
    if run is not None:
        return run
    if not isinstance(design, Design | Mechanism):
        if scene is not None:
            raise ExportError(
                "a scene is given with a plate, which does not move: leave scene= out, or export a design with joints"
            )
        return _plate_files(cast("PlateFile | Problem", design), to, options or ExportOptions())
    if scene is not None and not TARGETS[to].moves:
        raise ExportError(f"a scene is given with an export to {to!r}, where nothing moves: leave scene= out")
    mechanism = split(design) if isinstance(design, Design) else design
    return TARGETS[to].files(mechanism, scene or mechanism.scene or Scene(), options or ExportOptions())


def _run_files(design: Exported, to: str, scene: Scene | None, options: ExportOptions) -> Files | None:
    """Files of a Result; None for anything else."""
    from lamc.run.result import Result

    if not isinstance(design, Result):
        return None
    if to != "fold" or scene is not None:
        raise ExportError("a run is exported to 'fold' only, and as it was; export its design for more")
    check_used(options, to, TARGETS[to].uses, _uses())
    from lamc.export.fold import result_files

    return result_files(design, options)


def _plate_files(plate: "PlateFile | Problem", to: str, options: ExportOptions) -> Files:
    from lamc.export.plate import plate_files
    from lamc.readers.plates.problem_records import PlateFile

    if to != "c":
        raise ExportError(f"a plate is exported to 'c' only, not to {to!r}, which is for what moves")
    if isinstance(plate, PlateFile):
        check_used(options, "a plate", PLATE_USES, _uses())
    else:
        own = tuple(name for name in PLATE_USES if name != "edge_length")
        check_used(options, "a Problem, which has its mesh,", own, _uses())
    return plate_files(plate, options)


def export(
    design: Exported,
    to: str = "c",
    scene: Scene | None = None,
    out: str | Path | None = None,
    options: ExportOptions | None = None,
    *,
    force: bool = False,
    **values: object,
) -> Path:
    """Writes an export of a design, a mechanism, a run (to "fold" only), a plate file or a plate's Problem into the
    folder `out` (None: NAME_c in the present folder, by target) and returns its path.

    scene    None: the design's own, else what the design asks for
    options  or their fields by name
    force    replace files too that are not lamc's or were edited

    Raises ExportError for options, targets and folders that cannot be.
    """
    if options is not None and values:
        raise ExportError(f"give options or their fields ({', '.join(values)}), not both")
    files = files_of(design, to, scene, options or options_from(**values))
    name = str(getattr(getattr(design, "mechanism", design), "name", "plate"))  # a Problem has none
    folder = Path(out) if out is not None else Path(f"{identifier(name)}_{to}")
    write_folder(folder, files, Origin(name, to), force=force)
    return folder


def convert(
    source: str | Path,
    target: str | Path,
    *,
    force: bool = False,
    **reading: object,
) -> Path:
    """Writes what the file `source` holds as the file `target`, whose suffix says how; returns its path. Beside an SVG
    or DXF file of a laminate, `target`.yaml is the design that takes its shapes from there.

    force    replace what is there, but for what is read
    reading  keywords of `lamc.load`: card, crease, fixed, units, …

    What the file does not hold is a DesignWarning each. Raises ExportError for a suffix that means nothing, a file in
    the way, and one that is read; UnsupportedError for what the format cannot hold; and as `lamc.load` does.
    """
    from lamc.export.conversions import check_place, converted, write  # `import lamc` does without them

    path, read = checked_path(target), checked_path(source)
    check_place(read, path, force=force)
    made = converted(load(read, **reading), path, read)  # type: ignore[arg-type]  # load looks at them
    write(made, path, force=force)
    for lost in made.lost:
        warn(f"{path.name} does not hold {lost}")
    return path
