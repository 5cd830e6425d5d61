"""Whether two studies are of the same thing: digests of designs, scenes and functions.

In: records, arrays, geometries, functions. Out: SHA-256 over all that they hold, in a fixed order; where a record stood
in a file does not count, as the same design may be read from another folder.
"""

import hashlib
import inspect
from collections.abc import Iterator, Mapping
from dataclasses import fields, is_dataclass
from typing import Any

import numpy as np
import shapely

from lamc.basics.errors import Place
from lamc.basics.places import Places
from lamc.records.family import Family


def digest_of(value: Any) -> str:
    """In hexadecimal."""
    return hashlib.sha256(b"\0".join(_pieces(value))).hexdigest()


def _pieces(value: Any) -> Iterator[bytes]:
    if isinstance(value, Place | Places):
        return
    if is_dataclass(value) and not isinstance(value, type):
        yield type(value).__qualname__.encode()
        for each in fields(value):
            if each.compare:
                yield each.name.encode()
                yield from _pieces(getattr(value, each.name))
    elif isinstance(value, Mapping):
        for key, item in value.items():
            yield repr(key).encode()
            yield from _pieces(item)
    elif isinstance(value, tuple | list):
        yield str(len(value)).encode()
        for item in value:
            yield from _pieces(item)
    elif isinstance(value, np.ndarray):
        yield repr((value.shape, str(value.dtype))).encode()
        yield value.tobytes()
    elif isinstance(value, shapely.Geometry):
        yield shapely.to_wkb(value)
    elif hasattr(value, "func") and hasattr(value, "keywords"):  # functools.partial
        yield from _pieces((value.func, value.args, value.keywords))
    elif isinstance(value, Family):
        yield from _pieces((value.function, dict(value.parameters)))
    elif callable(value):
        yield _code(value)
    else:
        yield repr(value).encode()


def _code(function: Any) -> bytes:
    """A function by its source; by its name where there is none."""
    try:
        return inspect.getsource(function).encode()
    except (OSError, TypeError):
        return f"{getattr(function, '__module__', '')}.{getattr(function, '__qualname__', type(function))}".encode()
