/* real.h, of lamc: lamc_real.h where types and constants are written out. Only lamc's amalgamation reads it. */
