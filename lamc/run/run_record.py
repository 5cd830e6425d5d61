"""What a run tells besides its rows: its cost, its events, and where it comes from.

In: plain values. Out: frozen records, which a `Result` carries and files keep. Never: computes.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field

from lamc.basics.brief import brief


@dataclass(frozen=True)
class RunStats:
    """What a run took."""

    integrator: str
    rtol: float
    atol: float  # rad and rad/s
    steps: int  # tried
    accepted: int
    rejected: int | None  # None: this integrator does not tell
    evaluations: int  # of the right-hand side
    last_step: float  # s
    wall_time: float  # s
    real_time_factor: float  # simulated seconds per second of wall time
    switches: tuple[
        tuple[float, str], ...
    ] = ()  # of "auto": s, and the integrator from there on; the first ones
    singular_steps: int = (
        0  # of the accepted ones, at singular positions, where equations of the loops were let go
    )
    max_step: float | None = None  # s, the limit that was asked for; None: none


@dataclass(frozen=True)
class Event:
    """A limit reached or left, or an impact."""

    t: float  # s
    name: str


@dataclass(frozen=True)
class Provenance:
    """Where a result comes from; written to the manifest beside each file."""

    design: str
    digest: str  # of the program
    lamc_version: str
    compiler: str
    flags: tuple[str, ...]
    effects: tuple[str, ...]
    parameters: Mapping[str, float] = field(default_factory=dict)  # every one, as used
    series: Mapping[str, str] = field(default_factory=dict)  # digest of what each input followed over time

    def __repr__(self) -> str:
        effects = ", ".join(self.effects)
        return brief(
            "Provenance", self.design, f"lamc {self.lamc_version}", f"digest {self.digest[:12]}…", effects
        )
