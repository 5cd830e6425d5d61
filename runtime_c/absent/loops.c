/* loops.c where a model has no loops: what motion.c and others ask of it, at no cost. Only lamc's amalgamation reads it. */
#include "loops.h"

#include <stddef.h>

long long lamc_loops_work(const lamc_model *model) {
  (void)model;
  return 0;
}

int lamc_loops_acceleration(const lamc_motion *motion, lamc_real t, const lamc_real *q, const lamc_real *u,
                            lamc_real *udot, lamc_real *lambda) {
  (void)motion, (void)t, (void)q, (void)u, (void)udot, (void)lambda;
  return 0;
}

void lamc_loops_response(const lamc_motion *motion, int count, const lamc_real *goal, lamc_real *x) {
  (void)motion, (void)count, (void)goal, (void)x;
}

int lamc_loops_weigh(const lamc_motion *motion, lamc_real t, const lamc_real *q, const lamc_real *u) {
  (void)motion, (void)t, (void)q, (void)u;
  return 0;
}

void lamc_loops_free(const lamc_motion *motion, int count, lamc_real *x) {
  (void)motion, (void)count, (void)x;
}

void lamc_loops_rates(const lamc_motion *motion, int count, lamc_real *x) {
  (void)motion, (void)count, (void)x;
}

void lamc_loops_keep(const lamc_motion *motion, lamc_real *kept) {
  (void)motion, (void)kept;
}

void lamc_loops_put_back(const lamc_motion *motion, const lamc_real *kept) {
  (void)motion, (void)kept;
}

void lamc_loops_begin(const lamc_motion *motion) {
  (void)motion;
}

long long lamc_loops_doubts(const void *motion) {
  (void)motion;
  return 0;
}

lamc_real *lamc_loops_counter(const void *motion) {
  (void)motion;
  return NULL;
}

lamc_status lamc_loops_judge(const void *motion) {
  (void)motion;
  return LAMC_OK;
}

lamc_status lamc_motion_settle(const lamc_motion *motion, lamc_real t, lamc_real *y, lamc_real *moved) {
  (void)motion, (void)t, (void)y;
  *moved = 0;
  return LAMC_OK;
}
