"""The supply of a CANopen device fails and returns: it boots on its own, and unsaved values are lost."""

from gateway.conformance.framework.base import hexed
from gateway.conformance.suites.can.node import HEARTBEAT, NodeTester
from gateway.conformance.suites.can.tester import shown
from gateway.conformance.suites.canopen301.keep import SAVE, STORES, defaults
from gateway.pure.conformance.purpose import Purposes
from gateway.pure.conformance.verdict import Fail, Warn
from protocols.base.machine import ms
from protocols.canopen import cob_id as cobid
from protocols.canopen import nmt

SUP = Purposes[NodeTester]("CO301_SUP", "device", "CiA 301, 7.3.2.2.1", condition=("power",), preamble=("CO301_SDO_BV_01",))
PRE_OPERATIONAL, OPERATIONAL = 0x7F, 0x05
ODD = 777


@SUP.case(
    "RC_01",
    "after power-on it sends one boot-up message and is pre-operational",
    "nach dem Einschalten sendet es eine Boot-up-Nachricht und ist Pre-operational",
    condition=("heartbeat",),
)
def boots(t: NodeTester) -> None:
    t.command(nmt.Command.START)
    t.pause(ms(5))
    t.power.turn(False)
    t.pause(ms(1000))
    t.drain()
    t.power.turn(True)
    if t.boot_up(max(t.setup.boot, t.power.back)) is None:
        raise Fail("no boot-up message after power-on", f"{cobid.heartbeat(t.setup.node):03X}h 00", "nothing")
    again = [one for one in t.pause(ms(500)) if one.identifier == cobid.heartbeat(t.setup.node) and one.data == b"\0"]
    if again:
        raise Fail("it boots twice", "one boot-up message", shown(again[0]))
    t.ready()
    if (state := t.state()) & 0x7F == OPERATIONAL:
        raise Warn("it starts by itself (1F80h)", "7Fh: pre-operational", f"{state:02X}h")
    if state & 0x7F != PRE_OPERATIONAL:
        raise Fail(f"state {state:02X}h after power-on", "7Fh: pre-operational", f"{state:02X}h")


@SUP.case(
    "RC_02",
    "a value that was not stored is lost with the supply",
    "ein nicht gespeicherter Wert geht mit der Versorgung verloren",
    condition=("heartbeat",),
)
def forgets(t: NodeTester) -> None:
    with t.given():
        before = t.upload(HEARTBEAT)
        t.download(HEARTBEAT, ODD, len(before))
    t.power.cycle()
    if t.boot_up(max(t.setup.boot, t.power.back)) is None:
        t.remark("no boot-up message was received after power-on")
    t.ready()
    got = t.upload(HEARTBEAT)
    if int.from_bytes(got, "little") == ODD:
        t.download(HEARTBEAT, int.from_bytes(before, "little"), len(before))
        raise Fail(f"1017h is still {ODD} after power-off, without 1010h", hexed(before), hexed(got))


@SUP.case(
    "RC_03",
    "a value that was stored (1010h) survives the supply",
    "ein gespeicherter Wert (1010h) übersteht den Ausfall der Versorgung",
    clause="CiA 301, 7.5.2.13",
    condition=("heartbeat", *STORES),
    preamble=("CO301_SDO_BV_01", "CO301_STO_BV_01"),
)
def remembers(t: NodeTester) -> None:
    with defaults(t):
        with t.given():
            t.download(HEARTBEAT, ODD, 2)
            t.download((0x1010, 1), SAVE, 4)
        t.power.cycle()
        if t.boot_up(max(t.setup.boot, t.power.back)) is None:
            t.remark("no boot-up message was received after power-on")
        t.ready()
        if (got := t.number(HEARTBEAT)) != ODD:
            raise Fail(f"1017h is {got} after 1010h and power-off", f"{ODD}, as stored", str(got))
