"""CANopen, error control: heartbeat, node guarding, heartbeat consumer, emergency messages (CiA 301, 7.2.7, 7.2.8.3)."""

from collections.abc import Iterator
from contextlib import contextmanager, suppress

from gateway.conformance.suites.can.node import HEARTBEAT, NodeTester
from gateway.conformance.suites.can.tester import gaps, shown
from gateway.conformance.suites.canopen301.network import entered
from gateway.pure.conformance.purpose import Particulars, Purposes
from gateway.pure.conformance.verdict import Ended, Fail, NotApplicable, Warn
from protocols.base.errors import DecodeError
from protocols.base.machine import Frame, ms
from protocols.canopen import cob_id as cobid
from protocols.canopen import sdo
from protocols.canopen.emcy import Emergency, decode
from protocols.canopen.nmt import Command, State
from protocols.canopen.sdo import Abort, Request

BASIC, WRITE, BEAT, LOST = "CO301_SDO_BV_01", "CO301_SDO_BV_03", "CO301_ERR_BV_01", "CO301_ERR_BV_06"
ERR = Purposes[NodeTester]("CO301_ERR", "slave", "CiA 301, 7.2.8.3", preamble=(BASIC, WRITE))
CONSUMES = ("consumer", "emcy", "heartbeat")
GUARDS = ("guarding", "remote", "heartbeat")
MASTER, SUPERVISED_MS = 126, 60
CONSUMER, HISTORY = (0x1016, 1), (0x1003, 0)


@ERR.case(
    "BV_01",
    "1017h is the period of the heartbeat",
    "1017h ist die Periode des Heartbeats",
    condition=("heartbeat",),
    beside=Particulars(limits="each period 80 to 120 %, the mean 95 to 105 %"),
)
def period(t: NodeTester) -> None:
    for wanted in (100, 40):
        with t.beating(wanted):
            frames = t.collect(cobid.heartbeat(t.setup.node), 12, ms(10 * wanted))[1:]
        if len(frames) < 10:
            raise Fail(f"1017h = {wanted} ms: {len(frames)} heartbeats", "one each period", f"{len(frames)} in {12 * wanted} ms")
        mean = (frames[-1].stamp_ns - frames[0].stamp_ns) // (len(frames) - 1)
        t.timed(f"mean heartbeat period, 1017h = {wanted}", mean, ms(0.95 * wanted), ms(1.05 * wanted))
        for gap in (min(gaps(frames)), max(gaps(frames))):
            t.timed(f"heartbeat period, 1017h = {wanted}", gap, ms(0.8 * wanted), ms(1.2 * wanted))


@ERR.case(
    "BV_02", "1017h = 0 ends the heartbeat", "1017h = 0 beendet den Heartbeat", condition=("heartbeat",), preamble=(BASIC, WRITE, BEAT)
)
def no_beat(t: NodeTester) -> None:
    with t.kept(HEARTBEAT):
        with t.given():
            t.download(HEARTBEAT, 20, 2)
            t.beat()
            t.download(HEARTBEAT, 0, 2)
            t.pause(ms(5))
        t.silence(cobid.heartbeat(t.setup.node), ms(100), "1017h = 0")


@ERR.case(
    "BV_03",
    "node guarding is answered, the toggle bit alternates",
    "Node Guarding wird beantwortet, das Toggle-Bit wechselt",
    clause="CiA 301, 7.2.8.3.2",
    condition=GUARDS,
)
def guarding(t: NodeTester) -> None:
    with t.kept(HEARTBEAT):
        with t.given():
            t.download(HEARTBEAT, 0, 2)
            t.pause(ms(5))
        first = guarded(t)
        for turn in range(1, 5):
            got, wanted = guarded(t), first ^ (0x80 if turn % 2 else 0)
            if got != wanted:
                raise Fail(f"answer {turn + 1} to guarding is {got:02X}h", f"{wanted:02X}h", f"{got:02X}h")
    if first & 0x7F != State.PRE_OPERATIONAL:
        raise Fail(f"guarding shows state {first & 0x7F}", "127 (pre-operational)", str(first & 0x7F))


