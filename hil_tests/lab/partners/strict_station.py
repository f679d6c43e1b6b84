"""A 3964R station by the table of the manuals, written by hand: it sends one block, answers what it receives, and knows no remainders.

It shares with protocols only the seven methods of a machine, so a virtual line moves its characters.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field
from enum import Enum, auto

from protocols.base.machine import Damage, Ns

STX, ETX, DLE, NAK = 0x02, 0x03, 0x10, 0x15
ATTEMPTS = 6


def framed(block: bytes) -> bytes:
    wire, check = block.replace(b"\x10", b"\x10\x10") + b"\x10\x03", 0
    for byte in wire:
        check ^= byte
    return wire + bytes((check,))


class State(Enum):
    IDLE, PAUSE, CONNECT, SENDING, ANSWER, RECEIVE = auto(), auto(), auto(), auto(), auto(), auto()


@dataclass
class StrictStation:
    """One station; `done_at`: when the partner acknowledged its block."""

    qvz: Ns
    zvz: Ns
    high: bool  # priority
    repeats_on_any: bool  # any other character than DLE is a refusal; else only NAK is
    pause: Ns = 0  # before a repeat
    naks_strays: bool = False
    state: State = State.IDLE
    due: Ns | None = None
    out: bytearray = field(default_factory=bytearray)
    block: bytes = b""  # to send; empty: none
    done_at: Ns | None = None
    _connects: int = 0
    _blocks: int = 0
    _heard: bytearray = field(default_factory=bytearray)

    def want(self, block: bytes) -> None:
        self.block = block
        if self.state is State.IDLE:
            self._begin()

    # ---- the machine
    def receive(self, data: bytes, now: Ns) -> Sequence[None]:
        for byte in data:
            self._hear(byte, now)
        return ()

    def damaged(self, kind: Damage, now: Ns) -> Sequence[None]:
        return ()

    def deadline(self) -> Ns | None:
        return self.due

    def take_output(self) -> bytes:
        said, self.out = bytes(self.out), bytearray()
        return said

    def lost(self, now: Ns) -> Sequence[None]:
        return ()

    def sent(self, now: Ns) -> Sequence[None]:
        if self.state is State.CONNECT and self.due is None:
            self.due = now + self.qvz
        elif self.state is State.SENDING:
            self.state, self.due = State.ANSWER, now + self.qvz
        elif self.state is State.RECEIVE and self.due is None:
            self.due = now + self.zvz
        return ()

    def wake(self, now: Ns) -> Sequence[None]:
        match self.state:
            case State.CONNECT:
                self._again(now, block=False)
            case State.ANSWER:
                self._again(now, block=True)
            case State.PAUSE:
                self._begin()
            case _:
                self._end_of_block(NAK)
        return ()

    # ---- the table
    def _hear(self, byte: int, now: Ns) -> None:
        match self.state:
            case State.CONNECT if byte == DLE:
                self.out += framed(self.block)
                self.state, self.due = State.SENDING, None
            case State.CONNECT if byte == STX:
                if not self.high:
                    self._listen()
            case State.CONNECT if byte == NAK or self.repeats_on_any:
                self._again(now, block=False)
            case State.ANSWER if byte == DLE:
                self.block, self.done_at = b"", now
                self._rest()
            case State.ANSWER if byte == NAK or self.repeats_on_any:
                self._again(now, block=True)
            case State.RECEIVE:
                self._collect(byte, now)
            case State.IDLE | State.PAUSE if byte == STX:
                self._listen()
            case State.IDLE if byte != NAK and self.naks_strays:
                self.out.append(NAK)
            case _:
                pass

    def _begin(self) -> None:
        self.out.append(STX)
        self.state, self.due = State.CONNECT, None

    def _again(self, now: Ns, *, block: bool) -> None:
        self._connects, self._blocks = (0, self._blocks + 1) if block else (self._connects + 1, self._blocks)
        if max(self._connects, self._blocks) == ATTEMPTS:
            self.out.append(NAK)
            self.block = b""
            self._rest()
        elif self.pause:
            self.state, self.due = State.PAUSE, now + self.pause
        else:
            self._begin()

    def _listen(self) -> None:
        self.out.append(DLE)
        self.state, self.due, self._heard = State.RECEIVE, None, bytearray()

    def _collect(self, byte: int, now: Ns) -> None:
        self._heard.append(byte)
        self.due = now + self.zvz
        if self._heard[:-1].replace(b"\x10\x10", b"").endswith(b"\x10\x03"):
            check = 0
            for one in self._heard:
                check ^= one
            self._end_of_block(NAK if check else DLE)

    def _end_of_block(self, answer: int) -> None:
        self.out.append(answer)
        self._rest()

    def _rest(self) -> None:
        self.state, self.due = State.IDLE, None
        if self.block:
            self._begin()
