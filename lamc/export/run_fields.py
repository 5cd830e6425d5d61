"""What a run under way consists of beside pointers, read from the runtime's own header.

In: the text of lamc.h. Out: members of lamc_run by kind, so that a run can be kept as two arrays of plain numbers.
Never: knows a member by its name, but for those that every call sets anew, and those whose numbers are indices.
"""

from dataclasses import dataclass

from lamc.export.amalgam.tokens import QUIET, Token, items, tokens
from lamc.run.methods import numbers_of_c

_SET_ANEW = ("ode", "options", "status")  # and pointers
_LOGS = ("switch_t", "switch_method")  # told to people, and of no consequence
_REAL, _WHOLE = ("lamc_real",), (("int",), ("long", "long"))


@dataclass(frozen=True)
class RunFields:
    """Members as they are reached from a lamc_run, such as `watch.pace`."""

    reals: tuple[str, ...]
    integers: tuple[str, ...]
    wide: tuple[str, ...]  # of the integers, those that are long long


@dataclass(frozen=True)
class IntegerRange:
    """What a member of a run that was kept can be, both ends included, as C says it."""

    field: str
    least: str
    most: str


def integer_ranges(fields: RunFields, n: int, guard_count: int) -> tuple[IntegerRange, ...]:
    """One for each of `fields.integers`. Counters have room to go on counting for.

    n  components of a state
    """
    stride = f"({n} + LANES - 1) / LANES * LANES" if n else "LANES"
    known = {
        "method": numbers_of_c(),
        "watch.next_method": ("0", numbers_of_c()[1]),
        "side": ("0", "1"),
        "dense": ("0", "LAMC_DENSE_READY"),
        "stride": (stride, stride),
        "event_guard": ("-1", str(guard_count - 1)),
        "event_due": ("0", str(guard_count)),
        "t_eval_count": ("0", "0"),
        "t_eval_next": ("0", "0"),
    }
    counted = {
        field: ("0", "LLONG_MAX / 4" if field in fields.wide else "INT_MAX / 4") for field in fields.integers
    }
    return tuple(IntegerRange(field, *(counted | known)[field]) for field in fields.integers)


def run_fields(header: str) -> RunFields:
    """Members of lamc_run in the order of their declaration, records within it member by member."""
    stream = tokens(
        header.split("/* lamc: declarations begin */")[1].split("/* lamc: declarations end */")[0]
    )
    bodies = {
        item.declares[-1]: _members(item.significant)
        for item in items("lamc", stream)
        if item.kind == "type" and "struct" in [t.text for t in item.significant[:2]]
    }
    reals: list[str] = []
    integers: list[str] = []
    wide: list[str] = []

    def walk(record: str, path: str) -> None:
        for kind, name, is_plain in bodies[record]:
            if name in _LOGS or (not path and name in _SET_ANEW) or not is_plain:
                continue
            if kind == _REAL:
                reals.append(path + name)
            elif kind in _WHOLE:
                integers.append(path + name)
                wide.extend([path + name] if kind == _WHOLE[1] else [])
            else:
                walk(kind[-1], f"{path}{name}.")

    walk("lamc_run", "")
    return RunFields(tuple(reals), tuple(integers), tuple(wide))


def _members(stream: list[Token]) -> list[tuple[tuple[str, ...], str, bool]]:
    """(type, name, whether it is a single number or record) of each member."""
    inside = stream[[t.text for t in stream].index("{") + 1 :]
    found: list[tuple[tuple[str, ...], str, bool]] = []
    current: list[str] = []
    depth = 0
    for token in (t for t in inside if t.kind not in QUIET):
        depth += (token.text in "([{") - (token.text in ")]}")
        if depth < 0:
            break
        if token.text != ";" or depth:
            current.append(token.text)
            continue
        is_plain = not {"*", "[", "("} & set(current)
        found.append((tuple(current[:-1]), current[-1], is_plain))
        current = []
    return found
