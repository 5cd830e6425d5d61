"""Models that run in a page, and the numbers of them that it has sliders for.

In: what `lamc.export.live` compiled. Out: plain data for the page. Never: compiles.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from lamc.records.mechanism import Mechanism

BODIES = "Bodies"  # heading of what belongs to the mechanism itself: masses, inertias
_GRAVITY = 9.81  # m/s²
_PACE = 10.0  # rad/s, of a hinge that turns fast


@dataclass(frozen=True, eq=False)
class Live:
    """A model that runs in the page: what `lamc.export.live` makes.

    engine              JavaScript that defines `simulatorOf`
    wasm                bytes
    parameters, inputs  field, name, unit, meaning, group, value, least, most of each, as plain data
    """

    engine: str
    wasm: bytes = field(repr=False)
    parameters: tuple[Mapping[str, Any], ...] = ()
    inputs: tuple[Mapping[str, Any], ...] = ()


def live_data(
    live: Live, mechanism: Mechanism, used: Mapping[str, float], settings: Mapping[str, float]
) -> dict[str, Any]:
    """For the page. used: values by name that a run had; `given` are those that are not the model's own."""
    scales = _scales(mechanism)
    data: dict[str, Any] = {"wasm": live.wasm, "settings": settings, "given": {}}
    for kind, members in (("parameters", live.parameters), ("inputs", live.inputs)):
        now = [{**each, "value": used.get(each["name"], each["value"])} for each in members]
        pairs = zip(now, members, strict=True)
        data["given"][kind] = {
            new["field"]: new["value"] for new, old in pairs if new["value"] != old["value"]
        }
        scaled = [{**each, "scale": scales.get(each["unit"])} for each in now]
        data[kind] = sorted(scaled, key=lambda each: each.get("group") == BODIES)  # stable: those come last
    return data


def _scales(mechanism: Mechanism) -> dict[str, float]:
    """What is much for a number of a unit, where its own value is zero and tells nothing: by the device's weight."""
    weight = _GRAVITY * sum(body.mass for body in mechanism.bodies if not body.fixed)
    torque = weight * mechanism.size / 2.0
    return {
        "N": _round(weight),
        "N·m": _round(torque),
        "N·m/rad": _round(torque),
        "N·m·s/rad": _round(torque / _PACE),
    }


def _round(value: float) -> float:
    return float(f"{value:.1g}") or 1.0
