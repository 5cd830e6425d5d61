/* lamc_sensitivity.h, of lamc: derivatives of a run by parameters and by its start.
 *
 * In:    a model with derivatives of its equations, directions in its inputs, a start and its derivatives, output times.
 * Out:   the rows of the run by itself, bit for bit, and at each the derivatives of its state; where there are none, since when.
 * Never: allocates, prints, keeps global state, or sways a step. */
#ifndef LAMC_SENSITIVITY_H
#define LAMC_SENSITIVITY_H

#include "lamc.h"

#include <stddef.h>

#ifdef __cplusplus
extern "C" {
#endif

/* lamc: declarations begin */

/* Derivatives of a model's equations. Generated C fills it; it never changes. */
struct lamc_loop_parts;

typedef struct lamc_tangents {
  int column_count;  /* k: parameters and dimensions that the equations are differentiated by */
  int state_columns; /* nq + nu; 0: derivatives by q and u are had along a direction, by `directional` */
  /* At udot and lambda -> (nu + m, state_columns + k) derivatives by q, u and columns of M udot - f - J^T lambda (nu,), then
   * of J udot + gamma (m,); then, if the model has rates, (nq, nq + nu) of dq/dt by q and u; then, of a model that gives
   * accelerations as they are, factors of M */
  void (*residuals)(const lamc_real *constants, lamc_real t, const lamc_real *q, const lamc_real *u,
                    const lamc_real *udot, const lamc_real *lambda, lamc_real *residuals);
  /* With what residuals left: rows (nu, width) less its derivatives by columns and along S (n, width); of a model that gives
   * accelerations as they are, M^-1 of that; and goals (m, width) and those of the loops */
  void (*along)(const lamc_real *residuals, int width, const lamc_real *sens, lamc_real *rows,
                lamc_real *goals);
  /* -> (m, nq + k + nq + nu + k) derivatives of phi by q and columns, then of J u by q, u and columns. NULL: a tree */
  void (*closure)(const lamc_real *constants, const lamc_real *q, const lamc_real *u, lamc_real *closure);
  /* -> (guard_count, nq + nu + 1 + k) derivatives of the guards by q, u, t and columns. NULL: there are none */
  void (*guards)(const lamc_real *constants, lamc_real t, const lamc_real *q, const lamc_real *u,
                 lamc_real *guards);
  /* -> (held_count, nq + nu + k + held_count) derivatives of what clocks sample by q, u, columns and what is held. NULL: there
   * are none. Rows of residuals and of guards end with derivatives by what is held, too */
  void (*samples)(const lamc_real *constants, lamc_real t, const lamc_real *q, const lamc_real *u,
                  lamc_real *samples);
  /* -> (nu + m,) derivatives of the residuals along a direction (nq + nu,) of q and u. NULL: state_columns are there */
  void (*directional)(const lamc_real *constants, lamc_real t, const lamc_real *q, const lamc_real *u,
                      const lamc_real *udot, const lamc_real *lambda, const lamc_real *direction,
                      lamc_real *residuals);
  int lanes; /* numbers that are worked out side by side, each of them beginning at a multiple of 64 bytes; 0: none are */
  /* As `residuals` at so many places: constants (constant_count, lanes), places (1 + nq + nu + nu + m, lanes) of t, q, u, udot
   * and lambda -> residuals (.., lanes). NULL: one place comes after the other */
  void (*side_by_side)(const lamc_real *constants, const lamc_real *places, lamc_real *residuals);
  /* As `along`, from one of those lanes on */
  void (*along_lane)(const lamc_real *residuals, int width, const lamc_real *sens, lamc_real *rows,
                     lamc_real *goals);
  /* As `directional`, along so many directions (nq + nu, lanes). NULL: one after the other */
  void (*directions)(const lamc_real *constants, const lamc_real *places, const lamc_real *directions,
                     lamc_real *residuals);
  /* rows (nu, width) replaced by x of M x = rows + J^T .., J x + goals = 0, by columns; of small loops: see loop_columns.h.
   * NULL: the runtime has a slower one */
  void (*loop_columns)(const struct lamc_loop_parts *parts, int count, int width, const lamc_real *goals,
                       lamc_real *rows, lamc_real *scratch);
} lamc_tangents;

const lamc_tangents *lamc_this_tangents(void);

/* Why there are no derivatives any more */
typedef enum lamc_lost {
  LAMC_NOT_LOST = 0,
  LAMC_LOST_TOGETHER = 1,  /* several events at one instant: another value takes them in another order */
  LAMC_LOST_GRAZING = 2,   /* a guard was touched, and not passed */
  LAMC_LOST_SINGULAR = 3,  /* loops lost equations at a singular position */
  LAMC_LOST_NOT_FINITE = 4 /* they grew beyond all numbers */
} lamc_lost;

/* Scratch of a run with derivatives: S (n, width) of an argument; two states; constants; inputs; what collocation and finer
 * steps take */
typedef struct lamc_room {
  lamc_real *argument, *y, *after, *constants, *inputs, *collocation, *fine;
} lamc_room;

/* A run with its derivatives, under way. Fields are for reading; lamc_sensitivity_start sets them all.
 *
 * A column of S, (n,), is the derivative of y = [q, u] along one direction: dS/dt = f_y S + f_p. Columns of the equations come
 * first; those behind them move the start only. Where y is stepped by an explicit method S is stepped by the same one with
 * the same stages, so that it is the derivative of what the run computes at the steps that it takes; else by collocation at
 * the nodes of Radau IIA, of order 5, on the continuous extension of y. */
typedef struct lamc_sensitivity {
  lamc_motion motion; /* the run's: the first member, since callbacks of the run are given its address */
  lamc_motion beside; /* the same with constants and work of its own, where derivatives are evaluated */
  lamc_run run;
  const lamc_tangents *tangents;
  const lamc_real *inputs;     /* what setup was given: (parameter_count + geometry_count,) */
  const lamc_real *directions; /* (column_count, parameter_count + geometry_count): how columns move them */
  int column_count;            /* of S */
  int width;                   /* the same, padded: distance of its rows */
  lamc_real t;                 /* s, where S stands */
  lamc_real t_break;           /* s, of the last break of a series that was passed */
  lamc_real t_lost;            /* s, since when there are no derivatives */
  int lost;                    /* lamc_lost: why */
  int lost_guard;              /* of LOST_TOGETHER and LOST_GRAZING: which guard */
  int has_slope;               /* 1: the last slope of the step before is the first of the next */
  int slope_count;             /* slopes of S that are known of the last step */
  int method;                  /* lamc_method of the last step */
  lamc_real h;                 /* s, of the last step */
  int is_fine; /* 1: the last step was too long for S, which went over it by steps of its own */
  /* s: where these stand, how long the next one is, how long the run's was */
  lamc_real fine_t, fine_h, h_fine_run;
  long long evaluations; /* of derivatives */
  lamc_real *here, *start,
      *end;        /* S where the run stands, where the last step began, and at its end before an event */
  lamc_real *held; /* (held_count, held_width): derivatives of what clocks hold, of all columns */
  int held_width;
  /* Constants, and `held`, as they were over the last step that was fine */
  lamc_real *over_step, *held_over_step;
  lamc_real *slopes; /* dS/dt at the stages */
  lamc_real *scratch;
  lamc_room room;
  lamc_real *remembered; /* the run's last evaluations: see memory.h */
  lamc_real *lanes[5];   /* what is worked out side by side: see side_by_side.h */
  int has_new_constants; /* 1: they are not in lanes yet */
  int ahead_first, ahead_beyond,
      ahead_entry[16]; /* which stages, and the evaluations that are remembered of them */
  ptrdiff_t entry_size, factors_size;
  int latest, recalled; /* of them: the last that was made, and the last that was asked for */
  void (*rhs)(const void *context, lamc_real t, const lamc_real *y, lamc_real *dydt); /* the run's own */
} lamc_sensitivity;

/* Numbers of `work`, beside the run's own, for so many columns of S; 0 where a count is out of bounds. */
long long lamc_sensitivity_work_size(const lamc_model *model, const lamc_tangents *tangents,
                                     int column_count);

/* As lamc_run_start, from a motion whose constants setup made of `inputs`, with derivatives s0 (n, column_count) of y0. What
 * is pointed to must outlive the run. run_work: of lamc_run_work_size. */
lamc_status lamc_sensitivity_start(lamc_sensitivity *s, const lamc_motion *motion,
                                   const lamc_tangents *tangents, const lamc_real *inputs,
                                   const lamc_real *directions, int column_count, lamc_method which,
                                   const lamc_options *options, lamc_real t0, const lamc_real *y0,
                                   const lamc_real *s0, lamc_real t_end, const lamc_real *t_eval,
                                   long long t_eval_count, lamc_real *run_work, lamc_real *work);

/* As lamc_run_advance; for each row written its derivatives too, at sensitivities + row n column_count: NaN where there are
 * none. */
lamc_status lamc_sensitivity_advance(lamc_sensitivity *s, lamc_rows *rows, lamc_real *sensitivities,
                                     long long budget, const volatile int *cancel);

/* lamc: declarations end */

#ifdef __cplusplus
}
#endif

#endif /* LAMC_SENSITIVITY_H */
