"""CANopen, store and restore (1010h, 1011h) and layer setting services (CiA 301, 7.5.2.13, 7.5.2.14; CiA 305)."""

from collections.abc import Iterator
from contextlib import contextmanager, suppress

from gateway.conformance.framework.base import hexed
from gateway.conformance.suites.can.node import HEARTBEAT, IDENTITY, NodeTester
from gateway.conformance.suites.can.tester import shown
from gateway.pure.conformance.purpose import Purposes
from gateway.pure.conformance.verdict import Ended, Fail, Inconclusive
from protocols.base.machine import ms
from protocols.canopen import cob_id as cobid
from protocols.canopen import lss, sdo
from protocols.canopen.lss import Mode, Service
from protocols.canopen.nmt import Command
from protocols.canopen.sdo import Abort, Request

BASIC, WRITE, BOOT = "CO301_SDO_BV_01", "CO301_SDO_BV_03", "CO301_NMT_BV_01"
STO = Purposes[NodeTester]("CO301_STO", "server", "CiA 301, 7.5.2.13", condition=("reset", "heartbeat"), preamble=(BASIC, WRITE, BOOT))
SAVE, LOAD = 0x65766173, 0x64616F6C
WRONG = (Abort.NO_STORE, Abort.LOCAL_CONTROL, Abort.DEVICE_STATE)
STORES = ("store", "restore", "may_store")
KEPT = "CO301_STO_BV_01"


@contextmanager
def defaults(t: NodeTester) -> Iterator[None]:
    """Restore the default of what was stored within the block."""
    try:
        yield
    finally:
        with suppress(Ended):
            t.download((0x1011, 1), LOAD, 4)
            t.reset()


@STO.case("BV_01", "what was saved is there after a reset", "was gespeichert wurde, ist nach einem Reset da", condition=STORES)
def saved(t: NodeTester) -> None:
    with defaults(t):
        t.download(HEARTBEAT, 4321, 2)
        t.download((0x1010, 1), SAVE, 4)
        with t.given():
            t.reset()
        if (got := t.number(HEARTBEAT)) != 4321:
            raise Fail(f"1017h is {got} after save and reset", "4321", str(got))


@STO.case(
    "BV_02",
    "restored defaults are there after the next reset, not before",
    "wiederhergestellte Vorgaben gelten nach dem nächsten Reset, nicht vorher",
    clause="CiA 301, 7.5.2.14",
    condition=STORES,
    preamble=(BASIC, WRITE, BOOT, KEPT),
)
def restored(t: NodeTester) -> None:
    with defaults(t):
        with t.given():
            t.reset()
            factory = t.number(HEARTBEAT)
            stored = 4321 if factory != 4321 else 5432  # 4321 is left over from an earlier load without effect
            t.download(HEARTBEAT, stored, 2)
            t.download((0x1010, 1), SAVE, 4)
        t.download((0x1011, 1), LOAD, 4)
        if (got := t.number(HEARTBEAT)) != stored:
            raise Fail(f"1017h is {got} at once after load", f"{stored} until the reset", str(got))
        with t.given():
            t.reset()
        if (got := t.number(HEARTBEAT)) != factory:
            raise Fail(f"1017h is {got} after load and reset", str(factory), str(got))


def _signature(number: int, index: int, item: str) -> None:
    @STO.case(
        f"BI_{number:02}",
        f"{index:04X}h:01 with a wrong signature is refused: 0800002xh",
        f"{index:04X}h:01 mit falscher Signatur wird abgelehnt: 0800002xh",
        condition=(item,),
        preamble=(BASIC, WRITE),
    )
    def body(t: NodeTester) -> None:
        request = sdo.expedited(Request.INITIATE_DOWNLOAD, (index, 1), b"evil")
        t.refused(request, WRONG, f'"evil" to {index:04X}h:01', (Abort.GENERAL, Abort.VALUE))


_signature(1, 0x1010, "store")
_signature(2, 0x1011, "restore")

# ---- layer setting services
LSS = Purposes[NodeTester]("CO301_LSS", "slave", "CiA 305", condition=("lss",), preamble=(BASIC,))
SELECTED = "CO301_LSS_BV_01"
ANSWER = ms(200)


