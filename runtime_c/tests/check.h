/* check.h: the harness of the C tests. A test is a function that calls CHECK; main counts and prints. */
#ifndef LAMC_TESTS_CHECK_H
#define LAMC_TESTS_CHECK_H

#include <stdio.h>

typedef struct check_counts {
  int passed;
  int failed;
} check_counts;

typedef void (*check_test)(check_counts *counts);

typedef struct check_case {
  const char *name;
  check_test test;
} check_case;

static inline void check_that(check_counts *counts, int holds, const char *what, const char *file, int line) {
  if (holds) {
    counts->passed++;
  } else {
    counts->failed++;
    printf("%s:%d: failed: %s\n", file, line, what);
  }
}

#define CHECK(counts, condition) check_that(counts, (condition) ? 1 : 0, #condition, __FILE__, __LINE__)
#define CASE(name) {#name, name}

/* Runs the cases in order; the process's exit code. */
static inline int check_run(const check_case *cases, int count) {
  check_counts counts = {0, 0};
  for (int i = 0; i < count; i++) {
    const int failed_before = counts.failed;
    cases[i].test(&counts);
    if (counts.failed > failed_before) printf("FAILED %s\n", cases[i].name);
  }
  printf("%d passed, %d failed\n", counts.passed, counts.failed);
  return counts.failed > 0;
}

#endif
