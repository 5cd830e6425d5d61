/* layout.h, of lamc: where the numbers of a run with derivatives lie.
 *
 * In: the sizes of a model, and how many columns S has. Out: how many numbers `work` takes; its parts.
 * Never: reads what is in them. */
#ifndef LAMC_LAYOUT_H
#define LAMC_LAYOUT_H

#include "lamc_sensitivity.h"

#include "ahead.h"
#include "collocation.h"
#include "finely.h"
#include "memory.h"

enum { SLOPES = 16 };

static inline long long lamc_whole(long long size) {
  return (size + LANES - 1) / LANES * LANES;
}

/* Where the parts lie; returns how many numbers they take. s NULL: for the size only */
static inline long long lamc_lay_out(lamc_sensitivity *s, const lamc_model *model,
                                     const lamc_tangents *tangents, int columns, lamc_real *work) {
  const int n = model->coordinate_count + model->rate_count, width = lamc_columns_width(columns);
  const long long block = (long long)n * width;
  const int broad = lamc_collocation_width(n, columns); /* the broadest S that is asked for */
  const long long inputs = (long long)model->parameter_count + model->geometry_count;
  const long long sizes[] = {block,
                             block,
                             block,
                             SLOPES * block,
                             block,
                             padded(n),
                             padded(n),
                             lamc_whole(model->constant_count) + LANES,
                             lamc_whole(model->constant_count) + LANES,
                             lamc_whole(inputs) + LANES,
                             lamc_whole(lamc_collocation_size(n, columns, width)),
                             lamc_whole(lamc_motion_work_size(model)) + LANES,
                             lamc_whole(lamc_variation_size(model, tangents->column_count, broad)),
                             lamc_whole(lamc_fine_size(n, width)),
                             2LL * model->held_count * width,
                             lamc_memory_size(model),
                             lamc_lay_side_by_side(model, tangents, NULL, NULL),
                             lamc_whole(model->constant_count) + LANES,
                             2LL * model->held_count * width};
  enum { PARTS = sizeof sizes / sizeof sizes[0] };
  long long at[PARTS + 1] = {0};
  for (int i = 0; i < PARTS; i++) at[i + 1] = at[i] + sizes[i];
  if (s != NULL) {
    lamc_real **const of_run[] = {&s->here, &s->start, &s->end, &s->slopes};
    for (int i = 0; i < 4; i++) *of_run[i] = work + at[i];
    s->beside.constants = work + at[7];
    s->beside.work = work + at[11];
    s->scratch = work + at[12];
    s->room.argument = work + at[4];
    s->room.y = work + at[5];
    s->room.after = work + at[6];
    s->room.constants = work + at[8];
    s->room.inputs = work + at[9];
    s->room.collocation = work + at[10];
    s->room.fine = work + at[13];
    s->held = work + at[14];
    s->remembered = work + at[15];
    (void)lamc_lay_side_by_side(model, tangents, work + at[16], s->lanes);
    s->held_width = width;
    s->over_step = work + at[17];
    s->held_over_step = work + at[18];
  }
  return at[PARTS];
}

#endif /* LAMC_LAYOUT_H */
