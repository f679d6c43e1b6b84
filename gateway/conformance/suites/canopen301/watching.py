"""CANopen, NMT, errors and their messages in order: once, in time, on the right identifier, gone when gone (CiA 301, 7.2.7, 7.2.8.3)."""

from gateway.conformance.suites.can.node import DEVICE_TYPE, HEARTBEAT, NodeTester
from gateway.conformance.suites.can.tester import shown
from gateway.conformance.suites.canopen301.life import (
    CONSUMER,
    CONSUMES,
    GUARDS,
    LOST,
    MASTER,
    SUPERVISED_MS,
    emergency,
    guarded,
    master_beats,
    watched_master,
)
from gateway.conformance.suites.canopen301.network import entered
from gateway.pure.conformance.purpose import Particulars, Purposes
from gateway.pure.conformance.verdict import Fail, Inconclusive, NotApplicable
from protocols.base.machine import Frame, ms
from protocols.canopen import cob_id as cobid
from protocols.canopen.emcy import decode
from protocols.canopen.nmt import Command, State

BASIC, WRITE, STATES, BOOT = "CO301_SDO_BV_01", "CO301_SDO_BV_03", "CO301_NMT_BV_03", "CO301_NMT_BV_01"
LIFE = Purposes[NodeTester]("CO301_NMT", "slave", "CiA 301, 7.3.2", condition=("reset", "heartbeat"), preamble=(BASIC, WRITE, STATES))
WATCH = Purposes[NodeTester]("CO301_ERR", "slave", "CiA 301, 7.2.7", condition=CONSUMES, preamble=(BASIC, WRITE, LOST))
WAIT = ms(10 * SUPERVISED_MS)
EMCY_ID, EMCY_INHIBIT = (0x1014, 0), (0x1015, 0)
OTHER_EMCY, INHIBIT_MS = 0x6B2, 200


@LIFE.case("BV_07", "while operational an SDO is answered", "im Zustand Operational wird ein SDO beantwortet")
def at_work(t: NodeTester) -> None:
    with t.beating(), t.operational():
        with t.given():
            entered(t, State.OPERATIONAL, "after start")
        if len(t.upload(DEVICE_TYPE)) != 4:
            raise Fail("1000h while operational", "four bytes", "another length")


@LIFE.case(
    "BV_08",
    "a reset is followed by one boot-up message, and by nothing of the node before it",
    "auf einen Reset folgt eine Boot-up-Nachricht, und davor nichts vom Knoten",
    clause="CiA 301, 7.2.8.3.3",
    preamble=(BASIC, BOOT, "CO301_NMT_BV_02"),
)
def boots_once(t: NodeTester) -> None:
    node = t.setup.node
    for command in (Command.RESET_NODE, Command.RESET_COMMUNICATION):
        t.pause(ms(50))
        t.drain()
        t.command(command)
        since = len(t.heard)
        with t.given():
            if t.boot_up() is None:
                raise Fail("no boot-up message after a reset", f"{cobid.heartbeat(node):03X}h 00", "nothing")
        own = [frame for frame in t.heard[since:] if frame.identifier in (cobid.heartbeat(node), cobid.sdo_answer(node), t.emcy)]
        if len(own) > 1:
            raise Fail("it sends before its boot-up message", f"{cobid.heartbeat(node):03X}h 00 first", shown(own[0]))
        again = [frame for frame in t.pause(ms(300)) if frame.identifier == cobid.heartbeat(node) and frame.data == b"\0"]
        t.ready()
        if again:
            raise Fail(f"it boots twice after {command.name.lower().replace('_', ' ')}", "one boot-up message", shown(again[0]))


@LIFE.case(
    "BV_09",
    "reset node forgets what was not stored",
    "Reset Node vergisst, was nicht gespeichert ist",
    preamble=(BASIC, WRITE, BOOT),
)
def forgets(t: NodeTester) -> None:
    with t.given():
        t.reset()
        before = t.number(HEARTBEAT)
        t.download(HEARTBEAT, before + 777, 2)
        t.reset()
    if (got := t.number(HEARTBEAT)) != before:
        t.download(HEARTBEAT, before, 2)
        raise Fail(f"1017h is still {got} after reset node", str(before), str(got))


