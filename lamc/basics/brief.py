"""Short reprs of records that hold whole drawings, meshes or arrays.

In: a kind, a name, facts. Out: one line, as `<Design 'pendulum': 3 layers, 3 hinge lines>`.
"""


def brief(kind: str, name: str, *facts: str) -> str:
    """One line; empty facts are left out."""
    told = ", ".join(fact for fact in facts if fact)
    return f"<{kind}{f' {name!r}' if name else ''}{f': {told}' if told else ''}>"


def counted(number: int, one: str, many: str = "") -> str:
    """A number with its noun: "1 layer", "3 layers"."""
    return f"{number} {one if number == 1 else many or one + 's'}"
