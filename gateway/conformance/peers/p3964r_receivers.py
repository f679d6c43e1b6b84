"""3964R: receivers with one fault each (used by peers.p3964r)."""

from protocols.base.machine import Damage, Ns, ms
from protocols.p3964r.characters import Char
from protocols.p3964r.events import BlockReceived, Refusal
from protocols.p3964r.receiver import Receiver
from protocols.p3964r.receiver import State as Hearing


class AnyCheck(Receiver):
    def _judge(self, check: int) -> None:
        super()._judge(self._check)


class TopBitOfCheck(Receiver):
    def _judge(self, check: int) -> None:
        super()._judge(self._check if (check ^ self._check) == 0x80 else check)


class ZeroIsGood(Receiver):
    def _judge(self, check: int) -> None:
        super()._judge(self._check if check == 0 else check)


class OrComplement(Receiver):
    def _judge(self, check: int) -> None:
        super()._judge(self._check if check == self._check ^ 0xFF else check)


class OnceToo(Receiver):
    """Takes a check that counts a doubled DLE once as well."""

    def _judge(self, check: int) -> None:
        super()._judge(self._check if check == self._check ^ Char.DLE and Char.DLE in self._data else check)


class CheckOfDle(Receiver):
    """A check of 10h counts as the start of a pair."""

    def _judge(self, check: int) -> None:
        super()._judge(check ^ 0xFF if check == Char.DLE else check)


class CheckOfNak(Receiver):
    def _judge(self, check: int) -> None:
        super()._judge(check ^ 0xFF if check == Char.NAK else check)


class FalseEnd(Receiver):
    """A doubled 10h followed by 03h ends the block."""

    def _collect(self, data: bytes, at: int) -> int:
        if data[at] == Char.ETX and self._data[-1:] == bytes((Char.DLE,)):
            self._check ^= Char.ETX
            self._state = Hearing.CHECK
            return at + 1
        return super()._collect(data[: at + 1], at)


class AnswersInside(Receiver):
    """Answers 02h in the data with DLE, and continues."""

    def _collect(self, data: bytes, at: int) -> int:
        if data[at] == Char.STX and self._data:
            self._box.say(Char.DLE)
        return super()._collect(data[: at + 1], at)


class NoZeroFirst(Receiver):
    """Refuses a block that begins with 00."""

    def _judge(self, check: int) -> None:
        super()._judge(check ^ 0xFF if self._data[:1] == b"\0" else check)


class PairKeepsTimer(Receiver):
    """The second character of a pair does not restart ZVZ."""

    def hear(self, data: bytes, at: int, now: Ns) -> int:
        before = self.due if self._state is Hearing.ESCAPED else None
        found = super().hear(data, at, now)
        if before is not None and self._state is Hearing.DATA:
            self.due = before
        return found


class Restarts(Receiver):
    """02h inside a block restarts it."""

    def _collect(self, data: bytes, at: int) -> int:
        if data[at] == Char.STX:
            self._data.clear()
            self._count, self._check = 0, 0
            self._guard.untouched = False
            return at + 1
        return super()._collect(data[: at + 1], at)


class PairRestarts(Receiver):
    """DLE STX inside a block restarts it."""

    def _broken_pair(self, byte: int) -> None:
        if byte != Char.STX:
            super()._broken_pair(byte)
            return
        self._state = Hearing.DATA
        self._data.clear()
        self._count, self._check = 0, 0


class StaysDoubled(Receiver):
    """A doubled DLE is two characters of the data."""

    def _second_of_pair(self, byte: int) -> None:
        super()._second_of_pair(byte)
        if byte == Char.DLE:
            self._store(bytes((Char.DLE,)))


class NakEnds(Receiver):
    """15h inside a block ends it."""

    def _collect(self, data: bytes, at: int) -> int:
        if data[at] == Char.NAK:
            self._refuse(Refusal.ORDER)
            return at + 1
        return super()._collect(data[: at + 1], at)


class NoTimer(Receiver):
    """Waits for the next character for ever."""

    def hear(self, data: bytes, at: int, now: Ns) -> int:
        found = super().hear(data, at, now)
        self.due = None
        return found

    def sent(self, now: Ns) -> None:
        super().sent(now)
        self.due = None


class TimerOfBlock(Receiver):
    """The character delay runs once, from the DLE on."""

    _began: Ns = 0

    def sent(self, now: Ns) -> None:
        super().sent(now)
        if self._state is Hearing.DATA and self._guard.untouched:
            self._began = now

    def hear(self, data: bytes, at: int, now: Ns) -> int:
        found = super().hear(data, at, now)
        if self.due is not None and not self._guard.untouched and self._state in (Hearing.DATA, Hearing.ESCAPED, Hearing.CHECK):
            self.due = min(self.due, self._began + self._profile.char_delay)
        return found


