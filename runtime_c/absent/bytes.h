/* bytes.h: memory copied and cleared without <string.h>, in whose place lamc's amalgamation reads it. */
#ifndef LAMC_BYTES_H
#define LAMC_BYTES_H

#include <stddef.h>

#if defined(__GNUC__)
#define memcpy(to, from, count) __builtin_memcpy(to, from, count)
#define memset(to, value, count) __builtin_memset(to, value, count)
#else
static void *memcpy(void *to, const void *from, size_t count) {
  unsigned char *a = (unsigned char *)to;
  const unsigned char *b = (const unsigned char *)from;
  for (size_t i = 0; i < count; i++) a[i] = b[i];
  return to;
}

static void *memset(void *to, int value, size_t count) {
  unsigned char *a = (unsigned char *)to;
  for (size_t i = 0; i < count; i++) a[i] = (unsigned char)value;
  return to;
}
#endif

#endif /* LAMC_BYTES_H */
