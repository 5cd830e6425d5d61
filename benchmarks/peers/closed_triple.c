/* closed_triple.c: a row of three equal links, as one would write it by hand, with an integrator of its own.
 *
 * In:    a triple_model and [angles from the horizontal, down is positive (3), their rates (3)]. Out: the state at t_end.
 * Never: shares a line with lamc.
 *
 * Equations: Lagrange's in absolute angles, the closed form of textbooks. Links of length L with their centres at c along
 * them, mass m, moment I about the centre; springs k and dampers b in the three hinges. With A_ij of `coefficients`,
 *     sum_j A_ij cos(a_i - a_j) a_j'' + A_ij sin(a_i - a_j) a_j'^2 = G_i cos a_i + hinge torques.
 * Integrator: DOPRI5 as in E. Hairer, S. P. Norsett, G. Wanner, Solving Ordinary Differential Equations I, 2nd ed.
 * (1993), sections II.4 and II.5, appendix: PI step control, first step, no output between steps; loops of fixed length. */
#include <float.h>
#include <math.h>
#include <string.h>

enum { N = 3, SIZE = 2 * N };

typedef struct triple_model {
  double length, centre, mass, moment, stiffness, damping, gravity;
} triple_model;

typedef struct coefficients {
  double A[N][N], G[N], k, b;
} coefficients;

static coefficients prepare(const triple_model *p) {
  coefficients c;
  for (int i = 0; i < N; i++) {
    const int beyond_i = N - 1 - i;
    for (int j = i; j < N; j++) {
      const int beyond = N - 1 - j;
      c.A[i][j] = p->mass * (p->length * (i == j ? 0.0 : p->centre) + beyond * p->length * p->length);
      if (i == j) c.A[i][j] += p->moment + p->mass * p->centre * p->centre;
      c.A[j][i] = c.A[i][j];
    }
    c.G[i] = p->mass * p->gravity * (p->centre + beyond_i * p->length);
  }
  c.k = p->stiffness;
  c.b = p->damping;
  return c;
}

static void slope(const coefficients *p, const double *y, double *f) {
#ifdef TEXTBOOK /* the formulas as they are printed */
  const double c0 = cos(y[0]), c1 = cos(y[1]), c2 = cos(y[2]);
  const double c01 = cos(y[0] - y[1]), c02 = cos(y[0] - y[2]), c12 = cos(y[1] - y[2]);
  const double s01 = sin(y[0] - y[1]), s02 = sin(y[0] - y[2]), s12 = sin(y[1] - y[2]);
#else /* half as many sines and cosines, by their theorems of addition */
  const double s0 = sin(y[0]), c0 = cos(y[0]), s1 = sin(y[1]), c1 = cos(y[1]), s2 = sin(y[2]), c2 = cos(y[2]);
  const double c01 = c0 * c1 + s0 * s1, c02 = c0 * c2 + s0 * s2, c12 = c1 * c2 + s1 * s2;
  const double s01 = s0 * c1 - c0 * s1, s02 = s0 * c2 - c0 * s2, s12 = s1 * c2 - c1 * s2;
#endif
  const double u0 = y[3], u1 = y[4], u2 = y[5];
  const double m00 = p->A[0][0], m11 = p->A[1][1], m22 = p->A[2][2];
  const double m01 = p->A[0][1] * c01, n01 = p->A[0][1] * s01;
  const double m02 = p->A[0][2] * c02, n02 = p->A[0][2] * s02;
  const double m12 = p->A[1][2] * c12, n12 = p->A[1][2] * s12;
  const double t0 = p->k * y[0] + p->b * u0; /* what each hinge resists with */
  const double t1 = p->k * (y[1] - y[0]) + p->b * (u1 - u0);
  const double t2 = p->k * (y[2] - y[1]) + p->b * (u2 - u1);
  const double w0 = u0 * u0, w1 = u1 * u1, w2 = u2 * u2;
  const double r0 = p->G[0] * c0 - n01 * w1 - n02 * w2 - t0 + t1;
  const double r1 = p->G[1] * c1 + n01 * w0 - n12 * w2 - t1 + t2;
  const double r2 = p->G[2] * c2 + n02 * w0 + n12 * w1 - t2;
  /* L D L^T of the symmetric 3 x 3 matrix, from the last row up */
  const double d2 = 1.0 / m22, l02 = m02 * d2, l12 = m12 * d2;
  const double a01 = m01 - l02 * m12, d1 = 1.0 / (m11 - l12 * m12), l01 = a01 * d1;
  const double z1 = r1 - l12 * r2;
  const double x0 = (r0 - l02 * r2 - l01 * z1) / (m00 - l02 * m02 - l01 * a01);
  const double x1 = z1 * d1 - l01 * x0;
  f[0] = u0;
  f[1] = u1;
  f[2] = u2;
  f[3] = x0;
  f[4] = x1;
  f[5] = r2 * d2 - l02 * x0 - l12 * x1;
}

