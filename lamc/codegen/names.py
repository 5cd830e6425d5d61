"""C identifiers, string literals and comments made from names that come from a design.

A user's name never reaches C text as it is: identifiers are rebuilt from a small alphabet, strings are escaped
byte by byte, comments lose whatever could end them.
"""

import re
from collections.abc import Container, Iterable

MAX_IDENTIFIER = 40

# Words of C and C++, and names that the templates or libc's macros use.
RESERVED = frozenset(
    """
    auto break case char const continue default do double else enum extern float for goto if inline int
    long register restrict return short signed sizeof static struct switch typedef union unsigned void
    volatile while asm bool catch class delete explicit export false friend mutable namespace new
    operator private protected public template this throw true try typename using virtual wchar_t
    nullptr constexpr static_assert thread_local main lamc q u t p c z out sin cos tan exp log pow sqrt
    fabs fmin fmax errno linux unix signal stdin stdout
    """.split()  # noqa: SIM905  one word per item would be a page
)


def identifier(name: str, taken: Container[str] = ()) -> str:
    """A lower-case C identifier that resembles `name` and is neither reserved nor in `taken`."""
    core = re.sub(r"[^a-z0-9]+", "_", name.lower()).strip("_")[:MAX_IDENTIFIER].strip("_")
    if not core or not core[0].isalpha():
        core = f"x_{core}".rstrip("_")
    candidate, number = core, 1
    while candidate in taken or candidate in RESERVED:
        number += 1
        candidate = f"{core}_{number}"
    return candidate


def identifiers(names: Iterable[str], taken: Iterable[str] = ()) -> list[str]:
    """One identifier each, all different, and none of those taken."""
    known = dict.fromkeys(taken)
    result: list[str] = []
    for name in names:
        result.append(identifier(name, known))
        known[result[-1]] = None
    return result


def string_literal(text: str) -> str:
    """A C string literal with the UTF-8 bytes of `text`; octal escapes, which cannot run into what follows."""
    plain = set(range(0x20, 0x7F)) - {ord('"'), ord("\\"), ord("?")}
    return '"' + "".join(chr(b) if b in plain else f"\\{b:03o}" for b in text.encode()) + '"'


_PLAIN = str.maketrans(
    {
        "·": "*", "²": "^2", "³": "^3", "½": "1/2 ", "×": "x", "–": "-", "ω": "w", "π": "pi", "₀": "0",
        "∫": "int", "∇": "grad ", "ξ": "xi", "η": "eta", "ε": "eps", "κ": "kappa", "ρ": "rho", "γ": "gamma",
    }
)  # fmt: skip


def comment(text: str) -> str:
    """`text` for use inside a C comment: ASCII, one line, with nothing that opens or ends a comment."""
    text = "".join(ch if " " <= ch <= "~" else "?" for ch in text.translate(_PLAIN))
    return text.replace("*/", "* /").replace("/*", "/ *")
