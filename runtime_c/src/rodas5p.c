/* rodas5p.c, of lamc: the Rosenbrock method Rodas5P, order 5 with an error estimate of order 4, stiffly accurate.
 *
 * In: a lamc_run with y and dy/dt at t, and the Jacobian of its equation. Out: the new state, the error norm, the dense
 * output of order 4. Never: iterates.
 *
 * Stage i: (I / (h gamma) - J) k_i = f(t + c_i h, y + sum a_ij k_j) + sum C_ij k_j / h + h d_i df/dt. Stages 6 to 8 lie at
 * the end of the step, and each is the one before with its k added.
 *
 * Coefficients: G. Steinebach, BIT Numerical Mathematics 63 (2023) 27, in the form without matrix products of E. Hairer,
 * G. Wanner, Solving Ordinary Differential Equations II, 2nd ed. (1996), section IV.7. */
#include "implicit.h"

enum {
  STAGES = 8,
  SLOT_K = SLOT_OWN,            /* the stages */
  SLOT_DENSE = SLOT_K + STAGES, /* three vectors of the continuous extension */
  SLOT_SUM = SLOT_DENSE + 3,
  OWN_SLOTS = STAGES + 4
};

static const double GAMMA = 0.21193756319429014;
static const double A[6][5] = {
    {0.0},
    {3.0},
    {2.849394379747939, 0.45842242204463923},
    {-6.954028509809101, 2.489845061869568, -10.358996098473584},
    {2.8029986275628964, 0.5072464736228206, -0.3988312541770524, -0.04721187230404641},
    {-7.502846399306121, 2.561846144803919, -11.627539656261098, -0.18268767659942256, 0.030198172008377946},
};
static const double C[STAGES][STAGES - 1] = {
    {0.0},
    {-14.155112264123755},
    {-17.97296035885952, -2.859693295451294},
    {147.12150275711716, -1.41221402718213, 71.68940251302358},
    {165.43517024871676, -0.4592823456491126, 42.90938336958603, -5.961986721573306},
    {24.854864614690072, -3.0009227002832186, 47.4931110020768, 5.5814197821558125, -0.6610691825249471},
    {30.91273214028599, -3.1208243349937974, 77.79954646070892, 34.28646028294783, -19.097331116725623,
     -28.087943162872662},
    {37.80277123390563, -3.2571969029072276, 112.26918849496327, 66.9347231244047, -40.06618937091002,
     -54.66780262877968, -9.48861652309627},
};
static const double NODE[STAGES] = {
    0.0, 0.6358126895828704, 0.4095798393397535, 0.9769306725060716, 0.4288403609558664, 1.0, 1.0, 1.0};
static const double SHIFT[STAGES] = {0.21193756319429014,
                                     -0.42387512638858027,
                                     -0.3384627126235924,
                                     1.8046452872882734,
                                     2.325825639765069,
                                     0.0,
                                     0.0,
                                     0.0};
/* of the continuous extension */
static const double H[3][STAGES] = {
    {25.948786856663858, -2.5579724845846235, 10.433815404888879, -2.3679251022685204, 0.524948541321073,
     1.1241088310450404, 0.4272876194431874, -0.17202221070155493},
    {-9.91568850695171, -0.9689944594115154, 3.0438037242978453, -24.495224566215796, 20.176138334709044,
     15.98066361424651, -6.789040303419874, -6.710236069923372},
    {11.419903575922262, 2.8879645146136994, 72.92137995996029, 80.12511834622643, -52.072871366152654,
     -59.78993625266729, -0.15582684282751913, 4.883087185713722},
};

/* out = sum over the first `count` stages of weight * k */
static void combine(const lamc_run *run, const double *weights, int count, double *LAMC_RESTRICT out) {
  memset(out, 0, (size_t)run->stride * sizeof *out);
  for (int j = 0; j < count; j++) {
    const double *LAMC_RESTRICT k = slot(run, SLOT_K + j);
    for (int i = 0; i < run->ode.n; i++) out[i] += weights[j] * k[i];
  }
}

static double attempt(lamc_run *run, double h) {
  const int n = run->ode.n;
  const implicit parts = lamc_implicit_parts(run, OWN_SLOTS);
  const double shift = 1.0 / (h * GAMMA);
  const double *y = y_here(run);
  double *y_new = y_there(run), *slope = slot(run, SLOT_STAGE), *sum = slot(run, SLOT_SUM);
  lamc_implicit_jacobian(run, &parts);
  if (!lamc_implicit_factorise(run, &parts, shift)) return HUGE_VAL;
  for (int s = 0; s < STAGES; s++) {
    double *k = slot(run, SLOT_K + s);
    if (s >= 6) {
      const double *last = slot(run, SLOT_K + s - 1);
      for (int i = 0; i < n; i++) y_new[i] += last[i];
    } else {
      combine(run, A[s], s < 5 ? s : 5, sum);
      for (int i = 0; i < n; i++) y_new[i] = y[i] + sum[i];
    }
    if (s == 0) {
      memcpy(slope, slope_here(run), (size_t)n * sizeof *slope);
    } else {
      evaluate(run, run->t + NODE[s] * h, y_new, slope);
    }
    combine(run, C[s], s, sum);
    for (int i = 0; i < n; i++) k[i] = slope[i] + sum[i] / h;
    for (int i = 0; i < parts.k; i++) k[parts.late + i] += h * SHIFT[s] * parts.by_t[i];
    lamc_implicit_solve(&parts, shift, k);
  }
  const double *error = slot(run, SLOT_K + STAGES - 1);
  for (int i = 0; i < n; i++) y_new[i] += error[i];
  if (!all_finite(run, y_new)) return HUGE_VAL;
  if (n == 0) return 0.0;
  return lamc_implicit_pass(run, &parts, shift, error, weighed(run, error) / (double)n, sum);
}

static void make_dense(lamc_run *run) {
  for (int row = 0; row < 3; row++) combine(run, H[row], STAGES, slot(run, SLOT_DENSE + row));
  memcpy(slot(run, SLOT_SUM), y_here(run), (size_t)run->ode.n * sizeof(double)); /* an event may change it */
}

static void interpolate(const lamc_run *run, double a, double *y) {
  const double *old = y_there(run), *now = slot(run, SLOT_SUM);
  const double *d1 = slot(run, SLOT_DENSE), *d2 = slot(run, SLOT_DENSE + 1), *d3 = slot(run, SLOT_DENSE + 2);
  const double b = 1.0 - a;
  for (int i = 0; i < run->ode.n; i++)
    y[i] = b * old[i] + a * (now[i] + b * (d1[i] + a * (d2[i] + a * d3[i])));
}

const method lamc_method_rodas5p = {
    OWN_SLOTS,          STAGES,  0.2,        0.0,         6.0,  0, 0, 0.0, &lamc_gauss_4,
    lamc_implicit_size, attempt, make_dense, interpolate, NULL,
};
