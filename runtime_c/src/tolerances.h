/* tolerances.h, of lamc: what depends on the round-off of the numbers, once for each precision.
 *
 * In loops, residuals of floats round off at 1e-7 of the size, and equations that fade to half the cube root of that are
 * let go (see lamc_loop_order in loop_equations.h). Those of floats were found by trying: passages of the N-four-bar keep
 * branch and energy, and random states move as doubles do (tests/export/test_export_float_loops.py); places
 * that are themselves within half of FADING are taken up to twice as far apart. */
#ifndef LAMC_TOLERANCES_H
#define LAMC_TOLERANCES_H

#include "lamc_real.h"

#include <float.h>

#ifdef LAMC_REAL_FLOAT
#define LAMC_EPSILON FLT_EPSILON
#define LAMC_LEAST FLT_MIN
#define LAMC_GREATEST FLT_MAX
static const lamc_real PASSING = 2e-3f;
static const lamc_real TOGETHER = 4e-3f;
static const lamc_real NEAR_SINGULAR = 0.2f;
static const lamc_real CLOSED = 2e-6f;
static const lamc_real EXACT = 5e-7f;
static const lamc_real OUT_OF_NOTHING = 2e-3f;
static const lamc_real LOST = 1e-4f;
static const lamc_real NO_EQUATION = 1e-5f;
static const lamc_real FADING = 5e-2f;
static const lamc_real NOISE = 2e-2f;
static const lamc_real AROUND = 0.1f;
static const lamc_real SMOOTH = 0.3f;
static const lamc_real ALIKE = 1e-2f;
#else
#define LAMC_EPSILON DBL_EPSILON /* round-off of 1 */
#define LAMC_LEAST DBL_MIN       /* the least number that can still be divided by */
#define LAMC_GREATEST DBL_MAX
static const lamc_real PASSING =
    3e-5; /* of the first pivot, or of one: an equation that fades below is let go */
static const lamc_real TOGETHER = 3e-4;     /* likewise: what has faded to this goes with it */
static const lamc_real NEAR_SINGULAR = 0.1; /* likewise: closer than this, states are settled before use */
static const lamc_real CLOSED = 1e-13;      /* rad, or of the size: round-off of the residuals */
static const lamc_real EXACT = 1e-15;       /* likewise, to the last digit: what a singular place asks for */
static const lamc_real OUT_OF_NOTHING = 1e-10; /* of accelerations: what being off closure may add to them */
static const lamc_real LOST = 1e-4;            /* rad, or of the size: no drift of a step comes near it */
static const lamc_real FADING = 3e-3; /* of a row of J: below, accelerations are those of places around */
static const lamc_real AROUND =
    1e-2; /* rad, between these: digits go by the square, truncation by the sixth power */
/* Of accelerations, but for round-off of the state's own: what two places around may differ from them, and six. In
 * N-four-bars two differ by 5e-5, in popups beside a singular position by a third and more. */
static const lamc_real SMOOTH = 0.1;
static const lamc_real ALIKE = 1e-5;
static const lamc_real NOISE = 1e-8; /* of what a row has left: where it may have more, a plan is left */
static const lamc_real NO_EQUATION = 1e-12; /* of a row of J: less is left over from rounding the drawing */
#endif
/* Times the gap that is accepted, of the size: shorter rows of J are not made longer, or a misfit becomes an equation */
static const lamc_real OF_MISFIT = 1000;

#endif /* LAMC_TOLERANCES_H */
