"""`CompileOptions`: everything a user can choose that changes the binary. What is not here cannot."""

import sys
from dataclasses import dataclass, field

from lamc.basics.checks import shown
from lamc.basics.errors import BuildError

PRECISIONS = ("double", "float")
# For C that is compiled for the machine at hand: lanes, whose number follows from its registers. No results change by
# it where contraction is off.
MACHINE = ("-march=native",)


MOST_RATES_IN_LOOPS = 10  # of models whose loops are solved side by side: LARGE of runtime_c/src/loop_dense.h


def why_alone(*, large_loops: bool, moves: bool, precision: str) -> str:
    """Why steps of a model are not taken side by side, for people; empty where they are."""
    if precision == "float":
        return "accelerations are evaluated in single precision"
    if large_loops:
        return f"loops of more than {MOST_RATES_IN_LOOPS} hinges are solved one run at a time"
    return "" if moves else "nothing moves"


@dataclass(frozen=True)
class CompileOptions:
    """How the generated C is compiled.

    compiler     command, e.g. "gcc" or "zig cc"; None: $LAMC_CC, $CC, cc, gcc, clang, then ziglang
    fast         allow contraction to fused multiply-add and the instructions of this machine; results then differ from
                 machine to machine in the last digits
    precision    "double", or "float": accelerations are evaluated in single precision, everything else in double;
                 its round-off, some 1e-7 of an acceleration, stays whatever the tolerance (1e-8 of an angle in the
                 pendulum), and steps that are to be more exact than that are tried in vain
    large        mechanisms are compiled that take minutes, by the number of their hinges and closing equations; no
                 binary changes by it

    Raises BuildError for values of other types.
    """

    compiler: str | None = None
    fast: bool = False
    precision: str = "double"
    large: bool = field(default=False, compare=False, repr=False)

    def __post_init__(self) -> None:
        if self.compiler is not None and not isinstance(self.compiler, str):
            raise BuildError(
                f"compiler is {shown(self.compiler)}; it must be a command such as 'gcc', or None"
            )
        if not isinstance(self.fast, bool):
            raise BuildError(f"fast is {shown(self.fast)}; it must be True or False")
        if not isinstance(self.large, bool):
            raise BuildError(f"large is {shown(self.large)}; it must be True or False")
        if self.precision not in PRECISIONS:
            raise BuildError(f"precision is {shown(self.precision)}; it must be 'double' or 'float'")

    @property
    def flags(self) -> tuple[str, ...]:
        """Compiler flags. -ffp-contract=off, so that results repeat from machine to machine. NaN and infinity keep
        their meaning in all of them: the runtime looks for them. LAMC_FLOAT changes nothing in C text that is float
        already; it lets keys of the cache and the provenance of results tell."""
        # Code on Windows is independent of its position by itself; clang takes -fPIC there for an error.
        position = () if sys.platform == "win32" else ("-fPIC",)
        common = ("-std=c11", "-O2", *position, *(("-DLAMC_FLOAT",) if self.precision == "float" else ()))
        if self.fast:
            return (*common, "-march=native", "-ffp-contract=fast")
        return (*common, "-ffp-contract=off")
