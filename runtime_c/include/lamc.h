/* lamc.h: the C runtime that a generated simulator stands on.
 *
 * In:    a lamc_model (filled by generated C) or any lamc_ode, an initial state, tolerances, output times.
 * Out:   rows of states in buffers of the caller, and a lamc_status.
 * Never: allocates, prints, keeps global state, or runs without a bound on its work.
 *
 * Units are SI and radians throughout. A state is y = [q, u]: coordinates (nq,), then rates (nu,). Joint angles (rad) and
 * joint rates (rad/s) come first among them, and in most mechanisms are all there is: dq/dt = u then.
 * Every number is a lamc_real, which is double unless lamc_real.h is told otherwise. Matrices are row-major. Arrays carry their shape in the comment beside them.
 *
 * The text between the two `lamc: declarations` lines is plain C without preprocessor (but for
 * `#define NAME integer`), because Python's cffi reads the same text.
 */
#ifndef LAMC_H
#define LAMC_H

#include "lamc_real.h"

#ifdef __cplusplus
extern "C" {
#endif

/* lamc: declarations begin */

/* What a call came to. Zero: the end was reached. Positive: not an end, call again. Negative: it ended early, and
 * every row written so far is good. */
typedef enum lamc_status {
  LAMC_OK = 0,              /* the end was reached */
  LAMC_PAUSED = 1,          /* the budget of evaluations is spent: call again to go on */
  LAMC_OUTPUT_FULL = 2,     /* the rows are full: empty or replace them and call again */
  LAMC_STEP_UNDERFLOW = -1, /* the step needed is below the spacing of numbers around t */
  LAMC_NOT_FINITE = -2,     /* NaN or infinity at the start, or at every step however short */
  LAMC_STEP_LIMIT = -3,     /* max_steps steps were taken */
  LAMC_CANCELLED = -4,      /* the cancel flag was raised */
  LAMC_BAD_ARGUMENT = -5,   /* an argument breaks the rule written beside it */
  LAMC_CLOSURE_LOST = -7,   /* a loop came apart: no position nearby closes it */
  LAMC_RANK_LOST = -8,      /* the motion stays at a singular position, where it is not determined */
  LAMC_EVENTS_PILE_UP = -9  /* impacts or switches follow each other ever faster (Zeno) */
} lamc_status;

/* One line of English for people; never NULL, also for numbers that are no status. */
const char *lamc_status_message(lamc_status status);

/* ---- A compiled mechanism. Generated C fills it; it never changes. ---------------------------------------- */

/* Which entries of J, the Jacobian of the closure of loops, are not zero, and a plan to eliminate it where they are few.
 * Entries lie row by row. Of the plan: a row of J is taken for each step, less multiples of what earlier steps left of
 * theirs; what is left has its pivot first. It holds where pivots are not too small; elsewhere an order is looked for. */
typedef struct lamc_pattern {
  const int *row_start;    /* (m + 1,): entries row_start[i] to row_start[i + 1] - 1 are those of row i */
  const int *column;       /* (row_start[m],): the rate that an entry belongs to */
  int step_count;          /* of the plan; 0: there is none, and J is eliminated as one array */
  const int *step_row;     /* (m,): the row of J that each step takes, then the rows that none does */
  const int *update_start; /* (step_count + 1,) */
  const int *update;     /* (update_start[step_count],): the earlier steps that a row is freed of, in order */
  const int *left_start; /* (step_count + 1,) */
  const int *left;       /* (left_start[step_count],): the rates that are left in a row, the pivot's first */
} lamc_pattern;

/* A value, and its first three derivatives by time */
enum { LAMC_SERIES_ORDERS = 4 };

/* An input over time, by pieces of polynomials. */
typedef struct lamc_series {
  long long count;      /* rows, > 0 */
  int width;            /* coefficients of a row, 1 to 4 */
  lamc_real begin, end; /* s: before and after, there is no value */
  const lamc_real
      *t; /* (count,), s, strictly ascending: where rows begin; the first counts before that too */
  const lamc_real *rows; /* (count, width): by rising power of the time since the row began */
} lamc_series;

/* What inputs follow in a run, and where its steps end for it. */
typedef struct lamc_recording {
  const lamc_series *series; /* (series_count,) */
  const lamc_real
      *breaks; /* (break_count,), s, strictly ascending: an input, or a derivative of it, jumps at each */
  long long break_count;
} lamc_recording;

typedef struct lamc_model {
  const char *name;            /* of the mechanism */
  const char *digest;          /* of the program that the C was printed from, hexadecimal */
  int joint_count;             /* joints that are coordinates; the first ones */
  int coordinate_count;        /* nq: joints, and what effects add, such as the pose of a free base */
  int rate_count;              /* nu <= nq; fewer where a quaternion is among the coordinates */
  int cut_count;               /* the last joints, which close loops; 0: a tree */
  int closure_count;           /* m: equations that hold the loops, redundant ones included */
  int rank;                    /* of the closure at a generic position: no more equations are taken */
  const lamc_pattern *pattern; /* of J; NULL: a tree */
  int body_count;              /* moving bodies */
  int parameter_count;         /* numbers that can change without recompiling */
  int geometry_count;          /* numbers of the drawing, behind them */
  int constant_count; /* numbers that depend on those only. With loops the last two are the mechanism's
                                   * size, m, which closure is judged by, and the gap, m, that loops may keep where
                                   * their equations disagree */
  int energy_count;   /* kinetic first, then one for each effect that stores energy */
  int guard_count;    /* conditions whose passing of zero is an event */
  int power_count;    /* effects whose power is told; 0: none */
  int table_count;    /* piecewise cubics in the equations, whose higher derivatives jump */
  int series_count; /* inputs that follow a table over time; each has LAMC_SERIES_ORDERS of the first constants */
  const char *const *joint_names;      /* (joint_count,), UTF-8 */
  const char *const *coordinate_names; /* (nq,), UTF-8 */
  const char *const *coordinate_units; /* (nq,), UTF-8; NULL: all rad */
  const char *const *rate_names;       /* (nu,), UTF-8 */
  const char *const *rate_units;       /* (nu,), UTF-8; NULL: all rad/s */
  const char *const *body_names;       /* (body_count,), UTF-8 */
  const char *const *parameter_names;  /* (parameter_count,), UTF-8 */
  const char *const *parameter_units;  /* (parameter_count,), UTF-8 */
  const char *const *energy_names;     /* (energy_count,), UTF-8 */
  const char *const *guard_names;      /* (guard_count,), UTF-8 */
  const char *const *power_names;      /* (power_count,), UTF-8 */
  const char *const *series_names;     /* (series_count,), UTF-8 */
  const int *series_orders;            /* (series_count,): the highest derivative that accelerations hold */
  const lamc_recording *recording;     /* followed where a motion has none of its own; NULL: none */
  const lamc_real *parameter_defaults; /* (parameter_count + geometry_count,), in parameter_units, then SI */
  const int *
      guard_modes; /* (guard_count,): constant that is 1 beyond the guard, 0 before; -1: an impact, -2: a clock */
  lamc_real jacobian_cost; /* operations of jacobian over those of an acceleration */
  /* parameters (parameter_count + geometry_count,) -> constants (constant_count,); once per change of parameters */
  void (*setup)(const lamc_real *parameters, lamc_real *constants);
  /* q, u -> dq/dt (nq,), linear in u. NULL: dq/dt = u */
  void (*rates)(const lamc_real *constants, const lamc_real *q, const lamc_real *u, lamc_real *qdot);
  /* t s, q (nq,), u (nu,) -> udot (nu,). NULL with loops, and where the runtime solves M udot = f from system. */
  void (*acceleration)(const lamc_real *constants, lamc_real t, const lamc_real *q, const lamc_real *u,
                       lamc_real *udot);
  /* -> M lower triangle by rows (nu (nu + 1) / 2), f (nu,) of M udot = f without the loops. NULL where residual is not */
  void (*system)(const lamc_real *constants, lamc_real t, const lamc_real *q, const lamc_real *u,
                 lamc_real *system);
  /* -> phi (m,) rad or parts of the size, the entries of J (m, nu): dphi/dt = J u */
  void (*closure)(const lamc_real *constants, const lamc_real *q, lamc_real *closure);
  /* -> what system gives, then the entries of J, gamma (m,) 1/s^2 of J udot + gamma = 0: all that an acceleration needs */
  void (*dynamics)(const lamc_real *constants, lamc_real t, const lamc_real *q, const lamc_real *u,
                   lamc_real *dynamics);
  /* Large loops have the three that follow in place of system and dynamics: M is not written down there. */
  /* -> the entries of J, gamma (m,) */
  void (*constraints)(const lamc_real *constants, const lamc_real *q, const lamc_real *u,
                      lamc_real *constraints);
  /* At udot -> M udot - f (nu,) without the loops */
  void (*residual)(const lamc_real *constants, lamc_real t, const lamc_real *q, const lamc_real *u,
                   const lamc_real *udot, lamc_real *residual);
  /* At udot -> M udot (nu,), for rates as well */
  void (*momenta)(const lamc_real *constants, const lamc_real *q, const lamc_real *udot, lamc_real *momenta);
  /* -> energies (energy_count,) J */
  void (*energy)(const lamc_real *constants, lamc_real t, const lamc_real *q, const lamc_real *u,
                 lamc_real *energies);
  /* t, q -> poses (body_count, 12): centre of mass (3) m, rotation (3, 3) row-major, both in world axes */
  void (*poses)(const lamc_real *constants, lamc_real t, const lamc_real *q, lamc_real *poses);
  /* With acceleration: -> M lower triangle by rows (nu (nu + 1) / 2). NULL where nothing below needs it. */
  void (*inertia)(const lamc_real *constants, const lamc_real *q, lamc_real *inertia);
  /* At udot, and lambda (m,) N m of M udot = f + J^T lambda, -> (nu + m, nq + nu + 1) derivatives by q, u and t of the residuals
   * M udot - f - J^T lambda (nu,) and J udot + gamma (m,); then, if there is rates, (nq, nq + nu) of dq/dt by q and u.
   * NULL: not worked out, differences are taken instead. */
  void (*jacobian)(const lamc_real *constants, lamc_real t, const lamc_real *q, const lamc_real *u,
                   const lamc_real *udot, const lamc_real *lambda, lamc_real *jacobian);
  /* -> guards (guard_count,) rad or m, negative where nothing happens, then their rates (guard_count,) */
  void (*guards)(const lamc_real *constants, lamc_real t, const lamc_real *q, const lamc_real *u,
                 lamc_real *guards);
  /* -> restitutions (guard_count,), then derivatives of the guards' rates by u (guard_count, nu) */
  void (*impacts)(const lamc_real *constants, lamc_real t, const lamc_real *q, lamc_real *impacts);
  /* At udot -> power (power_count,) W of all loads that each effect applies */
  void (*power)(const lamc_real *constants, lamc_real t, const lamc_real *q, const lamc_real *u,
                const lamc_real *udot, lamc_real *power);
  /* At udot -> what it adds to the guards' rates (guard_count,). NULL: no guard depends on u */
  void (*guard_changes)(const lamc_real *constants, lamc_real t, const lamc_real *q, const lamc_real *u,
                        const lamc_real *udot, lamc_real *changes);
  /* -> periods of the clocks (clock_count,) s, then samples of what they hold (held_count,) */
  void (*samples)(const lamc_real *constants, lamc_real t, const lamc_real *q, const lamc_real *u,
                  lamc_real *samples);
  int clock_count; /* what samples at each multiple of a period, and holds in between */
  int held_count;
  const int *clock_guards; /* (clock_count,): guards that pass zero at a sample */
  const int *clock_ticks;  /* (clock_count,): constants that are the times of the next samples, s */
  const int *held;         /* (held_count,): constants that are what it was at the last sample */
  const int *held_clocks;  /* (held_count,): by which clock */
} lamc_model;

/* A model with its constants: what the functions below evaluate. One thread at a time for loops and guards, which use
 * work and constants. */
typedef struct lamc_motion {
  const lamc_model *model;
  lamc_real *
      constants; /* (constant_count,), from model->setup; of them, only series and guards' modes change later */
  lamc_real *work; /* (lamc_motion_work_size(model),); NULL where that is 0 */
  lamc_real
      baumgarte; /* 1/s, rate at which loops that drifted close again; 0: states are brought back instead */
  const lamc_recording *recording; /* what its inputs follow; NULL: the model's */
} lamc_motion;

/* Numbers that `work` must hold; 0 for a tree with acceleration and without guards, series and power. */
long long lamc_motion_work_size(const lamc_model *model);

/* Brings y = [q, u] of a motion with loops back to closure, by the smallest move in the mass metric: positions first,
 * rates then. *moved is the largest move. LAMC_CLOSURE_LOST where no near position closes. */
lamc_status lamc_motion_settle(const lamc_motion *motion, lamc_real t, lamc_real *y, lamc_real *moved);

/* Steps of the run under way, or of the last one, that ended at a singular position, with equations of the loops let go */
long long lamc_motion_singular_steps(const lamc_motion *motion);

/* Work that the loops of the run under way have taken, about: additions with multiplications, each a nanosecond or less;
 * 0 for a tree. Counted, not timed, and much larger near singular positions: for a limit that is the same everywhere. */
lamc_real lamc_motion_work_done(const lamc_motion *motion);

/* Row by row: -> phi (count, m) rad or parts of the size, and J (count, m, nu), one after the other in each row */
lamc_status lamc_motion_closures(const lamc_motion *motion, long long count, const lamc_real *y,
                                 lamc_real *closures);

/* Row by row over states y (count, nq + nu) at times t (count,); LAMC_BAD_ARGUMENT for NULL or count < 0. */
/* -> udot (count, nu) */
lamc_status lamc_motion_accelerations(const lamc_motion *motion, long long count, const lamc_real *t,
                                      const lamc_real *y, lamc_real *udot);
/* -> energies (count, energy_count), J */
lamc_status lamc_motion_energies(const lamc_motion *motion, long long count, const lamc_real *t,
                                 const lamc_real *y, lamc_real *energies);
/* -> poses (count, body_count, 12) */
lamc_status lamc_motion_poses(const lamc_motion *motion, long long count, const lamc_real *t,
                              const lamc_real *y, lamc_real *poses);
/* -> powers (count, power_count), W */
lamc_status lamc_motion_powers(const lamc_motion *motion, long long count, const lamc_real *t,
                               const lamc_real *y, lamc_real *powers);

/* Numbers of scratch for the function below */
long long lamc_motion_jacobian_scratch(const lamc_model *model);
/* One state y = [q, u] at t: -> d(udot)/dq (nu, nq), d(udot)/du (nu, nu), d(udot)/dt (nu,); analytic where the model
 * brings them, else by differences */
lamc_status lamc_motion_jacobian(const lamc_motion *motion, lamc_real t, const lamc_real *y, lamc_real *by_q,
                                 lamc_real *by_u, lamc_real *by_t, lamc_real *scratch);

/* ---- Ordinary differential equations ----------------------------------------------------------------------- */

/* dy/dt = rhs(t, y), y of shape (n,). rhs writes all of dydt, and may write NaN where it is not defined. What follows
 * context may be NULL or 0, one by one. */
typedef struct lamc_ode {
  int n; /* >= 0 */
  void (*rhs)(const void *context, lamc_real t, const lamc_real *y, lamc_real *dydt);
  const void *context;
  /* Brings y back to what holds for all states; *moved tells how far. NULL: nothing has to hold. */
  lamc_status (*settle)(const void *context, lamc_real t, lamc_real *y, lamc_real *moved);
  /* After a step was accepted and its end settled: whether the run can go on. NULL: it always can. */
  lamc_status (*judge)(const void *context);
  /* How many evaluations of rhs so far are not to be relied on between the ends of a step. NULL: all are. */
  long long (*doubts)(const void *context);
  int coordinate_count; /* y = [q, u], of which q are so many; 0: half of them */
  int is_rough;         /* 1: rhs has few continuous derivatives, so that LAMC_AUTO takes no high order */
  /* Implicit methods need one of two. Where dq/dt = u, k = n / 2: of udot at a state its derivatives by q (k, k), by
   * u (k, k), rows for components of udot, and by t (k,). scratch holds scratch_size numbers. */
  void (*jacobian)(const void *context, lamc_real t, const lamc_real *y, lamc_real *by_q, lamc_real *by_u,
                   lamc_real *by_t, lamc_real *scratch);
  /* Any equation: derivatives of dy/dt by y (n, n) and by t (n,); at more than twice the price */
  void (*full_jacobian)(const void *context, lamc_real t, const lamc_real *y, lamc_real *by_y,
                        lamc_real *by_t, lamc_real *scratch);
  long long scratch_size;  /* of the one that there is */
  lamc_real jacobian_cost; /* of one call, in evaluations of rhs */
  /* Events: guards (guard_count,) that pass from negative to positive, and their rates (guard_count,), 1/s */
  int guard_count;
  void (*guards)(const void *context, lamc_real t, const lamc_real *y, lamc_real *guards);
  /* Before a run starts at (t, y): what rhs and guards stand for there */
  void (*sense)(const void *context, lamc_real t, const lamc_real *y);
  /* After a change of the equation, or to another state: the same, but for guards that are zero up to round-off */
  void (*review)(const void *context, lamc_real t, const lamc_real *y);
  /* The guards with struck (guard_count,) above 0 have reached zero at (t, y), all at one instant: changes y, or what rhs
   * and guards stand for from here on */
  lamc_status (*event)(const void *context, lamc_real t, lamc_real *y, const lamc_real *struck);
  /* Integrals along the run, zero at its start, of integrands (integral_count,): as accurate as the states within steps,
   * and without influence on the steps. Each step takes the integrands at 3 to 7 states. */
  int integral_count; /* 0: none, and the two may be NULL */
  void (*integrands)(const void *context, lamc_real t, const lamc_real *y, lamc_real *values);
  /* Adds to the integrals what an event does that changes y from `before` to `after` */
  void (*jump)(const void *context, lamc_real t, const lamc_real *before, const lamc_real *after,
               lamc_real *integrals);
  /* Times at which rhs or a derivative of it by time jumps, (break_count,), s, strictly ascending: a step ends at each */
  const lamc_real *breaks;
  long long break_count;
  /* From here on rhs stands for times up to the break of that number, at it what holds before; break_count: for all */
  void (*pass)(const void *context, long long next);
  /* Where what rhs and settle take is counted, to which rows and integrals are to add nothing; NULL: it is not */
  lamc_real *(*work)(const void *context);
} lamc_ode;

/* The motion as an equation in y = [q, u], n = nq + nu; `motion` must outlive it. With guards a run changes the
 * motion's constants: one run at a time. A model that tells powers has their integrals, the work of each effect, J, and
 * after them what impacts added to the energy: power_count + 1. A caller who does not want them sets
 * integral_count to 0. */
lamc_ode lamc_motion_ode(const lamc_motion *motion);

typedef struct lamc_options {
  lamc_real rtol;       /* relative tolerance, 1e-13 .. 1 */
  lamc_real atol;       /* absolute tolerance, >= 0, in the units of y, one for all components */
  lamc_real first_step; /* s; 0: chosen from the equation */
  lamc_real max_step;   /* s; 0: no limit; the last step may be 1 % longer */
  long long max_steps;  /* steps tried, accepted or not; > 0 */
} lamc_options;

/* Rows of output. The caller owns the arrays, and may replace them or set the counts to 0 between two calls. */
typedef struct lamc_rows {
  lamc_real *t;             /* (capacity,), s */
  lamc_real *y;             /* (capacity, n) */
  long long capacity;       /* > 0 */
  long long count;          /* rows written so far */
  lamc_real *event_t;       /* (event_capacity,), s; NULL: events are not written */
  int *event_guard;         /* (event_capacity,): which guard */
  long long event_capacity; /* >= 0 */
  long long event_count;    /* events written so far */
  lamc_real *integrals;     /* (capacity, integral_count); NULL: they are not written */
} lamc_rows;

typedef enum lamc_method {
  LAMC_AUTO = 0,    /* explicit, and implicit where that goes faster */
  LAMC_RK45 = 1,    /* Dormand-Prince 5(4), explicit, for loose tolerances */
  LAMC_DOP853 = 2,  /* Dormand-Prince 8(5,3), explicit, for tight tolerances */
  LAMC_RODAS5P = 3, /* Rosenbrock 5(4), no iteration, for stiff hinges */
  LAMC_RADAU5 = 4   /* Radau IIA of order 5, fully implicit, for the stiffest hinges */
} lamc_method;

enum { LAMC_SWITCHES_KEPT = 16 };

typedef enum lamc_dense {
  LAMC_DENSE_NONE = 0,     /* no step yet, or a later one was tried over it */
  LAMC_DENSE_POSSIBLE = 1, /* the stages of the step are still there */
  LAMC_DENSE_READY = 2     /* worked out */
} lamc_dense;

/* What LAMC_AUTO knows of the run. */
typedef struct lamc_watch {
  int is_auto;
  int next_method;      /* to switch to before the next step; 0: none */
  int suspicions;       /* of the last steps, how many stability rather than accuracy seems to have limited */
  int probe_steps;      /* steps left of the trial of another method; 0: none under way */
  long long rest;       /* accepted steps before the next trial */
  long long backoff;    /* what rest is set to when a trial does not pay; doubles each time */
  lamc_real eigenvalue; /* 1/s, that the steps before a trial met */
  lamc_real pace;       /* s of motion per evaluation, of the method that was left for the trial */
  lamc_real mark_t;     /* s, where the pace of the present method is measured from */
  lamc_real mark_cost;  /* evaluations, until then */
} lamc_watch;

/* A run under way. Fields are for reading; lamc_run_start sets them all. */
typedef struct lamc_run {
  lamc_ode ode;
  lamc_options options;
  int method;              /* lamc_method in use; never LAMC_AUTO */
  lamc_real t_end;         /* s */
  const lamc_real *t_eval; /* (t_eval_count,), s, or NULL: a row at the start and after every step */
  long long t_eval_count;
  long long t_eval_next;   /* index of the first time that is not written yet */
  lamc_real t;             /* s, where the run stands */
  lamc_real t_old;         /* s, where the last accepted step began; the dense output covers t_old .. t */
  lamc_real h;             /* s, the step to try next */
  lamc_real h_last;        /* s, the last accepted step; 0: none yet */
  lamc_real log_error_old; /* log2 of the error norm of the last accepted step, for the PI controller */
  long long steps;         /* tried */
  long long accepted;
  long long rejected;
  long long evaluations;    /* of rhs */
  long long jacobians;      /* evaluated */
  long long factorisations; /* of matrices of implicit methods */
  long long events;
  long long switches;                     /* of the method, by LAMC_AUTO */
  lamc_real switch_t[LAMC_SWITCHES_KEPT]; /* s, of the first ones */
  int switch_method[LAMC_SWITCHES_KEPT];  /* lamc_method switched to */
  lamc_watch watch;
  lamc_real *guards; /* guards and their rates where the run stands, then room to find events */
  lamc_real
      *integrals;      /* (integral_count,) where the run stands, then what tells them within the last step */
  lamc_real t_event;   /* s, of the last event */
  lamc_real event_gap; /* s, between the last two events */
  int event_streak;    /* events in a row, each sooner after the last than that one before */
  int event_guard;     /* guard of the last event; -1: none yet */
  int event_due;       /* how many events of this instant are not written yet */
  int stride;          /* n rounded up: distance between the vectors in work */
  int side;           /* 0 or 1: which halves of work hold y and dy/dt at t; the others hold those at t_old */
  int dense;          /* lamc_dense: whether work holds the dense output of t_old .. t */
  int row_due;        /* 1: the row at t is not written yet; t_eval == NULL only */
  int was_rejected;   /* 1: the step before this one was rejected */
  int was_finite;     /* 0: the step before this one met NaN or infinity */
  int was_closed;     /* 0: the step before this one lost what must hold */
  int has_jacobian;   /* 1: work holds the Jacobian at t */
  int has_polynomial; /* 1: work holds the polynomial of the last step, for a first guess of the next */
  long long next_break; /* index of the first break ahead */
  lamc_real h_free;     /* s, the step that would have been tried but for a break; 0: none cut it short */
  int may_pass;         /* 1: the first step of an implicit method is still to come, see implicit.h */
  lamc_status status;   /* of the last call; a negative one stays */
  lamc_real *work;      /* (lamc_run_work_size(&ode, method),) */
} lamc_run;

/* Numbers that `work` must hold; 0 if the equation has a size that cannot be, or lacks what the method needs. */
long long lamc_run_work_size(const lamc_ode *ode, lamc_method method);

/* Prepares a run from y0 (n,) at t0 to t_end >= t0. t_eval ascends within t0 .. t_end. The run keeps pointers to
 * t_eval, work and ode->context, and copies everything else. Two evaluations at most.
 * LAMC_OK; LAMC_BAD_ARGUMENT; LAMC_NOT_FINITE if y0 or rhs(t0, y0) is not finite. */
lamc_status lamc_run_start(lamc_run *run, const lamc_ode *ode, lamc_method method,
                           const lamc_options *options, lamc_real t0, const lamc_real *y0, lamc_real t_end,
                           const lamc_real *t_eval, long long t_eval_count, lamc_real *work);

/* Goes on until the end, an obstacle, or `budget` more evaluations (0: no limit). Stops between two steps only, so
 * a run in slices gives the same bits as a run in one piece. `cancel` (may be NULL) is looked at before each step. */
lamc_status lamc_run_advance(lamc_run *run, lamc_rows *rows, long long budget, const volatile int *cancel);

/* The state y (n,) where the run stands. */
const lamc_real *lamc_run_state(const lamc_run *run);

/* y (n,) at a time within the last accepted step, t_old .. t, by the method's continuous extension.
 * LAMC_BAD_ARGUMENT outside, before the first step, and where a later step was tried and rejected. */
lamc_status lamc_run_interpolate(lamc_run *run, lamc_real t, lamc_real *y);

/* Without rows: one step further, however many are tried for it, to t_end at the most. LAMC_OK, also where the run stands
 * at t_end already, or what ended it. */
lamc_status lamc_run_step(lamc_run *run);

/* y (n,) at a time within the last accepted step, t_old < t <= run->t, as a row has it: what must hold does. At most once
 * per time and in ascending order, if the steps after it are to be those of a run with rows. */
lamc_status lamc_run_at(lamc_run *run, lamc_real t, lamc_real *y);

/* The run goes on from y (n,) at t, within t0 .. t_end, or under an equation that has changed: steps keep method and length.
 * One evaluation. LAMC_OK; LAMC_BAD_ARGUMENT; LAMC_NOT_FINITE if y or rhs(t, y) is not finite. */
lamc_status lamc_run_put(lamc_run *run, lamc_real t, const lamc_real *y);

/* Numbers of scratch for the function below */
long long lamc_fixed_scratch(const lamc_ode *ode);

/* One step of length h != 0 from (t, y) to (t + h, y), without looking at errors: the classical Runge-Kutta method of order
 * 4, four evaluations. What must hold is settled and events are looked at at its end only, each guard once.
 * LAMC_NOT_FINITE: dy/dt at (t, y) is not, and y is as it was; or the step is too long, and y is what it led to. Or what
 * settling says; y is then spoilt. */
lamc_status lamc_fixed_step(const lamc_ode *ode, lamc_real t, lamc_real h, lamc_real *y, lamc_real *scratch);

/* Numbers of scratch for the function below; 0 where the equation has no Jacobian */
long long lamc_stiff_scratch(const lamc_ode *ode);

/* The same by one step of Rodas5P, of order 5: stable for every h, however stiff the equation. Eight evaluations, one
 * Jacobian and one factorisation. LAMC_BAD_ARGUMENT without a Jacobian; LAMC_NOT_FINITE also where h is singular for it. */
lamc_status lamc_stiff_step(const lamc_ode *ode, lamc_real t, lamc_real h, lamc_real *y, lamc_real *scratch);

/* lamc: declarations end */

#ifdef __cplusplus
}
#endif

#endif /* LAMC_H */
