/* implicit.c, of lamc: (c I - J) v = r with the Jacobian J of y = [q, u], dq/dt = u.
 *
 * J = [0 I; A B], so with v = [x; w] and r = [a; b] the system is (c^2 I - c B - A) x = b + (c I - B) a and w = c x - a:
 * one of half the size, an eighth of the work. */
#include "implicit.h"

long long lamc_implicit_size(const lamc_ode *ode) {
  const long long k = ode->n / 2;
  if (ode->jacobian == NULL || ode->n % 2 != 0) return 0;
  return 1 + 2 * k * k + k + (k * k + k) + (2 * k * k + k) + 2 * k +
         ode->scratch_size; /* 1: also where nothing moves */
}

implicit lamc_implicit_parts(const lamc_run *run, int slots) {
  implicit p;
  p.k = run->ode.n / 2;
  const size_t k = (size_t)p.k;
  p.by_q = slot(run, SLOT_OWN + slots);
  p.by_u = p.by_q + k * k;
  p.by_t = p.by_u + k * k;
  p.real = p.by_t + k;
  p.real_row = p.real + k * k;
  p.pair = p.real_row + k;
  p.pair_row = p.pair + 2 * k * k;
  p.buffer = p.pair_row + k;
  p.scratch = p.buffer + 2 * k;
  return p;
}

void lamc_implicit_jacobian(lamc_run *run, const implicit *parts) {
  if (run->has_jacobian) return;
  run->ode.jacobian(run->ode.context, run->t, y_here(run), parts->by_q, parts->by_u, parts->by_t,
                    parts->scratch);
  run->has_jacobian = 1;
  run->jacobians++;
}

/* ---- Real shift -------------------------------------------------------------------------------------------- */

int lamc_implicit_factorise(lamc_run *run, const implicit *parts, double c) {
  const int k = parts->k;
  double *w = parts->real;
  run->factorisations++;
  for (int i = 0; i < k * k; i++) w[i] = -c * parts->by_u[i] - parts->by_q[i];
  for (int i = 0; i < k; i++) w[i * k + i] += c * c;
  for (int j = 0; j < k; j++) {
    int best = j;
    for (int i = j + 1; i < k; i++)
      if (fabs(w[i * k + j]) > fabs(w[best * k + j])) best = i;
    parts->real_row[j] = best;
    for (int i = 0; i < k && best != j; i++) {
      const double keep = w[j * k + i];
      w[j * k + i] = w[best * k + i];
      w[best * k + i] = keep;
    }
    const double pivot = w[j * k + j];
    if (pivot == 0.0 || !is_finite(pivot)) return 0;
    for (int i = j + 1; i < k; i++) {
      const double factor = w[i * k + j] /= pivot;
      for (int m = j + 1; m < k; m++) w[i * k + m] -= factor * w[j * k + m];
    }
  }
  return 1;
}

void lamc_implicit_solve(const implicit *parts, double c, double *v) {
  const int k = parts->k;
  const double *w = parts->real;
  double *x = parts->buffer, *a = v, *b = v + k;
  for (int i = 0; i < k; i++) {
    x[i] = b[i] + c * a[i];
    for (int j = 0; j < k; j++) x[i] -= parts->by_u[i * k + j] * a[j];
  }
  for (int j = 0; j < k; j++) {
    const int row = (int)parts->real_row[j];
    const double keep = x[row];
    x[row] = x[j];
    x[j] = keep;
  }
  for (int i = 0; i < k; i++)
    for (int j = 0; j < i; j++) x[i] -= w[i * k + j] * x[j];
  for (int i = k - 1; i >= 0; i--) {
    for (int j = i + 1; j < k; j++) x[i] -= w[i * k + j] * x[j];
    x[i] /= w[i * k + i];
  }
  for (int i = 0; i < k; i++) {
    b[i] = c * x[i] - a[i];
    a[i] = x[i];
  }
}

