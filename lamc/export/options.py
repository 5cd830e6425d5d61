"""`ExportOptions`: everything a user can choose of an export. What is not here cannot be chosen."""

from dataclasses import dataclass, fields
from typing import Any, cast

from lamc.errors import DesignError, ExportError
from lamc.export.prefixes import check_prefix
from lamc.mechanism.checks import checked_number, shown

PRECISIONS = ("double", "float")
INTEGRATORS = ("auto", "rk45", "dop853", "rodas5p", "radau5")


@dataclass(frozen=True)
class ExportOptions:
    """What is exported, and how.

    prefix      of all public names and of the files; None: from the name of the design
    precision   of all numbers: "double", or "float" for processors without doubles: with lamc's own functions, and for
                real_time
    integrator  of the adaptive step: "auto" links all four methods; "rk45", "dop853" (explicit), "rodas5p", "radau5"
                (implicit) that one only
    real_time   no adaptive step: steps of fixed length and bounded cost only
    jacobian    with a function for the derivatives of the accelerations
    libm        call <math.h>; False: lamc's own functions, the same bits on every machine and compiler
    single_header  one file, NAME.h, with the source in it
    fmi         version of the standard of an FMU, 2 or 3; 2 is what most tools read
    inputs      torques from outside: "hinges" on every one, "none", or a tuple of names of hinges; a scene that has
                `ExternalTorque` itself keeps its own
    lossy       of formats that cannot tell all of a scene: leave out what they cannot, instead of refusing it
    edge_length  m, of the mesh of a plate; None: as its file says
    step        s, time step of models for other engines; None: one that suits the mechanism

    Raises ExportError for values of other kinds.
    """

    prefix: str | None = None
    precision: str = "double"
    integrator: str = "auto"
    real_time: bool = False
    jacobian: bool = True
    libm: bool = True
    single_header: bool = False
    fmi: int = 2
    inputs: str | tuple[str, ...] = "hinges"
    lossy: bool = False
    step: float | None = None  # s
    edge_length: float | None = None  # m

    def __post_init__(self) -> None:
        if self.prefix is not None:
            check_prefix(self.prefix)
        for name, allowed in (("precision", PRECISIONS), ("integrator", INTEGRATORS)):
            if getattr(self, name) not in allowed:
                told = ", ".join(map(repr, allowed))
                raise ExportError(f"{name} is {shown(getattr(self, name))}; it must be one of {told}")
        if self.precision == "float" and not self.real_time:
            raise ExportError(
                "precision is 'float', whose round-off no control of errors copes with; choose steps of fixed length "
                "too: real_time=True, --real-time"
            )
        self._check_positive("step", "the step of an export", "seconds")
        self._check_positive("edge_length", "the edge length of an export", "metres")
        if self.fmi not in (2, 3) or not isinstance(self.fmi, int):
            raise ExportError(f"fmi is {shown(self.fmi)}; it must be 2 or 3, the version of the standard")
        for name in ("real_time", "jacobian", "libm", "single_header", "lossy"):
            if not isinstance(getattr(self, name), bool):
                raise ExportError(f"{name} is {shown(getattr(self, name))}; it must be True or False")
        are_names = isinstance(self.inputs, tuple) and all(isinstance(name, str) for name in self.inputs)
        if self.inputs not in ("hinges", "none") and not are_names:
            raise ExportError(
                f"inputs is {shown(self.inputs)}; it must be 'hinges', 'none' or a tuple of names of hinges"
            )

    def _check_positive(self, name: str, what: str, unit: str) -> None:
        if getattr(self, name) is None:
            return
        try:
            value = checked_number(getattr(self, name), what, minimum=0.0)
        except DesignError as error:
            raise ExportError(error.message) from error
        if value == 0.0:
            raise ExportError(f"{what} is 0; give {unit} above zero, or None")
        object.__setattr__(self, name, value)

    @property
    def calls_libm(self) -> bool:
        return self.libm and self.precision == "double"


def options_from(**values: object) -> ExportOptions:
    """Options by name. Raises ExportError for a name that is none."""
    known = [field.name for field in fields(ExportOptions)]
    for name in values:
        if name not in known:
            raise ExportError(f"there is no option {name!r} of an export; there are {', '.join(known)}")
    return ExportOptions(**cast(Any, values))  # __post_init__ looks at the values
