"""CANopen, intermittent faults, and faults that show only in PDOs and watched nodes beyond the first (CiA 301, 7.2.2, 7.2.8.3)."""

from collections.abc import Iterator
from contextlib import contextmanager

from gateway.conformance.framework.base import hexed
from gateway.conformance.suites.can.node import HEARTBEAT, NodeTester, named
from gateway.conformance.suites.can.tester import afterwards, gaps, shown
from gateway.conformance.suites.canopen301.life import CONSUMES, GUARDS, LOST, MASTER, SUPERVISED_MS, emergency, guarded
from gateway.conformance.suites.canopen301.network import entered
from gateway.conformance.suites.canopen301.pdo import CONTROL, SENDS, TAKEN, TAKES, mapped_value, mapping, reception, synced, transmission
from gateway.pure.conformance.purpose import Particulars, Purposes
from gateway.pure.conformance.verdict import Ended, Fail, NotApplicable
from protocols.base.machine import ms
from protocols.canopen import cob_id as cobid
from protocols.canopen import pdo
from protocols.canopen.nmt import State

BASIC, WRITE, FIRST, BEAT = "CO301_SDO_BV_01", "CO301_SDO_BV_03", "CO301_PDO_BV_01", "CO301_ERR_BV_01"
BEATS = Purposes[NodeTester]("CO301_ERR", "slave", "CiA 301, 7.2.8.3", preamble=(BASIC, WRITE))
PDOS = Purposes[NodeTester]("CO301_PDO", "slave", "CiA 301, 7.2.2", preamble=(BASIC, WRITE))
PERIOD, MANY = 40, 40
SECOND = (0x1016, 2)
NUMBERS = range(1, 8)  # of PDOs besides the first


@BEATS.case(
    "ST_01",
    "40 heartbeats while operational: each shows the state, none is missing",
    "40 Heartbeats im Zustand Operational: jeder zeigt den Zustand, keiner fehlt",
    condition=("heartbeat",),
    preamble=(BASIC, WRITE, BEAT, "CO301_NMT_BV_03"),
    beside=Particulars(limits="1017h = 40: at most 160 % from one to the next"),
)
def many_beats(t: NodeTester) -> None:
    with t.beating(PERIOD), t.operational():
        with t.given():
            entered(t, State.OPERATIONAL, "after start")
        t.drain()
        frames = t.collect(cobid.heartbeat(t.setup.node), MANY, t.setup.wait)
    wrong = [frame for frame in frames if frame.data != bytes((State.OPERATIONAL,))]
    if wrong:
        raise Fail(f"heartbeat {frames.index(wrong[0]) + 1} of {MANY} shows another state", "05 (operational)", shown(wrong[0]))
    if len(frames) < MANY:
        raise Fail(f"after {len(frames)} heartbeats no more are received", f"{MANY}", str(len(frames)))
    t.timed("longest time between two heartbeats, 1017h = 40", max(gaps(frames)), None, ms(1.6 * PERIOD))


@BEATS.case(
    "ST_02",
    "40 answers to node guarding: the toggle bit alternates in each",
    "40 Antworten auf Node Guarding: das Toggle-Bit wechselt in jeder",
    clause="CiA 301, 7.2.8.3.2",
    condition=GUARDS,
    preamble=(BASIC, WRITE, "CO301_ERR_BV_03"),
)
def many_guards(t: NodeTester) -> None:
    with t.kept(HEARTBEAT):
        with t.given():
            t.download(HEARTBEAT, 0, 2)
            t.pause(ms(5))
            before = guarded(t)
        for turn in range(2, MANY + 1):
            got, wanted = guarded(t), before ^ 0x80
            if got != wanted:
                raise Fail(f"answer {turn} to guarding is {got:02X}h", f"{wanted:02X}h", f"{got:02X}h")
            before = got


@BEATS.case(
    "BV_20",
    "the node in 1016h:02 is watched as well",
    "auch der Knoten in 1016h:02 wird überwacht",
    condition=CONSUMES,
    preamble=(BASIC, WRITE, LOST),
)
def second_consumer(t: NodeTester) -> None:
    if not t.exists(SECOND):
        raise NotApplicable("there is no 1016h:02")
    with t.kept(SECOND):
        with t.given():
            t.download(SECOND, MASTER << 16 | SUPERVISED_MS, 4)
            t.say_on(cobid.heartbeat(MASTER), bytes((State.OPERATIONAL,)))
        try:
            emergency(t, 0x8130, ms(10 * SUPERVISED_MS), "the heartbeat of the node in 1016h:02 stays away")
        finally:
            t.reset()


