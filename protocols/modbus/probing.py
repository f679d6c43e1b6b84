"""Requests that test a Modbus TCP server against the specification, and how to judge its answers.

Sources: V1.1b3 (sections in each case), TCP guide; the points where widely used servers differ: serial-protocols 5.1.  A verdict is PASS
where the text is met, WARN where practice and text differ and clients live with it, FAIL where a client is misled.
"""

import struct
from collections.abc import Sequence
from dataclasses import dataclass
from enum import Enum

from protocols.modbus.mbap import ANSWER, HEADER

FIRST_ID = 0x1234


class Verdict(Enum):
    """In the order of weight."""

    PASS = "PASS"
    NOT_OFFERED = "not offered"
    WARN = "WARN"
    FAIL = "FAIL"


@dataclass(frozen=True, slots=True)
class Said:
    """One answer of the server."""

    transaction: int
    protocol: int
    unit: int
    pdu: bytes


@dataclass(frozen=True, slots=True)
class Heard:
    """The answer to one case; `rest`: bytes that were not a complete answer."""

    said: tuple[Said, ...] = ()
    closed: bool = False
    rest: bytes = b""

    def words(self) -> str:
        """For a report."""
        parts = [f"{each.pdu.hex(' ').upper()}" for each in self.said[:3]] + (
            [f".. {len(self.said)} answers"] if len(self.said) > 3 else []
        )
        parts += [f"rest {self.rest.hex(' ').upper()}"] if self.rest else []
        parts += ["closed"] if self.closed else []
        return "; ".join(parts) or "silence"


@dataclass(frozen=True, slots=True)
class Case:
    """One question: pieces are sent in sequence.  `right`: outcomes as written; `lived`: outcomes that get a WARN with these words.

    Outcomes: "silence", "closed", "normal" (an answer without exception, well built), "XX" an exception code, "echo" the request PDU.
    """

    name: str
    section: str
    pieces: tuple[bytes, ...]
    pdu: bytes
    right: tuple[str, ...]
    lived: tuple[tuple[str, str], ...] = ()
    answers: int = 1
    optional: bool = False  # a function a server need not have: 01 is fine
    writes: bool = False
    unit: int = 1
    apart_ms: int = 0  # between the pieces


def frame(pdu: bytes, unit: int, transaction: int = FIRST_ID, protocol: int = 0, length: int | None = None) -> bytes:
    """An MBAP frame; `length` overrides the right one."""
    return ANSWER.pack(transaction, protocol, len(pdu) + 1 if length is None else length, unit) + pdu


def split(data: bytes) -> tuple[list[Said], bytes]:
    """Complete answers at the start of the received bytes, and the rest."""
    said, at = [], 0
    while len(data) - at >= 8:
        transaction, protocol, length = HEADER.unpack_from(data, at)
        if length < 2 or len(data) - at < 6 + length:
            break
        said.append(Said(transaction, protocol, data[at + 6], data[at + 7 : at + 6 + length]))
        at += 6 + length
    return said, data[at:]


def _pdu(text: str) -> bytes:
    return bytes.fromhex(text)


def cases(unit: int = 1, register: int = 0, coil: int = 0, missing: int = 247, writes: bool = False) -> list[Case]:
    """The list; `register` and `coil` must be readable (and writable, with writes) there, unit `missing` must not exist."""
    return [
        *_reads(unit, register, coil),
        *_framing(unit, register, missing),
        *_functions(unit),
        *(_writes(unit, register, coil) if writes else []),
    ]


EXCEPTION_01 = ("01", "refuses with 01 (function) where 03 (value) is specified: this misleads the client")


def _one(
    unit: int, name: str, section: str, pdu: bytes, right: Sequence[str], lived: Sequence[tuple[str, str]] = (), **flags: bool
) -> Case:
    return Case(
        name,
        section,
        (frame(pdu, unit),),
        pdu,
        tuple(right),
        tuple(lived),
        optional=flags.get("optional", False),
        writes=flags.get("writes", False),
        unit=unit,
    )


