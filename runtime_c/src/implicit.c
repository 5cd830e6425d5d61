/* implicit.c, of lamc: (c I - J) v = r with the Jacobian J of an equation, c real or complex.
 *
 * Where y = [q, u] with dq/dt = u, J = [0 I; A B], so with v = [x; w] and r = [a; b] the system is
 * (c^2 I - c B - A) x = b + (c I - B) a and w = c x - a: one of half the size, an eighth of the work. Any other equation
 * is taken as it is. */
#include "implicit.h"

static int has_structure(const lamc_ode *ode) {
  return ode->full_jacobian == NULL;
}

long long lamc_implicit_size(const lamc_ode *ode) {
  if (ode->full_jacobian == NULL && (ode->jacobian == NULL || ode->n % 2 != 0)) return 0;
  const long long k = has_structure(ode) ? ode->n / 2 : ode->n;
  return 1 + 2 * k * k + k + (k * k + k) + (2 * k * k + k) + 2 * k +
         ode->scratch_size; /* 1: also where nothing moves */
}

implicit lamc_implicit_parts(const lamc_run *run, int slots) {
  implicit p;
  p.has_structure = has_structure(&run->ode);
  p.k = p.has_structure ? run->ode.n / 2 : run->ode.n;
  p.late = run->ode.n - p.k;
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
  const lamc_ode *ode = &run->ode;
  if (run->has_jacobian) return;
  if (parts->has_structure) {
    ode->jacobian(ode->context, run->t, y_here(run), parts->by_q, parts->by_u, parts->by_t, parts->scratch);
  } else {
    ode->full_jacobian(ode->context, run->t, y_here(run), parts->by_q, parts->by_t, parts->scratch);
  }
  run->has_jacobian = 1;
  run->jacobians++;
}

/* ---- Real shift -------------------------------------------------------------------------------------------- */

/* Factors of w (k, k) in place, with partial pivoting. 0 if it is singular or not finite. */
static int factorise(int k, lamc_real *w, lamc_real *from) {
  for (int j = 0; j < k; j++) {
    int best = j;
    for (int i = j + 1; i < k; i++)
      if (fabs(w[i * k + j]) > fabs(w[best * k + j])) best = i;
    from[j] = (lamc_real)best;
    for (int i = 0; i < k && best != j; i++) {
      const lamc_real keep = w[j * k + i];
      w[j * k + i] = w[best * k + i];
      w[best * k + i] = keep;
    }
    const lamc_real pivot = w[j * k + j];
    if (pivot == 0 || !is_finite(pivot)) return 0;
    for (int i = j + 1; i < k; i++) {
      const lamc_real factor = w[i * k + j] /= pivot;
      for (int m = j + 1; m < k; m++) w[i * k + m] -= factor * w[j * k + m];
    }
  }
  return 1;
}

/* x = w^-1 x with those factors */
static void solve(int k, const lamc_real *w, const lamc_real *from, lamc_real *x) {
  for (int j = 0; j < k; j++) {
    const int row = (int)from[j];
    const lamc_real keep = x[row];
    x[row] = x[j];
    x[j] = keep;
  }
  for (int i = 0; i < k; i++)
    for (int j = 0; j < i; j++) x[i] -= w[i * k + j] * x[j];
  for (int i = k - 1; i >= 0; i--) {
    for (int j = i + 1; j < k; j++) x[i] -= w[i * k + j] * x[j];
    x[i] /= w[i * k + i];
  }
}

int lamc_implicit_factorise(lamc_run *run, const implicit *parts, lamc_real c) {
  const int k = parts->k;
  lamc_real *w = parts->real;
  run->factorisations++;
  if (parts->has_structure) {
    for (int i = 0; i < k * k; i++) w[i] = -c * parts->by_u[i] - parts->by_q[i];
    for (int i = 0; i < k; i++) w[i * k + i] += c * c;
  } else {
    for (int i = 0; i < k * k; i++) w[i] = -parts->by_q[i];
    for (int i = 0; i < k; i++) w[i * k + i] += c;
  }
  return factorise(k, w, parts->real_row);
}

void lamc_implicit_solve(const implicit *parts, lamc_real c, lamc_real *v) {
  const int k = parts->k;
  lamc_real *x = parts->buffer, *a = v, *b = v + k;
  if (!parts->has_structure) {
    solve(k, parts->real, parts->real_row, v);
    return;
  }
  for (int i = 0; i < k; i++) {
    x[i] = b[i] + c * a[i];
    for (int j = 0; j < k; j++) x[i] -= parts->by_u[i * k + j] * a[j];
  }
  solve(k, parts->real, parts->real_row, x);
  for (int i = 0; i < k; i++) {
    b[i] = c * x[i] - a[i];
    a[i] = x[i];
  }
}

lamc_real lamc_implicit_pass(const lamc_run *run, const implicit *parts, lamc_real c, const lamc_real *error,
                             lamc_real squared, lamc_real *room) {
  const lamc_real MOST = 10000; /* 100 tolerances, squared */
  if (!run->may_pass || squared <= 1 || !(squared <= MOST)) return squared;
  for (int i = 0; i < run->ode.n; i++) room[i] = c * error[i];
  lamc_implicit_solve(parts, c, room);
  const lamc_real left = weighed(run, room) / (lamc_real)run->ode.n;
  return left <= 1 ? left : squared;
}