def _ask(t: NodeTester, service: Service, number: int = 0) -> bytes:
    t.say(cobid.LSS_MASTER, lss.request(service, number).data)
    frame = t.hear((cobid.LSS_SLAVE,), ANSWER)
    return b"" if frame is None else frame.data


def _address(t: NodeTester) -> lss.Identity:
    with t.given():
        return lss.Identity(*(t.number((IDENTITY, sub)) for sub in (1, 2, 3, 4)))


def _select(t: NodeTester, address: lss.Identity) -> bytes:
    got = b""
    for service, number in zip(range(Service.SELECT_VENDOR, Service.SELECT_SERIAL + 1), address, strict=True):
        t.say(cobid.LSS_MASTER, lss.request(Service(service), number).data)
        if service != Service.SELECT_SERIAL:
            t.pause(ms(1))
    frame = t.hear((cobid.LSS_SLAVE,), ANSWER)
    if frame is not None:
        got = frame.data
    return got


def _waiting(t: NodeTester) -> None:
    t.say(cobid.LSS_MASTER, lss.request(Service.SWITCH_GLOBAL, Mode.WAITING).data)
    t.pause(ms(5))


@contextmanager
def _configuring(t: NodeTester) -> Iterator[lss.Identity]:
    """Selected by its address within the block."""
    address = _address(t)
    with t.given():
        got = _select(t, address)
        if got[:1] != bytes((Service.SELECTED,)):
            raise Fail("not selected by its address", "44h", hexed(got))
    try:
        yield address
    finally:
        _waiting(t)


@LSS.case(
    "BV_01",
    "switch selective with its identity is answered with 44h",
    "Switch Selective mit seiner Identität wird mit 44h beantwortet",
    clause="CiA 305, 3.9.3",
)
def selected(t: NodeTester) -> None:
    address = _address(t)
    try:
        got = _select(t, address)
        if len(got) != 8 or got[0] != Service.SELECTED:
            raise Fail("switch selective with the identity of 1018h", "44h and seven bytes", hexed(got))
    finally:
        _waiting(t)


@LSS.case("BV_02", "it reports its identity as 1018h does", "es nennt seine Identität wie 1018h", preamble=(BASIC, SELECTED))
def inquired(t: NodeTester) -> None:
    with _configuring(t) as address:
        for service, wanted in zip(range(Service.INQUIRE_VENDOR, Service.INQUIRE_SERIAL + 1), address, strict=True):
            got = _ask(t, Service(service))
            if len(got) != 8 or got[0] != service or lss.number_of(got) != wanted:
                raise Fail(f"LSS {service:02X}h", f"{service:02X}h {wanted:08X}h", hexed(got))


@LSS.case("BV_03", "it reports its node number", "es nennt seine Knotennummer", preamble=(BASIC, SELECTED))
def node_number(t: NodeTester) -> None:
    with _configuring(t):
        got = _ask(t, Service.INQUIRE_NODE)
        if len(got) != 8 or got[0] != Service.INQUIRE_NODE or got[1] != t.setup.node:
            raise Fail("LSS inquire node-ID", f"5Eh {t.setup.node:02X}h", hexed(got))


@LSS.case(
    "BV_04",
    "a new node number counts after reset communication",
    "eine neue Knotennummer gilt nach Reset Communication",
    condition=("may_number", "reset"),
    preamble=(BASIC, SELECTED, "CO301_NMT_BV_02"),
)
def new_number(t: NodeTester) -> None:
    before, after = t.setup.node, t.setup.node % 100 + 11
    try:
        with _configuring(t):
            got = _ask(t, Service.CONFIGURE_NODE, after)
            if len(got) != 8 or got[:2] != bytes((Service.CONFIGURE_NODE, lss.OK)):
                raise Fail(f"LSS configure node-ID {after}", "11h 00h", hexed(got))
        t.command(Command.RESET_COMMUNICATION)
        frame = t.hear((cobid.heartbeat(after), cobid.heartbeat(before)), t.setup.boot)
        if frame is None or frame.identifier != cobid.heartbeat(after):
            raise Fail(f"after reset communication node {after} does not boot", f"{cobid.heartbeat(after):03X}h 00", shown(frame))
        t.setup.node = after
    finally:
        _number_back(t, before)


