"""The C of finite elements as C: strict compilers, C++, sanitizers, the same bytes always, the cache."""

import subprocess
import threading
import time
from pathlib import Path

import numpy as np
import pytest
import sympy as sp

from lamc.codegen import emit_element
from lamc.codegen.build import write_sources
from lamc.codegen.emit import SourceTree
from lamc.plates.elements import build as element_build
from lamc.plates.elements.definition import Element, side, xi
from lamc.plates.elements.kernels import kernels
from lamc.plates.elements.library import ELEMENTS, element
from tests.plates.test_plate_kernels import cells, inputs
from tests.support.ctools import STRICT, STRICT_CXX, cc, needs_cc, objects_of, sanitizer_works
from tests.unit.test_sanitizers import FLAGS

pytestmark = needs_cc

# Arrays live on the heap and have exactly the size that the header states, so that one step beyond is seen.
_DRIVER = """
#include "@.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

static double *vector(int64_t count, double scale) {
  double *v = malloc(sizeof(double) * (size_t)(count > 0 ? count : 1));
  if (v == NULL) exit(9);
  for (int64_t i = 0; i < count; ++i) v[i] = scale * (0.3 * (double)(i % 7) + 0.1);
  return v;
}

static int32_t *integers(int64_t count) {
  int32_t *v = malloc(sizeof *v * (size_t)(count > 0 ? count : 1));
  if (v == NULL) exit(9);
  return v;
}

/* A fan of m cells about point 0, each with points of its own besides the one that it shares with the next; cells of
 * four corners are kites. Nodes are numbered as the points are, those on edges and inside are each cell's own. */
static double assembled(const lamc_element *e, int m, const int32_t *sizes) {
  const int c = e->corner_count, n = e->node_count, per_cell = n - 2, unknowns_each = 6;
  const int points = 1 + m * (c - 2);
  lamc_assembly a = {m, n, 0, sizes, NULL, NULL, NULL, NULL, NULL};
  double *xy = vector(2 * points, 1.0), sum = 0.0;
  int32_t *corner = integers(m * c), *nodes = integers((int64_t)m * n), *row = integers(m);
  xy[0] = xy[1] = 0.0;
  for (int i = 0; i < m; ++i) {
    for (int k = 0; k < c - 2; ++k) {
      const double angle = 6.283185307179586 * (i + k / (double)(c - 2)) / m;
      xy[2 * (1 + i * (c - 2) + k)] = cos(angle);
      xy[2 * (1 + i * (c - 2) + k) + 1] = sin(angle);
    }
    corner[c * i] = 0;
    for (int k = 0; k < c - 1; ++k) corner[c * i + 1 + k] = 1 + (i * (c - 2) + k) % (m * (c - 2));
    row[i] = i % 2;
    nodes[n * i] = 0;
    for (int k = 1; k < n; ++k) nodes[n * i + k] = unknowns_each * (1 + per_cell * i + (k - 1) % per_cell);
    nodes[n * i + n - 1] = unknowns_each * (1 + per_cell * ((i + 1) % m));
  }
  a.unknown_count = unknowns_each * (1 + per_cell * m);
  a.points = xy, a.cells = corner, a.nodes = nodes;
  a.begins = integers(a.unknown_count + 1), a.offsets = integers((int64_t)m * n * n);
  int32_t *scratch = integers(lamc_assembly_scratch(&a));
  const int64_t entries = lamc_assembly_begin(&a, scratch);
  int32_t *rows = integers(entries);
  double *values = vector(entries, 0.0), *table = vector(2 * e->section_count, 1.0);
  if (a.begins[a.unknown_count] != entries) exit(5);
  lamc_assembly_rows(&a, rows);
  for (int32_t u = 0; u < a.unknown_count; ++u) {
    for (int32_t k = a.begins[u] + 1; k < a.begins[u + 1]; ++k) {
      if (rows[k - 1] >= rows[k]) exit(6);
    }
  }
  e->assemble_stiffness(&a, table, row, values);
  e->assemble_mass(&a, table, row, values);
  if (e->assemble_geometric != NULL) e->assemble_geometric(&a, table, row, values);
  double *u = vector(a.unknown_count, 1.0), *forces = vector(a.unknown_count, 0.0);
  long double *long_u = malloc(sizeof(long double) * (size_t)a.unknown_count);
  long double *long_forces = malloc(sizeof(long double) * (size_t)a.unknown_count);
  if (long_u == NULL || long_forces == NULL) exit(9);
  for (int32_t i = 0; i < a.unknown_count; ++i) long_u[i] = (long double)u[i], long_forces[i] = 0.0L;
  e->assemble_force(&a, table, row, u, forces);
  e->assemble_force_extended(&a, table, row, long_u, long_forces);
  for (int32_t i = 0; i < a.unknown_count; ++i) sum += forces[i] + (double)long_forces[i];
  free(u); free(forces); free(long_u); free(long_forces);
  for (int64_t i = 0; i < entries; ++i) sum += values[i];
  free(xy); free(corner); free(nodes); free(row); free(a.begins); free(a.offsets);
  free(scratch); free(rows); free(values); free(table);
  return sum;
}

int main(void) {
  const lamc_element *e = @_element();
  const int32_t sizes[] = {#};
  const int d = e->unknown_count, s = e->section_count;
  for (int m = 0; m < 4; ++m) {
    double *xy = vector(2 * m * e->corner_count, 1.0), *section = vector(m * s, 1.0), *u = vector(m * d, 1.0);
    double *rho = vector(m, 1.0), *n = vector(3 * m, 1.0), *r = vector(m * e->strain_count, 1.0);
    double *f = vector(m * e->field_count * e->corner_count, 1.0), *at = vector(2 * m, 0.3);
    double *matrix = vector(m * d * d, 0.0), *out = vector(m * d, 0.0);
    double *strain = vector(m * e->strain_count, 0.0), *value = vector(m * e->value_count, 0.0);
    long double *long_xy = malloc(sizeof(long double) * (size_t)(2 * m * e->corner_count + 1));
    long double *long_s = malloc(sizeof(long double) * (size_t)(m * s + 1));
    long double *long_u = malloc(sizeof(long double) * (size_t)(m * d + 1));
    long double *long_out = malloc(sizeof(long double) * (size_t)(m * d + 1));
    if (long_xy == NULL || long_s == NULL || long_u == NULL || long_out == NULL) return 9;
    for (int i = 0; i < 2 * m * e->corner_count; ++i) long_xy[i] = (long double)xy[i];
    for (int i = 0; i < m * s; ++i) long_s[i] = (long double)section[i];
    for (int i = 0; i < m * d; ++i) long_u[i] = (long double)u[i];
    e->stiffness(m, xy, section, matrix);
    e->mass(m, xy, rho, matrix);
    if (e->geometric != NULL) e->geometric(m, xy, n, matrix);
    e->load(m, xy, f, out);
    e->prestress(m, xy, r, out);
    e->strain(m, xy, at, u, strain);
    e->displacement(m, xy, at, u, value);
    e->force(m, xy, section, u, out);
    e->force_extended(m, long_xy, long_s, long_u, long_out);
    free(xy); free(section); free(u); free(rho); free(n); free(r); free(f); free(at); free(matrix); free(out);
    free(strain); free(value); free(long_xy); free(long_s); free(long_u); free(long_out);
  }
  printf("%s %g %g\\n", e->name, assembled(e, 5, sizes), assembled(e, 150, sizes));
  return 0;
}
"""


