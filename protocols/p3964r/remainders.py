"""Guard of the receiver against remainders of blocks: which STX starts a block, and which belongs to an old one.

A block that was torn (a gap, a BREAK) or refused at once may continue after our answer, and 02h is as frequent in it as any other
character. A remainder differs in two ways: it does not wait for our DLE, and it comes without a pause.  Source: AX-228, AX-240, AX-654.

| question | yes, when |
|---|---|
| is this STX a part of the block before? (`behind_an_end`) | it followed the end of that block without a pause |
| was nothing opened? (`not_opened`) | the line was restless or a block torn, and this character did not wait for our DLE |
| is this the same request again? (`wish_again`) | it came in one burst with the STX; after stray characters also before our DLE has left |
| does the block begin only now? (`outrun`) | a burst came with the STX without a complete block, and our DLE has left since |
| does a partner wait? (`waits`) | the last stray character was STX, not the check of a block, and silence followed |
"""

from protocols.base.machine import Ns
from protocols.p3964r.characters import DLE, ETB, ETX, NAK, STX
from protocols.p3964r.events import Outbox

BLOCK_ENDS = (bytes((DLE, ETX)), bytes((DLE, ETB)))


class Remainders:
    """The receiver queries it and reports events to it; it sends nothing itself."""

    def __init__(self, box: Outbox, char_delay: Ns) -> None:
        self._box, self._char_delay = box, char_delay
        self.untouched = False  # nothing received since our DLE
        self.torn = False  # a block was refused before its end: its remainder may still come
        self._restless, self.heard_at = False, 0  # the last character was stray or refused; and its time
        self.doubted = False  # the current opening came on a doubtful line
        self._behind_strays = False  # that line had characters without a place, and no refused block
        self.leaving = False  # our DLE to it has not left
        self.early = False  # this part of the block came in one burst with the STX
        self.opened_in, self.ended_in = -1, -1  # turns of the box: our answer to STX, to the end of a block
        self.misled = False  # our DLE was sent to an STX that was then not accepted as a request
        self.waits = False  # the last stray character was STX: a partner that waits for DLE, if nothing follows
        self._passed = b""  # the last two of them

    # ---- the five questions
    @property
    def behind_an_end(self) -> bool:
        """This character followed the end of a block without a pause: it belongs to that block."""
        return self._box.turn == self.ended_in

    @property
    def same_burst(self) -> bool:
        """This character is in one burst with the STX: our DLE has not left."""
        return self._box.turn == self.opened_in

    @property
    def outrun(self) -> bool:
        """A burst with the STX had no complete block: the block begins now, after our DLE."""
        return self.early and self._box.turn != self.opened_in

    def not_opened(self, byte: int) -> bool:
        """This first character after a doubtful opening did not wait for our DLE: that STX belonged to a remainder."""
        same = self.same_burst
        return self.doubted and (same or (self.torn and self.leaving)) and not (byte == STX and same)

    def wish_again(self, byte: int) -> bool:
        """Whether this STX repeats the request, or this NAK withdraws it.  Our NAK to stray characters may have crossed with the STX."""
        if self.same_burst:
            return byte in (STX, NAK)
        return byte == STX and self._behind_strays and self.doubted and self.leaving

    @property
    def unsaid(self) -> bool:
        """Our DLE to the present block has not left, and only that burst of it was received."""
        return self.early and self._box.turn == self.opened_in

    # ---- events
    def opening(self, now: Ns, *, behind_strays: bool) -> None:
        """STX, to be answered."""
        self._behind_strays = behind_strays
        self.waits, self.misled, self._passed = False, False, b""
        self.doubted = self.torn or (self._restless and now - self.heard_at < self._char_delay)
        self._restless = False

    def answered(self) -> None:
        """DLE is sent to it."""
        self.opened_in, self.leaving, self.untouched = self._box.turn, True, True

    def left(self) -> None:
        """Our output has left the line."""
        self.leaving = False

    def heard(self, *, inside: bool) -> None:
        """A character; `inside`: of a block."""
        self.untouched = False
        self.early = inside and self._box.turn == self.opened_in

    def begins(self) -> None:
        """The block restarts, or there is none."""
        self.early = False

    def ended(self) -> None:
        """A block has been received to its end."""
        self.ended_in, self.torn = self._box.turn, False

    def refused(self) -> None:
        """A block was refused: its remainder would be received as a block of its own."""
        self._restless = True

    def disquiet(self, now: Ns) -> None:
        """A character without a place was received, here or by the sender."""
        self._restless, self.heard_at = True, now

    def pass_over(self, byte: int, *, refused: bool) -> None:
        """After DLE ETX a 02h is the check of a block whose sender also waits for DLE, but as the acknowledgement of the block."""
        self.waits = byte == STX and self._passed not in BLOCK_ENDS and not refused
        self._passed = (self._passed + bytes((byte,)))[-2:]

    def damaged(self) -> None:
        """No character in line order: no wish."""
        self.waits, self._passed = False, b""

    def lost(self) -> None:
        """The port is lost."""
        self.torn = self._restless = self.waits = self.misled = False
        self.opened_in = self.ended_in = -1
