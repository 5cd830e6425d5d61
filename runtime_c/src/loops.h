/* loops.h, of lamc: what the motion asks of loops.c. All of it uses the motion's work. */
#ifndef LAMC_LOOPS_H
#define LAMC_LOOPS_H

#include "lamc.h"

/* Numbers of work that loops need; 0 for a tree */
long long lamc_loops_work(const lamc_model *model);

/* udot (nu,) of a motion with loops, and lambda (m,) of M udot = f + J^T lambda unless NULL; how many equations count */
int lamc_loops_acceleration(const lamc_motion *motion, lamc_real t, const lamc_real *q, const lamc_real *u,
                            lamc_real *udot, lamc_real *lambda);

/* After an acceleration, at the same place: x (nu,) replaced by the solution of M x = x_before + J^T ..., J x + goal = 0 */
void lamc_loops_response(const lamc_motion *motion, int count, const lamc_real *goal, lamc_real *x);

/* What loops.c counts along a run, for what is evaluated beside the run to leave no trace in it */
enum { LAMC_LOOPS_KEPT = 7 };
void lamc_loops_keep(const lamc_motion *motion, lamc_real *kept);
void lamc_loops_put_back(const lamc_motion *motion, const lamc_real *kept);

/* phi (m,) and J (m, nu), every entry, at q (nq,) */
void lamc_loops_closure(const lamc_motion *motion, const lamc_real *q, lamc_real *closure);

/* Before a run: no step was taken yet. */
void lamc_loops_begin(const lamc_motion *motion);

/* LAMC_RANK_LOST where equations have been missing for many steps in a row: lamc_ode.judge of a motion with loops */
lamc_status lamc_loops_judge(const void *motion);

/* How many accelerations were worked out without all equations: lamc_ode.doubts of a motion with loops */
/* Where the work of a motion's loops is counted; see `lamc_motion_work_done` */
lamc_real *lamc_loops_counter(const void *context);

long long lamc_loops_doubts(const void *motion);

/* M = L L^T and the equations of the loops at a state; how many count. For the two functions below */
int lamc_loops_weigh(const lamc_motion *motion, lamc_real t, const lamc_real *q, const lamc_real *u);
/* x (nu,) replaced by what of a force the loops leave free, so that x . x is twice the energy that its impulse gives */
void lamc_loops_free(const lamc_motion *motion, int count, lamc_real *x);
/* x (nu,) replaced by the rates of such a part */
void lamc_loops_rates(const lamc_motion *motion, int count, lamc_real *x);

#endif /* LAMC_LOOPS_H */
