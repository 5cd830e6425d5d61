"""Zip files whose bytes follow from their content alone."""

import io
import zipfile
from collections.abc import Collection, Mapping

_OLD = (1980, 1, 1, 0, 0, 0)  # the first date that a zip file can have


def zipped(files: Mapping[str, bytes], executable: Collection[str] = ()) -> bytes:
    """A zip file of `files`, in their order, all of one date; those named in `executable` may be executed."""
    whole = io.BytesIO()
    with zipfile.ZipFile(whole, "w") as archive:
        for name, content in files.items():
            entry = zipfile.ZipInfo(name, _OLD)
            entry.compress_type = zipfile.ZIP_DEFLATED
            entry.create_system = 3  # Unix, wherever it was made
            entry.external_attr = (0o100755 if name in executable else 0o100644) << 16
            archive.writestr(entry, content)
    return whole.getvalue()
