/* lane_pivots.h, of lamc: which equations of small loops hold, for several runs side by side: loop_dense.h in lanes.
 *
 * In:    the entries of J in lanes, and goals beside them. Out: J eliminated, with complete pivoting; what solves it, and
 *        which directions it leaves free; which lanes are no regular case.
 * Never: lets an equation go: a lane where one fades is left to loops.c.
 *
 * Pivots are each lane's own. Rows and columns of all lanes are exchanged by masks, so that what follows is the same for
 * all; goals are columns behind J, which rows take along. Operations are in the order of loop_dense.h and loop_parts.h,
 * whose names are here in brackets. */
#ifndef LAMC_LANE_PIVOTS_H
#define LAMC_LANE_PIVOTS_H

#include "lane_numbers.h"
#include "tolerances.h"

enum {
  FREE = NU - RANK, /* rates that are left over */
  MASS = NU * (NU + 1) / 2,
  GOALS = 2, /* phi or gamma; rates that open the loops */
  WIDTH = NU + GOALS,
  COLUMNS = 1 << 4, /* a place in J is COLUMNS * row + column */
  ROUNDS = 8        /* MAX_ITERATIONS */
};

typedef struct lane_loops {
  lanes raw[MASS + NU + ENTRIES + NM]; /* M, f; J and gamma behind them */
  lanes closure[NM + ENTRIES];         /* phi and J */
  lanes norms[NM];
  lanes a[NM][WIDTH], inverse[RANK];
  lane_mask is_rate[NU][NU]; /* whether column k of `a` is the rate */
  lanes last;                /* the last pivot, of the first */
  lanes free[FREE + 1][NU], l[FREE + 1][FREE + 1];
  lanes y[NQ + NU]; /* a state that is being closed */
  lane_mask odd;    /* no regular case */
} lane_loops;

LAMC_LANE_FUNCTION void lane_exchange(lane_mask is, lanes *a, lanes *b) {
  const lanes keep = *a;
  *a = lane_pick(is, *b, *a);
  *b = lane_pick(is, keep, *b);
}

/* (larger of loops.c): NaN where one is */
LAMC_LANE_FUNCTION lanes lane_most(lanes most, lanes next) {
  return lane_pick(lane_less(most, next) | lane_not(lane_same(next, next)), next, most);
}

LAMC_LANE_FUNCTION lanes lane_largest(const lanes *v, int count) {
  lanes most = {0};
  LAMC_UNROLLED for (int i = 0; i < count; i++) most = lane_most(most, lane_fabs(v[i]));
  return most;
}

LAMC_LANE_FUNCTION lanes lane_dot(int count, const lanes *a, const lanes *b) {
  lanes sum = {0};
  LAMC_UNROLLED for (int i = 0; i < count; i++) sum += a[i] * b[i];
  return sum;
}

/* Rows of J, and `extra` with them, whose largest entry is about one [lamc_loop_normalise, lamc_loop_divide] */
LAMC_LANE_FUNCTION void lane_normalise(lane_loops *p, const lanes *c, lanes *j, lanes *extra) {
  const lanes least = lane_larger(OF_MISFIT * (c[NC - 1] / c[NC - 2]), EACH(NO_EQUATION));
  LAMC_UNROLLED for (int i = 0; i < NM; i++) {
    lanes norm = {0};
    LAMC_UNROLLED for (int e = LANE_ROW_START[i]; e < LANE_ROW_START[i + 1]; e++) norm =
        lane_larger(lane_fabs(j[e]), norm);
    const lane_mask is_plain = lane_less(EACH(0.25), norm) & lane_less(norm, EACH(4.0));
    p->norms[i] = EACH(1.0);
    if (!lane_some(lane_not(is_plain))) continue;
    const lane_mask holds = lane_less(least, norm);
    const lanes faint = lane_pick(lane_less(EACH(NO_EQUATION), least), 1.0 / least, EACH(0.0));
    const lanes scale = lane_pick(is_plain, EACH(1.0), lane_pick(holds, 1.0 / norm, faint));
    p->odd |= holds & lane_less(norm, EACH(FADING));
    p->norms[i] = lane_pick(is_plain, EACH(1.0), lane_pick(holds, norm, EACH(0.0)));
    LAMC_UNROLLED for (int e = LANE_ROW_START[i]; e < LANE_ROW_START[i + 1]; e++) j[e] *= scale;
    extra[i] *= scale;
  }
}

/* Where the largest so far is */
typedef struct lane_place {
  lanes size;
  lane_bits at;
} lane_place;

LAMC_LANE_FUNCTION void lane_look(lanes value, int at, lane_place *largest) {
  const lanes size = lane_fabs(value);
  const lane_mask is = lane_less(largest->size, size);
  largest->size = lane_pick(is, size, largest->size);
  largest->at = (lane_bits)lane_pick(is, (lanes)(largest->at * 0 + at), (lanes)largest->at);
}

/* Likewise, of a row that comes after it: rows are looked through by themselves, so that none waits for another. */
LAMC_LANE_FUNCTION void lane_look_on(const lane_place *row, lane_place *largest) {
  const lane_mask is = lane_less(largest->size, row->size);
  largest->size = lane_pick(is, row->size, largest->size);
  largest->at = (lane_bits)lane_pick(is, (lanes)row->at, (lanes)largest->at);
}

