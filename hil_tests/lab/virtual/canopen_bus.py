"""A CANopen bus in virtual time: a master in the test's hand and the emulated CiA 402 drives, no process and no clock.

`Master` speaks bytes: it uses nothing of the emulator's own codecs but the frames of protocols.canopen.
"""

from collections.abc import Callable

from drivers.emulator.cia402.axis import Cia402Axis
from drivers.emulator.cia402.slave import Cia402Slave
from drivers.emulator.servo import record
from drivers.emulator.servo.settings import BusSettings, DriveSettings, ServoSettings
from gateway.files.find import find_config
from protocols.base.machine import Frame, Ns, ms
from protocols.canopen import cob_id as cobid
from protocols.canopen import nmt, sdo
from protocols.canopen.dictionary import ObjectDictionary
from protocols.canopen.eds import parse

START: Ns = 1_000_000_000_000
EDS_TEXT = find_config("axisgate_402.eds", "drives").read_text()
DICTIONARY: ObjectDictionary
DICTIONARY, _FAULTS = parse(EDS_TEXT)
assert not _FAULTS, _FAULTS
QUICK = ServoSettings(boot_s=0.01, charge_s=0.0)


class AbortedError(AssertionError):
    """The server aborted."""

    def __init__(self, code: int) -> None:
        super().__init__(f"{code:08X}h {sdo.TEXTS.get(code, '')}")
        self.code = code


class CanopenBus:
    """`said`: every frame of the drives with the time it was sent; nodes 1, 2, .. unless named."""

    def __init__(self, *drives: DriveSettings, cycle_ms: float = 4.0, seed: int = 1, nodes: dict[int, DriveSettings] | None = None) -> None:
        chosen = nodes or dict(enumerate(drives or (DriveSettings(QUICK),), 1))
        self.settings = BusSettings(cycle_ms, seed, {}, chosen)
        self.slave = Cia402Slave(self.settings, dict.fromkeys(chosen, DICTIONARY))
        self.cycle_ns = self.slave.cycle_ns
        self.now: Ns = START
        self.said: list[Frame] = []
        self.trace: list[Frame] = []
        self._rows = bytearray(self.slave.header())
        self.wake(START)

    # -- time -----------------------------------------------------------------------------------

    def wake(self, until: Ns) -> None:
        """Time passes; every deadline on the way is kept to the nanosecond."""
        for _ in range(1_000_000):
            due = self.slave.deadline()
            if due is None or due > until:
                break
            self.slave.wake(max(due, self.now))
            self._listen(max(due, self.now))
        else:
            raise AssertionError("a deadline does not move")
        self.now = until
        self.slave.wake(until)
        self._listen(until)

    def run(self, seconds: float) -> None:
        self.wake(self.now + round(seconds * 1e9))

    def hand(self, *frames: Frame) -> list[Frame]:
        """These frames reach the drives now; what they answer at once."""
        stamped = [frame._replace(stamp_ns=self.now) for frame in frames]
        self.trace += stamped
        before = len(self.said)
        self.slave.receive(stamped, self.now)
        self._listen(self.now)
        return self.said[before:]

    def _listen(self, now: Ns) -> None:
        self.said += [frame._replace(stamp_ns=now) for frame in self.slave.take_output()]

    def heard(self, identifier: int, since: int = 0) -> list[Frame]:
        """Return what was sent on an identifier."""
        return [frame for frame in self.said[since:] if frame.identifier == identifier]

    def cycle(self, *sets: Frame) -> list[Frame]:
        """Set values, then SYNC one cycle after the last; the answers."""
        self.run(self.cycle_ns * 1e-9 * 0.5)
        if sets:
            self.hand(*sets)
        self.run(self.cycle_ns * 1e-9 * 0.5)
        answers = self.hand(Frame(cobid.SYNC))
        self.slave.prepare()
        return answers

    # -- a node ---------------------------------------------------------------------------------

    def node(self, number: int = 1) -> "Master":
        return Master(self, number)

    def axis(self, number: int = 1) -> Cia402Axis:
        return self.slave.axis(number)

    def rows(self) -> tuple[record.Row, ...]:
        self._rows += self.slave.take_record()
        return record.read(bytes(self._rows)).rows


