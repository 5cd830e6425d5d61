"""The JSON Schema of a ledger, and reading one back.

In: nothing, or the text of ledger.json. Out: a schema, or the `Ledger`. Both follow from the records themselves.
"""

from typing import Any

from pydantic import TypeAdapter, ValidationError

from lamc.basics.errors import LamcError
from lamc.ledger.records import Ledger


def ledger_schema() -> dict[str, Any]:
    """JSON Schema (2020-12) of ledger.json. Numbers that were not measured are null."""
    found = TypeAdapter(Ledger).json_schema()
    return {"$schema": "https://json-schema.org/draft/2020-12/schema", "title": "lamc ledger", **found}


def read_ledger(text: str) -> Ledger:
    """The ledger of a JSON text. Raises LamcError for another text."""
    try:
        return TypeAdapter(Ledger).validate_json(text)
    except ValidationError as error:
        first = error.errors()[0]
        where = ".".join(str(part) for part in first["loc"])
        raise LamcError(
            f"this is no ledger of lamc: {where}: {first['msg']}; make one with `lamc ledger`"
        ) from error