def guarded(t: NodeTester) -> int:
    identifier = cobid.heartbeat(t.setup.node)
    t.say(identifier | cobid.REMOTE)
    frame = t.hear((identifier,), t.setup.wait)
    if frame is None or len(frame.data) != 1:
        raise Fail("a guarding request is not answered with one byte", "one byte", shown(frame))
    return frame.data[0]


@ERR.case(
    "BV_04",
    "after reset communication the toggle bit begins with 0",
    "nach Reset Communication beginnt das Toggle-Bit mit 0",
    clause="CiA 301, 7.2.8.3.2",
    condition=(*GUARDS, "reset"),
    preamble=(BASIC, "CO301_ERR_BV_03", "CO301_NMT_BV_02"),
)
def toggle_begins(t: NodeTester) -> None:
    for _ in range(2):
        with t.given():
            t.reset(Command.RESET_COMMUNICATION)
            t.download(HEARTBEAT, 0, 2)
            t.pause(ms(5))
        if (got := guarded(t)) & 0x80:
            raise Fail(f"the first answer after a reset is {got:02X}h", "toggle bit 0", f"{got:02X}h")


@ERR.case(
    "BV_05",
    "guarding that stays away is reported: EMCY 8130h",
    "ausbleibendes Guarding wird gemeldet: EMCY 8130h",
    clause="CiA 301, 7.2.8.3.2",
    condition=(*GUARDS, "emcy"),
    preamble=(BASIC, "CO301_ERR_BV_03"),
)
def life_guarding(t: NodeTester) -> None:
    with t.kept((0x100C, 0), (0x100D, 0), HEARTBEAT):
        with t.given():
            t.download(HEARTBEAT, 0, 2)
            t.download((0x100C, 0), 30, 2)
            t.download((0x100D, 0), 2, 1)
            for _ in range(3):
                guarded(t)
                t.pause(ms(30))
        emergency(t, 0x8130, ms(500), "guarding stays away")
    t.reset()


# ---- the master's heartbeat
@contextmanager
def watched_master(t: NodeTester) -> Iterator[None]:
    """Node 126 is watched, and its heartbeat was received; the errors are cleared afterwards."""
    with t.kept(CONSUMER):
        with t.given():
            t.download(CONSUMER, MASTER << 16 | SUPERVISED_MS, 4)
            for _ in range(3):
                master_beats(t)
        yield
    with suppress(Ended):
        t.reset()


