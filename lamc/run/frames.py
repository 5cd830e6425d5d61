"""Results as pandas and xarray objects, where those are installed. In: a `Result`. Out: a frame with its
own copy."""

from typing import TYPE_CHECKING

from lamc.basics.errors import LamcError
from lamc.run.files import columns, others, positions, table

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
    found = columns(result)
    index = pandas.Index(found.pop("t (s)").copy(), name="t (s)")
    return pandas.DataFrame({title: values.copy() for title, values in found.items()}, index=index)


def to_xarray(result: "Result") -> "xarray.Dataset":
    """A Dataset with `angle` and `rate` over (t, joint), other coordinates and rates by name over t, `output` over
    (t, output_name), its units over output_name, `energies` over (t, energy_name), and `energy` and
    `constraint_error` over t, each with its unit in `attrs`. Joints are all hinges, in the design's order.

    Raises LamcError without xarray."""
    try:
        import xarray  # optional, and slow to load
    except ImportError as error:
        raise LamcError("to_xarray needs xarray: pip install lamc[frames]") from error
    provenance = result.provenance
    rows, hinges = len(result.t), result.hinges
    outputs = positions(result)
    return xarray.Dataset(
        {
            "angle": (("t", "joint"), table([result.angle(h) for h in hinges], rows), {"units": "rad"}),
            "rate": (("t", "joint"), table([result.rate(h) for h in hinges], rows), {"units": "rad/s"}),
            **{
                title: (("t",), values.copy(), {"units": unit})
                for title, unit, values in others(result)
                if title not in hinges
            },
            "output": (("t", "output_name"), table([each.values for each in outputs], rows), {}),
            "output_unit": (("output_name",), [each.unit for each in outputs], {}),
            "energies": (("t", "energy_name"), table(list(result.energies.values()), rows), {"units": "J"}),
            "energy": (("t",), result.energy.copy(), {"units": "J"}),
            "constraint_error": (("t",), result.constraint_error.copy(), {"units": "m"}),
        },
        coords={
            "t": ("t", result.t.copy(), {"units": "s"}),
            "joint": list(hinges),
            "output_name": [each.name for each in outputs],
            "energy_name": list(result.energies),
        },
        attrs={"design": provenance.design, "digest": provenance.digest, "message": result.message},
    )
