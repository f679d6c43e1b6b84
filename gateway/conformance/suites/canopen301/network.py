"""CANopen, NMT slave: boot-up, states, commands for others, services in each state (CiA 301, 7.3.2)."""

from gateway.conformance.suites.can.node import DEVICE_TYPE, HEARTBEAT, NodeTester
from gateway.conformance.suites.can.tester import shown
from gateway.pure.conformance.purpose import Particulars, Purposes
from gateway.pure.conformance.verdict import Fail, Warn
from protocols.base.machine import ms
from protocols.canopen import cob_id as cobid
from protocols.canopen import nmt, sdo
from protocols.canopen.nmt import Command, State
from protocols.canopen.sdo import Request

BASIC, WRITE, BOOT, STATES = "CO301_SDO_BV_01", "CO301_SDO_BV_03", "CO301_NMT_BV_01", "CO301_NMT_BV_03"
NMT = Purposes[NodeTester]("CO301_NMT", "slave", "CiA 301, 7.3.2", condition=("reset",), preamble=(BASIC,))
BEATS = ("heartbeat",)
STEPS = ((Command.START, State.OPERATIONAL), (Command.STOP, State.STOPPED), (Command.PRE_OPERATIONAL, State.PRE_OPERATIONAL))
EACH_STEP = (*STEPS[:2], STEPS[0], STEPS[2], STEPS[1], STEPS[2])  # from each state to each other one


def words(which: Command | State) -> str:
    """A command or state as the standard spells it."""
    return which.name.lower().replace("_", "-")


def entered(t: NodeTester, wanted: State, what: str) -> None:
    got = t.beat()
    if got != wanted:
        got = t.beat()  # one heartbeat may have been on its way
    if got != wanted:
        raise Fail(f"{what}: state {got}", f"state {wanted.value} ({words(wanted)})", str(got))


@NMT.case(
    "BV_01",
    "after reset node comes the boot-up message",
    "nach Reset Node kommt die Boot-up-Nachricht",
    clause="CiA 301, 7.2.8.3.3",
    beside=Particulars(limits="within [link] boot_ms, 10 s unless stated"),
)
def reset_node(t: NodeTester) -> None:
    _boots(t, Command.RESET_NODE, "reset node")


@NMT.case("BV_02", "after reset communication as well", "nach Reset Communication ebenso", clause="CiA 301, 7.2.8.3.3")
def reset_communication(t: NodeTester) -> None:
    _boots(t, Command.RESET_COMMUNICATION, "reset communication")


def _instead(t: NodeTester, since: int) -> str:
    """Frames that the node sent on the identifier of its boot-up message."""
    found = [frame for frame in t.heard[since:] if frame.identifier == cobid.heartbeat(t.setup.node)]
    return shown(found[0] if found else None)


def _boots(t: NodeTester, what: Command, words: str) -> None:
    since = len(t.heard)
    t.command(what)
    asked = t.asked_at
    frame = t.boot_up()
    if frame is None:
        raise Fail(f"no boot-up message after {words}", f"{cobid.heartbeat(t.setup.node):03X}h 00", _instead(t, since))
    t.timed(f"{words} to boot-up", frame.stamp_ns - asked, None, t.setup.boot)
    t.ready()


@NMT.case(
    "BV_03",
    "start, stop and enter pre-operational lead from each state to their own",
    "Start, Stop und Enter Pre-Operational führen aus jedem Zustand in ihren",
    condition=BEATS,
    preamble=(BASIC, WRITE),
)
def states(t: NodeTester) -> None:
    with t.beating():
        before = State.PRE_OPERATIONAL
        for command, state in EACH_STEP:
            t.command(command)
            entered(t, state, f"after {words(command)} in {words(before)}")
            before = state


@NMT.case("BV_04", "a command to node 0 is for all", "ein Befehl an Knoten 0 gilt allen", condition=BEATS, preamble=(BASIC, STATES))
def all_nodes(t: NodeTester) -> None:
    with t.beating():
        for command, state in STEPS:
            t.command(command, nmt.ALL_NODES)
            entered(t, state, f"after {words(command)} to all")


@NMT.case(
    "BV_05", "after boot-up it is pre-operational", "nach dem Hochlauf ist er pre-operational", condition=BEATS, preamble=(BASIC, BOOT)
)
def after_boot(t: NodeTester) -> None:
    with t.given():
        t.reset()
    got = t.state()
    if got == State.OPERATIONAL:
        raise Warn("it starts by itself (1F80h)", "state 127 (pre-operational)", str(got))
    if got != State.PRE_OPERATIONAL:
        raise Fail(f"state {got} after boot-up", "state 127 (pre-operational)", str(got))


@NMT.case(
    "BV_06",
    "reset communication forgets what was not stored",
    "Reset Communication vergisst, was nicht gespeichert ist",
    condition=BEATS,
    preamble=(BASIC, "CO301_NMT_BV_02", "CO301_SDO_BV_03"),
)
def forgets(t: NodeTester) -> None:
    with t.given():
        t.reset()
        before = t.number(HEARTBEAT)
        t.download(HEARTBEAT, before + 777, 2)
        t.reset(Command.RESET_COMMUNICATION)
    if (got := t.number(HEARTBEAT)) != before:
        raise Fail(f"1017h is still {got} after reset communication", str(before), str(got))


