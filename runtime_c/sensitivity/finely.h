/* finely.h, of lamc: derivatives over a step on steps of their own, where the run's step is too long for them.
 *
 * Behind an event forces may begin with a power of time, as those of a contact do: the state is as exact as it is asked for,
 * and its derivatives, which have one power less, are not. There y and S go on together by DOP853 from where the step began,
 * with the error of S kept small as well; the run itself sees nothing of it. */
#ifndef LAMC_FINELY_H
#define LAMC_FINELY_H

#include "replay.h"

enum { FINE_STAGES = 12, FINE_TRIES = 400 };

/* Of an error of S in a step, over the size of its column, what the tolerance of the run allows */
static const lamc_real LAMC_S_PER_RTOL = 1e3;

static inline long long lamc_fine_size(int n, int width) {
  return (FINE_STAGES + 3LL) * padded(n) + (FINE_STAGES + 2LL) * n * width;
}

/* The error norm of DOP853 (see dop853.c) over the size of S, for the worst column. slopes (stages, n, width), of which
 * `count` are weighed */
static inline lamc_real lamc_s_error(int n, int width, lamc_real h, const lamc_real *slopes, int count,
                                     const lamc_real *fifth, const lamc_real *third, const lamc_real *sens) {
  const ptrdiff_t size = (ptrdiff_t)n * width;
  lamc_real worst = 0;
  for (int b = 0; b < width; b += PACK) {
    lamc_real five[PACK] = {0}, three[PACK] = {0}, most[PACK] = {0};
    for (int i = 0; i < n; i++) {
      const ptrdiff_t at = (ptrdiff_t)i * width + b;
      lamc_real a[PACK] = {0}, d[PACK] = {0};
      lamc_pack of_a = lamc_pack_at(a), of_d = of_a;
      for (int k = 0; k < count; k++) {
        const lamc_pack slope = lamc_pack_at(slopes + (ptrdiff_t)k * size + at);
        of_a = lamc_pack_add(of_a, fifth[k], slope);
        if (third != NULL) of_d = lamc_pack_add(of_d, third[k], slope);
      }
      lamc_pack_put(a, of_a);
      lamc_pack_put(d, of_d);
      for (int c = 0; c < PACK; c++) {
        five[c] = larger(five[c], fabs(h * a[c]));
        three[c] = larger(three[c], fabs(h * d[c]));
        most[c] = larger(most[c], fabs(sens[at + c]));
      }
    }
    for (int c = 0; c < PACK; c++) {
      const lamc_real both = sqrt(five[c] * five[c] + LAMC_R(0.01) * three[c] * three[c]);
      const lamc_real error = third == NULL ? five[c] : both > 0 ? five[c] * five[c] / both : 0;
      if (most[c] > 0) worst = larger(worst, error / most[c]);
    }
  }
  return worst;
}

/* 1 if that error is at most `enough` for sure, by norms that are quicker to have: |v| <= ||v|| <= sqrt(n) |v| of the largest
 * component |v| */
static inline int lamc_s_is_exact(int n, int width, lamc_real h, const lamc_real *slopes, int count,
                                  const lamc_real *fifth, const lamc_real *third, const lamc_real *sens,
                                  lamc_real enough) {
  const ptrdiff_t size = (ptrdiff_t)n * width;
  const lamc_real nothing[PACK] = {0};
  for (int b = 0; b < width; b += PACK) {
    lamc_real five[PACK], three[PACK], most[PACK];
    lamc_pack of_five = lamc_pack_at(nothing), of_three = of_five, of_sens = of_five;
    for (int i = 0; i < n; i++) {
      const lamc_real *at = slopes + (ptrdiff_t)i * width + b;
      lamc_pack a = lamc_pack_at(nothing), d = a;
      for (int k = 0; k < count; k++, at += size) {
        if (fifth[k] == 0) continue; /* those of the third order are zero there, too */
        const lamc_pack slope = lamc_pack_at(at);
        a = lamc_pack_add(a, fifth[k], slope);
        if (third != NULL) d = lamc_pack_add(d, third[k], slope);
      }
      of_five = lamc_pack_add_square(of_five, a);
      of_three = lamc_pack_add_square(of_three, d);
      of_sens = lamc_pack_add_square(of_sens, lamc_pack_at(sens + (ptrdiff_t)i * width + b));
    }
    lamc_pack_put(five, of_five);
    lamc_pack_put(three, of_three);
    lamc_pack_put(most, of_sens);
    for (int c = 0; c < PACK; c++) { /* squares all of them */
      const lamc_real smallest = LAMC_R(0.01) * three[c] / n, both = five[c] + smallest;
      const lamc_real error = h * h * (third == NULL || !(both > 0) ? five[c] : five[c] * five[c] / both);
      if (!(error * n <= enough * enough * most[c])) return 0;
    }
  }
  return 1;
}

