"""The table of a study: what was varied, what was measured, how each point went.

In: a plan, names and units, rows. Out: a `Table`, as CSV, netCDF, zarr or an xarray Dataset. The same rows give the
same bytes, in whatever order they came. Never: runs anything.
"""

import csv
import math
import shutil
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from importlib import import_module
from inspect import signature
from pathlib import Path
from typing import IO, TYPE_CHECKING, Any

import numpy as np

from lamc.basics.errors import LamcError
from lamc.basics.files import replacing
from lamc.run.request import Array
from lamc.studies.bench import MISSING, OK, STATUSES, UNDEFINED, Row, Subject
from lamc.studies.plans import Grid, Plan
from lamc.studies.structures import NONE, Numbers, numbered, structure_notes

if TYPE_CHECKING:
    import xarray

_POINT = "point"


@dataclass(frozen=True, eq=False)
class Table:
    """count points in the plan's order.

    units     SI units by name, of what was varied and of measures
    values    (count,) of each measure, NaN where there is none
    statuses  (count,), places in `STATUSES`; reasons: of points that are not "ok", by number
    design    its name
    structures  (count,), numbers of structures: points of one number have the same equations; -1 where there are none
    changes   what is another in structures but the first, in words
    """

    plan: Plan
    units: Mapping[str, str]
    values: Mapping[str, Array]
    statuses: "np.ndarray[Any, np.dtype[np.uint8]]"
    reasons: Mapping[int, str]
    design: str
    structures: Numbers | None = None
    changes: tuple[str, ...] = ()

    @property
    def structure_count(self) -> int:
        """How many there are: as many modules were compiled."""
        return 0 if self.structures is None else int(self.structures.max(initial=NONE)) + 1

    def structure(self, index: int) -> int:
        return NONE if self.structures is None else int(self.structures[index])

    @property
    def count(self) -> int:
        return self.plan.count

    def tally(self) -> dict[str, int]:
        """How many points went how; what did not happen is left out."""
        counts = np.bincount(self.statuses, minlength=len(STATUSES))
        return {status: int(counts[k]) for k, status in enumerate(STATUSES) if counts[k]}

    def points(self) -> Array:
        """(count, names) of what was varied."""
        return np.array([self.plan.point(k) for k in range(self.count)]).reshape(
            self.count, len(self.plan.names)
        )

    def status(self, index: int) -> str:
        return STATUSES[self.statuses[index]]

    def write_csv(self, path: Path) -> Path:
        """A line for each point, numbers with 17 digits. Raises LamcError if it cannot."""

        def write(file: IO[str]) -> None:
            writer = csv.writer(file, lineterminator="\n")
            titles = [f"{name} ({self.units[name]})" for name in (*self.plan.names, *self.values)]
            writer.writerow([_POINT, *titles, "structure", "status", "reason"])
            columns = list(self.values.values())
            for k in range(self.count):
                values = [float(column[k]) for column in columns]
                ended = (self.structure(k), self.status(k), self.reasons.get(k, ""))
                writer.writerow([k, *self.plan.point(k), *values, *ended])

        with replacing(path) as temporary, temporary.open("w", encoding="utf-8", newline="") as file:
            write(file)
        return path

    def dataset(self) -> "xarray.Dataset":
        """Measures, `structure`, `status` and `reason` over what was varied, of a grid, or over points. Raises
        LamcError without xarray."""
        make = need_xarray().Dataset
        grid = self.plan if isinstance(self.plan, Grid) else None
        dims, shape = (grid.names, grid.shape) if grid is not None else ((_POINT,), (self.count,))
        coords: dict[str, Any] = {}
        if grid is not None:
            for name, axis in grid.axes.items():
                values = np.array([axis.value(k) for k in range(len(axis))])
                coords[name] = (name, values, {"units": self.units[name]})
        else:
            points = self.points()
            for k, name in enumerate(self.plan.names):
                coords[name] = (_POINT, points[:, k], {"units": self.units[name]})
        data: dict[str, Any] = {
            name: (dims, column.reshape(shape), {"units": self.units[name]})
            for name, column in self.values.items()
        }
        reasons = np.array([self.reasons.get(k, "") for k in range(self.count)], dtype=np.str_)
        structures = np.array([self.structure(k) for k in range(self.count)], dtype=np.int32)
        data["structure"] = (dims, structures.reshape(shape), {"structures": self.structure_count})
        data["status"] = (dims, np.array(STATUSES)[self.statuses].reshape(shape), {})
        data["reason"] = (dims, reasons.reshape(shape), {})
        more = {"structures": self.structure_count, "topology": "; ".join(self.changes)}
        found: xarray.Dataset = make(
            data, coords, {"design": self.design, "statuses": " ".join(STATUSES), **more}
        )
        return found

    def write_netcdf(self, path: Path) -> Path:
        """A netCDF 3 file. Raises LamcError without xarray."""
        dataset = _renamed(self.dataset())
        with replacing(path) as temporary:
            dataset.to_netcdf(temporary, engine="scipy", format="NETCDF3_64BIT")
        return path

    def write_zarr(self, path: Path) -> Path:
        """A zarr folder (format 2, which all readers of zarr know), in the place of one that is there. Raises LamcError
        without xarray and zarr."""
        need_zarr()
        dataset = _renamed(self.dataset())
        fresh = path.with_name(f".{path.name}.new")
        try:
            shutil.rmtree(fresh, ignore_errors=True)
            newer = (
                "zarr_format" in signature(dataset.to_zarr).parameters
            )  # older ones write format 2 and no other
            more: dict[str, Any] = {"zarr_format": 2} if newer else {}
            dataset.to_zarr(fresh, mode="w", consolidated=True, **more)
            shutil.rmtree(path, ignore_errors=True)
            fresh.replace(path)
        except OSError as error:
            raise LamcError(f"{str(path)!r} cannot be written: {error.strerror or error}") from error
        finally:
            shutil.rmtree(fresh, ignore_errors=True)
        return path


