"""RK512: active stations with one fault each (used by peers.rk512)."""

from gateway.conformance.peers.stations import ActiveStation, Built
from protocols.base.machine import Ns, ms
from protocols.p3964r.profiles import RHO3
from protocols.p3964r.receiver import Receiver
from protocols.rk512.active import Active
from protocols.rk512.active import Event as ActiveEvent
from protocols.rk512.station import Event as StationEvent
from protocols.rk512.station import Station as Roles


class Hangs(Active):
    """A reaction it does not like is waited for again, for ever."""

    def reaction(self, data: bytes, now: Ns) -> list[ActiveEvent]:
        if data[3:4] != b"\x00" or data[:1] not in (b"\x00", b"\xff"):
            self._until = None
            return []
        return [*super().reaction(data, now)]


class HangsWhenShort(Active):
    def reaction(self, data: bytes, now: Ns) -> list[ActiveEvent]:
        if len(data) < 4:
            self._until = None
            return []
        return [*super().reaction(data, now)]


class WaitsForEver(Active):
    """No limit for the reaction."""

    def acknowledged(self, now: Ns) -> list[ActiveEvent]:
        events = super().acknowledged(now)
        if self._until is not None:
            self._until += ms(10_000_000)
        return [*events]


class Patient(Active):
    """Waits for its reaction longer than usual, as CP 341 does."""

    def acknowledged(self, now: Ns) -> list[ActiveEvent]:
        events = super().acknowledged(now)
        if self._until is not None:
            self._until = now + ms(20_000)
        return [*events]


class HangsAtError(Active):
    number = 0x14

    def reaction(self, data: bytes, now: Ns) -> list[ActiveEvent]:
        if data[3:4] == bytes((self.number,)):
            self._until = None
            return []
        return [*super().reaction(data, now)]


class HangsInStop(HangsAtError):
    number = 0x2A


class HangsWhenLocked(HangsAtError):
    number = 0x32


class HangsWhenLong(Active):
    def reaction(self, data: bytes, now: Ns) -> list[ActiveEvent]:
        if self._until is not None and len(data) > 8:
            self._until = None
            return []
        return [*super().reaction(data, now)]


class CommandTwice(ActiveStation):
    """Each FETCH is sent twice."""

    _repeated = 0

    def _serve(self, data: bytes, now: Ns) -> None:
        if data[:4] == bytes(4) and self._jobs % 2 and self._repeated != self._jobs:
            self._repeated = self._jobs
            self.active.fetch(0, 2, block=5)
        super()._serve(data, now)


class StopsAtCommand(Roles):
    """A command in place of the reaction is dropped, and so is all after it."""

    _stopped = False

    def block(self, data: bytes, now: Ns, overtaken: bool = False) -> list[StationEvent]:
        if self.active.awaiting and len(data) > 4 and data[2] == 0x45:
            self._stopped = True
        return [] if self._stopped else super().block(data, now, overtaken)

    def take_block(self) -> bytes | None:
        return None if self._stopped else super().take_block()


class SmallType(ActiveStation):
    """Its SEND names type d (64h)."""

    def _hand_over(self, now: Ns) -> None:
        while (block := self.roles.take_block()) is not None:
            self.link.send(block[:3] + b"d" + block[4:] if len(block) > 10 and block[2] == 0x41 else block, now)


class NoCommand(ActiveStation):
    """Its SEND is command I (49h)."""

    def _hand_over(self, now: Ns) -> None:
        while (block := self.roles.take_block()) is not None:
            self.link.send(block[:2] + b"I" + block[3:] if len(block) > 10 and block[2] == 0x41 else block, now)


class WrongAmount(ActiveStation):
    """Announces one word less than it sends."""

    def _hand_over(self, now: Ns) -> None:
        while (block := self.roles.take_block()) is not None:
            if len(block) > 10 and block[2] == 0x41:
                block = block[:7] + bytes((block[7] - 1,)) + block[8:]
            elif len(block) == 10 and block[2] == 0x45:
                block = block[:6] + b"\0\0" + block[8:]
            self.link.send(block, now)


class _RefusesEight(Receiver):
    """Refuses a block of eight characters, however right."""

    def _judge(self, check: int) -> None:
        super()._judge(check ^ 0xFF if len(self._data) == 8 else check)


class RefusesReaction(ActiveStation):
    """The reaction to its FETCH of two words is answered with NAK."""

    def __init__(self) -> None:
        super().__init__()
        self.link._receiver = _RefusesEight(RHO3, self.link._box, False)


class LongJobs(ActiveStation):
    """Correct; its jobs need follow-on telegrams."""

    def stimulate(self, now: Ns, block: bytes = b"") -> None:
        self._jobs += 1
        if self._jobs % 2:
            self.active.fetch(0, 150, block=5)
        else:
            self.active.send(0, bytes(300), block=5)
        self._hand_over(now)


class SmallLetters(Built):
    """Takes commands in small letters as well."""

    def _serve(self, data: bytes, now: Ns) -> None:
        super()._serve(data[:2] + data[2:3].upper() + data[3:], now)
