"""CANopen: axisgate's emulated drive with one fault each in its communication half, and correct devices unlike it."""

from collections.abc import Callable

from drivers.emulator.canopen.objects import OK
from drivers.emulator.servo.settings import DriveSettings
from gateway.conformance.peers.can_devices import NODE, QUICK, Drive, Says, Tune
from gateway.conformance.peers.canopen301_frames import (
    abort_code,
    all_used,
    answers,
    beats,
    chatty,
    commands,
    deaf,
    each_50th,
    fixed_identifier,
    general,
    lss_answers,
    no_toggle,
    on,
    other_number,
    short_taken,
    stuck_contents,
    sub_for_index,
    tires,
    toggle_zero,
    unknown_unheard,
    when,
)
from gateway.conformance.peers.canopen301_history import Shifted
from gateway.conformance.peers.canopen301_parts import (
    KeepsUnsaved,
    Late,
    LosesStored,
    NoBootAtPower,
    always_operational,
    always_valid,
    any_number,
    any_serial,
    any_signature,
    beat_times,
    beats_on,
    configures_always,
    consumer,
    count_free,
    each_sync,
    entries_free,
    first_rpdo,
    history_stays,
    inhibit_ignored,
    kept_rpdos,
    life_never,
    mapping_free,
    never_resets,
    no_store,
    number_ignored,
    reports_once,
    restores_at_once,
    restores_nothing,
    rpdo_at_once,
    served_when_stopped,
    sets_too,
    shows_register,
    stays,
    stays_stopped,
    toggle_stays,
    unchecked,
)
from gateway.conformance.peers.canopen301_servers import (
    AnswersAborts,
    AnyBlock,
    AnySize,
    BigBlocks,
    HangsInBlocks,
    Holds,
    NoCrcCheck,
    NoRepeat,
    NoToggleCheck,
    server,
)
from gateway.conformance.peers.canopen301_settings import SETTINGS, takes_constants
from gateway.conformance.peers.canopen301_states import (
    any_entry_length,
    any_heartbeat,
    beats_toggle,
    boots_twice,
    coarse_beats,
    crc_always,
    emergencies_never_off,
    emergencies_unhindered,
    expedited_only,
    guards_as_before,
    keeps_pdos,
    late_ready,
    never_says_gone,
    no_sdo_at_work,
    no_wrap,
    refuses,
    register_sticks,
    remaps_counted,
    remaps_valid,
    reports_again,
    second_toggle,
    sends_when_stopped,
    skips_gaps,
    starts_at_once,
    starts_itself,
    takes_invalid,
    timers_run_on,
    watches_unheard,
    writes_aborted,
)
from gateway.conformance.peers.canopen301_states import remembers as remembers_all
from gateway.conformance.peers.stations import Mutant, Variant
from gateway.files.find import find_config
from protocols.base.machine import Frame, ms
from protocols.canopen import cob_id as cobid
from protocols.canopen import lss, sdo
from protocols.canopen.sdo import Abort

LINK: dict[str, object] = {"node": NODE}


Row = tuple[str, str, tuple[str, ...], Callable[[], object]]


def _row(name: str, what: str, expects: str, tune: Tune | None = None, says: Says | None = None, hears: Says | None = None) -> Row:
    return name, what, tuple(f"CO301_{one}" for one in expects.split()), lambda: Drive(tune, says, hears)


