"""FOLD: a sheet of creases becomes a `Mechanism` that is drawn flat, facets its bodies and creases its hinges.

In: JSON text, and what a user says of the sheet. Out: a mechanism. Never: simulates; passes over anything without a
note. What is assumed is told in one warning for each assumption, and not assumed where it is given.
"""

from pathlib import PurePath

from lamc.basics.errors import DesignError, LamcError, Place, warn
from lamc.readers.fold_file import read_frame
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
        frame, stem = read_frame(text, file, limits), PurePath(file).stem
        lines = lines_of(frame, options, stem, file)
        if lines is not None:
            from lamc.readers.drawings.sheet import sheet_of  # other files do without healing

            return sheet_of(lines, options)
        if options.heal is not None:
            raise DesignError(
                "heal is for lines; a FOLD file that lists its faces says itself where edges end"
            )
        made, notes = sheet_mechanism(frame, options, stem)
    except LamcError as error:
        raise (type(error)(error.message, Place(file)) if error.place is None else error) from error
    for note in notes:
        warn(note, Place(file))
    return with_origin(made, SheetAsSuch(frame, options, stem))
