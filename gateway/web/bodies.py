"""Request bodies of the interface; /api/openapi.json contains their JSON schemas."""

from typing import Annotated, Literal

from pydantic import BaseModel, ConfigDict, Field

from gateway.pure.image.records.cell import MOST_AXES

Name = Annotated[str, Field(min_length=1, max_length=64, pattern=r"^[A-Za-z0-9_.@-]+$")]
Password = Annotated[str, Field(min_length=1, max_length=256)]
RoleName = Literal["viewer", "operator", "setter", "admin"]
Share = Annotated[float, Field(ge=0.0, le=1.0)]


class Body(BaseModel):
    """Base of all: nothing unknown, no NaN."""

    model_config = ConfigDict(extra="forbid", allow_inf_nan=False, strict=True)


class Login(Body):
    name: Name
    password: Password


class User(Body):
    name: Name
    role: RoleName
    password: Password


class Named(Body):
    name: Name


class Token(Body):
    label: Name
    role: RoleName


class ProgramName(Body):
    """A program of the old controller."""

    name: Annotated[str, Field(min_length=1, max_length=128, pattern=r"^[^\x00-\x1f]+$")]


class Val3Act(Body):
    """An operator's action in a VAL 3 application."""

    act: Literal["event", "enter", "answer", "key", "set", "connect", "hold", "mode", "speed", "ratio"]
    what: Annotated[str, Field(max_length=128)] = ""  # object of the user page, or variable
    attribute: Annotated[str, Field(max_length=64)] = "value"
    value: Annotated[str, Field(max_length=256)] = ""
    on: bool = False


class PlcStart(Body):
    """A program of the integrated PLC; empty: its start program."""

    name: Annotated[str, Field(max_length=256, pattern=r"^[^\x00-\x1f]*$")] = ""


class Marker(Body):
    """M10.0, M10 or MD10, and a number: decimal, or hexadecimal with H."""

    operand: Annotated[str, Field(min_length=2, max_length=16)]
    value: Annotated[str, Field(min_length=1, max_length=16)]


class Command(Body):
    """As the command block of AX-011; targets in the axes' own units."""

    code: Literal[
        "enable", "disable", "reference", "ptp_absolute", "ptp_relative", "resume", "abandon", "fault_reset", "override",
        "request_control", "release_control",
    ]  # fmt: skip
    mask: int = Field(default=0, ge=0, le=(1 << MOST_AXES) - 1)
    velocity: Share = 1.0
    acceleration: Share = 1.0
    targets: Annotated[list[Annotated[float, Field(ge=-1e9, le=1e9)]], Field(max_length=MOST_AXES)] = []


class Permit(Body):
    """Enabling inputs of a simulation."""

    on: bool = True


class Force(Body):
    """An RC input."""

    bit: int = Field(ge=0, le=1023)
    value: Literal[0, 1]


class Unforce(Body):
    """One RC input, or all."""

    bit: int | None = Field(default=None, ge=0, le=1023)


class ForceWord(Body):
    """A data word or bit by its id, in its own type and unit."""

    id: Annotated[str, Field(min_length=4, max_length=40)]
    value: Annotated[str, Field(min_length=1, max_length=24)]


class UnforceWord(Body):
    id: Annotated[str, Field(min_length=4, max_length=40)]


Channel = Annotated[str, Field(min_length=1, max_length=80)]


class Record(Body):
    """A scope recording: up to 16 channels, from the trigger on, including values before it."""

    channels: Annotated[list[Channel], Field(min_length=1, max_length=16)]
    seconds: float = Field(default=5.0, ge=0.01, le=600.0)
    pre: float = Field(default=0.0, ge=0.0, le=60.0)
    trigger: Annotated[str, Field(max_length=100)] = ""
    rolling: bool = False  # shows the last `seconds` until it is stopped


class FileName(Body):
    """Name of a recording; no path."""

    name: Annotated[str, Field(min_length=1, max_length=60, pattern=r"^[A-Za-z0-9][A-Za-z0-9_+-]*$")]


ListKind = Literal["watch", "scope"]
ListName = Annotated[str, Field(min_length=1, max_length=60, pattern=r"^[^\x00-\x1f]*\S[^\x00-\x1f]*$")]


class Keep(Body):
    """A watch list (ids of values) or a layout of the scope, as the page wrote it."""

    kind: ListKind
    name: ListName
    value: Annotated[str, Field(min_length=2, max_length=12_000)]


class Kept(Body):
    kind: ListKind
    name: ListName


class Put(Body):
    """As if the PLC had written it; simulated cells only."""

    address: Annotated[str, Field(min_length=1, max_length=64)]
    value: Annotated[str, Field(min_length=1, max_length=64)]


class Cable(Body):
    line: Annotated[str, Field(min_length=1, max_length=64)]
    do: Literal["plug", "unplug", "remove", "insert", "calm", "damage"]
    side: Literal["A", "B"] = "A"
    kind: Literal["parity", "framing", "overrun", "break", "flip", "drop"] = "parity"
    probability: Share = 0.0


class Fault(Body):
    """One fault of an emulated drive."""

    emulator: Annotated[str, Field(min_length=1, max_length=64)]
    do: Annotated[str, Field(pattern=r"^[a-z_0-9]{2,40}$")]
    axis: int | None = Field(default=None, ge=1, le=127)
    node: int | None = Field(default=None, ge=1, le=127)
    on: bool | None = None
    code: int | None = Field(default=None, ge=1, le=0xFFFF)
    count: int | None = Field(default=None, ge=0, le=1_000_000)
    torque_nm: float | None = Field(default=None, ge=-10_000, le=10_000)
