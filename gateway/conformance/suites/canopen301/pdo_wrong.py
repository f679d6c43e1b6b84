"""CANopen, PDO parameters: mapping by its rules, and required refusals (CiA 301, 7.5.2.35 to 7.5.2.38)."""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress

from gateway.conformance.suites.can.node import NodeTester
from gateway.conformance.suites.canopen301.pdo import SENDS, TX, mapping, synced, transmission
from gateway.pure.conformance.purpose import Purposes
from gateway.pure.conformance.verdict import Ended, Fail, NotApplicable
from protocols.canopen import cob_id as cobid
from protocols.canopen import pdo, sdo
from protocols.canopen.sdo import Abort, Request

BASIC, WRITE, FIRST = "CO301_SDO_BV_01", "CO301_SDO_BV_03", "CO301_PDO_BV_01"
RULES = Purposes[NodeTester]("CO301_PDO", "slave", "CiA 301, 7.5.2.35", preamble=(BASIC, WRITE))
MAP = 0x1A00
MAPS = (*SENDS, "mapping")
STATE_CODES = (Abort.ACCESS, Abort.DEVICE_STATE, Abort.READ_ONLY)
MAP_CODES = (Abort.NOT_MAPPABLE, Abort.NO_OBJECT, Abort.NO_SUB)
OTHERS = (Abort.GENERAL, Abort.LOCAL_CONTROL, Abort.NO_STORE, Abort.VALUE, Abort.INCOMPATIBLE)


def write(key: tuple[int, int], value: int, size: int) -> bytes:
    return sdo.expedited(Request.INITIATE_DOWNLOAD, key, value.to_bytes(size, "little"))


def mapped_back(t: NodeTester, cob: int, parts: Sequence[pdo.Mapped]) -> None:
    """TPDO 1 as it was."""
    for key, value, size in (
        ((TX, 1), cob | cobid.INVALID, 4),
        ((MAP, 0), 0, 1),
        *(((MAP, sub), part.word, 4) for sub, part in enumerate(parts, 1)),
        ((MAP, 0), len(parts), 1),
        ((TX, 1), cob, 4),
    ):
        with suppress(Ended):
            t.download(key, value, size)


@contextmanager
def opened(t: NodeTester) -> Iterator[list[pdo.Mapped]]:
    """TPDO 1 invalid, with an empty mapping; restored afterwards."""
    with t.given():
        cob, parts = t.number((TX, 1)), mapping(t, MAP)
        t.download((TX, 1), cob | cobid.INVALID, 4)
        t.download((MAP, 0), 0, 1)
    try:
        yield parts
    finally:
        mapped_back(t, cob, parts)


@RULES.case(
    "BV_11",
    "a new mapping: not valid, no entries, entries, count, valid; the TPDO then has its length",
    "ein neues Mapping: ungültig, keine Einträge, Einträge, Anzahl, gültig; das TPDO hat dann dessen Länge",
    condition=MAPS,
    preamble=(BASIC, WRITE, FIRST),
)
def remapped(t: NodeTester) -> None:
    with t.given():
        cob = t.number((TX, 1))
    with opened(t) as parts:
        if not parts:
            raise NotApplicable("TPDO 1 carries nothing")
        t.download((MAP, 1), parts[-1].word, 4)
        t.download((MAP, 0), 1, 1)
        with t.given():
            if t.number((MAP, 0)) != 1 or t.number((MAP, 1)) != parts[-1].word:
                raise Fail("1A00h does not hold what was written", "one entry", "another")
            t.download((TX, 1), cob & ~cobid.INVALID, 4)
        with transmission(t, 1) as identifier:
            frames = synced(t, identifier, 2)[1]
    size = (parts[-1].bits + 7) // 8
    got = len(frames[0].data) if frames else 0
    if got != size:
        raise Fail(f"the TPDO has {got} bytes after its mapping was changed", f"{size} bytes", f"{got} bytes")


@RULES.case(
    "BI_02",
    "a mapping cannot be changed while it has entries",
    "ein Mapping mit Einträgen lässt sich nicht ändern",
    condition=MAPS,
    preamble=(BASIC, WRITE),
)
def while_counted(t: NodeTester) -> None:
    with t.given():
        cob, parts = t.number((TX, 1)), mapping(t, MAP)
    if len(parts) < 2:
        raise NotApplicable("TPDO 1 carries fewer than two objects")
    with t.kept((TX, 1)):
        for identifier, what in ((cob & ~cobid.INVALID, "valid"), (cob | cobid.INVALID, "not valid")):
            with t.given():
                t.download((TX, 1), identifier, 4)
            try:
                t.refused(write((MAP, 1), parts[1].word, 4), STATE_CODES, f"an entry of a mapping with entries (TPDO 1 {what})", OTHERS)
            finally:
                mapped_back(t, identifier, parts)


@RULES.case(
    "BI_03",
    "an object that is not there cannot be mapped",
    "ein fehlendes Objekt lässt sich nicht mappen",
    condition=MAPS,
    preamble=(BASIC, WRITE),
)
def no_object(t: NodeTester) -> None:
    with opened(t):
        _mapped(t, 0x5FFE_0008, "5FFEh")


