/* watch.h, of lamc: which method LAMC_AUTO takes, and that rows and integrals sway neither it nor the count of work. */
#ifndef LAMC_WATCH_H
#define LAMC_WATCH_H

#include "method.h"

/* The first method of a run. */
void lamc_watch_start(lamc_run *run, lamc_method which);

/* After an accepted step of a LAMC_AUTO run: may ask for another method. */
void lamc_watch_step(lamc_run *run);

/* Before a step: the method that was asked for becomes the present one. */
void lamc_watch_switch(lamc_run *run);

/* The work that was counted so far; 0 where none is */
static inline lamc_real lamc_watch_work(const lamc_run *run) {
  return run->ode.work == NULL ? 0 : *run->ode.work(run->ode.context);
}

/* What was counted since does not count */
static inline void lamc_watch_forget(const lamc_run *run, lamc_real work) {
  if (run->ode.work != NULL) *run->ode.work(run->ode.context) = work;
}

#endif /* LAMC_WATCH_H */