def sources(name: str, folder: Path) -> SourceTree:
    program = element_build.element_program(element(name))
    tree = emit_element.emit_element(program)
    write_sources(tree, folder)
    sizes = ", ".join(str(len(node)) for node in program.nodes)
    (folder / "driver.c").write_text(_DRIVER.replace("@", tree.prefix).replace("#}", f"{sizes}}}"))
    return tree


# Triangles and squares, nodes on corners and on edges, sums over points, reciprocals of lengths.
SANITIZED = ("bfs", "dkt", "lst", "q8")


@pytest.mark.parametrize("name", SANITIZED)
@pytest.mark.quick("dkt", others="campaign")
def test_generated_c_runs_clean_under_sanitizers(name: str, tmp_path: Path) -> None:
    if not sanitizer_works(tmp_path, *FLAGS):
        pytest.skip("this compiler has no address and undefined-behaviour sanitizers")
    tree = sources(name, tmp_path)
    cc(tmp_path, *FLAGS, "driver.c", *objects_of(tree, tmp_path, *FLAGS), "-lm", "-o", "driver")
    done = subprocess.run([tmp_path / "driver"], capture_output=True, text=True, timeout=120, check=False)
    assert done.returncode == 0, done.stderr[:3000]
    assert done.stderr == ""


@pytest.mark.parametrize("name", sorted(ELEMENTS))
@pytest.mark.quick("cst", "dkt", "lst", "q4", "specht", others="campaign")
def test_generated_c_pleases_a_strict_compiler(name: str, tmp_path: Path) -> None:
    tree = sources(name, tmp_path)
    objects_of(tree, tmp_path, *STRICT)
    (tmp_path / "alone.c").write_text(f'#include "{tree.prefix}.h"\nint main(void) {{ return 0; }}\n')
    cc(tmp_path, *STRICT, "-c", "alone.c")
    cc(tmp_path, "-x", "c++", *STRICT_CXX, "-fsyntax-only", "alone.c")


