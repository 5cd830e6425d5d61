/* cst: the equations of a finite element, straight, for numbers of any kind.
 *
 * Made by lamc VERSION from template element_equations.h.j2. Do not edit: change the element and build again.
 * Element digest 61ed2f9e5bb1b392e6e46439026e6cbf730a8f152da46fe378309d9ec856d7b9
 *
 * cst.c includes this once for each kind of number, having defined
 *
 *   scalar       the type of numbers
 *   real         the type of values: a number, or one for each of several cells
 *   EACH(x)      a number as a value
 *   OF(name)     the function's name for that type
 *   RATIO(p, q)  the number p/q in that type's precision
 *
 * Inputs, for one cell:
 *   xy   (6)  x and y of the corners, m
 *   s    (6)  unique entries of the section's stiffness
 *   rho  (1)  kg/m^2
 *   f    (6)  forces per area at the corners, N/m^2, field by field
 *   r    (3)  membrane forces, N/m, then moments, N
 *   xi   (2)  xi and eta of a point
 *   d    (6)  of the element, node by node
 */

/* stiffness, lower triangle by rows, N/m for displacements; 84 operations, 1 of them reciprocals */
static inline void OF(stiffness)(const real *xy, const real *s, real *out) {
  /* sides of the cell, and what shape functions take from them */
  const real z0 = xy[0] - xy[2];
  const real z1 = xy[1] - xy[3];
  const real z2 = xy[0] - xy[4];
  const real z3 = xy[1] - xy[5];
  const real z4 = 1.0/(z0*z3 - z1*z2);
  /* stiffness against these amounts (K = int B^T S B dA) */
  const real z5 = 0.5*z4;
  const real z6 = s[0]*z5;
  const real z7 = s[1]*z5;
  const real z8 = s[2]*z5;
  const real z9 = s[3]*z5;
  const real z10 = s[4]*z5;
  const real z11 = s[5]*z5;
  const real z12 = z3*z6 - z2*z8;
  const real z13 = z2*z10;
  const real z14 = z3*z7 - z13;
  const real z15 = z0*z10;
  const real z16 = z1*z7 - z15;
  const real z17 = z2*z9 - z3*z10;
  const real z18 = z3*z8 - z2*z11;
  const real z19 = z1*z8 - z0*z11;
  const real z20 = z13 - z3*z11;
  const real z21 = z3*z12 - z2*z18;
  const real z22 = z1*z12 - z0*z18;
  const real z23 = z1*(z1*z6 - z0*z8) - z0*z19;
  const real z24 = z2*z14 - z3*z18;
  const real z25 = z2*z16 - z3*z19;
  const real z26 = z2*z17 - z3*z20;
  const real z27 = z0*z14 - z1*z18;
  const real z28 = z0*z16 - z1*z19;
  const real z29 = z0*z17 - z1*z20;
  const real z30 = z0*(z0*z9 - z1*z10) - z1*(z15 - z1*z11);
  /* stiffness against the unknowns (W^T K W) */
  const real z31 = z21 - z22;
  const real z32 = z24 - z25;
  const real z33 = z22 - z23;
  const real z34 = z27 - z28;
  const real z35 = z24 - z27;
  const real z36 = z26 - z29;
  const real z37 = z25 - z28;
  const real z38 = z29 - z30;
  const real z39 = z31 - z33;
  const real z40 = z32 - z34;
  const real z41 = z36 - z38;
  out[0] = z39;
  out[1] = -z40;
  out[2] = z41;
  out[3] = -z31;
  out[4] = z35;
  out[5] = z21;
  out[6] = z32;
  out[7] = -z36;
  out[8] = -z24;
  out[9] = z26;
  out[10] = z33;
  out[11] = -z37;
  out[12] = -z22;
  out[13] = z25;
  out[14] = z23;
  out[15] = -z34;
  out[16] = z38;
  out[17] = z27;
  out[18] = -z29;
  out[19] = -z28;
  out[20] = z30;
}

/* consistent mass, lower triangle by rows, kg for displacements; 10 operations, 0 of them reciprocals */
static inline void OF(mass)(const real *xy, const real *rho, real *out) {
  /* sides of the cell, and what shape functions take from them */
  const real z0 = (xy[0] - xy[2])*(xy[1] - xy[5]) - (xy[1] - xy[3])*(xy[0] - xy[4]);
  /* mass (int rho (u^2 + v^2 + w^2) dA) */
  const real z1 = z0*rho[0];
  const real z2 = RATIO(1.0, 12.0)*z1;
  const real z3 = RATIO(1.0, 24.0)*z1;
  out[0] = z2;
  out[1] = EACH(0.0);
  out[2] = z2;
  out[3] = z3;
  out[4] = EACH(0.0);
  out[5] = z2;
  out[6] = EACH(0.0);
  out[7] = z3;
  out[8] = EACH(0.0);
  out[9] = z2;
  out[10] = z3;
  out[11] = EACH(0.0);
  out[12] = z3;
  out[13] = EACH(0.0);
  out[14] = z2;
  out[15] = EACH(0.0);
  out[16] = z3;
  out[17] = EACH(0.0);
  out[18] = z3;
  out[19] = EACH(0.0);
  out[20] = z2;
}

