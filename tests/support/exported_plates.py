"""Plates of every kind as exported C, and the C as functions of arrays."""

import ctypes
import re
from functools import cache
from pathlib import Path

import numpy as np
import numpy.typing as npt
import shapely

import lamc
from lamc import plate
from lamc.export import files_of
from lamc.plates.problem import Problem
from tests.support.exported_folders import cc, put

Array = npt.NDArray[np.float64]
CFRP = plate.Material(E1=150e9, E2=9e9, nu12=0.3, G12=5e9, density=1600.0, name="cfrp")
STEEL = plate.Material.isotropic(E=200e9, nu=0.3, density=7850.0, name="steel")
GRAPHITE = plate.Material(
    181e9,
    10.3e9,
    0.28,
    7.17e9,
    1600.0,
    alpha1=0.02e-6,
    alpha2=22.5e-6,
    beta1=0.0,
    beta2=0.6,
    name="T300/5208",
)
PZT = plate.Material(61e9, 61e9, 0.35, 22.6e9, 7750.0, 2e-6, 3e-6, d31=-171e-12, d32=-150e-12, name="PZT")
SIDE = 0.2  # m


def _square() -> Problem:
    """Simply supported, uniform: every unknown is free or held."""
    boundary = shapely.box(0.0, 0.0, SIDE, SIDE).exterior
    return Problem(
        plate.grid(SIDE, SIDE, 16, 16, "one-diagonal"),
        plate.Laminate([plate.Ply(STEEL, 1e-3)]),
        supports=[plate.SimplySupported(boundary)],
        loads=[plate.Pressure(1000.0)],
    )


def _coupled() -> Problem:
    """Bends when it stretches, five unknowns per node; two cases."""
    left = shapely.LineString([(0.0, 0.0), (0.0, 0.1)])
    return Problem(
        plate.grid(0.3, 0.1, 12, 4, "union-jack"),
        plate.Laminate([plate.Ply(CFRP, 1e-3, 30.0), plate.Ply(CFRP, 5e-4, 90.0, gap=2e-4)], "bottom"),
        supports=[plate.Clamped(left)],
        loads=[plate.SelfWeight()],
        cases={
            "tip": [plate.PointLoad((0.3, 0.1), 2.0)],
            "pull": [plate.PointLoad((0.3, 0.05), (50.0, 0, 0))],
        },
    )


def _oblique() -> Problem:
    """Edges at an angle, one of which resists turning, one that is lifted; a hinge line; two regions, and weight."""
    outline = shapely.Polygon([(0.0, 0.0), (0.1, 0.02), (0.12, 0.1), (-0.01, 0.09)])
    corners = list(outline.exterior.coords)
    edges = [shapely.LineString(corners[k : k + 2]) for k in range(4)]
    fold = shapely.intersection(shapely.LineString([(0.05, 0.0), (0.05, 0.1)]), outline)
    patch = shapely.box(0.07, 0.03, 0.1, 0.08)
    mesh = plate.mesh(outline, 0.012, regions={"patch": patch}, follow=[fold])
    thin = plate.Laminate([plate.Ply(CFRP, 3e-4, 15.0)])
    thick = plate.Laminate([plate.Ply(CFRP, 3e-4, 15.0), plate.Ply(STEEL, 2e-4)], 1e-4)
    names = {name: thick if name == "patch" else thin for name in mesh.region_names}
    return Problem(
        mesh,
        names,
        supports=[
            plate.SimplySupported(edges[0]),
            plate.Hinged(edges[1], stiffness=3.0),
            plate.Support(shapely.Point(-0.01, 0.09), ("w",), 1e-4),
        ],
        loads=[plate.SelfWeight(), plate.Pressure(50.0)],
        hinges=[plate.HingeLine(fold, 0.7, name="fold")],
    )


def _squares() -> Problem:
    """Quadrilaterals that are no parallelograms, whose stiffness is a sum over points."""
    mesh = plate.jittered(plate.grid(0.1, 0.1, 4, 4, "squares"), 0.2, seed=3)
    left = shapely.LineString([(0.0, 0.0), (0.0, 0.1)])
    right = shapely.LineString([(0.1, 0.0), (0.1, 0.1)])
    return Problem(
        mesh,
        plate.Laminate([plate.Ply(CFRP, 1e-3, 20.0)]),
        element="q8",
        supports=[plate.Support(left, ("u", "v"))],
        loads=[plate.EdgeLoad(right, (1e4, 2e3, 0.0))],
    )