class NoTimerBeforeCheck(Receiver):
    def hear(self, data: bytes, at: int, now: Ns) -> int:
        found = super().hear(data, at, now)
        if self._state is Hearing.CHECK and self.due is not None:
            self.due += ms(2000)
        return found


class NoTimerInPair(Receiver):
    def hear(self, data: bytes, at: int, now: Ns) -> int:
        found = super().hear(data, at, now)
        if self._state is Hearing.ESCAPED and self.due is not None:
            self.due += ms(2000)
        return found


class SilentGap(Receiver):
    """Leaves a block that broke off without a word."""

    def expire(self, now: Ns) -> None:
        inside = self._state in (Hearing.DATA, Hearing.ESCAPED, Hearing.CHECK)
        before = len(self._box.output)
        super().expire(now)
        if inside:
            del self._box.output[before:]


class Locks(Receiver):
    """After five refused blocks it receives nothing any more."""

    _bad = 0

    def _refuse(self, why: Refusal) -> None:
        self._bad += 1
        super()._refuse(why)

    def hear(self, data: bytes, at: int, now: Ns) -> int:
        return len(data) if self._bad >= 5 else super().hear(data, at, now)


class GarbageKills(Receiver):
    """Twenty stray characters fill its buffer for ever."""

    _full = False

    def hear(self, data: bytes, at: int, now: Ns) -> int:
        self._full = self._full or self._strays > 20
        return len(data) if self._full else super().hear(data, at, now)


class TailOpens(Receiver):
    """NAK at once at a broken pair, and a 02h of the rest opens a block."""

    def _broken_pair(self, byte: int) -> None:
        self._refuse(Refusal.ORDER)
        self._guard.torn = self._guard._restless = False

    def _open(self, now: Ns) -> None:
        self._guard.torn = self._guard._restless = False
        super()._open(now)


class EmptyHangs(Receiver):
    """An empty block is never answered, and nothing is after it."""

    _hung = False

    def _deliver(self) -> None:
        if not self._data:
            self._hung = True
            self._rest()
        else:
            super()._deliver()

    def hear(self, data: bytes, at: int, now: Ns) -> int:
        return len(data) if self._hung else super().hear(data, at, now)


class EveryTenth(Receiver):
    """Every 25th good block is refused."""

    _good = 0

    def _deliver(self) -> None:
        self._good += 1
        if self._good % 25 == 0:
            self._refuse(Refusal.CHECK)
        else:
            super()._deliver()


class DleInIdle(Receiver):
    """A DLE in idle is answered with DLE."""

    def _stray(self, now: Ns) -> None:
        super()._stray(now)

    def hear(self, data: bytes, at: int, now: Ns) -> int:
        if self._state is Hearing.IDLE and data[at] == Char.DLE:
            self._box.say(Char.DLE)
        return super().hear(data, at, now)


class StrayOpens(Receiver):
    """Any character in idle counts as STX."""

    def hear(self, data: bytes, at: int, now: Ns) -> int:
        if self._state is Hearing.IDLE and data[at] not in (Char.STX, Char.NAK, Char.DLE):
            self._open(now)
            return at + 1
        return super().hear(data, at, now)


class AnswersNak(Receiver):
    """NAK in idle is answered with NAK."""

    def hear(self, data: bytes, at: int, now: Ns) -> int:
        if self._state is Hearing.IDLE and data[at] == Char.NAK:
            self._box.say(Char.NAK)
        return super().hear(data, at, now)


class AnyCheckAfterDamage(Receiver):
    """The adapter passes a damaged character on as good, and the block check is ignored."""

    def _judge(self, check: int) -> None:
        super()._judge(self._check if b"U" in self._data[1:] else check)


class DamageEnds(TailOpens):
    """NAK at once at a damaged character, and a 02h of the rest opens a block."""

    def damaged(self, kind: Damage, now: Ns) -> None:
        if kind is Damage.BREAK or self._state is not Hearing.DATA:
            super().damaged(kind, now)
        else:
            self._broken_pair(0)


class NaksGapTwice(Receiver):
    """Two NAK for a block that broke off."""

    def expire(self, now: Ns) -> None:
        inside = self._state in (Hearing.DATA, Hearing.ESCAPED, Hearing.CHECK)
        super().expire(now)
        if inside:
            self._box.output.append(Char.NAK)


class TakesBrokenOff(Receiver):
    """A block whose check never comes is refused, but delivered."""

    def expire(self, now: Ns) -> None:
        data = bytes(self._data) if self._state is Hearing.CHECK else b""
        super().expire(now)
        if data:
            self._box.report(BlockReceived(data))
