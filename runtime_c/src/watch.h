/* watch.h, of lamc: which method LAMC_AUTO takes. */
#ifndef LAMC_WATCH_H
#define LAMC_WATCH_H

#include "method.h"

/* The first method of a run. */
void lamc_watch_start(lamc_run *run, lamc_method which);

/* After an accepted step of a LAMC_AUTO run: may ask for another method. */
void lamc_watch_step(lamc_run *run);

/* Before a step: the method that was asked for becomes the present one. */
void lamc_watch_switch(lamc_run *run);

#endif /* LAMC_WATCH_H */
