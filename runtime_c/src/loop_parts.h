/* loop_parts.h, of lamc: the parts of the work array of loops, and the rows of J.
 *
 * In:    the entries of J, phi or gamma beside them. Out: rows whose largest entry is about one, and sums over them.
 * Never: decides which equations hold. */
#ifndef LAMC_LOOP_PARTS_H
#define LAMC_LOOP_PARTS_H

#include "lamc.h"
#include "loops.h"
#include "tolerances.h"

#include <math.h>
#include <stddef.h>
#include <string.h>

/* Whole numbers of a plan, or such as were found at run time */
typedef struct lamc_indices {
  const int *given;
  lamc_real *found; /* where `given` is NULL */
} lamc_indices;

static inline int lamc_at(lamc_indices x, ptrdiff_t k) {
  return x.given != NULL ? x.given[k] : (int)x.found[k];
}

/* A sparse elimination of J: the same facts as a plan's, and its numbers */
typedef struct lamc_steps {
  lamc_indices row, update_start, update, left_start, left;
  lamc_real *factor;  /* by update: the multiple of the earlier step */
  lamc_real *value;   /* by rate left */
  lamc_real *inverse; /* (n,): 1 / pivot, by step */
  lamc_real *peak;    /* (n,): the largest value left, by step */
  lamc_real *noise;   /* (n,): round-off of the values left, at most, in units of that of one */
} lamc_steps;

/* The parts of the work array. Of those that eliminate, the first are of small loops, the others of large ones. */
typedef struct lamc_loop_parts {
  const lamc_motion *motion;
  const lamc_pattern *pattern; /* of J */
  int n, m;                    /* rates, equations */
  int nq;                      /* coordinates */
  int cut, beyond;             /* rates cut <= i < beyond have no mass of their own */
  int is_sparse;               /* 1: J is eliminated row by row */
  int has_mass;                /* 1: M is written down; else the model applies it */
  lamc_real *mass;             /* (n (n + 1) / 2,): M, its lower triangle by rows */
  lamc_real *f;                /* (n,) */
  lamc_real *j;                /* (entries,): rows that were short or long with entries up to one */
  lamc_real *extra;            /* (m,): phi or gamma, by what was asked last; divided as the rows */
  lamc_real *place;            /* (nq,): the position that was prepared */
  lamc_real *taken; /* (entries + nq,): J and the place that were eliminated last, by this record */
  int count;        /* equations that were taken then; -1: none yet */
  lamc_real *a; /* (m, n): J with rows and columns in order: the multipliers of elimination below U and V */
  lamc_real *rows;    /* (m,): the equation that row k of `a` is, a whole number */
  lamc_real *columns; /* (n,): the rate that column k of `a` is, likewise */
  lamc_real *inverse; /* (n,): 1 / pivot k: back substitution waits for no division then */
  lamc_real *peak;    /* (m,): the largest entry of row k of `a` that is left, in loops that are not tiny */
  lamc_real *filled;  /* (m,): how many entries of row k that are left are not zero, likewise */
  lamc_steps steps, found; /* of large loops: those at hand; those that are looked for at run time */
  lamc_real *row;          /* (n,): one row of J, all rates; zero when it is not in use */
  lamc_real *step_of;      /* (n,): the step that eliminates a rate; -1: none */
  lamc_real *touched;      /* (n,): the rates that the row knows */
  lamc_real *is_touched; /* (n,): their places among those, from 1, while they are gathered; zeros between */
  lamc_real *due;        /* (n,): steps that eliminated one of those, a heap */
  lamc_real *waiting;    /* (m,): rows that wait, by their places in the plan's order */
  lamc_real *free;       /* (n, n): as many rows as there are free directions */
  lamc_real *l;          /* (n, n): of N^T M N = L L^T */
  lamc_real *x;          /* (n,) */
  lamc_real *z;          /* (n,) */
  lamc_real *goal;       /* (m,) */
  lamc_real *qdot;       /* (nq,) */
  lamc_real *y;          /* (nq + n,): a settled copy of a state */
  lamc_real *settled;    /* (nq + n,): the same while places around are looked at */
  /* (LAMC_LOOPS_KEPT,): equations taken when a state was last settled, steps in a row with too few, accelerations with
   * too few, steps with too few, 1 where a row of J fades, 1 where the elimination was planned; work that was done, in
   * units of an addition and a multiplication, some nanosecond of a core */
  lamc_real *state;
  lamc_real *norms; /* (m,): what rows of J were divided by; 0: a row of none */
  lamc_real *reach; /* (m,): the largest angle that the row knows, rad */
  lamc_real *mean;  /* (n + m,): accelerations and multipliers from places around */
  lamc_real *plain; /* (n + m,): those of the state itself */
  lamc_real *step;  /* (n,): of a state that is brought to closure */
  lamc_real *raw;   /* what the model writes: the largest of its functions */
} lamc_loop_parts;