@NMT.case(
    "BI_01",
    "a command to another node has no effect",
    "ein Befehl an einen anderen Knoten wirkt nicht",
    condition=BEATS,
    preamble=(BASIC, STATES),
)
def other_node(t: NodeTester) -> None:
    with t.beating():
        for command in (Command.STOP, Command.START):
            t.command(command, t.setup.node % cobid.MAX_NODE + 1)
            t.pause(ms(5))
            entered(t, State.PRE_OPERATIONAL, f"after {words(command)} to another node")


@NMT.case("BI_02", "an unknown command has no effect", "ein unbekannter Befehl wirkt nicht", condition=BEATS, preamble=(BASIC, STATES))
def unknown(t: NodeTester) -> None:
    with t.beating():
        for data in (bytes((3, t.setup.node)), bytes((0x55, t.setup.node)), bytes((Command.STOP,))):
            t.say(cobid.NMT, data)
            t.pause(ms(5))
            entered(t, State.PRE_OPERATIONAL, f"after NMT {data.hex(' ').upper()}")


@NMT.case(
    "BO_01",
    "in state stopped no SDO is answered",
    "im Zustand Stopped wird kein SDO beantwortet",
    condition=BEATS,
    preamble=(BASIC, STATES),
)
def stopped(t: NodeTester) -> None:
    with t.stopped():
        t.say(cobid.sdo_request(t.setup.node), sdo.initiate(Request.INITIATE_UPLOAD, DEVICE_TYPE))
        t.silence(cobid.sdo_answer(t.setup.node), ms(100), "an SDO request in state stopped")


@NMT.case(
    "BO_02",
    "start while operational changes nothing",
    "Start im Zustand Operational ändert nichts",
    condition=BEATS,
    preamble=(BASIC, STATES),
)
def start_twice(t: NodeTester) -> None:
    with t.beating(), t.operational():
        t.command(Command.START)
        t.pause(ms(5))
        entered(t, State.OPERATIONAL, "after a second start")


@NMT.case("ST_01", "20 resets, a boot-up message after each", "20 Resets, nach jedem eine Boot-up-Nachricht", preamble=(BASIC, BOOT))
def resets(t: NodeTester) -> None:
    for turn in range(20):
        t.command(Command.RESET_COMMUNICATION if turn % 2 else Command.RESET_NODE)
        if t.boot_up() is None:
            raise Fail(f"no boot-up message after reset {turn + 1}", "a boot-up message", "nothing")
        t.ready()


TRC = Purposes[NodeTester]("CO301_TRC", "node", "CiA 301, 7.3.5", condition=("reset",), preamble=(BASIC, BOOT))


@TRC.case(
    "BV_01",
    "all it sends from reset to operational has a known identifier, a right length and a right range; no error frames",
    "alles von Reset bis Operational hat bekannte Kennungen, richtige Längen und Bereiche; keine Fehlerrahmen",
)
def tour(t: NodeTester) -> None:
    own = _own(t)
    t.command(Command.RESET_NODE)
    t.boot_up()
    t.ready()
    t.upload((0x1001, 0))
    with t.operational():
        for _ in range(5):
            t.sync()
            t.pause(t.setup.cycle)
    for frame in t.heard:
        identifier = frame.identifier & cobid.ID_BITS
        wanted = own.get(identifier)
        if wanted is None and _of_others(identifier, t.setup.node):
            t.remark(f"another node sends on {identifier:03X}h")
        elif wanted is None:
            raise Fail(f"it sends {shown(frame)}", "identifiers of this node", shown(frame))
        elif wanted and len(frame.data) not in wanted:
            raise Fail(f"{cobid.describe(identifier)} of {len(frame.data)} bytes", f"{' or '.join(map(str, wanted))} bytes", shown(frame))
        elif identifier == cobid.heartbeat(t.setup.node) and frame.data[0] not in (0, *(state.value for state in State)):
            raise Fail(f"heartbeat with state {frame.data[0]}", "0, 4, 5 or 127", shown(frame))
    if t.faults:
        raise Fail(f"{len(t.faults)} error frames", "none", ", ".join(fault.name.lower() for fault in t.faults))


def _own(t: NodeTester) -> dict[int, tuple[int, ...]]:
    """Identifier -> lengths; () any."""
    node = t.setup.node
    found: dict[int, tuple[int, ...]] = {cobid.heartbeat(node): (1,), cobid.sdo_answer(node): (8,), cobid.emcy(node): (8,), cobid.SYNC: ()}
    with t.given():
        for number in range(4):
            key = (0x1800 + number, 1)
            if t.exists(key):
                found[t.number(key) & cobid.ID_BITS] = ()
    return found


def _of_others(identifier: int, node: int) -> bool:
    """A node number of another device, in the predefined connection set."""
    return identifier & 0x7F not in (0, node) and identifier >= 0x81
