"""CANopen, PDOs and their states: stopped, not valid, another identifier, the SYNC counter, effects of a reset (CiA 301)."""

from contextlib import suppress

from gateway.conformance.framework.base import hexed
from gateway.conformance.suites.can.node import NodeTester
from gateway.conformance.suites.can.tester import afterwards
from gateway.conformance.suites.canopen301.pdo import RX, SENDS, TAKEN, TAKES, TX, mapping, offered_types, reception, synced, transmission
from gateway.conformance.suites.canopen301.pdo_wrong import MAP, MAPS, OTHERS, mapped_back, opened, write
from gateway.pure.conformance.purpose import Purposes
from gateway.pure.conformance.verdict import Ended, Fail, NotApplicable
from protocols.base.machine import ms
from protocols.canopen import cob_id as cobid
from protocols.canopen.nmt import Command
from protocols.canopen.sdo import Abort

BASIC, WRITE, FIRST = "CO301_SDO_BV_01", "CO301_SDO_BV_03", "CO301_PDO_BV_01"
SENT = Purposes[NodeTester]("CO301_PDO", "slave", "CiA 301, 7.3.2.2.4", condition=SENDS, preamble=(BASIC, WRITE, FIRST))
HEARD = Purposes[NodeTester]("CO301_PDO", "slave", "CiA 301, 7.5.2.35", condition=TAKES, preamble=(BASIC, WRITE, TAKEN))
MAPPED = Purposes[NodeTester]("CO301_PDO", "slave", "CiA 301, 7.5.2.36", condition=MAPS, preamble=(BASIC, WRITE, "CO301_PDO_BV_11"))
SYNC, OVERFLOW, START = (0x1005, 0), (0x1019, 0), (TX, 6)
OTHER_SYNC, OTHER_RPDO, COUNT = 0x6B4, 0x6B3, 4


@SENT.case("BO_04", "in state stopped no TPDO is sent", "im Zustand Stopped wird kein TPDO gesendet")
def stopped(t: NodeTester) -> None:
    with transmission(t, 1) as identifier, t.stopped():
        if any(synced(t, identifier, 4)):
            raise Fail("a TPDO in state stopped", "nothing", "a TPDO")


@SENT.case(
    "BO_05",
    "the event timer ends with state operational",
    "der Event-Timer endet mit dem Zustand Operational",
    preamble=(BASIC, WRITE, FIRST, "CO301_PDO_BV_04"),
)
def timer_ends(t: NodeTester) -> None:
    with transmission(t, 255, 30) as identifier:
        with t.given():
            if len(t.collect(identifier, 3, ms(500))) < 3:
                raise Fail("no TPDOs with an event timer of 30 ms", "one each period", "fewer")
        t.command(Command.PRE_OPERATIONAL)
        t.pause(ms(10))
        t.silence(identifier, ms(150), "an event timer in state pre-operational")


@HEARD.case("BV_12", "an RPDO that is not valid has no effect", "ein ungültiges RPDO wirkt nicht")
def not_valid(t: NodeTester) -> None:
    with t.given():
        cob = t.number((RX, 1))
    with reception(t, 255) as target, afterwards(lambda: t.download((RX, 1), cob, 4)):
        with t.given():
            t.download((RX, 1), cob | cobid.INVALID, 4)
        t.say(target.identifier, target.data(0x3C))
        t.pause(ms(5))
        target.holds(t, 0, "an RPDO that 1400h:01 marks as not valid")


@HEARD.case("BV_13", "an RPDO is taken on the identifier of 1400h:01", "ein RPDO wird auf der Kennung von 1400h:01 angenommen")
def moved(t: NodeTester) -> None:
    with t.given():
        cob = t.number((RX, 1))
    place = cob & ~cobid.INVALID & ~cobid.ID_BITS | OTHER_RPDO
    back = (lambda: t.download((RX, 1), place | cobid.INVALID, 4), lambda: t.download((RX, 1), cob, 4))
    with reception(t, 255) as target, afterwards(*back):
        for word in (cob | cobid.INVALID, place):
            try:
                t.download((RX, 1), word, 4)
            except Fail as refused:
                raise NotApplicable(f"1400h:01 cannot be changed ({refused.got})") from refused
        t.say(OTHER_RPDO, target.data(0x35))
        t.pause(ms(5))
        target.holds(t, 0x35, f"an RPDO on {OTHER_RPDO:03X}h, as set in 1400h:01")
        t.say(target.identifier, target.data(0x53))
        t.pause(ms(5))
        target.holds(t, 0x35, "an RPDO on its former identifier")


@SENT.case("BV_14", "SYNC is heard on the identifier of 1005h", "SYNC wird auf der Kennung von 1005h gehört", clause="CiA 301, 7.5.2.5")
def moved_sync(t: NodeTester) -> None:
    with t.kept(SYNC):
        try:
            t.download(SYNC, OTHER_SYNC, 4)
        except Fail as refused:
            raise NotApplicable(f"1005h cannot be changed ({refused.got})") from refused
        with transmission(t, 1) as identifier:
            t.pause(t.setup.cycle)
            t.say(OTHER_SYNC)
            if not [frame for frame in t.pause(t.setup.cycle) if frame.identifier == identifier]:
                raise Fail(f"no TPDO after SYNC on {OTHER_SYNC:03X}h, as set in 1005h", "a TPDO", "none")
            if any(synced(t, identifier, 2)):
                raise Fail("a TPDO after SYNC on its former identifier", "nothing", "a TPDO")