/* forces of a load, N for displacements; 37 operations, 0 of them reciprocals */
static inline void OF(load)(const real *xy, const real *f, real *out) {
  /* sides of the cell, and what shape functions take from them */
  const real z0 = (xy[0] - xy[2])*(xy[1] - xy[5]) - (xy[1] - xy[3])*(xy[0] - xy[4]);
  /* load (int N p dA) */
  const real z1 = z0*f[0];
  const real z2 = z0*f[1];
  const real z3 = z0*f[2];
  const real z4 = RATIO(1.0, 12.0)*z1 + RATIO(1.0, 24.0)*(z2 + z3);
  const real z5 = RATIO(1.0, 24.0)*(z1 + z3) + RATIO(1.0, 12.0)*z2;
  const real z6 = RATIO(1.0, 24.0)*(z1 + z2) + RATIO(1.0, 12.0)*z3;
  const real z7 = z0*f[3];
  const real z8 = z0*f[4];
  const real z9 = z0*f[5];
  const real z10 = RATIO(1.0, 12.0)*z7 + RATIO(1.0, 24.0)*(z8 + z9);
  const real z11 = RATIO(1.0, 24.0)*(z7 + z9) + RATIO(1.0, 12.0)*z8;
  const real z12 = RATIO(1.0, 24.0)*(z7 + z8) + RATIO(1.0, 12.0)*z9;
  out[0] = z4;
  out[1] = z10;
  out[2] = z5;
  out[3] = z11;
  out[4] = z6;
  out[5] = z12;
}

/* forces of membrane forces and moments, N for displacements; 22 operations, 0 of them reciprocals */
static inline void OF(prestress)(const real *xy, const real *r, real *out) {
  /* sides of the cell, and what shape functions take from them */
  const real z0 = xy[0] - xy[2];
  const real z1 = xy[1] - xy[3];
  const real z2 = xy[0] - xy[4];
  const real z3 = xy[1] - xy[5];
  /* prestress (int B^T r dA) */
  const real z4 = 0.5*(z3*r[0] - z2*r[2]);
  const real z5 = 0.5*(z2*r[1] - z3*r[2]);
  const real z6 = 0.5*(z1*r[0] - z0*r[2]);
  const real z7 = 0.5*(z0*r[1] - z1*r[2]);
  const real z8 = z4 - z6;
  const real z9 = z5 - z7;
  out[0] = z8;
  out[1] = -z9;
  out[2] = -z4;
  out[3] = z5;
  out[4] = z6;
  out[5] = -z7;
}

/* strains at a point, then curvatures, 1/m; 28 operations, 1 of them reciprocals */
static inline void OF(strain)(const real *xy, const real *xi, const real *d, real *out) {
  (void)xi;
  /* sides of the cell, and what shape functions take from them */
  const real z0 = xy[0] - xy[2];
  const real z1 = xy[1] - xy[3];
  const real z2 = xy[0] - xy[4];
  const real z3 = xy[1] - xy[5];
  const real z4 = 1.0/(z0*z3 - z1*z2);
  /* amounts that rigid motion leaves at zero */
  const real z5 = d[0] - d[2];
  const real z6 = d[1] - d[3];
  const real z7 = d[0] - d[4];
  const real z8 = d[1] - d[5];
  /* strain (B d) */
  const real z9 = z4*(z3*z5 - z1*z7);
  const real z10 = z4*(z2*z6 - z0*z8);
  const real z11 = ((z2*z5 - z0*z7) - z3*z6) + z1*z8;
  const real z12 = z4*z11;
  out[0] = z9;
  out[1] = -z10;
  out[2] = -z12;
}

/* displacements at a point, m, then slopes; 12 operations, 0 of them reciprocals */
static inline void OF(displacement)(const real *xy, const real *xi, const real *d, real *out) {
  (void)xy;
  /* displacement (N d) */
  const real z0 = xi[0] + (xi[1] - 1.0);
  const real z1 = (d[0]*z0 - xi[0]*d[2]) - xi[1]*d[4];
  const real z2 = (d[1]*z0 - xi[0]*d[3]) - xi[1]*d[5];
  out[0] = -z1;
  out[1] = -z2;
}

/* forces of the stiffness by way of strains, N for displacements; 60 operations, 1 of them reciprocals */
static inline void OF(force)(const real *xy, const real *s, const real *d, real *out) {
  /* sides of the cell, and what shape functions take from them */
  const real z0 = xy[0] - xy[2];
  const real z1 = xy[1] - xy[3];
  const real z2 = xy[0] - xy[4];
  const real z3 = xy[1] - xy[5];
  const real z4 = 1.0/(z0*z3 - z1*z2);
  /* amounts that rigid motion leaves at zero */
  const real z5 = d[0] - d[2];
  const real z6 = d[1] - d[3];
  const real z7 = d[0] - d[4];
  const real z8 = d[1] - d[5];
  /* strain (B d) */
  const real z9 = z4*(z3*z5 - z1*z7);
  const real z10 = z4*(z2*z6 - z0*z8);
  const real z11 = ((z2*z5 - z0*z7) - z3*z6) + z1*z8;
  const real z12 = z4*z11;
  /* forces on these amounts, from strains (int B^T S eps dA) */
  const real z13 = 0.5*((s[0]*z9 - s[1]*z10) - s[2]*z12);
  const real z14 = 0.5*((s[1]*z9 - s[3]*z10) - s[4]*z12);
  const real z15 = 0.5*((s[2]*z9 - s[4]*z10) - s[5]*z12);
  const real z16 = z3*z13 - z2*z15;
  const real z17 = z1*z13 - z0*z15;
  const real z18 = z2*z14 - z3*z15;
  const real z19 = z0*z14 - z1*z15;
  /* forces on the unknowns */
  const real z20 = z16 - z17;
  const real z21 = z18 - z19;
  out[0] = z20;
  out[1] = -z21;
  out[2] = -z16;
  out[3] = z18;
  out[4] = z17;
  out[5] = -z19;
}