/* Work of what the model's functions do for each hinge, as was measured of sheets of 165 to 1500 hinges: closure,
 * constraints or residual, and momenta */
enum { WORK_OF_CLOSURE = 100, WORK_OF_MOMENTA = 45 };

static inline void lamc_loop_count_work(const lamc_loop_parts *p, lamc_real work) {
  p->state[6] += work;
}

/* Row i of J times v */
static inline lamc_real lamc_loop_row(const lamc_loop_parts *p, int i, const lamc_real *v) {
  lamc_real sum = 0;
  for (int e = p->pattern->row_start[i]; e < p->pattern->row_start[i + 1]; e++) {
    sum += p->j[e] * v[p->pattern->column[e]];
  }
  return sum;
}

/* The largest angle that row i of J knows, rad: what fades as these angles do keeps its digits, and what fades elsewhere,
 * such as in a linkage that has turned into a line, does not */
static inline lamc_real lamc_loop_reach(const lamc_loop_parts *p, int i, const lamc_real *q) {
  lamc_real largest = 0;
  for (int e = p->pattern->row_start[i]; e < p->pattern->row_start[i + 1]; e++) {
    const lamc_real angle = fabs(q[p->pattern->column[e]]);
    if (p->j[e] != 0 && angle > largest) largest = angle;
  }
  return largest;
}

/* 1 if row i of J is shorter than `tolerance`, by angles of one rad or more, or as much shorter than smaller ones */
static inline int lamc_loop_fades(const lamc_loop_parts *p, int i, lamc_real tolerance) {
  const lamc_real reach = p->reach[i] < 1 ? p->reach[i] : 1;
  return p->norms[i] > 0 && p->norms[i] < tolerance * reach;
}

/* The rows that are not plain, by what `norms` says; those that are to be let go stay as long as they are */
static inline void lamc_loop_divide(const lamc_loop_parts *p, lamc_real least) {
  int fades = 0;
  for (int i = 0; i < p->m; i++) fades |= lamc_loop_fades(p, i, PASSING);
  for (int i = 0; i < p->m; i++) {
    if (fades && lamc_loop_fades(p, i, TOGETHER)) p->norms[i] = 1;
    if (p->norms[i] == 1) continue;
    const lamc_real scale = p->norms[i] > 0 ? 1 / p->norms[i] : least > NO_EQUATION ? 1 / least : 0;
    for (int e = p->pattern->row_start[i]; e < p->pattern->row_start[i + 1]; e++) p->j[e] *= scale;
    p->extra[i] *= scale;
  }
}

/* The gap that loops may keep, in sizes: see `constant_count`. */
static inline lamc_real lamc_loop_gap(const lamc_motion *motion) {
  const lamc_real *last = motion->constants + motion->model->constant_count - 2;
  return last[1] / last[0];
}

/* Rows of J that are short or long, and what is in `extra` with them, divided by their largest entry: an equation that
 * fades in a flat position, with all its digits, is as good as any. What is left of a misfit is not made large,
 * nor is what fades without its digits, to be let go; and what round-off leaves is no equation: right on a singular position
 * its row would point anywhere. */
static inline void lamc_loop_normalise(const lamc_loop_parts *p, const lamc_real *q) {
  const lamc_real misfit = OF_MISFIT * lamc_loop_gap(p->motion);
  const lamc_real least = misfit > NO_EQUATION ? misfit : NO_EQUATION;
  int fades = 0, odd = 0;
  for (int i = 0; i < p->m; i++) {
    lamc_real norm = 0;
    for (int e = p->pattern->row_start[i]; e < p->pattern->row_start[i + 1]; e++) {
      if (fabs(p->j[e]) > norm) norm = fabs(p->j[e]);
    }
    const int plain = norm > LAMC_R(0.25) && norm < 4;
    p->norms[i] = plain ? 1 : norm > least ? norm : 0;
    p->reach[i] = 1;
    odd |= !plain;
    if (norm > least && norm < FADING) {
      p->reach[i] = lamc_loop_reach(p, i, q);
      fades |= lamc_loop_fades(p, i, FADING);
    }
  }
  p->state[4] = (lamc_real)fades;
  if (odd) lamc_loop_divide(p, least);
}

#endif /* LAMC_LOOP_PARTS_H */
