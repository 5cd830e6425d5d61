"""What tells one topology from another, in words. In: two mechanisms. Out: one line."""

from collections.abc import Iterable

from lamc.records.mechanism import Mechanism
from lamc.records.network import listed_names


def changes(before: Mechanism, after: Mechanism) -> str:
    """Bodies and joints that one has and the other has not; where they are the same, what else it can be."""
    parts = []
    for what, old, new in (
        ("bodies", (b.name for b in before.bodies), (b.name for b in after.bodies)),
        ("joints", (j.name for j in before.joints), (j.name for j in after.joints)),
    ):
        gone, added = _difference(old, new)
        parts += [f"{what} gone: {listed_names(gone)}"] if gone else []
        parts += [f"{what} added: {listed_names(added)}"] if added else []
    same = (
        "the same bodies and joints, and other numbers of it vanish, other effects act, loops have another rank, or an "
        "expression of its scene has other numbers of the design"
    )
    return "; ".join(parts) or same


def _difference(old: Iterable[str], new: Iterable[str]) -> tuple[list[str], list[str]]:
    a, b = dict.fromkeys(old), dict.fromkeys(new)
    return [name for name in a if name not in b], [name for name in b if name not in a]
