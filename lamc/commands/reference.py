"""`lamc materials`, `lamc effects`, `lamc functions`: what there is to name in files, as tables.

In: a name, or none. Out: text, or plain data for --json. It simulates nothing.
"""

import textwrap
from dataclasses import asdict

from lamc import effects
from lamc.basics.checks import did_you_mean
from lamc.basics.errors import LamcError
from lamc.commands.schema import part_text
from lamc.commands.terminal import Terminal
from lamc.effects.registry import EFFECTS, by_name
from lamc.plates.laminates.library import LIBRARY
from lamc.plates.laminates.materials import Material
from lamc.readers.schema_names import called, parts
from lamc.report.schema_text import schema_data
from lamc.report.split_text import table
from lamc.symbolic.expression import CONSTANTS
from lamc.symbolic.functions import FUNCTIONS

_WIDTH = 112
_NAMES = (  # in expressions: name, where, what
    ("t", "every drive", "time, s"),
    ("angle", "torques and motors on a hinge, laws of stiffness", "of that hinge, rad"),
    ("rate", "torques and motors on a hinge", "of that hinge, rad/s"),
    ("inputs", "every drive", "those of the scene, by their names"),
    ("x, y", "pressures, fields and fixed values of plates", "the place, in the file's units"),
)
# Of a material: what it is, its unit, how many SI units that unit is.
_MEANINGS: dict[str, tuple[str, str, float]] = {
    "E1": ("Young's modulus along 1, the fibres", "GPa", 1e9),
    "E2": ("Young's modulus across them", "GPa", 1e9),
    "nu12": ("Poisson's ratio, of stress along 1", "", 1.0),
    "G12": ("shear modulus in the plane", "GPa", 1e9),
    "density": ("density", "kg/m³", 1.0),
    "alpha1": ("thermal expansion along 1", "1e-6/K", 1e-6),
    "alpha2": ("thermal expansion along 2", "1e-6/K", 1e-6),
    "beta1": ("swelling along 1 per share of water", "", 1.0),
    "beta2": ("swelling along 2 per share of water", "", 1.0),
    "d31": ("free strain along 1 per field along z", "pm/V", 1e-12),
    "d32": ("free strain along 2 per field along z", "pm/V", 1e-12),
    "G13": ("shear modulus through the thickness, 1 and z", "GPa", 1e9),
    "G23": ("shear modulus through the thickness, 2 and z", "GPa", 1e9),
    "Xt": ("strength along 1 in tension", "MPa", 1e6),
    "Xc": ("strength along 1 in compression", "MPa", 1e6),
    "Yt": ("strength along 2 in tension", "MPa", 1e6),
    "Yc": ("strength along 2 in compression", "MPa", 1e6),
    "S": ("strength in shear in the plane", "MPa", 1e6),
}


def show_materials(name: str | None, terminal: Terminal) -> int:
    """The library as a table, or one material with all its numbers and where they are printed."""
    if name is not None:
        return _show_material(_material(name), terminal)
    heads = [
        "material",
        "E1 [GPa]",
        "E2 [GPa]",
        "nu12",
        "G12 [GPa]",
        "density [kg/m³]",
        "d31 [pm/V]",
        "strengths",
    ]
    rows = [
        [
            each.name,
            *(
                f"{value:.4g}"
                for value in (each.E1 / 1e9, each.E2 / 1e9, each.nu12, each.G12 / 1e9, each.density)
            ),
            f"{each.d31 * 1e12:.4g}" if each.d31 else "",
            "yes" if each.Xt is not None else "",
        ]
        for each in LIBRARY.values()
    ]
    terminal.say(
        f"{table(heads, rows)}\n\nlamc materials NAME tells all its numbers and their source. Plies of plates and of "
        "benders name them: material: Kapton HN;\nhinges take them with --hinge-stiffness from-material --material "
        "'film=Kapton HN'. In Python: lamc.plate.LIBRARY."
    )
    terminal.result({"ok": True, "materials": [asdict(each) for each in LIBRARY.values()]})
    return 0


