"""Records exchanged by interpreter, services and planner (AX-860): one region with what programs see of the control, one with the
processes, a ring of orders to the interpreter, a ring of its messages, and a ring of lines to the planner (records of
gateway.pure.image.records.planner).
"""

import json
import struct
from collections.abc import Mapping
from dataclasses import dataclass

from gateway.pure.image.records.cell import RC_BYTES

TEXT_BYTES = 1_500  # of a record of the two rings
RECORDS = 1_024
REPORT_BYTES = 32_768
REPORT_LAYOUT = "interpreter/1 json"
Fact = str | int | float | bool
Facts = Mapping[str, Fact]

_TEXT = struct.Struct(f"=I{TEXT_BYTES}s")
TEXT_SIZE = _TEXT.size
TEXT_LAYOUT = f"programs/1 {_TEXT.format}"
_SEEN = struct.Struct(f"={RC_BYTES}s{RC_BYTES}s8sQQBBddd")
SEEN_SIZE = _SEEN.size
SEEN_LAYOUT = f"channels/1 {_SEEN.format}"
FIRST_FAST, FAST = 610, 30  # high-speed inputs of three boards
FIRST_MULTI, MULTI = 801, 4
NO_MULTI = 0x80


def pack_facts(facts: Facts) -> bytes:
    """As TEXT_SIZE bytes; a text that is too long is cut."""
    octets = json.dumps(dict(facts), ensure_ascii=False).encode()
    if len(octets) > TEXT_BYTES:
        room = TEXT_BYTES - len(json.dumps({**facts, "text": ""}, ensure_ascii=False).encode())
        text = str(facts.get("text", "")).encode()[: max(0, room // 2)].decode(errors="ignore")
        octets = json.dumps({**facts, "text": text}, ensure_ascii=False).encode()
    return _TEXT.pack(len(octets), octets)


def unpack_facts(data: bytes) -> dict[str, Fact]:
    """The reverse of pack_facts."""
    size, octets = _TEXT.unpack(data)
    found = json.loads(octets[:size])
    assert isinstance(found, dict)
    return found


@dataclass(frozen=True, slots=True)
class Channels:
    """The control as programs see it: RC inputs and outputs, INTEGER inputs as taken with their strobes, high-speed inputs that P11 gives
    and their values (bit 0 = channel 610), the multi-function inputs (None: the control has none), the global factors."""

    inputs: bytes = bytes(RC_BYTES)
    outputs: bytes = bytes(RC_BYTES)
    integers: bytes = bytes(8)
    fast: int = 0
    fast_given: int = 0
    multi: int | None = None
    multi_out: int = 0
    factors: tuple[float, float, float] = (1.0, 1.0, 1.0)


def pack_channels(channels: Channels) -> bytes:
    """As SEEN_SIZE bytes."""
    multi = NO_MULTI if channels.multi is None else channels.multi
    return _SEEN.pack(
        channels.inputs,
        channels.outputs,
        channels.integers,
        channels.fast,
        channels.fast_given,
        multi,
        channels.multi_out,
        *channels.factors,
    )


def unpack_channels(data: bytes) -> Channels:
    """The reverse of pack_channels."""
    inputs, outputs, integers, fast, given, multi, multi_out, *factors = _SEEN.unpack(data)
    velocity, acceleration, deceleration = factors
    return Channels(
        inputs, outputs, integers, fast, given, None if multi == NO_MULTI else multi, multi_out, (velocity, acceleration, deceleration)
    )


def pack_report(report: Mapping[str, object], size: int = REPORT_BYTES) -> bytes:
    """JSON, padded; rows that do not fit are left out, the last ones first."""
    rows = dict(report)
    octets = json.dumps(rows, ensure_ascii=False).encode()
    while len(octets) > size:
        longest = max((name for name, value in rows.items() if isinstance(value, list) and value), key=lambda name: len(str(rows[name])))
        held = rows[longest]
        assert isinstance(held, list)
        rows[longest] = held[: len(held) // 2]
        octets = json.dumps(rows, ensure_ascii=False).encode()
    return octets.ljust(size)


def unpack_report(data: bytes) -> dict[str, object]:
    """The reverse of pack_report."""
    found = json.loads(data)
    assert isinstance(found, dict)
    return found
