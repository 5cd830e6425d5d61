"""FOLD: a sheet of creases becomes a `Mechanism` that is drawn flat, facets its bodies and creases its hinges.

In: JSON text, and what a user says of the sheet. Out: a mechanism. Never: simulates; passes over anything without a
note. What is assumed is told in one warning for each assumption, and not assumed where it is given.
"""

from pathlib import PurePath

from lamc.basics.errors import DesignError, LamcError, Place, warn
from lamc.readers.fold_file import crease_pattern, fold_data, read_frame
from lamc.readers.fold_flat import TornError
from lamc.readers.fold_frames import Data
from lamc.readers.fold_lines import lines_of
from lamc.readers.fold_sheet import sheet_mechanism
from lamc.readers.inert import Limits
from lamc.readers.mechanism_as_such import SheetAsSuch
from lamc.records.card import SheetOptions
from lamc.records.mechanism import Mechanism
from lamc.records.parameters import with_origin


def read_fold(text: str, file: str, options: SheetOptions, limits: Limits) -> Mechanism:
    """The mechanism in a FOLD text. Raises DesignError with edge, face or vertex for what cannot be."""
    try:
        data = fold_data(text, file, limits)
        try:
            return _sheet_of(data, file, options)
        except TornError as torn:
            told = torn.message.partition(", so")[0]
            try:
                number = crease_pattern(data, file)
            except DesignError as error:
                raise type(error)(f"{told}; of its other frames, {error.message}", error.place) from torn
            if number is None:
                raise
            try:
                made = _sheet_of(data, file, options, number)
            except DesignError as error:
                raise type(error)(
                    f"{told}; frame {number}, the file's crease pattern, is none either: {error.message}",
                    error.place,
                ) from torn
            warn(f"{told}: frame {number}, the file's crease pattern, is read in its place", Place(file))
            return made
    except LamcError as error:
        raise (type(error)(error.message, Place(file)) if error.place is None else error) from error


def _sheet_of(data: Data, file: str, options: SheetOptions, number: int | None = None) -> Mechanism:
    """The mechanism of a frame by its number; None: of the one that is read where nobody says."""
    frame, stem = read_frame(data, file, number), PurePath(file).stem
    lines = lines_of(frame, options, stem, file)
    if lines is not None:
        from lamc.readers.drawings.sheet import sheet_of  # other files do without healing

        return sheet_of(lines, options)
    if options.heal is not None:
        raise DesignError("heal is for lines; a FOLD file that lists its faces says itself where edges end")
    made, notes = sheet_mechanism(frame, options, stem)
    for note in notes:
        warn(note, Place(file))
    return with_origin(made, SheetAsSuch(frame, options, stem))