double lamc_implicit_pass(const lamc_run *run, const implicit *parts, double c, const double *error,
                          double squared, double *room) {
  const double MOST = 1e4; /* 100 tolerances, squared */
  if (!run->may_pass || squared <= 1.0 || !(squared <= MOST)) return squared;
  for (int i = 0; i < run->ode.n; i++) room[i] = c * error[i];
  lamc_implicit_solve(parts, c, room);
  const double left = weighed(run, room) / run->ode.n;
  return left <= 1.0 ? left : squared;
}

/* ---- Complex shift: numbers are pairs, real part first ------------------------------------------------------- */

static double squared_size(const double *z) {
  return z[0] * z[0] + z[1] * z[1];
}

/* out -= f z */
static void take_off(double *out, const double *f, const double *z) {
  out[0] -= f[0] * z[0] - f[1] * z[1];
  out[1] -= f[0] * z[1] + f[1] * z[0];
}

/* z /= d */
static void divide(double *z, const double *d) {
  const double size = squared_size(d);
  const double re = (z[0] * d[0] + z[1] * d[1]) / size;
  z[1] = (z[1] * d[0] - z[0] * d[1]) / size;
  z[0] = re;
}

static void swap_pairs(double *a, double *b) {
  for (int i = 0; i < 2; i++) {
    const double keep = a[i];
    a[i] = b[i];
    b[i] = keep;
  }
}

int lamc_implicit_factorise_pair(lamc_run *run, const implicit *parts, const double *c) {
  const int k = parts->k;
  double *w = parts->pair;
  run->factorisations++;
  for (int i = 0; i < k * k; i++) {
    w[2 * i] = -c[0] * parts->by_u[i] - parts->by_q[i];
    w[2 * i + 1] = -c[1] * parts->by_u[i];
  }
  for (int i = 0; i < k; i++) {
    w[2 * (i * k + i)] += c[0] * c[0] - c[1] * c[1];
    w[2 * (i * k + i) + 1] += 2.0 * c[0] * c[1];
  }
  for (int j = 0; j < k; j++) {
    int best = j;
    for (int i = j + 1; i < k; i++)
      if (squared_size(w + 2 * (i * k + j)) > squared_size(w + 2 * (best * k + j))) best = i;
    parts->pair_row[j] = best;
    for (int i = 0; i < k && best != j; i++) swap_pairs(w + 2 * (j * k + i), w + 2 * (best * k + i));
    const double *pivot = w + 2 * (j * k + j);
    const double size = squared_size(pivot);
    if (size == 0.0 || !is_finite(size)) return 0;
    for (int i = j + 1; i < k; i++) {
      double *factor = w + 2 * (i * k + j);
      divide(factor, pivot);
      for (int m = j + 1; m < k; m++) take_off(w + 2 * (i * k + m), factor, w + 2 * (j * k + m));
    }
  }
  return 1;
}

void lamc_implicit_solve_pair(const implicit *parts, const double *c, double *re, double *im) {
  const int k = parts->k;
  const double *w = parts->pair;
  double *x = parts->buffer;
  for (int i = 0; i < k; i++) {
    x[2 * i] = re[k + i] + c[0] * re[i] - c[1] * im[i];
    x[2 * i + 1] = im[k + i] + c[0] * im[i] + c[1] * re[i];
    for (int j = 0; j < k; j++) {
      x[2 * i] -= parts->by_u[i * k + j] * re[j];
      x[2 * i + 1] -= parts->by_u[i * k + j] * im[j];
    }
  }
  for (int j = 0; j < k; j++) swap_pairs(x + 2 * j, x + 2 * (int)parts->pair_row[j]);
  for (int i = 0; i < k; i++)
    for (int j = 0; j < i; j++) take_off(x + 2 * i, w + 2 * (i * k + j), x + 2 * j);
  for (int i = k - 1; i >= 0; i--) {
    for (int j = i + 1; j < k; j++) take_off(x + 2 * i, w + 2 * (i * k + j), x + 2 * j);
    divide(x + 2 * i, w + 2 * (i * k + i));
  }
  for (int i = 0; i < k; i++) {
    const double *z = x + 2 * i;
    re[k + i] = c[0] * z[0] - c[1] * z[1] - re[i];
    im[k + i] = c[0] * z[1] + c[1] * z[0] - im[i];
    re[i] = z[0];
    im[i] = z[1];
  }
}