MUTANT_ROWS: tuple[Row, ...] = (
    ("keeps-unsaved", "keeps what was not stored over a power failure", ("CO301_SUP_RC_02",), KeepsUnsaved),
    ("loses-stored", "loses what was stored over a power failure", ("CO301_SUP_RC_03",), LosesStored),
    ("no-boot-at-power", "no boot-up message after a power failure", ("CO301_SUP_RC_01",), NoBootAtPower),
    _row("silent", "answers no SDO", "SDO_BV_01", says=answers(lambda data: None)),
    _row(
        "wrong-index",
        "its answers name the next index",
        "SDO_BV_01",
        says=answers(lambda data: data[:1] + bytes((data[1] + 1 & 255,)) + data[2:]),
    ),
    _row(
        "always-four",
        "expedited uploads of four bytes, whatever the object",
        "SDO_BV_02",
        says=when(2, lambda data: b"\x43" + data[1:] if data[0] & 2 else data),
    ),
    ("late", "SDO answers after 1.5 s", ("CO301_SDO_BV_01",), lambda: Late(ms(1500))),
    _row(
        "lost-writes",
        "downloads are acknowledged without effect",
        "SDO_BV_03",
        lambda drive: setattr(drive.node.objects, "download", lambda key, data: OK),
    ),
    _row("segment-toggle", "upload segments with the same toggle bit", "SDO_BV_04", says=when(0, toggle_zero)),
    _row("segment-unused", "the last segment names no unused bytes", "SDO_BV_04 DIC_CA_01", says=when(0, all_used)),
    _row("stays-stopped", "does not start in state stopped", "NMT_BV_03", stays_stopped),
    _row(
        "segment-size",
        "announces a byte more than comes",
        "SDO_BV_04",
        says=when(2, lambda data: data[:4] + (sdo.size_of(data) + 1).to_bytes(4, "little") if not data[0] & 2 else data),
    ),
    _row(
        "no-download-segments",
        "refuses segmented downloads",
        "SDO_BV_05",
        hears=on(
            cobid.sdo_request(NODE),
            lambda drive, frame: [frame._replace(data=b"\xe0" + frame.data[1:])] if frame.data[0] in (0x20, 0x21) else [frame],
        ),
    ),
    _row(
        "block-crc",
        "block uploads with a wrong CRC",
        "SDO_BV_06",
        says=when(6, lambda data: data[:1] + bytes((data[1] ^ 1,)) + data[2:] if data[0] & 1 else data),
    ),
    _row(
        "block-unused",
        "block uploads name no unused bytes",
        "SDO_BV_06",
        says=when(6, lambda data: bytes((data[0] & ~0x1C,)) + data[1:] if data[0] & 1 else data),
    ),
    _row("block-size-ignored", "blocks of another size than asked", "SDO_BV_07 SDO_BV_08", server(BigBlocks)),
    _row("no-repeat", "segments that were not acknowledged are not repeated", "SDO_BV_08", server(NoRepeat)),
    _row(
        "block-download-end",
        "does not acknowledge the end of a block download",
        "SDO_BV_09",
        says=answers(lambda data: None if data[0] == 0xA1 else data),
    ),
    _row("answers-aborts", "answers an abort of the client", "SDO_BO_01", server(AnswersAborts)),
    _row("holds", "a new upload is refused while one is under way", "SDO_BO_02", server(Holds)),
    _row("other-node", "answers requests to the next node", "SDO_BO_04", hears=other_number),
    _row("hangs-in-blocks", "waits for ever for a client that gave up a block upload", "SDO_RC_01", server(HangsInBlocks)),
    _row("tires", "one SDO answer in 250 is lost", "SDO_ST_01", says=tires),
    _row("toggle-unchecked", "takes any toggle bit", "SDO_BI_01 SDO_BI_02", server(NoToggleCheck)),
    _row("too-long-is-general", "too many bytes: 06020000h", "SDO_BI_03", says=abort_code(Abort.TOO_LONG, Abort.NO_OBJECT)),
    _row("short-taken", "refuses a wrong length, and writes", "SDO_BI_03 SDO_BI_04", sets_too),
    _row("any-size", "takes more than announced", "SDO_BI_05", server(AnySize)),
    _row("crc-unchecked", "takes a block with a wrong CRC", "SDO_BI_06", server(NoCrcCheck)),
    _row("unknown-silent", "an unknown command is not answered", "SDO_BI_07", hears=on(cobid.sdo_request(NODE), unknown_unheard)),
    _row("segment-alone", "a segment without transfer: 06060000h", "SDO_BI_08 SDO_BO_01", says=abort_code(Abort.COMMAND, Abort.HARDWARE)),
    _row("any-block", "takes a block size of 0", "SDO_BI_09", server(AnyBlock)),
    _row(
        "device-type",
        "1000h of two bytes",
        "SDO_BV_01 DIC_BV_01",
        says=when(2, lambda data: b"\x4b" + data[1:] if data[1:3] == b"\x00\x10" else data),
    ),
    _row(
        "no-identity",
        "1018h has no vendor",
        "DIC_BV_03",
        lambda drive: drive.node.objects.refused.update({(0x1018, 1): (Abort.NO_SUB, 9999)}),
    ),
    _row("no-index-is-hardware", "a missing index: 06060000h", "DIC_BI_01", says=abort_code(Abort.NO_OBJECT, Abort.HARDWARE)),
    _row("no-sub-is-value", "a missing sub-index: 06090030h", "DIC_BI_02 DIC_BV_06", says=abort_code(Abort.NO_SUB, Abort.VALUE)),
    _row("read-only-is-length", "a write to a constant: 06070010h", "DIC_BI_03", says=abort_code(Abort.READ_ONLY, Abort.LENGTH)),
    _row(
        "no-boot-up",
        "sends no boot-up message",
        "NMT_BV_01",
        says=on(cobid.heartbeat(NODE), lambda drive, frame: [] if frame.data == b"\0" else [frame]),
    ),
    _row(
        "no-reset-communication",
        "does not know reset communication",
        "NMT_BV_02",
        hears=commands(lambda what, node: None if what == 130 else (what, node)),
    ),
    _row("no-stop", "does not know stop", "NMT_BV_03", hears=commands(lambda what, node: None if what == 2 else (what, node))),
    _row(
        "not-all",
        "commands to all nodes are not heard",
        "NMT_BV_04",
        hears=commands(lambda what, node: None if node == 0 else (what, node)),
    ),
    _row("for-others", "commands to other nodes are its own", "NMT_BI_01", hears=commands(lambda what, node: (what, NODE))),
    _row(
        "any-command",
        "an unknown command stops it",
        "NMT_BI_02",
        hears=commands(lambda what, node: (what if what in (1, 2, 128, 129, 130) else 2, node)),
    ),
    _row("remembers", "reset communication keeps what was written", "NMT_BV_06", never_resets),
    _row("served-when-stopped", "answers SDOs in state stopped", "NMT_BO_01", served_when_stopped),
    _row("slow-beat", "its heartbeat comes every 1.4 periods", "ERR_BV_01", beat_times(1.4)),
    _row("beats-on", "1017h = 0 does not end the heartbeat", "ERR_BV_02", beats_on),
    _row("no-guard-toggle", "guarding without toggle bit", "ERR_BV_03", says=no_toggle),
    _row("toggle-stays", "a reset leaves the toggle bit of guarding", "ERR_BV_04", toggle_stays),
    _row("life-never", "guarding that stays away is not reported", "ERR_BV_05", life_never),
    _row("no-consumer", "does not watch heartbeats", "ERR_BV_06", hears=deaf(0x700 + 126)),
    _row("slow-consumer", "watches heartbeats with twice the time", "ERR_BV_06", consumer(2.0)),
    _row("fast-consumer", "watches heartbeats with half the time", "ERR_BV_06", consumer(0.5)),
    _row(
        "short-emcy",
        "emergencies of seven bytes",
        "ERR_BV_06",
        says=on(cobid.emcy(NODE), lambda drive, frame: [frame._replace(data=frame.data[:7])]),
    ),
    _row(
        "emcy-code",
        "another emergency code for a lost heartbeat",
        "ERR_BV_06",
        says=on(
            cobid.emcy(NODE),
            lambda drive, frame: [frame._replace(data=b"\0\x10" + frame.data[2:])] if frame.data[:2] == b"\x30\x81" else [frame],
        ),
    ),
    _row("no-register", "the error register is always 0", "ERR_BV_08", shows_register),
    _row("history-stays", "1003h cannot be emptied", "ERR_BV_09", history_stays),
    _row("reports-once", "the same error is reported once for ever", "ERR_RC_01", reports_once),
    _row("stays-operational", "a lost heartbeat changes no state", "ERR_BV_11", stays),
    _row("history-any", "1003h:00 takes anything", "ERR_BI_01", unchecked((0x1003, 0))),
    _row("watched-twice", "a node may be watched twice", "ERR_BI_02", unchecked((0x1016, 1), (0x1016, 2))),
    _row("emcy-any", "EMCY may have any identifier", "ERR_BI_03", unchecked((0x1014, 0))),
    _row("no-sync", "does not act on SYNC", "PDO_BV_01", hears=deaf(cobid.SYNC)),
    _row(
        "long-tpdo",
        "TPDOs of eight bytes, whatever is mapped",
        "PDO_BV_01",
        says=on(cobid.tpdo(1, NODE), lambda drive, frame: [frame._replace(data=frame.data.ljust(8, b"\0"))]),
    ),
    ("late-tpdo", "TPDOs 15 ms after SYNC", ("CO301_PDO_BV_01",), lambda: Drive(settings=DriveSettings(QUICK, tpdo_delay_us=15_000))),
    _row("each-sync", "a TPDO with each SYNC, whatever the type", "PDO_BV_02", each_sync),
    _row("stuck-contents", "a bit of TPDO 1 is wrong", "PDO_BV_03", says=stuck_contents),
    _row("inhibit-ignored", "the inhibit time does not count", "PDO_BV_05", inhibit_ignored),
    _row("always-valid", "bit 31 of 1800h:01 does not count", "PDO_BV_06", always_valid),
    _row("fixed-identifier", "1800h:01 does not change its identifier", "PDO_BV_07", says=fixed_identifier),
    _row("always-operational", "pre-operational is never entered again", "NMT_BV_03 PDO_BO_01", always_operational),
    _row("each-50th", "one TPDO in 50 is lost", "PDO_ST_01", says=each_50th),
    _row("never-says-gone", "no EMCY 0000h", "ERR_BV_10", says=never_says_gone),
    _row("deaf-rpdo", "does not hear RPDO 1", "PDO_BV_08", hears=deaf(cobid.rpdo(1, NODE))),
    _row("rpdo-at-once", "RPDOs never wait for SYNC", "PDO_BV_09", rpdo_at_once),
    _row("first-rpdo", "of several RPDOs the first counts", "PDO_BV_10", first_rpdo),
    _row("short-filled", "fills up an RPDO that is too short", "PDO_BI_01", hears=short_taken),
    _row("kept-rpdos", "an RPDO of before the start acts", "PDO_BO_03", kept_rpdos),
    _row("mapping-free", "a mapping may be changed at any time", "PDO_BI_02", mapping_free),
    _row("maps-anything", "anything can be mapped", "PDO_BI_03 PDO_BI_04", entries_free),
    _row("maps-any-length", "more than 64 bits can be mapped", "PDO_BI_05", count_free),
    _row("any-type", "any transmission type", "PDO_BI_06", unchecked((0x1800, 2))),
    _row("any-identifier", "any identifier, at any time", "PDO_BI_07 PDO_BI_08", unchecked((0x1800, 1))),
    _row("any-counter", "1019h takes anything", "PDO_BI_09", unchecked((0x1019, 0))),
    _row("any-sync", "SYNC of any length", "PDO_BI_10", hears=on(cobid.SYNC, lambda drive, frame: [frame._replace(data=b"")])),
    _row("no-store", "save is acknowledged, nothing is kept", "STO_BV_01", no_store),
    _row("restores-at-once", "load acts at once", "STO_BV_02", restores_at_once),
    _row("restores-nothing", "load is acknowledged, nothing is restored", "STO_BV_02", restores_nothing),
    _row("sub-for-index", "a missing index is refused as a missing sub-index", "DIC_BI_01 DIC_BI_06", says=answers(sub_for_index)),
    _row("any-save", "1010h takes any signature", "STO_BI_01", any_signature(0x1010)),
    _row("any-load", "1011h takes any signature", "STO_BI_02", any_signature(0x1011)),
    _row(
        "lss-vendor",
        "LSS reports another vendor",
        "LSS_BV_02",
        says=lss_answers(lambda data: data[:1] + b"\x55" + data[2:] if data[0] == 0x5A else data),
    ),
    _row(
        "lss-node",
        "LSS reports another node number",
        "LSS_BV_03",
        says=lss_answers(lambda data: data[:1] + b"\x55" + data[2:] if data[0] == 0x5E else data),
    ),
    _row("number-ignored", "a new node number never counts", "LSS_BV_04", number_ignored),
    _row(
        "identifies-all",
        "sends 4Fh whatever the range",
        "LSS_BV_05",
        lambda drive: setattr(drive.node.lss, "_identify", lambda part, number: [lss.answer(lss.Service.IDENTIFIED)] if part == 5 else []),
    ),
    _row("any-serial", "selected with any serial number", "LSS_BI_01", any_serial),
    _row("any-number", "takes node numbers 0 and 128", "LSS_BI_02", any_number),
    _row(
        "any-rate",
        "takes a reserved bit rate",
        "LSS_BI_03",
        says=lss_answers(lambda data: data[:1] + b"\0" + data[2:] if data[0] == 0x13 else data),
    ),
    _row("configures-always", "can be configured without being selected", "LSS_BO_01", configures_always),
    _row("bad-state", "its heartbeat shows state 6", "NMT_BV_03 TRC_BV_01", says=beats(lambda data: b"\x06" if data == b"\x05" else data)),
    _row(
        "strange-identifier",
        "sends something on 101h",
        "TRC_BV_01",
        says=on(cobid.tpdo(1, NODE), lambda drive, frame: [frame, Frame(0x101, b"\x01")]),
    ),
    _row("answer-toggle", "acknowledges each segment with toggle bit 0", "SDO_BV_11", says=when(1, lambda data: b"\x20" + data[1:])),
    _row("second-toggle", "the toggle bit counts in the first segment only", "SDO_BI_11", second_toggle),
    _row("writes-aborted", "writes what has come when a download is aborted", "SDO_BO_05", writes_aborted),
    _row("skips-gaps", "does not miss a segment of a block", "SDO_BV_12", skips_gaps),
    _row("crc-always", "checks a CRC that the client does not send", "SDO_BV_13", crc_always),
    _row(
        "abort-names-nothing",
        "its aborts name 0000h:00",
        "DIC_BI_07",
        says=answers(lambda data: b"\x80\0\0\0" + data[4:] if data[0] == 0x80 else data),
    ),
    _row("no-sdo-at-work", "answers no SDO while operational", "NMT_BV_07", hears=no_sdo_at_work),
    _row("boots-twice", "two boot-up messages", "NMT_BV_08", says=boots_twice),
    _row("remembers-all", "reset node keeps what was written", "NMT_BV_09", remembers_all),
    _row("keeps-pdos", "reset communication keeps PDO parameters", "PDO_BV_17", keeps_pdos),
    _row("register-sticks", "1001h stays set when the error is gone", "ERR_BV_12", register_sticks),
    _row("reports-again", "reports a lost heartbeat again and again", "ERR_BV_13", reports_again),
    _row("any-heartbeat", "the heartbeat of any node will do", "ERR_BV_14", hears=any_heartbeat),
    _row("watches-unheard", "misses a heartbeat that was never received", "ERR_BO_01", watches_unheard),
    _row("emcy-never-off", "bit 31 of 1014h does not count", "ERR_BV_15", emergencies_never_off),
    _row(
        "emcy-fixed",
        "1014h does not change the identifier",
        "ERR_BV_16",
        says=on(0x6B2, lambda drive, frame: [frame._replace(identifier=cobid.emcy(NODE))]),
    ),
    _row("emcy-unhindered", "1015h does not count", "ERR_BV_17", emergencies_unhindered),
    _row("guards-as-before", "guarding shows pre-operational for ever", "ERR_BV_18", says=guards_as_before),
    _row("beats-toggle", "its heartbeat has a toggle bit", "ERR_BV_19", says=beats_toggle),
    _row("sends-when-stopped", "sends TPDOs in state stopped", "PDO_BO_04", sends_when_stopped),
    _row("timers-run-on", "event timers run on in pre-operational", "PDO_BO_05", timers_run_on),
    _row("takes-invalid", "takes an RPDO that is not valid", "PDO_BV_12", takes_invalid),
    _row("fixed-rpdo", "1400h:01 does not change its identifier", "PDO_BV_13", hears=deaf(0x6B3)),
    _row("fixed-sync", "1005h does not change its identifier", "PDO_BV_14", hears=deaf(0x6B4)),
    _row("no-wrap", "a SYNC counter that begins again is an error", "PDO_BV_15", hears=no_wrap),
    _row("starts-at-once", "1800h:06 does not count", "PDO_BV_16", starts_at_once),
    _row("any-entry-length", "maps an object with a wrong length", "PDO_BI_11", any_entry_length),
    _row("remaps-valid", "a valid PDO can be mapped anew", "PDO_BI_12", remaps_valid),
    _row("remaps-counted", "an entry is written while 1A00h:00 counts it", "PDO_BI_02", remaps_counted),
    *(_row(*one) for one in SETTINGS),
)


