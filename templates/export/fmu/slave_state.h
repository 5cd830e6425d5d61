/* slave_state.h: saved states of an instance, and saved states as bytes.
 *
 * In:    a record, or bytes of one. Out: the same the other way, or a sentence why not.
 * Never: allocates; takes bytes that are not whole, or are another model's.
 *
 * The bytes are those of this machine's numbers: they can be read where floating point and byte order are the same and
 * the FMU was compiled from the same sources for the same ABI.
 */
#ifndef SLAVE_STATE_H
#define SLAVE_STATE_H

#include "slave.h"
#include "sum.h"

typedef struct slave_bytes {
  char token[64];
  unsigned long long sum; /* of what follows */
  slave_record record;
} slave_bytes;

static slave_status slave_restore(slave *self, const slave_record *record) {
  if (record == NULL) return slave_refuse(self, SLAVE_ERROR, "a state is set, but the pointer is null");
  if (record->phase < SLAVE_INSTANTIATED || record->phase > SLAVE_TERMINATED) {
    return slave_refuse(self, SLAVE_ERROR, "a state is set that this FMU did not save");
  }
  self->now = *record;
  self->has_values = 0;
  return SLAVE_OK;
}

static slave_status slave_serialise(const slave *self, const slave_record *record, void *bytes, size_t size) {
  static const char token[64] = MODEL_TOKEN;
  if (record == NULL || bytes == NULL) {
    return slave_refuse(self, SLAVE_ERROR, "a state is to become bytes, but a pointer is null");
  }
  if (size < sizeof(slave_bytes)) {
    return slave_refuse(self, SLAVE_ERROR, "there is room for %lu bytes; a state has %lu",
                        (unsigned long)size, (unsigned long)sizeof(slave_bytes));
  }
  char *to = (char *)bytes;
  memset(to, 0, sizeof(slave_bytes));
  memcpy(to, token, sizeof token);
  memcpy(to + offsetof(slave_bytes, record), record, sizeof *record);
  const unsigned long long sum = lamc_sum(to + offsetof(slave_bytes, record), sizeof *record);
  memcpy(to + offsetof(slave_bytes, sum), &sum, sizeof sum);
  return SLAVE_OK;
}

static slave_status slave_check_bytes(const slave *self, const void *bytes, size_t size) {
  static const char token[64] = MODEL_TOKEN;
  const char *from = (const char *)bytes;
  unsigned long long sum;
  if (bytes == NULL)
    return slave_refuse(self, SLAVE_ERROR, "bytes are to become a state, but the pointer is null");
  if (size < sizeof(slave_bytes)) {
    return slave_refuse(self, SLAVE_ERROR, "these are %lu bytes; a state has %lu", (unsigned long)size,
                        (unsigned long)sizeof(slave_bytes));
  }
  if (memcmp(from, token, sizeof token) != 0) {
    return slave_refuse(self, SLAVE_ERROR, "these bytes are no state of the FMU " MODEL_TOKEN);
  }
  memcpy(&sum, from + offsetof(slave_bytes, sum), sizeof sum);
  if (sum != lamc_sum(from + offsetof(slave_bytes, record), sizeof(slave_record))) {
    return slave_refuse(self, SLAVE_ERROR, "these bytes were a state, but are damaged");
  }
  return SLAVE_OK;
}

/* Bytes that were checked. */
static void slave_deserialise(const void *bytes, slave_record *record) {
  memcpy(record, (const char *)bytes + offsetof(slave_bytes, record), sizeof *record);
}

#endif /* SLAVE_STATE_H */
