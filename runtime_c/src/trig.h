/* trig.h, of lamc: sine and cosine that are inlined, for a compile that asks for speed.
 *
 * In: an angle, rad. Out: its sine or cosine within 2.5 units in the last place (1.1 up to a turn, 1.4 up to 1000 rad).
 * Never: looks into a table, or branches but for angles beyond LAMC_TRIG_MOST and for what is no number: libm gets those.
 *
 * Reduction by Cody & Waite (1980): x - n pi/2 with pi/2 in three parts of 33 bits, so that n times each is exact for
 * |n| < 2^20. Minimax polynomials on [-pi/4, pi/4] are those of fdlibm's k_sin.c and k_cos.c (Sun Microsystems 1993).
 * Both polynomials are evaluated and one is taken, so that sine and cosine of one angle share all their work. */
#ifndef LAMC_TRIG_H
#define LAMC_TRIG_H

#include <math.h>

#define LAMC_TRIG_MOST 1e5

static inline double lamc_sine_of(double x, long long turns) {
  const double magic = 6755399441055744.0; /* 1.5 * 2^52: adding it rounds to a whole number */
  const double shifted = x * 6.36619772367581382433e-01 + magic, n = shifted - magic;
  const double r = ((x - n * 1.57079632673412561417e+00) - n * 6.07710050630396597660e-11) -
                   n * 2.02226624879595063154e-21;
  const long long quadrant = (long long)n + turns;
  const double z = r * r;
  const double s = 8.33333333332248946124e-03 +
                   z * (-1.98412698298579493134e-04 +
                        z * (2.75573137070700676789e-06 +
                             z * (-2.50507602534068634195e-08 + z * 1.58969099521155010221e-10)));
  const double sine = r + z * r * (-1.66666666666666324348e-01 + z * s);
  const double c = 4.16666666666666019037e-02 +
                   z * (-1.38888888888741095749e-03 +
                        z * (2.48015872894767294178e-05 +
                             z * (-2.75573143513906633035e-07 +
                                  z * (2.08757232129817482790e-09 + z * -1.13596475577881948265e-11))));
  const double half = 0.5 * z, w = 1.0 - half;
  const double cosine = w + (((1.0 - w) - half) + z * z * c);
  const double value = quadrant & 1 ? cosine : sine;
  return quadrant & 2 ? -value : value;
}

static inline double lamc_sin(double x) {
  return fabs(x) < LAMC_TRIG_MOST ? lamc_sine_of(x, 0) : sin(x);
}

static inline double lamc_cos(double x) {
  return fabs(x) < LAMC_TRIG_MOST ? lamc_sine_of(x, 1) : cos(x);
}

#endif
