"""CANopen, PDOs at work: transmission types, SYNC, event and inhibit times, contents, lengths (CiA 301, 7.2.2, 7.5.2.35)."""

import itertools
from collections.abc import Iterator
from contextlib import contextmanager, suppress

from gateway.conformance.framework.base import hexed
from gateway.conformance.suites.can.node import Aborted, NodeTester
from gateway.conformance.suites.can.tester import gaps, shown
from gateway.pure.conformance.purpose import Particulars, Purposes
from gateway.pure.conformance.verdict import Ended, Fail, NotApplicable, Warn
from protocols.base.machine import Frame, Ns, ms
from protocols.canopen import cob_id as cobid
from protocols.canopen import pdo
from protocols.canopen.dictionary import Key
from protocols.canopen.emcy import decode
from protocols.canopen.nmt import Command
from protocols.canopen.sdo import Abort

BASIC, WRITE, FIRST = "CO301_SDO_BV_01", "CO301_SDO_BV_03", "CO301_PDO_BV_01"
SENDS, TAKES = ("tpdo", "sync", "tpdo_setup"), ("rpdo", "sync", "write_pdo", "rpdo_setup")
PDO = Purposes[NodeTester]("CO301_PDO", "slave", "CiA 301, 7.2.2", preamble=(BASIC, WRITE, FIRST))
TX, RX = 0x1800, 0x1400
CONTROL: Key = (0x6040, 0)
SYNCS = 12


def mapping(t: NodeTester, index: int) -> list[pdo.Mapped]:
    count = t.number((index, 0))
    return [pdo.mapped(t.number((index, sub))) for sub in range(1, count + 1)]


def offered_types(t: NodeTester, index: int, *kinds: int) -> list[int]:
    """The transmission types a PDO accepts, the last of them set; a device need not offer each."""
    found = []
    for kind in kinds:
        try:
            t.download((index, 2), kind, 1)
        except Aborted as refused:
            if refused.code not in (Abort.VALUE, Abort.TOO_HIGH, Abort.TOO_LOW, Abort.GENERAL):
                raise
            continue
        found.append(kind)
    return found


@contextmanager
def transmission(t: NodeTester, kind: int, event_ms: int = 0, inhibit: int = 0) -> Iterator[int]:
    """TPDO 1 of this type, operational; its identifier."""
    with t.given():
        cob = t.number((TX, 1))
        before = [(sub, t.upload((TX, sub))) for sub in (2, 3, 5) if t.exists((TX, sub))]
    there = {sub for sub, _ in before}
    if (event_ms and 5 not in there) or (inhibit and 3 not in there):
        raise NotApplicable("TPDO 1 has no such time")
    try:
        with t.given():
            t.download((TX, 1), cob | cobid.INVALID, 4)
            if kind not in offered_types(t, TX, kind):
                raise NotApplicable(f"TPDO 1 does not offer transmission type {kind}")
            for sub, value in ((3, inhibit), (5, event_ms)):
                if sub in there:
                    t.download((TX, sub), value, 2)
            t.download((TX, 1), cob & ~cobid.INVALID, 4)
        with t.operational():
            yield cob & cobid.ID_BITS
    finally:
        with suppress(Ended):
            t.download((TX, 1), cob | cobid.INVALID, 4)
        for sub, held in before:
            with suppress(Ended):
                t.download((TX, sub), int.from_bytes(held, "little"), len(held))
        with suppress(Ended):
            t.download((TX, 1), cob, 4)


def synced(t: NodeTester, identifier: int, count: int) -> list[list[Frame]]:
    """Frames on this identifier after each of so many SYNCs."""
    found = []
    for _ in range(count):
        t.sync()
        found.append([frame for frame in t.pause(t.setup.cycle) if frame.identifier == identifier])
    return found


