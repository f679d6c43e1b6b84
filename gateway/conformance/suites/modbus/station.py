"""Modbus RTU, rules of a station on a line: other units and broadcasts for every function, extra bytes at a request, the silence
before an answer, damaged characters (serial line guide V1.02, 2.1 to 2.5)."""

import struct
from collections.abc import Iterator

from gateway.conformance.suites.modbus.answers import RTU_ANS
from gateway.conformance.suites.modbus.content import kept, same_values
from gateway.conformance.suites.modbus.tester import ModbusTester
from gateway.pure.conformance.purpose import Purposes
from gateway.pure.conformance.verdict import Fail, NotApplicable, Warn

STA = Purposes[ModbusTester]("MBRTU_STA", "server", "serial line guide V1.02, 2.1", preamble=("MBRTU_FUN_BV_01",))
SILENCE = 7  # half characters that end a frame
ROUNDED = 100_000
Asked = tuple[int, int, int, bytes, list[int]]  # function, table, address, request, present values


def _other_values(t: ModbusTester) -> Iterator[Asked]:
    """Each function that writes and is offered, with values that are not there."""
    for table, touched, functions in ((1, t.setup.coils, (5, 15)), (3, t.setup.holding, (6, 16))):
        for function in functions:
            if touched and t.setup.pics.get(f"fc{function}"):
                at = touched[0]
                with t.given():
                    value = t.read(table, at, 1)[0] ^ (1 if table == 1 else 0x0FF0)
                request = {
                    5: lambda at, value: struct.pack(">BHH", 5, at, 0xFF00 * value),
                    6: lambda at, value: struct.pack(">BHH", 6, at, value),
                    15: lambda at, value: struct.pack(">BHHBB", 15, at, 1, 1, value),
                    16: lambda at, value: struct.pack(">BHHBH", 16, at, 1, 2, value),
                }[function](at, value)
                yield function, table, at, request, [value]


def _unanswered(t: ModbusTester, frame: bytes, what: str, disputed: bool = False) -> None:
    t.quiet()
    t.send(frame)
    if found := t.answer_frame():
        raise (Warn if disputed else Fail)(f"{what} was answered", "silence", t.words(found))


@STA.case(
    "BI_01",
    "a request of each function for another unit: silence, and nothing is written",
    "eine Anfrage jeder Funktion an ein anderes Gerät: Stille, und nichts wird geschrieben",
    clause="serial line guide V1.02, 2.2",
    preamble=("MBRTU_FUN_BV_01", "MBRTU_RTU_BI_04"),
)
def other_unit(t: ModbusTester) -> None:
    """Also unit + 128, which has the same lower bits, and 248 to 255, which are reserved."""
    units = (t.setup.unit % 247 + 1, t.setup.unit ^ 0x80, 248)
    for place, (function, at) in enumerate(t.setup.base.items()):
        for unit in units if not place else units[:1]:
            _unanswered(t, t.frame(struct.pack(">BHH", function, at, 1), unit=unit), f"FC {function} for unit {unit}")
    for function, table, at, request, _ in _other_values(t):
        with kept(t, table, at, 1):
            before = t.read(table, at, 1)
            _unanswered(t, t.frame(request, unit=units[0]), f"FC {function} for unit {units[0]}")
            same_values(t.read(table, at, 1), before, f"{at} after FC {function} for unit {units[0]}")


@STA.case(
    "BI_05",
    "a write of each function with a wrong CRC: silence, and nothing is written",
    "ein Schreiben jeder Funktion mit falscher CRC: Stille, und nichts wird geschrieben",
    clause="serial line guide V1.02, 2.4.2",
    preamble=("MBRTU_FUN_BV_01", "MBRTU_RTU_BI_01"),
)
def spoilt_write(t: ModbusTester) -> None:
    for function, table, at, request, _ in _other_values(t):
        with kept(t, table, at, 1):
            before = t.read(table, at, 1)
            frame = t.frame(request)
            _unanswered(t, frame[:-1] + bytes((frame[-1] ^ 0x10,)), f"FC {function} with a wrong CRC")
            same_values(t.read(table, at, 1), before, f"{at} after FC {function} with a wrong CRC")


@STA.case(
    "BV_01",
    "a broadcast write of each function: silence, and it is done",
    "ein Rundspruch-Schreiben jeder Funktion: Stille, und es wird ausgeführt",
    condition=("broadcast",),
    preamble=("MBRTU_FUN_BV_01", "MBRTU_RTU_BV_01", "MBRTU_CON_BV_05"),
)
def broadcasts(t: ModbusTester) -> None:
    done, lost = list[str](), list[str]()
    for function, table, at, request, wanted in _other_values(t):
        with kept(t, table, at, 1):
            _unanswered(t, t.frame(request, unit=0), f"a broadcast of FC {function}")
            (done if t.read(table, at, 1) == wanted else lost).append(f"FC {function}")
    if not done and not lost:
        raise NotApplicable("nothing may be written")
    if lost:
        ended = Fail if done or t.setup.pics.get("broadcast_stated") else Warn
        raise ended(f"a broadcast of {', '.join(lost)} has no effect", "the effect of a request", "the values as before")


