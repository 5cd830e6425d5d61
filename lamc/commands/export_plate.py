"""`lamc export` of a plate: its finite elements as files for other programs.

In: words that name a plate. Out: its files. Where they go is the business of `export.py`.
"""

from pathlib import Path

from lamc.basics.errors import DesignError, ExportError, LamcError
from lamc.basics.units import LENGTH, to_si
from lamc.commands.inputs import SceneChanges, Source
from lamc.commands.plate_input import PlateSource
from lamc.commands.plate_input import load_source as load_plate_source
from lamc.examples import names as design_names
from lamc.examples import plates
from lamc.export import Files, files_of
from lamc.export.options import ExportOptions
from lamc.readers.inert import compose
from lamc.readers.load import file_text
from lamc.readers.plates.problem_file import is_plate
from lamc.readers.plates.problem_records import PlateFile
from lamc.run.request import did_you_mean


def is_plate_source(source: Source) -> bool:
    """Whether the file or example is a plate's; False also for what cannot be read, which its reader then tells."""
    if source.example is not None:
        return source.example in plates.names() and source.example not in design_names()
    if source.file is None or not Path(source.file).is_file():
        return False
    try:
        text = file_text(source.file)
        return ("plate" in text or "supports" in text) and is_plate(compose(text, source.file))
    except LamcError:
        return False


def check_example(source: Source) -> None:
    """Raises DesignError for an example that neither a design nor a plate is, with names of both."""
    if source.example is None or source.file is not None:
        return
    known = {*design_names(), *plates.names()}
    if source.example.partition(":")[0] not in known:
        hint = did_you_mean(source.example, sorted(known))
        raise DesignError(
            f"there is no example {source.example[:60]!r}; {hint}; see `lamc examples`, `lamc plate --examples`"
        )


def load(source: Source) -> PlateFile:
    """The plate. Raises LamcError as `lamc plate` does."""
    file, _ = load_plate_source(PlateSource(source.file, source.example))
    return file


def files_of_plate(plate: PlateFile, target: str, changes: SceneChanges, options: ExportOptions) -> Files:
    """All files. Raises ExportError for options that belong to what moves, and as the export does."""
    if changes != SceneChanges():
        raise ExportError(
            "effects, angles, rates and scenes belong to mechanisms, and a plate does not move: leave them out"
        )
    return files_of(plate, target, options=options)


def edge_length(text: str | None) -> float | None:
    """The length of --size, m. Raises DesignError."""
    if text is None:
        return None
    try:
        return to_si(text, LENGTH)
    except DesignError as error:
        raise DesignError(f"--size {text!r}: {error.message}") from error
