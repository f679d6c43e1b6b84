"""The tester's side of a Modbus server, TCP or RTU: frames, answers, faults of the header."""

import struct
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

from drivers.ports.base import PortError
from gateway.conformance.framework.base import Seen, Tester, hexed
from gateway.conformance.framework.host import Host
from gateway.links.serial.tool_wire import Heard, Wire
from gateway.pure.conformance.purpose import Particulars
from gateway.pure.conformance.verdict import Fail, Inconclusive, Warn
from protocols.base.machine import Damage, Ns, ms
from protocols.modbus.crc import crc, sealed
from protocols.modbus.mbap import ANSWER, HEADER

EXCEPTIONS = {
    1: "illegal function",
    2: "illegal data address",
    3: "illegal data value",
    4: "server device failure",
    5: "acknowledge",
    6: "server device busy",
    8: "memory parity error",
    10: "gateway path unavailable",
    11: "gateway target silent",
}


def without_top_bit(pdu: bytes) -> bool:
    """A refusal whose function has no top bit: two bytes, the second an exception; no answer of a function is as short."""
    return len(pdu) == 2 and not pdu[0] & 0x80 and pdu[1] in EXCEPTIONS


def amount(count: int, one: str) -> str:
    """1 register, 2 registers."""
    return f"{count} {one}" if count == 1 else f"{count} {one}s"


CROSS = Particulars(cross="Modbus conformance test specification V3.0")
TABLES = {1: "coils", 2: "discrete_inputs", 3: "holding_registers", 4: "input_registers"}
MOST_FRAME = 600
QUIET = ms(30)
LINE_QUIET = ms(60)
BUSY = 4  # attempts at a busy server
ONE_ANSWER = "one answer to each request"
LISTENED = 2  # times that a late answer of a server is waited for which has answered nothing yet
LATER = ms(2000)  # waited for an answer that did not come in time
FAILURE = b"\x04"  # of the server
STATUS = 7  # Read Exception Status: its answer has two bytes as well


@dataclass(slots=True)
class ModbusSetup:
    """Known facts about the server and the bench."""

    unit: int = 1
    missing: int = 247
    wait: Ns = ms(1000)
    pics: Mapping[str, object] = field(default_factory=dict)
    base: dict[int, int] = field(default_factory=dict)  # function -> an address that can be read
    span: dict[int, int] = field(default_factory=dict)  # function -> how many from there can be read at once
    holding: tuple[int, ...] = ()  # may be written
    coils: tuple[int, ...] = ()
    known: Mapping[str, int] = field(default_factory=dict)
    odd_exceptions: str = ""  # the case that found refusals badly built
    answers: bool = False  # it has answered a request
    refused: tuple[bytes, ...] = ()  # requests that were refused with an exception
    refusals_end: str = ""  # the case after whose refusals none was answered
    unsteady: str = ""  # the case that first missed an answer which came later, or when the request was repeated

    def most(self, function: int, legal: int) -> int:
        """Largest number in one request: the limit of V1.1b3, or less if the PICS states it."""
        stated = self.pics.get("most_bits" if function in (1, 2, 15) else "most_registers")
        return min(stated, legal) if isinstance(stated, int) and stated > 0 else legal


