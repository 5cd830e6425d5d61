/* status.c: what each status means, for people. */
#include "lamc.h"

const char *lamc_status_message(lamc_status status) {
  switch (status) {
  case LAMC_OK:
    return "the end was reached";
  case LAMC_PAUSED:
    return "paused: the budget of evaluations is spent";
  case LAMC_OUTPUT_FULL:
    return "paused: the rows for output are full";
  case LAMC_STEP_UNDERFLOW:
    return "the step needed is below the spacing of numbers around t";
  case LAMC_NOT_FINITE:
    return "the motion is not finite (NaN or infinity), however short the step";
  case LAMC_STEP_LIMIT:
    return "the limit on the number of steps was reached";
  case LAMC_CANCELLED:
    return "cancelled";
  case LAMC_BAD_ARGUMENT:
    return "an argument is outside its range";
  case LAMC_CLOSURE_LOST:
    return "a loop came apart: no position nearby closes it";
  case LAMC_RANK_LOST:
    return "the motion stays at a singular position, where it is not determined";
  case LAMC_EVENTS_PILE_UP:
    return "impacts or switches follow each other ever faster";
  }
  return "unknown status";
}
