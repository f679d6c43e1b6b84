"""Receiving side of 3964R.  Source: rho 3 Releases part 1, section 7.1 (below: 7.1); refusals: AX-007, AX-008; rests of blocks: AX-240."""

from enum import Enum, auto

from protocols.base.machine import Damage, Ns
from protocols.p3964r.characters import DLE, DLE_BYTE, ETB, ETX, NAK, STX, check_of
from protocols.p3964r.events import (
    BlockReceived,
    BlockRefused,
    LineBreak,
    Outbox,
    ReceptionFailed,
    Refusal,
    StrayCharacters,
)
from protocols.p3964r.profiles import BrokenPair, Profile, Stray, TooLong


class State(Enum):
    """What the receiver expects next."""

    IDLE = auto()  # STX; a repeat may be expected, which changes only what is reported
    NO_BUFFER = auto()  # heard STX, has no room for the block; hopes to get some
    DATA = auto()  # inside the block
    ESCAPED = auto()  # one DLE seen; the next character says what it meant
    CHECK = auto()  # end seen; the block check comes next, whatever its value
    DEAF = auto()  # the rest of a broken or torn block comes in: nothing in it is a wish to send; a quiet line ends it (AX-228, AX-240)


IDLE, NO_BUFFER, DATA, ESCAPED, CHECK, DEAF = State  # asked at every character: State.DATA costs a search in its class
INSIDE = (DATA, ESCAPED, CHECK)
BLOCK_ENDS = (bytes((DLE, ETX)), bytes((DLE, ETB)))


