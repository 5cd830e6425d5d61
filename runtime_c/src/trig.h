/* trig.h, of lamc: sine and cosine of one angle or of two at a time, for every model.
 *
 * In: angles, rad: any numbers. Out: sine and cosine; errors, and what it takes, stand in the header of each precision.
 * Never: calls a library; depends on the machine. */
#ifndef LAMC_TRIG_H
#define LAMC_TRIG_H

#include "lamc_real.h"

#ifdef LAMC_REAL_FLOAT
#include "trig_float.h"
#else
#include "trig_double.h"
#endif

static inline lamc_real lamc_sin(lamc_real x) {
  lamc_real sine, cosine;
  lamc_turn(x, &sine, &cosine);
  return sine;
}

static inline lamc_real lamc_cos(lamc_real x) {
  lamc_real sine, cosine;
  lamc_turn(x, &sine, &cosine);
  return cosine;
}

#endif /* LAMC_TRIG_H */
