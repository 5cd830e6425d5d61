"""A square plate in CalculiX: clamped all around under pressure, of triangles S6.

In: how many squares along a side, each cut into two triangles. Out: seconds from the deck to the deflection, and the
deflection at the centre. CalculiX makes solids of shells; it shares nothing with lamc.
"""

import os
import shutil
import subprocess
import time
from dataclasses import dataclass
from pathlib import Path


@dataclass(frozen=True)
class Plate:
    """Side and thickness, m; Young's modulus, Pa; Poisson's ratio; pressure, Pa."""

    side: float = 1.0
    thickness: float = 1e-2
    young: float = 70e9
    poisson: float = 0.3
    pressure: float = 1e3

    @property
    def expected(self) -> float:
        """Deflection of the centre, m; 0.00126532 of Timoshenko and Woinowsky-Krieger, table 35, to six digits."""
        bending = self.young * self.thickness**3 / (12 * (1 - self.poisson**2))
        return 0.00126532 * self.pressure * self.side**4 / bending


def is_there() -> bool:
    return shutil.which("ccx") is not None


def run(plate: Plate, squares: int, folder: Path) -> tuple[float, float]:
    """Seconds of wall time on one thread, and the centre's deflection, m. `squares` must be even."""
    (folder / "plate.inp").write_text(_deck(plate, squares), encoding="ascii")
    environment = {**os.environ, "OMP_NUM_THREADS": "1", "CCX_NPROC_EQUATION_SOLVER": "1"}
    started = time.perf_counter()
    subprocess.run(["ccx", "plate"], cwd=folder, env=environment, capture_output=True, check=True)
    seconds = time.perf_counter() - started
    last = [line for line in (folder / "plate.dat").read_text().splitlines() if line.strip()][-1]
    return seconds, abs(float(last.split()[-1]))


def _deck(plate: Plate, squares: int) -> str:
    """Nodes at corners and middles of edges: a grid of 2 squares + 1 points along each side."""
    count = 2 * squares + 1
    step = plate.side / (count - 1)
    lines = ["*NODE, NSET=ALL"]
    lines += [
        f"{j * count + i + 1}, {i * step!r}, {j * step!r}, 0.0" for j in range(count) for i in range(count)
    ]
    lines.append("*ELEMENT, TYPE=S6, ELSET=PLATE")
    number = 0
    for j in range(0, count - 1, 2):
        for i in range(0, count - 1, 2):
            for corners in (((0, 0), (2, 0), (2, 2)), ((0, 0), (2, 2), (0, 2))):
                middles = [
                    ((p[0] + q[0]) // 2, (p[1] + q[1]) // 2)
                    for p, q in zip(corners, (*corners[1:], corners[0]), strict=True)
                ]
                nodes = [(j + b) * count + i + a + 1 for a, b in (*corners, *middles)]
                number += 1
                lines.append(f"{number}, {', '.join(map(str, nodes))}")
    rim = [
        j * count + i + 1 for j in range(count) for i in range(count) if 0 in (i, j) or count - 1 in (i, j)
    ]
    lines += ["*NSET, NSET=RIM", *(f"{node}," for node in rim)]
    centre = (count // 2) * count + count // 2 + 1
    lines += [
        "*NSET, NSET=CENTRE",
        f"{centre},",
        "*BOUNDARY",
        "RIM, 1, 6",
        "*MATERIAL, NAME=M",
        "*ELASTIC",
        f"{plate.young!r}, {plate.poisson!r}",
        "*SHELL SECTION, ELSET=PLATE, MATERIAL=M",
        f"{plate.thickness!r}",
        "*STEP",
        "*STATIC",
        "*DLOAD",
        f"PLATE, P, {plate.pressure!r}",
        "*NODE PRINT, NSET=CENTRE",
        "U",
        "*END STEP",
        "",
    ]
    return "\n".join(lines)
