"""When plies fail: maximum stress and Tsai-Wu, ply by ply.

In: stress along and across the fibres, and the strengths of materials. Out: indices (1 at failure) and strength ratios
(how many times the load until failure). Never: what a laminate still carries after its first ply has failed.

Tsai-Wu: F_i σ_i + F_ij σ_i σ_j = 1 with F1 = 1/Xt - 1/Xc, F11 = 1/(Xt Xc), F2 and F22 likewise, F66 = 1/S², and
F12 = f sqrt(F11 F22), where f in (-1, 1) is taken as -1/2 unless it was measured. The strength ratio R multiplies the
stress that the load makes, not that of temperature, moisture and fields, and solves a quadratic equation.

Stress vectors are (1, 2, 12). Sources: S. W. Tsai and H. T. Hahn, Introduction to Composite Materials, 1980, chapter 7;
R. M. Jones, Mechanics of Composite Materials, 2nd ed. 1999, section 2.9.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from lamc.basics.checks import Array, checked_array, checked_number, shown
from lamc.basics.errors import DesignError
from lamc.plates.laminates.free_strains import Fields
from lamc.plates.laminates.graded import Amount, Graded
from lamc.plates.laminates.laminate import Laminate
from lamc.plates.laminates.materials import STRENGTHS, Material
from lamc.plates.laminates.plies import Ply

CRITERIA = ("tsai-wu", "max-stress")
MODES = ("tension along 1", "compression along 1", "tension along 2", "compression along 2", "shear")
INTERACTION = -0.5
_FACES = ("lower", "upper")


def require_strengths(laminate: Laminate) -> None:
    """Raises DesignError that names every material of the laminate whose strengths are not all known."""
    lacking: dict[str, str] = {}
    for number, ply in enumerate(laminate.plies, start=1):
        unknown = [symbol for symbol in STRENGTHS if getattr(ply.material, symbol) is None]
        if unknown:
            name = repr(ply.material.name) if ply.material.name else f"the material of ply {number}"
            lacking.setdefault(name, ", ".join(unknown))
    if lacking:
        reported = "; ".join(f"{name} lacks {symbols}" for name, symbols in lacking.items())
        raise DesignError(
            f"failure needs the strengths of every material, and {reported}: give them, Pa, as in "
            "dataclasses.replace(material, Xt=…, Xc=…, Yt=…, Yc=…, S=…)"
        )


def _strengths(material: Material) -> tuple[float, float, float, float, float]:
    Xt, Xc, Yt, Yc, S = (getattr(material, symbol) for symbol in STRENGTHS)
    if None in (Xt, Xc, Yt, Yc, S):
        name = repr(material.name) if material.name else "a material"
        raise DesignError(f"failure needs the strengths {', '.join(STRENGTHS)} of {name}; not all are given")
    return Xt, Xc, Yt, Yc, S


def tsai_wu_terms(material: Material, interaction: float = INTERACTION) -> tuple[Array, Array]:
    """F_i, shape (3,), 1/Pa, and F_ij, shape (3, 3), 1/Pa². `interaction`: F12 / sqrt(F11 F22), between -1 and 1.

    Raises DesignError for a material without strengths, or another interaction: the surface would be open.
    """
    Xt, Xc, Yt, Yc, S = _strengths(material)
    f = checked_number(interaction, "the interaction of Tsai-Wu")
    if not -1.0 < f < 1.0:
        raise DesignError(f"the interaction of Tsai-Wu is {f:g}; it must be between -1 and 1, as -0.5 is")
    F11, F22 = 1.0 / (Xt * Xc), 1.0 / (Yt * Yc)
    F12 = f * np.sqrt(F11 * F22)
    linear = np.array([1.0 / Xt - 1.0 / Xc, 1.0 / Yt - 1.0 / Yc, 0.0])
    return linear, np.array([[F11, F12, 0.0], [F12, F22, 0.0], [0.0, 0.0, 1.0 / S**2]])


def tsai_wu_index(material: Material, stress: Array, interaction: float = INTERACTION) -> Array:
    """F_i σ_i + F_ij σ_i σ_j at stresses (..., 3), Pa: 1 at failure, shape (...). Raises DesignError."""
    linear, square = tsai_wu_terms(material, interaction)
    return np.asarray(stress @ linear + np.einsum("...i,ij,...j->...", stress, square, stress))


def tsai_wu_ratio(
    material: Material, stress: Array, residual: Array | float = 0.0, interaction: float = INTERACTION
) -> Array:
    """How many times `stress` (..., 3), Pa, may act besides `residual` until failure, shape (...).

    inf where it never fails, 0 where the residual stress alone is beyond. Raises DesignError.
    """
    linear, square = tsai_wu_terms(material, interaction)
    rest = np.broadcast_to(residual, np.shape(stress))
    a = np.einsum("...i,ij,...j->...", stress, square, stress)
    b = stress @ linear + 2.0 * np.einsum("...i,ij,...j->...", rest, square, stress)
    c = tsai_wu_index(material, rest, interaction) - 1.0
    root = np.sqrt(np.maximum(b * b - 4.0 * a * c, 0.0))
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        # The positive root of a R² + b R + c, in the form that does not take a difference of near equals.
        ratio = np.where(b > 0.0, -2.0 * c / (b + root), (root - b) / (2.0 * a))
    return np.where(c >= 0.0, 0.0, np.where(a > 0.0, ratio, np.inf))


def max_stress_index(material: Material, stress: Array) -> tuple[Array, Array]:
    """The largest of the stresses (..., 3) over their strengths, and its place in MODES, each of shape (...).

    Raises DesignError for a material without strengths.
    """
    parts = _by_mode(np.asarray(stress)) / np.array(_strengths(material))
    return parts.max(axis=-1), parts.argmax(axis=-1)


def max_stress_ratio(material: Material, stress: Array, residual: Array | float = 0.0) -> Array:
    """As `tsai_wu_ratio`, by maximum stress."""
    stress, strengths = np.asarray(stress), np.array(_strengths(material))
    rest = np.broadcast_to(residual, stress.shape)
    signs = np.array([[1, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1], [0, 0, -1]])
    limits = np.append(strengths, strengths[-1])
    load, left = stress @ signs.T, limits - rest @ signs.T
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        each = np.where(load > 0.0, left / load, np.inf)
    return np.where((left <= 0.0).any(axis=-1), 0.0, each.min(axis=-1))


def _by_mode(stress: Array) -> Array:
    along, across, shear = np.moveaxis(stress, -1, 0)
    return np.stack([along, -along, across, -across, np.abs(shear)], axis=-1)


@dataclass(frozen=True, eq=False)
class PlyFailure:
    """How near a ply is to failure, at its lower and its upper face (last axis), at one place or many (axes before)."""

    number: int  # from the bottom, 1 for the lowest
    ply: Ply
    stress: Array  # (..., 2, 3), Pa, material axes
    tsai_wu: Array  # (..., 2), 1 at failure
    tsai_wu_ratio: Array  # (..., 2)
    max_stress: Array  # (..., 2), 1 at failure
    max_stress_ratio: Array  # (..., 2)
    mode: Array  # (..., 2), of the maximum stress: index into MODES


def ply_failures(
    laminate: Laminate,
    strain: Sequence[float] | Array,
    curvature: Sequence[float] | Array,
    *,
    temperature: Amount = 0.0,
    moisture: Amount = 0.0,
    fields: Fields = 0.0,
    interaction: float = INTERACTION,
) -> tuple[PlyFailure, ...]:
    """Indices and strength ratios of every ply, bottom to top, where the reference surface has `strain` (..., 3) and
    `curvature` (..., 3), 1/m, expansion included. The ratios multiply all of the stress. What expands is given as for
    `Laminate.material_stress`.

    Raises DesignError for materials without strengths, and as `Laminate.expansion` does.
    """
    require_strengths(laminate)
    climate: dict[str, Any] = {"temperature": temperature, "moisture": moisture, "fields": fields}
    stress = laminate.material_stress(np.asarray(strain), np.asarray(curvature), **climate)
    return _failures(laminate, stress, 0.0, interaction)


def _failures(
    laminate: Laminate, stress: Array, residual: Array | float, interaction: float
) -> tuple[PlyFailure, ...]:
    rest = np.broadcast_to(residual, stress.shape)
    found = []
    for k, ply in enumerate(laminate.plies):
        load, remains = stress[..., k, :, :], rest[..., k, :, :]
        total = load + remains
        index, mode = max_stress_index(ply.material, total)
        found.append(
            PlyFailure(
                number=k + 1,
                ply=ply,
                stress=total,
                tsai_wu=tsai_wu_index(ply.material, total, interaction),
                tsai_wu_ratio=tsai_wu_ratio(ply.material, load, remains, interaction),
                max_stress=index,
                max_stress_ratio=max_stress_ratio(ply.material, load, remains),
                mode=mode,
            )
        )
    return tuple(found)


@dataclass(frozen=True, eq=False)
class FirstPlyFailure:
    """The ply that fails first when force and moment grow together; `str` says it in a line."""

    criterion: str
    ratio: float  # times the load given; inf where it makes no stress, 0 where expansion alone is too much
    number: int  # of the ply, from the bottom, 1 for the lowest
    ply: Ply
    face: str  # "lower" or "upper"
    mode: str  # of the largest stress over strength there, at failure: one of MODES
    force: Array  # (3,), N/m, at failure
    moment: Array  # (3,), N

    def __str__(self) -> str:
        if np.isinf(self.ratio):
            return "no ply fails, however large the load: it makes no stress that could"
        name = f", {self.ply.material.name}" if self.ply.material.name else ""
        when = (
            f"at {self.ratio:.5g} times the load"
            if self.ratio > 0.0
            else "by expansion alone, before any load"
        )
        return (
            f"ply {self.number} from the bottom ({self.ply.angle:g}°{name}) fails first, at its {self.face} face in "
            f"{self.mode}, {when} ({self.criterion})"
        )


def first_ply_failure(
    laminate: Laminate,
    force: Sequence[float] | Array = (0.0, 0.0, 0.0),
    moment: Sequence[float] | Array = (0.0, 0.0, 0.0),
    *,
    criterion: str = "tsai-wu",
    temperature: float | Graded = 0.0,
    moisture: float | Graded = 0.0,
    fields: Fields = 0.0,
    interaction: float = INTERACTION,
) -> FirstPlyFailure:
    """Which ply fails first under `force` N/m and `moment` N per width, each (3,), and at how many times these.

    Expansion acts all the while and does not grow. Of plies that fail together, the lowest; of its faces, the lower.

    Raises DesignError for materials without strengths, an unknown criterion, and as `Laminate.deformation` does.
    """
    if criterion not in CRITERIA:
        raise DesignError(f"the criterion is {shown(criterion)}; it must be one of {', '.join(CRITERIA)}")
    require_strengths(laminate)
    N = checked_array(force, (3,), "the force per width on a laminate")
    M = checked_array(moment, (3,), "the moment per width on a laminate")
    loaded = laminate.deformation(N, M)
    stress = laminate.material_stress(loaded.strain, loaded.curvature)
    free = laminate.deformation(temperature=temperature, moisture=moisture, fields=fields)
    residual = laminate.material_stress(
        free.strain, free.curvature, temperature=temperature, moisture=moisture, fields=fields
    )
    found = _failures(laminate, stress, residual, interaction)
    ratios = np.array([f.tsai_wu_ratio if criterion == "tsai-wu" else f.max_stress_ratio for f in found])
    # Faces that fail together differ by round-off; the first of them is named, whatever the machine.
    k, face = (int(i[0]) for i in np.nonzero(ratios <= ratios.min() * (1.0 + 1e-9)))
    ratio = float(ratios[k, face])
    scale = ratio if np.isfinite(ratio) else 0.0
    _, mode = max_stress_index(laminate.plies[k].material, residual[k, face] + scale * stress[k, face])
    return FirstPlyFailure(
        criterion, ratio, k + 1, laminate.plies[k], _FACES[face], MODES[int(mode)], scale * N, scale * M
    )
