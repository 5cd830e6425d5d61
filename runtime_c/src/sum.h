/* sum.h, of lamc: a sum over bytes, by which damage to them is found.
 *
 * In: bytes. Out: 64 bits that differ where one byte does. Never: tells malice. */
#ifndef LAMC_SUM_H
#define LAMC_SUM_H

#include <stddef.h>

/* FNV-1a: G. Fowler, L. C. Noll, K.-P. Vo, D. Eastlake, RFC 9923 */
static inline unsigned long long lamc_sum(const void *bytes, size_t size) {
  const unsigned char *byte = (const unsigned char *)bytes;
  unsigned long long sum = 14695981039346656037ULL;
  for (size_t i = 0; i < size; i++) sum = (sum ^ byte[i]) * 1099511628211ULL;
  return sum;
}

#endif /* LAMC_SUM_H */
