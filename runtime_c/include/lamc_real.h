/* lamc_real.h: the type of all numbers of the runtime, and how constants of it are written.
 *
 * double; float where LAMC_REAL_FLOAT is defined, for steps of fixed length on processors without doubles. Steps that
 * control their error need doubles: run.c refuses floats. */
#ifndef LAMC_REAL_H
#define LAMC_REAL_H

#ifdef LAMC_REAL_FLOAT
#include <tgmath.h> /* fabs of a float is one */

typedef float lamc_real;
#define LAMC_R(x) x##f
#else
/* lamc: declarations begin */
typedef double lamc_real;
/* lamc: declarations end */
#define LAMC_R(x) x
#endif

#endif /* LAMC_REAL_H */
