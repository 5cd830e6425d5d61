/* methods.h, of lamc: the methods that there are. Made from lamc/run/methods.py by `make methods`. */
#ifndef LAMC_METHODS_H
#define LAMC_METHODS_H

extern const struct method lamc_method_rk45;
extern const struct method lamc_method_dop853;
extern const struct method lamc_method_rodas5p;
extern const struct method lamc_method_radau5;

/* clang-format off */
#define LAMC_METHODS &lamc_method_rk45, &lamc_method_dop853, &lamc_method_rodas5p, &lamc_method_radau5
/* clang-format on */

#endif /* LAMC_METHODS_H */