SHEET: dict[str, object] = {**LINK, "eds": str(find_config("axisgate_402.eds", "drives"))}
MUTANTS = (
    *(Mutant(name, what, expects, make, LINK, {}) for name, what, expects, make in MUTANT_ROWS),
    Mutant("takes-constants", "takes a write to a constant", ("CO301_DIC_BI_08",), lambda: Drive(takes_constants), SHEET, {}),
    Mutant("shifted", "TPDO 1 is shifted after power-on", ("CO301_SUP_RC_04",), Shifted, LINK, {}),
)


def _good(name: str, what: str, make: Callable[[], object], touch: bool = True, **pics: object) -> Variant:
    return Variant(name, what, make, LINK, dict(pics), touch)


PDOS = tuple(range(0x1400, 0x1404)) + tuple(range(0x1600, 0x1604)) + tuple(range(0x1800, 0x1804)) + tuple(range(0x1A00, 0x1A04))

PARAMETERS, MAPPINGS = (range(0x1400, 0x1600), range(0x1800, 0x1A00)), (range(0x1600, 0x1800), range(0x1A00, 0x1C00))
FIXED = tuple(range(index, index + 1) for index in (0x1005, 0x1014, 0x1015, 0x1019))
MORE = tuple(range(0x1003, 0x1017)) + tuple(range(0x1019, 0x1201))


