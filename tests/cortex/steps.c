/* Steps MODEL, a model in single precision, and prints the bits of every
 * STEP_STRIDE-th state: on a bare processor and on the machine that tests run
 * on, where HOSTED is defined. */
#include MODEL_H

#include <stdint.h>
#ifdef HOSTED
#include <stdio.h>
#include <string.h>
static void put(const char *text) { fputs(text, stdout); }
#define COPY(to, from, count) memcpy(to, from, count)
#else
void put(const char *text);
uint32_t ticks(void);
#define COPY(to, from, count) __builtin_memcpy(to, from, count)
#endif

#define JOIN_(a, b) a##b
#define JOIN(a, b) JOIN_(a, b)
#define M(name) JOIN(MODEL, name)

static void put_number(uint32_t number, char end) {
  char text[10];
  for (int i = 0; i < 8; i++)
    text[i] = "0123456789abcdef"[number >> (28 - 4 * i) & 15u];
  text[8] = end;
  text[9] = '\0';
  put(text);
}

static void put_bits(float x, char end) {
  uint32_t bits;
  COPY(&bits, &x, sizeof bits);
  put_number(bits, end);
}

int main(void) {
  static M(_t) it;
  M(_outputs) out;
  int status = M(_init)(&it, 0, 0);
  for (int k = 0; k <= STEPS && status == 0; k++) {
#ifndef HOSTED
    const uint32_t before = ticks();
#endif
    if (k > 0)
      status = M(_step_fixed)(&it, STEP);
#ifndef HOSTED
    const uint32_t after = ticks();
    if (k == STEPS) {
      put("ticks ");
      put_number((before - after) & 0xffffffu, '\n');
    }
#endif
    if (k % STRIDE != 0 || status != 0)
      continue;
    put_bits(it.t, ' ');
    for (int i = 0; i < M(_coordinate_count); i++)
      put_bits(it.q[i], ' ');
    for (int i = 0; i < M(_rate_count); i++)
      put_bits(it.u[i], ' ');
    status = M(_get_outputs)(&it, &out);
    put_bits(out.total_energy, '\n');
  }
  if (status != 0)
    put_number((uint32_t)status, '\n');
  return status != 0;
}
