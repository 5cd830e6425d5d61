"""Result files: CSV, NPZ and the manifest beside them.

In: a `Result` and a path. Out: files that appear whole or not at all (written beside their place and
renamed). Never: pickles; leaves a half-written file.
"""

import csv
import json
import math
from collections.abc import Callable, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import IO, TYPE_CHECKING, Any

import numpy as np

from lamc.basics.files import replacing
from lamc.records.scene import OutputPoint
from lamc.run.quantities import AXES, Quantity
from lamc.run.request import Array

if TYPE_CHECKING:
    from lamc.run.result import Result
    from lamc.symbolic.program import Coordinate


def columns(result: "Result") -> dict[str, Array]:
    """The table of a result: column title with unit → values (m,). Titles of distinct columns are distinct,
    since joint names are."""
    count = len(result.joints)
    values = [result.t, *(result.angle(j) for j in result.joints), *(result.rate(j) for j in result.joints)]
    values += [*result.q.T[count:], *result.u.T[count:], *result.energies.values(), result.energy]
    named = titles(result.joints, result.coordinates, result.rates, list(result.energies))
    found = dict(zip(named, values, strict=True))
    for hinge in result.hinges:  # those that close loops and yield are coordinates without a rate
        found.setdefault(f"{hinge} rate (rad/s)", result.rate(hinge))
    found |= {f"{q.name} ({q.unit})": q.values for q in positions(result)}
    if result.kept is not None:
        found |= {f"{name} work (J)": values for name, values in result.work.items()}
    return found


def positions(result: "Result") -> list[Quantity]:
    """Of the scene's outputs those that are not among coordinates: points and centres of bodies, m."""
    known = {c.name for c in result.coordinates}
    wanted = [
        [f"{each.name}.{axis}" for axis in AXES] if isinstance(each, OutputPoint) else [each]
        for each in result.outputs
    ]
    return [result.quantity(name) for group in wanted for name in group if name not in known]


def titles(
    joints: Sequence[str],
    coordinates: "Sequence[Coordinate]",
    rates: "Sequence[Coordinate]",
    energies: Sequence[str],
) -> list[str]:
    """Titles of the table's columns, with units."""
    named = [f"{joint} angle (rad)" for joint in joints] + [f"{joint} rate (rad/s)" for joint in joints]
    named += [f"{title} ({unit})" for title, unit in _other_titles(len(joints), coordinates, rates)]
    return ["t (s)", *named, *(f"{name} energy (J)" for name in energies), "energy (J)"]


def _other_titles(
    count: int, coordinates: "Sequence[Coordinate]", rates: "Sequence[Coordinate]"
) -> list[tuple[str, str]]:
    """Title and unit of each coordinate and rate beyond the first `count`. A rate named as its coordinate is reported
    apart by the word."""
    known = {c.name for c in coordinates}
    others = [(c.name, c.unit) for c in coordinates[count:]]
    return others + [(f"{r.name} rate" if r.name in known else r.name, r.unit) for r in rates[count:]]


def energy_balance_data(result: "Result") -> dict[str, Any] | None:
    """The energy balance of the whole run as plain data, J; None where none were kept."""
    if result.kept is None:
        return None
    energy_balance = result.energy_balance
    return {
        "kinetic": float(energy_balance.kinetic[-1]) if len(energy_balance.kinetic) else 0.0,
        "effects": [asdict(entry) for entry in energy_balance.entries],
        "balance": energy_balance.balance,
        "scale": energy_balance.scale,
    }


def others(result: "Result") -> list[tuple[str, str, Array]]:
    """Title, unit and values (m,) of each coordinate and rate that is no joint's."""
    count = len(result.joints)
    named = _other_titles(count, result.coordinates, result.rates)
    values = [*result.q.T[count:], *result.u.T[count:]]
    return [(title, unit, each) for (title, unit), each in zip(named, values, strict=True)]


def write_csv(result: "Result", path: Path, *, manifest: bool = True) -> Path:
    """Writes the table with 17 digits, which read back exactly, and the manifest if asked. Returns the path."""
    found = columns(result)

    def write(file: IO[str]) -> None:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(found)
        writer.writerows(zip(*(values.tolist() for values in found.values()), strict=True))

    if manifest:
        _write_manifest(result, path, list(found))
    _write_text(path, write)
    return path


def write_npz(result: "Result", path: Path, *, manifest: bool = True) -> Path:
    """Writes the arrays, and the manifest if asked. Returns the path."""
    arrays: dict[str, Any] = {
        "t": result.t,
        "q": result.q,
        "u": result.u,
        "energies": table(list(result.energies.values()), len(result.t)),
        "energy": result.energy,
        "constraint_error": result.constraint_error,
        "joints": np.array(result.joints, dtype=np.str_),
        "coordinates": np.array([c.name for c in result.coordinates], dtype=np.str_),
        "coordinate_units": np.array([c.unit for c in result.coordinates], dtype=np.str_),
        "rates": np.array([c.name for c in result.rates], dtype=np.str_),
        "rate_units": np.array([c.unit for c in result.rates], dtype=np.str_),
        "energy_names": np.array(list(result.energies), dtype=np.str_),
        "hinges": np.array(result.hinges, dtype=np.str_),
        "angles": table([result.angle(name) for name in result.hinges], len(result.t)),
        "angle_rates": table([result.rate(name) for name in result.hinges], len(result.t)),
    }
    arrays["event_times"] = np.array([event.t for event in result.events], dtype=float)
    arrays["event_names"] = np.array([event.name for event in result.events], dtype=np.str_)
    outputs = positions(result)
    arrays["outputs"] = table([each.values for each in outputs], len(result.t))
    arrays["output_names"] = np.array([each.name for each in outputs], dtype=np.str_)
    arrays["output_units"] = np.array([each.unit for each in outputs], dtype=np.str_)
    if result.kept is not None:
        arrays["work"] = table(list(result.work.values()), len(result.t))
        arrays["work_names"] = np.array(list(result.work), dtype=np.str_)
    if manifest:
        _write_manifest(result, path, list(arrays))
    with replacing(path) as temporary, temporary.open("wb") as file:
        np.savez_compressed(file, **arrays)
    return path


def table(columns: Sequence[Array], rows: int) -> Array:
    """Columns (m,) side by side, (m, len(columns))."""
    found: Array = np.column_stack([np.zeros((rows, 0)), *columns])
    return found


def _write_manifest(result: "Result", path: Path, contents: list[str]) -> None:
    manifest = {
        "file": path.name,
        "contents": contents,
        "rows": len(result.t),
        "status": result.status.name.lower(),
        "message": result.message,
        **asdict(result.provenance),
        "books": energy_balance_data(result),
        "stats": asdict(result.stats),
    }
    place = path.with_name(path.name + ".manifest.json")
    _write_text(
        place, lambda file: json.dump(_plain(manifest), file, indent=2, ensure_ascii=False, allow_nan=False)
    )


def _plain(value: Any) -> Any:
    """`value` in JSON's own types; a number that is not finite becomes null."""
    if isinstance(value, dict):
        return {key: _plain(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(item) for item in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value


def _write_text(path: Path, write: Callable[[IO[str]], None]) -> None:
    with replacing(path) as temporary, temporary.open("w", encoding="utf-8", newline="") as file:
        write(file)