class Master:
    """What a master does with one node, over frames alone."""

    def __init__(self, bus: CanopenBus, number: int) -> None:
        self.bus, self.number = bus, number

    def ask(self, request: bytes) -> bytes:
        """One SDO request; the one answer."""
        answers = [frame.data for frame in self.bus.hand(Frame(cobid.sdo_request(self.number), request)) if self._mine(frame)]
        assert len(answers) == 1, f"{request.hex(' ')}: {len(answers)} answers"
        return answers[0]

    def asks(self, request: bytes) -> list[bytes]:
        """One SDO request; all answers."""
        return [frame.data for frame in self.bus.hand(Frame(cobid.sdo_request(self.number), request)) if self._mine(frame)]

    def _mine(self, frame: Frame) -> bool:
        return frame.identifier == cobid.sdo_answer(self.number)

    def write(self, index: int, sub: int, value: int, size: int) -> None:
        """Expedited download.  Raises AbortedError."""
        data = (value & ((1 << 8 * size) - 1)).to_bytes(size, "little")
        self._good(self.ask(sdo.expedited(sdo.Request.INITIATE_DOWNLOAD, (index, sub), data)))

    def set(self, index: int, value: int, sub: int = 0) -> None:
        """Expedited download with the size of the data sheet."""
        entry = DICTIONARY.entry(index, sub)
        assert entry is not None, f"{index:04X}h:{sub}"
        self.write(index, sub, value, entry.type.size)

    def read(self, index: int, sub: int = 0) -> int:
        """Expedited upload of a number; signed as in the data sheet.  Raises AbortedError."""
        entry = DICTIONARY.entry(index, sub)
        answer = self._good(self.ask(sdo.initiate(sdo.Request.INITIATE_UPLOAD, (index, sub))))
        signed = entry is not None and entry.type.low < 0
        return int.from_bytes(sdo.expedited_data(answer), "little", signed=signed)

    def _good(self, answer: bytes) -> bytes:
        if answer[0] == sdo.Request.ABORT << 5:
            raise AbortedError(sdo.abort_of(answer).code)
        return answer

    def nmt(self, command: nmt.Command) -> None:
        self.bus.hand(nmt.command(command, self.number))

    @property
    def status(self) -> int:
        return self.read(0x6041)

    def control(self, word: int) -> int:
        """Controlword by SDO; the statusword after it."""
        self.set(0x6040, word)
        return self.status

    def until(self, reached: Callable[[], bool], limit_s: float = 5.0, step_s: float = 0.001) -> float:
        """Time passes until it is so; the seconds it took."""
        begin = self.bus.now
        while not reached():
            assert self.bus.now - begin < limit_s * 1e9, f"not within {limit_s} s; statusword {self.status:04X}h"
            self.bus.run(step_s)
        return (self.bus.now - begin) * 1e-9

    def until_state(self, bits: int, limit_s: float = 5.0) -> float:
        """Until bits 0..3, 5, 6 of the statusword are these."""
        return self.until(lambda: self.status & 0x6F == bits, limit_s)

    def enable(self, mode: int) -> None:
        """Boots, chooses the mode, goes to operation enabled by SDO alone."""
        self.until(lambda: bool(self.bus.heard(cobid.heartbeat(self.number))))
        self.until(lambda: self.status & 0x4F == 0x40)
        self.set(0x6060, mode)
        for word, expected in ((6, 0x21), (7, 0x23), (15, 0x27)):
            self.control(word)
            self.until_state(expected)

    def in_cycle(self, mode: int = 8) -> None:
        """Set values by RPDO1 and actual values by TPDO1, both with SYNC; operation enabled, 607Ah = 6064h."""
        self.until(lambda: bool(self.bus.heard(cobid.heartbeat(self.number))))
        self.set(0x1800, 1, 2)
        self.set(0x1400, 1, 2)
        self.nmt(nmt.Command.START)
        self.set(0x607A, self.read(0x6064))
        self.enable(mode)


def rpdo1(node: int, word: int, position: int) -> Frame:
    """Controlword and target position."""
    return Frame(cobid.rpdo(1, node), word.to_bytes(2, "little") + (position & 0xFFFFFFFF).to_bytes(4, "little"))


def tpdo1(frame: Frame) -> tuple[int, int]:
    """Statusword and position."""
    return int.from_bytes(frame.data[:2], "little"), int.from_bytes(frame.data[2:6], "little", signed=True)


SECOND = ms(1000)
