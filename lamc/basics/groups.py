"""Things that belong together, joined pair by pair: disjoint sets with path halving, the least index at the head.

In: a list in which everything is its own head, `list(range(n))`. Out: the same list, in which `root` finds the head of
each group. Never: depends on the order of the pairs.
"""


def root(head: list[int], index: int) -> int:
    """The least index of the group that `index` is in."""
    while head[index] != index:
        head[index] = index = head[head[index]]
    return index


def unite(head: list[int], a: int, b: int) -> bool:
    """Joins the groups of a and b. Returns whether they were apart."""
    low, high = sorted((root(head, a), root(head, b)))
    head[high] = low
    return low != high
