/* lanes.h, of lamc: what the C of a model offers to those who take several steps side by side.
 *
 * A block is the memory of so many lanes; each holds the numbers of one run. It begins at a multiple of 64 bytes. */
#ifndef LAMC_LANES_H
#define LAMC_LANES_H

#include "method.h"

typedef struct lamc_lane_steps {
  int width;      /* lanes of a block */
  long long size; /* numbers of a block */
  /* The constants of the run in a lane */
  void (*take_constants)(lamc_real *block, int lane, const lamc_real *constants);
  /* As `attempt` of the method `which`, for every lane that has a run; of the same bits. runs (width,): NULL where a lane
   * is idle; h (width,); -> squared (width,). The stages stay in the block. */
  void (*attempt)(lamc_real *block, int which, lamc_run *const *runs, const lamc_real *h, lamc_real *squared);
  /* Puts the stages of the last attempt into the work of a run, all of them or those that tell its eigenvalues */
  void (*give_stages)(const lamc_real *block, int which, int lane, lamc_run *run, int all);
  /* dy/dt where runs stand, for every lane that has one */
  void (*slope)(lamc_real *block, lamc_run *const *runs);
  /* The continuous extension of DOP853's last step, into the work of every lane that has a run: three evaluations. -> done
   * (width,): 0 where the run is to work it out by itself */
  void (*dense)(lamc_real *block, lamc_run *const *runs, int *done);
  /* As `settle` of the equation, where the last attempt led in every lane that has a run, at t (width,); of the same bits.
   * -> moved (width,); done (width,): 0 where the run is to do it by itself. NULL: nothing has to hold. */
  void (*settle)(lamc_real *block, lamc_run *const *runs, const lamc_real *t, lamc_real *moved, int *done);
} lamc_lane_steps;

/* Of the model's C. NULL: there are none for its compiler. */
const lamc_lane_steps *lamc_this_lanes(void);

/* 1 if steps of the method can be taken side by side */
static inline int lamc_lanes_serve(int which) {
  return which == LAMC_RK45 || which == LAMC_DOP853;
}

#endif /* LAMC_LANES_H */
