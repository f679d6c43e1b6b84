"""CANopen, settings: effects of save and load, values lost by a reset, statements of the data sheet (CiA 301, 7.5.2.13)."""

from contextlib import suppress

from gateway.conformance.framework.base import hexed
from gateway.conformance.suites.can.node import HEARTBEAT, Aborted, NodeTester, named
from gateway.conformance.suites.canopen301.keep import KEPT, LOAD, SAVE, STORES, defaults
from gateway.conformance.suites.canopen301.pdo import RX, TX, mapping, offered_types
from gateway.pure.conformance.purpose import Purposes
from gateway.pure.conformance.verdict import Ended, Fail, NotApplicable
from protocols.canopen import cob_id as cobid
from protocols.canopen import sdo
from protocols.canopen.nmt import Command
from protocols.canopen.sdo import Abort, Request

BASIC, WRITE, BOOT, COMMUNICATION = "CO301_SDO_BV_01", "CO301_SDO_BV_03", "CO301_NMT_BV_01", "CO301_NMT_BV_02"
SETTINGS = Purposes[NodeTester](
    "CO301_STO", "server", "CiA 301, 7.5.2.13", condition=("reset", "heartbeat", *STORES), preamble=(BASIC, WRITE, BOOT, KEPT)
)
FORGETS = Purposes[NodeTester](
    "CO301_NMT", "slave", "CiA 301, 7.3.2.2.1", condition=("reset",), preamble=(BASIC, WRITE, COMMUNICATION, "CO301_NMT_BV_06")
)
SHEET = Purposes[NodeTester]("CO301_DIC", "server", "CiA 301, table 22", condition=("eds",), preamble=(BASIC, WRITE))
SERVER = Purposes[NodeTester]("CO301_DIC", "server", "CiA 301, 7.5.2.33", preamble=(BASIC,))
MAP, SYNC, TIME, OTHER_SYNC = 0x1A00, (0x1005, 0), (0x1012, 0), 0x6B4
PDOS = 8  # TPDOs that are looked at
Look = tuple[int, list[int]]  # transmission type and mapping of TPDO 1


def _look(t: NodeTester) -> Look:
    return t.number((TX, 2)), [part.word for part in mapping(t, MAP)]


def _store_another(t: NodeTester) -> tuple[Look, Look]:
    """TPDO 1 gets another type, and a shorter mapping where it can be changed; that is stored, and a reset follows: (before, stored)."""
    with t.given():
        t.reset()
        before, cob = _look(t), t.number((TX, 1))
        t.download((TX, 1), cob | cobid.INVALID, 4)
        offered = offered_types(t, TX, *(kind for kind in (255, 254, 1, 5) if kind != before[0]))
        shorter = bool(t.setup.pics.get("mapping")) and len(before[1]) > 1
        if shorter:
            t.download((MAP, 0), 0, 1)
            for sub, word in enumerate(before[1][:-1], 1):
                t.download((MAP, sub), word, 4)
            t.download((MAP, 0), len(before[1]) - 1, 1)
        t.download((TX, 1), cob, 4)
        if not offered and not shorter:
            raise NotApplicable("TPDO 1 can be set in one way only")
        stored = _look(t)
        t.download((0x1010, 1), SAVE, 4)
        t.reset()
    return before, stored


def _judge(t: NodeTester, wanted: Look, what: str) -> None:
    kind, words = _look(t)
    if kind != wanted[0]:
        raise Fail(f"1800h:02 is {kind} {what}", str(wanted[0]), str(kind))
    if words != wanted[1]:
        expected, got = (" ".join(f"{word:08X}h" for word in each) or "no entries" for each in (wanted[1], words))
        raise Fail(f"1A00h has other entries {what}", expected, got)


@SETTINGS.case(
    "BV_03",
    "stored settings of TPDO 1 are there after a reset: type and mapping",
    "gespeicherte Einstellungen des TPDO 1 sind nach einem Reset da: Art und Mapping",
    condition=("tpdo_setup",),
)
def tpdo_saved(t: NodeTester) -> None:
    with defaults(t):
        _, stored = _store_another(t)
        _judge(t, stored, "after save and reset")


@SETTINGS.case(
    "BV_04",
    "load sets the settings of TPDO 1 back as well",
    "auch die Einstellungen des TPDO 1 stellt load wieder her",
    clause="CiA 301, 7.5.2.14",
    condition=("tpdo_setup",),
    preamble=(BASIC, WRITE, BOOT, KEPT, "CO301_STO_BV_02", "CO301_STO_BV_03"),
)
def tpdo_restored(t: NodeTester) -> None:
    with defaults(t):
        before, stored = _store_another(t)
        with t.given():
            _judge(t, stored, "after save and reset")
            t.download((0x1011, 1), LOAD, 4)
            t.reset()
        _judge(t, before, "after load and reset")


