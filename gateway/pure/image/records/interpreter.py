"""Records exchanged by interpreter, services and planner (AX-860): one region with what programs see of the control, one with the
processes, a ring of orders to the interpreter, a ring of its messages, and a ring of lines to the planner (records of
gateway.pure.image.records.planner).
"""

import json
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated

from gateway.pure.image.records.cell import RC_BYTES
from gateway.pure.image.records.layout import U8, U32, U64, Code, Layout

TEXT_BYTES = 1_500  # of a record of the two rings
RECORDS = 1_024
REPORT_BYTES = 32_768
REPORT_LAYOUT = "interpreter/1 json"
Fact = str | int | float | bool
Facts = Mapping[str, Fact]


@dataclass(frozen=True, slots=True)
class _Text:
    """A record of the two rings."""

    size: U32
    octets: Annotated[bytes, Code(f"{TEXT_BYTES}s")]


_TEXT = Layout(_Text, "programs/1")
TEXT_SIZE, TEXT_LAYOUT = _TEXT.size, _TEXT.text
FIRST_FAST, FAST = 610, 30  # high-speed inputs of three boards
FIRST_MULTI, MULTI = 801, 4
FIRST_REAL, REALS = 201, 24
NO_MULTI = 0x80
FLAG_BYTES = 2_048


def pack_facts(facts: Facts) -> bytes:
    """As TEXT_SIZE bytes; a text that is too long is cut."""
    octets = json.dumps(dict(facts), ensure_ascii=False).encode()
    if len(octets) > TEXT_BYTES:
        room = TEXT_BYTES - len(json.dumps({**facts, "text": ""}, ensure_ascii=False).encode())
        text = str(facts.get("text", "")).encode()[: max(0, room // 2)].decode(errors="ignore")
        octets = json.dumps({**facts, "text": text}, ensure_ascii=False).encode()
    return _TEXT.pack(_Text(len(octets), octets))


def unpack_facts(data: bytes) -> dict[str, Fact]:
    """The reverse of pack_facts."""
    text = _TEXT.unpack(data)
    found = json.loads(text.octets[: text.size])
    assert isinstance(found, dict)
    return found


def _multi(byte: int) -> int | None:
    return None if byte == NO_MULTI else byte


def _multi_byte(value: int | None) -> int:
    return NO_MULTI if value is None else value


@dataclass(frozen=True, slots=True)
class Channels:
    """The control as programs see it: RC inputs and outputs, INTEGER inputs as taken with their strobes, high-speed inputs set by P11
    and their values (bit 0 = channel 610), the multi-function inputs (None: the control has none), the global factors; of a ROBOTstar its
    markers M0..M2047, with binary inputs and outputs.  reals: REAL inputs 201..224, reals_given: the wired ones."""

    inputs: Annotated[bytes, Code(f"{RC_BYTES}s")] = bytes(RC_BYTES)
    outputs: Annotated[bytes, Code(f"{RC_BYTES}s")] = bytes(RC_BYTES)
    integers: Annotated[bytes, Code("8s")] = bytes(8)
    fast: U64 = 0
    fast_given: U64 = 0
    multi: Annotated[int | None, Code("B", _multi, _multi_byte)] = None
    multi_out: U8 = 0
    factors: Annotated[tuple[float, float, float], Code("3d")] = (1.0, 1.0, 1.0)
    flags: Annotated[bytes, Code(f"{FLAG_BYTES}s")] = bytes(FLAG_BYTES)
    reals_given: U32 = 0
    reals: Annotated[tuple[float, ...], Code(f"{REALS}d")] = (0.0,) * REALS


_SEEN = Layout(Channels, "channels/4")
SEEN_SIZE, SEEN_LAYOUT = _SEEN.size, _SEEN.text
pack_channels, unpack_channels = _SEEN.pack, _SEEN.unpack


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
    found = json.loads(data.rstrip())
    assert isinstance(found, dict)
    return found
