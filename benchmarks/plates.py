"""Plates: what elements, assembly and solving cost, on one thread.

    python -m benchmarks.plates [--quick] [--out FOLDER]

Beside scikit-fem's Morley triangles (the bench extra) and CalculiX (where `ccx` is installed), in the same run. CHOLMOD
has rows where scikit-sparse is. Each figure is the shortest of several repeats; what is measured once says so.
Prints tables and writes JSON.
"""

import argparse
import os
import sys
import tempfile
import time
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from shapely.geometry import LineString, Point, box

from benchmarks.measure import environment, interleaved, write_json
from benchmarks.peers import ccx_peer
from benchmarks.spine import Rows, fresh_folder, show, target, timed
from lamc import plate
from lamc.codegen.emit_element import MATRICES
from lamc.plates.answers.model import FactoredPlate
from lamc.plates.dofs import Dofs
from lamc.plates.elements.build import element_program
from lamc.plates.elements.kernels import kernels
from lamc.plates.memory import estimate_memory
from lamc.plates.meshing.mesh import Mesh
from lamc.plates.solving.assembly import Assembly
from lamc.plates.solving.solvers import cholmod_is_fast

try:
    from benchmarks.peers import skfem_peer
except ImportError:  # the bench extra is not installed; its rows are left out
    skfem_peer = None  # type: ignore[assignment]

