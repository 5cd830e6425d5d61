"""Plain data as YAML text that lamc reads back exactly.

In: dicts with string keys, lists, strings, numbers, booleans, None. Out: text. Floats are printed so that
they read back to the last bit, strings are quoted where they must be; only plain data is ever written.
"""

import json
import re
from collections.abc import Mapping, Sequence

_PLAIN_WORD = re.compile(r"[A-Za-z_][A-Za-z0-9_]*\Z")
_WORDS = frozenset({"true", "false", "null", "yes", "no", "on", "off", "y", "n"})
_WIDTH = 100


def dump(data: Mapping[str, object]) -> str:
    """The data as block-style YAML; lists and maps without structure of their own stand in one line."""
    return "".join(line + "\n" for line in _map_lines(data))


def scalar(value: object) -> str:
    """A string, number, boolean or None as YAML."""
    if value is None:
        return "null"
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, float):
        # YAML 1.1 readers (PyYAML) take 1e-05 for a string; 1.0e-05 is a number to all.
        digits, e, exponent = repr(value).partition("e")
        return digits + (".0" if e and "." not in digits else "") + e + exponent
    if isinstance(value, int):
        return repr(value)
    if isinstance(value, str) and _PLAIN_WORD.match(value) and value.lower() not in _WORDS:
        return value
    if isinstance(value, str):
        quoted = json.dumps(value, ensure_ascii=False)
        return "".join(c if c.isprintable() else f"\\U{ord(c):08x}" for c in quoted)
    raise TypeError(f"{type(value).__name__} is not plain data")


def _map_lines(data: Mapping[str, object]) -> list[str]:
    lines: list[str] = []
    for key, value in data.items():
        name = scalar(key)
        if _is_flat(value):
            lines.append(f"{name}: {_flow(value)}")
        else:
            lines.append(f"{name}:")
            lines += [f"  {line}" for line in _block(value)]
    return lines


def _block(value: object) -> list[str]:
    if isinstance(value, Mapping):
        return _map_lines(value)
    assert isinstance(value, Sequence)
    lines: list[str] = []
    for item in value:
        inner = [_flow(item)] if _is_flat(item) else _block(item)
        lines.append(f"- {inner[0]}")
        lines += [f"  {line}" for line in inner[1:]]
    return lines


def _is_flat(value: object) -> bool:
    """True for scalars, empty things, and short nests of numbers."""
    if not isinstance(value, Mapping | list | tuple) or not value:
        return True
    if isinstance(value, Mapping):
        return False
    return all(_is_flat(v) for v in value) and len(_flow(value)) <= _WIDTH


def _flow(value: object) -> str:
    if isinstance(value, Mapping):
        return "{" + ", ".join(f"{scalar(k)}: {_flow(v)}" for k, v in value.items()) + "}"
    if isinstance(value, list | tuple):
        return "[" + ", ".join(_flow(v) for v in value) + "]"
    return scalar(value)
