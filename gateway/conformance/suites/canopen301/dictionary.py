"""CANopen, the object dictionary: mandatory objects, statements of the EDS, missing objects (CiA 301, 7.4 and 7.5)."""

from gateway.conformance.suites.can.node import DEVICE_TYPE, IDENTITY, Aborted, NodeTester, named
from gateway.pure.conformance.purpose import Purposes
from gateway.pure.conformance.verdict import Fail, NotApplicable, Warn
from protocols.canopen import sdo
from protocols.canopen.dictionary import Access, Entry
from protocols.canopen.sdo import Abort, Request

BASIC, WRITE = "CO301_SDO_BV_01", "CO301_SDO_BV_03"
DIC = Purposes[NodeTester]("CO301_DIC", "server", "CiA 301, 7.4", preamble=(BASIC,))
OWN = 0x2000  # communication profile below
NO_INDEX = (0x1FF0, 0x5FFE, 0x9FF3)


def _sized(t: NodeTester, index: int, size: int) -> None:
    data = t.upload((index, 0))
    if len(data) != size:
        raise Fail(f"{index:04X}h has {len(data)} bytes", f"{size} bytes", data.hex(" ").upper())


@DIC.case("BV_01", "1000h device type has four bytes", "1000h Gerätetyp hat vier Bytes", clause="CiA 301, 7.5.2.1")
def device_type(t: NodeTester) -> None:
    _sized(t, 0x1000, 4)


@DIC.case("BV_02", "1001h error register has one byte", "1001h Fehlerregister hat ein Byte", clause="CiA 301, 7.5.2.2")
def error_register(t: NodeTester) -> None:
    _sized(t, 0x1001, 1)


@DIC.case(
    "BV_03",
    "1018h identity: 1 to 4 entries of four bytes, the vendor among them",
    "1018h Identität: 1 bis 4 Einträge zu vier Bytes, darunter der Hersteller",
    clause="CiA 301, 7.5.2.19",
)
def identity(t: NodeTester) -> None:
    count = t.number((IDENTITY, 0))
    if not 1 <= count <= 4:
        raise Fail(f"1018h:00 is {count}", "1 to 4", str(count))
    for sub in range(1, count + 1):
        try:
            size = len(t.upload((IDENTITY, sub)))
        except Aborted as refused:
            if sub == 1 or refused.code not in (Abort.NO_SUB, Abort.NO_OBJECT):
                raise
            continue
        if size != 4:
            raise Fail(f"1018h:{sub:02X} has {size} bytes", "4 bytes", f"{size} bytes")


def _entries(t: NodeTester) -> list[Entry]:
    assert t.setup.dictionary is not None, "the condition of the case is eds"
    return [entry for entry in t.setup.dictionary if entry.index >= 0x1000]


@DIC.case(
    "BV_04",
    "each readable entry of the EDS is there and has the size of its type",
    "jeder lesbare Eintrag des EDS ist vorhanden und hat die Länge seines Typs",
    condition=("eds",),
)
def as_in_the_eds(t: NodeTester) -> None:
    for entry in _entries(t):
        if not entry.access.readable:
            continue
        try:
            data = t.upload(entry.key)
        except Aborted as refused:
            if refused.code in (Abort.NO_DATA, Abort.DEVICE_STATE, Abort.NO_STORE):
                continue  # there, but without a value now (1003h beyond its count)
            raise
        if entry.type.size and len(data) != entry.type.size and not t.unsized:
            raise Fail(f"{entry} has {len(data)} bytes", f"{entry.type.size} bytes ({entry.type.name})", data.hex(" ").upper())


@DIC.case(
    "BV_05",
    "device type, vendor and product are those of the EDS",
    "Gerätetyp, Hersteller und Produkt sind die des EDS",
    condition=("eds",),
)
def same_device(t: NodeTester) -> None:
    for entry in _entries(t):
        if entry.key in (DEVICE_TYPE, (IDENTITY, 1), (IDENTITY, 2)) and isinstance(entry.default, int) and entry.default:
            got = t.number(entry.key)
            if got != entry.default:
                raise Fail(f"{entry} is {got:08X}h", f"{entry.default:08X}h, as in the EDS", f"{got:08X}h")


@DIC.case(
    "BV_06",
    "sub-index 0 of the identity is its highest sub-index",
    "Sub-Index 0 der Identität ist ihr höchster Sub-Index",
    preamble=(BASIC, "CO301_DIC_BV_03"),
)
def highest(t: NodeTester) -> None:
    with t.given():
        count = t.number((IDENTITY, 0))
    t.refused(
        sdo.initiate(Request.INITIATE_UPLOAD, (IDENTITY, count + 1)),
        (Abort.NO_SUB,),
        f"1018h:{count + 1:02X}",
        (Abort.NO_OBJECT, Abort.GENERAL),
    )