def _material(name: str) -> Material:
    found = next((each for key, each in LIBRARY.items() if key.lower() == name.strip().lower()), None)
    if found is None:
        raise LamcError(
            f"no material of the library is named {name[:40]!r}; {did_you_mean(name, list(LIBRARY))}"
        )
    return found


def _show_material(material: Material, terminal: Terminal) -> int:
    rows = [
        [symbol, f"{value / scale:.5g}", unit, said]
        for symbol, (said, unit, scale) in _MEANINGS.items()
        if (value := getattr(material, symbol)) is not None
    ]
    file = f"materials: {{film: {{density: {material.density:g}, E1: {material.E1 / 1e9:.4g} GPa"
    file += (
        ""
        if material.is_isotropic
        else f", E2: {material.E2 / 1e9:.4g} GPa, G12: {material.G12 / 1e9:.4g} GPa"
    )
    file += f", poisson: {material.nu12:.4g}}}}}"
    terminal.say(
        f"{material.name}\n\n{table(['', 'value', 'unit', 'meaning'], rows)}\n\n"
        f"{textwrap.fill('source: ' + material.source, _WIDTH)}\n\nin a design\n  {file}\nin a plate or a bender\n"
        f"  material: {material.name}"
    )
    terminal.result({"ok": True, **asdict(material)})
    return 0


def show_effects(name: str | None, terminal: Terminal) -> int:
    """The effects as a table, or one with its law, fields and an example."""
    if name is None:
        rows = [[kind.name, kind.summary, kind.absent] for kind in EFFECTS]
        terminal.say(
            f"{table(['effect', 'what it is', 'absent because'], rows)}\n\nlamc effects NAME tells the law of one, its "
            "fields and an example. Scenes call for them under effects: or with:,\nand options by --with NAME=VALUE."
        )
        reported = [{"name": kind.name, "summary": kind.summary, "source": kind.source} for kind in EFFECTS]
        terminal.result({"ok": True, "effects": reported})
        return 0
    known = by_name()
    wanted = name.strip().lower().replace("-", "_")
    if wanted not in known:
        raise LamcError(f"no effect is named {name[:40]!r}; {did_you_mean(wanted, sorted(known))}")
    kind, part = known[wanted], parts()[wanted]
    law = f"\n\nlaw     {kind.source}" if kind.source else ""
    is_public = kind.__name__ in effects.__all__
    python = f"lamc.{kind.__name__}" if is_public else f"from {kind.__module__} import {kind.__name__}"
    terminal.say(f"{part_text(part)}{law}\nPython  {python}")
    rows_data = schema_data(part.definition, called)
    terminal.result(
        {"ok": True, "name": wanted, "summary": kind.summary, "fields": rows_data, "example": kind.example}
    )
    return 0


def _arguments(name: str, arity: int) -> str:
    if arity == 1:
        return "x"
    return "y, x" if name == "atan2" else "x, y"


def show_functions(terminal: Terminal) -> int:
    """What expressions may hold."""
    functions = [
        [f"{name}({_arguments(name, each.arity)})", each.meaning] for name, each in FUNCTIONS.items()
    ]
    functions += [[name, f"{value:.6g}"] for name, value in CONSTANTS.items()]
    names = [list(row) for row in _NAMES]
    terminal.say(
        "\n\n".join(
            [
                table(["function", "what it is"], functions),
                table(["name", "known in", "what it is"], names),
                "Signs: + - * / ^ (or **) and parentheses. Values are SI. An expression is text: in YAML\n"
                "  torque: {knee: 1e-4*sin(2*pi*5*t) - 1e-6*rate}",
            ]
        )
    )
    data = {name: {"arguments": each.arity, "meaning": each.meaning} for name, each in FUNCTIONS.items()}
    terminal.result({"ok": True, "functions": data, "constants": dict(CONSTANTS)})
    return 0
