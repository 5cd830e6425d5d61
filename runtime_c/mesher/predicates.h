/* The sign of two determinants, exactly. */
#ifndef LAMC_PREDICATES_H
#define LAMC_PREDICATES_H

/* Positive where a, b, c turn counter-clockwise, zero where they are in line. */
double lamc_orientation(const double a[2], const double b[2], const double c[2]);

/* Positive where d lies inside the circle through a, b, c, which turn counter-clockwise; zero on it. */
double lamc_in_circle(const double a[2], const double b[2], const double c[2], const double d[2]);

#endif