@SETTINGS.case("BV_05", "a second save replaces the first one", "ein zweites Speichern ersetzt das erste")
def saved_twice(t: NodeTester) -> None:
    with defaults(t):
        with t.given():
            for value in (4321, 2345):
                t.download(HEARTBEAT, value, 2)
                t.download((0x1010, 1), SAVE, 4)
            t.reset()
        if (got := t.number(HEARTBEAT)) != 2345:
            raise Fail(f"1017h is {got} after 4321 was saved, then 2345", "2345", str(got))


@FORGETS.case(
    "BV_10",
    "reset communication sets RPDO 1 and the identifier of SYNC back",
    "Reset Communication setzt RPDO 1 und die Kennung von SYNC zurück",
    condition=("rpdo_setup",),
)
def sets_back(t: NodeTester) -> None:
    with t.given():
        t.reset()
        cob, kind = t.number((RX, 1)), t.number((RX, 2))
        sync = t.number(SYNC) if t.setup.pics.get("sync") else None
        t.download((RX, 1), cob | cobid.INVALID, 4)
        offered_types(t, RX, *(number for number in (255, 254, 1) if number != kind))
    if sync is not None:
        with suppress(Aborted):
            t.download(SYNC, OTHER_SYNC, 4)
    with t.given():
        t.reset(Command.RESET_COMMUNICATION)
    for key, wanted in (((RX, 1), cob), ((RX, 2), kind), (SYNC, sync)):
        if wanted is not None and (got := t.number(key)) != wanted:
            t.reset()
            raise Fail(f"{named(key)} is kept over reset communication", f"{wanted:X}h", f"{got:X}h")


@SERVER.case("BV_07", "1200h, where it is, names the identifiers of its SDO", "1200h nennt, wo es vorhanden ist, die Kennungen seines SDO")
def own_server(t: NodeTester) -> None:
    found = False
    for sub, wanted in ((1, cobid.sdo_request(t.setup.node)), (2, cobid.sdo_answer(t.setup.node))):
        if not t.exists((0x1200, sub)):
            continue
        found = True
        if (got := t.number((0x1200, sub))) != wanted:
            raise Fail(f"1200h:{sub:02X} is {got:X}h", f"{wanted:X}h, on which it is requested or answers", f"{got:X}h")
    if not found:
        raise NotApplicable("there is no 1200h")


@SERVER.case(
    "BV_08",
    "what it sends has identifiers of its own: none of them is that of SYNC, TIME or NMT, no two are the same",
    "was es sendet, hat eigene Kennungen: keine ist die von SYNC, TIME oder NMT, keine zwei sind gleich",
    clause="CiA 301, 7.3.5",
)
def own_identifiers(t: NodeTester) -> None:
    """Of a PDO or an emergency that is valid."""
    taken = {0: "NMT"}
    for key, name in ((SYNC, "SYNC"), (TIME, "TIME")):
        if t.exists(key):
            taken.setdefault(t.number(key) & cobid.ID_BITS, f"{name} ({named(key)})")
    for key in ((0x1014, 0), *((TX + number, 1) for number in range(PDOS))):
        if not t.exists(key) or (word := t.number(key)) & cobid.INVALID:
            continue
        identifier = word & cobid.ID_BITS
        other = taken.get(identifier)
        if other is not None:
            raise Fail(f"{named(key)} has the identifier of {other}: {identifier:03X}h", "an identifier of its own", f"{word:08X}h")
        if cobid.sdo_answer(t.setup.node) == identifier or cobid.heartbeat(t.setup.node) == identifier:
            raise Fail(
                f"{named(key)} has the identifier of SDO or heartbeat: {identifier:03X}h", "an identifier of its own", f"{word:08X}h"
            )
        taken[identifier] = named(key)


@SHEET.case(
    "BI_08",
    "what the EDS states as read-only cannot be written: its own value is refused",
    "was im EDS nur lesbar ist, lässt sich nicht schreiben: der eigene Wert wird abgelehnt",
)
def read_only(t: NodeTester) -> None:
    assert t.setup.dictionary is not None, "the condition of the case is eds"
    for entry in t.setup.dictionary:
        if entry.index < 0x1000 or entry.access.writable or not entry.access.readable or not 1 <= entry.type.size <= 4:
            continue
        try:
            held = t.upload(entry.key)
        except Ended:
            continue  # judged by BV_04
        request = sdo.expedited(Request.INITIATE_DOWNLOAD, entry.key, held[:4])
        got = t.ask(request)
        if got[:1] != b"\x80":
            raise Fail(
                f"{entry} accepts a write, the EDS states it as {entry.access.name.lower()}", "an abort", hexed(got) if got else "silence"
            )
        if sdo.abort_of(got).code == Abort.NO_OBJECT:
            raise Fail(f"{entry}: a write is refused as if it did not exist", "06010002h", hexed(got))