def need_xarray() -> Any:
    """The module, or LamcError with what to install."""
    try:
        import xarray  # optional, and slow to load
    except ImportError as error:
        raise LamcError("a Dataset needs xarray: pip install lamc[frames]; or write csv") from error
    return xarray


def need_zarr() -> None:
    """LamcError with what to install, where a zarr folder cannot be written."""
    need_xarray()
    try:
        import_module("zarr")  # optional, and slow to load
    except ImportError as error:
        raise LamcError("a zarr folder needs zarr: pip install zarr; or write netcdf") from error


def _renamed(dataset: "xarray.Dataset") -> "xarray.Dataset":
    """With names that netCDF and zarr take: / parts their groups, and the whole name becomes an attribute."""
    names = {str(name): str(name).replace("/", "÷") for name in dataset.variables if "/" in str(name)}
    for name in names:
        dataset[name].attrs["long_name"] = name
    return dataset.rename(names)


def table_of(subject: Subject, plan: Plan, rows: Iterable[Row], design: str) -> Table:
    """The table of rows; where a point has several, the last that tells of a run."""
    units = {target.name: target.unit for target in subject.targets}
    units |= {name: measure.unit for name, measure in subject.measures.items()}
    values = np.full((len(subject.measures), plan.count), math.nan)
    statuses = np.full(plan.count, STATUSES.index(MISSING), dtype=np.uint8)
    reasons: dict[int, str] = {}
    digests: dict[int, str] = {}
    for row in rows:
        if not 0 <= row.index < plan.count or len(row.values) != len(values):
            continue
        values[:, row.index] = row.values
        statuses[row.index] = STATUSES.index(row.status)
        reasons.pop(row.index, None)
        digests[row.index] = row.structure
        if row.reason:
            reasons[row.index] = row.reason
    named = dict(zip(subject.measures, values, strict=True))
    structures = numbered(digests, plan.count)
    return Table(
        plan, units, named, statuses, reasons, design, structures, structure_notes(subject, plan, structures)
    )


def is_usable(status: str) -> bool:
    """Whether a point of this status has measures, some of them perhaps NaN."""
    return status in (OK, UNDEFINED)
