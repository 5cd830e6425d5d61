"""Writes what C and the guide say of the integration methods, from the table of `lamc/run/methods.py`.

`make methods` writes it; `tests/unit/test_methods.py` holds the files against the table. Raises ValueError for a file
in which the place is not found.
"""

import re
import sys
from pathlib import Path

from lamc.run.methods import METHODS, Method, constant

ROOT = Path(__file__).resolve().parent.parent
HEADER, LIST = ROOT / "runtime_c/include/lamc.h", ROOT / "runtime_c/src/methods.h"
GUIDE = ROOT / "docs/guide/stiff.md"
_ENUM = re.compile(r"(?<=  LAMC_AUTO = 0,).*?(?=} lamc_method;)", re.DOTALL)
_ROWS = re.compile(r"(?<=always, to begin with \|\n)(?:\| `\w+` \|.*\n)+")


def _entries() -> str:
    """Behind LAMC_AUTO in the enumeration, as clang-format has it."""
    said = ["explicit, and implicit where that goes faster", *map(_comment, METHODS.values())]
    names = [f"{constant(method)} = {k}" for k, method in enumerate(METHODS, 1)]
    last = len(names) - 1
    entries = [f"  {name}{',' if k < last else ''}" for k, name in enumerate(names)]
    width = max(map(len, entries))
    pairs = zip(["", *entries], said, strict=True)
    lines = [
        f"{entry.ljust(width - (0 if entry else len('  LAMC_AUTO = 0,')))} /* {it} */" for entry, it in pairs
    ]
    return "\n".join(lines) + "\n"


def _comment(method: Method) -> str:
    said = f"{method.title}, for {method.when}".replace("–", "-")
    return re.split(r", (?:or|where) ", said)[0].replace("`", "")


def _list() -> str:
    """The whole of methods.h."""
    return "\n".join(
        [
            "/* methods.h, of lamc: the methods that there are. Made from lamc/run/methods.py by `make methods`. */",
            "#ifndef LAMC_METHODS_H",
            "#define LAMC_METHODS_H",
            "",
            *(f"extern const struct method lamc_method_{name};" for name in METHODS),
            "",
            "/* clang-format off */",
            "#define LAMC_METHODS " + ", ".join(f"&lamc_method_{name}" for name in METHODS),
            "/* clang-format on */",
            "",
            "#endif /* LAMC_METHODS_H */",
            "",
        ]
    )


def _put(path: Path, place: re.Pattern[str], text: str) -> str:
    whole, count = place.subn(lambda _: text, path.read_text(encoding="utf-8"))
    if count != 1:
        raise ValueError(f"{path.relative_to(ROOT)} has {count} places for the methods; leave exactly one")
    return whole


def texts() -> dict[Path, str]:
    """Files and what they should say."""
    rows = "".join(f"| `{name}` | {method.title} | {method.when} |\n" for name, method in METHODS.items())
    return {HEADER: _put(HEADER, _ENUM, _entries()), LIST: _list(), GUIDE: _put(GUIDE, _ROWS, rows)}


if __name__ == "__main__":
    if sys.argv[1:]:
        sys.exit("usage: python docs/make_methods.py")
    for path, text in texts().items():
        path.write_text(text, encoding="utf-8")