static double norm(const double *v, const double *y, double rtol, double atol) {
  double sum = 0.0;
  for (int i = 0; i < SIZE; i++) {
    const double ratio = v[i] / (atol + rtol * fabs(y[i]));
    sum += ratio * ratio;
  }
  return sqrt(sum / SIZE);
}

static double first_step(const coefficients *p, const double *y, const double *f, double t_end, double rtol,
                         double atol) {
  const double size = norm(y, y, rtol, atol), speed = norm(f, y, rtol, atol);
  double h = size < 1e-5 || speed < 1e-5 ? 1e-6 : 0.01 * size / speed;
  double z[SIZE], g[SIZE];
  for (int i = 0; i < SIZE; i++) z[i] = y[i] + h * f[i];
  slope(p, z, g);
  for (int i = 0; i < SIZE; i++) g[i] -= f[i];
  const double bend = norm(g, y, rtol, atol) / h, most = fmax(speed, bend);
  const double by_order = most <= 1e-15 ? fmax(1e-6, 1e-3 * h) : pow(0.01 / most, 0.2);
  return fmin(fmin(100.0 * h, by_order), t_end);
}

/* From y (6,) at 0 to t_end, in place. Accepted steps, or -1 where the step underflows. */
long triple_run(const triple_model *model, double *y, double t_end, double rtol, double atol) {
  const coefficients p = prepare(model);
  double k1[SIZE], k2[SIZE], k3[SIZE], k4[SIZE], k5[SIZE], k6[SIZE], k7[SIZE], z[SIZE], yn[SIZE];
  double t = 0.0, old = 1e-4;
  long steps = 0;
  int rejected = 0;
  slope(&p, y, k1);
  double h = first_step(&p, y, k1, t_end, rtol, atol);
  while (t < t_end) {
    int last = 0;
    if (h <= DBL_EPSILON * t) return -1;
    if (t + 1.01 * h >= t_end) {
      h = t_end - t;
      last = 1;
    }
    for (int i = 0; i < SIZE; i++) z[i] = y[i] + h * (1.0 / 5.0) * k1[i];
    slope(&p, z, k2);
    for (int i = 0; i < SIZE; i++) z[i] = y[i] + h * (3.0 / 40.0 * k1[i] + 9.0 / 40.0 * k2[i]);
    slope(&p, z, k3);
    for (int i = 0; i < SIZE; i++)
      z[i] = y[i] + h * (44.0 / 45.0 * k1[i] - 56.0 / 15.0 * k2[i] + 32.0 / 9.0 * k3[i]);
    slope(&p, z, k4);
    for (int i = 0; i < SIZE; i++)
      z[i] = y[i] + h * (19372.0 / 6561.0 * k1[i] - 25360.0 / 2187.0 * k2[i] + 64448.0 / 6561.0 * k3[i] -
                         212.0 / 729.0 * k4[i]);
    slope(&p, z, k5);
    for (int i = 0; i < SIZE; i++)
      z[i] = y[i] + h * (9017.0 / 3168.0 * k1[i] - 355.0 / 33.0 * k2[i] + 46732.0 / 5247.0 * k3[i] +
                         49.0 / 176.0 * k4[i] - 5103.0 / 18656.0 * k5[i]);
    slope(&p, z, k6);
    for (int i = 0; i < SIZE; i++)
      yn[i] = y[i] + h * (35.0 / 384.0 * k1[i] + 500.0 / 1113.0 * k3[i] + 125.0 / 192.0 * k4[i] -
                          2187.0 / 6784.0 * k5[i] + 11.0 / 84.0 * k6[i]);
    slope(&p, yn, k7);
    double sum = 0.0;
    for (int i = 0; i < SIZE; i++) {
      const double e = h * (71.0 / 57600.0 * k1[i] - 71.0 / 16695.0 * k3[i] + 71.0 / 1920.0 * k4[i] -
                            17253.0 / 339200.0 * k5[i] + 22.0 / 525.0 * k6[i] - 1.0 / 40.0 * k7[i]);
      const double ratio = e / (atol + rtol * fmax(fabs(y[i]), fabs(yn[i])));
      sum += ratio * ratio;
    }
    const double error = sqrt(sum / SIZE), by_error = pow(error, 0.17);
    if (error <= 1.0) {
      const double shrink = fmax(0.1, fmin(5.0, by_error / pow(old, 0.04) / 0.9));
      double next = h / shrink;
      if (rejected) next = fmin(next, h);
      old = fmax(error, 1e-4);
      memcpy(y, yn, sizeof yn);
      memcpy(k1, k7, sizeof k7);
      t = last ? t_end : t + h;
      h = next;
      rejected = 0;
      steps++;
    } else {
      h /= fmin(5.0, by_error / 0.9);
      rejected = 1;
    }
  }
  return steps;
}

/* Right-hand sides of rows (count, 6), for comparison and to time one. */
void triple_slopes(const triple_model *model, long count, const double *y, double *f) {
  const coefficients p = prepare(model);
  for (long row = 0; row < count; row++) slope(&p, y + SIZE * row, f + SIZE * row);
}
