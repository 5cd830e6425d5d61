"""What a simulator evaluates at single states: accelerations and their derivatives, energies, closure.

In: a `Model`, and what a user passes for states. Out: arrays. Never: integrates.
"""

from collections.abc import Mapping
from types import MappingProxyType

import numpy as np
import numpy.typing as npt

from lamc.basics.errors import RequestError
from lamc.basics.once import lazy
from lamc.run.arguments import numbers, states
from lamc.run.model import Model, Motion, Unchanging
from lamc.run.request import Array
from lamc.symbolic.program import Coordinate

NO_PARAMETERS: Mapping[str, float] = MappingProxyType({})


class Evaluations(Unchanging):
    """The part of a `Simulator` that asks the compiled model for one state after the other."""

    def __init__(self, model: Model) -> None:
        self._model = model

    @property
    def model(self) -> Model:
        """The compiled model, for what is made of it."""
        return self._model

    @property
    def joints(self) -> tuple[str, ...]:
        return self._model.joints

    @property
    def coordinates(self) -> tuple[Coordinate, ...]:
        """Names and units of q: the joints, then what effects add."""
        return self._model.coordinates

    @property
    def rates(self) -> tuple[Coordinate, ...]:
        """Names and units of u."""
        return self._model.rates

    @property
    def freedoms(self) -> int:
        """Degrees of freedom: rates that loops leave independent."""
        return len(self.rates) - self._model.rank

    @property
    def cut_joints(self) -> tuple[str, ...]:
        """Names of the last of `joints`, which close loops."""
        return self._model.cuts

    @lazy
    def parameters(self) -> Mapping[str, float]:
        return MappingProxyType(dict(zip(self._model.parameters, self._model.defaults, strict=True)))

    @lazy
    def parameter_units(self) -> Mapping[str, str]:
        return MappingProxyType(dict(zip(self._model.parameters, self._model.parameter_units, strict=True)))

    def acceleration(
        self,
        q: npt.ArrayLike,
        u: npt.ArrayLike,
        t: npt.ArrayLike = 0.0,
        parameters: Mapping[str, float | str] = NO_PARAMETERS,
    ) -> Array:
        """Derivatives of the rates, shape (…, nu), of joints rad/s², at coordinates q (…, nq), of joints rad, rates
        u (…, nu) and times t (…), s. The leading shapes broadcast. Raises RequestError for other shapes."""
        times, rows, shape = states(q, u, t, self._model)
        return self._motion(parameters).accelerations(times, rows).reshape(*shape, len(self.rates))

    def jacobian(
        self,
        q: npt.ArrayLike,
        u: npt.ArrayLike,
        t: float = 0.0,
        parameters: Mapping[str, float | str] = NO_PARAMETERS,
    ) -> tuple[Array, Array]:
        """Derivatives of the accelerations by the coordinates, shape (nu, nq), of joints 1/s², and by the rates, shape
        (nu, nu), of joints 1/s, at coordinates q (nq,), rates u (nu,) and time t, s: [i, j] is that of i by j.

        Loops hold: the derivatives are those of the accelerations under closure. Raises RequestError for other
        shapes."""
        times, rows, shape = states(q, u, t, self._model)
        if shape:
            raise RequestError(f"jacobian takes one state; these are {shape} of them")
        return self._motion(parameters).jacobian(float(times[0]), rows[0])

    def energy(
        self,
        q: npt.ArrayLike,
        u: npt.ArrayLike,
        t: npt.ArrayLike = 0.0,
        parameters: Mapping[str, float | str] = NO_PARAMETERS,
    ) -> Array:
        """Kinetic plus stored energy, shape (…), J, at coordinates q (…, nq), rates u (…, nu) and times t (…)."""
        times, rows, shape = states(q, u, t, self._model)
        total: Array = self._motion(parameters).energies(times, rows).sum(axis=1).reshape(shape)
        return total

    def closure(self, q: npt.ArrayLike) -> tuple[Array, Array]:
        """Residuals φ, shape (m,), m, of the loops' equations and their Jacobian J, shape (m, nu), of joints m/rad, by
        which φ̇ = J u, at coordinates q (nq,); m is 0 for a tree. Raises RequestError for another shape."""
        angles = numbers(q, "q")
        nq, nu, m = len(self.coordinates), len(self.rates), self._model.closure_count
        if angles.shape != (nq,):
            what = "one angle per joint" if nq == len(self.joints) else "one number per coordinate"
            raise RequestError(f"q has shape {angles.shape}; it must be ({nq},), {what}")
        row = np.concatenate([angles, np.zeros(nu)]).reshape(1, -1)
        flat = self._motion(NO_PARAMETERS).closures(row)[0]
        return flat[:m], flat[m:].reshape(m, nu)

    @lazy
    def _default_motion(self) -> Motion:
        return self._model.motion(NO_PARAMETERS)

    def _motion(self, parameters: Mapping[str, float | str], baumgarte: float = 0.0) -> Motion:
        if parameters is not NO_PARAMETERS or baumgarte:
            return self._model.motion(parameters, baumgarte)
        return self._default_motion
