"""What measures can name: outputs of runs, their events, and what is varied from run to run.

In: units by name. Out: `Outputs`, which gives the term of a name. Raises ExpressionError for what is none, with the
nearest one.
"""

from collections.abc import Mapping
from dataclasses import dataclass

from lamc.basics.checks import did_you_mean
from lamc.basics.errors import ExpressionError
from lamc.basics.readonly import ReadOnlyDict
from lamc.studies.dimensions import is_unit, unit_of
from lamc.studies.measure_terms import Term, parameter, quantity

NOTHING_GIVEN: Mapping[str, float] = ReadOnlyDict({})  # where nothing was varied


@dataclass(frozen=True)
class Outputs:
    """What the runs of a simulator tell: SI units of quantities by name, and the names of events. varied: SI units of
    what is varied from run to run, by name."""

    units: Mapping[str, str]
    events: tuple[str, ...] = ()
    varied: Mapping[str, str] = ReadOnlyDict({})

    def knows(self, name: str) -> bool:
        return name in self.units or name in self.varied

    def term(self, name: str) -> Term:
        """Of a name. Raises ExpressionError."""
        if name in self.varied and name in self.units:
            raise ExpressionError(
                f"{name!r} names an output of the run, and a dimension that is varied; rename the dimension"
            )
        if name in self.varied:
            return parameter(name, unit_of(self.varied[name]))
        if name in self.units:
            return quantity(name, unit_of(self.units[name]))
        hint = did_you_mean(name, [*self.units, *self.varied])
        if is_unit(name):
            hint = "as a unit it stands behind its number: put both into parentheses, (5 N*mm)"
        longer = next((known for known in self.units if _is_cut_off(name, known)), None)
        if longer is not None:
            hint = f'a name with other characters stands between quotes: "{longer}"'
        raise ExpressionError(f"no output of a run is named {name!r}; {hint}")

    def of(self, names: frozenset[str]) -> "Outputs":
        """Those of some names alone, in their order, with all events."""
        units, varied = (
            {name: each[name] for name in sorted(names) if name in each} for each in (self.units, self.varied)
        )
        return Outputs(units, self.events, varied)


def _is_cut_off(name: str, known: str) -> bool:
    """Whether a name is what is read of a known one without quotes: "link" of "link 2.x"."""
    return known.startswith(name) and not _is_plain(known) and not known[len(name) :][:1].isalnum()


def _is_plain(name: str) -> bool:
    """Whether a name can stand without quotes."""
    return name.isascii() and all(part.isidentifier() for part in name.split("."))