class Receiver:
    """Takes blocks off the line and answers them; half of a Link, which passes it its characters."""

    def __init__(self, profile: Profile, box: Outbox, keep_one: bool) -> None:
        self._profile, self._box, self._keep_one = profile, box, keep_one
        self._most = profile.most_received
        self._cut = profile.too_long is TooLong.NAK_AT_ONCE
        self._state = IDLE
        self._due: Ns | None = None  # end of the gap, of the wait for a buffer, or of the quiet after stray characters
        self._repeat_due: Ns | None = None
        self._why: Refusal | None = None  # first fault of the running block; it is heard to its end all the same (AX-007)
        self._check, self._data, self._count = 0, bytearray(), 0
        self._untouched = False  # nothing heard since our DLE
        self._torn = False  # a block was refused without having come to its end: its rest may still come
        self._restless, self._heard_at = False, 0  # what was heard last had no place, or was refused; and when that was
        self._doubted = False  # the opening under way came on such a line
        self._leaving = False  # our DLE to it has not left
        self._early = False  # what was heard of the block came in one burst with the STX
        self._opened_in, self._ended_in = -1, -1  # turns of the box: our answer to STX, to the end of a block
        self._strays = 0
        self._wish = False  # the last of them was STX: a partner that waits for DLE, if nothing follows (AX-654)
        self._passed = b""  # the last two of them
        self._refusals, self._first_why = 0, Refusal.GAP
        self._awaits_repeat = False
        self._free = True
        self._asked_at: Ns = 0  # when STX found no buffer
        self._stored: bytes | None = None

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
        if self._early and self._box.turn != self._opened_in:
            self._forget()
        size = len(data)
        while at < size:
            byte = data[at]
            if self._untouched and self._other_than_begun(byte):
                at += 1
            elif self._state is DATA and byte != DLE:
                at = self._collect(data, at)
            else:
                self._step(byte, now)
                at += 1
            if self._state is IDLE:
                break
        self._heard_at = now
        if not self._untouched and self._state is not IDLE and self._state is not NO_BUFFER:
            self._due = now + self._profile.char_delay
        return at

    def _other_than_begun(self, byte: int) -> bool:
        """The first character after our DLE, where it is a wish again or shows that there was none.  True: it is taken."""
        if self._doubted and self._before_our_dle() and not (byte == STX and self._box.turn == self._opened_in):
            self._close_again(byte)
        elif byte in (STX, NAK) and self._box.turn == self._opened_in:
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
            if byte == STX and self._box.turn != self._ended_in:  # else in one breath with the end of a block: part of it
                self._open(now)
                return
            if byte != NAK:  # the partner gave up or started; never answered, so two stations cannot loop
                self._stray(now)
            self._pass_over(byte)
        elif state is DEAF:
            self._strays += 1
            self._pass_over(byte)
        # NO_BUFFER: still the same wish to send (AX-006)
        self._untouched = False
        self._early = self._box.turn == self._opened_in and self._state in INSIDE

    def _second_of_pair(self, byte: int) -> None:
        """What the DLE before it meant."""
        if byte == DLE:
            self._state = DATA
            self._store(DLE_BYTE)  # both enter the check, so they cancel
        elif byte in (ETX, ETB):
            self._check ^= DLE ^ byte
            self._state = CHECK
            if not self._profile.block_check:
                self._judge(self._check)
        else:
            self._broken_pair(byte)

    def _collect(self, data: bytes, at: int) -> int:
        """A run of plain characters up to the next DLE, taken at once; the same as one step for each."""
        end = data.find(DLE_BYTE, at)
        run = data[at:] if end < 0 else data[at:end]
        if self._cut:
            run = run[: self._most + 1 - self._count]  # the first one too many ends the block
        self._check ^= check_of(run)
        self._store(run)
        self._untouched = False
        self._early = self._box.turn == self._opened_in and self._state in INSIDE
        return at + len(run)

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
        self._wish, self._passed = False, b""
        if kind is Damage.BREAK:
            self._break(now)
        elif self._state is IDLE:
            self._stray(now)
        elif self._state is DEAF:
            self._strays += 1
            self._due = now + self._profile.char_delay
        elif self._state is not NO_BUFFER:
            self._blame(Refusal.DAMAGED)
            self._untouched = False
            self._due = now + self._profile.char_delay
            if self._state is CHECK:
                self._judge(self._check)  # the spoiled character was the check
            else:
                self._state = DATA

    # ---- the ends of a block
    def _judge(self, check: int) -> None:
        self._ended_in, self._torn = self._box.turn, False
        why = self._why or (None if check == self._check else Refusal.CHECK)
        if why is None:
            self._deliver()
        else:
            self._refuse(why)

    def _deliver(self) -> None:
        data = bytes(self._data)
        self._box.say(DLE)
        self._box.tell(BlockReceived(data))
        if self._keep_one:
            self._stored, self._free = data, False
        self._refusals = 0
        self._rest()

    def _refuse(self, why: Refusal) -> None:
        """NAK, once; the repeat is expected within the block wait time, which runs from when the NAK has left."""
        if self._early and self._box.turn == self._opened_in:
            del self._box.output[-1:]  # our DLE was not given out: before a NAK it would read "block good"
        self._box.say(NAK)
        self._box.tell(BlockRefused(why, self._count))
        self._restless = True
        if self._refusals == 0:
            self._first_why = why
        self._refusals += 1
        self._rest()
        self._awaits_repeat = True
        if self._refusals == self._profile.block_attempts:
            self._report_failure()

    def _report_failure(self) -> None:
        self._box.tell(ReceptionFailed(self._first_why, self._refusals))
        self._refusals, self._awaits_repeat, self._repeat_due = 0, False, None

    def _break(self, now: Ns) -> None:
        """BREAK: no answer, and back to idle; from inside a block once the line is quiet (AX-228)."""
        inside = self._state in INSIDE or self._state is DEAF
        if self._state is not DEAF:
            self._box.tell(BlockRefused(Refusal.BREAK, self._count) if self.busy else LineBreak())
        self._rest()
        if inside:
            self._state, self._due, self._untouched = DEAF, now + self._profile.char_delay, False

    def _rest(self) -> None:
        self._state, self._due, self._early = IDLE, None, False
        self._why, self._data, self._count, self._check = None, bytearray(), 0, 0

    # ---- idle
    def _pass_over(self, byte: int) -> None:
        """Behind DLE ETX a 02h is the check of a block whose sender waits for DLE as well, but to hear that it was taken."""
        refused = self._state is IDLE and self._profile.stray is Stray.NAK_AT_ONCE
        self._wish = byte == STX and self._passed not in BLOCK_ENDS and not refused
        self._passed = (self._passed + bytes((byte,)))[-2:]

    def _grant(self, now: Ns) -> None:
        """The line has been quiet since the last stray character, which was STX: nobody but a partner that waits is silent behind one."""
        self._strays -= 1
        self._open(now)

    def _open(self, now: Ns) -> None:
        self.settle()
        self._wish, self._passed = False, b""
        self._doubted = self._torn or (self._restless and now - self._heard_at < self._profile.char_delay)
        self._restless = False
        self._awaits_repeat, self._repeat_due = False, None
        if self._free:
            self._admit(now)
        elif self._profile.no_buffer_wait:
            self._state, self._asked_at = NO_BUFFER, now
            self._due = now + self._profile.no_buffer_wait
        else:
            self._turn_away()

    def _admit(self, now: Ns) -> None:
        self._box.say(DLE)
        self._opened_in, self._leaving = self._box.turn, True
        self._state, self._untouched = DATA, True
        self._due = now + self._profile.char_delay  # prolonged when the DLE has left

    def _before_our_dle(self) -> bool:
        """What comes now did not wait for the DLE: in one burst with the STX, or, after a torn block, before the DLE has left."""
        return self._box.turn == self._opened_in or (self._torn and self._leaving)

    def _forget(self) -> None:
        """In one burst with the STX and no whole block: the block begins now, behind our DLE."""
        self._state, self._early = DATA, False
        self._why, self._data, self._count, self._check = None, bytearray(), 0, 0

    def _wish_again(self, byte: int) -> None:
        """In one burst with the STX: STX is the same wish once more, NAK takes it back."""
        if byte == NAK:
            del self._box.output[-1:]
            self._untouched = False
            self._rest()

    def _close_again(self, byte: int) -> None:
        """That STX was a character out of the rest of a block: nothing was opened, and nothing is until the line is quiet (AX-240)."""
        if self._box.turn == self._opened_in:
            del self._box.output[-1:]
        self._strays += 1
        self._state, self._untouched = DEAF, False
        self._pass_over(byte)

    def _turn_away(self) -> None:
        self._box.say(NAK)
        self._box.tell(BlockRefused(Refusal.NO_BUFFER, 0))
        self._rest()

    def _stray(self, now: Ns) -> None:
        if self._profile.stray is Stray.NAK_AT_ONCE:
            self._box.say(NAK)
        self._strays += 1
        self._due = now + self._profile.char_delay
        self.disquiet(now)

    def disquiet(self, now: Ns) -> None:
        """A character without a place was heard, here or by the sender."""
        self._restless, self._heard_at = True, now

    def settle(self) -> None:
        """Something else begins: report the stray characters so far."""
        if self._strays:
            self._box.tell(StrayCharacters(self._strays))
            self._strays, self._due = 0, None

    # ---- time
    def deadline(self) -> Ns | None:
        if self._due is None or self._repeat_due is None:
            return self._due if self._repeat_due is None else self._repeat_due
        return min(self._due, self._repeat_due)

    def sent(self, now: Ns) -> None:
        self._leaving = False
        if self._untouched and self._state is DATA:
            self._due = now + self._profile.char_delay
        if self._awaits_repeat and self._repeat_due is None:
            self._repeat_due = now + self._profile.block_wait

    def expire(self, now: Ns) -> None:
        """The earlier of the timers is over."""
        if self._due is None or self._due > now:
            self._report_failure()
            return
        match self._state:
            case State.IDLE if self._wish:
                self._grant(now)
            case State.IDLE:
                self.settle()
                if self._profile.stray is Stray.NAK_AFTER_QUIET:
                    self._box.say(NAK)
            case State.NO_BUFFER:
                self._look_for_room(now)
            case State.DEAF:
                self._rest()
                self._torn = False
                if self._wish:
                    self._grant(now)
                else:
                    self.settle()
            case _:
                self._torn = True
                self._refuse(self._why or Refusal.GAP)

    # ---- the one-block buffer
    def set_free(self, free: bool, now: Ns) -> None:
        self._free = free
        if free and self._state is NO_BUFFER:
            poll, last = self._profile.no_buffer_poll, self._asked_at + self._profile.no_buffer_wait
            if poll == 0:
                self._admit(now)
            else:
                self._due = min(last, self._asked_at - (self._asked_at - now) // poll * poll)  # the next step, this moment included

    def _look_for_room(self, now: Ns) -> None:
        """A polling step, or the end of the wait for a buffer."""
        last = self._asked_at + self._profile.no_buffer_wait
        if self._free:
            self._admit(now)
        elif now < last:
            self._due = last
        else:
            self._turn_away()

    def take_block(self, now: Ns) -> bytes | None:
        block, self._stored = self._stored, None
        if block is not None:
            self.set_free(True, now)
        return block

    def lost(self) -> None:
        """The port is gone.  A block already acknowledged stays in the buffer: the partner will not send it again."""
        self.settle()
        self._torn = self._restless = self._wish = False
        self._opened_in = self._ended_in = -1
        if self.busy:
            self._box.tell(BlockRefused(Refusal.LOST, self._count))
        self._rest()
        self._refusals, self._awaits_repeat, self._repeat_due = 0, False, None
