"""The records of a ledger: what accuracy costs, what effects change and cost, and what follows for a user.

Plain data, made by `lamc.ledger.measure`. Errors are relative: the largest difference from the reference over the range
of an output (`Output.scale`), or of the rates (`Ledger.rate_scales`). Times are processor time of one warm run.
"""

from dataclasses import dataclass

from lamc.run.methods import NAMES

DECADES = tuple(float(f"1e-{k}") for k in range(3, 13))
TARGETS = (1e-2, 1e-3, 1e-6)  # relative errors that the verdict is about


@dataclass(frozen=True)
class Sweep:
    """What a ledger is asked for.

    accuracy     relative to the range of an output: what changes it by less does not matter
    tolerances   rtol of the runs, loosest first; atol is a hundredth of it, as in a run
    integrators  of lamc and scipy by name, as `Simulator.run` takes them, then peers: "cvode", "mujoco"
    rows         times at which runs are compared, evenly spread
    budget       s of wall time for the whole; what does not fit is left out, and told
    """

    t_end: float = 10.0  # s
    accuracy: float = 1e-2
    tolerances: tuple[float, ...] = DECADES
    integrators: tuple[str, ...] = (
        *NAMES,
        *("scipy:DOP853", "scipy:LSODA", "cvode", "mujoco"),
    )
    rows: int = 201
    budget: float = 30.0  # s


@dataclass(frozen=True)
class Output:
    """A quantity that the user cares about, and the scale of its errors."""

    name: str
    unit: str
    lowest: float  # over the reference run
    highest: float
    scale: float  # what its errors are relative to, in its unit


@dataclass(frozen=True)
class Reference:
    """The run that errors are measured against, and how far it can be trusted.

    uncertainty        largest difference of the two runs that agree best, relative: the floor of what can be reported
    rates_uncertainty  the same of the rates
    growth             how much a small change of the start has grown by the end, at most; None: not known
    sensitive_after    s, when that growth passes 1000; None: it never does
    events             of the run: limits, touches, impacts
    events_differ_after  s, when the second run ceases to have the same ones; None: it never does
    """

    integrator: str
    rtol: float
    second: str
    second_rtol: float
    uncertainty: float
    rates_uncertainty: float
    growth: float | None
    sensitive_after: float | None
    events: int = 0
    events_differ_after: float | None = None

    @property
    def is_one_method(self) -> bool:
        """No second method arrived: the two runs are of one."""
        return self.integrator == self.second


@dataclass(frozen=True)
class Point:
    """One setting of one integrator. What is None was not measured, and `note` says why.

    setting    rtol; of a tool with fixed steps its step, s
    end, path, rates   relative errors: outputs at t_end, outputs at all times, rates at all times
    closure    largest gap of loops over the mechanism's size
    drift      largest change of the energy over the largest kinetic energy; None where something dissipates or drives
    is_floor   the error is no larger than the uncertainty of the reference
    """

    integrator: str
    is_peer: bool
    setting: float
    is_step: bool
    succeeded: bool
    note: str = ""
    used: str = ""  # integrators that "auto" took
    seconds: float | None = None
    repeats: int = 0
    steps: int | None = None
    rejected: int | None = None
    evaluations: int | None = None
    end: float | None = None
    path: float | None = None
    rates: float | None = None
    closure: float | None = None
    drift: float | None = None
    is_floor: bool = False


@dataclass(frozen=True)
class ObservedOrder:
    """Slopes of log error over log steps, from `points` settings; None where too few can be used or no line fits.

    end, path  of the errors at t_end, and at all times, most of which lie within steps
    theory, path_theory  of the method at its steps, and of its polynomial between them; None where it has no one order
    """

    integrator: str
    end: float | None
    path: float | None
    theory: float | None
    path_theory: float | None
    points: int


@dataclass(frozen=True)
class EffectRow:
    """A scene that differs from the ledger's by one effect or some, and what that does.

    is_added        True: an effect that the design asks for and the scene lacks was added
    form            the other form of the effect that took its place, in its own words; empty: the effect was left out
    change          of the outputs, relative: model error of leaving it out; both runs at a tight tolerance
    changes         the same by output
    discretisation  what of `change` may be the integrator's doing
    operations      flops of one evaluation, and ns, steps, seconds of a run at the setting of the account
    compiling       s from equations to a loaded module, no cache
    """

    effects: tuple[str, ...]
    is_added: bool
    succeeded: bool
    form: str = ""
    note: str = ""
    change: float | None = None
    changes: dict[str, float] | None = None
    discretisation: float | None = None
    operations: int | None = None
    evaluation: float | None = None  # ns
    steps: int | None = None
    seconds: float | None = None
    compiling: float | None = None


@dataclass(frozen=True)
class Account:
    """The scene itself as a row without effects, at one setting, then what each effect does."""

    integrator: str
    rtol: float
    scene: EffectRow
    rows: tuple[EffectRow, ...]
    together: EffectRow | None  # without all effects that change less than the accuracy asked for


@dataclass(frozen=True)
class ArithmeticRow:
    """The same equations compiled in another way. floor: the least path error that any tolerance reached."""

    name: str
    flags: tuple[str, ...]
    succeeded: bool
    note: str = ""
    evaluation: float | None = None  # ns
    seconds: float | None = None
    floor: float | None = None
    floor_rtol: float | None = None


@dataclass(frozen=True)
class Cheapest:
    """The cheapest measured setting of lamc whose path error is at most `target`; None where there is none."""

    target: float
    point: Point | None


@dataclass(frozen=True)
class Verdict:
    """What follows, and the same in lines for people."""

    cheapest: tuple[Cheapest, ...]
    idle: tuple[str, ...]  # effects that together change less than the accuracy asked for
    saved: float | None  # share of the run's time that leaving them out saves
    lines: tuple[str, ...]


@dataclass(frozen=True)
class Ledger:
    """Everything that was measured on one design in one scene.

    interrupted  what was under way when Ctrl-C ended the measuring; empty: it is complete
    """

    design: str
    digest: str
    effects: tuple[str, ...]
    sweep: Sweep
    outputs: tuple[Output, ...]
    rate_scales: dict[str, float]  # by unit: what errors of rates are relative to
    reference: Reference
    points: tuple[Point, ...]
    orders: tuple[ObservedOrder, ...]
    account: Account | None
    arithmetic: tuple[ArithmeticRow, ...]
    verdict: Verdict
    notes: tuple[str, ...]  # what was left out, and what a reader should know
    seconds: float  # that the measuring took
    versions: dict[str, str]  # lamc, compiler, flags, machine, peers
    interrupted: str = ""