def master_beats(t: NodeTester) -> None:
    t.say_on(cobid.heartbeat(MASTER), bytes((State.OPERATIONAL,)))
    t.pause(ms(SUPERVISED_MS // 3))


def emergency(t: NodeTester, code: int, wait: int, what: str) -> Emergency:
    found = _decoded(t.hear((t.emcy,), wait), what, code)
    if found.code != code:
        raise Fail(f"{what}: EMCY {found.code:04X}h", f"EMCY {code:04X}h", f"EMCY {found.code:04X}h")
    return found


def _decoded(frame: Frame | None, what: str, code: int) -> Emergency:
    if frame is None:
        raise Fail(f"{what}: no emergency message", f"EMCY {code:04X}h", "nothing")
    try:
        return decode(frame.data)
    except DecodeError as error:
        raise Fail(f"{what}: an emergency of {len(frame.data)} bytes", "8 bytes", shown(frame)) from error


@ERR.case(
    "BV_06",
    "a heartbeat that stays away is reported: EMCY 8130h, after the time of 1016h",
    "ein ausbleibender Heartbeat wird gemeldet: EMCY 8130h, nach der Zeit von 1016h",
    condition=CONSUMES,
    beside=Particulars(limits="80 to 150 % of 1016h after the last heartbeat"),
)
def lost(t: NodeTester) -> None:
    with watched_master(t):
        t.pause(ms(2))
        t.say_on(cobid.heartbeat(MASTER), bytes((State.OPERATIONAL,)))
        last = t.asked_at
        frame = t.hear((t.emcy,), ms(10 * SUPERVISED_MS))
        found = _decoded(frame, "the heartbeat of the master stays away", 0x8130)
        if found.code != 0x8130:
            raise Fail(f"EMCY {found.code:04X}h", "EMCY 8130h", f"EMCY {found.code:04X}h")
        t.timed("heartbeat lost to EMCY", t.answered_at - last, ms(0.8 * SUPERVISED_MS), ms(1.5 * SUPERVISED_MS))


@ERR.case(
    "BV_07",
    "while heartbeats come nothing is reported",
    "solange Heartbeats kommen, wird nichts gemeldet",
    condition=CONSUMES,
    preamble=(BASIC, WRITE, LOST),
)
def watched(t: NodeTester) -> None:
    with watched_master(t):
        for _ in range(15):
            master_beats(t)
        if found := [frame for frame in t.heard if frame.identifier == t.emcy]:
            raise Fail("an emergency while the master's heartbeat is received", "nothing", shown(found[0]))


@ERR.case(
    "BV_08",
    "the error register shows bits 0 and 4 meanwhile, and EMCY repeats it",
    "das Fehlerregister zeigt derweil die Bits 0 und 4, EMCY enthält es",
    clause="CiA 301, 7.5.2.2",
    condition=CONSUMES,
    preamble=(BASIC, WRITE, LOST),
)
def register(t: NodeTester) -> None:
    with watched_master(t):
        with t.given():
            found = emergency(t, 0x8130, ms(10 * SUPERVISED_MS), "the heartbeat stays away")
        got = t.number((0x1001, 0))
        if got & 0x11 != 0x11:
            raise Fail(f"1001h is {got:02X}h while the heartbeat is lost", "bits 0 and 4 set", f"{got:02X}h")
        if found.register != got:
            raise Fail(f"EMCY has register {found.register:02X}h, 1001h is {got:02X}h", f"{got:02X}h", f"{found.register:02X}h")


@ERR.case(
    "BV_09",
    "1003h keeps the newest error first; a write of 0 empties it",
    "1003h hält den neuesten Fehler zuerst; Schreiben von 0 leert es",
    clause="CiA 301, 7.5.2.4",
    condition=(*CONSUMES, "history"),
    preamble=(BASIC, WRITE, LOST),
)
def history(t: NodeTester) -> None:
    with watched_master(t):
        with t.given():
            emergency(t, 0x8130, ms(10 * SUPERVISED_MS), "the heartbeat stays away")
        count = t.number(HISTORY)
        newest = t.number((0x1003, 1)) & 0xFFFF if count else 0
        if not count or newest != 0x8130:
            raise Fail(f"1003h has {count} errors, the newest {newest:04X}h", "at least 1, the newest 8130h", f"{count}, {newest:04X}h")
        t.download(HISTORY, 0, 1)
        if got := t.number(HISTORY):
            raise Fail(f"1003h:00 is {got} after a write of 0", "0", str(got))


@ERR.case(
    "BV_10",
    "the heartbeat is back: EMCY 0000h",
    "der Heartbeat ist wieder da: EMCY 0000h",
    clause="CiA 301, 7.2.7.1",
    condition=CONSUMES,
    preamble=(BASIC, WRITE, LOST),
)
def back(t: NodeTester) -> None:
    with t.given():
        before = t.number((0x1001, 0))
    with watched_master(t):
        with t.given():
            emergency(t, 0x8130, ms(10 * SUPERVISED_MS), "the heartbeat stays away")
        t.say(cobid.heartbeat(MASTER), bytes((State.OPERATIONAL,)))
        frame = t.hear((t.emcy,), ms(SUPERVISED_MS // 2))
        if frame is None:
            _still_present(t, before)
            raise Fail("no error reset message after the heartbeat returned, though 1001h shows no error", "EMCY 0000h", "nothing")
        if (found := decode(frame.data)).code:
            raise Fail(f"EMCY {found.code:04X}h when the heartbeat returned", "EMCY 0000h", f"EMCY {found.code:04X}h")


def _still_present(t: NodeTester, before: int) -> None:
    """A device may keep the error until a fault reset or a reset node, as drives do."""
    with t.given():
        master_beats(t)
        register = t.number((0x1001, 0))
    if register & ~before:
        raise Warn("the error stays after the heartbeat returned", "1001h without error and EMCY 0000h", f"{register:02X}h")


@ERR.case(
    "BV_11",
    "1029h:01 = 0: a lost heartbeat leads to pre-operational",
    "1029h:01 = 0: ein verlorener Heartbeat führt zu Pre-Operational",
    clause="CiA 301, 7.5.2.24",
    condition=(*CONSUMES, "error_behaviour"),
    preamble=(BASIC, WRITE, LOST, "CO301_NMT_BV_03"),
)
def behaviour(t: NodeTester) -> None:
    for value, state in ((0, State.PRE_OPERATIONAL), (1, State.OPERATIONAL), (2, State.STOPPED)):
        with t.kept((0x1029, 1)), watched_master(t), t.beating():
            with t.given():
                t.download((0x1029, 1), value, 1)
                t.command(Command.START)
                for _ in range(3):
                    master_beats(t)
                entered(t, State.OPERATIONAL, "after start")
            t.pause(ms(2 * SUPERVISED_MS))
            entered(t, state, f"1029h:01 = {value}, heartbeat lost")
            t.command(Command.PRE_OPERATIONAL)
            t.pause(ms(5))


@ERR.case("BI_01", "1003h:00 takes only 0", "1003h:00 nimmt nur 0", clause="CiA 301, 7.5.2.4", condition=("history",), preamble=(BASIC,))
def history_value(t: NodeTester) -> None:
    codes, others = (Abort.VALUE, Abort.TOO_HIGH), (Abort.GENERAL, Abort.READ_ONLY, Abort.ACCESS)
    for value in (255, 16, 2, 1):
        t.refused(sdo.expedited(Request.INITIATE_DOWNLOAD, HISTORY, bytes((value,))), codes, f"{value} to 1003h:00", others)


@ERR.case(
    "BI_02",
    "a node cannot be watched twice: 06040043h",
    "ein Knoten kann nicht zweimal überwacht werden: 06040043h",
    clause="CiA 301, 7.5.2.17",
    condition=("consumer",),
    preamble=(BASIC, WRITE),
)
def twice(t: NodeTester) -> None:
    with t.given():
        if not t.exists((0x1016, 2)):
            raise NotApplicable("it watches one node")
    with t.kept(CONSUMER, (0x1016, 2)):
        with t.given():
            t.download(CONSUMER, MASTER << 16 | 5000, 4)
        request = sdo.expedited(Request.INITIATE_DOWNLOAD, (0x1016, 2), (MASTER << 16 | 6000).to_bytes(4, "little"))
        t.refused(request, (Abort.INCOMPATIBLE,), "the same node in 1016h:02", (Abort.VALUE, Abort.GENERAL))


@ERR.case(
    "BI_03",
    "1014h with a restricted identifier is refused",
    "1014h mit gesperrter Kennung wird abgelehnt",
    clause="CiA 301, 7.3.5",
    condition=("emcy",),
    preamble=(BASIC, WRITE),
)
def emcy_identifier(t: NodeTester) -> None:
    request = sdo.expedited(Request.INITIATE_DOWNLOAD, (0x1014, 0), (0x8000_0000 | 0).to_bytes(4, "little"))
    with t.kept((0x1014, 0)):
        with t.given():
            got = t.ask(request)
        if got[:1] == b"\x80":
            raise Warn("1014h cannot be changed", "60h", "an abort")
        wrong = sdo.expedited(Request.INITIATE_DOWNLOAD, (0x1014, 0), (0x0000_0581).to_bytes(4, "little"))
        t.refused(wrong, (Abort.VALUE,), "581h to 1014h", (Abort.GENERAL, Abort.TOO_HIGH, Abort.TOO_LOW))


@ERR.case(
    "RC_01",
    "after a lost heartbeat it is reported again the next time",
    "nach einem verlorenen Heartbeat wird der nächste wieder gemeldet",
    condition=CONSUMES,
    preamble=(BASIC, WRITE, LOST, "CO301_ERR_BV_10"),
)
def again(t: NodeTester) -> None:
    with watched_master(t):
        for turn in range(3):
            emergency(t, 0x8130, ms(10 * SUPERVISED_MS), f"loss {turn + 1} of the heartbeat")
            for _ in range(3):
                master_beats(t)
            t.drain()  # the message that the error is gone