def _reads(unit: int, register: int, coil: int) -> list[Case]:
    found: list[Case] = []
    for function, section, at, most in (
        (1, "6.1", coil, 2000),
        (2, "6.2", coil, 2000),
        (3, "6.3", register, 125),
        (4, "6.4", register, 125),
    ):

        def pdu(address: int, count: int, function: int = function) -> bytes:
            return struct.pack(">BHH", function, address, count)

        what = "bits" if function < 3 else "registers"
        rows = (
            (f"FC {function}: one of {what}", pdu(at, 1), ("normal",), (("02", "nothing readable at this address: name one"),)),
            (f"FC {function}: 0 {what}", pdu(at, 0), ("03",), (EXCEPTION_01,)),
            (f"FC {function}: {most + 1} {what}", pdu(at, most + 1), ("03",), (EXCEPTION_01,)),
            (f"FC {function}: 65535 {what}", pdu(at, 0xFFFF), ("03",), (EXCEPTION_01,)),
            (f"FC {function}: beyond address 65535", pdu(0xFFFF, 2), ("02",), (("03", "02 (address) is written"),)),
            (
                f"FC {function}: a byte too few",
                pdu(at, 1)[:-1],
                ("03",),
                (("closed", "closes instead of 03"), ("silence", "does not answer")),
            ),
            (
                f"FC {function}: a byte too many",
                pdu(at, 1) + b"\0",
                ("03",),
                (("normal", "does not look at the length"), ("closed", "closes")),
            ),
        )
        found += [_one(unit, name, section, request, right, lived, optional=True) for name, request, right, lived in rows]
    return found


def _framing(unit: int, register: int, missing: int) -> list[Case]:
    read = struct.pack(">BHH", 3, register, 1)
    good = frame(read, unit)
    ten = b"".join(frame(read, unit, FIRST_ID + n) for n in range(10))
    gone = (("normal", "answers for any unit id"), ("04", "04 is for failures inside the device"), ("02", "0Ah, 0Bh or silence"))

    def raw(
        name: str, section: str, pieces: Sequence[bytes], right: Sequence[str], lived: Sequence[tuple[str, str]] = (), **more: int
    ) -> Case:
        return Case(
            name, section, tuple(pieces), read, tuple(right), tuple(lived),
            answers=more.get("answers", 1), unit=more.get("unit", unit), apart_ms=more.get("apart_ms", 0),
        )  # fmt: skip

    return [
        raw("ten requests in one segment", "TCP 4.2.2", [ten], ("normal",), answers=10),
        raw("one byte per segment", "TCP 4.2.1", [good[n : n + 1] for n in range(len(good))], ("normal",), apart_ms=2),
        raw("a frame in two halves", "TCP 4.2.1", [good[:9], good[9:]], ("normal",), apart_ms=100),
        raw("transaction 65535", "TCP 3.1.3", [frame(read, unit, 0xFFFF)], ("normal",)),
        raw("unit that does not exist", "TCP 4.4.2.3", [frame(read, missing)], ("0A", "0B", "silence"), gone, unit=missing),
        raw(
            "protocol identifier 1",
            "TCP 4.3.2.2",
            [frame(read, unit, protocol=1)],
            ("silence", "closed"),
            (("normal", "its answer is not Modbus"),),
        ),
        raw("length 0", "TCP 3.1.3", [HEADER.pack(FIRST_ID, 0, 0)], ("closed", "silence")),
        raw("length 1", "TCP 3.1.3", [frame(b"", unit, length=1)], ("closed", "silence")),
        raw(
            "length 255",
            "TCP 3.1.3",
            [frame(read + bytes(249), unit, length=255)],
            ("closed", "silence"),
            (("03", "a PDU of 254 bytes is none"),),
        ),
        raw(
            "length a byte short",
            "TCP 3.1.3",
            [frame(read, unit, length=5)],
            ("03", "closed", "silence"),
            (("normal", "does not look at the length"),),
        ),
    ]


def _functions(unit: int) -> list[Case]:
    rows: list[tuple[str, str, str, tuple[str, ...], bool]] = [
        ("FC 41h, which does not exist", "7", "41 00 00 00 01", ("01",), False),
        ("FC 0, which does not exist", "4.1", "00 00 00 00 01", ("01", "closed", "silence"), False),
        ("FC 7", "6.7", "07", ("normal",), True),
        ("FC 8/0: the data are returned", "6.8", "08 0000 A537", ("echo",), True),
        ("FC 8: sub-function FFFFh", "6.8", "08 FFFF 0000", ("01",), True),
        ("FC 11", "6.9", "0B", ("normal",), True),
        ("FC 12", "6.10", "0C", ("normal",), True),
        ("FC 17", "6.13", "11", ("normal",), True),
        ("FC 20: byte count 0", "6.14", "14 00", ("03",), True),
        ("FC 24: a byte too few", "6.18", "18 00", ("03",), True),
        ("FC 43/14: basic stream", "6.21", "2B 0E 01 00", ("normal",), True),
        ("FC 43/14: code 0", "6.21", "2B 0E 00 00", ("03",), True),
        ("FC 43/255", "6.19", "2B FF 00 00", ("01",), True),
    ]
    return [_one(unit, name, section, _pdu(text), right, optional=optional) for name, section, text, right, optional in rows]


