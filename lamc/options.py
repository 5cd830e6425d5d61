"""`CompileOptions`: everything a user can choose that changes the binary. What is not here cannot."""

from dataclasses import dataclass

from lamc.errors import BuildError
from lamc.mechanism.checks import shown


@dataclass(frozen=True)
class CompileOptions:
    """How the generated C is compiled.

    compiler     command, e.g. "gcc" or "zig cc"; None: $LAMC_CC, $CC, cc, gcc, clang, then ziglang
    fast         allow contraction to fused multiply-add and the instructions of this machine; results then differ
                 from machine to machine in the last digits

    Raises BuildError for values of other types.
    """

    compiler: str | None = None
    fast: bool = False

    def __post_init__(self) -> None:
        if self.compiler is not None and not isinstance(self.compiler, str):
            raise BuildError(
                f"compiler is {shown(self.compiler)}; it must be a command such as 'gcc', or None"
            )
        if not isinstance(self.fast, bool):
            raise BuildError(f"fast is {shown(self.fast)}; it must be True or False")

    @property
    def flags(self) -> tuple[str, ...]:
        """Compiler flags. -ffp-contract=off, so that results repeat from machine to machine."""
        common = ("-std=c11", "-O2", "-fPIC")
        return (
            (*common, "-march=native", "-ffp-contract=fast") if self.fast else (*common, "-ffp-contract=off")
        )