def _lost(t: NodeTester) -> None:
    with t.given():
        emergency(t, 0x8130, WAIT, "the heartbeat stays away")


@WATCH.case(
    "BV_12",
    "the heartbeat is back: bit 4 of the error register is clear",
    "der Heartbeat ist wieder da: Bit 4 des Fehlerregisters ist gelöscht",
    clause="CiA 301, 7.5.2.2",
    preamble=(BASIC, WRITE, LOST, "CO301_ERR_BV_08", "CO301_ERR_BV_10"),
)
def register_clears(t: NodeTester) -> None:
    with watched_master(t):
        _lost(t)
        for _ in range(3):
            master_beats(t)
        if (got := t.number((0x1001, 0))) & 0x10:
            raise Fail(f"1001h is {got:02X}h though the heartbeat is back", "bit 4 clear", f"{got:02X}h")


@WATCH.case("BV_13", "a loss is reported once", "ein Ausfall wird einmal gemeldet")
def once(t: NodeTester) -> None:
    with watched_master(t):
        _lost(t)
        more = [frame for frame in t.pause(ms(5 * SUPERVISED_MS)) if _is_loss(t, frame)]
        if more:
            raise Fail(f"the same loss is reported {len(more) + 1} times", "one emergency message", shown(more[0]))


def _is_loss(t: NodeTester, frame: Frame) -> bool:
    return frame.identifier == t.emcy and len(frame.data) == 8 and decode(frame.data).code == 0x8130


