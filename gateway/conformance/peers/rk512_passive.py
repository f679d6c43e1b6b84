"""RK512: passive stations with one fault each (used by peers.rk512)."""

from collections.abc import Callable, Sequence

from gateway.conformance.peers.powered import Powered
from gateway.conformance.peers.stations import Built, Chatty
from gateway.conformance.serial.partners import Blocks, Late
from protocols.base.machine import Ns, ms
from protocols.p3964r.profiles import RHO3, Priority
from protocols.rk512.dialects import Dialect
from protocols.rk512.flags import Flags
from protocols.rk512.header import ErrorNumber, Flag, Header
from protocols.rk512.passive import Event as PassiveEvent
from protocols.rk512.passive import Passive, Refused

Change = Callable[[bytes, bytes], bytes | None]  # command, reaction -> the reaction sent instead


class ChangedReactions(Passive):
    """Our passive station with one reaction changed: `change(command, reaction)`; None: no reaction is sent."""

    def __init__(self, blocks: Blocks, change: Change, dialect: Dialect | None = None) -> None:
        super().__init__(blocks, dialect)
        self._change, self._command = change, b""

    def telegram(self, data: bytes, now: Ns) -> list[PassiveEvent]:
        self._command = data
        return super().telegram(data, now)

    def take_output(self) -> bytes | None:
        output = super().take_output()
        return output if output is None else self._change(self._command, output)


class ChattyAndSilent(Chatty):
    """Correct; sends blocks of its own, and does not react to what begins neither with 00 nor with FF."""

    def __init__(self) -> None:
        super().__init__()
        self.passive = ChangedReactions(self.blocks, lambda command, said: said if command[:1] in (b"\0", b"\xff") else None)


class StickyNumber(ChangedReactions):
    """The number of a refusal is in the next reaction to SEND as well."""

    def __init__(self, blocks: Blocks) -> None:
        super().__init__(blocks, self._stuck)
        self._number = 0

    def _stuck(self, command: bytes, said: bytes) -> bytes:
        number, self._number = self._number, said[3]
        return said[:3] + bytes((number,)) if number and len(said) == 4 and not said[3] else said


class ShortSends(Passive):
    """Writes the received data, whatever was announced."""

    def _wrong_amount(self, header: Header, data_bytes: int) -> tuple[int, str] | None:
        return None if header.command == 0x41 else super()._wrong_amount(header, data_bytes)