@PDOS.case(
    "ST_02",
    "60 TPDOs: each holds what an SDO reads",
    "60 TPDOs: jedes enthält, was ein SDO liest",
    condition=SENDS,
    preamble=(BASIC, WRITE, FIRST, "CO301_PDO_BV_03"),
)
def many_contents(t: NodeTester) -> None:
    with t.given():
        parts = mapping(t, 0x1A00)
    with transmission(t, 1) as identifier:
        with t.given():
            before = mapped_value(t, parts)
        found = [frame for frames in synced(t, identifier, 60) for frame in frames]
        with t.given():
            after = mapped_value(t, parts)
    if before != after:
        raise NotApplicable("the contents of TPDO 1 change by themselves")
    wrong = [at for at, frame in enumerate(found) if frame.data != before]
    if wrong:
        raise Fail(f"TPDO {wrong[0] + 1} of 60 holds other values than its objects", hexed(before), hexed(found[wrong[0]].data))


@PDOS.case("ST_03", "40 RPDOs: each of them acts", "40 RPDOs: jedes wirkt", condition=TAKES, preamble=(BASIC, WRITE, TAKEN))
def many_taken(t: NodeTester) -> None:
    with reception(t, 255) as target:
        for turn in range(MANY):
            value = 0x21 + turn
            t.say(target.identifier, target.data(value))
            t.pause(ms(5))
            target.holds(t, value, f"RPDO {turn + 1} of {MANY}")


# ---- PDOs besides the first
@contextmanager
def _made_valid(t: NodeTester, index: int, kind: int) -> Iterator[int]:
    """A PDO of this type, valid within the block; its identifier."""
    with t.given():
        cob, before = t.number((index, 1)), t.number((index, 2))
    back = (
        lambda: t.download((index, 1), cob | cobid.INVALID, 4),
        lambda: t.download((index, 2), before, 1),
        lambda: t.download((index, 1), cob, 4),
    )
    with afterwards(*back):
        with t.given():
            t.download((index, 1), cob | cobid.INVALID, 4)
            t.download((index, 2), kind, 1)
            t.download((index, 1), cob & ~cobid.INVALID, 4)
        yield cob & cobid.ID_BITS


def _others(t: NodeTester, communication: int, maps: int) -> list[tuple[int, list[pdo.Mapped]]]:
    """PDOs besides the first that have an identifier and a mapping."""
    found = []
    for number in NUMBERS:
        try:
            parts = mapping(t, maps + number)
            if parts and t.number((communication + number, 1)) & cobid.ID_BITS:
                found.append((number, parts))
        except Ended:
            continue
    return found


@PDOS.case(
    "BV_18",
    "each further TPDO: on its identifier, in its length, with what an SDO reads",
    "jedes weitere TPDO: auf seiner Kennung, in seiner Länge, mit dem, was ein SDO liest",
    condition=SENDS,
    preamble=(BASIC, WRITE, FIRST, "CO301_PDO_BV_03"),
)
def further_tpdos(t: NodeTester) -> None:
    with t.given():
        found = _others(t, 0x1800, 0x1A00)
    tried = 0
    for number, parts in found:
        try:
            with _made_valid(t, 0x1800 + number, 1) as identifier, t.operational():
                with t.given():
                    t.pause(t.setup.cycle)
                    before = mapped_value(t, parts)
                frames = synced(t, identifier, 1)[0]
                with t.given():
                    after = mapped_value(t, parts)
        except Ended as ended:
            t.remark(f"TPDO {number + 1} is left out: {ended.reason}")
            continue
        tried += 1
        got = frames[0].data if frames else b""
        if len(got) != len(before) or (got != before == after):
            raise Fail(f"TPDO {number + 1} on {identifier:03X}h after SYNC", hexed(before), hexed(got) if frames else "nothing")
    if not tried:
        raise NotApplicable("there is no further TPDO that can be set to type 1")


@PDOS.case(
    "BV_19",
    "each further RPDO that may be written acts",
    "jedes weitere RPDO, das geschrieben werden darf, wirkt",
    condition=("rpdo", "rpdo_setup"),
)
def further_rpdos(t: NodeTester) -> None:
    with t.given():
        found = _others(t, 0x1400, 0x1600)
    tried = 0
    for number, parts in found:
        keys = [(part.index, part.sub) for part in parts]
        if CONTROL in keys or not set(keys) <= t.setup.touch or any(part.bits < 8 for part in parts):
            continue
        with t.kept(*keys), _made_valid(t, 0x1400 + number, 255) as identifier, t.operational():
            for byte in (0x11, 0x22):
                size = sum(part.bits for part in parts) // 8
                t.say(identifier, bytes((byte,)) * size)
                t.pause(ms(5))
                for part, key in zip(parts, keys, strict=True):
                    got, wanted = t.number(key), int.from_bytes(bytes((byte,)) * (part.bits // 8), "little")
                    if got != wanted:
                        raise Fail(f"{named(key)} after RPDO {number + 1} on {identifier:03X}h is {got:X}h", f"{wanted:X}h", f"{got:X}h")
        tried += 1
    if not tried:
        raise NotApplicable("no further RPDO carries only what may be written")
