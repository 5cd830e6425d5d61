/* dop853.c: the explicit Runge-Kutta method of Dormand and Prince of order 8, with error estimates of orders 5 and 3.
 *
 * In: a lamc_run with y and dy/dt at t. Out: the new state, the error norm, the dense output of order 7.
 * Never: decides anything; that is run.c.
 *
 * E. Hairer, S. P. Norsett, G. Wanner, Solving Ordinary Differential Equations I, 2nd ed. (1993), section II.10, with
 * the coefficients and the error norm of its code DOP853. */
#include "method.h"

enum {
  STAGES = 12,
  ALL_STAGES = 16,            /* the 13th is the slope at the new state; three more serve the dense output */
  SLOT_K = SLOT_OWN,          /* stages 2 to 12 */
  SLOT_K_EXTRA = SLOT_K + 11, /* stages 14 to 16 */
  SLOT_DENSE = SLOT_K_EXTRA + 3, /* seven vectors of the continuous extension */
  OWN_SLOTS = 11 + 3 + 7
};

/* c_i; stages 13 to 15 serve the dense output */
static const lamc_real C[16] = {0.0,
                                0.05260015195876773,
                                0.0789002279381516,
                                0.1183503419072274,
                                0.2816496580927726,
                                0.3333333333333333,
                                0.25,
                                0.3076923076923077,
                                0.6512820512820513,
                                0.6,
                                0.8571428571428571,
                                1.0,
                                1.0,
                                0.1,
                                0.2,
                                0.7777777777777778};

/* a_ij; row 13 holds the weights b_i of the new state */
static const lamc_real A[16][15] = {
    {0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0},
    {0.05260015195876773, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0},
    {0.0197250569845379, 0.0591751709536137, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0},
    {0.02958758547680685, 0.0, 0.08876275643042054, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0,
     0.0},
    {0.2413651341592667, 0.0, -0.8845494793282861, 0.924834003261792, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0,
     0.0, 0.0, 0.0},
    {0.037037037037037035, 0.0, 0.0, 0.17082860872947386, 0.12546768756682242, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0,
     0.0, 0.0, 0.0, 0.0},
    {0.037109375, 0.0, 0.0, 0.17025221101954405, 0.06021653898045596, -0.017578125, 0.0, 0.0, 0.0, 0.0, 0.0,
     0.0, 0.0, 0.0, 0.0},
    {0.03709200011850479, 0.0, 0.0, 0.17038392571223998, 0.10726203044637328, -0.015319437748624402,
     0.008273789163814023, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0},
    {0.6241109587160757, 0.0, 0.0, -3.3608926294469414, -0.868219346841726, 27.59209969944671,
     20.154067550477894, -43.48988418106996, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0},
    {0.47766253643826434, 0.0, 0.0, -2.4881146199716677, -0.590290826836843, 21.230051448181193,
     15.279233632882423, -33.28821096898486, -0.020331201708508627, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0},
    {-0.9371424300859873, 0.0, 0.0, 5.186372428844064, 1.0914373489967295, -8.149787010746927,
     -18.52006565999696, 22.739487099350505, 2.4936055526796523, -3.0467644718982196, 0.0, 0.0, 0.0, 0.0,
     0.0},
    {2.273310147516538, 0.0, 0.0, -10.53449546673725, -2.0008720582248625, -17.9589318631188,
     27.94888452941996, -2.8589982771350235, -8.87285693353063, 12.360567175794303, 0.6433927460157636, 0.0,
     0.0, 0.0, 0.0},
    {0.054293734116568765, 0.0, 0.0, 0.0, 0.0, 4.450312892752409, 1.8915178993145003, -5.801203960010585,
     0.3111643669578199, -0.1521609496625161, 0.20136540080403034, 0.04471061572777259, 0.0, 0.0, 0.0},
    {0.056167502283047954, 0.0, 0.0, 0.0, 0.0, 0.0, 0.25350021021662483, -0.2462390374708025,
     -0.12419142326381637, 0.15329179827876568, 0.00820105229563469, 0.007567897660545699, -0.008298, 0.0,
     0.0},
    {0.03183464816350214, 0.0, 0.0, 0.0, 0.0, 0.028300909672366776, 0.053541988307438566,
     -0.05492374857139099, 0.0, 0.0, -0.00010834732869724932, 0.0003825710908356584, -0.00034046500868740456,
     0.1413124436746325, 0.0},
    {-0.42889630158379194, 0.0, 0.0, 0.0, 0.0, -4.697621415361164, 7.683421196062599, 4.06898981839711,
     0.3567271874552811, 0.0, 0.0, 0.0, -0.0013990241651590145, 2.9475147891527724, -9.15095847217987}};

