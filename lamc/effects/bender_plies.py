"""The laminate of a bender from plain data: plies from bottom to top, with materials by name or by their numbers.

In: a `lamc.plate.Laminate`, or data of a scene file. Out: a `Laminate`. The plate half of lamc is imported when it is
needed: it takes longer than all the rest.
"""

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from lamc.basics.checks import did_you_mean, shown
from lamc.basics.errors import LamcError
from lamc.effects.data import quantity, refusal

if TYPE_CHECKING:
    from lamc.plates.laminates.laminate import Laminate
    from lamc.plates.laminates.materials import Material
    from lamc.plates.laminates.plies import Ply

_PLY = {"material": "", "thickness": "m", "angle": "deg", "gap": "m"}
_MATERIAL = {
    **dict.fromkeys(("E", "E1", "E2", "G12", "G13", "G23", "Xt", "Xc", "Yt", "Yc", "S"), "Pa"),
    **dict.fromkeys(("nu", "nu12", "beta1", "beta2"), "1"),
    **dict.fromkeys(("alpha1", "alpha2"), "K^-1"),
    **dict.fromkeys(("d31", "d32"), "m/V"),
    "density": "kg/m^3",
}
_TEXTS = ("name", "source")


def laminate_of(data: object, what: str, where: str = "") -> "Laminate":
    """`data` as a Laminate. Raises DesignError for what is none, with the part at fault where `where` is given."""
    from lamc.plates.laminates.laminate import Laminate

    if isinstance(data, Laminate):
        return data
    reference = "middle"
    if isinstance(data, Mapping) and set(data) <= {"plies", "reference"}:
        reference, data = data.get("reference", reference), data.get("plies")
    if not isinstance(data, list | tuple) or not data:
        raise refusal(
            where or what,
            f"{what} is {shown(data)}; give its plies from bottom to top, or a lamc.plate.Laminate",
            *_at(where),
        )
    plies = [_ply(ply, where or what, (*_at(where), index)) for index, ply in enumerate(data)]
    return _made(lambda: Laminate(plies, reference), where or what, _at(where))  # type: ignore[no-any-return]


def _at(where: str) -> tuple[str | int, ...]:
    return ("laminate",) if where else ()


def _made(make: Any, where: str, path: tuple[str | int, ...]) -> Any:
    try:
        return make()
    except LamcError as error:
        raise refusal(where, error.message, *path) from error


def _ply(data: object, where: str, path: tuple[str | int, ...]) -> "Ply":
    from lamc.plates.laminates.plies import Ply

    if isinstance(data, Ply):
        return data
    known = _fields(data, _PLY, where, path, "a ply")
    for name in ("material", "thickness"):
        if name not in known:
            raise refusal(where, f"the ply has no {name}; give material and thickness", *path)
    numbers = {n: quantity(v, _PLY[n], where, *path, n) for n, v in known.items() if _PLY[n]}
    material = _material(known["material"], where, (*path, "material"))
    return _made(lambda: Ply(material, **numbers), where, path)  # type: ignore[no-any-return]


def _material(data: object, where: str, path: tuple[str | int, ...]) -> "Material":
    from lamc.plates.laminates.library import LIBRARY
    from lamc.plates.laminates.materials import Material

    if isinstance(data, Material):
        return data
    if isinstance(data, str):
        if data not in LIBRARY:
            hint = did_you_mean(data, sorted(LIBRARY))
            raise refusal(where, f"no material of the library is named {data[:40]!r}; {hint}", *path)
        return LIBRARY[data]
    known = _fields(data, {**_MATERIAL, **dict.fromkeys(_TEXTS, "")}, where, path, "a material")
    values: dict[str, Any] = {
        name: value if name in _TEXTS else quantity(value, _MATERIAL[name], where, *path, name)
        for name, value in known.items()
        if value is not None
    }
    values.setdefault("density", 0.0)
    if "E" in values or "nu" in values:
        if not {"E", "nu"} <= set(values) or {"E1", "E2", "nu12", "G12"} & set(values):
            raise refusal(where, "a material has E and nu, or E1, E2, nu12 and G12", *path)
        modulus, ratio = values.pop("E"), values.pop("nu")
        sheet = _made(lambda: Material.isotropic(modulus, ratio, values["density"]), where, path)
        values |= {n: getattr(sheet, n) for n in ("E1", "E2", "nu12", "G12")}
    missing = [name for name in ("E1", "E2", "nu12", "G12") if name not in values]
    if missing:
        raise refusal(
            where, f"the material has no {', '.join(missing)}; give E and nu, or E1, E2, nu12 and G12", *path
        )
    return _made(lambda: Material(**values), where, path)  # type: ignore[no-any-return]


def _fields(
    data: object, known: Mapping[str, str], where: str, path: tuple[str | int, ...], what: str
) -> dict[str, Any]:
    """Raises DataError for what is no map of these fields."""
    if not isinstance(data, Mapping):
        raise refusal(where, f"{what} is {shown(data)}; give a map of {', '.join(known)}", *path)
    for name in data:
        if name not in known:
            raise refusal(
                where,
                f"{what} has no field {str(name)[:40]!r}; {did_you_mean(str(name), list(known))}",
                *path,
            )
    return {str(name): value for name, value in data.items()}
