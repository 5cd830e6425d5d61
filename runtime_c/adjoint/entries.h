/* entries.h, of lamc: what an entry of a tape holds.
 *
 * In: the sizes of a model. Out: where the parts lie. Never: reads what is in them. */
#ifndef LAMC_ENTRIES_H
#define LAMC_ENTRIES_H

#include "lamc_adjoint.h"

#include "tableau.h"

enum { ENTRY_STEP = 0, ENTRY_EVENT = 1, ENTRY_HEAD = 8, TAPE_MARGIN = 16 };

/* Of a step: from t_old to t with h, whose state goes from `before` to `after`; nodes: states at the inner nodes of Radau IIA,
 * of a step of an implicit method. Of an event at t: what it does to the state. modes, held: before that; later: modes behind it;
 * struck: its guards. */
typedef struct entry {
  lamc_real *kind, *t_old, *t, *h, *method, *next, *singular, *is_break;
  lamc_real *struck, *modes, *later, *held, *before, *after, *nodes;
} entry;

static inline long long lamc_entry_size(const lamc_model *model) {
  const long long n = model->coordinate_count + model->rate_count, k = model->guard_count;
  return ENTRY_HEAD + 3 * k + model->held_count + 2 * n + (RADAU_NODES - 1) * n;
}

static inline entry lamc_entry_at(const lamc_model *model, lamc_real *first, long long index) {
  const ptrdiff_t n = model->coordinate_count + model->rate_count, k = model->guard_count;
  lamc_real *p = first + (ptrdiff_t)(index * lamc_entry_size(model));
  entry e = {p, p + 1, p + 2, p + 3, p + 4, p + 5, p + 6, p + 7, NULL, NULL, NULL, NULL, NULL, NULL, NULL};
  e.struck = p + ENTRY_HEAD;
  e.modes = e.struck + k;
  e.later = e.modes + k;
  e.held = e.later + k;
  e.before = e.held + model->held_count;
  e.after = e.before + n;
  e.nodes = e.after + n;
  return e;
}

#endif /* LAMC_ENTRIES_H */
