"""The part of a `Simulator` that tells of operating points: where it stays at rest, and how it moves nearby.

In: what a user asks. Out: `Equilibrium`, `LinearModel`, `Modes`. What finds them is imported when it is first needed.
"""

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, cast

from lamc.run.evaluations import NO_PARAMETERS

if TYPE_CHECKING:
    from lamc.run.equilibrium import Equilibrium
    from lamc.run.linear_model import LinearModel
    from lamc.run.simulator import Simulator
    from lamc.run.vibration import Modes


class OperatingPoints:
    """Base of `Simulator`."""

    @property
    def _simulator(self) -> "Simulator":
        return cast("Simulator", self)

    def equilibrium(
        self,
        angles: "Mapping[str, float | str] | Equilibrium | None" = None,
        parameters: Mapping[str, float | str] = NO_PARAMETERS,
        *,
        t: float | None = None,
        stable: bool = False,
    ) -> "Equilibrium":
        """The position at rest in which all forces balance and the loops are closed, next to a start.

        angles      to start from, by joint, rad or text with a unit, in place of the scene's; loops are closed around
                    them as `start` is. Or an equilibrium, of other parameters for example
        parameters  by name, in the units of `parameter_units`, or text with a unit; the others keep their defaults
        t           s: loads that depend on time are held as they are then; None: there may be none
        stable      True: only a stable one: from the start on, where the loads push. Else the next, stable or not;
                    where none is found that way, the one that loads push to, and its `way` says so

        Newton's method in a trust region, with exact derivatives along the closed positions where the model has them;
        the position is known to about 1e-12 rad where its stiffness is not near zero. `kind` tells whether it is
        stable. Raises SimulationError, with the reason, where no equilibrium is within reach, at singular positions and
        where a contact is about to be made or lost; RequestError for arguments that make no sense, and for loads that
        change with time if t is not given.
        """
        from lamc.run.equilibrium import equilibrium_of

        return equilibrium_of(self._simulator, angles, parameters, t, stable=stable)

    def equilibria(
        self,
        starts: int | Sequence[Mapping[str, float | str]] = 20,
        parameters: Mapping[str, float | str] = NO_PARAMETERS,
        *,
        t: float | None = None,
        stable: bool = False,
    ) -> "tuple[Equilibrium, ...]":
        """All equilibria that are found from several starts, each once, by stored energy and then by angles.

        starts  angles by joint to start from; or how many: the scene's, and others that are spread evenly within 2 rad
                of it over as many joints as there are degrees of freedom, always the same ones. More starts may find
                more: none says that it has all

        parameters, t and stable as for `equilibrium`. Starts from which nothing is found, or whose loops do not close,
        are passed over. Raises the first one's error where that are all.
        """
        from lamc.run.equilibrium import equilibria_of

        return equilibria_of(self._simulator, starts, parameters, t, stable=stable)

    def linearise(
        self,
        point: "Equilibrium",
        inputs: Sequence[str] | None = None,
        outputs: Sequence[str] | None = None,
        *,
        independent: Sequence[str] | None = None,
    ) -> "LinearModel":
        """The linear model x' = A x + B w, y = C x + D w about an equilibrium, of small deviations, in SI units.

        inputs       parameters by name, such as inputs of the scene, or any other; None: the inputs of the scene
        outputs      quantities as `Result.quantity` has them: "h1", "h1.rate", "tip.x"; None: the scene's outputs, or
                     all joints
        independent  coordinates by name whose deviations and rates are the state; None: a choice that depends on no
                     round-off, joints of the tree first where they are as good as others

        Exact derivatives along the closed positions where the model has them (up to 12 rates), extrapolated differences
        elsewhere and by parameters, with an estimate of their error in `errors`. Raises RequestError for what is no
        equilibrium of this simulator and for names that are not there.
        """
        from lamc.run.linear_model import linear_model_of

        return linear_model_of(self._simulator, point, inputs, outputs, independent)

    def modes(self, point: "Equilibrium | None" = None, *, damping: bool = True) -> "Modes":
        """Frequencies, damping ratios and shapes of the small motions about an equilibrium; None: the one next to the
        scene's start. damping: False: without it, as if nothing were lost.

        Raises as `equilibrium` does, and RequestError for what is no equilibrium of this simulator."""
        from lamc.run.vibration import modes_of

        return modes_of(self._simulator, point, damping=damping)