def test_one_lane_gives_the_bits_of_several(tmp_path: Path) -> None:
    """Compilers without vectors take the other branch; it is the same arithmetic."""
    tree = sources("dkt", tmp_path)
    text = (tmp_path / "dkt.c").read_text()
    assert "#if defined(__GNUC__)" in text
    (tmp_path / "dkt.c").write_text(text.replace("#if defined(__GNUC__)", "#if 0"))
    flags = [f for f in STRICT if f != "-Wpedantic"]
    cc(tmp_path, *flags, "-O2", "-ffp-contract=off", "-fPIC", "-shared", *tree.compiled, "-o", "one.so")
    made = kernels("dkt")
    ffi = made.evaluator.module.ffi  # type: ignore[attr-defined]
    lib = ffi.dlopen(str(tmp_path / "one.so"))
    corners, (sections,) = cells("dkt", 5), inputs(made, 5)["stiffness"]
    out = np.zeros((5, 9, 9))
    lib.dkt_stiffness(
        5, *(ffi.from_buffer("double[]", np.ascontiguousarray(a)) for a in (corners, sections, out))
    )
    assert np.array_equal(out, made.stiffness(corners, sections))


def test_long_functions_become_parts_with_the_same_bits(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """gcc's time grows faster than a block's length, so that one beyond the limit is cut; its numbers are the same."""
    made = kernels("bciz")
    monkeypatch.setenv("LAMC_CACHE_DIR", str(tmp_path / "cache"))
    monkeypatch.setattr(emit_element, "MAX_BLOCK", 50)
    cut = kernels("bciz")
    text = (cut.source_dir / "bciz_equations.h").read_text()
    assert "OF(stiffness_part_0)" in text
    corners = cells("bciz", 5)
    for function, arguments in inputs(made, 5).items():
        expected = getattr(made, function)(corners, *arguments)
        assert np.array_equal(getattr(cut, function)(corners, *arguments), expected), function
    section, d = inputs(made, 5)["force"]
    assert np.array_equal(
        cut.force(corners, section, d, np.longdouble), made.force(corners, section, d, np.longdouble)
    )


def test_library_functions_are_called_for_one_cell_at_a_time() -> None:
    """Constant strain with shape functions times the first side's length, squared, over its square: one, by a root."""
    cst, length, inverse = ELEMENTS["cst"], sp.Symbol("length"), sp.Symbol("inverse")
    square = side("x", 2, 1) ** 2 + side("y", 2, 1) ** 2
    rooted = Element(
        "rooted",
        cst.cell,
        cst.nodes,
        u=[length**2 * inverse * n for n in cst.u],
        v=[length**2 * inverse * n for n in cst.v],
        geometry={length: sp.sqrt(square), inverse: 1 / square},
    )
    made = kernels(rooted)
    text = (made.source_dir / "rooted.c").read_text()
    assert "#include <tgmath.h>" in text
    corners, (sections,) = cells("cst", 5), inputs(made, 5)["stiffness"]
    found, expected = made.stiffness(corners, sections), kernels("cst").stiffness(corners, sections)
    assert np.abs(found - expected).max() <= 4e-15 * np.abs(expected).max()  # some ten roundings more
    assert np.array_equal(found, kernels(rooted, "interpreted").stiffness(corners, sections))


def test_an_element_from_the_cache_is_not_derived_again(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("LAMC_CACHE_DIR", str(tmp_path / "cache"))
    first = kernels("cst")
    entries = sorted(p.name for p in (tmp_path / "cache").iterdir())

    def refuse(_: Element) -> None:
        raise AssertionError("derived although the cache has it")

    monkeypatch.setattr(element_build, "element_program", refuse)
    again = kernels("cst")
    corners, (sections,) = cells("cst", 3), inputs(first, 3)["stiffness"]
    assert np.array_equal(again.stiffness(corners, sections), first.stiffness(corners, sections))
    assert sorted(p.name for p in (tmp_path / "cache").iterdir()) == entries


def test_a_damaged_entry_is_built_anew(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("LAMC_CACHE_DIR", str(tmp_path / "cache"))
    kernels("cst")
    for library in (tmp_path / "cache").glob("*/model.so"):
        library.unlink()  # this process has the old one mapped
        library.write_bytes(b"no library")
    made = kernels("cst")
    assert made.stiffness(cells("cst", 1), inputs(made, 1)["stiffness"][0]).shape == (1, 6, 6)


def test_other_elements_of_one_name_have_entries_of_their_own() -> None:
    """A user's element may be called as one of lamc's: what counts is what it is."""
    cst = ELEMENTS["cst"]
    skewed = Element(
        "cst", cst.cell, cst.nodes, u=[2 * sp.sympify(n) for n in cst.u], v=[2 * sp.sympify(n) for n in cst.v]
    )
    assert xi in sp.sympify(cst.u[2]).free_symbols
    key = {element_build.alias_of(e, "compiler", ()) for e in (cst, skewed)}
    assert len(key) == 2


def test_other_threads_run_while_c_works() -> None:
    """A second thread counts on while cells are computed; with the GIL held it would stand still."""
    made = kernels("dkt")
    count = 300_000
    corners = np.tile(cells("dkt", 1), (count, 1, 1))
    sections = np.tile(inputs(made, 1)["stiffness"][0], (count, 1))
    ticks, done = [], threading.Event()

    def tick() -> None:
        while not done.is_set():
            ticks.append(time.perf_counter())
            time.sleep(1e-4)

    thread = threading.Thread(target=tick)
    thread.start()
    started = time.perf_counter()
    function = made.evaluator.handle.stiffness  # type: ignore[attr-defined]
    address = made.evaluator.address  # type: ignore[attr-defined]
    out = np.zeros((count, 9, 9))
    started = time.perf_counter()
    function(count, address(np.ascontiguousarray(corners)), address(sections), address(out))
    ended = time.perf_counter()
    done.set()
    thread.join()
    assert sum(started < t < ended for t in ticks) > 3
