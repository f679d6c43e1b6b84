"""Two RK512 stations of any dialects over a faulted line, both active and passive; every telegram and job is judged.

Payloads are zero-rich, random and all-10h in equal parts; jobs are SEND and FETCH of 1 to 300 bytes of every type from both sides, some
with a coordination flag.  Each station keeps to its own dialect, also where the other's is another one.
"""

from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace
from itertools import pairwise
from random import Random

from gateway.pure.lines.buep64 import BUEP64, buep64_dialect
from gateway.pure.lines.rk512_link import Rk512Link
from gateway.tools.progress import steps
from hil_tests.soak.faulted_line import FaultedLine
from hil_tests.soak.judge import payload_of, taken, why_acknowledged
from hil_tests.soak.store import Store, payload
from protocols.base.machine import Ns, ms
from protocols.buep64.form import Form
from protocols.p3964r.characters import Char
from protocols.p3964r.events import BlockReceived, BlockSent, Event, SendFailed
from protocols.p3964r.profiles import PROFILES, Priority, Profile
from protocols.rk512.active import Denied, Done, Failed
from protocols.rk512.dialects import Dialect, dialect_of
from protocols.rk512.header import ErrorNumber, Flag, Kind

CHAR: Ns = 11_000_000_000 // 9600
SIZES = (2, 4, 8, 20, 40, 80, 128, 130, 300)
WEIGHTS = (8, 8, 8, 6, 4, 2, 2, 1, 1)
SHARE = 0.16  # of the blocks; with what hits control characters well above a tenth of the telegrams
EARLY: Ns = ms(5)  # an acknowledgement may be heard so long before the port told that the block has left (AX-052)
OTHER_TYPES = (Kind.EXTENDED, Kind.INPUTS, Kind.OUTPUTS, Kind.FLAGS, Kind.TIMERS, Kind.COUNTERS)
PAYLOADS = ("zero-rich", "random", "all 10h")


@dataclass
class Tally:
    """What a soak counted; `wrong` and `lost` must stay empty."""

    telegrams: int = 0
    faulted: int = 0
    jobs: int = 0
    reported: int = 0
    faults: Counter[str] = field(default_factory=Counter)
    payloads: Counter[str] = field(default_factory=Counter)  # of the jobs
    roles: Counter[str] = field(default_factory=Counter)
    link_missed: int = 0  # delivered wrong, and nothing at the link could show it
    link_acknowledged: Counter[str] = field(default_factory=Counter)  # acknowledged, never delivered: what made the DLE
    link_random: float = 0.0  # theory: spoiled blocks x 1/256; 3964 without check: x 1
    rk512_missed: Counter[str] = field(default_factory=Counter)  # jobs with wrong data that RK512 cannot show: by which blocks
    repeats: int = 0  # blocks delivered twice (the acknowledgement got lost)
    examples: dict[str, str] = field(default_factory=dict)  # one of each class, in bytes
    wrong: list[str] = field(default_factory=list)
    lost: list[str] = field(default_factory=list)

    def add(self, other: "Tally") -> None:
        for name, value in vars(other).items():
            mine = getattr(self, name)
            if isinstance(value, dict):
                mine.update(value)  # counters add
            else:
                setattr(self, name, mine + value)


@dataclass
class Delivered:
    """A block that a side received: the unit sent that it came from (the last of several), and whether it equals what was sent."""

    number: int
    data: bytes
    right: bool
    reaction: bool  # as it was said


@dataclass
class Wanted:
    """A job of this round and what its result must be; `data` None: refused."""

    fetch: bool
    kind: Kind
    place: int
    data: bytes | None
    flag: Flag | None
    locked: bool
    sent: bytes = b""