/* ---- Complex shift: numbers are pairs, real part first ------------------------------------------------------- */

static lamc_real squared_size(const lamc_real *z) {
  return z[0] * z[0] + z[1] * z[1];
}

/* out -= f z */
static void take_off(lamc_real *out, const lamc_real *f, const lamc_real *z) {
  out[0] -= f[0] * z[0] - f[1] * z[1];
  out[1] -= f[0] * z[1] + f[1] * z[0];
}

/* z /= d */
static void divide(lamc_real *z, const lamc_real *d) {
  const lamc_real size = squared_size(d);
  const lamc_real re = (z[0] * d[0] + z[1] * d[1]) / size;
  z[1] = (z[1] * d[0] - z[0] * d[1]) / size;
  z[0] = re;
}

static void swap_pairs(lamc_real *a, lamc_real *b) {
  for (int i = 0; i < 2; i++) {
    const lamc_real keep = a[i];
    a[i] = b[i];
    b[i] = keep;
  }
}

static int factorise_pairs(int k, lamc_real *w, lamc_real *from) {
  for (int j = 0; j < k; j++) {
    int best = j;
    for (int i = j + 1; i < k; i++)
      if (squared_size(w + 2 * (i * k + j)) > squared_size(w + 2 * (best * k + j))) best = i;
    from[j] = (lamc_real)best;
    for (int i = 0; i < k && best != j; i++) swap_pairs(w + 2 * (j * k + i), w + 2 * (best * k + i));
    const lamc_real *pivot = w + 2 * (j * k + j);
    const lamc_real size = squared_size(pivot);
    if (size == 0 || !is_finite(size)) return 0;
    for (int i = j + 1; i < k; i++) {
      lamc_real *factor = w + 2 * (i * k + j);
      divide(factor, pivot);
      for (int m = j + 1; m < k; m++) take_off(w + 2 * (i * k + m), factor, w + 2 * (j * k + m));
    }
  }
  return 1;
}

static void solve_pairs(int k, const lamc_real *w, const lamc_real *from, lamc_real *x) {
  for (int j = 0; j < k; j++) swap_pairs(x + 2 * j, x + 2 * (int)from[j]);
  for (int i = 0; i < k; i++)
    for (int j = 0; j < i; j++) take_off(x + 2 * i, w + 2 * (i * k + j), x + 2 * j);
  for (int i = k - 1; i >= 0; i--) {
    for (int j = i + 1; j < k; j++) take_off(x + 2 * i, w + 2 * (i * k + j), x + 2 * j);
    divide(x + 2 * i, w + 2 * (i * k + i));
  }
}

int lamc_implicit_factorise_pair(lamc_run *run, const implicit *parts, const lamc_real *c) {
  const int k = parts->k;
  lamc_real *w = parts->pair;
  run->factorisations++;
  if (parts->has_structure) {
    for (int i = 0; i < k * k; i++) {
      w[2 * i] = -c[0] * parts->by_u[i] - parts->by_q[i];
      w[2 * i + 1] = -c[1] * parts->by_u[i];
    }
    for (int i = 0; i < k; i++) {
      w[2 * (i * k + i)] += c[0] * c[0] - c[1] * c[1];
      w[2 * (i * k + i) + 1] += 2 * c[0] * c[1];
    }
  } else {
    for (int i = 0; i < k * k; i++) {
      w[2 * i] = -parts->by_q[i];
      w[2 * i + 1] = 0;
    }
    for (int i = 0; i < k; i++) {
      w[2 * (i * k + i)] += c[0];
      w[2 * (i * k + i) + 1] += c[1];
    }
  }
  return factorise_pairs(k, w, parts->pair_row);
}

void lamc_implicit_solve_pair(const implicit *parts, const lamc_real *c, lamc_real *re, lamc_real *im) {
  const int k = parts->k;
  lamc_real *x = parts->buffer;
  for (int i = 0; i < k; i++) {
    x[2 * i] = parts->has_structure ? re[k + i] + c[0] * re[i] - c[1] * im[i] : re[i];
    x[2 * i + 1] = parts->has_structure ? im[k + i] + c[0] * im[i] + c[1] * re[i] : im[i];
    for (int j = 0; j < k && parts->has_structure; j++) {
      x[2 * i] -= parts->by_u[i * k + j] * re[j];
      x[2 * i + 1] -= parts->by_u[i * k + j] * im[j];
    }
  }
  solve_pairs(k, parts->pair, parts->pair_row, x);
  for (int i = 0; i < k; i++) {
    const lamc_real *z = x + 2 * i;
    if (parts->has_structure) {
      re[k + i] = c[0] * z[0] - c[1] * z[1] - re[i];
      im[k + i] = c[0] * z[1] + c[1] * z[0] - im[i];
    }
    re[i] = z[0];
    im[i] = z[1];
  }
}