@PDO.case(
    "BV_01",
    "transmission type 1: one TPDO after each SYNC, in the length of its mapping",
    "Übertragungsart 1: ein TPDO nach jedem SYNC, in der Länge seines Mappings",
    condition=SENDS,
    preamble=(BASIC, WRITE),
    beside=Particulars(limits="SYNC to TPDO within 1007h, or the cycle of the tester"),
)
def each_sync(t: NodeTester) -> None:
    with t.given():
        size = (sum(part.bits for part in mapping(t, 0x1A00)) + 7) // 8
        window = t.number((0x1007, 0)) * 1000 if t.exists((0x1007, 0)) else 0
    with transmission(t, 1) as identifier:
        t.pause(t.setup.cycle)
        for turn in range(SYNCS):
            t.sync()
            asked = t.asked_at
            frames = [frame for frame in t.pause(t.setup.cycle) if frame.identifier == identifier]
            if len(frames) != 1:
                raise Fail(f"{len(frames)} TPDOs after SYNC {turn + 1}", "1", str(len(frames)))
            if len(frames[0].data) != size:
                raise Fail(f"TPDO 1 has {len(frames[0].data)} bytes", f"{size} bytes, as mapped", shown(frames[0]))
            t.timed("SYNC to TPDO", frames[0].stamp_ns - asked, None, window or t.setup.cycle)


@PDO.case("BV_02", "transmission type 3: with every third SYNC", "Übertragungsart 3: mit jedem dritten SYNC", condition=SENDS)
def third(t: NodeTester) -> None:
    with transmission(t, 3) as identifier:
        counts = [len(frames) for frames in synced(t, identifier, SYNCS)]
    places = [at for at, count in enumerate(counts) if count]
    steps = {later - before for before, later in itertools.pairwise(places)}
    if max(counts) > 1 or len(places) != SYNCS // 3 or steps != {3}:
        raise Fail(f"TPDOs after the SYNCs: {counts}", "one with every third", str(counts))


@PDO.case("BV_03", "a TPDO holds what an SDO reads", "ein TPDO enthält, was ein SDO liest", condition=SENDS)
def contents(t: NodeTester) -> None:
    with t.given():
        parts = mapping(t, 0x1A00)
    with transmission(t, 1) as identifier:
        for _ in range(3):  # a value that changes in between is read again
            with t.given():
                before = mapped_value(t, parts)
            frames = synced(t, identifier, 1)[0]
            with t.given():
                after = mapped_value(t, parts)
            if before == after:
                break
        else:
            raise NotApplicable("the contents of TPDO 1 change by themselves")
    got = frames[0].data if frames else b""
    if got != before:
        raise Fail("TPDO 1 holds other values than its objects", hexed(before), hexed(got))


