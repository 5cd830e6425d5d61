"""Numbers and names of a page as one text of base64.

In: plain data with arrays in it. Out: JSON and the arrays' bytes, deflated, in letters that mean nothing in HTML or
JavaScript, whatever the names in a design are. `templates/view/unpack.js` is its other half. Never: rounds.
"""

import base64
import json
import math
import struct
import zlib
from collections.abc import Mapping
from typing import Any

import numpy as np

_KINDS = {
    "u1": "Uint8Array",
    "i2": "Int16Array",
    "u2": "Uint16Array",
    "u4": "Uint32Array",
    "f4": "Float32Array",
}
_KINDS["f8"] = "Float64Array"
_WORD = 8  # bytes: each array begins at a multiple, as typed arrays of JavaScript have to


def packed(data: object) -> str:
    """The text. Layout of the bytes before they are deflated, little-endian: length of the JSON (u4), the JSON in
    UTF-8, zeros up to a multiple of 8, the arrays. An array is {"$": [kind, first byte, count]} in the JSON; a number
    that is not finite is null."""
    blocks: list[bytes] = []
    text = json.dumps(
        _plain(data, blocks), separators=(",", ":"), allow_nan=False, ensure_ascii=False
    ).encode()
    head = struct.pack("<I", len(text)) + text
    whole = _filled(head) + b"".join(blocks)
    return base64.b64encode(zlib.compress(whole, 9)).decode("ascii")


def _filled(block: bytes) -> bytes:
    return block + bytes(-len(block) % _WORD)


def _plain(value: object, blocks: list[bytes]) -> Any:
    if isinstance(value, Mapping):
        return {str(key): _plain(each, blocks) for key, each in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(each, blocks) for each in value]
    if isinstance(value, bytes):
        value = np.frombuffer(value, dtype=np.uint8)
    if isinstance(value, np.ndarray):
        first = sum(map(len, blocks))
        kind = value.dtype.str[1:]
        blocks.append(_filled(np.ascontiguousarray(value, dtype=f"<{kind}").tobytes()))
        return {"$": [_KINDS[kind], first, value.size]}
    if isinstance(value, np.generic):
        value = value.item()
    return None if isinstance(value, float) and not math.isfinite(value) else value