@dataclass
class Side:
    """One station and what the judge remembers of it."""

    machine: Rk512Link
    store: Store
    dialect: Dialect
    profile: Profile
    delivered: list[Delivered] = field(default_factory=list)  # to this side in this round
    acknowledged: list[tuple[range, Ns]] = field(default_factory=list)  # its jobs of the link: attempts by their number, since when
    begun: int = 0  # number of the first thing said for the job of the link under way
    result: object | None = None


def station_dialect(profile: Profile) -> Dialect:
    """BUEP64 has a package of its own; all serve flags."""
    dialect = buep64_dialect(Form()) if profile.name.startswith(BUEP64) else dialect_of(profile.name.removesuffix("-3964"))
    return replace(dialect, coordination_flag="serve")


class Pair:
    """One dialect left, one right."""

    def __init__(self, left: Profile, right: Profile, seed: int, share: float = SHARE) -> None:
        self.tally, self.chance = Tally(), Random(seed)
        self.name = f"{left.name} / {right.name} seed {seed}"
        self.sides: list[Side] = []
        for number, (profile, priority) in enumerate(((left, Priority.HIGH), (right, Priority.LOW))):
            store, dialect = Store(self.chance), station_dialect(profile)
            machine = Rk512Link(profile, priority, store, dialect, areas=store, tap=self._tap(number))
            self.sides.append(Side(machine, store, dialect, profile))
        self.line = FaultedLine(self.sides[0].machine, self.sides[1].machine, self._event, seed, share, CHAR)
        self.line.kick(0)
        self.line.kick(1)
        self._settle()  # some say NAK at start

    # ---- what happens
    def _tap(self, side: int) -> Callable[[Event, Ns], None]:
        return lambda event, now: self._link(side, event)

    def _link(self, side: int, event: object) -> None:
        me, mine = self.sides[side], self.line.records[side]
        if isinstance(event, BlockReceived):
            self._judge_delivery(side, event.data)
        elif isinstance(event, BlockSent | SendFailed):
            attempts = range(me.begun, len(mine.said))
            me.begun = len(mine.said)
            if isinstance(event, BlockSent):
                last = next(number for number in reversed(attempts) if mine.said[number].is_block)
                me.acknowledged.append((attempts, mine.said[last].left - EARLY))

    def _judge_delivery(self, side: int, data: bytes) -> None:
        me, speaker = self.sides[side], self.line.records[1 - side]
        found = taken(speaker, self.line.records[side], data, me.profile.char_delay, me.profile.block_check)
        numbers = [number for number, _ in speaker.origins[found[0] : found[1]]] if found else [each[0] for each in speaker.origins[-1:]]
        number = numbers[-1] if numbers else -1
        right = number >= 0 and payload_of(speaker.said[number].data) == data
        said_data = (payload_of(speaker.said[number].data) or b"") if number >= 0 else b""
        me.delivered.append(Delivered(number, data, right, _is_reaction(said_data)))
        if right:
            self.tally.repeats += sum(each.data == data for each in me.delivered[-2:]) == 2
            return
        said = speaker.said[number].data.hex(" ") if number >= 0 else "nothing"
        if found is None:
            self.tally.wrong.append(f"{self.name}: delivered {data.hex(' ')}, no faultless block was heard; said {said}")
        else:
            self.tally.link_missed += 1

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
        for station, record in zip(self.sides, self.line.records, strict=True):
            record.clear()
            station.delivered.clear()
            station.acknowledged.clear()
            station.begun, station.result = 0, None
            if self.chance.random() < 0.5:
                station.machine.passive.flags.set.clear()  # its program has used what came
        sides = [0, 1] if self.chance.random() < 0.3 else [self.chance.randrange(2)]
        wanted = {side: self._give(side) for side in sides}
        for side in sides:
            self.sides[side].machine.start(self.line.now)
            self.line.kick(side)
        for _ in range(100_000):
            if all(self.sides[side].result is not None for side in sides):
                break
            self.line.step()
        self._settle()
        missing = [self._judge_acknowledgements(side) for side in (0, 1)]
        for side in sides:
            self._judge(side, wanted[side], missing[side])
        self._count()

    def _settle(self) -> None:
        """Repeats of a last reaction; then nobody has anything to send and nothing is under way."""
        self.line.run(self.line.now + ms(40_000))
        for _ in range(100):
            if not any(side.machine.link.pending for side in self.sides) and not any(record.coming for record in self.line.records):
                return
            self.line.run(self.line.now + ms(10_000))
        raise AssertionError(f"{self.name}: the line does not come to rest")

    def _give(self, side: int) -> Wanted:
        """A job for this side, and what must come of it by the dialects of both."""
        me, other, chance = self.sides[side], self.sides[1 - side], self.chance
        size = min(chance.choices(SIZES, WEIGHTS)[0], me.dialect.most_bytes)
        fetch = me.dialect.reaction and chance.random() < 0.5
        kind = Kind.BLOCK if chance.random() < 0.7 else chance.choice(OTHER_TYPES)
        if not fetch and kind not in me.dialect.send_kinds:
            kind = Kind.BLOCK
        flag = Flag(chance.randrange(255), chance.randrange(8), chance.randrange(5)) if chance.random() < 0.2 else None
        locked = flag is not None and other.machine.passive.flags.locks(flag)
        form = chance.randrange(3)
        place = chance.randrange(100)
        there = self._there(me.dialect, other.dialect, kind, place)
        size = size - chance.randrange(2) if kind.unit == 1 else size
        self.tally.payloads[PAYLOADS[form]] += 1
        self.tally.roles[f"{'FETCH' if fetch else 'SEND'} {chr(kind)}"] += 1
        if fetch:
            other.store.fill(kind, form, chance)
            me.machine.active.fetch(place, size // kind.unit, 11 if kind.in_blocks else 0, kind, flag)
            data = None if there is None else other.store.given_at(kind, there, size)
        else:
            data = payload(form, size, chance)
            other.store.spoil(data)
            me.machine.active.send(place, data, 10, kind, flag)
        return Wanted(fetch, kind, there or 0, data if there is not None else None, flag, locked, b"" if fetch else data or b"")

    @staticmethod
    def _there(mine: Dialect, theirs: Dialect, kind: Kind, place: int) -> int | None:
        """Where the other dialect finds what this one addresses; None: nowhere."""
        if not kind.in_blocks or mine.db_address_unit == theirs.db_address_unit:
            return place
        if mine.db_address_unit == "byte":
            return 2 * place
        return None if place % 2 else place // 2

    # ---- the verdicts
    def _judge_acknowledgements(self, side: int) -> list[int]:
        """Return the units for which this side has an acknowledgement and which the other never received in any attempt, by number."""
        other, mine, back = self.sides[1 - side], self.line.records[side], self.line.records[1 - side]
        missing = []
        for attempts, since in self.sides[side].acknowledged:
            taken_here = [each for each in other.delivered if each.number in attempts]
            if taken_here:
                continue  # as it was said, or wrong without a sign: counted there
            block = next(number for number in reversed(attempts) if mine.said[number].is_block)
            why, words = why_acknowledged(mine, back, block, since)
            missing.append(block)
            if why:
                self.tally.link_acknowledged[why] += 1
                self.tally.examples.setdefault(why, f"{self.name}: {words}")
            else:
                self.tally.lost.append(f"{self.name}: {mine.said[block].data[:16].hex(' ')} acknowledged and not delivered: {words}")
        return missing

    def _judge(self, side: int, wanted: Wanted, missing: list[int]) -> None:
        me = self.sides[side]
        self.tally.jobs += 1
        if not isinstance(me.result, Done):
            self.tally.reported += isinstance(me.result, Denied | Failed)
            if me.result is None:
                self.tally.lost.append(f"{self.name}: a job without a result")
            return
        if self._right(side, wanted, me.result):
            return
        why = self._explained(side, missing)
        if why:
            self.tally.rk512_missed[why] += 1
        else:
            self.tally.wrong.append(f"{self.name}: {me.result} for {wanted}")

    def _right(self, side: int, wanted: Wanted, result: Done) -> bool:
        """The data are what the other one has, or are where they belong; the flag let it through and is set now."""
        mine, other = self.sides[side].dialect, self.sides[1 - side]
        if not mine.reaction and self._refused_by(other.dialect, wanted):
            return any(each.right and each.data[10:].endswith(wanted.sent) for each in other.delivered)  # done when the link is: it has it
        if wanted.data is None or wanted.locked:
            return False
        if wanted.flag is not None and wanted.flag not in other.machine.passive.flags.set:
            return False
        if wanted.fetch:
            return result.data == wanted.data
        return other.store.taken_at(wanted.kind, wanted.place, len(wanted.data)) == wanted.data

    @staticmethod
    def _refused_by(theirs: Dialect, wanted: Wanted) -> bool:
        served = len(wanted.sent) <= theirs.served_bytes and wanted.kind in theirs.send_kinds
        return wanted.data is None or wanted.locked or not served

    def _explained(self, side: int, missing: list[int]) -> str:
        """Which blocks of this job's own went wrong without a sign; empty: none."""
        why = self._blocks_of(side, missing)
        return f"{why}, a dialect without reactions" if why and not self.sides[side].dialect.reaction else why

    def _blocks_of(self, side: int, missing: list[int]) -> str:
        to_me, to_other = self.sides[side].delivered, self.sides[1 - side].delivered
        if any(not each.right for each in to_other if not each.reaction):
            return "a command taken wrong"
        if any(not each.right for each in to_me if each.reaction):
            return "a reaction taken wrong"
        if any(not _is_reaction(payload_of(self.line.records[side].said[number].data) or b"") for number in missing):
            return "a command acknowledged and not taken, a reaction heard all the same"
        return ""

    def _count(self) -> None:
        for side, record in zip(self.sides, self.line.records, strict=True):
            blocks = [each for each in record.said if each.is_block]
            self.tally.telegrams += len(blocks)
            hit = False
            for each in record.said:
                hit = hit or bool(each.fault)
                if each.is_block:
                    self.tally.faulted += hit
                    self.tally.link_random += bool(each.fault) / (256 if side.profile.block_check else 1)
                    hit = False
        self.tally.faults.update(self.line.faults)
        self.line.faults.clear()


def _is_reaction(data: bytes) -> bool:
    return len(data) >= 4 and data[0] in (0, 0xFF) and data[1] == 0 and data[2] == 0


def pairs_with_check() -> Iterator[tuple[Profile, Profile]]:
    """All ordered pairs of dialects under 3964R; Bosch ends its follow-on telegrams with ETB."""
    profiles = [replace(each, follow_on_end=Char.ETB) if each.name == BUEP64 else each for _, each in sorted(PROFILES.items())]
    yield from ((left, right) for left in profiles for right in profiles)


def pairs_without_check() -> Iterator[tuple[Profile, Profile]]:
    """Procedure 3964: each dialect with itself and with its neighbours."""
    profiles = [each.plain() for _, each in sorted(PROFILES.items())]
    yield from ((each, each) for each in profiles)
    yield from pairwise((*profiles, profiles[0]))


def soak(telegrams: int, seed: int = 1, progress: bool = False) -> tuple[Tally, Tally]:
    """So many telegrams in equal parts over all pairs: what 3964R did, what 3964 without block check did."""
    totals = (Tally(), Tally())
    pairs = [*((0, pair) for pair in pairs_with_check()), *((1, pair) for pair in pairs_without_check())]
    for number, (which, (left, right)) in enumerate(steps("soak", pairs) if progress else pairs):
        totals[which].add(Pair(left, right, seed * 1000 + number).run(telegrams // len(pairs) + 1))
    return totals


__all__ = ["ErrorNumber", "Pair", "Tally", "soak"]