class WritesThenRefuses(Passive):
    """Writes the received data, then finds the length wrong."""

    def _wrong_amount(self, header: Header, data_bytes: int) -> tuple[int, str] | None:
        fault = super()._wrong_amount(header, data_bytes)
        if fault is not None and header.command == 0x41 and data_bytes:
            self._blocks.write(header.db, header.address, b"\x77" * (data_bytes // 2 * 2 or 2))
        return fault


class NoLength(Passive):
    """Ignores what follows the header of a FETCH."""

    def _wrong_amount(self, header: Header, data_bytes: int) -> tuple[int, str] | None:
        return super()._wrong_amount(header, 0 if header.command == 0x45 else data_bytes)


class NoFirstByte(Passive):
    def _form(self, data: bytes) -> tuple[int, str] | None:
        return super()._form(b"\x00" + data[1:] if data[:1] not in (b"\x00", b"\xff") else data)

    def telegram(self, data: bytes, now: Ns) -> list[PassiveEvent]:
        return super().telegram(b"\x00" + data[1:] if data[:1] == b"\x55" and len(data) > 9 else data, now)


class Ignores(Passive):
    """Correct: a block that begins with neither 00 nor FF is not a command to it."""

    def telegram(self, data: bytes, now: Ns) -> list[PassiveEvent]:
        return super().telegram(data, now) if data[:1] in (b"\0", b"\xff") else []


class LockedByFollowOn(Passive):
    """A long job that is abandoned is waited for for ever."""

    def _refuse(self, fault: tuple[int, str], data: bytes) -> Refused:
        kept = self._open
        refused = super()._refuse(fault, data)
        self._open = kept
        return refused


class SilentToErrors(Passive):
    def take_output(self) -> bytes | None:
        output = super().take_output()
        return None if output is not None and output[3] else output


class DiesOfErrors(Passive):
    """After four refusals nothing is served."""

    _bad = 0

    def take_output(self) -> bytes | None:
        output = super().take_output()
        if output is not None and output[3]:
            self._bad += 1
        return None if self._bad > 4 else output


class SendDx(Passive):
    """A SEND to DX lands in the data block of the same number."""

    def telegram(self, data: bytes, now: Ns) -> list[PassiveEvent]:
        return super().telegram(data[:2] + b"AD" + data[4:] if data[2:3] == b"O" else data, now)


class FetchDx(Passive):
    """A FETCH of DX brings the words of the data block of the same number; SEND to DX is refused."""

    def telegram(self, data: bytes, now: Ns) -> list[PassiveEvent]:
        return super().telegram(data[:2] + b"ED" + data[4:] if data[2:4] == b"EX" else data, now)


class LoneSend(Passive):
    """Writes a follow-on SEND without a first one after the words of the last SEND."""

    _behind = 0

    def telegram(self, data: bytes, now: Ns) -> list[PassiveEvent]:
        if data[:4] == b"\0\0AD" and len(data) >= 10:
            self._last, self._behind = data, data[5] + (len(data) - 10) // 2
        elif data[:4] == b"\xff\0AD" and self._behind and len(self._last) < 100:
            head = self._last[:5] + bytes((self._behind, 0, (len(data) - 4) // 2)) + self._last[8:10]
            return super().telegram(head + data[4:], now)
        return super().telegram(data, now)


class LowAmount(Passive):
    """The high byte of the amount does not count."""

    def telegram(self, data: bytes, now: Ns) -> list[PassiveEvent]:
        return super().telegram(data[:6] + b"\0" + data[7:] if data[:1] == b"\0" and len(data) >= 10 else data, now)


class KeepsPieces(Passive):
    """The data of an abandoned SEND are put before the next one."""

    def telegram(self, data: bytes, now: Ns) -> list[PassiveEvent]:
        before = b""
        if self._open is not None and data[:1] == b"\0":
            before, self._open = bytes(self._open.data), None
        events = super().telegram(data, now)
        if self._open is not None and data[2:3] == b"A" and data[:1] == b"\0":
            self._open.data[:] = (before + bytes(self._open.data))[: len(self._open.data)]
        return events


class NeverLocks(Flags):
    """A flag that is set locks nothing."""

    def locks(self, flag: Flag | None) -> bool:
        return False


class WritesLocked(Passive):
    """A SEND that it refuses with 32h is written."""

    def _refuse(self, fault: tuple[int, str], data: bytes) -> Refused:
        if fault[0] == ErrorNumber.LOCKED and data[2:3] == b"A":
            self._blocks.write(data[4], data[5], data[10:])
        return super()._refuse(fault, data)


class Twice(Built):
    """Each reaction comes twice."""

    def _serve(self, data: bytes, now: Ns) -> None:
        assert self.passive is not None
        self.passive.telegram(data, now)
        while (reaction := self.passive.take_output()) is not None:
            self.link.send(reaction, now)
            self.link.send(reaction, now)


class OneByteKills(Built):
    """A telegram of less than four bytes ends its service."""

    def _serve(self, data: bytes, now: Ns) -> None:
        if len(data) < 4:
            self.passive = None
        super()._serve(data, now)


class Slow(Built):
    """The reaction comes late: after seven seconds, too late.  A new command withdraws one that is waited for."""

    _due: Ns | None = None
    _waiting: bytes = b""

    def __init__(self, late: Ns = ms(7000)) -> None:
        super().__init__()
        self._late = late

    def _serve(self, data: bytes, now: Ns) -> None:
        self._due, self._waiting = now + self._late, data

    def deadline(self) -> Ns | None:
        moments = [moment for moment in (super().deadline(), self._due) if moment is not None]
        return min(moments, default=None)

    def wake(self, now: Ns) -> Sequence[object]:
        if self._due is not None and now >= self._due:
            self._due = None
            super()._serve(self._waiting, now)
        due = self.link.deadline()
        return super().wake(now) if due is not None and due <= now else []


class Beside(Built):
    """A command with a wrong block check is executed."""

    def _handle(self, events: Sequence[object], now: Ns) -> Sequence[object]:
        handled = super()._handle(events, now)
        if any(type(event).__name__ == "BlockRefused" for event in events):
            self._serve(bytes((0, 0, 0x45, 0x44, 10, 0, 0, 1, 0xFF, 0xFF)), now)
        return handled


class ReactsLate(Powered):
    """A command before the power failure is answered after it."""

    def __init__(self) -> None:
        super().__init__(lambda: Late(RHO3, Priority.LOW, late=ms(20)))

    def power(self, on: bool, now: Ns) -> None:
        before = self._device
        super().power(on, now)
        if on:
            self._device = before
