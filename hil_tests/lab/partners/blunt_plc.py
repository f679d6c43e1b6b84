"""A PLC with RK512 on 3964R written by hand, which breaks its jobs off: it leaves reactions untaken, falls silent in a block, starts again.

It shares nothing with protocols: one generator is the station.  `yield` asks for the next character, at most so long (ns), and gives it
back or SILENCE.  It takes whatever block comes after its command for the reaction to it, as a CP does: RK512 has no number to tell.
"""

from collections.abc import Generator, Sequence
from dataclasses import dataclass, field

from protocols.base.machine import Damage, Ns

SILENCE = -1
MILLISECOND = 1_000_000
QVZ, ZVZ = 550 * MILLISECOND, 220 * MILLISECOND
Script = Generator[Ns, int, bytes | None]


@dataclass(frozen=True)
class Job:
    """One command; `ends`: take | leave (the reaction) | torn (in the command) | unacknowledged (the reaction was received, no DLE)."""

    command: bytes
    ends: str = "take"
    pause: Ns = 0  # before the next job: so long it hears nothing


@dataclass
class BluntPlc:
    """`answers`: number of the job -> the reaction it took; `unasked`: blocks it had to take while it waited to send."""

    jobs: Sequence[Job]
    priority: bool
    answers: dict[int, bytes | None] = field(default_factory=dict)
    unasked: list[bytes] = field(default_factory=list)
    sent_ok: set[int] = field(default_factory=set)
    over: bool = False

    def __post_init__(self) -> None:
        self._say, self._now, self._on_its_way = b"", 0, False
        self._until: Ns | None = None
        self._station = self._forever()
        self._limit: Ns = next(self._station)

    # ---- the station
    def _forever(self) -> Generator[Ns, int, None]:
        for number, job in enumerate(self.jobs):
            connected = yield from self._send(number, job)
            if connected and job.ends in ("take", "unacknowledged"):
                reaction = yield from self._take_reaction(job.ends == "take")
                if job.ends == "take":
                    self.answers[number] = reaction
            yield from self._deaf(job.pause)
        self.over = True
        while True:
            if (yield 3_600_000 * MILLISECOND) == 0x02:
                yield from self._receive(True)

    def _deaf(self, how_long: Ns) -> Generator[Ns, int, None]:
        end = self._now + how_long
        while self._now < end:
            yield end - self._now

    def _send(self, number: int, job: Job) -> Generator[Ns, int, bool]:
        tries = 0
        while tries < 60:  # patient: the other end may wait out its own attempts
            tries += 1
            self._say += b"\x02"
            heard = yield QVZ
            while heard == 0x02 and self.priority:
                heard = yield QVZ
            if heard == 0x02:
                block = yield from self._receive(True)
                self.unasked += [block] if block is not None else []
                continue
            if heard != 0x10:
                continue
            wire = job.command.replace(b"\x10", b"\x10\x10") + b"\x10\x03"
            check = 0
            for byte in wire:
                check ^= byte
            if job.ends == "torn":
                self._say += wire[: len(wire) // 2]
                return False
            self._say += wire + bytes([check])
            if (yield QVZ) == 0x10:
                self.sent_ok.add(number)
                return True
        return False

    def _take_reaction(self, acknowledge: bool) -> Script:
        end = self._now + 10_000 * MILLISECOND
        while self._now < end:
            if (yield end - self._now) == 0x02:
                block = yield from self._receive(acknowledge)
                if block is not None:
                    return block
        return None

    def _receive(self, acknowledge: bool) -> Script:
        self._say += b"\x10"
        data, check = b"", 0
        while True:
            character = yield ZVZ
            if character == 0x10:
                check ^= 0x10
                character = yield ZVZ
                if character == 0x03:
                    last = yield ZVZ
                    if not acknowledge:
                        return data
                    self._say += b"\x10" if last == check ^ 0x03 else b"\x15"
                    return data if last == check ^ 0x03 else None
            if character == SILENCE:
                self._say += b"\x15"
                return None
            check ^= character
            data += bytes([character])

    # ---- the machine around it
    def _feed(self, character: int, now: Ns) -> None:
        self._now = now
        self._limit = self._station.send(character)
        self._until = None if self._say else now + self._limit

    def receive(self, data: bytes, now: Ns) -> list[object]:
        for byte in data:
            self._feed(byte, now)
        return []

    def damaged(self, kind: Damage, now: Ns) -> list[object]:
        return []

    def sent(self, now: Ns) -> list[object]:
        self._on_its_way, self._until = False, now + self._limit
        return []

    def wake(self, now: Ns) -> list[object]:
        if self._until is not None and now >= self._until:
            self._feed(SILENCE, now)
        return []

    def deadline(self) -> Ns | None:
        return None if self._on_its_way else self._until

    def take_output(self) -> bytes:
        said, self._say = self._say, b""
        self._on_its_way = self._on_its_way or bool(said)
        return said

    def lost(self, now: Ns) -> list[object]:
        return []
