"""What a run does where nobody says: how long it is, how many rows it has, how much work it may be. Numbers only."""

import math

DURATION = 10.0  # s
MAX_STEPS = 1_000_000
RTOL, ATOL = 1e-9, 1e-11  # of a step
_FEWEST, _MOST_NUMBERS = 2001, 4_000_000  # rows; numbers in the table of a result


def default_rows(t_end: float, size: int) -> int:
    """200 rows a second and 2001 at least, as long as states of this size make no file of a size that nobody wants."""
    if not math.isfinite(t_end):
        return 0
    most = max(_FEWEST, min(100_001, _MOST_NUMBERS // (size + 2)))
    return int(min(max(_FEWEST, 200 * t_end + 1), most))


# Work of an evaluation in units of 2 ns of a core, by sheets of 176 to 736 hinges that start flat: a hinge in loops
# takes 150, and the square of the freedoms (up to 50, in proportion from there on) for the directions that are free; a
# hinge of a tree takes 40. `python -m benchmarks.large_drawings` has what comes of it.
_OF_LOOPS, _OF_TREES, _SQUARED = 150, 40, 50
# A hinge of loops that close only within a tolerance takes `_MISFIT` more for each hinge that the mechanism has beyond
# `_FEW`, up to `_ALL`: their closure is solved by singular values, as what is a misfit's is no equation. Some such
# sheets take a fifth, others three times as much (95 hinges: 2.7 ms for an evaluation, 113: 1.2, 269: 40, 700 to 1500:
# some 25). Such sheets are left rigid by `--facets rigid` alone, or are of triangles. Loops of fewer hinges are quick.
_MISFIT, _FEW, _ALL = 100, 40, 300
_EVALUATIONS = 12  # of a step
_MOST_WORK = 2_000_000_000  # of a run: 4 s, so that all of `lamc run` takes some 20 at most
# Of loops, as `Simulator.run` counts it, some 2 s: `Length` may take half as much again, and all of it once more for
# rows. Small loops are not stuck after PATIENT_WORK.
MOST_WORK, PATIENT_WORK = 2e9, 15e9
_SHARE_OF_LOOPS = 0.6  # of it, as their equations take longer than those of trees


def default_steps(hinges: int, freedoms: int, *, has_loops: bool, has_misfit: bool = False) -> int:
    """Steps that a run tries where nobody says how long it is, nor how many: those of small mechanisms have no part
    in it. Counted, not timed, so that a run ends alike on every machine. has_misfit: whether its loops close only
    within a tolerance."""
    each = _OF_LOOPS + freedoms * min(freedoms, _SQUARED) if has_loops else _OF_TREES
    each += _MISFIT * max(0, min(hinges, _ALL) - _FEW) if has_misfit else 0
    most = int(_MOST_WORK * _SHARE_OF_LOOPS) if has_loops else _MOST_WORK
    return min(MAX_STEPS, max(1, most // (_EVALUATIONS * max(1, hinges) * each)))
