/* rk45.h, of lamc: coefficients of the pair of Dormand and Prince of order 5; their source is told in rk45.c. */
#ifndef LAMC_RK45_H
#define LAMC_RK45_H

#include "lamc_real.h"

/* c_i */
static const lamc_real RK45_C2 = 1.0 / 5.0, RK45_C3 = 3.0 / 10.0, RK45_C4 = 4.0 / 5.0, RK45_C5 = 8.0 / 9.0;
/* a_ij */
static const lamc_real RK45_A21 = 1.0 / 5.0;
static const lamc_real RK45_A31 = 3.0 / 40.0, RK45_A32 = 9.0 / 40.0;
static const lamc_real RK45_A41 = 44.0 / 45.0, RK45_A42 = -56.0 / 15.0, RK45_A43 = 32.0 / 9.0;
static const lamc_real RK45_A51 = 19372.0 / 6561.0, RK45_A52 = -25360.0 / 2187.0, RK45_A53 = 64448.0 / 6561.0,
                       RK45_A54 = -212.0 / 729.0;
static const lamc_real RK45_A61 = 9017.0 / 3168.0, RK45_A62 = -355.0 / 33.0, RK45_A63 = 46732.0 / 5247.0,
                       RK45_A64 = 49.0 / 176.0, RK45_A65 = -5103.0 / 18656.0;
/* b_i, the row of order 5, also a_7i */
static const lamc_real RK45_B1 = 35.0 / 384.0, RK45_B3 = 500.0 / 1113.0, RK45_B4 = 125.0 / 192.0,
                       RK45_B5 = -2187.0 / 6784.0, RK45_B6 = 11.0 / 84.0;
/* b_i - b^_i, the difference from the row of order 4 */
static const lamc_real RK45_E1 = 71.0 / 57600.0, RK45_E3 = -71.0 / 16695.0, RK45_E4 = 71.0 / 1920.0,
                       RK45_E5 = -17253.0 / 339200.0, RK45_E6 = 22.0 / 525.0, RK45_E7 = -1.0 / 40.0;

#endif /* LAMC_RK45_H */
