/* watch.c where the method is given. Only lamc's amalgamation reads it. */
#include "watch.h"

void lamc_watch_start(lamc_run *run, lamc_method which) {
  run->method = (int)which;
}

void lamc_watch_step(lamc_run *run) {
  (void)run;
}

void lamc_watch_switch(lamc_run *run) {
  (void)run;
}