/* One step of y and S together from (t, y, sens). Leaves the new ones, and returns the error of S. */
static inline lamc_real lamc_fine_step(lamc_sensitivity *s, lamc_real t, lamc_real h, const lamc_real *y,
                                       const lamc_real *sens, lamc_real *y_new, lamc_real *sens_new,
                                       lamc_real *k, lamc_real *slopes) {
  const int n = s->run.ode.n, nq = s->motion.model->coordinate_count, row = padded(n);
  const ptrdiff_t size = (ptrdiff_t)n * s->width;
  for (int stage = 0; stage <= FINE_STAGES; stage++) {
    memcpy(y_new, y, (size_t)n * sizeof *y);
    lamc_weighted_sum(size, sens, h, stage, DOP853_A[stage], slopes, sens_new);
    for (int j = 0; j < stage; j++)
      for (int i = 0; i < n; i++) y_new[i] += h * DOP853_A[stage][j] * k[(ptrdiff_t)j * row + i];
    if (stage == FINE_STAGES) break;
    lamc_real *slope = k + (ptrdiff_t)stage * row;
    const lamc_real at = t + DOP853_C[stage] * h;
    const lamc_place place = lamc_place_beside(s, at, y_new, NULL);
    lamc_motion_rates(&s->beside, y_new, y_new + nq, slope);
    memcpy(slope + nq, place.udot, (size_t)(n - nq) * sizeof *slope);
    lamc_vary(s, &place, sens_new, slopes + (ptrdiff_t)stage * size);
  }
  return lamc_s_error(n, s->width, h, slopes, FINE_STAGES, DOP853_E5, DOP853_E3, sens_new);
}

/* S over the last step of the run, into `end`, by steps of its own. room: lamc_fine_size; rows: (n, width) of scratch */
static inline void lamc_follow_finely(lamc_sensitivity *s, lamc_real *room, lamc_real *rows) {
  const lamc_run *run = &s->run;
  const int n = run->ode.n, row = padded(n);
  const ptrdiff_t size = (ptrdiff_t)n * s->width;
  lamc_real *k = room, *y = k + (ptrdiff_t)FINE_STAGES * row, *y_new = y + row;
  lamc_real *slopes = y_new + 2 * row, *sens = slopes + FINE_STAGES * size, *sens_new = sens + size;
  const lamc_real enough = LAMC_S_PER_RTOL * run->options.rtol, shortest = LAMC_R(1e-9) * run->h_last;
  lamc_real t = run->t_old, h = LAMC_R(0.1) * run->h_last;
  memcpy(y, y_there(run), (size_t)n * sizeof *y);
  memcpy(sens, s->start, (size_t)size * sizeof *sens);
  for (int i = 0; i < FINE_TRIES; i++) {
    const int is_last = LAMC_R(1.01) * h >= run->t - t;
    if (is_last) h = run->t - t;
    const lamc_real error = lamc_fine_step(s, t, h, y, sens, y_new, sens_new, k, slopes);
    const lamc_real factor = LAMC_R(0.9) * pow(larger(error, LAMC_R(1e-3) * enough) / enough, LAMC_R(-0.2));
    if (!(error <= enough) && h > shortest && i < FINE_TRIES / 2) {
      h *= larger(factor, LAMC_R(0.1));
      continue;
    }
    lamc_real moved = 0;
    t = is_last ? run->t : t + h;
    memcpy(y, y_new, (size_t)n * sizeof *y);
    memcpy(sens, sens_new, (size_t)size * sizeof *sens);
    if (s->beside.baumgarte == 0) (void)lamc_motion_settle(&s->beside, t, y, &moved);
    lamc_vary_settle(s, t, y, sens, rows);
    h *= factor;
    if (is_last) {
      memcpy(s->end, sens, (size_t)size * sizeof *sens);
      return;
    }
  } /* too many: S of the run's own step stays */
}

#endif /* LAMC_FINELY_H */
