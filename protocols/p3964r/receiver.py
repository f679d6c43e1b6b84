"""Receiving side of 3964R.  Source: rho 3 Releases part 1, section 7.1 (below: 7.1); refusals: AX-007, AX-008; remainders: AX-240."""

from enum import Enum, auto

from protocols.base.machine import Damage, Ns
from protocols.p3964r.block_buffer import BlockBuffer
from protocols.p3964r.characters import DLE, DLE_BYTE, ETB, ETX, NAK, STX, check_of
from protocols.p3964r.events import (
    BlockReceived,
    BlockRefused,
    LineBreak,
    Outbox,
    Refusal,
    StrayCharacters,
)
from protocols.p3964r.profiles import BrokenPair, Profile, Stray, TooLong
from protocols.p3964r.remainders import Remainders
from protocols.p3964r.repeats import Repeats


class State(Enum):
    """What the receiver expects next."""

    IDLE = auto()  # STX; a repeat may be expected, which only affects the events
    NO_BUFFER = auto()  # received STX, has no room for the block; waits for some
    DATA = auto()  # inside the block
    ESCAPED = auto()  # one DLE received; the next character defines its meaning
    CHECK = auto()  # end seen; the block check comes next, whatever its value
    DEAF = auto()  # the rest of a broken or torn block comes in: nothing in it is a wish to send; a quiet line ends it (AX-228, AX-240)


IDLE, NO_BUFFER, DATA, ESCAPED, CHECK, DEAF = State  # compared at every character: State.DATA costs a search in its class
INSIDE = (DATA, ESCAPED, CHECK)
ENDS = (ETX, ETB)  # after a DLE
NAK_BYTE = bytes((NAK,))