def _no_such_service(*specifiers: int) -> Says:
    """Requests with these command specifiers are unknown to it."""
    unknown = lambda drive, frame: [frame._replace(data=b"\xe0" + frame.data[1:])] if frame.data[0] >> 5 in specifiers else [frame]  # noqa: E731
    return on(cobid.sdo_request(NODE), unknown)


def without_size(data: bytes) -> bytes:
    return bytes((data[0] & ~0x0D,)) + data[1:] if data[0] & 2 else data


VARIANTS = (
    _good("plain", "offers everything", Drive),
    Variant("with-its-eds", "its EDS is given", Drive, SHEET, {}),
    _good("slow", "SDO answers after 300 ms", lambda: Late(ms(300))),
    _good("chatty", "another node speaks as well", lambda: Drive(says=chatty)),
    _good("no-pdos", "no PDOs", lambda: Drive(lacks=PDOS)),
    _good("no-texts", "no device name and versions", lambda: Drive(lacks=(0x1008, 0x1009, 0x100A))),
    _good("no-emcy", "no emergencies, no history, no consumer", lambda: Drive(lacks=(0x1014, 0x1003, 0x1016))),
    _good("no-store", "stores nothing", lambda: Drive(lacks=(0x1010, 0x1011))),
    _good("guarding-only", "no heartbeat", lambda: Drive(lacks=(0x1017, 0x1016))),
    _good("no-lss", "no layer setting services", lambda: Drive(hears=deaf(cobid.LSS_MASTER))),
    _good("no-blocks", "refuses block transfers", lambda: Drive(hears=_no_such_service(5, 6))),
    _good("general-aborts", "refuses everything with 08000000h", lambda: Drive(says=answers(general))),
    _good("no-sizes", "expedited uploads name no size", lambda: Drive(says=when(2, without_size))),
    _good("untouchable", "nothing may be written by PDO", Drive, touch=False),
    _good("fixed-mapping", "its mapping is constant", lambda: Drive(refuses(*MAPPINGS))),
    _good("fixed-pdos", "PDO parameters and mapping are constant", lambda: Drive(refuses(*MAPPINGS, *PARAMETERS))),
    _good("few-types", "transmission types 1, 254 and 255 only", lambda: Drive(refuses(*PARAMETERS, taken=(1, 254, 255)))),
    _good("fixed-identifiers", "1005h, 1014h, 1015h and 1019h are constant", lambda: Drive(refuses(*FIXED))),
    _good("starts-itself", "operational without a command", lambda: Drive(starts_itself)),
    _good("expedited-only", "expedited transfers only", lambda: Drive(hears=expedited_only, lacks=(0x1008, 0x1009, 0x100A))),
    _good("smallest", "1000h, 1001h, 1017h and 1018h only", lambda: Drive(lacks=(*PDOS, *MORE))),
    _good("late-ready", "SDOs 800 ms after its boot-up message", lambda: Drive(late_ready)),
    _good("coarse-beats", "a heartbeat by a clock of 10 ms", lambda: Drive(coarse_beats)),
    _good("patient-consumer", "misses a heartbeat after 1.3 of its times", lambda: Drive(consumer(1.3))),
    _good("slow-tpdo", "TPDOs 2 ms after SYNC", lambda: Drive(settings=DriveSettings(QUICK, tpdo_delay_us=2000, tpdo_spread_us=500))),
)
