/* lamc_adjoint.h, of lamc: the gradient of numbers that a run gives, whatever the number of parameters.
 *
 * In:    a model with pullbacks, a start, output times; then what a number weighs each row of the run with.
 * Out:   the rows of the run by itself, bit for bit, and a tape of its steps; then, back along the tape, derivatives of the
 *        number by the start, and by all values that the model works out of its parameters.
 * Never: allocates, prints, keeps global state, or sways a step. */
#ifndef LAMC_ADJOINT_H
#define LAMC_ADJOINT_H

#include "lamc.h"

#include <stddef.h>

#ifdef __cplusplus
extern "C" {
#endif

/* lamc: declarations begin */

/* Derivatives of weighted sums of what a model gives. Generated C fills it; it never changes. Each writes derivatives by
 * q (nq,), u (nu,) and the sources: values by parameters only (source_count,), then what clocks hold (held_count,). */
typedef struct lamc_pullbacks {
  int source_count;
  /* Of udot (nu,), where the model gives it; else, less, at udot and lambda, of M udot - f - J^T lambda (nu,), then of
   * J udot + gamma (m,). Then, if the model has rates, of dq/dt (nq,) */
  void (*motion)(const lamc_real *constants, lamc_real t, const lamc_real *q, const lamc_real *u,
                 const lamc_real *udot, const lamc_real *lambda, const lamc_real *weights,
                 lamc_real *derivatives);
  /* Of phi (m,), then of J u (m,). NULL: a tree */
  void (*closure)(const lamc_real *constants, const lamc_real *q, const lamc_real *u,
                  const lamc_real *weights, lamc_real *derivatives);
  /* Of the guards; behind q and u comes the derivative by t. NULL: there are none */
  void (*guards)(const lamc_real *constants, lamc_real t, const lamc_real *q, const lamc_real *u,
                 const lamc_real *weights, lamc_real *derivatives);
  /* Of periods of the clocks, then of samples. NULL: there are none */
  void (*samples)(const lamc_real *constants, lamc_real t, const lamc_real *q, const lamc_real *u,
                  const lamc_real *weights, lamc_real *derivatives);
  /* Of restitutions of the guards, and of derivatives of their rates by u (guards, nu); then stand 1, z (nu,), x (nu,),
   * mu (m,) and eta (m,), of -z M x + mu J z + eta J x. As of guards. NULL: there are no impacts */
  void (*impacts)(const lamc_real *constants, lamc_real t, const lamc_real *q, const lamc_real *u,
                  const lamc_real *weights, lamc_real *derivatives);
  /* Of poses (12 body_count,), and of energies */
  void (*poses)(const lamc_real *constants, lamc_real t, const lamc_real *q, const lamc_real *u,
                const lamc_real *weights, lamc_real *derivatives);
  void (*energies)(const lamc_real *constants, lamc_real t, const lamc_real *q, const lamc_real *u,
                   const lamc_real *weights, lamc_real *derivatives);
  /* Of the sources: derivatives by what setup is given (parameter_count + geometry_count,) */
  void (*setup)(const lamc_real *constants, const lamc_real *weights, lamc_real *derivatives);
} lamc_pullbacks;

const lamc_pullbacks *lamc_this_pullbacks(void);

/* Entries of one size, one for each accepted step and for each event, in their order. */
typedef struct lamc_tape {
  lamc_real *entries; /* (capacity, lamc_tape_entry_size) */
  long long capacity, count;
} lamc_tape;

/* A run that is taped, under way. Fields are for reading; lamc_taped_start sets them all. */
typedef struct lamc_taped {
  lamc_motion motion; /* the run's: the first member, since callbacks of the run are given its address */
  lamc_run run;
  lamc_tape *tape;
  long long total;    /* entries so far, of all tapes */
  lamc_real t;        /* s, of the end of the last entry */
  lamc_real t_break;  /* s, of the last break of a series that was passed */
  long long next;     /* the break that ends the step under way */
  long long singular; /* steps so far at whose end loops had let equations go */
  int overflow;       /* 1: the tape was full, and an entry is missing */
} lamc_taped;

/* Numbers of an entry; and entries that must be free before a step is taken */
long long lamc_tape_entry_size(const lamc_model *model);
int lamc_tape_margin(void);

/* As lamc_run_start, and lamc_run_advance. at (rows' capacity,): for each row how many entries were written before it. A tape
 * with too little room ends a slice, as a budget does: LAMC_PAUSED; then give another. */
lamc_status lamc_taped_start(lamc_taped *s, const lamc_motion *motion, lamc_method which,
                             const lamc_options *options, lamc_real t0, const lamc_real *y0, lamc_real t_end,
                             const lamc_real *t_eval, long long t_eval_count, lamc_real *run_work);
lamc_status lamc_taped_advance(lamc_taped *s, lamc_tape *tape, lamc_rows *rows, long long *at,
                               long long budget, const volatile int *cancel);

/* Why there is no gradient */
typedef enum lamc_no_gradient {
  LAMC_GRADIENT_KNOWN = 0,
  LAMC_GRADIENT_TOGETHER = 1, /* several events at one instant: another value takes them in another order */
  LAMC_GRADIENT_GRAZING = 2,  /* a guard was touched, and not passed */
  LAMC_GRADIENT_SINGULAR = 3, /* loops lost equations at a singular position */
  LAMC_GRADIENT_NOT_FINITE = 4,
  LAMC_GRADIENT_IMPACT = 5 /* an impact drove a second one */
} lamc_no_gradient;

/* On the way back along a tape. Fields are for reading; lamc_adjoint_start sets them all. */
typedef struct lamc_adjoint {
  lamc_motion motion; /* with constants and work of its own */
  const lamc_pullbacks *pullbacks;
  const lamc_real *row_t, *row_y, *seeds; /* of the rows: times, states (n,), and derivatives (n,) by them */
  const long long *row_at;
  long long rows;     /* that are still to come */
  lamc_real rtol;     /* of the run */
  lamc_real *state;   /* (n,): derivatives by the state where the way back stands */
  lamc_real *sources; /* (source_count,): by the sources */
  lamc_real *scratch;
  long long next; /* the break that ends the step under way */
  long long evaluations, pulls, refined;
  int lost, lost_guard; /* lamc_no_gradient: why, and at which guard */
  lamc_real t_lost;
} lamc_adjoint;

/* Numbers of `work` */
long long lamc_adjoint_work_size(const lamc_model *model, const lamc_pullbacks *pullbacks);

/* A motion whose constants setup made, as the run began with it, the run's rows, and what a number weighs them with. What is
 * pointed to must outlive the way. */
lamc_status lamc_adjoint_start(lamc_adjoint *a, const lamc_motion *motion, const lamc_pullbacks *pullbacks,
                               const lamc_real *row_t, const lamc_real *row_y, const long long *row_at,
                               const lamc_real *seeds, long long rows, lamc_real rtol, lamc_real *work);

/* Back along a tape that begins with the entry of number `first`, the last tape first; LAMC_CANCELLED where there is no
 * gradient: see `lost`. */
lamc_status lamc_adjoint_back(lamc_adjoint *a, const lamc_tape *tape, long long first);

/* At the start of the run, where loops close it: the derivatives are in `state` and `sources` */
lamc_status lamc_adjoint_end(lamc_adjoint *a, lamc_real t0, const lamc_real *y0);

/* Adds derivatives of weighted poses and energies of rows to `seeds` (count, n) and to `sources`; weights of row k at
 * pose_weights + k 12 body_count, and energy_weights + k energy_count; NULL: none */
lamc_status lamc_adjoint_outputs(lamc_adjoint *a, long long count, const lamc_real *t, const lamc_real *y,
                                 const lamc_real *pose_weights, const lamc_real *energy_weights,
                                 lamc_real *seeds);

/* lamc: declarations end */

#ifdef __cplusplus
}
#endif

#endif /* LAMC_ADJOINT_H */
