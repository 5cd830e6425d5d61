"""What a run does where nobody says: how long it is, and how many rows it has. Numbers only."""

import math

DURATION = 10.0  # s
_FEWEST, _MOST_NUMBERS = 2001, 4_000_000  # rows; numbers in the table of a result


def default_rows(t_end: float, size: int) -> int:
    """200 rows a second and 2001 at least, as long as states of this size make no file of a size that nobody wants."""
    if not math.isfinite(t_end):
        return 0
    most = max(_FEWEST, min(100_001, _MOST_NUMBERS // (size + 2)))
    return int(min(max(_FEWEST, 200 * t_end + 1), most))
