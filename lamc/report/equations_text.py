"""The equations of motion written out for people: plain text, and LaTeX that compiles by itself.

In: an `Equations`. Out: text. Every quantity has a name and is defined before it is used; the sections are those of the
derivation. Names from a design are escaped, so that no name can end a formula or start a command. It writes no files.
"""

import re
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import sympy as sp
from sympy.printing.latex import LatexPrinter

from lamc.basics._version import __version__

if TYPE_CHECKING:
    from lamc.mechanics.equations import Assignment, Equations

_SPECIAL = {
    "\\": r"\textbackslash{}",
    "{": r"\{",
    "}": r"\}",
    "$": r"\$",
    "&": r"\&",
    "#": r"\#",
    "%": r"\%",
    "_": r"\_",
    "^": r"\textasciicircum{}",
    "~": r"\textasciitilde{}",
    "<": r"\textless{}",
    ">": r"\textgreater{}",
    "|": r"\textbar{}",
    '"': r"\textquotedbl{}",
    "·": r"\textperiodcentered{}",
    "²": r"\textsuperscript{2}",
    "³": r"\textsuperscript{3}",
    "°": r"\textdegree{}",
    "’": "'",
    "–": "--",
    "ω": r"$\omega$",
}
_LARGEST_MATRIX = (
    12  # hinges; a larger matrix leaves the page, and its entries grow as the square of the hinges
)
# sympy's own order of terms. Sorting them by degree for the eye takes longer than all the rest.
_ORDER = "none"
_STATE = re.compile(r"(q|u|udot)_(.+)", re.DOTALL)
_INDEXED = re.compile(r"(z|M|f)_?(\d+)(?:_(\d+))?")
_PREAMBLE = r"""% Equations of motion, written by lamc {version}.
\documentclass[10pt,a4paper,landscape]{{article}}
\usepackage[T1]{{fontenc}}
\usepackage[utf8]{{inputenc}}
\usepackage{{textcomp}}
\usepackage{{amsmath,amssymb}}
\usepackage[margin=15mm]{{geometry}}
\allowdisplaybreaks
\setcounter{{MaxMatrixCols}}{{{columns}}}
\begin{{document}}
\footnotesize
"""


@dataclass(frozen=True, eq=False)
class _Chapter:
    """One listing: its title, a word on it, and its assignments by section."""

    title: str
    about: str
    assignments: "tuple[Assignment, ...]"

    def sections(self) -> "Iterator[tuple[str, list[Assignment]]]":
        """(heading, assignments) for each run of assignments with one origin."""
        run: list[Assignment] = []
        heading = ""
        for assignment in self.assignments:
            found = _heading(assignment)
            if run and found != heading:
                yield heading, run
                run = []
            heading = found
            run.append(assignment)
        if run:
            yield heading, run


def _heading(assignment: "Assignment") -> str:
    notes = [note for note in (assignment.effect.replace("_", " "), assignment.source) if note]
    return assignment.section + (f" ({'; '.join(notes)})" if notes else "")


@dataclass(frozen=True, eq=False)
class Listing:
    """The equations staged for reading; made once, written as text and as LaTeX."""

    name: str
    equations: "Equations"
    chapters: tuple[_Chapter, ...]
    shows_matrix: bool


def listing(equations: "Equations", name: str) -> Listing:
    """Accelerations, mass matrix and forces, energies of `equations`; `name` is the device's."""
    energies = equations.staged({f"energy_{name}": value for name, value in equations.energies.items()})
    chapters = [_motion(equations)]
    if equations.coordinate_rates is not None:
        names = (f"qdot_{c.name}" for c in equations.coordinates)
        rates = equations.staged(dict(zip(names, equations.coordinate_rates, strict=True)))
        chapters.append(_Chapter("Rates of the coordinates", "By q and u. The z are numbered anew.", rates))
    shows_matrix = 0 < len(equations.rates) <= _LARGEST_MATRIX
    if shows_matrix and equations.is_plain:
        about = "The same motion as M udot = f, with M in kg·m² and f in N·m. The z are numbered anew."
        chapters.append(_Chapter("Mass matrix and generalised forces", about, equations.mass_assignments))
    about = "In J, one for each effect that stores any. The z are numbered anew."
    chapters.append(_Chapter("Energies", about, energies))
    return Listing(name, equations, tuple(chapters), shows_matrix)


def _motion(equations: "Equations") -> _Chapter:
    if not equations.is_plain:
        about = f"M and f of M udot = f by {equations.solver}, as the generated C computes them; its runtime solves."
        return _Chapter("Mass matrix and generalised forces", about, equations.assignments)
    flops = ", ".join(f"{way} {count}" for way, count in sorted(equations.solver_flops.items()))
    about = (
        f"The joint accelerations udot, rad/s², as the generated C computes them: by {equations.solver} "
        f"(operations: {flops})."
    )
    return _Chapter("Accelerations", about, equations.assignments)


def _added(equations: "Equations") -> str:
    """Coordinates and rates that effects add, with their units; nothing where there are none."""
    count = len(equations.joints)
    groups = ((equations.coordinates[count:], "q"), (equations.rates[count:], "u"))
    parts = [
        f"{letter}: {', '.join(f'{c.name} ({c.unit})' for c in more)}" for more, letter in groups if more
    ]
    return f"Beside the joints there are {'; '.join(parts)}." if parts else ""


