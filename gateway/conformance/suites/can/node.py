"""The tester's side of a CANopen node: SDO client, NMT master, objects as numbers."""

from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field

from gateway.conformance.framework.base import hexed
from gateway.conformance.framework.frame_wire import FrameWire
from gateway.conformance.suites.can.sizes import object_size
from gateway.conformance.suites.can.tester import CanTester, shown
from gateway.pure.conformance.verdict import Ended, Fail, Inconclusive, NotApplicable, Warn
from protocols.base.machine import Frame, Ns, ms
from protocols.canopen import cob_id as cobid
from protocols.canopen import nmt, sdo
from protocols.canopen.dictionary import Key, ObjectDictionary
from protocols.canopen.sdo import Abort, Answer, Request

DEVICE_TYPE, HEARTBEAT, IDENTITY = (0x1000, 0), (0x1017, 0), 0x1018
SEGMENTS = 2000
SILENT = "no answer"


@dataclass(slots=True)
class NodeSetup:
    """Known facts about the node and the bench."""

    node: int = 1
    wait: Ns = ms(1000)  # an SDO answer
    boot: Ns = ms(10_000)  # reset to boot-up
    cycle: Ns = ms(10)  # SYNC period of the tester
    pics: Mapping[str, object] = field(default_factory=dict)
    dictionary: ObjectDictionary | None = None
    touch: frozenset[Key] = frozenset()
    text: Key = (0x1008, 0)  # an object longer than four bytes
    long: Key = (0x1008, 0)  # the longest of those that were looked at
    remotes: bool = True  # the port sends remote frames
    emcy: int = 0  # identifier of emergencies; 0: the default
    took: Ns = 0  # an SDO upload of this device


class Aborted(Fail):
    """The server refused."""

    def __init__(self, what: str, code: int) -> None:
        words = abort_words(code)
        super().__init__(f"{what}: {words}", "an answer without abort", words)
        self.code = code


def abort_words(code: int) -> str:
    return f"abort {code:08X}h ({sdo.TEXTS.get(code, 'unknown code')})"


def named(key: Key) -> str:
    return f"{key[0]:04X}h:{key[1]:02X}"