class Receiver:
    """Takes blocks off the line and answers them; half of a Link, which passes it its characters."""

    def __init__(self, profile: Profile, box: Outbox, keep_one: bool) -> None:
        self._profile, self._box = profile, box
        self._most = profile.most_received
        self._cut = profile.too_long is TooLong.NAK_AT_ONCE
        self._block_check = profile.block_check
        self._state = IDLE
        self.due: Ns | None = None  # end of the gap, of the wait for a buffer, or of the quiet after stray characters
        self._why: Refusal | None = None  # first fault of the running block; it is received to its end all the same (AX-007)
        self._check, self._data, self._count = 0, bytearray(), 0
        self._strays = 0
        self._guard = Remainders(box, profile.char_delay)
        self.repeats = Repeats(box, profile.block_attempts, profile.block_wait)
        self._buffer = BlockBuffer(keep_one, profile.no_buffer_wait, profile.no_buffer_poll)

    @property
    def busy(self) -> bool:
        """Inside a block or about to be: the line belongs to the partner."""
        return self._state is not IDLE

    @property
    def heard_only_dle(self) -> bool:
        """A lone DLE since we connected: sent by a partner that gave way while this side gave way too."""
        return self._state is ESCAPED and self._count == 0

    # ---- the table
    def hear(self, data: bytes, at: int, now: Ns) -> int:
        """Take characters from index `at` on until idle again or none are left; returns the index of the next one."""
        guard, turn = self._guard, self._box.turn
        if guard.early and guard.outrun:
            self._forget()
        size = len(data)
        while at < size:
            byte = data[at]
            if guard.untouched and (guard.doubted or turn == guard.opened_in) and self._other_than_begun(byte):
                at += 1
            elif self._state is DATA and byte != DLE:
                at = self._collect(data, at)
            else:
                self._step(byte, now)
                at += 1
            if self._state is IDLE:
                break
        guard.heard_at = now
        if not guard.untouched and self._state is not IDLE and self._state is not NO_BUFFER:
            self.due = now + self._profile.char_delay
        return at

    def _other_than_begun(self, byte: int) -> bool:
        """The first character after our DLE, if it repeats the request or shows that there was none.  True: it is handled."""
        if self._guard.not_opened(byte):
            self._close_again(byte)
        elif self._guard.wish_again(byte):
            self._wish_again(byte)
            return True
        return False

    def _step(self, byte: int, now: Ns) -> None:
        """One row of the table; the states come as often as they do here."""
        state = self._state
        if state is DATA:  # DLE
            self._state = ESCAPED
        elif state is ESCAPED:
            self._second_of_pair(byte)
        elif state is CHECK:
            self._judge(byte)
        elif state is IDLE:
            if byte == STX and not self._guard.behind_an_end:  # else in one breath with the end of a block: part of it
                self._open(now)
                return
            if byte != NAK:  # the partner gave up or started; never answered, so two stations cannot loop
                self._stray(now)
            self._pass_over(byte)
        elif state is DEAF:
            self._strays += 1
            self._pass_over(byte)
        # NO_BUFFER: still the same wish to send (AX-006)
        self._guard.heard(inside=self._state in INSIDE)

    def _second_of_pair(self, byte: int) -> None:
        """Meaning of the DLE before it."""
        if byte == DLE:
            self._state = DATA
            self._store(DLE_BYTE)  # both enter the check, so they cancel
        elif byte in ENDS:
            self._check ^= DLE ^ byte
            self._state = CHECK
            if not self._block_check:
                self._judge(self._check)
        else:
            self._broken_pair(byte)

    def _collect(self, data: bytes, at: int) -> int:
        """A run of plain characters up to the next DLE, handled at once; the same as one step for each."""
        end = data.find(DLE_BYTE, at)
        run = data[at:] if end < 0 else data[at:end]
        if 0 <= end < len(data) - 2 and data[end + 1] in ENDS and self._block_check and self._count + len(run) <= self._most:
            self._end(run, data[end + 1], data[end + 2])
            return end + 3
        if self._cut:
            run = run[: self._most + 1 - self._count]  # the first one too many ends the block
        self._check ^= check_of(run)
        self._store(run)
        self._guard.heard(inside=self._state in INSIDE)
        return at + len(run)

    def _end(self, run: bytes, end: int, check: int) -> None:
        """The last plain run of a block, DLE, its end character and its check, all at once."""
        self._data += run
        self._count += len(run)
        self._check ^= check_of(run) ^ DLE ^ end
        self._guard.heard(inside=True)
        self._state = CHECK
        self._judge(check)
        self._guard.heard(inside=self._state in INSIDE)

    def _store(self, run: bytes) -> None:
        self._count += len(run)
        if self._count <= self._most:
            self._data += run
        elif self._cut:
            self._refuse(self._why or Refusal.LENGTH)
        else:
            self._blame(Refusal.LENGTH)

    def _broken_pair(self, byte: int) -> None:
        """A DLE followed by neither DLE nor the end."""
        self._state = DATA
        match self._profile.broken_pair:
            case BrokenPair.NAK_AT_END:
                self._blame(Refusal.ORDER)
            case BrokenPair.NAK_AT_ONCE:
                self._refuse(self._why or Refusal.ORDER)
            case _:  # DROP_DLE
                self._check ^= DLE ^ byte
                self._store(bytes((byte,)))

    def _blame(self, why: Refusal) -> None:
        self._why = self._why or why

    def damaged(self, kind: Damage, now: Ns) -> None:
        self._guard.damaged()
        if kind is Damage.BREAK:
            self._break(now)
        elif self._state is IDLE:
            self._stray(now)
        elif self._state is DEAF:
            self._strays += 1
            self.due = now + self._profile.char_delay
        elif self._state is not NO_BUFFER:
            self._blame(Refusal.DAMAGED)
            self._guard.untouched = False
            self.due = now + self._profile.char_delay
            if self._state is CHECK:
                self._judge(self._check)  # the damaged character was the check
            else:
                self._state = DATA

    # ---- the ends of a block
    def _judge(self, check: int) -> None:
        self._guard.ended()
        why = self._why or (None if check == self._check else Refusal.CHECK)
        if why is None:
            self._deliver()
        else:
            self._refuse(why)

    def _deliver(self) -> None:
        data = bytes(self._data)
        self._box.say(DLE)
        self._box.report(BlockReceived(data))
        self._buffer.store(data)
        self.repeats.delivered()
        self._rest()

    def _refuse(self, why: Refusal) -> None:
        """NAK, once; the repeat is expected within the block wait time, which runs from when the NAK has left."""
        if self._guard.unsaid:
            del self._box.output[-1:]  # our DLE has not left: before a NAK it would read "block good"
        self._box.say(NAK)
        self._box.report(BlockRefused(why, self._count))
        self._guard.refused()
        self._rest()
        self.repeats.refused(why)

    def _break(self, now: Ns) -> None:
        """BREAK: no answer, and back to idle; from inside a block once the line is quiet (AX-228)."""
        inside = self._state in INSIDE or self._state is DEAF
        if self._state is not DEAF:
            self._box.report(BlockRefused(Refusal.BREAK, self._count) if self.busy else LineBreak())
        self._rest()
        if inside:
            self._state, self.due, self._guard.untouched = DEAF, now + self._profile.char_delay, False

    def _rest(self) -> None:
        self._state, self.due = IDLE, None
        self._guard.begins()
        self._why, self._data, self._count, self._check = None, bytearray(), 0, 0

    # ---- idle
    def _pass_over(self, byte: int) -> None:
        """A character without a place."""
        self._guard.pass_over(byte, refused=self._state is IDLE and self._profile.stray is Stray.NAK_AT_ONCE)

    def _grant(self, now: Ns) -> None:
        """The line has been quiet since the last stray character, which was STX: only a waiting partner is silent after one."""
        self._strays -= 1
        self._open(now)

    def _open(self, now: Ns) -> None:
        if self._strays and self._box.output[-1:] == NAK_BYTE:
            del self._box.output[-1:]  # it has not left; before our answer it would cost the partner an attempt
        self._guard.opening(now, behind_strays=self._strays > 0)
        self.settle()
        self.repeats.opened()
        if self._buffer.free:
            self._admit(now)
        elif self._buffer.wait:
            self._state, self.due = NO_BUFFER, self._buffer.asked(now)
        else:
            self._turn_away()

    def _admit(self, now: Ns) -> None:
        self._box.say(DLE)
        self._guard.answered()
        self._state = DATA
        self.due = now + self._profile.char_delay  # prolonged when the DLE has left

    def _forget(self) -> None:
        """Received in one burst with the STX, without a complete block: the block begins now, after our DLE."""
        self._state = DATA
        self._guard.begins()
        self._why, self._data, self._count, self._check = None, bytearray(), 0, 0

    def _wish_again(self, byte: int) -> None:
        """STX repeats the request, NAK withdraws it."""
        if byte == NAK:
            del self._box.output[-1:]
            self._guard.untouched = False
            self._rest()

    def _close_again(self, byte: int) -> None:
        """That STX was a character out of the rest of a block: nothing was opened, and nothing is until the line is quiet (AX-240)."""
        if self._guard.same_burst:
            del self._box.output[-1:]
        else:
            self._guard.misled = True
        self._strays += 1
        self._state, self._guard.untouched = DEAF, False
        self._pass_over(byte)

    def _turn_away(self) -> None:
        self._box.say(NAK)
        self._box.report(BlockRefused(Refusal.NO_BUFFER, 0))
        self._rest()

    def _stray(self, now: Ns) -> None:
        if self._profile.stray is Stray.NAK_AT_ONCE and self._box.output[-1:] != NAK_BYTE:
            self._box.say(NAK)  # once for a burst: each NAK costs a partner that waits for DLE one of its attempts
        self._strays += 1
        self.due = now + self._profile.char_delay
        self.disquiet(now)

    def disquiet(self, now: Ns) -> None:
        """A character without a place was received, here or by the sender."""
        self._guard.disquiet(now)

    def settle(self) -> None:
        """Something else begins: report the stray characters so far."""
        if self._strays:
            self._box.report(StrayCharacters(self._strays))
            self._strays, self.due = 0, None

    # ---- time
    def sent(self, now: Ns) -> None:
        guard = self._guard
        if guard.leaving:
            guard.left()
        if guard.untouched and self._state is DATA:
            self.due = now + self._profile.char_delay
        if self.repeats.awaited:
            self.repeats.left(now)

    def expire(self, now: Ns) -> None:
        """The earlier of the timers is over."""
        if self.due is None or self.due > now:
            self.repeats.fail()
            return
        match self._state:
            case State.IDLE if self._guard.waits:
                self._grant(now)
            case State.IDLE:
                self._quiet_again()
            case State.NO_BUFFER:
                self._look_for_room(now)
            case State.DEAF:
                self._rest()
                self._guard.torn = False
                if self._guard.waits:
                    self._grant(now)
                else:
                    self._quiet_again()
            case _:
                self._guard.torn = True
                self._refuse(self._why or Refusal.GAP)

    def _quiet_again(self) -> None:
        """The line has been quiet since the last stray character.  A partner that read a DLE of ours as consent waits for an answer to its
        block.
        """
        if self._guard.misled or (self._strays and self._profile.stray is Stray.NAK_AFTER_QUIET):
            self._box.say(NAK)
        self._guard.misled = False
        self.settle()

    # ---- the one-block buffer
    def set_free(self, free: bool, now: Ns) -> None:
        self._buffer.free = free
        if free and self._state is NO_BUFFER:
            look = self._buffer.next_look(now)
            if look is None:
                self._admit(now)
            else:
                self.due = look

    def _look_for_room(self, now: Ns) -> None:
        """A polling step, or the end of the wait for a buffer."""
        if self._buffer.free:
            self._admit(now)
        elif now < self._buffer.last:
            self.due = self._buffer.last
        else:
            self._turn_away()

    def take_block(self, now: Ns) -> bytes | None:
        block = self._buffer.take()
        if block is not None:
            self.set_free(True, now)
        return block

    def lost(self) -> None:
        """The port is lost.  A block already acknowledged stays in the buffer: the partner will not send it again."""
        self.settle()
        self._guard.lost()
        if self.busy:
            self._box.report(BlockRefused(Refusal.LOST, self._count))
        self._rest()
        self.repeats.forget()