/* errors of order 3 and 5 */
static const lamc_real E3[12] = {-0.18980075407240762,
                                 0.0,
                                 0.0,
                                 0.0,
                                 0.0,
                                 4.450312892752409,
                                 1.8915178993145003,
                                 -5.801203960010585,
                                 -0.4226823213237919,
                                 -0.1521609496625161,
                                 0.20136540080403034,
                                 0.02265179219836082};
static const lamc_real E5[12] = {0.01312004499419488,
                                 0.0,
                                 0.0,
                                 0.0,
                                 0.0,
                                 -1.2251564463762044,
                                 -0.4957589496572502,
                                 1.6643771824549864,
                                 -0.35032884874997366,
                                 0.3341791187130175,
                                 0.08192320648511571,
                                 -0.022355307863886294};

/* d_ij of the continuous extension */
static const lamc_real D[4][16] = {
    {-8.428938276109013, 0.0, 0.0, 0.0, 0.0, 0.5667149535193777, -3.0689499459498917, 2.38466765651207,
     2.117034582445028, -0.871391583777973, 2.2404374302607883, 0.6315787787694688, -0.08899033645133331,
     18.148505520854727, -9.194632392478356, -4.436036387594894},
    {10.427508642579134, 0.0, 0.0, 0.0, 0.0, 242.28349177525817, 165.20045171727028, -374.5467547226902,
     -22.113666853125306, 7.733432668472264, -30.674084731089398, -9.332130526430229, 15.697238121770845,
     -31.139403219565178, -9.35292435884448, 35.81684148639408},
    {19.985053242002433, 0.0, 0.0, 0.0, 0.0, -387.0373087493518, -189.17813819516758, 527.8081592054236,
     -11.57390253995963, 6.8812326946963, -1.0006050966910838, 0.7777137798053443, -2.778205752353508,
     -60.19669523126412, 84.32040550667716, 11.99229113618279},
    {-25.69393346270375, 0.0, 0.0, 0.0, 0.0, -154.18974869023643, -231.5293791760455, 357.6391179106141,
     93.40532418362432, -37.45832313645163, 104.0996495089623, 29.8402934266605, -43.53345659001114,
     96.32455395918828, -39.17726167561544, -149.72683625798564}};

/* Stage k (from 0): the slopes at the two ends of a step are stages 0 and 12. `begin` and `end` are those. */
static const lamc_real *stage(const lamc_run *run, int k, const lamc_real *begin, const lamc_real *end) {
  if (k == 0) return begin;
  if (k == STAGES) return end;
  return slot(run, k < STAGES ? SLOT_K + k - 1 : SLOT_K_EXTRA + k - STAGES - 1);
}

/* out = sum over the first `count` stages of weight * stage */
static void combine(const lamc_run *run, const lamc_real *weights, int count, const lamc_real *begin,
                    const lamc_real *end, lamc_real *LAMC_RESTRICT out) {
  const int m = run->stride;
  memset(out, 0, (size_t)m * sizeof *out);
  for (int k = 0; k < count; k++) {
    const lamc_real w = weights[k];
    if (w == 0.0) continue;
    const lamc_real *LAMC_RESTRICT v = stage(run, k, begin, end);
    for (int b = 0; b < m; b += LANES)
      for (int i = b; i < b + LANES; i++) out[i] += w * v[i];
  }
}

