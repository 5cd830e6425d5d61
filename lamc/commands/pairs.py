"""Values of options: NAME=VALUE, and shares.

In: words from the command line. Out: text by name and numbers, or DesignErrors that name the option.
"""

from collections.abc import Iterable

from lamc.basics.errors import DesignError


def share_of(text: str, option: str) -> float:
    """A share as a number: of "1e-3" or "0.1 %". Raises DesignError for what is no number."""
    number, unit = text.strip(), 1.0
    if number.endswith("%"):
        number, unit = number[:-1].strip(), 1e-2
    try:
        return float(number) * unit
    except ValueError as error:
        raise DesignError(
            f"{option} {text!r} is no number; it must be a share such as 1e-3 or '0.1 %'"
        ) from error


def pairs_of(texts: Iterable[str], option: str, example: str) -> dict[str, str]:
    """Values by name of an option that may stand several times, each as in `split_pair`; one name may stand once."""
    values: dict[str, str] = {}
    for text in texts:
        name, value = split_pair(text, option, example)
        if name in values:
            raise DesignError(
                f"{option} gives {name!r} twice, {values[name][:40]!r} and {value[:40]!r}; keep one of them"
            )
        values[name] = value
    return values


def split_pair(text: str, option: str, example: str) -> tuple[str, str]:
    """NAME and VALUE of "NAME=VALUE"; the last "=" divides, since names may hold one."""
    name, sign, value = text.rpartition("=")
    if not sign or not name or not value:
        raise DesignError(f"{option} {text!r} is not of the form NAME=VALUE, such as h1={example}")
    return name, value