@RULES.case(
    "BI_04",
    "an object that must not be mapped is refused: 06040041h",
    "ein nicht mappbares Objekt wird abgelehnt: 06040041h",
    condition=MAPS,
    preamble=(BASIC, WRITE),
)
def not_mappable(t: NodeTester) -> None:
    with opened(t):
        _mapped(t, 0x1018_0120, "1018h:01")


def _mapped(t: NodeTester, word: int, what: str) -> None:
    """Refused with the entry, or with the count."""
    got = t.ask(write((MAP, 1), word, 4))
    if got[:1] == b"\x60":
        got = t.ask(write((MAP, 0), 1, 1))
    t.judge_refusal(got, MAP_CODES, f"the mapping of {what}", OTHERS)


@RULES.case(
    "BI_05",
    "more than 64 bits are refused: 06040042h",
    "mehr als 64 Bits werden abgelehnt: 06040042h",
    condition=MAPS,
    preamble=(BASIC, WRITE),
)
def too_long(t: NodeTester) -> None:
    with opened(t) as parts:
        widest = max(parts, key=lambda part: part.bits, default=None)
        if widest is None or widest.bits < 8:
            raise NotApplicable("TPDO 1 carries nothing to repeat")
        count = 64 // widest.bits + 1
        with t.given():
            if not t.exists((MAP, count)):
                raise NotApplicable(f"1A00h has no sub-index {count}")
        got = b"\x60"
        for sub in range(1, count + 1):
            got = t.ask(write((MAP, sub), widest.word, 4))
            if got[:1] != b"\x60":
                break
        if got[:1] == b"\x60":
            got = t.ask(write((MAP, 0), count, 1))
        t.judge_refusal(got, (Abort.MAPPED_LENGTH,), f"a mapping of {count * widest.bits} bits", (*OTHERS, Abort.NOT_MAPPABLE))


@RULES.case(
    "BI_06",
    "a reserved transmission type is refused",
    "eine reservierte Übertragungsart wird abgelehnt",
    condition=("tpdo", "tpdo_setup"),
    preamble=(BASIC, WRITE),
)
def reserved(t: NodeTester) -> None:
    with t.kept((TX, 1), (TX, 2)) as before:
        with t.given():
            t.download((TX, 1), before[0] | cobid.INVALID, 4)
        for value in (241, 251):
            t.refused(write((TX, 2), value, 1), (Abort.VALUE, Abort.TOO_HIGH), f"transmission type {value}", OTHERS)


@RULES.case(
    "BI_07",
    "the identifier of a valid PDO cannot be changed",
    "die Kennung eines gültigen PDO lässt sich nicht ändern",
    condition=("tpdo", "tpdo_setup"),
    preamble=(BASIC, WRITE),
)
def valid_identifier(t: NodeTester) -> None:
    with t.kept((TX, 1)) as before:
        with t.given():
            t.download((TX, 1), before[0] & ~cobid.INVALID, 4)
        wrong = before[0] & ~cobid.INVALID & ~cobid.ID_BITS | 0x6B1
        try:
            t.refused(write((TX, 1), wrong, 4), (Abort.VALUE, *STATE_CODES), "another identifier for a valid TPDO", OTHERS)
        finally:
            with suppress(Ended):
                t.download((TX, 1), before[0] | cobid.INVALID, 4)


@RULES.case(
    "BI_08",
    "a restricted identifier is refused",
    "eine gesperrte Kennung wird abgelehnt",
    clause="CiA 301, 7.3.5",
    condition=("tpdo", "tpdo_setup"),
    preamble=(BASIC, WRITE),
)
def restricted(t: NodeTester) -> None:
    with t.kept((TX, 1)) as before:
        with t.given():
            t.download((TX, 1), before[0] | cobid.INVALID, 4)
        for identifier in (0x000, 0x581, 0x601, 0x701):
            t.refused(write((TX, 1), 0x4000_0000 | identifier, 4), (Abort.VALUE,), f"identifier {identifier:03X}h for a TPDO", OTHERS)


@RULES.case(
    "BI_09",
    "the SYNC counter takes 0 and 2 to 240",
    "der SYNC-Zähler nimmt 0 und 2 bis 240",
    clause="CiA 301, 7.5.2.20",
    condition=("sync_counter",),
    preamble=(BASIC, WRITE),
)
def counter(t: NodeTester) -> None:
    with t.kept((0x1019, 0)):
        try:
            t.download((0x1019, 0), 10, 1)
        except Fail as refused:
            raise NotApplicable(f"1019h cannot be changed ({refused.got})") from refused
        for value in (1, 241):
            t.refused(write((0x1019, 0), value, 1), (Abort.VALUE, Abort.TOO_HIGH, Abort.TOO_LOW), f"{value} to 1019h", OTHERS)


@RULES.case(
    "BI_10",
    "SYNC with a byte too many, or without its counter, starts nothing",
    "SYNC mit einem Byte zu viel oder ohne seinen Zähler löst nichts aus",
    clause="CiA 301, 7.2.5.3.1",
    condition=(*SENDS, "sync_counter"),
    preamble=(BASIC, WRITE, FIRST),
)
def sync_length(t: NodeTester) -> None:

    with transmission(t, 1) as identifier:
        t.sync(b"\x01\x02")
        frames = [frame for frame in t.pause(t.setup.cycle) if frame.identifier == identifier]
        if frames:
            raise Fail("a TPDO after a SYNC of two bytes", "nothing", "a TPDO")
    t.reset()