/* The argument of stage `row` */
static void argument(const lamc_run *run, int row, lamc_real h, const lamc_real *y, const lamc_real *begin,
                     const lamc_real *end, lamc_real *LAMC_RESTRICT out) {
  const int m = run->stride;
  combine(run, A[row], row, begin, end, out);
  for (int b = 0; b < m; b += LANES)
    for (int i = b; i < b + LANES; i++) out[i] = y[i] + h * out[i];
}

static lamc_real attempt(lamc_run *run, lamc_real h) {
  const lamc_real *y = y_here(run), *begin = slope_here(run);
  lamc_real *y_new = y_there(run), *s = slot(run, SLOT_STAGE), *error = slot(run, SLOT_DENSE);
  for (int k = 1; k < STAGES; k++) {
    argument(run, k, h, y, begin, begin, s);
    evaluate(run, run->t + C[k] * h, s, slot(run, SLOT_K + k - 1));
  }
  argument(run, STAGES, h, y, begin, begin, y_new);
  if (!all_finite(run, y_new)) return HUGE_VAL;
  combine(run, E5, STAGES, begin, begin, error);
  const lamc_real fifth = weighed(run, error);
  combine(run, E3, STAGES, begin, begin, error);
  const lamc_real third = weighed(run, error);
  const lamc_real both = fifth + 0.01 * third;
  return both > 0.0 ? h * h * fifth * fifth / (both * run->ode.n) : 0.0;
}

static void make_dense(lamc_run *run) {
  const int n = run->ode.n;
  const lamc_real h = run->h_last;
  const lamc_real *y = y_there(run), *y_new = y_here(run), *begin = slope_there(run), *end = slope_here(run);
  lamc_real *s = slot(run, SLOT_DENSE); /* not SLOT_STAGE, of which eigenvalue() asks later */
  for (int k = STAGES + 1; k < ALL_STAGES; k++) {
    argument(run, k, h, y, begin, end, s);
    evaluate(run, run->t_old + C[k] * h, s, slot(run, SLOT_K_EXTRA + k - STAGES - 1));
  }
  lamc_real *f0 = slot(run, SLOT_DENSE), *f1 = slot(run, SLOT_DENSE + 1), *f2 = slot(run, SLOT_DENSE + 2);
  for (int k = 0; k < 4; k++) combine(run, D[k], ALL_STAGES, begin, end, slot(run, SLOT_DENSE + 3 + k));
  for (int i = 0; i < n; i++) {
    const lamc_real change = y_new[i] - y[i];
    f0[i] = change;
    f1[i] = h * begin[i] - change;
    f2[i] = 2.0 * change - h * (end[i] + begin[i]);
  }
}

static void interpolate(const lamc_run *run, lamc_real a, lamc_real *y) {
  const lamc_real *start = y_there(run);
  const lamc_real b = 1.0 - a;
  for (int i = 0; i < run->ode.n; i++) {
    lamc_real sum = 0.0;
    for (int k = 6; k >= 0; k--) {
      const lamc_real weight = k >= 3 ? run->h_last : 1.0;
      sum = (sum + weight * slot(run, SLOT_DENSE + k)[i]) * (k % 2 == 0 ? a : b);
    }
    y[i] = start[i] + sum;
  }
}

static lamc_real eigenvalue(const lamc_run *run) {
  return steepness(run, slope_here(run), slot(run, SLOT_K + STAGES - 2), y_here(run), slot(run, SLOT_STAGE));
}

/* PI control with 0.05 of the last error: a third of the refusals that the code DOP853 without it has, for the same work
 * (measured: four-bar, five-bar, origami) */
const method lamc_method_dop853 = {
    OWN_SLOTS,     12,   0.1,     0.05,       6.0,         0,          0, 3.0,
    &lamc_gauss_7, NULL, attempt, make_dense, interpolate, eigenvalue,
};