def _warm() -> Problem:
    """Two regions that warm, swell and have piezoelectric plies, each in its own way; two cases."""
    patch = shapely.box(0.05, 0.0, 0.1, 0.1)
    mesh = plate.grid(0.2, 0.1, 8, 4, "union-jack", regions={"patch": patch})
    thin = plate.Laminate([plate.Ply(GRAPHITE, 2e-4, 10.0), plate.Ply(GRAPHITE, 1e-4, 80.0)])
    thick = plate.Laminate([plate.Ply(GRAPHITE, 2e-4, 10.0), plate.Ply(PZT, 3e-4, -20.0)], "top")
    rest = next(name for name in mesh.region_names if name != "patch")
    return Problem(
        mesh,
        {rest: thin, "patch": thick},
        supports=[plate.Clamped(shapely.LineString([(0.0, 0.0), (0.0, 0.1)]))],
        loads=[plate.Temperature(-80.0), plate.Pressure(3.0)],
        cases={
            "wet": [plate.Moisture(0.008), plate.Moisture(0.004, region="patch")],
            "driven": [plate.ElectricField([0.0, 4e5], region="patch"), plate.Temperature(20.0, region=rest)],
        },
    )


MAKERS = {"warm": _warm, "square": _square, "coupled": _coupled, "oblique": _oblique, "squares": _squares}


@cache
def problem(name: str) -> Problem:
    return MAKERS[name]()


@cache
def exported(name: str, **options: object) -> dict[str, bytes]:
    """Files of an export of prefix `name`."""
    wanted = lamc.ExportOptions(**{"prefix": name, **options})  # type: ignore[arg-type]
    return dict(files_of(problem(name), "c", options=wanted))


class Library:
    """The exported C as a library of this process."""

    def __init__(self, name: str, folder: Path, made: Problem | None = None, **options: object) -> None:
        """Of the plate of MAKERS that has this name, or of `made` under this name."""
        self.name = name
        if made is None:
            self.files = exported(name, **options)
        else:
            self.files = dict(files_of(made, "c", options=lamc.ExportOptions(**{"prefix": name, **options})))  # type: ignore[arg-type]
        put(self.files, folder)
        self.prefix = str(options.get("prefix", name))
        made = f"lib{self.prefix}.so"
        cc(folder, "-std=c99", "-shared", "-fPIC", f"{self.prefix}.c", "-o", made, "-lm")
        self.lib = ctypes.CDLL(str(folder / made))
        header = self.files[f"{self.prefix}.h"].decode()
        self.counts = {
            key: int(value)
            for key, value in re.findall(rf"^  {self.prefix}_(\w+)_count = (\d+)", header, re.M)
        }
        fields = re.findall(rf"^  double (\w+)\[{self.prefix}_(\w+)_count\];", header, re.M)

        class Parameters(ctypes.Structure):
            _fields_ = [
                ("digest", ctypes.c_ubyte * 16),
                *((field, ctypes.c_double * self.counts[count]) for field, count in fields),
            ]

        self.parameters = Parameters()
        self.call("default_parameters", ctypes.byref(self.parameters))
        self.default = bytes(self.parameters)

    def call(self, function: str, *arguments: object) -> int:
        made = [a.ctypes.data_as(ctypes.c_void_p) if isinstance(a, np.ndarray) else a for a in arguments]
        return int(getattr(self.lib, f"{self.prefix}_{function}")(*made))

    def at(self, x: Array | None, at_x: float, at_y: float, out: Array | None) -> int:
        """Status of what the plate does at a point, into `out` (6,)."""
        return self.call("displacement_at", x, ctypes.c_double(at_x), ctypes.c_double(at_y), out)

    def cell(self, at_x: float, at_y: float) -> int:
        return self.call("cell_at", ctypes.c_double(at_x), ctypes.c_double(at_y))

    def array(self, count: str) -> Array:
        return np.full(self.counts[count], np.nan)

    def matrix(self, sections: Array | None = None) -> Array:
        """Values of the assembled matrix."""
        values = self.array("entry")
        pointer = ctypes.byref(self.parameters)
        if sections is None:
            assert self.call("assemble", pointer, values) == 0
        else:
            assert self.call("assemble_sections", pointer, np.ascontiguousarray(sections), values) == 0
        return values

    def solution(self, case: int = 0) -> Array:
        """What every node does, (nodes, 6)."""
        rhs, work, x = self.array("row"), self.array("work"), self.array("row")
        assert self.call("load", ctypes.byref(self.parameters), case, rhs) == 0
        assert self.call("solve", self.matrix(), rhs, work, x) == 0
        motions = np.full((self.counts["node"], 6), np.nan)
        for node in range(len(motions)):
            assert self.call("displacement", x, node, motions[node]) == 0
        return motions
