/* rows.h, of lamc: the output of a run. */
#ifndef LAMC_ROWS_H
#define LAMC_ROWS_H

#include "lamc.h"

/* Writes the rows and the event that are due at or before t. LAMC_OK, LAMC_OUTPUT_FULL where some remain, or why a row
 * cannot be had. */
lamc_status lamc_rows_write(lamc_run *run, lamc_rows *rows);

#endif /* LAMC_ROWS_H */
