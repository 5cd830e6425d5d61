"""The integrators by name. In: a name, a `Motion`, a `Request`. Out: the name that was used and a
`Trajectory`."""

from lamc.errors import RequestError
from lamc.run import rk45
from lamc.run.model import Motion
from lamc.run.request import Request, Trajectory, did_you_mean

SCIPY_METHODS = ("RK23", "RK45", "DOP853", "Radau", "BDF", "LSODA")
NAMES = ("auto", "rk45", *(f"scipy:{method}" for method in SCIPY_METHODS))


def integrate(name: str, motion: Motion, request: Request) -> tuple[str, Trajectory]:
    """Runs the integrator of that name; "auto" is "rk45". Raises RequestError for a name that is not
    there."""
    if name not in NAMES:
        raise RequestError(f"no integrator is named {name!r}; {did_you_mean(name, NAMES)}")
    if name in ("auto", "rk45"):
        return "rk45", rk45.integrate(motion, request)
    from lamc.run import scipy_methods  # half a second to load, and most runs do not need it

    return name, scipy_methods.integrate(motion, request, name.removeprefix("scipy:"))