class ModbusTester(Tester):
    """One server; `connect` opens a new wire to it."""

    def __init__(self, connect: Callable[[], Wire], setup: ModbusSetup, rtu: bool, host: Host | None = None) -> None:
        super().__init__()
        self._connect, self.setup, self.rtu, self._host = connect, setup, rtu, host or Host()
        self._wire: Wire | None = None
        self.closed = False  # by the server, since the last request
        self._transaction = 0x1233
        self._rest = b""
        self._doubtful = False
        self.answered = False  # since the last connection was made
        self._silent = b""  # the last request, where it had no answer in time
        self._frame, self._sent = b"", 0  # the last request, and when
        self._well_answered = False  # the last request, and nothing was sent since
        self._listened = 0  # times that a late answer was waited for
        self.missed, self._instead = "", ""  # in this case: an answer that came late, when it was repeated, or twice; what came instead

    # ---- the wire
    @property
    def wire(self) -> Wire:
        if self._wire is None:
            self._wire = self._connect()
            self.clock = "virtual" if self._wire.simulated else "monotonic clock of this host, at the port"
            self._rest, self.closed, self._doubtful, self.answered = b"", False, False, False
        return self._wire

    def reconnect(self) -> None:
        """A new connection on TCP; a line stays open."""
        if self.rtu:
            return
        self.drop()
        _ = self.wire

    def another(self) -> "ModbusTester":
        """A second client at the same server."""
        return ModbusTester(self._connect, self.setup, self.rtu, self._host)

    def drop(self) -> None:
        if self._wire is not None:
            self._wire.close()
            self._wire = None

    def now(self) -> Ns:
        wire = self.wire
        return wire.now()

    def late(self) -> Ns:
        return 0 if self._wire is None else self._host.late(self._wire)

    def uncertainty(self) -> Ns:
        return 0 if self._wire is None or self._wire.simulated else self.late() + self._wire.char_ns

    def doubt(self, took: Ns) -> tuple[Ns, Ns]:
        """Uncertainty of this one time, not of the complete case."""
        if self._wire is None or self._wire.simulated:
            return 0, 0
        since = self._wire.now() - took
        return self._wire.char_ns + self._host.ends(self._wire, since), self._wire.char_ns + self._host.within(self._wire, since)

    def begin(self) -> None:
        if self.closed:
            self.reconnect()
        self.wire.late_ns, self.missed = 0, ""
        if self.setup.unsteady == self.case:  # the case is repeated, and judges anew
            self.setup.unsteady = ""
        if self.setup.refusals_end == self.case:
            self.setup.refusals_end = ""

    def standing(self) -> None:
        """An answer that is missed now and then is one FAIL, in the first case that meets it."""
        if not self.missed:
            return
        if self.case.endswith("_FUN_BV_01"):  # where all others start from
            raise Warn(self.missed, ONE_ANSWER, self._instead)
        if self.setup.unsteady in ("", self.case):
            self.setup.unsteady = self.case
            raise Fail(self.missed, ONE_ANSWER, self._instead)
        raise Warn(f"{self.missed}, as in {self.setup.unsteady}", ONE_ANSWER, self._instead)

    # ---- saying and hearing
    def send(self, data: bytes) -> None:
        """As it is."""
        self._well_answered = False
        self._host.sample(self.wire)
        try:
            self.wire.write(data)
        except PortError as error:
            self._gone(error)
        self.notes.trace.append(Seen(self.wire.drained(), "tester", data))

    def _gone(self, error: PortError) -> None:
        if self.rtu:
            raise error
        self.closed = True
        self.notes.trace.append(Seen(self.wire.now(), "device", b"", "closed"))

    def hear(self, until: Ns) -> bytes:
        """The next bytes, as far as they are here; b"": deadline passed, or the server closed."""
        if self.closed:
            return b""
        try:
            heard = self._awaited(until)
        except PortError as error:
            self._gone(error)
            return b""
        if heard is None:
            return b""
        data = b"" if isinstance(heard.what, Damage) else bytes((heard.what,))
        self.notes.trace.append(Seen(heard.stamp, "device", data, "" if data else "a damaged character"))
        return data

    def _awaited(self, until: Ns) -> Heard | None:
        wire = self.wire
        heard = wire.hear(until)
        self._host.sample(wire)
        return heard

    def frame(self, pdu: bytes, unit: int | None = None, transaction: int | None = None) -> bytes:
        unit = self.setup.unit if unit is None else unit
        if self.rtu:
            return sealed(bytes((unit,)) + pdu)
        if transaction is None:
            self._transaction = transaction = (self._transaction + 1) & 0xFFFF
        return ANSWER.pack(transaction, 0, len(pdu) + 1, unit) + pdu

    def answer_frame(self, wait: Ns | None = None) -> bytes:
        """The next complete frame, or the bytes there are when the time is over; the time-out counts from now."""
        data, self._rest = self._rest, b""
        start = max(self.wire.now(), self.wire.drained())
        within = self.setup.wait if wait is None else wait
        while len(data) < MOST_FRAME:
            if not self.rtu and len(data) >= HEADER.size and len(data) >= 6 + HEADER.unpack_from(data)[2]:
                size = 6 + HEADER.unpack_from(data)[2]
                self._rest = data[size:]
                return data[:size]
            byte = self._byte(start, within)
            if not byte:
                break
            data += byte
            if self.rtu:
                start, within = self.wire.now(), max(QUIET, 8 * self.wire.char_ns)
        return data

    def _byte(self, start: Ns, within: Ns) -> bytes:
        """The next byte; a wait in which this host, or a server on it, was delayed is extended by as much."""
        while not (byte := self.hear(start + within + self._left_open(start))):
            if self.closed or self.wire.now() >= start + within + self._left_open(start):
                break
        return byte

    def _left_open(self, since: Ns) -> Ns:
        return 0 if self.wire.simulated else self.wire.char_ns + self._host.within(self.wire, since)

    def ask(self, pdu: bytes, unit: int | None = None, judge: bool = False, wait: Ns | None = None) -> bytes:
        """The answer PDU.  A busy server (exception 06) is asked again, as in V1.1b3, 7."""
        for turn in range(BUSY):
            got = self._asked(pdu, unit, judge, wait)
            if got[1:] != b"\x06" or not got[0] & 0x80 or turn == BUSY - 1:
                break
            self.remark(f"function {pdu[0]:02X}h was refused with 06h (busy) and asked again")
            self.hear(self.wire.now() + LINE_QUIET)
        found_by = self.setup.odd_exceptions
        if found_by not in ("", self.case) and without_top_bit(got) and pdu[0] != STATUS:
            wanted = f"{got[0] | 0x80:02X} {got[1]:02X}"
            raise Inconclusive(f"preamble: a refusal without the top bit: {self.words(got)}", wanted, self.words(got), found_by)
        return got

    def steady(self, pdu: bytes, judge: bool = False) -> bytes:
        """As ask; a request without an answer in time, or with a failure of the server, is repeated once; a late answer counts as one."""
        got = self.ask(pdu, judge=judge)
        if got[1:] == FAILURE and got[0] & 0x80:
            again = self.ask(pdu, judge=judge)
            if again and again != got:
                self._miss(f"function {pdu[0]:02X}h was refused with 04h, and not when it was repeated", self.words(got))
            return again
        if got or self.closed or (not self.setup.answers and self._listened >= LISTENED):
            return got
        self._listened += 1
        found = self.answer_frame(max(LATER, self.setup.wait))
        if found and not self._frame_fault(self._frame, found, pdu):
            self._doubtful, self._silent, self.answered, self.setup.answers = False, b"", True, True
            self._miss(f"function {pdu[0]:02X}h was answered only after {(self.wire.now() - self._sent) / 1e9:.1f} s")
            return self._pdu(found)
        if got := self.ask(pdu, judge=judge):
            self._miss(f"function {pdu[0]:02X}h was answered only when it was repeated")
        return got

    def _miss(self, what: str, instead: str = "silence") -> None:
        """The first of a case counts."""
        if not self.missed:
            self.missed, self._instead = what, instead

    def _pdu(self, frame: bytes) -> bytes:
        return frame[1:-2] if self.rtu else frame[7:]

    def _asked(self, pdu: bytes, unit: int | None, judge: bool, wait: Ns | None) -> bytes:
        """The answer PDU; b"": silence, or closed.  Faults of its frame are judged by one purpose, and INCONC elsewhere."""
        self.quiet()
        frame = self.frame(pdu, unit)
        self.send(frame)
        self._frame, self._sent = frame, self.wire.drained()
        found = self.answer_frame(wait)
        self._doubtful = not found and not self.rtu  # it may have lost the framing of the stream, or closed the connection
        self.answered = self.answered or bool(found)
        self.setup.answers = self.setup.answers or bool(found)
        if found:
            self.timed(f"answer to function {pdu[0]:02X}h", self.wire.now() - self._sent, None, None)
        fault = self._frame_fault(frame, found, pdu)
        before, self._silent = self._silent, b"" if found else pdu
        if fault and self.rtu and before and not _function_fault(found[1:-2], before):
            self._silent = pdu
            fault = f"the answer to the request before, function {before[0]:02X}h, comes only now: {fault}"
        if fault:
            if judge and not self._preparing:
                raise Fail(fault, f"a well-formed answer to {hexed(frame)}", hexed(found))
            raise Inconclusive(f"preamble: {fault}", f"a well-formed answer to {hexed(frame)}", hexed(found))
        self._well_answered = bool(found)
        return self._pdu(found)

    def quiet(self) -> None:
        """Drop unexpected bytes; those that follow an answer were not asked for."""
        extra, self._rest = self._rest, b""
        while byte := self.hear(self.wire.now() + (LINE_QUIET if self.rtu else 0)):
            extra += byte
        if extra and self._well_answered:
            self._miss(f"bytes that were not asked for follow an answer: {hexed(extra)}", hexed(extra))
        self._well_answered = False
        if self.closed or self._doubtful:
            self.reconnect()

    def _frame_fault(self, asked: bytes, found: bytes, pdu: bytes) -> str:
        if not found:
            return ""
        unit = asked[0] if self.rtu else asked[6]
        if self.rtu:
            if len(found) < 5 or crc(found):
                return "the answer is not an RTU frame: its CRC does not fit"
            if found[0] != unit:
                return f"unit {found[0]} answered, {unit} was asked"
            return _function_fault(found[1:-2], pdu)
        if len(found) < 9 or len(found) != 6 + HEADER.unpack_from(found)[2]:
            return "what was received is not a Modbus TCP frame"
        transaction, protocol, _ = HEADER.unpack_from(found)
        wanted = HEADER.unpack_from(asked)[0]
        if transaction != wanted:
            return f"transaction {transaction:04X}h answered, {wanted:04X}h was asked"
        if protocol:
            return f"protocol identifier {protocol} in an answer"
        if found[6] != unit:
            return f"unit {found[6]} answered, {unit} was asked"
        return _function_fault(found[7:], pdu)

    # ---- judged steps
    def words(self, pdu: bytes) -> str:
        """An answer in hex and words."""
        if not pdu:
            return "closed" if self.closed else "silence"
        if pdu[0] & 0x80 and len(pdu) == 2:
            return f"{hexed(pdu)} (exception {pdu[1]:02X}h: {EXCEPTIONS.get(pdu[1], 'unknown')})"
        return hexed(pdu)

    def exception(self, pdu: bytes, code: int, what: str, others: tuple[int, ...] = ()) -> int | None:
        """Refused with this exception, or one of the others (which is returned); None: with the right one."""
        got = self.steady(pdu, judge=not self.setup.odd_exceptions)
        if len(got) == 2 and got[0] & 0x80:
            if got[1] == code:
                return None
            if got[1] in others:
                return got[1]
        wanted = f"{pdu[0] | 0x80:02X} {code:02X} (exception {code:02X}h: {EXCEPTIONS[code]})"
        if self.setup.odd_exceptions and len(got) in (0, 2):
            raise Inconclusive(f"preamble: {what}: {self.words(got)}; its refusals are not those of the protocol", wanted, self.words(got))
        self.silent_by_now(got, what, wanted)
        raise Fail(f"{what}: {self.words(got)}, expected exception {code:02X}h", wanted, self.words(got))

    def silent_by_now(self, got: bytes, what: str, wanted: str) -> None:
        """INCONC where the server answers no refusal because it had to give several: one case judges that."""
        found_by = self.setup.refusals_end
        if not got and found_by not in ("", self.case):
            reason = f"preamble: {what}: {self.words(got)}; after several refusals it answers no more of them"
            raise Inconclusive(reason, wanted, self.words(got), found_by)

    def normal(self, pdu: bytes, what: str) -> bytes:
        """Executed."""
        got = self.steady(pdu)
        if not got or got[0] & 0x80:
            raise Fail(f"{what}: {self.words(got)}", "an answer without exception", self.words(got))
        return got

    def registers(self, function: int, address: int, count: int) -> list[int]:
        what = f"FC {function}, {count} from {address}"
        got = self.normal(struct.pack(">BHH", function, address, count), what)
        if len(got) != 2 + 2 * count or got[1] != 2 * count:
            raise Fail(f"{what}: {len(got) - 2} bytes, byte count {got[1] if len(got) > 1 else '-'}", f"{2 * count} bytes", hexed(got))
        return list(struct.unpack(f">{count}H", got[2:]))

    def bits(self, function: int, address: int, count: int) -> list[int]:
        what = f"FC {function}, {count} from {address}"
        got = self.normal(struct.pack(">BHH", function, address, count), what)
        size = (count + 7) // 8
        if len(got) != 2 + size or got[1] != size:
            raise Fail(f"{what}: {len(got) - 2} bytes, byte count {got[1] if len(got) > 1 else '-'}", f"{size} bytes", hexed(got))
        return [got[2 + at // 8] >> at % 8 & 1 for at in range(count)]

    def read(self, function: int, address: int, count: int) -> list[int]:
        return self.bits(function, address, count) if function < 3 else self.registers(function, address, count)

    def echo(self, pdu: bytes, size: int, what: str) -> None:
        """A write whose answer repeats the first bytes of the request."""
        got = self.normal(pdu, what)
        if got != pdu[:size]:
            raise Fail(f"{what}: the answer does not repeat the request", hexed(pdu[:size]), hexed(got))

    def alive(self) -> None:
        """The suite's postamble: a read is answered."""
        for function, address in self.setup.base.items():
            got = self.steady(struct.pack(">BHH", function, address, 1))
            if not got or got[0] & 0x80:
                raise Fail(f"FC {function} is no longer answered: {self.words(got)}", "a normal answer", self.words(got))
            return
        got = self.steady(b"\x03\x00\x00\x00\x01")
        if not got:
            raise Fail("nothing is answered", "an answer", "silence")


def _function_fault(answer: bytes, pdu: bytes) -> str:
    if not answer or answer[0] & 0x7F != pdu[0] & 0x7F:
        return f"answered with function {answer[0] if answer else 0:02X}h, {pdu[0]:02X}h was asked"
    if answer[0] & 0x80 and not pdu[0] & 0x80 and len(answer) != 2:
        return f"an exception answer of {len(answer)} bytes, it has two"
    return ""
