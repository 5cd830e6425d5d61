/* lamc_ensemble.h, of lamc: many runs of one model, with parameters and starts of their own, several side by side.
 *
 * In:    a model, values and starts of all instances, output times; memory for each thread that takes part.
 * Out:   rows of every instance, and how it ended; the bits of a run by itself, however many there are and whoever is beside.
 * Never: allocates, prints, keeps global state. An instance that fails leaves the others as they are. */
#ifndef LAMC_ENSEMBLE_H
#define LAMC_ENSEMBLE_H

#include "lamc.h"

#ifdef __cplusplus
extern "C" {
#endif

/* lamc: declarations begin */

/* What an ensemble tells of an instance, in this order. */
enum {
  LAMC_TOLD_EVALUATIONS,
  LAMC_TOLD_ACCEPTED,
  LAMC_TOLD_REJECTED,
  LAMC_TOLD_EVENTS,
  LAMC_TOLD_SWITCHES,
  LAMC_TOLD_SINGULAR,
  LAMC_TOLD_METHOD,
  LAMC_TOLD
};

/* What is asked for. Threads share one; only `next` and the outputs change. */
typedef struct lamc_ensemble {
  const lamc_model *model;
  const lamc_recording *recording; /* what the inputs of all instances follow; NULL: the model's, if any */
  lamc_method method;
  lamc_options options;
  lamc_real t_end;         /* s; runs start at 0 */
  const lamc_real *t_eval; /* (row_count,), s, ascending within 0 .. t_end: the rows of every instance */
  long long row_count;     /* > 0 */
  long long count;         /* instances */
  const lamc_real
      *parameters; /* instance k: (parameter_count + geometry_count,) at parameters + k * parameter_stride */
  long long parameter_stride; /* 0: the same for all */
  const lamc_real *starts;    /* likewise y = [q, u] (n,) at t = 0 */
  long long start_stride;
  int use_lanes;              /* 0: one run after the other, for comparison */
  long long *next;            /* the first instance that nobody took; threads raise it one by one */
  const volatile int *cancel; /* NULL, or not 0 to end; looked at between steps */
  lamc_real *y;               /* -> (count, row_count, n); rows that are not reached stay as they are */
  int *status;                /* -> (count,): lamc_status; those that were not begun stay as they are */
  lamc_real *t_reached;       /* -> (count,), s */
  long long *told;            /* -> (count, LAMC_TOLD) */
} lamc_ensemble;

/* Instances side by side: 2, 4 or 8 by the machine that this was compiled for; 1: its compiler has no vectors, or the
 * method and the model need none of them. */
int lamc_ensemble_width(const lamc_ensemble *ensemble);

/* Numbers of memory that a thread needs; 0 where a single run could not start. */
long long lamc_ensemble_work_size(const lamc_ensemble *ensemble);

/* Takes instances until none is left. `work` is this thread's own. LAMC_OK, or LAMC_CANCELLED; LAMC_BAD_ARGUMENT where an
 * argument breaks the rule beside it. */
lamc_status lamc_ensemble_run(const lamc_ensemble *ensemble, lamc_real *work);

/* lamc: declarations end */

#ifdef __cplusplus
}
#endif

#endif /* LAMC_ENSEMBLE_H */