def mapped_value(t: NodeTester, parts: list[pdo.Mapped]) -> bytes:
    value = place = 0
    for part in parts:
        value |= (t.number((part.index, part.sub)) & ((1 << part.bits) - 1)) << place
        place += part.bits
    return value.to_bytes((place + 7) // 8, "little")


@PDO.case(
    "BV_04",
    "the event timer is the period of an event-driven TPDO",
    "der Event-Timer ist die Periode eines ereignisgesteuerten TPDO",
    condition=SENDS,
    beside=Particulars(limits="50 ms, each 80 to 120 %"),
)
def event_timer(t: NodeTester) -> None:
    _period(t, 50, 0, ms(40), ms(60))


@PDO.case(
    "BV_05",
    "two TPDOs are never closer than the inhibit time",
    "zwei TPDOs folgen nie dichter als die Sperrzeit",
    condition=SENDS,
    preamble=(BASIC, FIRST, "CO301_PDO_BV_04"),
    beside=Particulars(limits="inhibit time 60 ms, event timer 20 ms: at least 54 ms apart"),
)
def inhibit(t: NodeTester) -> None:
    _period(t, 20, 600, ms(54), ms(500))


def _period(t: NodeTester, event_ms: int, inhibit: int, least: Ns, most: Ns) -> None:
    with transmission(t, 255, event_ms, inhibit) as identifier:
        frames = t.collect(identifier, 8, ms(1000))[2:]
    if len(frames) < 4:
        raise Fail(f"{len(frames)} TPDOs with an event timer of {event_ms} ms", "one each period", str(len(frames)))
    for gap in (min(gaps(frames)), max(gaps(frames))):
        t.timed(f"from TPDO to TPDO, event timer {event_ms} ms, inhibit time {inhibit / 10:g} ms", gap, least, most)


@PDO.case("BV_06", "a TPDO that is not valid is not sent", "ein ungültiges TPDO wird nicht gesendet", condition=SENDS)
def invalid(t: NodeTester) -> None:
    with transmission(t, 1) as identifier:
        with t.given():
            cob = t.number((TX, 1))
            t.download((TX, 1), cob | cobid.INVALID, 4)
            if t.number((TX, 1)) & cobid.INVALID == 0:
                raise Fail("1800h:01 does not accept bit 31", "bit 31 set", "bit 31 clear")
        if any(synced(t, identifier, 4)):
            raise Fail("TPDO 1 is sent though 1800h:01 marks it as not valid", "nothing", "a TPDO")


@PDO.case("BV_07", "a TPDO is sent on the identifier of 1800h:01", "ein TPDO wird auf der Kennung von 1800h:01 gesendet", condition=SENDS)
def moved(t: NodeTester) -> None:
    with t.given():
        cob = t.number((TX, 1))
    other = 0x6B0
    with transmission(t, 1):
        try:
            with t.given():
                t.download((TX, 1), cob | cobid.INVALID, 4)
                t.download((TX, 1), cob & ~cobid.INVALID & ~cobid.ID_BITS | cobid.INVALID | other, 4)
                t.download((TX, 1), cob & ~cobid.INVALID & ~cobid.ID_BITS | other, 4)
            if not any(synced(t, other, 3)):
                raise Fail(f"no TPDO on {other:03X}h after 1800h:01 was set to it", f"a TPDO on {other:03X}h", "none")
        finally:
            with suppress(Ended):
                t.download((TX, 1), cob & ~cobid.ID_BITS | cobid.INVALID | other, 4)


@PDO.case("BO_01", "before start no TPDO is sent", "vor dem Start wird kein TPDO gesendet", condition=SENDS, preamble=(BASIC, WRITE, FIRST))
def not_before(t: NodeTester) -> None:
    with transmission(t, 1) as identifier:
        t.command(Command.PRE_OPERATIONAL)
        t.pause(ms(5))
        if any(synced(t, identifier, 4)):
            raise Fail("a TPDO in state pre-operational", "nothing", "a TPDO")


@PDO.case("ST_01", "1500 SYNCs, 1500 TPDOs", "1500 SYNCs, 1500 TPDOs", condition=SENDS)
def many(t: NodeTester) -> None:
    with transmission(t, 1) as identifier:
        t.pause(t.setup.cycle)
        counts = [len(frames) for frames in synced(t, identifier, 1500)]
    if set(counts) != {1}:
        bad = next(at for at, count in enumerate(counts) if count != 1)
        raise Fail(f"{counts[bad]} TPDOs after SYNC {bad + 1}", "1", str(counts[bad]))


# ---- what it accepts
class Target:
    """An object of RPDO 1 that may be written, and a telegram that writes it."""

    def __init__(self, t: NodeTester) -> None:
        with t.given():
            self._parts = mapping(t, 0x1600)
            self.identifier = t.number((RX, 1)) & cobid.ID_BITS
        chosen = [part for part in self._parts if (part.index, part.sub) != CONTROL and part.bits >= 8]
        if not chosen:
            raise NotApplicable("RPDO 1 carries nothing that may be written")
        self._chosen = chosen[-1]
        self.key: Key = (self._chosen.index, self._chosen.sub)
        self.mask = (1 << self._chosen.bits) - 1

    def data(self, value: int, others: int = 0) -> bytes:
        """The chosen object gets the value, all others 0 or another one; the controlword stays 0."""
        total = place = 0
        for part in self._parts:
            given = value if part is self._chosen else others
            total |= (given & ((1 << part.bits) - 1) if (part.index, part.sub) != CONTROL else 0) << place
            place += part.bits
        return total.to_bytes((place + 7) // 8, "little")

    def others(self, t: NodeTester) -> dict[Key, bytes]:
        """Values of the other objects of the RPDO."""
        keys = [(part.index, part.sub) for part in self._parts if part is not self._chosen]
        return {key: t.upload(key) for key in keys if key != CONTROL}

    def holds(self, t: NodeTester, value: int, what: str) -> None:
        got = t.number(self.key) & self.mask
        if got != value & self.mask:
            raise Fail(f"{self.key[0]:04X}h after {what} is {got:X}h", f"{value & self.mask:X}h", f"{got:X}h")


@contextmanager
def reception(t: NodeTester, kind: int) -> Iterator[Target]:
    """RPDO 1 of this type, operational."""
    target = Target(t)
    with t.kept((RX, 2), target.key):
        with t.given():
            if not offered_types(t, RX, kind):
                raise NotApplicable(f"RPDO 1 does not offer transmission type {kind}")
            t.download(target.key, 0, target.mask.bit_length() // 8)
        with t.operational():
            yield target


TAKEN = "CO301_PDO_BV_08"


@PDO.case("BV_08", "an RPDO of type 255 acts at once", "ein RPDO der Art 255 wirkt sofort", condition=TAKES, preamble=(BASIC, WRITE))
def at_once(t: NodeTester) -> None:
    with reception(t, 255) as target:
        for value in (0x51, 0x2F):
            t.say(target.identifier, target.data(value))
            t.pause(ms(5))
            target.holds(t, value, "an RPDO")


@PDO.case(
    "BV_09",
    "an RPDO of type 1 acts with the next SYNC, not before",
    "ein RPDO der Art 1 wirkt mit dem nächsten SYNC, nicht vorher",
    condition=TAKES,
    preamble=(BASIC, WRITE, TAKEN),
)
def with_sync(t: NodeTester) -> None:
    with reception(t, 1) as target:
        t.say(target.identifier, target.data(0x5A))
        t.pause(ms(5))
        target.holds(t, 0, "an RPDO that waits for SYNC")
        t.sync()
        t.pause(ms(5))
        target.holds(t, 0x5A, "SYNC")


@PDO.case(
    "BV_10",
    "of two RPDOs before a SYNC the last one counts",
    "von zwei RPDOs vor einem SYNC zählt das letzte",
    condition=TAKES,
    preamble=(BASIC, WRITE, TAKEN, "CO301_PDO_BV_09"),
)
def last_one(t: NodeTester) -> None:
    with reception(t, 1) as target:
        t.say(target.identifier, target.data(0x11))
        t.say(target.identifier, target.data(0x77))
        t.sync()
        t.pause(ms(5))
        target.holds(t, 0x77, "two RPDOs and a SYNC")


@PDO.case(
    "BI_01",
    "an RPDO that is too short has no effect, and is reported: EMCY 8210h",
    "ein zu kurzes RPDO wirkt nicht und wird gemeldet: EMCY 8210h",
    clause="CiA 301, 7.2.7.1",
    condition=TAKES,
    preamble=(BASIC, WRITE, TAKEN),
)
def too_short(t: NodeTester) -> None:
    with reception(t, 255) as target:
        with t.given():
            before = target.others(t)
        t.say(target.identifier, target.data(0x33, 0x35)[:-1])
        frame = t.hear((t.emcy,), ms(50))
        target.holds(t, 0, "an RPDO that lacks a byte")
        for key, held in target.others(t).items():
            if held != before[key]:
                raise Fail(f"{key[0]:04X}h:{key[1]:02X} was written by an RPDO that lacks a byte", hexed(before[key]), hexed(held))
        if frame is None:
            raise Warn("an RPDO that is too short is not reported", "EMCY 8210h", "nothing")
        if len(frame.data) != 8 or decode(frame.data).code != 0x8210:
            raise Fail("another emergency for an RPDO that is too short", "EMCY 8210h", shown(frame))
    t.reset()


@PDO.case("BO_02", "before start an RPDO has no effect", "vor dem Start wirkt kein RPDO", condition=TAKES, preamble=(BASIC, WRITE, TAKEN))
def rpdo_before(t: NodeTester) -> None:
    with reception(t, 255) as target:
        t.command(Command.PRE_OPERATIONAL)
        t.pause(ms(5))
        t.say(target.identifier, target.data(0x44))
        t.pause(ms(5))
        target.holds(t, 0, "an RPDO in state pre-operational")


@PDO.case(
    "BO_03",
    "an RPDO of before the start is forgotten",
    "ein RPDO von vor dem Start ist vergessen",
    condition=TAKES,
    preamble=(BASIC, WRITE, TAKEN, "CO301_PDO_BV_09", "CO301_PDO_BO_02"),
)
def stale(t: NodeTester) -> None:

    with reception(t, 1) as target:
        t.say(target.identifier, target.data(0x66))
        t.command(Command.PRE_OPERATIONAL)
        t.pause(ms(5))
        t.command(Command.START)
        t.pause(ms(5))
        t.sync()
        t.pause(ms(5))
        target.holds(t, 0, "an RPDO received before the last start")
