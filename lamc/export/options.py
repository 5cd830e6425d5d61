"""`ExportOptions`: everything a user can choose of an export. What is not here cannot be chosen.

In: values. Out: a record of checked ones, or an ExportError in the words of the command line and of Python. Never:
knows a target; which options a target reads is told by `lamc.export.TARGETS`, and held against it by `check_used`.
"""

from collections.abc import Collection, Mapping
from dataclasses import dataclass, fields
from types import MappingProxyType
from typing import Any, cast

from lamc.basics.checks import checked_number, shown
from lamc.basics.errors import DesignError, ExportError
from lamc.basics.given import GivenMaybe, GivenNumber
from lamc.export.cuts.options import (
    DRAWN,
    STRAIGHT,
    checked_kerf,
    checked_pins,
    checked_stock,
    checked_style,
    checked_width,
)
from lamc.export.prefixes import check_prefix
from lamc.run.methods import AUTO, METHODS, NUMBERS

PRECISIONS = ("double", "float")
FIXED = tuple(method.name for method in METHODS.values() if method.has_fixed_steps)
FMI = 2  # most tools read it

# Fields as the command line calls them; the others cannot be chosen there.
FLAGS: Mapping[str, str] = MappingProxyType(
    {
        "prefix": "--prefix",
        "precision": "--float",
        "integrator": "--integrator",
        "real_time": "--real-time",
        "libm": "--no-libm",
        "single_header": "--single-header",
        "fmi": "--fmi",
        "inputs": "--inputs",
        "lossy": "--lossy",
        "step": "--step",
        "edge_length": "--size",
        "hinge_style": "--hinge-style",
        "hinge_width": "--hinge-width",
        "kerf": "--kerf",
        "pins": "--pins",
        "stock": "--sheet",
    }
)
_CUT = {
    "hinge_style": checked_style,
    "hinge_width": checked_width,
    "kerf": checked_kerf,
    "pins": checked_pins,
    "stock": checked_stock,
}


def named(field: str) -> str:
    """A field in a message: `--real-time (real_time)`."""
    return f"{FLAGS[field]} ({field})" if field in FLAGS else field


@dataclass(frozen=True)
class ExportOptions:
    """What is exported, and how.

    prefix      of all public names and of the files; None: from the name of the design
    precision   of all numbers: "double", or "float" for processors without doubles: with lamc's own functions, and for
                real_time
    integrator  of the adaptive step: "auto" links all methods; the name of one, such as "rk45" (explicit) or "radau5"
                (implicit), that one only. With "rodas5p" steps of fixed length are its steps, too, and stable however
                stiff the hinges; else they are those of the classical Runge-Kutta method
    real_time   no adaptive step: steps of fixed length and bounded cost only
    jacobian    with a function for the derivatives of the accelerations
    libm        call <math.h>; False: lamc's own functions, the same bits on every machine and compiler
    single_header  one file, NAME.h, with the source in it
    fmi         version of the standard of an FMU, 2 or 3; None: 2, which most tools read
    inputs      torques from outside: "hinges" on every one, "none", or a tuple of names of hinges; a scene that has
                `ExternalTorque` itself keeps its own
    lossy       of formats that cannot tell all of a scene: leave out what they cannot, instead of refusing it
    edge_length  m, of the mesh of a plate; None: as its file says
    step        s, time step of a model for MuJoCo; None: one that suits the mechanism

    Of cut files, lengths in m or as text with a unit:
    hinge_style  how boards are cut at hinges: "gap", straight; "castellated", with tabs by turns; "perforated", the
                flexible layer too, along the line. With a pitch: "castellated, 2 mm"
    hinge_width  of what is cut of boards along a hinge: "drawn", as it is simulated; "gap", the hinge's gap; a length
    kerf        width of what the cutter takes away
    pins        diameter of holes for pins, by which layers are put over one another; None: no holes
    stock       width and height of the sheets that are cut, "300 mm x 200 mm"; None: no sheet is drawn

    Raises ExportError for values of other kinds.
    """

    prefix: str | None = None
    precision: str = "double"
    integrator: str = "auto"
    real_time: bool = False
    jacobian: bool = True
    libm: bool = True
    single_header: bool = False
    fmi: int | None = None
    inputs: str | tuple[str, ...] = "hinges"
    lossy: bool = False
    step: float | None = None  # s
    edge_length: float | None = None  # m
    hinge_style: str = STRAIGHT
    hinge_width: str | float = DRAWN  # m
    kerf: GivenNumber = 0.0  # type: ignore[assignment]  # m
    pins: GivenMaybe = None  # type: ignore[assignment]  # m
    stock: str | tuple[float, float] | None = None  # m

    def __post_init__(self) -> None:
        if self.prefix is not None:
            check_prefix(self.prefix)
        for name, allowed in (("precision", PRECISIONS), ("integrator", tuple(NUMBERS))):
            if getattr(self, name) not in allowed:
                reported = ", ".join(map(repr, allowed))
                raise ExportError(
                    f"{named(name)} is {shown(getattr(self, name))}; it must be one of {reported}"
                )
        self._check_positive("step", "seconds")
        self._check_positive("edge_length", "metres")
        for name, check in _CUT.items():
            try:
                object.__setattr__(self, name, check(getattr(self, name), named(name)))
            except DesignError as error:
                raise ExportError(error.message) from error
        if self.fmi not in (None, 2, 3) or not isinstance(self.fmi, int | None):
            raise ExportError(
                f"{named('fmi')} is {shown(self.fmi)}; it must be 2 or 3, the version of the standard"
            )
        for name in ("real_time", "jacobian", "libm", "single_header", "lossy"):
            if not isinstance(getattr(self, name), bool):
                raise ExportError(f"{named(name)} is {shown(getattr(self, name))}; it must be True or False")
        are_names = isinstance(self.inputs, tuple) and all(isinstance(name, str) for name in self.inputs)
        if self.inputs not in ("hinges", "none") and not are_names:
            raise ExportError(
                f"{named('inputs')} is {shown(self.inputs)}; it must be 'hinges', 'none' or a tuple of names of hinges"
            )

    def _check_positive(self, name: str, unit: str) -> None:
        if getattr(self, name) is None:
            return
        try:
            value = checked_number(getattr(self, name), named(name), minimum=0.0)
        except DesignError as error:
            raise ExportError(error.message) from error
        if value == 0.0:
            raise ExportError(f"{named(name)} is 0; give {unit} above zero, or leave it out")
        object.__setattr__(self, name, value)

    @property
    def is_stiff(self) -> bool:
        """Whether steps of fixed length are those of an implicit method."""
        return self.integrator in FIXED

    @property
    def fixed_method(self) -> str:
        """What takes steps of fixed length, in words."""
        return (
            "Rodas5P, stable for every stiffness"
            if self.is_stiff
            else "the classical Runge-Kutta method of order 4"
        )

    @property
    def calls_libm(self) -> bool:
        return self.libm and self.precision == "double"

    @property
    def fmi_version(self) -> int:
        return FMI if self.fmi is None else self.fmi


