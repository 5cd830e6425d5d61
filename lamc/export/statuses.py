"""What functions of an exported simulator return, beside "done": their numbers and meanings.

In: nothing. Out: a table. The numbers of the runtime's own statuses are those of `lamc_status` in lamc.h.
"""

from dataclasses import dataclass


@dataclass(frozen=True)
class CStatus:
    name: str
    value: int
    meaning: str


STATUSES = (
    CStatus("STEP_UNDERFLOW", -1, "the step needed is below the spacing of numbers around t"),
    CStatus("NOT_FINITE", -2, "the motion is not finite (NaN or infinity), however short the step"),
    CStatus("STEP_LIMIT", -3, "the limit on the number of steps was reached: call again to go on"),
    CStatus("BAD_ARGUMENT", -5, "an argument is NULL or outside its range"),
    CStatus("CLOSURE_LOST", -7, "a loop came apart: no position nearby closes it"),
    CStatus("RANK_LOST", -8, "the motion stays at a singular position, where it is not determined"),
    CStatus("EVENTS_PILE_UP", -9, "impacts or switches follow each other ever faster"),
    CStatus("BAD_DIGEST", -20, "a struct of another design, or one that was never initialised"),
    CStatus("IN_PAST", -21, "the time asked for lies before the present one"),
    CStatus("BAD_PARAMETER", -22, "a parameter is not finite or outside its range"),
    CStatus("BAD_INPUT", -23, "an input is not finite"),
    CStatus("BAD_STATE", -24, "a state is damaged or not finite, or no near state closes the loops"),
    CStatus(
        "STEP_TOO_LONG", -25, "a step turned something by over half a turn, or to infinity: take shorter ones"
    ),
)

# Of a binding, where there are no pointers and no structs
_BOUND = {
    "BAD_ARGUMENT": "a number is not finite or outside its range",
    "BAD_DIGEST": "a state of another design, or none",
}


def of_bindings() -> dict[int, tuple[str, str]]:
    """Number → name and meaning, as bindings for other languages tell them."""
    return {status.value: (status.name, _BOUND.get(status.name, status.meaning)) for status in STATUSES}
