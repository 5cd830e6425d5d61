/* integrals.c, of lamc: integrals along a run, by a quadrature over each accepted step.
 *
 * In: an accepted step with its continuous extension, and integrands of its states. Out: integrals at its end and within.
 * Never: sways the run: steps, methods and states are the same bit by bit with integrals and without.
 *
 * Carried along as components of y they would have to be left out of the error norm, of the Jacobian and of the choice of
 * method, and an implicit method would still need their derivatives. The continuous extension of order p errs by h^(p+1)
 * in the state, hence by h^(p+2) in the integral over a step: no more than a step of the method itself, of order p + 1,
 * does. p nodes make integrals within the step as accurate as states there. Radau IIA takes its own stages, which are two
 * orders better than its polynomial in between.
 *
 * Within a step the integrand is known by its Legendre coefficients c_i = (2 i + 1) sum_j w_j f(x_j) P_i(x_j), since all of
 * these rules integrate the products exactly, and the integral of P_i over -1 .. x is (P_(i+1) - P_(i-1)) / (2 i + 1). */
#include "integrals.h"

#include "watch.h"

enum { MOST_NODES = 7 };

static const lamc_real NODE_4[] = {0.06943184420297371, 0.33000947820757187, 0.6699905217924281,
                                   0.9305681557970263};
static const lamc_real WEIGHT_4[] = {0.17392742256872692, 0.32607257743127305, 0.32607257743127305,
                                     0.17392742256872692};
static const lamc_real NODE_7[] = {0.025446043828620736, 0.12923440720030278, 0.2970774243113014, 0.5,
                                   0.7029225756886985,   0.8707655927996972,  0.9745539561713793};
static const lamc_real WEIGHT_7[] = {0.06474248308443485, 0.13985269574463832, 0.19091502525255946,
                                     0.2089795918367347,  0.19091502525255946, 0.13985269574463832,
                                     0.06474248308443485};
const rule lamc_gauss_4 = {4, NODE_4, WEIGHT_4};
const rule lamc_gauss_7 = {7, NODE_7, WEIGHT_7};

/* The parts of a run's room for integrals; k of them */
typedef struct room {
  int k;
  lamc_real *here;         /* (k,): where the run stands */
  lamc_real *there;        /* (k,): where the last step began */
  lamc_real *coefficients; /* (MOST_NODES, k), of Legendre's polynomials over the last step */
  lamc_real *values;       /* (k,) */
  lamc_real *y;            /* (n,): within a step, or before an event */
} room;

long long lamc_integrals_size(const lamc_ode *ode) {
  return ode->integral_count > 0 ? (3LL + MOST_NODES) * ode->integral_count + ode->n : 0;
}

static room room_of(const lamc_run *run) {
  room r;
  r.k = run->ode.integral_count;
  r.here = run->integrals;
  r.there = r.here + r.k;
  r.coefficients = r.there + r.k;
  r.values = r.coefficients + (ptrdiff_t)MOST_NODES * r.k;
  r.y = r.values + r.k;
  return r;
}

void lamc_integrals_start(lamc_run *run, lamc_real *memory) {
  run->integrals = memory;
}

/* Legendre's polynomials P_0 .. P_count at x */
static void legendre(int count, lamc_real x, lamc_real *p) {
  p[0] = 1.0;
  p[1] = x;
  for (int i = 1; i < count; i++) p[i + 1] = ((2 * i + 1) * x * p[i] - i * p[i - 1]) / (i + 1);
}

void lamc_integrals_step(lamc_run *run) {
  if (run->ode.integral_count == 0 || run->dense == LAMC_DENSE_NONE) return;
  const room r = room_of(run);
  const rule *q = lamc_method_of(run->method)->quadrature;
  const int dense = run->dense;
  const long long before = run->evaluations;
  const lamc_real work = lamc_watch_work(run);
  lamc_real p[MOST_NODES + 1];
  memset(r.coefficients, 0, (size_t)(MOST_NODES * r.k) * sizeof *r.coefficients);
  for (int j = 0; j < q->count; j++) {
    const lamc_real t = smaller(run->t_old + q->node[j] * run->h_last, run->t);
    (void)lamc_run_interpolate(run, t, r.y);
    run->ode.integrands(run->ode.context, t, r.y, r.values);
    run->evaluations++;
    legendre(q->count, 2.0 * q->node[j] - 1.0, p);
    for (int i = 0; i < q->count; i++) {
      const lamc_real weight = (2 * i + 1) * q->weight[j] * p[i];
      for (int m = 0; m < r.k; m++) r.coefficients[i * r.k + m] += weight * r.values[m];
    }
  }
  memcpy(r.there, r.here, (size_t)r.k * sizeof *r.there);
  for (int m = 0; m < r.k; m++) r.here[m] += run->h_last * r.coefficients[m];
  run->watch.mark_cost += (lamc_real)(run->evaluations - before); /* they must not sway LAMC_AUTO */
  lamc_watch_forget(run, work);
  if (run->ode.doubts != NULL) run->dense = dense; /* rows ask whether making it met doubts */
}

void lamc_integrals_before(lamc_run *run) {
  const room r = room_of(run);
  if (r.k > 0) memcpy(r.y, y_here(run), (size_t)run->ode.n * sizeof *r.y);
}

void lamc_integrals_after(lamc_run *run) {
  const room r = room_of(run);
  if (r.k > 0 && run->ode.jump != NULL) run->ode.jump(run->ode.context, run->t, r.y, y_here(run), r.here);
}

void lamc_integrals_at(const lamc_run *run, lamc_real t, lamc_real *integrals) {
  const room r = room_of(run);
  if (t == run->t) {
    memcpy(integrals, r.here, (size_t)r.k * sizeof *integrals);
    return;
  }
  const lamc_real x = 2.0 * (t - run->t_old) / run->h_last - 1.0;
  lamc_real p[MOST_NODES + 1];
  legendre(MOST_NODES, x, p);
  for (int m = 0; m < r.k; m++) {
    lamc_real sum = (x + 1.0) * r.coefficients[m];
    for (int i = 1; i < MOST_NODES; i++)
      sum += (p[i + 1] - p[i - 1]) / (2 * i + 1) * r.coefficients[i * r.k + m];
    integrals[m] = r.there[m] + 0.5 * run->h_last * sum;
  }
}