def options_from(**values: object) -> ExportOptions:
    """Options by name. Raises ExportError for a name that is none."""
    known = [field.name for field in fields(ExportOptions)]
    for name in values:
        if name not in known:
            raise ExportError(f"there is no option {name!r} of an export; there are {', '.join(known)}")
    return ExportOptions(**cast(Any, values))  # __post_init__ looks at the values


def check_used(
    options: ExportOptions, by: str, read: Collection[str], uses: Mapping[str, Collection[str]]
) -> None:
    """Raises ExportError for options that were chosen and that nothing reads, by themselves or beside each other: what
    has no effect is not asked for.

    by    what is exported, in words, of which `read` are the fields that it reads
    uses  who else reads which, for the way out
    """
    usual = ExportOptions()
    names = [field.name for field in fields(options)]
    idle = [name for name in names if name not in read and getattr(options, name) != getattr(usual, name)]
    if not idle:
        _check_together(options)
        return
    it, they_are = ("it", "it is") if len(idle) == 1 else ("them", "they are")
    takers = [name for name, fields_read in uses.items() if set(idle) <= set(fields_read)]
    hint = f" ({they_are} for {', '.join(takers)})" if takers else ""
    raise ExportError(f"{', '.join(map(named, idle))}: {by} has no use for {it}; leave {it} out{hint}")


def _check_together(options: ExportOptions) -> None:
    """Raises ExportError for options that leave each other nothing to do, naming both."""
    if options.precision == "float" and not options.real_time:
        raise ExportError(
            f"{named('precision')} is 'float', whose round-off no control of errors copes with; choose steps of "
            "fixed length too: --real-time (real_time=True)"
        )
    if options.real_time and options.integrator not in (AUTO, *FIXED):
        raise ExportError(
            f"{named('integrator')} is {options.integrator!r}, which takes adaptive steps alone, and "
            f"{named('real_time')} leaves those out; leave out one of the two, or give {' or '.join(FIXED)}, which has "
            "steps of fixed length too"
        )
    if options.precision == "float" and not options.libm:
        raise ExportError(
            f"{named('libm')}: with {named('precision')} no mathematical library is called anyway; leave it out"
        )
