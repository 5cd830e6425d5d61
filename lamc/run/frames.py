"""Results as pandas and xarray objects, where those are installed. In: a `Result`. Out: a frame with its
own copy."""

from typing import TYPE_CHECKING

import numpy as np

from lamc.basics.errors import LamcError
from lamc.run.files import columns, others

if TYPE_CHECKING:
    import pandas
    import xarray

    from lamc.run.result import Result


def to_pandas(result: "Result") -> "pandas.DataFrame":
    """A DataFrame over t with the columns of the CSV. Raises LamcError without pandas."""
    try:
        import pandas  # optional, and slow to load
    except ImportError as error:
        raise LamcError("to_pandas needs pandas: pip install lamc[frames]") from error
    table = columns(result)
    index = pandas.Index(table.pop("t (s)").copy(), name="t (s)")
    return pandas.DataFrame({title: values.copy() for title, values in table.items()}, index=index)


def to_xarray(result: "Result") -> "xarray.Dataset":
    """A Dataset with `angle` and `rate` over (t, joint), other coordinates and rates by name over t, `energies`
    over (t, energy_name), and `energy` and `constraint_error` over t, each with its unit in `attrs`.

    Raises LamcError without xarray."""
    try:
        import xarray  # optional, and slow to load
    except ImportError as error:
        raise LamcError("to_xarray needs xarray: pip install lamc[frames]") from error
    energies = np.column_stack([np.zeros((len(result.t), 0)), *result.energies.values()])
    provenance = result.provenance
    count = len(result.joints)
    return xarray.Dataset(
        {
            "angle": (("t", "joint"), result.q[:, :count].copy(), {"units": "rad"}),
            "rate": (("t", "joint"), result.u[:, :count].copy(), {"units": "rad/s"}),
            **{title: (("t",), values.copy(), {"units": unit}) for title, unit, values in others(result)},
            "energies": (("t", "energy_name"), energies, {"units": "J"}),
            "energy": (("t",), result.energy.copy(), {"units": "J"}),
            "constraint_error": (("t",), result.constraint_error.copy(), {"units": "m"}),
        },
        coords={
            "t": ("t", result.t.copy(), {"units": "s"}),
            "joint": list(result.joints),
            "energy_name": list(result.energies),
        },
        attrs={"design": provenance.design, "digest": provenance.digest, "message": result.message},
    )
