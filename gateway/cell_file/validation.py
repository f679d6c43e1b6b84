"""The tables of a cell file, judged against the dataclasses of gateway.pure.cell: strict types, ranges, no unknown key."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from pydantic import ConfigDict, TypeAdapter
from pydantic_core import SchemaValidator, core_schema

from gateway.pure.cell.cell import CellTables
from gateway.pure.cell.columns import key_of
from gateway.registry import NAMES

LISTS_AND_TABLES = ("tuple", "dataclass")  # strict ones would require tuples and finished objects; a file has lists and tables


@dataclass(frozen=True, slots=True, kw_only=True)
class CellFile(CellTables):
    """The tables as a file holds them: keys by their own spelling, unknown ones forbidden, nothing converted."""

    __pydantic_config__ = ConfigDict(extra="forbid", strict=True, allow_inf_nan=False, alias_generator=key_of)


def validated(raw: Mapping[str, Any]) -> CellTables:
    """The tables as data.  Raises pydantic's ValidationError with every fault of a key."""
    tables: CellTables = _VALIDATOR.validate_python(raw)
    return tables


def _accepting(schema: Any) -> Any:
    """The schema with lists for tuples, tables for objects and the registry's names; all values in them stay strict."""
    if isinstance(schema, list):
        return [_accepting(each) for each in schema]
    if not isinstance(schema, dict):
        return schema
    table = (schema.get("metadata") or {}).get("registered")
    if table is not None:
        return core_schema.literal_schema([*NAMES[table]])
    inner = {key: value if key in ("default", "metadata") else _accepting(value) for key, value in schema.items()}
    return {**inner, "strict": False} if schema.get("type") in LISTS_AND_TABLES else inner


_VALIDATOR = SchemaValidator(_accepting(TypeAdapter(CellFile).core_schema))