# --- plain text -------------------------------------------------------------------------------------------------


def equations_txt(listing: Listing) -> str:
    """The equations as plain text."""
    equations = listing.equations
    lines = [f"Equations of motion of {listing.name}, by lamc {__version__}", ""]
    lines.append("q_NAME: angle of joint NAME, rad.  u_NAME: its rate, rad/s.  t: time, s.")
    lines += [added] if (added := _added(equations)) else []
    lines += ["", "Parameters"]
    width = max((len(p.name) for p in equations.parameters), default=0)
    lines += [f"  {p.name:<{width}}  = {p.default!r} {p.unit}  ({p.meaning})" for p in equations.parameters]
    for chapter in listing.chapters:
        lines += ["", chapter.title, "=" * len(chapter.title), chapter.about]
        for heading, assignments in chapter.sections():
            lines += ["", f"-- {heading}"]
            lines += [f"{a.symbol} = {sp.sstr(a.expression, order=_ORDER)}" for a in assignments]
    if listing.shows_matrix:
        lines += ["", "M = ["]
        lines += [f"  {sp.sstr(row)}" for row in equations.mass_matrix.tolist()]
        lines += ["]", f"f = {sp.sstr(list(equations.generalised_forces))}"]
    return "\n".join([*lines, ""])


# --- LaTeX ------------------------------------------------------------------------------------------------------


class _Printer(LatexPrinter):  # type: ignore[misc]  # sympy has no types
    """sympy's LaTeX printer with this module's symbols; sympy's own guesses what a name's underscores mean."""

    def _print_Symbol(self, expr: sp.Symbol, style: str = "plain") -> str:  # noqa: N802  sympy's name
        return symbol_tex(expr.name)


def equations_tex(listing: Listing) -> str:
    """The equations as a LaTeX document, for pdflatex, lualatex or xelatex."""
    equations = listing.equations
    printer = _Printer({"mul_symbol": "dot", "order": _ORDER})
    count = len(equations.rates)
    parts = [_PREAMBLE.format(version=__version__, columns=max(count, 10))]
    parts += [rf"\section*{{Equations of motion of {escaped(listing.name)}}}", ""]
    parts += [
        r"$q$ are the joint angles, rad, $u$ their rates, rad/s, and $t$ is the time, s. "
        r"Hinge names stand as indices.",
        escaped(_added(equations)),
        "",
    ]
    if equations.parameters:
        parts += [r"\subsection*{Parameters}", *_parameter_lines(equations)]
    for chapter in listing.chapters:
        parts += [rf"\section*{{{escaped(chapter.title)}}}", escaped(chapter.about), ""]
        for heading, assignments in chapter.sections():
            parts += [rf"\subsection*{{{escaped(heading)}}}", *_formulas(assignments, printer)]
    if listing.shows_matrix:
        matrix = printer.doprint(equations.mass_matrix)
        parts += [rf"\[ M = {matrix}, \qquad f = {printer.doprint(equations.generalised_forces)} \]"]
    return "\n".join([*parts, r"\end{document}", ""])


def _parameter_lines(equations: "Equations") -> Iterable[str]:
    yield r"\begin{flalign*}"
    lines = [
        rf"& {symbol_tex(p.name)} = {_number(p.default)}\ \text{{{escaped(p.unit)}}}"
        rf" \quad \text{{({escaped(p.meaning)})}} &"
        for p in equations.parameters
    ]
    yield " \\\\\n".join(lines)
    yield r"\end{flalign*}"


def _formulas(assignments: "Sequence[Assignment]", printer: _Printer) -> Iterable[str]:
    yield r"\begin{flalign*}"
    yield " \\\\\n".join(
        f"& {symbol_tex(a.symbol.name)} = {printer.doprint(a.expression)} &" for a in assignments
    )
    yield r"\end{flalign*}"


def _number(value: float) -> str:
    text = repr(float(value))
    mantissa, _, power = text.partition("e")
    return rf"{mantissa} \cdot 10^{{{int(power)}}}" if power else mantissa


def symbol_tex(name: str) -> str:
    r"""A symbol's name in LaTeX: q_h1 as q_{\text{h1}}, udot_h1 as \dot{u}, z12 as z_{12}, h1.stiffness upright."""
    if match := _INDEXED.fullmatch(name):
        letter, first, second = match.groups()
        return f"{letter}_{{{first}{',' + second if second else ''}}}"
    if match := _STATE.fullmatch(name):
        letter = {"q": "q", "u": "u", "udot": r"\dot{u}"}[match.group(1)]
        return rf"{letter}_{{\text{{{escaped(match.group(2))}}}}}"
    if name.startswith("energy_"):
        return rf"E_{{\text{{{escaped(name.removeprefix('energy_').replace('_', ' '))}}}}}"
    owner, dot, quantity = name.rpartition(".")
    if dot and owner:
        return rf"\text{{{escaped(quantity)}}}_{{\text{{{escaped(owner)}}}}}"
    return name if name == "t" else rf"\text{{{escaped(name)}}}"


def escaped(text: str) -> str:
    """`text` for LaTeX, outside mathematics: specials escaped, signs that pdflatex may lack by their code."""
    return "".join(_SPECIAL.get(ch) or (ch if " " <= ch <= "~" else f"[U+{ord(ch):04X}]") for ch in text)
