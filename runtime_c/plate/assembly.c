/* assembly.c: which nodes of a mesh meet, and so which entries a sparse matrix has.
 *
 * For every node: the nodes of its cells, each once, in ascending order. Their unknowns are the rows of all columns of
 * the node, so one offset per pair of nodes of a cell says where its entries go. Time is linear in the cells, but for
 * sorting the neighbours of a node.
 */
#include "lamc_plate.h"

#include <stdlib.h>
#include <string.h>

enum { INSERTION_LIMIT = 64 }; /* longer lists of neighbours are left to qsort */

int64_t lamc_assembly_scratch(const lamc_assembly *a) {
  return 5 * (int64_t)a->unknown_count + 1 + a->cell_count * a->node_count;
}

static int ascending(const void *p, const void *q) {
  const int32_t a = *(const int32_t *)p, b = *(const int32_t *)q;
  return (a > b) - (a < b);
}

static void sort(int32_t *list, int32_t count) {
  if (count > INSERTION_LIMIT) {
    qsort(list, (size_t)count, sizeof *list, ascending);
    return;
  }
  for (int32_t i = 1; i < count; ++i) {
    const int32_t value = list[i];
    int32_t k = i;
    for (; k > 0 && list[k - 1] > value; --k) list[k] = list[k - 1];
    list[k] = value;
  }
}

/* Where the nodes are met: head[u] to head[u + 1] are places in `nodes` that hold u. */
static void list_places(const lamc_assembly *a, int32_t *head, int32_t *place, int32_t *size) {
  const int64_t count = a->cell_count * a->node_count;
  memset(head, 0, sizeof *head * ((size_t)a->unknown_count + 1));
  for (int64_t k = 0; k < count; ++k) {
    ++head[a->nodes[k]];
    size[a->nodes[k]] = a->node_size[k % a->node_count];
  }
  int32_t sum = 0;
  for (int32_t u = 0; u <= a->unknown_count; ++u) {
    sum += head[u];
    head[u] = sum; /* the end; filling backwards makes it the beginning */
  }
  for (int64_t k = count - 1; k >= 0; --k) place[--head[a->nodes[k]]] = (int32_t)k;
}

int64_t lamc_assembly_begin(const lamc_assembly *a, int32_t *scratch) {
  const int32_t unknowns = a->unknown_count, n = a->node_count;
  int32_t *head = scratch, *size = head + unknowns + 1, *met = size + unknowns, *offset = met + unknowns;
  int32_t *list = offset + unknowns, *place = list + unknowns;
  int64_t total = 0;
  list_places(a, head, place, size);
  memset(met, -1, sizeof *met * (size_t)unknowns);
  memset(a->begins, 0, sizeof *a->begins * ((size_t)unknowns + 1));
  for (int32_t u = 0; u < unknowns; ++u) {
    int32_t count = 0, length = 0;
    if (head[u] == head[u + 1]) continue;
    for (int32_t k = head[u]; k < head[u + 1]; ++k) {
      const int32_t *nodes = a->nodes + (int64_t)(place[k] / n) * n;
      for (int32_t i = 0; i < n; ++i) {
        if (met[nodes[i]] == u) continue;
        met[nodes[i]] = u;
        list[count++] = nodes[i];
      }
    }
    sort(list, count);
    for (int32_t i = 0; i < count; ++i) {
      offset[list[i]] = length;
      length += size[list[i]];
    }
    for (int32_t k = head[u]; k < head[u + 1]; ++k) {
      const int32_t *nodes = a->nodes + (int64_t)(place[k] / n) * n;
      for (int32_t i = 0; i < n; ++i) a->offsets[(int64_t)place[k] * n + i] = offset[nodes[i]];
    }
    for (int32_t i = 0; i < size[u]; ++i) a->begins[u + i + 1] = length;
    total += (int64_t)length * size[u];
  }
  if (total > INT32_MAX) return total;
  for (int32_t u = 0; u < unknowns; ++u) a->begins[u + 1] += a->begins[u];
  return total;
}

void lamc_assembly_rows(const lamc_assembly *a, int32_t *rows) {
  const int32_t n = a->node_count;
  for (int64_t k = 0; k < a->cell_count * n; ++k) {
    const int32_t u = a->nodes[k];
    const int32_t *nodes = a->nodes + k / n * n;
    for (int32_t j = 0; j < a->node_size[k % n]; ++j) {
      for (int32_t i = 0; i < n; ++i) {
        int32_t *row = rows + a->begins[u + j] + a->offsets[k * n + i];
        for (int32_t d = 0; d < a->node_size[i]; ++d) row[d] = nodes[i] + d;
      }
    }
  }
}
