"""Two RK512 stations of any dialects over a faulted line, both active and passive; every telegram and job is judged.

Payloads are zero-rich, random and all-10h in equal parts; jobs are SEND and FETCH of 2 to 300 bytes from both sides.
"""

from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass, field
from random import Random

from gateway.pure.computerlink import ComputerLink
from hil_tests.soak.faulted_line import FaultedLine
from hil_tests.soak.judge import FIFO, could_be_taken, payload_of
from protocols.base.machine import Ns, ms
from protocols.p3964r.events import BlockReceived, BlockSent, Event
from protocols.p3964r.profiles import PROFILES, Priority, Profile
from protocols.rk512.active import Denied, Done, Failed
from protocols.rk512.dialects import dialect_of
from protocols.rk512.header import ErrorNumber

CHAR: Ns = 11_000_000_000 // 9600
SIZES = (2, 4, 8, 20, 40, 80, 128, 130, 300)
WEIGHTS = (8, 8, 8, 6, 4, 2, 2, 1, 1)
SHARE = 0.16  # of the blocks; with what hits control characters well above a tenth of the telegrams
WORDS = 400  # of DB 10, written by the partner, and DB 11, read by it: never changed


@dataclass
class Tally:
    """What a soak counted; `wrong` and `lost` must stay empty."""

    telegrams: int = 0
    faulted: int = 0
    jobs: int = 0
    reported: int = 0
    faults: Counter[str] = field(default_factory=Counter)
    link_missed: int = 0  # delivered wrong, and nothing at the link could show it
    link_ack: int = 0  # an acknowledgement heard that was not said, or said for something else
    link_random: float = 0.0  # theory: spoiled blocks x 1/256
    rk512_missed: int = 0  # jobs with wrong data that RK512's lengths and sequence cannot show
    repeats: int = 0  # blocks delivered twice (the acknowledgement got lost)
    wrong: list[str] = field(default_factory=list)
    lost: list[str] = field(default_factory=list)

    def add(self, other: "Tally") -> None:
        for name, value in vars(other).items():
            if isinstance(value, Counter):
                self.faults.update(value)
            else:
                setattr(self, name, getattr(self, name) + value)


def payload(kind: int, size: int, chance: Random) -> bytes:
    """0 zero-rich, 1 random, 2 all 10h."""
    if kind == 0:
        return bytes(chance.randrange(256) if chance.random() < 0.25 else 0 for _ in range(size))
    return chance.randbytes(size) if kind == 1 else b"\x10" * size


class Store:
    """DB 10 takes what comes, DB 11 holds its three kinds of payload for good."""

    def __init__(self, chance: Random) -> None:
        self.taken = bytearray(2 * WORDS)
        third = 2 * WORDS // 3 // 2 * 2
        self.given = payload(0, third, chance) + payload(1, third, chance) + payload(2, 2 * WORDS - 2 * third, chance)

    def read(self, db: int, word: int, words: int) -> bytes | ErrorNumber:
        data = bytes(self.taken) if db == 10 else self.given if db == 11 else b""
        return data[2 * word : 2 * (word + words)] if 2 * (word + words) <= len(data) else ErrorNumber.BLOCK

    def write(self, db: int, word: int, data: bytes) -> ErrorNumber | None:
        if db != 10 or 2 * word + len(data) > len(self.taken):
            return ErrorNumber.BLOCK
        self.taken[2 * word : 2 * word + len(data)] = data
        return None


@dataclass
class Side:
    """One station and what the judge remembers of it."""

    machine: ComputerLink
    store: Store
    delivered: list[bytes] = field(default_factory=list)  # to this side, since the job began
    result: object | None = None
    acknowledged: int = 0