def _number_back(t: NodeTester, node: int) -> None:
    if t.setup.node == node:
        return
    with suppress(Ended):
        t.ready()  # its identity is read by SDO
        with _configuring(t):
            _ask(t, Service.CONFIGURE_NODE, node)
    t.command(Command.RESET_COMMUNICATION)
    t.setup.node = node
    if t.boot_up() is None:
        raise Inconclusive(f"node {node} did not respond again", "a boot-up message", "nothing")
    t.ready()


@LSS.case("BV_05", "identify remote slave with ranges that hold its identity: 4Fh", "Identify Remote Slave mit passenden Bereichen: 4Fh")
def identified(t: NodeTester) -> None:
    own = _address(t)
    for numbers, wanted in (
        ((*own[:2], *(own.revision, own.revision), *(own.serial, own.serial)), True),
        ((*own[:2], *(0, 0xFFFFFFFF), *(0, 0xFFFFFFFF)), True),
        ((own.vendor, own.product ^ 1, 0, 0xFFFFFFFF, 0, 0xFFFFFFFF), False),
    ):
        for service, number in zip(range(Service.IDENTIFY_VENDOR, Service.IDENTIFY_SERIAL_HIGH + 1), numbers, strict=True):
            t.say(cobid.LSS_MASTER, lss.request(Service(service), number).data)
            if service != Service.IDENTIFY_SERIAL_HIGH:
                t.pause(ms(1))
        frame = t.hear((cobid.LSS_SLAVE,), ANSWER)
        got = frame is not None and frame.data[:1] == bytes((Service.IDENTIFIED,))
        if got is not wanted:
            raise Fail("identify remote slave", "4Fh" if wanted else "nothing", shown(frame))


@LSS.case(
    "BI_01", "with another identity it is not selected", "mit einer anderen Identität wird es nicht gewählt", preamble=(BASIC, SELECTED)
)
def another(t: NodeTester) -> None:
    own = _address(t)
    try:
        for wrong in (
            own._replace(serial=own.serial ^ 1),
            own._replace(vendor=own.vendor ^ 1),
            own._replace(revision=own.revision ^ 0x10000),
        ):
            got = _select(t, wrong)
            if got:
                raise Fail("selected with another identity", "nothing", hexed(got))
    finally:
        _waiting(t)


@LSS.case("BI_02", "node numbers 0 and 128 are refused", "die Knotennummern 0 und 128 werden abgelehnt", preamble=(BASIC, SELECTED))
def bad_number(t: NodeTester) -> None:
    with _configuring(t):
        for number in (0, 128):
            got = _ask(t, Service.CONFIGURE_NODE, number)
            if len(got) != 8 or got[0] != Service.CONFIGURE_NODE or not got[1]:
                raise Fail(f"LSS configure node-ID {number}", "11h and an error code", hexed(got))


@LSS.case("BI_03", "a reserved bit rate is refused", "eine reservierte Bitrate wird abgelehnt", preamble=(BASIC, SELECTED))
def bad_rate(t: NodeTester) -> None:
    with _configuring(t):
        t.say(cobid.LSS_MASTER, lss.configure_bit_timing(5).data)
        frame = t.hear((cobid.LSS_SLAVE,), ANSWER)
        if frame is None or len(frame.data) != 8 or frame.data[0] != Service.CONFIGURE_BIT_TIMING or not frame.data[1]:
            raise Fail("LSS bit timing with table entry 5", "13h and an error code", shown(frame))


@LSS.case("BO_01", "while it waits nothing is configured", "solange es wartet, wird nichts konfiguriert", preamble=(BASIC, SELECTED))
def not_selected(t: NodeTester) -> None:
    _waiting(t)
    got = _ask(t, Service.CONFIGURE_NODE, t.setup.node) or _ask(t, Service.INQUIRE_NODE)
    if got:
        raise Fail("a configuring service is answered without being selected", "nothing", hexed(got))