@WATCH.case(
    "BV_14",
    "the heartbeat of another node does not count",
    "der Heartbeat eines anderen Knotens zählt nicht",
    clause="CiA 301, 7.5.2.17",
)
def another(t: NodeTester) -> None:
    with watched_master(t):
        for _ in range(9):
            t.say_on(cobid.heartbeat(MASTER - 1), bytes((State.OPERATIONAL,)))
            t.pause(ms(SUPERVISED_MS // 3))
        if not any(_is_loss(t, frame) for frame in t.heard):
            raise Fail(f"node {MASTER} is watched, {MASTER - 1} beats, and nothing is reported", "EMCY 8130h", "nothing")


@WATCH.case(
    "BO_01",
    "a heartbeat that was never received is not missed: watching begins with the first one",
    "ein Heartbeat, der nie kam, wird nicht vermisst: die Überwachung beginnt mit dem ersten",
    clause="CiA 301, 7.2.8.3.2.2",
)
def never_heard(t: NodeTester) -> None:
    with t.given():
        t.reset()
    with t.kept(CONSUMER):
        with t.given():
            t.download(CONSUMER, (MASTER - 2) << 16 | SUPERVISED_MS, 4)
        t.pause(ms(5 * SUPERVISED_MS))
        found = [frame for frame in t.heard if _is_loss(t, frame)]
    t.reset()
    if found:
        raise Fail("the loss of a heartbeat that was never received is reported", "nothing before the first heartbeat", shown(found[0]))


def _takes(t: NodeTester, key: tuple[int, int], value: int, size: int) -> None:
    """N/A where the object is fixed."""
    try:
        t.download(key, value, size)
    except Fail as refused:
        raise NotApplicable(f"{key[0]:04X}h cannot be changed ({refused.got})") from refused


@WATCH.case(
    "BV_15",
    "bit 31 of 1014h: no emergency message is sent",
    "Bit 31 von 1014h: keine Emergency-Nachricht wird gesendet",
    clause="CiA 301, 7.5.2.15",
)
def off(t: NodeTester) -> None:
    with t.kept(EMCY_ID) as before:
        _takes(t, EMCY_ID, before[0] | cobid.INVALID, 4)
        with watched_master(t):
            found = [frame for frame in t.pause(WAIT) if frame.identifier == t.emcy]
    if found:
        raise Fail("an emergency message though bit 31 of 1014h is set", "nothing", shown(found[0]))


@WATCH.case(
    "BV_16",
    "an emergency is sent on the identifier of 1014h",
    "eine Emergency-Nachricht wird auf der Kennung von 1014h gesendet",
    clause="CiA 301, 7.5.2.15",
)
def moved(t: NodeTester) -> None:
    with t.kept(EMCY_ID) as before:
        try:
            _takes(t, EMCY_ID, before[0] | cobid.INVALID, 4)
            _takes(t, EMCY_ID, OTHER_EMCY, 4)
            with watched_master(t):
                frame = t.hear((OTHER_EMCY, t.emcy), WAIT)
            if frame is None or frame.identifier != OTHER_EMCY:
                raise Fail(
                    f"1014h is {OTHER_EMCY:03X}h, the emergency has another identifier", f"a message on {OTHER_EMCY:03X}h", shown(frame)
                )
        finally:
            t.reset()


@WATCH.case(
    "BV_17",
    "two emergency messages are never closer than 1015h",
    "zwei Emergency-Nachrichten folgen nie dichter als 1015h",
    clause="CiA 301, 7.5.2.16",
    beside=Particulars(limits=f"{INHIBIT_MS} ms: at least 90 % apart"),
)
def inhibited(t: NodeTester) -> None:
    if not t.exists(EMCY_INHIBIT):
        raise NotApplicable("there is no 1015h")
    with t.kept(EMCY_INHIBIT):
        _takes(t, EMCY_INHIBIT, 10 * INHIBIT_MS, 2)
        with watched_master(t):
            _lost(t)
            first = t.answered_at
            t.say_on(cobid.heartbeat(MASTER), bytes((State.OPERATIONAL,)))
            frame = t.hear((t.emcy,), ms(3 * INHIBIT_MS))
            if frame is None:
                raise Inconclusive("preamble: no message that the error is gone", "EMCY 0000h", "nothing")
            t.timed("from emergency to emergency", frame.stamp_ns - first, ms(0.9 * INHIBIT_MS), None)


GUARD = Purposes[NodeTester]("CO301_ERR", "slave", "CiA 301, 7.2.8.3.2", condition=GUARDS, preamble=(BASIC, WRITE, "CO301_ERR_BV_03"))


@GUARD.case("BV_18", "node guarding shows each state", "Node Guarding zeigt jeden Zustand")
def guarded_states(t: NodeTester) -> None:
    with t.kept(HEARTBEAT):
        with t.given():
            t.download(HEARTBEAT, 0, 2)
        try:
            for command, state in ((Command.START, State.OPERATIONAL), (Command.STOP, State.STOPPED)):
                t.command(command)
                t.pause(ms(10))
                if (got := guarded(t) & 0x7F) != state:
                    raise Fail(
                        f"guarding shows state {got} after {command.name.lower()}", f"{state.value} ({state.name.lower()})", str(got)
                    )
        finally:
            t.command(Command.PRE_OPERATIONAL)
            t.pause(ms(10))


BEATS = Purposes[NodeTester](
    "CO301_ERR", "slave", "CiA 301, 7.2.8.3.3", condition=("heartbeat",), preamble=(BASIC, WRITE, "CO301_ERR_BV_01")
)


@BEATS.case("BV_19", "bit 7 of a heartbeat is 0", "Bit 7 eines Heartbeats ist 0")
def no_toggle(t: NodeTester) -> None:
    with t.beating():
        t.drain()
        frames = t.collect(cobid.heartbeat(t.setup.node), 6, t.setup.wait)
    wrong = [frame for frame in frames if frame.data and frame.data[0] & 0x80]
    if wrong:
        raise Fail("a heartbeat has bit 7 set, as if it were an answer to guarding", "bit 7 clear", shown(wrong[0]))