def _writes(unit: int, register: int, coil: int) -> list[Case]:
    at_coil, at = f"{coil:04X}", f"{register:04X}"
    rows: list[tuple[str, str, str, tuple[str, ...], tuple[tuple[str, str], ...]]] = [
        ("FC 5: value 0001h", "6.5", f"05 {at_coil} 0001", ("03",), ()),
        ("FC 5: value FFFFh", "6.5", f"05 {at_coil} FFFF", ("03",), ()),
        ("FC 15: 0 coils", "6.11", f"0F {at_coil} 0000 00", ("03",), (EXCEPTION_01,)),
        ("FC 15: byte count too small", "6.11", f"0F {at_coil} 0009 01 FF", ("03",), (EXCEPTION_01,)),
        ("FC 16: 0 registers", "6.12", f"10 {at} 0000 00", ("03",), (EXCEPTION_01,)),
        ("FC 16: byte count does not fit", "6.12", f"10 {at} 0002 02 0000", ("03",), (EXCEPTION_01,)),
        ("FC 16: 124 registers, a PDU of 254 bytes", "6.12", f"10 {at} 007C F8" + "00" * 248, ("03", "closed"), ()),
        ("FC 16: beyond address 65535", "6.12", "10 FFFF 0002 04 0000 0000", ("02",), (("03", "02 (address) is written"),)),
        ("FC 22: a byte too few", "6.16", f"16 {at} 0000 00", ("03",), ()),
        ("FC 23: byte count does not fit", "6.17", f"17 {at} 0001 {at} 0001 04 0000", ("03",), ()),
    ]
    return [
        _one(unit, name, section, _pdu(text), right, lived, optional=text[:2] in ("16", "17"), writes=True)
        for name, section, text, right, lived in rows
    ]


# ------------------------------------------------------------------------------------------------------------- judging


def judge(case: Case, heard: Heard) -> tuple[Verdict, str]:
    """The verdict and why."""
    wrong = _header_faults(case, heard)
    if wrong:
        return Verdict.FAIL, wrong
    outcome = _outcome(case, heard)
    if outcome in case.right and len(heard.said) == (case.answers if heard.said else 0):
        return Verdict.PASS, ""
    if outcome == "01" and case.optional:
        return Verdict.NOT_OFFERED, "the function is not offered (01)"
    if heard.said and case.answers > 1:
        return Verdict.FAIL, f"{len(heard.said)} of {case.answers} requests answered"
    for tolerated, why in case.lived:
        if outcome == tolerated:
            return Verdict.WARN, why
    return Verdict.FAIL, f"{outcome} where {' or '.join(case.right)} is written (section {case.section})"


def _header_faults(case: Case, heard: Heard) -> str:
    if heard.rest:
        return "what was received is not a Modbus TCP frame"
    first = struct.unpack_from(">H", case.pieces[0])[0] if len(case.pieces[0]) >= 2 else FIRST_ID
    for n, said in enumerate(heard.said):
        if said.transaction != (first + n) & 0xFFFF:
            return f"transaction {said.transaction:04X}h answered, {(first + n) & 0xFFFF:04X}h asked"
        if said.protocol != 0 and case.name != "protocol identifier 1":
            return f"protocol identifier {said.protocol} in an answer"
        if said.unit != case.unit:
            return f"unit {said.unit} answered, {case.unit} asked"
        if said.pdu[0] & 0x7F != case.pdu[0] & 0x7F or (said.pdu[0] & 0x80 and len(said.pdu) != 2):
            return f"answered with function {said.pdu[0]:02X}h, asked was {case.pdu[0]:02X}h"
    return ""


def _outcome(case: Case, heard: Heard) -> str:
    if not heard.said:
        return "closed" if heard.closed else "silence"
    pdu = heard.said[0].pdu
    if pdu[0] & 0x80:
        return f"{pdu[1]:02X}"
    if "echo" in case.right:
        return "echo" if pdu == case.pdu else "another answer"
    if pdu[0] in (1, 2, 3, 4) and (len(pdu) < 2 or pdu[1] != len(pdu) - 2):
        return "malformed answer"
    return "normal"
