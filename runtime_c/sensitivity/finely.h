/* finely.h, of lamc: derivatives over a step on steps of their own, where the run's step is too long for them.
 *
 * Behind an event forces may begin with a power of time, as those of a contact do: the state is as exact as it is asked for,
 * and its derivatives, which have one power less, are not. There y and S go on together by DOP853 from where the step began,
 * with the error of S kept small as well; the run itself sees nothing of it. */
#ifndef LAMC_FINELY_H
#define LAMC_FINELY_H

#include "replay.h"

enum { FINE_STAGES = 12, FINE_TRIES = 20000, FINE_MISSED = 200 };

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

/* Room for such steps: slopes of y at the stages, y, the next one, y where the run's step began, slopes of S, S, the next one */
typedef struct lamc_fine_room {
  lamc_real *k, *y, *y_new, *y_begin, *slopes, *sens, *sens_new;
} lamc_fine_room;

static inline lamc_fine_room lamc_fine_room_of(const lamc_sensitivity *s) {
  const int row = padded(s->run.ode.n);
  const ptrdiff_t size = (ptrdiff_t)s->run.ode.n * s->width;
  lamc_fine_room f;
  f.k = s->room.fine;
  f.y = f.k + (ptrdiff_t)FINE_STAGES * row;
  f.y_new = f.y + row;
  f.y_begin = f.y_new + row;
  f.slopes = f.y_begin + row;
  f.sens = f.slopes + FINE_STAGES * size;
  f.sens_new = f.sens + size;
  return f;
}

/* y and S stand where the last step of the run began */
static inline void lamc_begin_finely(lamc_sensitivity *s, const lamc_fine_room *f) {
  memcpy(f->y, f->y_begin, (size_t)s->run.ode.n * sizeof *f->y);
  memcpy(f->sens, s->start, (size_t)s->run.ode.n * (size_t)s->width * sizeof *f->sens);
  s->fine_t = s->run.t_old;
  s->fine_h = LAMC_R(0.1) * s->h_fine_run;
}

/* y and S go on by steps of their own to `until`; 0: they take too many. rows: (n, width) of scratch */
static inline int lamc_go_finely(lamc_sensitivity *s, const lamc_fine_room *f, lamc_real until,
                                 lamc_real *rows) {
  const int n = s->run.ode.n;
  const lamc_real over_all = LAMC_S_PER_RTOL * s->run.options.rtol, shortest = LAMC_R(1e-9) * s->h_fine_run;
  for (int i = 0, missed = 0; i < FINE_TRIES; i++) {
    const int is_last = LAMC_R(1.01) * s->fine_h >= until - s->fine_t;
    const lamc_real h = is_last ? until - s->fine_t : s->fine_h;
    const lamc_real enough = over_all * larger(h / s->h_fine_run, LAMC_R(1e-3)); /* they add up */
    const lamc_real error =
        lamc_fine_step(s, s->fine_t, h, f->y, f->sens, f->y_new, f->sens_new, f->k, f->slopes);
    const lamc_real factor = LAMC_R(0.9) * pow(larger(error, LAMC_R(1e-3) * enough) / enough, LAMC_R(-0.2));
    if (!(error <= enough) && h > shortest && missed < FINE_MISSED) {
      s->fine_h = h * larger(factor, LAMC_R(0.1));
      missed++;
      continue;
    }
    lamc_real moved = 0;
    s->fine_t = is_last ? until : s->fine_t + h;
    memcpy(f->y, f->y_new, (size_t)n * sizeof *f->y);
    memcpy(f->sens, f->sens_new, (size_t)n * (size_t)s->width * sizeof *f->sens);
    if (s->beside.baumgarte == 0) (void)lamc_motion_settle(&s->beside, s->fine_t, f->y, &moved);
    lamc_vary_settle(s, s->fine_t, f->y, f->sens, rows);
    s->fine_h = is_last ? larger(s->fine_h, h * factor) : h * factor;
    if (is_last) return 1;
  }
  return 0;
}

/* S over the last step of the run, into `end`, by steps of its own; 0: they are too many. rows: (n, width) of scratch */
static inline int lamc_follow_finely(lamc_sensitivity *s, lamc_real *rows) {
  const lamc_run *run = &s->run;
  const lamc_fine_room f = lamc_fine_room_of(s);
  const size_t bytes = (size_t)run->ode.n * (size_t)s->width * sizeof *f.sens;
  memcpy(f.y_begin, y_there(run), (size_t)run->ode.n * sizeof *f.y_begin);
  s->h_fine_run = run->h_last;
  memcpy(s->over_step, s->beside.constants, (size_t)s->motion.model->constant_count * sizeof *s->over_step);
  memcpy(s->held_over_step, s->held,
         2 * (size_t)s->motion.model->held_count * (size_t)s->held_width * sizeof *s->held);
  lamc_begin_finely(s, &f);
  if (!lamc_go_finely(s, &f, run->t, rows)) return 0;
  memcpy(s->end, f.sens, bytes);
  lamc_begin_finely(s, &f); /* for the rows within, as they come */
  return 1;
}

/* What an event, a clock or a break at the end of a step has changed, and what was so over it, change places */
static inline void lamc_swap_over_step(lamc_sensitivity *s) {
  lamc_real *const pairs[2][2] = {{s->over_step, s->beside.constants}, {s->held_over_step, s->held}};
  const ptrdiff_t counts[2] = {s->motion.model->constant_count,
                               2 * (ptrdiff_t)s->motion.model->held_count * s->held_width};
  for (int k = 0; k < 2; k++) {
    for (ptrdiff_t i = 0; i < counts[k]; i++) {
      const lamc_real there = pairs[k][0][i];
      pairs[k][0][i] = pairs[k][1][i];
      pairs[k][1][i] = there;
    }
  }
  s->has_new_constants = 1;
}

/* S (n, width) within that step, at t, which is behind those that were asked for before; 0: it takes too many steps */
static inline int lamc_finely_at(lamc_sensitivity *s, lamc_real t, lamc_real *rows, lamc_real *out) {
  const lamc_fine_room f = lamc_fine_room_of(s);
  if (t < s->fine_t) return 0;
  lamc_swap_over_step(s);
  const int is_there = t == s->fine_t || lamc_go_finely(s, &f, t, rows);
  lamc_swap_over_step(s);
  if (is_there) memcpy(out, f.sens, (size_t)s->run.ode.n * (size_t)s->width * sizeof *out);
  return is_there;
}

#endif /* LAMC_FINELY_H */
