"""How much too flexible BCIZ's plates become on ever finer meshes: what `lamc.plates.meshing.report` tells.

Square plates, simply supported and clamped, uniform pressure and a force in the middle; the deflection there over that
of the series, less 1, on 20 and 40 cells a side, and continued to no size with second order. `python -m
benchmarks.bciz_bias`.
"""

from shapely.geometry import box

from lamc import plate

NU = 0.3
LAMINATE = plate.Laminate([plate.Ply(plate.Material.isotropic(12 * (1 - NU**2), NU, 1.0), 1.0)])  # D = 1 N·m
SUPPORTS = {"simple": plate.SimplySupported, "clamped": plate.Clamped}
LOADS = {"uniform": plate.Pressure(1.0), "point": plate.PointLoad((0.5, 0.5), 1.0)}
# Deflection in the middle for a side, D and load of 1: S. Timoshenko, S. Woinowsky-Krieger, Theory of Plates and
# Shells, 1959, tables 8, 23, 35 and 37, to more digits from their series.
EXACT = {
    ("simple", "uniform"): 4.06235e-3,
    ("clamped", "uniform"): 1.26532e-3,
    ("simple", "point"): 1.16008e-2,
    ("clamped", "point"): 5.6120e-3,
}
COUNTS = (20, 40)
MESHES = ("one-diagonal", "criss-cross", "union-jack", "jittered", "mesher")


def mesh_of(kind: str, count: int) -> plate.Mesh:
    """Of the unit square, some `count` cells a side."""
    if kind == "mesher":
        return plate.mesh(box(0, 0, 1, 1), 1.0 / count)
    if kind == "jittered":
        return plate.jittered(plate.grid(1.0, 1.0, count, count), 0.25)
    return plate.grid(1.0, 1.0, count, count, kind)


def bias(kind: str, support: str, load: str) -> tuple[float, ...]:
    """On each of COUNTS, then continued."""
    off = []
    for count in COUNTS:
        problem = plate.Problem(
            mesh_of(kind, count), LAMINATE, "bciz", [SUPPORTS[support]("boundary")], [LOADS[load]]
        )
        found = plate.solve(problem)
        assert isinstance(found, plate.Solution)
        off.append(float(abs(found.deflection(0.5, 0.5))) / EXACT[support, load] - 1.0)
    return (*off, off[1] + (off[1] - off[0]) / 3.0)


def main() -> None:
    """Prints a line for each mesh, support and load, in percent."""
    print(f"{'mesh':<14}{'support':<10}{'load':<9}" + "".join(f"{n:>8}" for n in COUNTS) + f"{'limit':>8}")
    for kind in MESHES:
        for support, load in EXACT:
            values = "".join(f"{100.0 * part:8.2f}" for part in bias(kind, support, load))
            print(f"{kind:<14}{support:<10}{load:<9}{values}")


if __name__ == "__main__":
    main()