def _counts(t: NodeTester) -> None:
    """The SYNC counter runs from 1 to COUNT; N/A where 1019h is fixed."""
    try:
        t.download(OVERFLOW, COUNT, 1)
    except Fail as refused:
        raise NotApplicable(f"1019h cannot be changed ({refused.got})") from refused


@SENT.case(
    "BV_15",
    "the SYNC counter begins again with 1 after 1019h, and nothing is missed",
    "der SYNC-Zähler beginnt nach 1019h wieder mit 1, und nichts fehlt",
    clause="CiA 301, 7.2.5.3.1",
    condition=("sync_counter",),
)
def counter_wraps(t: NodeTester) -> None:
    with t.kept(OVERFLOW):
        _counts(t)
        with transmission(t, 1) as identifier:
            t.pause(t.setup.cycle)
            for turn in range(3 * COUNT):
                t.sync(bytes((turn % COUNT + 1,)))
                found = [frame for frame in t.pause(t.setup.cycle) if frame.identifier == identifier]
                if len(found) != 1:
                    number = turn % COUNT + 1
                    raise Fail(f"{len(found)} TPDOs after SYNC with counter {number} (SYNC {turn + 1})", "1", str(len(found)))


@SENT.case(
    "BV_16",
    "1800h:06: the first TPDO comes with that SYNC counter",
    "1800h:06: das erste TPDO kommt mit diesem SYNC-Zähler",
    clause="CiA 301, 7.5.2.37",
    condition=("sync_counter",),
    preamble=(BASIC, WRITE, FIRST, "CO301_PDO_BV_15"),
)
def starts_with(t: NodeTester) -> None:
    with t.given():
        if not t.exists(START):
            raise NotApplicable("there is no 1800h:06")
        cob = t.number((TX, 1))
    with t.kept(OVERFLOW, (TX, 1), START):
        _counts(t)
        with t.given():
            t.download((TX, 1), cob | cobid.INVALID, 4)
            t.download(START, 3, 1)
        try:
            with transmission(t, 1) as identifier:
                found = []
                for number in range(1, COUNT + 1):
                    t.sync(bytes((number,)))
                    found.append(sum(frame.identifier == identifier for frame in t.pause(t.setup.cycle)))
        finally:
            with suppress(Ended):
                t.download((TX, 1), cob | cobid.INVALID, 4)
    if found != [0, 0, 1, 1]:
        raise Fail(f"1800h:06 = 3: TPDOs after SYNC 1 to {COUNT}: {found}", "[0, 0, 1, 1]", str(found))


@SENT.case(
    "BV_17",
    "reset communication sets TPDO 1 back",
    "Reset Communication setzt TPDO 1 zurück",
    clause="CiA 301, 7.3.2.2.1",
    condition=("reset",),
    preamble=(BASIC, WRITE, FIRST, "CO301_NMT_BV_02"),
)
def set_back(t: NodeTester) -> None:
    with t.given():
        t.reset()
        kind, cob = t.upload((TX, 2)), t.number((TX, 1))
        t.download((TX, 1), cob | cobid.INVALID, 4)
        others = offered_types(t, TX, *(number for number in (255, 254, 1, 5) if number != kind[0]))
        t.reset(Command.RESET_COMMUNICATION)
    if not others:
        raise NotApplicable("1800h:02 accepts one value only")
    got = t.upload((TX, 2))
    if got != kind:
        t.reset()
        raise Fail("1800h:02 is kept over reset communication", hexed(kind), hexed(got))


@MAPPED.case(
    "BI_11",
    "an entry with another length than its object is refused",
    "ein Eintrag mit anderer Länge als sein Objekt wird abgelehnt",
)
def wrong_length(t: NodeTester) -> None:
    with opened(t) as parts:
        chosen = next((part for part in parts if part.bits in (16, 32)), None)
        if chosen is None:
            raise NotApplicable("TPDO 1 carries no object of 16 or 32 bits")
        word = chosen.word & ~0xFF | (chosen.bits * 2 if chosen.bits == 16 else 16)
        got = t.ask(write((MAP, 1), word, 4))
        if got[:1] == b"\x60":
            got = t.ask(write((MAP, 0), 1, 1))
        codes = (Abort.NOT_MAPPABLE, Abort.MAPPED_LENGTH, Abort.LENGTH, Abort.TOO_LONG, Abort.TOO_SHORT)
        t.judge_refusal(got, codes, f"{chosen.index:04X}h with {word & 0xFF} bits, which has {chosen.bits}", OTHERS)


@MAPPED.case("BI_12", "a valid TPDO cannot be mapped anew", "ein gültiges TPDO lässt sich nicht neu mappen")
def while_valid(t: NodeTester) -> None:
    """Refused is enough at any step: no entries, the entry, the count."""
    with t.given():
        cob, parts = t.number((TX, 1)), mapping(t, MAP)
    if not parts:
        raise NotApplicable("TPDO 1 carries nothing")
    steps = (write((MAP, 0), 0, 1), write((MAP, 1), parts[-1].word, 4), write((MAP, 0), 1, 1))
    with t.kept((TX, 1)):
        with t.given():
            t.download((TX, 1), cob & ~cobid.INVALID, 4)
        try:
            if all(t.ask(step)[:1] == b"\x60" for step in steps):
                raise Fail("TPDO 1 was remapped while valid (1800h:01)", "a refusal", "each step is acknowledged")
        finally:
            mapped_back(t, cob, parts)
