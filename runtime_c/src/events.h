/* events.h, of lamc: events of a run, and what they ask of run.c. */
#ifndef LAMC_EVENTS_H
#define LAMC_EVENTS_H

#include "method.h"

/* Numbers that events take at the end of the work array */
long long lamc_events_size(const lamc_ode *ode);

/* Takes the guards at the start of a run. */
void lamc_events_start(lamc_run *run, lamc_real *memory);

/* After an accepted step: if guards passed zero within it, the run goes back to the first of them and through the event.
 * LAMC_OK, LAMC_PAUSED where the shortened step was refused, LAMC_EVENTS_PILE_UP, or what the event says. */
lamc_status lamc_events_after_step(lamc_run *run);

/* At a break that the run has just passed: what guards are there now. Those that jumped beyond zero are struck. */
lamc_status lamc_events_at_break(lamc_run *run);

/* The guard of the next event to be written; there is one (run->event_due > 0). */
int lamc_events_due(const lamc_run *run);

/* Of run.c: takes a step of length h to a new state that holds. LAMC_PAUSED: refused; *squared is its error norm. */
lamc_status lamc_run_take(lamc_run *run, lamc_real h, int is_last, lamc_real *squared);

/* Of run.c: the state before the last accepted step becomes the present one. */
void lamc_run_move_back(lamc_run *run);

/* Of run.c: a new first step, after the equation or the method has changed. */
void lamc_run_restart(lamc_run *run);

#endif /* LAMC_EVENTS_H */