@STA.case(
    "BI_02",
    "a broadcast that cannot be executed is not answered either",
    "auch ein nicht ausführbarer Rundspruch wird nicht beantwortet",
    preamble=("MBRTU_FUN_BV_01", "MBRTU_RTU_BI_06"),
)
def refused_broadcasts(t: ModbusTester) -> None:
    for what, pdu in (
        ("a function that is none", b"\x41\0\0\0\1"),
        ("FC 5 with 0001h", b"\x05\0\0\0\1"),
        ("FC 16 with a quantity of 0", b"\x10\0\0\0\0\0"),
    ):
        _unanswered(t, t.frame(pdu, unit=0), f"a broadcast of {what}")


@STA.case(
    "BI_03",
    "a request with bytes before or after it, or two without silence between them: no frame",
    "eine Anfrage mit Bytes davor oder dahinter, oder zwei ohne Stille dazwischen: kein Telegramm",
    clause="serial line guide V1.02, 2.5.1.1",
    preamble=("MBRTU_FUN_BV_01", "MBRTU_RTU_BI_01"),
)
def round_about(t: ModbusTester) -> None:
    """A server that ends a frame by its length does not notice it: common, and seldom harmful (AX-1780)."""
    function, at = next(iter(t.setup.base.items()), (3, 0))
    frame = t.frame(struct.pack(">BHH", function, at, 1))
    for what, data in (
        ("a request followed by a byte", frame + b"\xa5"),
        ("a request with a byte before it", b"\xa5" + frame),
        ("two requests without silence between them", frame + frame),
    ):
        _unanswered(t, data, what, disputed=True)


@STA.case(
    "BI_04",
    "a damaged character within a request: silence",
    "ein gestörtes Zeichen in einer Anfrage: Stille",
    clause="serial line guide V1.02, 2.4.1",
)
def damaged(t: ModbusTester) -> None:
    function, at = next(iter(t.setup.base.items()), (3, 0))
    frame = t.frame(struct.pack(">BHH", function, at, 1))
    t.quiet()
    t.send(frame[:3])
    if not t.wire.spoil():
        t.send(frame[3:])
        t.answer_frame()
        raise NotApplicable(f"{t.wire.name} cannot send a character with wrong parity")
    t.send(frame[3:])
    if found := t.answer_frame():
        raise Fail("a request with a damaged character was answered", "silence", t.words(found))


@STA.case(
    "RC_01",
    "after a damaged character, in a request or alone, the next request is answered",
    "nach einem gestörten Zeichen, in einer Anfrage oder allein, wird die nächste Anfrage beantwortet",
    clause="serial line guide V1.02, 2.5.1.1",
)
def serves_on(t: ModbusTester) -> None:
    """The silence after it ends the frame: what follows is a new one."""
    function, at = next(iter(t.setup.base.items()), (3, 0))
    pdu = struct.pack(">BHH", function, at, 1)
    frame = t.frame(pdu)
    for before, behind, what in ((frame[:3], frame[3:], "in a request"), (b"", b"", "alone")):
        t.quiet()
        if before:
            t.send(before)
        if not t.wire.spoil():
            raise NotApplicable(f"{t.wire.name} cannot send a character with wrong parity")
        if behind:
            t.send(behind)
        if not t.ask(pdu):  # after 60 ms of silence
            raise Fail(f"after a damaged character {what} a request is not answered", "an answer", "silence")


@STA.case(
    "TI_01",
    "an answer begins after 3.5 characters of silence: only they end the request",
    "eine Antwort beginnt nach 3,5 Zeichen Stille: erst sie beenden die Anfrage",
    clause="serial line guide V1.02, 2.5.1.1",
)
def turns_round(t: ModbusTester) -> None:
    """Above 19200 Bd the silence is 1.75 ms.  A server that ends a frame by its length is quicker: a WARN."""
    function, at = next(iter(t.setup.base.items()), (3, 0))
    frame = t.frame(struct.pack(">BHH", function, at, 1))
    least = max(SILENCE * t.wire.char_ns // 2, 1_750_000)
    for _ in range(3):
        t.quiet()
        t.send(frame)
        start = t.wire.drained()
        first = t.hear(start + t.setup.wait)
        if not first:
            raise Fail("a request is not answered", "an answer", "silence")
        took = t.wire.now() - t.wire.char_ns - min(start, t.wire.drained())
        t.answer_frame()
        if took + t.doubt(max(took, 0))[0] < least - ROUNDED:
            shown = f"{max(took, 0) / 1e6:.2f} ms"
            raise Warn(f"the answer begins {shown} after the request", f"at least {least / 1e6:.2f} ms", shown)


@RTU_ANS.case(
    "BV_05",
    "the longest answers are whole frames, and have a right CRC",
    "die längsten Antworten sind ganze Telegramme mit richtiger CRC",
    clause="serial line guide V1.02, 2.4.2",
    preamble=("MBRTU_FUN_BV_01", "MBRTU_ANS_BV_01"),
)
def longest(t: ModbusTester) -> None:
    for function, at in t.setup.base.items():
        reach = min(2000 if function < 3 else 125, t.setup.most(function, 2000 if function < 3 else 125))
        low, high = 1, reach + 1
        while high - low > 1:  # discovery with an invalid frame finds too small a limit
            middle = (low + high) // 2
            got = t.ask(struct.pack(">BHH", function, at, middle), judge=True)
            low, high = (middle, high) if got and not got[0] & 0x80 else (low, middle)