/* What pivot k has, from the rows below; where the largest that is left is [lamc_dense_eliminate] */
LAMC_LANE_FUNCTION lane_bits lane_eliminate(lanes (*a)[WIDTH], lanes inverse, int k) {
  lane_place largest = {EACH(-1.0), {0}};
  LAMC_UNROLLED for (int i = k + 1; i < NM; i++) {
    lane_place of_row = {EACH(-1.0), {0}};
    const lanes part = a[i][k] *= inverse;
    LAMC_UNROLLED for (int c = k + 1; c < NU; c++) {
      a[i][c] -= part * a[k][c];
      lane_look(a[i][c], COLUMNS * i + c, &of_row);
    }
    lane_look_on(&of_row, &largest);
  }
  return largest.at;
}

/* The largest that is left comes to place k, k [lamc_dense_swap] */
LAMC_LANE_FUNCTION void lane_bring(lanes (*a)[WIDTH], int k, lane_bits best, lanes *rate) {
  const lane_bits row = best >> 4, column = best & (COLUMNS - 1);
  LAMC_UNROLLED for (int i = k + 1; i < NM; i++) {
    const lane_mask is = lane_is(row, i);
    LAMC_UNROLLED for (int c = 0; c < WIDTH; c++) lane_exchange(is, &a[k][c], &a[i][c]);
  }
  LAMC_UNROLLED for (int c = k + 1; c < NU; c++) {
    const lane_mask is = lane_is(column, c);
    LAMC_UNROLLED for (int i = 0; i < NM; i++) lane_exchange(is, &a[i][k], &a[i][c]);
    lane_exchange(is, rate + k, rate + c);
  }
}

/* J eliminated, with goals beside it [lamc_dense_order] */
static LAMC_ONCE void lane_order(lane_loops *p, const lanes *j, const lanes *goal, const lanes *other) {
  lanes a[NM][WIDTH], rate[NU], first = {0}, size = {0};
  lane_place largest = {EACH(-1.0), {0}};
  LAMC_UNROLLED for (int i = 0; i < NM; i++) {
    lane_place of_row = {EACH(-1.0), {0}};
    LAMC_UNROLLED for (int c = 0; c < NU; c++) a[i][c] = EACH(0.0);
    LAMC_UNROLLED for (int e = LANE_ROW_START[i]; e < LANE_ROW_START[i + 1]; e++) {
      a[i][LANE_COLUMN[e]] = j[e];
      lane_look(j[e], COLUMNS * i + LANE_COLUMN[e], &of_row);
    }
    lane_look_on(&of_row, &largest);
    a[i][NU] = goal[i];
    a[i][NU + 1] = other[i];
  }
  LAMC_UNROLLED for (int c = 0; c < NU; c++) rate[c] = EACH((double)c);
  LAMC_UNROLLED for (int k = 0; k < RANK; k++) {
    lane_bring(a, k, largest.at, rate);
    size = lane_fabs(a[k][k]);
    if (k == 0) first = size;
    p->odd |= lane_not(lane_less(PASSING * first, size));
    p->inverse[k] = 1.0 / a[k][k];
    if (k + 1 < RANK) largest.at = lane_eliminate(a, p->inverse[k], k);
  }
  memcpy(p->a, a, sizeof a);
  p->odd |= lane_less(size, TOGETHER * first);
  p->last = size / first;
  LAMC_UNROLLED for (int k = 0; k < NU; k++) {
    LAMC_UNROLLED for (int i = 0; i < NU; i++) p->is_rate[k][i] = lane_same(rate[k], EACH((double)i));
  }
}

/* x (NU,) of which number k in the order of `a` is y[k], for `count` of them */
LAMC_LANE_FUNCTION void lane_spread(const lane_loops *p, const lanes *y, int count, lanes *x) {
  LAMC_UNROLLED for (int i = 0; i < NU; i++) {
    x[i] = EACH(0.0);
    LAMC_UNROLLED for (int k = 0; k < count; k++) x[i] = lane_pick(p->is_rate[k][i], y[k], x[i]);
  }
}

/* [lamc_dense_impose] */
static LAMC_ONCE void lane_impose(const lane_loops *p, int goal, lanes *x) {
  lanes y[RANK];
  LAMC_UNROLLED for (int k = 0; k < RANK; k++) y[k] = -p->a[k][NU + goal] - lane_dot(k, p->a[k], y);
  LAMC_UNROLLED for (int k = RANK - 1; k >= 0; k--) {
    LAMC_UNROLLED for (int i = k + 1; i < RANK; i++) y[k] -= p->a[k][i] * y[i];
    y[k] *= p->inverse[k];
  }
  lane_spread(p, y, RANK, x);
}

/* [lamc_dense_find_free] */
LAMC_LANE_FUNCTION void lane_find_free(lane_loops *p) {
  LAMC_UNROLLED for (int c = RANK; c < NU; c++) {
    lanes y[NU];
    LAMC_UNROLLED for (int k = RANK; k < NU; k++) y[k] = EACH(k == c ? 1.0 : 0.0);
    LAMC_UNROLLED for (int k = RANK - 1; k >= 0; k--) {
      lanes rest = -p->a[k][c];
      LAMC_UNROLLED for (int i = k + 1; i < RANK; i++) rest -= p->a[k][i] * y[i];
      y[k] = rest * p->inverse[k];
    }
    lane_spread(p, y, NU, p->free[c - RANK]);
  }
}

#endif /* LAMC_LANE_PIVOTS_H */