class NodeTester(CanTester):
    """One node."""

    def __init__(self, connect: Callable[[], FrameWire], setup: NodeSetup, witness: Callable[[], Ns] = lambda: 0) -> None:
        super().__init__(connect, witness)
        self.setup = setup
        self.unsized = False  # the last upload announced no size: it was cut to that of the standard
        self._grid: Ns = 0  # of the last SYNC
        self.period: Ns = setup.cycle  # from SYNC to SYNC of `on_grid`

    @property
    def emcy(self) -> int:
        """Identifier of its emergencies."""
        return self.setup.emcy or cobid.emcy(self.setup.node)

    # ---- SDO messages
    def ask(self, request: bytes, wait: Ns | None = None) -> bytes:
        """The answer to one message; b"" for silence."""
        self.say(cobid.sdo_request(self.setup.node), request)
        frame = self.hear((cobid.sdo_answer(self.setup.node),), self.setup.wait if wait is None else wait)
        return b"" if frame is None else frame.data

    def asked(self, request: bytes, what: str, key: Key | None = None) -> bytes:
        """Judge: an answer of 8 bytes, for this object, that is not an abort."""
        got = self.ask(request)
        if not got:
            raise Fail(f"{what}: no answer within {self.setup.wait / 1e6:.0f} ms", "an SDO answer", "nothing")
        if len(got) != 8:
            raise Fail(f"{what}: an answer of {len(got)} bytes", "8 bytes", hexed(got))
        if got[0] == Answer.ABORT << 5:
            raise Aborted(what, sdo.abort_of(got).code)
        if key is not None and sdo.key_of(got) != key:
            raise Fail(f"{what}: the answer names {named(sdo.key_of(got))}", named(key), hexed(got))
        return got

    def refused(self, request: bytes, codes: tuple[int, ...], what: str, others: tuple[int, ...] = ()) -> None:
        """Judged: aborted with one of these codes; one of the others is WARN."""
        self.judge_refusal(self.ask(request), codes, what, others)

    def judge_refusal(self, got: bytes, codes: tuple[int, ...], what: str, others: tuple[int, ...] = ()) -> None:
        wanted = " or ".join(abort_words(code) for code in codes)
        if len(got) != 8 or got[0] != Answer.ABORT << 5:
            raise Fail(f"{what} is not refused", wanted, hexed(got) if got else "silence")
        code = sdo.abort_of(got).code
        if code in others and code not in codes:
            raise Warn(f"{what}: refused with {abort_words(code)}", wanted, abort_words(code))
        if code not in codes:
            raise Fail(f"{what}: refused with {abort_words(code)}", wanted, abort_words(code))

    # ---- transfers
    def upload(self, key: Key) -> bytes:
        """Expedited or segmented, as the server likes."""
        self.unsized = False
        what = f"upload of {named(key)}"
        got = self.asked(sdo.initiate(Request.INITIATE_UPLOAD, key), what, key)
        if got[0] >> 5 != Answer.INITIATE_UPLOAD:
            raise Fail(f"{what}: command byte {got[0]:02X}h", "43h, 47h, 4Bh, 4Fh, 41h or 40h", hexed(got))
        if not got[0] & sdo.EXPEDITED:
            data = self.segments(what)
            if got[0] & sdo.SIZED and len(data) != (size := int.from_bytes(got[4:8], "little")):
                raise Fail(f"{what}: {len(data)} bytes in its segments, {size} announced", f"{size} bytes", f"{len(data)} bytes")
            return data
        self.unsized = not got[0] & sdo.SIZED
        return sdo.expedited_data(got)[: object_size(key) if self.unsized else None]

    def segments(self, what: str, each: Callable[[], None] = lambda: None) -> bytes:
        """The rest of a segmented upload."""
        data, toggle = b"", False
        for _ in range(SEGMENTS):
            got = self.asked(sdo.short(Request.UPLOAD_SEGMENT, sdo.TOGGLE * toggle), f"{what}, segment {len(data) // 7 + 1}")
            if got[0] >> 5 != Answer.UPLOAD_SEGMENT:
                raise Fail(f"{what}: command byte {got[0]:02X}h in a segment", "00h to 1Fh", hexed(got))
            if bool(got[0] & sdo.TOGGLE) is not toggle:
                raise Fail(f"{what}: wrong toggle bit in a segment", f"toggle {int(toggle)}", hexed(got))
            data += sdo.segment_data(got)
            if got[0] & sdo.LAST:
                return data
            each()
            toggle = not toggle
        raise Fail(f"{what}: never ends", "a last segment", f"{len(data)} bytes so far")

    def end_transfer(self, got: bytes) -> None:
        """Aborts the transfer of a server that answers 1000h in segments; the rest is not read."""
        if len(got) == 8 and got[0] >> 5 == Answer.INITIATE_UPLOAD and not got[0] & sdo.EXPEDITED:
            self.say(cobid.sdo_request(self.setup.node), sdo.abort(sdo.key_of(got), Abort.GENERAL))

    def number(self, key: Key, signed: bool = False) -> int:
        return int.from_bytes(self.upload(key), "little", signed=signed)

    def download(self, key: Key, value: int, size: int) -> None:
        """Expedited."""
        data = (value & ((1 << 8 * size) - 1)).to_bytes(size, "little")
        what = f"download of {data.hex(' ').upper()} to {named(key)}"
        got = self.asked(sdo.expedited(Request.INITIATE_DOWNLOAD, key, data), what, key)
        if got[0] != Answer.INITIATE_DOWNLOAD << 5:
            raise Fail(f"{what}: command byte {got[0]:02X}h", "60h", hexed(got))

    def exists(self, key: Key) -> bool:
        try:
            self.upload(key)
        except Ended:
            return False
        return True

    @contextmanager
    def kept(self, *keys: Key) -> Iterator[list[int]]:
        """Write the present values of these objects back afterwards, in reverse order.  N/A if the device lacks one of them."""
        with self.given():
            before = [self._offered(key) for key in keys]
        try:
            yield [int.from_bytes(value, "little") for value in before]
        finally:
            for key, value in reversed(list(zip(keys, before, strict=True))):
                with suppress(Ended):
                    self.download(key, int.from_bytes(value, "little"), len(value))

    def _offered(self, key: Key) -> bytes:
        try:
            return self.upload(key)
        except Aborted as refused:
            if refused.code in (Abort.NO_OBJECT, Abort.NO_SUB):
                raise NotApplicable(f"the device has no {named(key)}") from refused
            raise

    # ---- NMT
    def command(self, what: nmt.Command, node: int | None = None) -> None:
        frame = nmt.command(what, self.setup.node if node is None else node)
        self.say(frame.identifier, frame.data)

    def boot_up(self, wait: Ns | None = None) -> Frame | None:
        """The next boot-up message."""
        until = self.now() + (self.setup.boot if wait is None else wait)
        while (frame := self.hear((cobid.heartbeat(self.setup.node),), max(until - self.now(), 0))) is not None:
            if frame.data == b"\0":
                return frame
        return None

    def reset(self, what: nmt.Command = nmt.Command.RESET_NODE) -> None:
        """Preparing: boots again and answers."""
        self.command(what)
        if self.boot_up() is None:
            raise Inconclusive("preamble: no boot-up message after a reset", "700h + node, one byte 00", "nothing")
        self.ready()

    def ready(self, limit: Ns | None = None) -> None:
        """An SDO is answered; a device may need a moment after its boot-up message."""
        until = self.now() + (self.setup.boot if limit is None else limit)
        missed = False
        while len(got := self.ask(sdo.initiate(Request.INITIATE_UPLOAD, DEVICE_TYPE))) < 4 or sdo.key_of(got) != DEVICE_TYPE:
            missed = True
            self.pause(ms(20))
            if self.now() > until:
                raise Inconclusive("preamble: no SDO answer after the boot-up message", "an answer", "nothing")
        self.end_transfer(got)
        if missed:
            self.pause(2 * self.setup.wait)  # an answer that was only late is none to the next request

    def state(self) -> int:
        """The NMT state, by heartbeat: the producer time is set for this moment."""
        with self.given():
            before = self.upload(HEARTBEAT)
            self.download(HEARTBEAT, 20, 2)
            frame = self.hear((cobid.heartbeat(self.setup.node),), self.setup.wait)
            if frame is None or len(frame.data) != 1:
                raise Fail("no heartbeat after 1017h was set to 20 ms", "a heartbeat", shown(frame))
            found = frame.data[0]
            self.download(HEARTBEAT, int.from_bytes(before, "little"), len(before))
        return found

    def beat(self, wait: Ns | None = None) -> int:
        """The state of the next heartbeat; the producer runs already."""
        self.drain()
        frame = self.hear((cobid.heartbeat(self.setup.node),), self.setup.wait if wait is None else wait)
        if frame is None or len(frame.data) != 1:
            raise Fail("the heartbeat stays away", "one byte on 700h + node", shown(frame))
        return frame.data[0] & 0x7F

    @contextmanager
    def beating(self, period_ms: int = 20) -> Iterator[None]:
        """The node produces heartbeats within the block."""
        with self.kept(HEARTBEAT):
            with self.given():
                self.download(HEARTBEAT, period_ms, 2)
            yield

    @contextmanager
    def operational(self) -> Iterator[None]:
        """NMT state operational within the block."""
        self.command(nmt.Command.START)
        self.pause(ms(2))
        try:
            yield
        finally:
            self.command(nmt.Command.PRE_OPERATIONAL)
            self.pause(ms(2))

    @contextmanager
    def stopped(self) -> Iterator[None]:
        """NMT state stopped within the block."""
        self.command(nmt.Command.STOP)
        self.pause(ms(5))
        try:
            yield
        finally:
            self.command(nmt.Command.PRE_OPERATIONAL)
            self.pause(ms(5))

    def sync(self, data: bytes = b"") -> None:
        self.say_on(cobid.SYNC, data)

    def on_grid(self, count: int = 1) -> None:
        """So many SYNCs, each a cycle after the one before, regardless of other actions between."""
        for _ in range(count):
            self._grid = max(self._grid + self.period, self.now())
            self.pause(self._grid - self.now())
            self.sync()

    def alive(self) -> None:
        """The suites' postamble: an SDO is answered."""
        got = self.ask(sdo.initiate(Request.INITIATE_UPLOAD, DEVICE_TYPE))
        self.end_transfer(got)
        if not got:
            raise Fail("an SDO upload is no longer answered", "an SDO answer", "nothing")
