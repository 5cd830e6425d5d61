"""Mechanisms and designs made by hand: a Python function of dimensions.

In: a function, and what its arguments are. Out: records that know their `parameters`, and are made again with others.
"""

import inspect
import sys
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any, Generic, TypeVar

from lamc.basics.checks import did_you_mean, shown
from lamc.basics.errors import DesignError, Place
from lamc.basics.readonly import ReadOnlyDict
from lamc.records.parameters import DesignParameter, Varied, checked_values, with_origin

R = TypeVar("R", bound=Varied)


class Family(Generic[R]):
    """A function from dimensions to a Mechanism, or a Design, with the dimensions as its `parameters`.

        @lamc.Family
        def pendulum(length="0.4 m", mass=lamc.DesignParameter("0.1 kg", minimum=0.01)):
            return lamc.Mechanism(bodies=…, joints=…)

        pendulum()                       # a Mechanism, with the defaults
        pendulum(length="0.5 m")         # another; the function is called with numbers, SI
        pendulum().with_parameters(length=0.5)

    function    takes each parameter by its name, and returns a fresh record; equal for equal numbers
    parameters  by name, each a `DesignParameter`, a number, or text with a unit; None: the defaults of its arguments

    What takes a design with parameters takes a family too: it has `parameters` and `with_parameters`. A family can be
    given to other processes where the function stands at the top of a module.

    Raises DesignError for parameters that the function does not take, and for arguments that have no default.
    """

    def __init__(
        self,
        function: Callable[..., R],
        parameters: Mapping[str, DesignParameter | float | str] | None = None,
    ) -> None:
        if not callable(function):
            raise DesignError(f"a family is made of {shown(function)}; give a function of dimensions")
        self.function = function
        self.name = getattr(function, "__name__", "family")
        said = _defaults(function, self.name) if parameters is None else parameters
        if not isinstance(said, Mapping):
            raise DesignError(f"the parameters of family {self.name!r} are {shown(said)}; give them by name")
        self._parameters = ReadOnlyDict({name: _parameter(name, each) for name, each in said.items()})
        _check_arguments(function, self.name, self._parameters)
        self.__doc__ = function.__doc__
        self.__module__ = getattr(function, "__module__", __name__)

    def __reduce__(self) -> Any:
        """By its name where it took its function's, as a decorator does: this cannot be found by that name then."""
        module, name = sys.modules.get(self.__module__), getattr(self.function, "__qualname__", "")
        if getattr(module, name, None) is self:
            return name
        return Family, (self.function, self._parameters)

    def __repr__(self) -> str:
        return f"<Family {self.name!r} of {', '.join(self._parameters)}>"

    @property
    def parameters(self) -> Mapping[str, DesignParameter]:
        """By name, SI, with their defaults."""
        return self._parameters

    def with_parameters(self, values: Mapping[str, float | str] | None = None, /, **named: float | str) -> R:
        """The record with these values in the place of the defaults: see `Mechanism.with_parameters`."""
        member = _Member(self, self._parameters)
        made: R = member.made(checked_values(member, values, named))
        return made

    __call__ = with_parameters


@dataclass(frozen=True, eq=False)
class _Member:
    """The recipe of one record of a family: see `lamc.records.parameters.Recipe`."""

    family: Family[Any]
    parameters: Mapping[str, DesignParameter]

    @property
    def given(self) -> Mapping[str, float]:
        return {name: each.default for name, each in self.parameters.items()}

    @property
    def listed(self) -> Mapping[str, DesignParameter]:
        return self.parameters

    def made(self, values: Mapping[str, float]) -> Any:
        known = {
            name: replace(each, default=values.get(name, each.default))
            for name, each in self.parameters.items()
        }
        record = self.family.function(**{name: each.default for name, each in known.items()})
        if not isinstance(record, Varied):
            raise DesignError(
                f"the function of family {self.family.name!r} returned {shown(record)}; it must return a Mechanism or "
                "a Design"
            )
        return with_origin(replace(record), _Member(self.family, ReadOnlyDict(known)))  # type: ignore[type-var]

    def place(self, name: str) -> Place | None:
        return None


def _parameter(name: object, value: object) -> DesignParameter:
    if not isinstance(name, str) or not name.isidentifier():
        raise DesignError(f"a parameter is named {shown(name)}; it must be the name of an argument")
    if isinstance(value, DesignParameter):
        return value
    try:
        return DesignParameter(value)  # type: ignore[arg-type]  # refuses what is no number
    except DesignError as error:
        raise DesignError(f"parameter {name!r}: {error.message}") from error


def _defaults(function: Callable[..., Any], name: str) -> dict[str, Any]:
    found = {}
    for each in inspect.signature(function).parameters.values():
        if each.kind in (each.VAR_KEYWORD, each.VAR_POSITIONAL):
            raise DesignError(
                f"the function of family {name!r} takes *{each.name}; say its parameters one by one"
            )
        if each.default is each.empty:
            raise DesignError(
                f"the argument {each.name!r} of family {name!r} has no default; give it one, such as "
                f'{each.name}="40 mm", or name all: lamc.Family(function, parameters={{…}})'
            )
        found[each.name] = each.default
    return found


def _check_arguments(
    function: Callable[..., Any], name: str, parameters: Mapping[str, DesignParameter]
) -> None:
    """Raises DesignError where the function cannot be called with the parameters by their names."""
    arguments = inspect.signature(function).parameters
    takes_any = any(each.kind == each.VAR_KEYWORD for each in arguments.values())
    for each in parameters:
        if each not in arguments and not takes_any:
            raise DesignError(
                f"the function of family {name!r} takes no {each!r}; {did_you_mean(each, list(arguments))}"
            )
    for each, argument in arguments.items():
        if (
            each not in parameters
            and argument.default is argument.empty
            and argument.kind
            not in (
                argument.VAR_KEYWORD,
                argument.VAR_POSITIONAL,
            )
        ):
            raise DesignError(
                f"the argument {each!r} of family {name!r} is none of its parameters, and has no default"
            )
