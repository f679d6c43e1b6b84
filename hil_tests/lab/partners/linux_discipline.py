"""A 3964R station that does what the Linux line discipline did, and notes what its partner does against the procedure.

Written from its description, character by character; it shares nothing with protocols but the shape of a machine.  It asks up to six times
for a block (STX, answer within 550 ms), waits 220 ms of quiet before it asks again, takes up to 4000 characters and the character after a
lone DLE, refuses a block after 220 ms of silence, and gives way to a conflict: at once without priority, in any repeat with it.
"""

from collections import deque
from enum import Enum, auto

from protocols.base.machine import Damage, Ns, ms
from protocols.p3964r.events import Event

STX, ETX, DLE, NAK = 0x02, 0x03, 0x10, 0x15
ANSWER, QUIET = ms(550), ms(220)
ASKS, MOST = 6, 4000


class At(Enum):
    """What it waits for."""

    IDLE = auto()
    ANSWER = auto()  # to its STX
    VERDICT = auto()  # on its block
    PAUSE = auto()  # before it asks again
    BLOCK = auto()
    CHECK = auto()


class LinuxDiscipline:
    """heard: blocks it acknowledged; given: those its partner did; failed: those given up; breaches: of the partner, in words."""

    def __init__(self, *, priority: bool) -> None:
        self.heard: list[bytes] = []
        self.given: list[bytes] = []
        self.failed: list[bytes] = []
        self.breaches: list[str] = []
        self._priority, self._jobs, self._at = priority, deque[bytes](), At.IDLE
        self._asked, self._out, self._due = 0, b"", -1
        self._block, self._check, self._doubled = bytearray(), 0, False

    def give(self, block: bytes, now: Ns) -> None:
        """A block to send."""
        self._jobs.append(block)
        self._next(now)

    # ---- machine
    def receive(self, data: bytes, now: Ns) -> list[Event]:
        for character in data:
            self._hear(character, now)
        return []

    def damaged(self, kind: Damage, now: Ns) -> list[Event]:
        return self.receive(b"\xff", now)

    def sent(self, now: Ns) -> list[Event]:
        if self._at in (At.ANSWER, At.VERDICT):
            self._due = now + ANSWER
        return []

    def wake(self, now: Ns) -> list[Event]:
        if 0 <= self._due <= now:
            at, self._due = self._at, -1
            if at is At.PAUSE:
                self._ask(now)
            elif at in (At.ANSWER, At.VERDICT):
                self._say(NAK)
                self._again(now)
            elif at in (At.BLOCK, At.CHECK):
                self._say(NAK)
                self._rest(now)
        return []

    def deadline(self) -> Ns | None:
        return self._due if self._due >= 0 else None

    def take_output(self) -> bytes:
        out, self._out = self._out, b""
        return out

    def lost(self, now: Ns) -> list[Event]:
        return []

    # ---- the procedure
    def _hear(self, character: int, now: Ns) -> None:
        match self._at:
            case At.BLOCK:
                self._take(character, now)
            case At.CHECK:
                self._judge(character, now)
            case At.IDLE | At.PAUSE:
                if character == STX:
                    self._listen(now)
                elif character != NAK:  # which its partner may say to what it did not ask for
                    self.breaches.append(f"{character:02X}h at rest")
            case At.ANSWER:
                if character == DLE:
                    self._write(now)
                elif character == STX:
                    if not self._priority or self._asked > 1:
                        self._listen(now)
                else:
                    self._again(now)
            case At.VERDICT:
                if character == DLE:
                    self.given.append(self._jobs.popleft())
                    self._asked = 0
                    self._rest(now)
                else:
                    if character != NAK:
                        self.breaches.append(f"{character:02X}h as the answer to a block")
                    self._again(now)

    def _take(self, character: int, now: Ns) -> None:
        self._check ^= character
        self._due = now + QUIET
        if self._doubled:
            self._doubled = False
            if character == ETX:
                self._at = At.CHECK
                return
            if character != DLE:
                self.breaches.append(f"DLE {character:02X}h within a block")
        elif character == DLE:
            self._doubled = True
            return
        self._block.append(character)

    def _judge(self, character: int, now: Ns) -> None:
        good = character == self._check and len(self._block) <= MOST
        if len(self._block) > MOST:
            self.breaches.append(f"a block of {len(self._block)} characters")
        if good:
            self.heard.append(bytes(self._block))
        self._say(DLE if good else NAK)
        self._rest(now)

    def _listen(self, now: Ns) -> None:
        self._block.clear()
        self._check, self._doubled, self._at, self._due = 0, False, At.BLOCK, now + QUIET
        self._say(DLE)

    def _rest(self, now: Ns) -> None:
        self._at, self._due = At.IDLE, -1
        self._next(now)

    def _next(self, now: Ns) -> None:
        if self._at is At.IDLE and self._jobs:
            self._ask(now)

    def _ask(self, now: Ns) -> None:
        self._asked += 1
        self._at, self._due = At.ANSWER, now + ANSWER
        self._say(STX)

    def _write(self, now: Ns) -> None:
        wire = self._jobs[0].replace(bytes((DLE,)), bytes((DLE, DLE))) + bytes((DLE, ETX))
        check = 0
        for character in wire:
            check ^= character
        self._say(*wire, check)
        self._at, self._due = At.VERDICT, now + ANSWER + len(wire) * ms(2)

    def _again(self, now: Ns) -> None:
        if self._asked >= ASKS:
            self.failed.append(self._jobs.popleft())
            self._asked = 0
            self._rest(now)
        else:
            self._at, self._due = At.PAUSE, now + QUIET

    def _say(self, *characters: int) -> None:
        self._out += bytes(characters)
