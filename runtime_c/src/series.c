/* series.c, of lamc: inputs that follow tables over time.
 *
 * In: a lamc_recording and the time. Out: values and derivatives of the inputs, in the first constants of the motion.
 * Never: remembers where it looked before: what a time gives does not depend on the times asked for earlier.
 *
 * A step that ends at a break sees the table as it is before the break, to the break itself; the step after it sees what
 * follows. So each step meets one polynomial of each input that jumps there, and methods keep their order. */
#include "series.h"

#include "motion.h"
#include "tolerances.h"

#include <stddef.h>

/* Of the table: the end of a step may lie beyond it by the round-off of many steps */
static const lamc_real SLACK = LAMC_R(1e-9) + 256 * LAMC_EPSILON;

long long lamc_series_work(const lamc_model *model) {
  return model->series_count > 0 ? 1 : 0;
}

const lamc_recording *lamc_series_recording(const lamc_motion *motion) {
  return motion->recording != NULL ? motion->recording : motion->model->recording;
}

void lamc_series_pass(const void *context, long long next) {
  *lamc_motion_series_work((const lamc_motion *)context) = (lamc_real)(next + 1);
}

/* Where the step under way ends at most; the greatest number where no run is under way, as in memory full of zeros */
static lamc_real end_of_step(const lamc_motion *motion, const lamc_recording *r) {
  const lamc_real passed = motion->work == NULL ? 0 : *lamc_motion_series_work(motion);
  const long long next = (long long)passed - 1;
  return next >= 0 && next < r->break_count ? r->breaks[next] : LAMC_GREATEST;
}

/* 1 if the row begins at or before t, and before the end of the step under way */
static int begins(const lamc_series *s, long long row, lamc_real t, lamc_real end) {
  return s->t[row] <= t && s->t[row] < end;
}

/* The last row that does, else the first row. Where samples are evenly spread, as most are, the first guess is it; else the
 * bracket doubles away from it and is then halved: 2 log2 of the distance. */
static long long row_at(const lamc_series *s, lamc_real t, lamc_real end) {
  const long long last = s->count - 1;
  const lamc_real whole = s->t[last] - s->t[0];
  const lamc_real share = whole > 0 ? (t - s->t[0]) / whole : 0;
  long long low = share > 0 ? (share < 1 ? (long long)(share * (lamc_real)last) : last) : 0, high, stride = 1;
  if (begins(s, low, t, end)) {
    high = low + 1;
    while (high <= last && begins(s, high, t, end)) {
      low = high;
      high = last - high > stride ? high + stride : last + 1;
      if (high > last && low < last && begins(s, last, t, end)) return last;
      stride *= 2;
    }
    if (high > last + 1) high = last + 1;
  } else {
    high = low;
    for (;;) {
      if (high == 0) return 0;
      low = high > stride ? high - stride : 0;
      stride *= 2;
      if (begins(s, low, t, end)) break;
      high = low;
    }
  }
  while (high - low > 1) {
    const long long middle = low + (high - low) / 2;
    if (begins(s, middle, t, end)) {
      low = middle;
    } else {
      high = middle;
    }
  }
  return low;
}

/* NaN: there is no value */
static lamc_real nothing(void) {
  lamc_real huge = LAMC_GREATEST;
  huge *= 2;
  return huge - huge;
}

/* The value and its derivatives (LAMC_SERIES_ORDERS,) */
static void evaluate_at(const lamc_series *s, lamc_real t, lamc_real end, lamc_real *out) {
  const lamc_real slack = SLACK * (s->end - s->begin);
  for (int order = 0; order < LAMC_SERIES_ORDERS; order++) out[order] = 0;
  if (!(t >= s->begin - slack && t <= s->end + slack)) {
    out[0] = nothing();
    return;
  }
  const long long row = row_at(s, t, end);
  const lamc_real *c = s->rows + row * s->width;
  const lamc_real after = t - s->t[row];
  for (int order = 0; order < s->width; order++) {
    lamc_real sum = 0;
    for (int power = s->width - 1; power >= order; power--) {
      lamc_real factor = 1;
      for (int k = 0; k < order; k++) factor *= (lamc_real)(power - k);
      sum = sum * after + factor * c[power];
    }
    out[order] = sum;
  }
}

void lamc_series_write(const lamc_motion *motion, lamc_real t) {
  const lamc_recording *r = lamc_series_recording(motion);
  for (int i = 0; i < motion->model->series_count; i++) {
    lamc_real *out = motion->constants + (ptrdiff_t)LAMC_SERIES_ORDERS * i;
    if (r != NULL) {
      evaluate_at(&r->series[i], t, end_of_step(motion, r), out);
    } else {
      out[0] = nothing();
    }
  }
}
