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

static const lamc_real GAMMA = LAMC_R(0.21193756319429014);
static const lamc_real A[6][5] = {
    {0},
    {3},
    {LAMC_R(2.849394379747939), LAMC_R(0.45842242204463923)},
    {-LAMC_R(6.954028509809101), LAMC_R(2.489845061869568), -LAMC_R(10.358996098473584)},
    {LAMC_R(2.8029986275628964), LAMC_R(0.5072464736228206), -LAMC_R(0.3988312541770524),
     -LAMC_R(0.04721187230404641)},
    {-LAMC_R(7.502846399306121), LAMC_R(2.561846144803919), -LAMC_R(11.627539656261098),
     -LAMC_R(0.18268767659942256), LAMC_R(0.030198172008377946)},
};
static const lamc_real C[STAGES][STAGES - 1] = {
    {0},
    {-LAMC_R(14.155112264123755)},
    {-LAMC_R(17.97296035885952), -LAMC_R(2.859693295451294)},
    {LAMC_R(147.12150275711716), -LAMC_R(1.41221402718213), LAMC_R(71.68940251302358)},
    {LAMC_R(165.43517024871676), -LAMC_R(0.4592823456491126), LAMC_R(42.90938336958603),
     -LAMC_R(5.961986721573306)},
    {LAMC_R(24.854864614690072), -LAMC_R(3.0009227002832186), LAMC_R(47.4931110020768),
     LAMC_R(5.5814197821558125), -LAMC_R(0.6610691825249471)},
    {LAMC_R(30.91273214028599), -LAMC_R(3.1208243349937974), LAMC_R(77.79954646070892),
     LAMC_R(34.28646028294783), -LAMC_R(19.097331116725623), -LAMC_R(28.087943162872662)},
    {LAMC_R(37.80277123390563), -LAMC_R(3.2571969029072276), LAMC_R(112.26918849496327),
     LAMC_R(66.9347231244047), -LAMC_R(40.06618937091002), -LAMC_R(54.66780262877968),
     -LAMC_R(9.48861652309627)},
};
static const lamc_real NODE[STAGES] = {0,
                                       LAMC_R(0.6358126895828704),
                                       LAMC_R(0.4095798393397535),
                                       LAMC_R(0.9769306725060716),
                                       LAMC_R(0.4288403609558664),
                                       1,
                                       1,
                                       1};
static const lamc_real SHIFT[STAGES] = {LAMC_R(0.21193756319429014),
                                        -LAMC_R(0.42387512638858027),
                                        -LAMC_R(0.3384627126235924),
                                        LAMC_R(1.8046452872882734),
                                        LAMC_R(2.325825639765069),
                                        0,
                                        0,
                                        0};
/* of the continuous extension */
static const lamc_real H[3][STAGES] = {
    {LAMC_R(25.948786856663858), -LAMC_R(2.5579724845846235), LAMC_R(10.433815404888879),
     -LAMC_R(2.3679251022685204), LAMC_R(0.524948541321073), LAMC_R(1.1241088310450404),
     LAMC_R(0.4272876194431874), -LAMC_R(0.17202221070155493)},
    {-LAMC_R(9.91568850695171), -LAMC_R(0.9689944594115154), LAMC_R(3.0438037242978453),
     -LAMC_R(24.495224566215796), LAMC_R(20.176138334709044), LAMC_R(15.98066361424651),
     -LAMC_R(6.789040303419874), -LAMC_R(6.710236069923372)},
    {LAMC_R(11.419903575922262), LAMC_R(2.8879645146136994), LAMC_R(72.92137995996029),
     LAMC_R(80.12511834622643), -LAMC_R(52.072871366152654), -LAMC_R(59.78993625266729),
     -LAMC_R(0.15582684282751913), LAMC_R(4.883087185713722)},
};

/* out = sum over the first `count` stages of weight * k */
static void combine(const lamc_run *run, const lamc_real *weights, int count, lamc_real *LAMC_RESTRICT out) {
  memset(out, 0, (size_t)run->stride * sizeof *out);
  for (int j = 0; j < count; j++) {
    const lamc_real *LAMC_RESTRICT k = slot(run, SLOT_K + j);
    for (int i = 0; i < run->ode.n; i++) out[i] += weights[j] * k[i];
  }
}

static lamc_real attempt(lamc_run *run, lamc_real h) {
  const int n = run->ode.n;
  const implicit parts = lamc_implicit_parts(run, OWN_SLOTS);
  const lamc_real shift = 1 / (h * GAMMA);
  const lamc_real *y = y_here(run);
  lamc_real *y_new = y_there(run), *slope = slot(run, SLOT_STAGE), *sum = slot(run, SLOT_SUM);
  lamc_implicit_jacobian(run, &parts);
  if (!lamc_implicit_factorise(run, &parts, shift)) return HUGE_VAL;
  for (int s = 0; s < STAGES; s++) {
    lamc_real *k = slot(run, SLOT_K + s);
    if (s >= 6) {
      const lamc_real *last = slot(run, SLOT_K + s - 1);
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
  const lamc_real *error = slot(run, SLOT_K + STAGES - 1);
  for (int i = 0; i < n; i++) y_new[i] += error[i];
  if (!all_finite(run, y_new)) return HUGE_VAL;
  if (n == 0) return 0;
  return lamc_implicit_pass(run, &parts, shift, error, weighed(run, error) / (lamc_real)n, sum);
}

static void make_dense(lamc_run *run) {
  for (int row = 0; row < 3; row++) combine(run, H[row], STAGES, slot(run, SLOT_DENSE + row));
  memcpy(slot(run, SLOT_SUM), y_here(run),
         (size_t)run->ode.n * sizeof(lamc_real)); /* an event may change it */
}

static void interpolate(const lamc_run *run, lamc_real a, lamc_real *y) {
  const lamc_real *old = y_there(run), *now = slot(run, SLOT_SUM);
  const lamc_real *d1 = slot(run, SLOT_DENSE), *d2 = slot(run, SLOT_DENSE + 1),
                  *d3 = slot(run, SLOT_DENSE + 2);
  const lamc_real b = 1 - a;
  for (int i = 0; i < run->ode.n; i++)
    y[i] = b * old[i] + a * (now[i] + b * (d1[i] + a * (d2[i] + a * d3[i])));
}

const method lamc_method_rodas5p = {
    OWN_SLOTS, STAGES,        LAMC_R(0.2),        0,       6,          0,           0,
    0,         &lamc_gauss_4, lamc_implicit_size, attempt, make_dense, interpolate, NULL,
};