@DIC.case("BI_01", "an index that is not there: 06020000h", "ein fehlender Index: 06020000h", clause="CiA 301, table 22")
def no_index(t: NodeTester) -> None:
    known = t.setup.dictionary.heads if t.setup.dictionary is not None else {}
    index = next((index for index in NO_INDEX if index not in known), NO_INDEX[0])
    t.refused(sdo.initiate(Request.INITIATE_UPLOAD, (index, 0)), (Abort.NO_OBJECT,), f"{index:04X}h", (Abort.GENERAL,))


@DIC.case("BI_02", "a sub-index that is not there: 06090011h", "ein fehlender Sub-Index: 06090011h", clause="CiA 301, table 22")
def no_sub(t: NodeTester) -> None:
    t.refused(sdo.initiate(Request.INITIATE_UPLOAD, (IDENTITY, 0x77)), (Abort.NO_SUB,), "1018h:77", (Abort.NO_OBJECT, Abort.GENERAL))


@DIC.case(
    "BI_03",
    "a write to a constant: 06010002h",
    "Schreiben einer Konstante: 06010002h",
    clause="CiA 301, table 22",
    preamble=(BASIC, WRITE),
)
def constant(t: NodeTester) -> None:
    request = sdo.expedited(Request.INITIATE_DOWNLOAD, DEVICE_TYPE, bytes(4))
    t.refused(request, (Abort.READ_ONLY,), "a write to 1000h", (Abort.ACCESS, Abort.GENERAL))


@DIC.case(
    "BI_04",
    "a read of what is only written: 06010001h",
    "Lesen eines nur schreibbaren Eintrags: 06010001h",
    clause="CiA 301, table 22",
    condition=("eds",),
)
def write_only(t: NodeTester) -> None:
    found = [entry for entry in _entries(t) if entry.access is Access.WO]
    if not found:
        raise NotApplicable("the EDS has no write-only entry")
    for entry in found[:5]:
        request = sdo.initiate(Request.INITIATE_UPLOAD, entry.key)
        t.refused(request, (Abort.WRITE_ONLY,), f"a read of {named(entry.key)}", (Abort.ACCESS,))


@DIC.case(
    "BI_05",
    "a value beyond the limits of the EDS is refused, and changes nothing",
    "ein Wert jenseits der Grenzen des EDS wird abgelehnt und ändert nichts",
    clause="CiA 301, table 22",
    condition=("eds",),
)
def beyond(t: NodeTester) -> None:
    """Entries of the communication profile, and those that may be written; both limits."""
    steps = list[tuple[Entry, int]]()
    for entry in _entries(t):
        if entry.access.writable and entry.type.whole and (entry.index < OWN or entry.key in t.setup.touch):
            if entry.high is not None and int(entry.high) < entry.type.high:
                steps.append((entry, int(entry.high) + 1))
            if entry.low is not None and int(entry.low) > entry.type.low:
                steps.append((entry, int(entry.low) - 1))
    if not steps:
        raise NotApplicable("no entry that may be written has a limit")
    for entry, number in steps[:16]:
        with t.given():
            before = t.upload(entry.key)
        value = (number & ((1 << entry.type.bits) - 1)).to_bytes(entry.type.size, "little")
        code = Abort.TOO_HIGH if entry.high is not None and number > entry.high else Abort.TOO_LOW
        request = sdo.expedited(Request.INITIATE_DOWNLOAD, entry.key, value)
        t.refused(request, (code, Abort.VALUE), f"{value.hex(' ').upper()} to {entry}", (Abort.GENERAL, Abort.INCOMPATIBLE))
        if (after := t.upload(entry.key)) != before:
            raise Fail(f"{entry} was changed by a refused write", before.hex(" ").upper(), after.hex(" ").upper())


@DIC.case(
    "BI_06",
    "an index that is not there cannot be written either",
    "auch schreiben lässt sich ein fehlender Index nicht",
    clause="CiA 301, table 22",
    preamble=(BASIC, WRITE),
)
def write_to_nothing(t: NodeTester) -> None:
    request = sdo.expedited(Request.INITIATE_DOWNLOAD, (NO_INDEX[0], 0), b"\x01")
    t.refused(request, (Abort.NO_OBJECT,), f"a write to {NO_INDEX[0]:04X}h", (Abort.ACCESS, Abort.GENERAL))


@DIC.case("CA_01", "1008h, 1009h and 100Ah, where they are, are texts", "1008h, 1009h und 100Ah sind, wo es sie gibt, Texte")
def texts(t: NodeTester) -> None:
    for index in (0x1008, 0x1009, 0x100A):
        try:
            text = t.upload((index, 0))
        except Aborted:
            continue
        if any(byte < 0x20 and byte for byte in text):
            raise Warn(f"{index:04X}h contains characters that cannot be printed", "a VISIBLE_STRING", text.hex(" ").upper())
