/* tableau.h, of lamc: coefficients of the steps that derivatives of a run go through once more.
 *
 * In: the number of a method. Out: its weights; those of Radau IIA of order 5, by which steps of implicit methods are
 * differentiated. Never: evaluates anything. */
#ifndef LAMC_TABLEAU_H
#define LAMC_TABLEAU_H

#include "dop853.h"
#include "method.h"
#include "rk45.h"

/* An explicit method as its runs use it: slopes 0 and `last` are those at the ends of a step, those behind `last` serve the
 * continuous extension. Rows of weights are of the earlier slopes in a stage's state; row `last` is the new state's. */
typedef struct tableau {
  int last, count, across;
  const lamc_real *node, *weight;
} tableau;

static const lamc_real RK45_NODE[7] = {0.0, 1.0 / 5.0, 3.0 / 10.0, 4.0 / 5.0, 8.0 / 9.0, 1.0, 1.0};
static const lamc_real RK45_WEIGHT[7][6] = {
    {0.0, 0.0, 0.0, 0.0, 0.0, 0.0},
    {1.0 / 5.0, 0.0, 0.0, 0.0, 0.0, 0.0},
    {3.0 / 40.0, 9.0 / 40.0, 0.0, 0.0, 0.0, 0.0},
    {44.0 / 45.0, -56.0 / 15.0, 32.0 / 9.0, 0.0, 0.0, 0.0},
    {19372.0 / 6561.0, -25360.0 / 2187.0, 64448.0 / 6561.0, -212.0 / 729.0, 0.0, 0.0},
    {9017.0 / 3168.0, -355.0 / 33.0, 46732.0 / 5247.0, 49.0 / 176.0, -5103.0 / 18656.0, 0.0},
    {35.0 / 384.0, 0.0, 500.0 / 1113.0, 125.0 / 192.0, -2187.0 / 6784.0, 11.0 / 84.0}};
/* Of the continuous extension, by slopes */
static const lamc_real RK45_D[7] = {-12715105075.0 / 11282082432.0,  0.0,
                                    87487479700.0 / 32700410799.0,   -10690763975.0 / 1880347072.0,
                                    701980252875.0 / 199316789632.0, -1453857185.0 / 822651844.0,
                                    69997945.0 / 29380423.0};

static inline int lamc_is_replayed(int which) {
  return which == LAMC_RK45 || which == LAMC_DOP853;
}

static inline tableau lamc_tableau(int which) {
  const tableau five = {6, 7, 6, RK45_NODE, &RK45_WEIGHT[0][0]};
  const tableau eight = {12, 16, 15, DOP853_C, &DOP853_A[0][0]};
  return which == LAMC_RK45 ? five : eight;
}

enum { RADAU_NODES = 3 };

static const lamc_real RADAU_NODE[RADAU_NODES] = {0.15505102572168222, 0.6449489742783178, 1.0};
static const lamc_real RADAU_WEIGHT[RADAU_NODES][RADAU_NODES] = {
    {0.19681547722366044, -0.06553542585019839, 0.023770974348220152},
    {0.39442431473908727, 0.29207341166522843, -0.04154875212599793},
    {0.37640306270046725, 0.51248582618842164, 0.11111111111111111}};

#endif /* LAMC_TABLEAU_H */
