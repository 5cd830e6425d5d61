/* control.h, of lamc: logarithm and power to base 2, to the four digits that step control can use.
 *
 * In: the square of an error norm, or a power of it. Out: the same as a logarithm, and back.
 * Never: calls a library, whose last bits differ from system to system and with them all later steps.
 *
 * Both are exact at powers of two and joined there by polynomials with the least largest error: of 1.2e-4 in the logarithm,
 * which is 1e-5 of a step, and of 1.5e-4 of the power. */
#ifndef LAMC_CONTROL_H
#define LAMC_CONTROL_H

#include "lamc_real.h"

#include <stdint.h>
#include <string.h>

/* log2 of x >= 0; -1023 of zero. Nothing of use for what is not finite. */
static inline lamc_real lamc_control_log2(lamc_real x) {
  uint64_t bits;
  memcpy(&bits, &x, sizeof bits);
  const int exponent = (int)(bits >> 52 & 0x7ff) - 1023;
  bits = (bits & 0xfffffffffffffu) | 0x3ff0000000000000u;
  lamc_real m;
  memcpy(&m, &bits, sizeof m);
  m -= 1.0;
  const lamc_real mm = m * m;
  return exponent + ((1.43873 * m - 0.67778 * mm) + (0.32118 * m - 0.08213 * mm) * mm);
}

/* 2^x for -1022 <= x < 1024 */
static inline lamc_real lamc_control_exp2(lamc_real x) {
  const int whole = (int)(x + 1023.0) - 1023; /* towards minus infinity */
  const lamc_real part = x - whole, square = part * part;
  const uint64_t bits = (uint64_t)(whole + 1023) << 52;
  lamc_real scale;
  memcpy(&scale, &bits, sizeof scale);
  return scale * ((1.0 + 0.69589 * part) + (0.22487 + 0.07924 * part) * square);
}

#endif /* LAMC_CONTROL_H */