class Pair:
    """One dialect left, one right."""

    def __init__(self, left: Profile, right: Profile, seed: int, share: float = SHARE) -> None:
        self.tally, self.chance = Tally(), Random(seed)
        dialect = dialect_of(left.name)
        self.name = f"{left.name} / {right.name} seed {seed}"
        self.dialect = dialect
        self.sides: list[Side] = []
        for number, (profile, priority) in enumerate(((left, Priority.HIGH), (right, Priority.LOW))):
            store = Store(self.chance)
            machine = ComputerLink(profile, priority, store, dialect, tap=self._tap(number))
            self.sides.append(Side(machine, store))
        self.line = FaultedLine(self.sides[0].machine, self.sides[1].machine, self._event, seed, share, CHAR)
        self._explained, self._missed = 0, False
        self.line.kick(0)
        self.line.kick(1)

    # ---- what happens
    def _tap(self, side: int) -> Callable[[Event, Ns], None]:
        return lambda event, now: self._link(side, event)

    def _link(self, side: int, event: object) -> None:
        me, other = self.sides[side], self.sides[1 - side]
        if isinstance(event, BlockReceived):
            me.delivered.append(event.data)
            records = self.line.records[1 - side], self.line.records[side]
            said = [payload_of(each.data) for each in records[0].said[-12:] if len(each.data) > 3]
            known = event.data in said
            if not could_be_taken(*records, event.data, me.machine.link.profile.char_delay):
                self.tally.wrong.append(f"{self.name}: delivered {event.data.hex(' ')}, no faultless block was heard")
            elif not known:
                self.tally.link_missed += 1
                self._explained += 1
                self._missed = True
            self.tally.repeats += me.delivered[-2:-1] == [event.data]
        elif isinstance(event, BlockSent):
            blocks = [each for each in self.line.records[side].said[-12:] if len(each.data) > 3]
            sent = payload_of(blocks[-1].data) if blocks else None
            if sent not in other.delivered[-4:]:
                self._explained += 1
                self._judge_acknowledgement(side)

    def _judge_acknowledgement(self, side: int) -> None:
        """Acknowledged but not delivered: no fault of ours if a wrong block was, or what was heard as DLE was spoiled or data."""
        back = self.line.records[1 - side]
        spoiled = any(each.fault for each in back.said[-12:])
        data = sum(moment == back.heard[-1][0] for moment, _ in back.heard[-FIFO:]) > 3  # not a control character: a block out of its turn
        mine = self.line.records[side]
        block = next(each.data for each in reversed(mine.said) if len(each.data) > 3)
        answers = [each for each in back.said if len(each.data) <= 3 and 0x10 in each.data]
        before = bool(answers) and answers[-1].heard_at <= len(mine.heard) - len(block) // 2  # said before the block was heard
        stale = before or (bool(answers) and answers[-1].data[:2] == b"\x02\x10")  # or giving way to a STX it heard
        if self._missed:
            return
        if spoiled or data or stale:
            self.tally.link_ack += 1
        else:
            self.tally.lost.append(f"{self.name}: a block acknowledged and not delivered")

    def _event(self, side: int, event: object, now: Ns) -> None:
        if isinstance(event, Done | Denied | Failed):
            self.sides[side].result = event

    # ---- jobs
    def run(self, telegrams: int) -> Tally:
        """At least so many telegrams; the last job is finished."""
        while self.tally.telegrams < telegrams:
            self._round()
        return self.tally

    def _round(self) -> None:
        """A job of each side at the same time or one after the other."""
        self._explained, self._missed = 0, False
        for record in self.line.records:
            record.said.clear()
            record.heard.clear()
        sides = [0, 1] if self.chance.random() < 0.3 else [self.chance.randrange(2)]
        wanted = {side: self._give(side) for side in sides}
        for side in sides:
            self.sides[side].machine.start(self.line.now)
            self.line.kick(side)
        for _ in range(100_000):
            if all(self.sides[side].result is not None for side in sides):
                break
            self.line.step()
        self.line.run(self.line.now + ms(40_000))  # repeats of a last reaction
        for side in sides:
            self._judge(side, *wanted[side])
        self._count()

    def _give(self, side: int) -> tuple[int, bytes | None]:
        """Word and data of a SEND, or word and None with the words of a FETCH behind."""
        me, chance = self.sides[side], self.chance
        me.result = None
        for each in self.sides:
            each.delivered.clear()
        size = chance.choices(SIZES, WEIGHTS)[0]
        size = size if size <= self.dialect.served_bytes else 40
        if not self.dialect.reaction or chance.random() < 0.5:
            data = payload(chance.randrange(3), size, chance)
            word = chance.randrange(min(self.dialect.most_word, 255 - 150))
            self.sides[1 - side].store.taken[:] = bytes(~byte & 0xFF for byte in (data * (2 * WORDS // size + 1))[: 2 * WORDS])
            me.machine.active.send(word, data, 10)
            return word, data
        kind, third = chance.randrange(3), WORDS // 3
        word = min(self.dialect.most_word, 255, kind * third + chance.randrange(third // 2))
        me.machine.active.fetch(word, size // 2, 11)
        return word, bytes(size)[:0] + self.sides[1 - side].store.given[2 * word : 2 * word + size]

    def _judge(self, side: int, word: int, data: bytes | None) -> None:
        me, other = self.sides[side], self.sides[1 - side]
        self.tally.jobs += 1
        assert data is not None
        if not isinstance(me.result, Done):
            self.tally.reported += isinstance(me.result, Denied | Failed)
            if me.result is None:
                self.tally.lost.append(f"{self.name}: a job without a result")
            return
        right = me.result.data == data if me.result.data else bytes(other.store.taken[2 * word : 2 * word + len(data)]) == data
        if right:
            return
        if self._explained or self._twice():
            self.tally.rk512_missed += 1
        else:
            self.tally.wrong.append(f"{self.name}: {me.result} instead of {data.hex(' ')}")

    def _twice(self) -> bool:
        """A block was delivered twice: whose telegrams they are cannot be told any more."""
        return any(len(each.delivered) != len(set(each.delivered)) for each in self.sides)

    def _count(self) -> None:
        for record in self.line.records:
            blocks = [each for each in record.said if len(each.data) > 3]
            self.tally.telegrams += len(blocks)
            spoiled = hit = 0
            for each in record.said:
                hit = hit or bool(each.fault)
                if len(each.data) > 3:
                    spoiled += hit
                    self.tally.link_random += bool(each.fault) / 256
                    hit = 0
            self.tally.faulted += spoiled
        self.tally.faults.update(self.line.faults)
        self.line.faults.clear()


def soak(telegrams: int, seed: int = 1, progress: bool = False) -> Tally:
    """Over all ordered pairs of dialects, so many telegrams in equal parts."""
    names = sorted(PROFILES)
    pairs = [(PROFILES[left], PROFILES[right]) for left in names for right in names]
    total = Tally()
    for number, (left, right) in enumerate(pairs):
        total.add(Pair(left, right, seed * 1000 + number).run(max(1, telegrams // len(pairs))))
        if progress and number % 17 == 16:
            print(f"{total.telegrams} telegrams, {total.faulted} faulted, wrong {len(total.wrong)}, lost {len(total.lost)}", flush=True)
    return total


__all__ = ["Pair", "Tally", "soak"]
