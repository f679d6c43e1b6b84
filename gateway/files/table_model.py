"""Common base of all models of the cell file: the strict table, names, units.

Strict, frozen, unknown keys forbidden.  Field names are the keys of the file (`from` by alias); a test compares both sides.
"""

from typing import Annotated, Any, Literal

from pydantic import BaseModel, BeforeValidator, ConfigDict, Field

BAUDS = "300|600|1200|2400|4800|9600|19200|38400|57600|115200"
OnLoss = Literal["hold", "finish_move", "stop_on_path", "quick_stop"]
Name = Annotated[str, Field(pattern=r"^[A-Za-z0-9][A-Za-z0-9_-]*$", json_schema_extra={"allowed": "letters, digits, _ and -"})]
Robots = Annotated[list[str], BeforeValidator(lambda given: [given] if isinstance(given, str) else given)]  # one name is a list of one
OneRobot = Annotated[Robots, Field(max_length=1)]
Percent = Annotated[str, Field(pattern=r"^(100|\d{1,2})(\.\d+)? %$", json_schema_extra={"allowed": '"0 %".."100 %"'})]


def plain_number(value: object) -> object:
    """`true` and 3.0 are equal to legal numbers and none."""
    return repr(value) if isinstance(value, bool | float) else value


def unit(text: str) -> dict[str, Any]:
    """Marks a field with its unit; {u} is the unit of the axis."""
    return {"unit": text}


class Table(BaseModel):
    """Base of every table."""

    model_config = ConfigDict(frozen=True, extra="forbid", strict=True, allow_inf_nan=False)
