"""A compiled model seen from numpy: names, parameters, and rows of accelerations, energies and poses.

In: the module that `build` loaded (its C side is `lamc_model` and the `lamc_motion_…` functions of lamc.h).
Out: arrays. Never: integrates; interprets names or physics.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from types import MappingProxyType
from typing import Any, Protocol, Self

import numpy as np

from lamc.basics.errors import UnsupportedError
from lamc.records.series import Series
from lamc.run.following import Following, Recorded, parted
from lamc.run.opened import Opened, OpenedPool
from lamc.run.parameters import checked_parameters
from lamc.run.remaking import Recipe, remade_model, remember
from lamc.run.request import Array
from lamc.symbolic.program import Coordinate, design_digest

NO_SERIES: Mapping[str, Series] = MappingProxyType({})


class CompiledModule(Protocol):
    """What `lamc.codegen.build.Module` offers to a run."""

    @property
    def ffi(self) -> Any: ...
    @property
    def lib(self) -> Any: ...
    @property
    def source_dir(self) -> Path: ...
    @property
    def compiler(self) -> str: ...
    @property
    def flags(self) -> tuple[str, ...]: ...


class Unchanging:
    """Base of what holds compiled code. It never changes, so a copy is the thing itself; it is pickled as what it was
    made from (`lamc.run.remaking`), and not at all where it was made by hand."""

    def __copy__(self) -> Self:
        return self

    def __deepcopy__(self, _memo: dict[int, Any]) -> Self:
        return self

    def __reduce__(self) -> tuple[Any, ...]:
        raise UnsupportedError(
            f"a {type(self).__name__} holds compiled code of this process and cannot be pickled; pickle the mechanism "
            "and the scene and compile them there (the cache makes it quick), or write a result with to_npz"
        )


@dataclass(frozen=True)
class DesignNumbers:
    """What tells a design from others of its structure.

    inputs  defaults of parameters, then numbers of the drawing, as the model's C takes them
    drawn   the state as drawn, (nq + nu,); empty: all zero
    """

    inputs: tuple[float, ...]
    drawn: tuple[float, ...] = ()


class Motion(Unchanging):
    """A model with one set of parameters: what an integrator evaluates and a `Result` asks for more.

    parameters  of the model in its order, then the numbers of the drawing
    following   the series that inputs follow

    States are rows y = [q, u], shape (m, nq + nu): coordinates, then rates; of joints first, rad and rad/s.
    Threads may share one: every call has memory of its own.
    """

    def __init__(
        self, model: "Model", parameters: Array, baumgarte: float = 0.0, series: tuple[Series, ...] = ()
    ) -> None:
        self.model = model
        self.parameters = parameters
        self.following = Following(model.series, series, model.series_orders, model.own_series)
        self._baumgarte = baumgarte
        constants = np.zeros(max(model.constant_count, 1))  # C wants an address even for none
        model.handle.setup(model.read(parameters), model.write(constants))
        constants.flags.writeable = False
        self.constants = constants
        recorded = Recorded(model.ffi, self.following, np.zeros(0)) if series else None
        self._pool = OpenedPool(model, constants, baumgarte, recorded)

    @property
    def gap(self) -> float:
        """The gap, m, that loops may keep where their equations disagree; 0: none."""
        return float(self.constants[-1]) if self.model.closure_count else 0.0

    def __reduce__(self) -> tuple[Any, ...]:
        return Motion, (self.model, self.parameters, self._baumgarte, self.following.series)

    def opened(self) -> Opened:
        """A `lamc_motion` for one caller: `with motion.opened() as handle`. What C keeps of `handle`, such as a
        `lamc_ode`, holds until the block ends."""
        return self._pool.opened()

    def closures(self, y: Array) -> Array:
        """Rows of residuals φ (m) and Jacobian J (m·nu, by rows) of the loops at states y (k, nq + nu)."""
        model = self.model
        out = np.zeros((len(y), model.closure_count * (len(model.rates) + 1)))
        self._on_own(model.lib.lamc_motion_closures, len(y), model.read(y), model.write(out))
        return out

    def accelerations(self, t: Array, y: Array) -> Array:
        """Derivatives of the rates, shape (m, nu), at times t (m,) s and states y (m, nq + nu)."""
        out = np.zeros((len(y), len(self.model.rates)))
        self._call(self.model.lib.lamc_motion_accelerations, len(y), t, y, out)
        return out

    def jacobian(self, t: float, y: Array) -> tuple[Array, Array]:
        """Derivatives of the accelerations by coordinates (nu, nq) and by rates (nu, nu), at one state y (nq + nu,)."""
        model = self.model
        nq, n = len(model.coordinates), len(model.rates)
        by_q, by_u, by_t = np.zeros((n, nq)), np.zeros((n, n)), np.zeros(n)
        scratch = np.zeros(model.lib.lamc_motion_jacobian_scratch(model.handle))
        write = [model.write(a) for a in (by_q, by_u, by_t, scratch)]
        self._on_own(model.lib.lamc_motion_jacobian, t, model.read(y), *write)
        return by_q, by_u

    @property
    def jacobian_cost(self) -> float:
        """What a Jacobian costs an implicit method, in evaluations of the accelerations."""
        return float(self._ode_member("jacobian_cost"))

    @property
    def is_rough(self) -> bool:
        """Whether accelerations have few continuous derivatives: methods of high order misjudge errors then."""
        return bool(self._ode_member("is_rough"))

    def energies(self, t: Array, y: Array) -> Array:
        """Energies, shape (m, len(model.energies)), J; kinetic first, then one for each effect that stores
        any."""
        out = np.zeros((len(y), len(self.model.energies)))
        self._call(self.model.lib.lamc_motion_energies, len(y), t, y, out)
        return out

    def powers(self, t: Array, y: Array) -> Array:
        """Power of the loads of each effect, shape (m, len(model.powers)), W."""
        out = np.zeros((len(y), len(self.model.powers)))
        self._call(self.model.lib.lamc_motion_powers, len(y), t, y, out)
        return out

    def poses(self, t: Array, y: Array) -> Array:
        """Poses of the moving bodies, shape (m, len(model.bodies), 12): com (3) m, rotation (9), row by
        row."""
        out = np.zeros((len(y), len(self.model.bodies), 12))
        self._call(self.model.lib.lamc_motion_poses, len(y), t, y, out)
        return out

    def rhs(self, t: float, y: Array) -> Array:
        """dy/dt at one state y (nq + nu,): of the coordinates, then of the rates."""
        row = np.ascontiguousarray(y).reshape(1, -1)
        accelerations = self.accelerations(np.array([t]), row)[0]
        return np.concatenate([self.coordinate_rates(row)[0], accelerations])

    def coordinate_rates(self, y: Array) -> Array:
        """Derivatives of the coordinates, shape (m, nq), at states y (m, nq + nu)."""
        model, nq = self.model, len(self.model.coordinates)
        if model.handle.rates == model.ffi.NULL:
            return y[:, nq:]
        found, constants = np.zeros((len(y), nq)), model.read(self.constants)
        for q, u, qdot in zip(y[:, :nq].copy(), y[:, nq:].copy(), found, strict=True):
            model.handle.rates(constants, model.read(q), model.read(u), model.write(qdot))
        return found

    def settled(self, t: float, y: Array) -> Array:
        """The state nearest to y (nq + nu,) where loops close, as far as one is near; y itself for a tree."""
        model, nearest = self.model, y.copy()
        if not model.cuts:
            return nearest
        moved = model.ffi.new("double *")
        with self.opened() as handle:
            model.lib.lamc_motion_settle(handle, t, model.write(nearest), moved)
        return nearest

    def _ode_member(self, name: str) -> float:
        with self.opened() as handle:
            return float(getattr(self.model.lib.lamc_motion_ode(handle), name))

    def _call(self, function: Any, count: int, t: Array, y: Array, out: Array) -> None:
        if self.following.series:
            self.following.check_times(t)
        self._on_own(function, count, self.model.read(t), self.model.read(y), self.model.write(out))

    def _on_own(self, function: Any, *arguments: Any) -> None:
        """Calls a function of the runtime on memory that no other thread has."""
        with self.opened() as handle:
            status = function(handle, *arguments)
        assert status == self.model.lib.LAMC_OK


class Model(Unchanging):
    """The names, counts and defaults of a compiled mechanism.

    recipe   what it was made from; None: by hand, and it cannot be pickled. tells: whether it tells powers
    numbers  of the design; None: those that the C was printed with
    series, series_orders  inputs that follow series, and the highest derivative of each that accelerations hold
    own_series  what they follow unless told otherwise
    structure, digest  of the program without numbers, which the C has, and with them
    """

    def __init__(
        self,
        module: CompiledModule,
        recipe: Recipe | None = None,
        *,
        tells: bool = False,
        numbers: "DesignNumbers | None" = None,
        series: Mapping[str, Series] = NO_SERIES,
    ) -> None:
        self._recipe, self._tells, self._entry = recipe, tells, str(module.source_dir)
        self.ffi: Any = module.ffi
        self.lib: Any = module.lib
        self.handle: Any = self.lib.lamc_this_model()
        handle = self.handle
        self.name = self._text(handle.name)
        self.joints = self._names(handle.joint_names, handle.joint_count)
        self.coordinates = self._named(
            handle.coordinate_names, handle.coordinate_units, handle.coordinate_count, "rad"
        )
        self.rates = self._named(handle.rate_names, handle.rate_units, handle.rate_count, "rad/s")
        self.powers = self._names(handle.power_names, handle.power_count)
        self.cuts = self.joints[len(self.joints) - int(handle.cut_count) :]
        self.closure_count = int(handle.closure_count)
        self.rank = int(handle.rank)
        self.guards = self._names(handle.guard_names, handle.guard_count)
        self.has_impacts = any(handle.guard_modes[i] == -1 for i in range(handle.guard_count))
        slots = (int(handle.guard_modes[i]) for i in range(handle.guard_count))
        self._mode_slots = tuple(slot for slot in slots if slot >= 0)
        self.has_clocks = bool(handle.clock_count)
        self.series = self._names(handle.series_names, handle.series_count)
        self.series_orders = tuple(int(handle.series_orders[i]) for i in range(handle.series_count))
        self.own_series = series
        self.bodies = self._names(handle.body_names, handle.body_count)
        self.energies = self._names(handle.energy_names, handle.energy_count)
        self.parameters = self._names(handle.parameter_names, handle.parameter_count)
        self.parameter_units = self._names(handle.parameter_units, handle.parameter_count)
        self.constant_count = int(handle.constant_count)
        own = [
            float(handle.parameter_defaults[i]) for i in range(handle.parameter_count + handle.geometry_count)
        ]
        numbers = numbers or DesignNumbers(tuple(own))
        self.defaults = numbers.inputs[: len(self.parameters)]
        self.geometry = numbers.inputs[len(self.parameters) :]
        self.structure = self._text(handle.digest)
        self.digest = design_digest(self.structure, numbers.inputs, numbers.drawn)
        if recipe is not None:
            remember(self, self._entry)

    def __reduce__(self) -> tuple[Any, ...]:
        if self._recipe is None:
            return super().__reduce__()
        return partial(remade_model, tells=self._tells), (self._recipe, self.digest, self._entry)

    @property
    def state_size(self) -> int:
        """nq + nu."""
        return len(self.coordinates) + len(self.rates)

    def motion(self, parameters: Mapping[str, "float | str | Series"], baumgarte: float = 0.0) -> Motion:
        """The model with these parameters, by name, and defaults for the rest; inputs follow series among them.

        baumgarte  1/s, rate at which loops that drifted close again; 0: states are projected on closure instead

        Raises RequestError for a name that is not there and for a value that its quantity cannot have.
        """
        parameters, series = parted(parameters, self.series, self.own_series, self.series_orders)
        values = dict(zip(self.parameters, self.defaults, strict=True))
        units = dict(zip(self.parameters, self.parameter_units, strict=True))
        values |= checked_parameters(parameters, units)
        inputs = [*values.values(), *self.geometry]
        return Motion(self, np.array(inputs or [0.0]), baumgarte, series)

    def modes(self, motion: Any) -> tuple[float, ...]:
        """Modes of the guards that a `lamc_motion` has now, 1 beyond a guard and 0 before, in their order."""
        return tuple(float(motion.constants[slot]) for slot in self._mode_slots)

    def read(self, array: Array) -> Any:
        """The address of a contiguous array, for C to read. The caller keeps the array alive."""
        assert array.flags.c_contiguous
        return self.ffi.from_buffer("double[]", array)

    def write(self, array: Array) -> Any:
        """The address of a contiguous array, for C to write. The caller keeps the array alive."""
        assert array.flags.c_contiguous
        return self.ffi.from_buffer("double[]", array, require_writable=True)

    def _text(self, pointer: Any) -> str:
        text: bytes = self.ffi.string(pointer)
        return text.decode("utf-8")

    def _named(self, names: Any, units: Any, count: int, usual: str) -> tuple[Coordinate, ...]:
        """Names with units; `usual` where there is no table of units."""
        known = [usual] * count if units == self.ffi.NULL else self._names(units, count)
        return tuple(map(Coordinate, self._names(names, count), known))

    def _names(self, pointers: Any, count: int) -> tuple[str, ...]:
        return tuple(self._text(pointers[i]) for i in range(count))
