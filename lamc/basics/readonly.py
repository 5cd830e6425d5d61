"""A dict that cannot change, for frozen records: it compares, prints, pickles and copies as a dict does.

In: what `dict` takes. Out: a mapping that refuses every change. `types.MappingProxyType` will not do: it can be neither
copied nor pickled, and so no record that holds one can be given to `dataclasses.asdict`.
"""

from typing import Any, NoReturn, TypeVar

K = TypeVar("K")
V = TypeVar("V")


class ReadOnlyDict(dict[K, V]):
    """A dict without the methods that change it. Raises TypeError for them."""

    def _refuse(self, *_args: Any, **_named: Any) -> NoReturn:
        raise TypeError("this mapping is part of a frozen record and cannot change; make a new record")

    __setitem__ = __delitem__ = __ior__ = _refuse
    clear = pop = popitem = setdefault = update = _refuse

    def __hash__(self) -> int:  # type: ignore[override]
        return hash(frozenset(self.items()))

    def __reduce__(self) -> "tuple[type[ReadOnlyDict[K, V]], tuple[dict[K, V]]]":
        return type(self), (dict(self),)