ONE_THREAD = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), "1")
BENDING = ("bciz", "dkt", "specht")
BATCH = 1000  # cells per call: corners, sections and matrices stay in the cache
POISSON = 0.3
ISOTROPIC = np.array([[1.0, POISSON, 0.0, 1.0, 0.0, (1 - POISSON) / 2]])  # D in units of its D_11
ALUMINIUM = plate.Material(E1=70e9, E2=70e9, nu12=POISSON, G12=70e9 / (2 * (1 + POISSON)), density=2700.0)
LARGE, SMALL = 200_000, 20_000  # triangles; SMALL with --quick
LIMITS = {"cholmod": 5.0, "superlu": 25.0}  # s from polygon to deflection at LARGE


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quick", action="store_true", help="few repeats, a tenth of the triangles")
    parser.add_argument("--out", type=Path, default=Path(__file__).parent / "results")
    arguments = parser.parse_args()
    if any(os.environ.get(name) != "1" for name in ONE_THREAD):  # BLAS reads them when it is loaded
        command = [sys.executable, "-m", "benchmarks.plates", *sys.argv[1:]]
        os.execve(sys.executable, command, {**os.environ, **ONE_THREAD})
    repeats, triangles = (3, SMALL) if arguments.quick else (9, LARGE)
    report: dict[str, Any] = {"environment": environment(), "triangles": triangles}
    with fresh_folder():
        report["elements"] = show("Elements: operations, and time in batches", elements(repeats))
        report["assembly"] = show("Stiffness matrix of a mesh", assemblies(triangles, repeats))
        title = "From polygon to deflection, clamped plate with a hole under pressure; once, s"
        report["solving"] = show(title, solving(triangles))
        report["hinges"] = show("What hinge lines cost, SuperLU; s", hinged(triangles // 10, repeats // 3))
        if ccx_peer.is_there():
            report["calculix"] = show(
                "Clamped square beside CalculiX; once", beside_calculix(arguments.quick)
            )
    report["targets"] = show("Targets", targets(report))
    write_json(arguments.out / "plates.json", report)


def elements(repeats: int) -> Rows:
    """Every element: seconds from shape functions to a loaded library, operations per cell, time per cell."""
    rows = []
    for name, element in plate.ELEMENTS.items():
        building, made = timed(partial(kernels, element))
        program = element_program(element)
        corners = np.tile(_cell(made.corner_count), (BATCH, 1, 1))
        sections = np.tile(_section(made.section_count), (BATCH, 1))
        jobs = {"stiffness": partial(made.stiffness, corners, sections)}
        jobs["mass"] = partial(made.mass, corners, np.ones(BATCH))
        best = interleaved(jobs, repeats)
        row: dict[str, Any] = {"element": name, "build s": building}
        for function in MATRICES:
            made_of = program.functions.get(function)
            points = max(len(program.points.get(function, ())), 1)
            row[f"{function} ops"] = points * made_of.operations.flops if made_of else "-"
        rows.append({**row, **{f"{job} ns": seconds / BATCH * 1e9 for job, seconds in best.items()}})
    return rows


def _cell(corners: int) -> np.ndarray:
    """A triangle of no special shape; a rectangle, which all quadrilaterals take."""
    if corners == 3:
        return np.array([[0.0, 0.0], [1.1e-3, 0.1e-3], [0.2e-3, 0.9e-3]])
    return np.array([[0.0, 0.0], [1.1e-3, 0.0], [1.1e-3, 0.9e-3], [0.0, 0.9e-3]])


def _section(count: int) -> np.ndarray:
    """Isotropic, in the middle of the plate: no B."""
    return ISOTROPIC[0] if count == 6 else np.concatenate([ISOTROPIC[0], np.zeros(6), ISOTROPIC[0]])


def assemblies(triangles: int, repeats: int) -> Rows:
    """The pattern (scikit-fem: the basis), once; then values. On a grid, and on what the mesher makes."""
    side = round((triangles / 2) ** 0.5)
    meshes = {"grid": plate.grid(1.0, 1.0, side, side), "triangulation": plate.mesh(*_holed(triangles))}
    rows = []
    for name, mesh in meshes.items():
        for element in BENDING:
            rows.append(_assembly_row(name, element, mesh, repeats))
        if skfem_peer is not None:
            rows.append(_skfem_row(name, mesh, repeats))
    return rows


def _assembly_row(name: str, element: str, mesh: Mesh, repeats: int) -> dict[str, Any]:
    made = kernels(element)
    dofs = Dofs(mesh, made.element)
    preparing, assembly = timed(partial(Assembly, made, mesh, dofs))
    seconds = interleaved({"values": partial(assembly.stiffness, ISOTROPIC)}, repeats)["values"]
    guessed = estimate_memory(made.element, len(mesh.cells))
    matrix = assembly.stiffness(ISOTROPIC)
    taken = matrix.data.nbytes + matrix.indices.nbytes + matrix.indptr.nbytes
    return {
        "mesh": name,
        "element": element,
        "triangles": len(mesh.cells),
        "pattern s": preparing,
        "values s": seconds,
        "1e6 triangles/s": len(mesh.cells) / seconds * 1e-6,
        "matrix MB": taken * 1e-6,
        "MB guessed": guessed.matrix * 1e-6,
    }


def _skfem_row(name: str, mesh: Mesh, repeats: int) -> dict[str, Any]:
    preparing, peer = timed(partial(skfem_peer.MorleyPlate, mesh.points, mesh.cells, POISSON))
    seconds = min(timed(peer.assemble)[0] for _ in range(min(repeats, 3)))
    return {
        "mesh": name,
        "element": "scikit-fem, Morley",
        "triangles": len(mesh.cells),
        "pattern s": preparing,
        "values s": seconds,
        "1e6 triangles/s": len(mesh.cells) / seconds * 1e-6,
        "matrix MB": "-",
        "MB guessed": "-",
    }


def _holed(triangles: int) -> tuple[Any, float]:
    """A square of 0.1 m with a hole, and the size of triangles that gives about so many."""
    outline = box(0.0, 0.0, 0.1, 0.1).difference(Point(0.05, 0.05).buffer(0.01, quad_segs=32))
    return outline, float((HOLED_SHAPE * outline.area / triangles) ** 0.5)


HOLED_SHAPE = 3.0  # area of a square of the mesher's size over that of its mean triangle, on this outline


def solving(triangles: int) -> Rows:
    """Each solver that is there: every step from the polygon to the deflection; another load; another laminate."""
    outline, size = _holed(triangles)
    laminate = plate.Laminate([plate.Ply(ALUMINIUM, 1e-3, 0.0)])
    rows = []
    for solver in ("cholmod", "superlu"):
        if solver == "cholmod" and not cholmod_is_fast():
            continue
        kernels("dkt")  # compiled: a user meets this once
        started = time.perf_counter()
        meshing, mesh = timed(partial(plate.mesh, outline, size))
        stating, problem = timed(
            partial(
                plate.Problem,
                mesh,
                laminate,
                supports=[plate.Clamped(outline.exterior)],
                loads=[plate.Pressure(1e3)],
            )
        )
        preparing, model = timed(partial(FactoredPlate, problem, solver))
        assembling, _ = timed(lambda model=model: model.system.stiffness)
        factoring, _ = timed(lambda model=model: model.system.factor)
        answering, solution = timed(model.solve)
        deflection = float(np.max(solution.deflection(*_near_hole())))
        total = time.perf_counter() - started
        again, _ = timed(partial(model.solve, [plate.PointLoad((0.03, 0.03), 1.0)]))
        thicker = plate.Laminate([plate.Ply(ALUMINIUM, 1.1e-3, 0.0)])
        other, _ = timed(lambda model=model, thicker=thicker: model.with_laminates(thicker).solve())
        rows.append(
            {
                "solver": solver,
                "triangles": len(mesh.cells),
                "mesh": meshing,
                "problem": stating,
                "pattern": preparing,
                "values": assembling,
                "factor": factoring,
                "solve": answering,
                "total": total,
                "other load": again,
                "other laminate": other,
                "deflection m": deflection,
                "forward error": solution.report.accuracy.forward_error,
            }
        )
    return rows


def hinged(triangles: int, repeats: int) -> Rows:
    """A clamped square that lines across fold in equal panels: processor time from the problem to the deflection."""
    side = 20 * round((triangles / 2) ** 0.5 / 20)  # a multiple of all numbers of panels
    mesh = plate.grid(1.0, 1.0, side, side)
    laminate = plate.Laminate([plate.Ply(ALUMINIUM, 10e-3, 0.0)])
    rows: Rows = []
    for count in (0, 1, 4, 19):
        places = [LineString([(k / (count + 1), 0.0), (k / (count + 1), 1.0)]) for k in range(1, count + 1)]
        seconds = []
        for _ in range(repeats + 1):  # the first also loads what a process loads once
            started = time.process_time()
            problem = plate.Problem(
                mesh,
                laminate,
                supports=[plate.Clamped("boundary")],
                loads=[plate.Pressure(1e3)],
                hinges=[plate.HingeLine(line, 100.0) for line in places],
            )
            FactoredPlate(problem, "superlu").solve()
            seconds.append(time.process_time() - started)
        best = min(seconds)
        first = rows[0]["s"] if rows else best
        rows.append(
            {
                "lines": count,
                "triangles": len(mesh.cells),
                "unknowns": problem.dofs.count,
                "s": best,
                "times none": best / first,
            }
        )
    return rows


def _near_hole() -> tuple[np.ndarray, np.ndarray]:
    angle = np.linspace(0.0, 2 * np.pi, 16, endpoint=False)
    return 0.05 + 0.0101 * np.cos(angle), 0.05 + 0.0101 * np.sin(angle)


def beside_calculix(quick: bool) -> Rows:
    """A clamped square under pressure on one diagonal grid: S6 and DKT on the same triangles."""
    rows = []
    case = ccx_peer.Plate()
    material = plate.Material(
        E1=case.young,
        E2=case.young,
        nu12=case.poisson,
        G12=case.young / (2 * (1 + case.poisson)),
        density=1.0,
    )
    laminate = plate.Laminate([plate.Ply(material, case.thickness, 0.0)])
    for squares in (10, 20) if quick else (10, 20, 40):

        def own(squares: int = squares) -> float:
            mesh = plate.grid(case.side, case.side, squares, squares)
            held, load = [plate.Clamped("boundary")], [plate.Pressure(case.pressure)]
            solution = plate.solve(plate.Problem(mesh, laminate, supports=held, loads=load))
            return float(solution.deflection(case.side / 2, case.side / 2))

        seconds, deflection = timed(own)
        with tempfile.TemporaryDirectory() as folder:
            peer_seconds, peer_deflection = ccx_peer.run(case, squares, Path(folder))
        rows.append(
            {
                "triangles": 2 * squares**2,
                "lamc s": seconds,
                "ccx s": peer_seconds,
                "ratio": peer_seconds / seconds,
                "lamc error": abs(abs(deflection) / case.expected - 1),
                "ccx error": abs(peer_deflection / case.expected - 1),
            }
        )
    return rows


def targets(report: dict[str, Any]) -> Rows:
    """What was set out to reach, and what this run found. Limits of solving are for LARGE, scaled to the mesh."""
    rows: Rows = []
    by_name = {row["element"]: row for row in report["elements"]}
    rows.append(target("bciz: operations", by_name["bciz"]["stiffness ops"], 1450, at_most=True))
    rows.append(target("bciz: element, ns", by_name["bciz"]["stiffness ns"], 260.0, at_most=True))
    rows.append(target("dkt: operations", by_name["dkt"]["stiffness ops"], 1900, at_most=True))
    for mesh in ("grid", "triangulation"):
        found = {row["element"]: row for row in report["assembly"] if row["mesh"] == mesh}
        for element in BENDING:
            speed = found[element]["1e6 triangles/s"]
            rows.append(target(f"{mesh}, {element}: 1e6 triangles/s", speed, 3.0, at_most=False))
        peer = found.get("scikit-fem, Morley")
        if peer is not None:
            # From corners to entries: scikit-fem's shape functions are in its basis, lamc's in every assembly.
            ratio = (peer["pattern s"] + peer["values s"]) / found["dkt"]["values s"]
            rows.append(target(f"{mesh}: scikit-fem / dkt, corners to entries", ratio, 100.0, at_most=False))
    for row in report["solving"] if report["triangles"] == LARGE else ():
        scale = row["triangles"] / LARGE
        name = f"{row['solver']}, {row['triangles']} triangles"
        rows.append(target(f"{name}: total, s", row["total"], scale * LIMITS[row["solver"]], at_most=True))
        rows.append(target(f"{name}: other load, s", row["other load"], scale * 1.5, at_most=True))
    return rows


if __name__ == "__main__":
    main()
