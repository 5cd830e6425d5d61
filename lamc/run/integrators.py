"""The integrators by name. In: a name, a `Motion`, a `Request`. Out: the name that was used and a
`Trajectory`."""

from lamc.basics.errors import RequestError
from lamc.run import native
from lamc.run.methods import NUMBERS
from lamc.run.model import Motion
from lamc.run.request import Request, Trajectory, did_you_mean

SCIPY_METHODS = ("RK23", "RK45", "DOP853", "Radau", "BDF", "LSODA")
NAMES = (*NUMBERS, *(f"scipy:{method}" for method in SCIPY_METHODS))


def integrate(name: str, motion: Motion, request: Request) -> tuple[str, Trajectory]:
    """Runs the integrator of that name. Raises RequestError for a name that is not there, and for one that cannot do
    what the scene calls for."""
    if name not in NAMES:
        raise RequestError(f"no integrator is named {name!r}; {did_you_mean(name, NAMES)}")
    if name in NUMBERS:
        return native.integrate(motion, request, name)
    if request.energy_balance:
        raise RequestError(
            f"integrator {name!r} keeps no energy balance; use one of lamc's own, such as 'auto'"
        )
    if motion.model.has_impacts:
        raise RequestError(f"integrator {name!r} finds no impacts, and the scene has some; use 'auto'")
    from lamc.run import scipy_methods  # half a second to load, and most runs do not need it

    return name, scipy_methods.integrate(motion, request, name.removeprefix("scipy:"))
