"""CANopen: parts that lose or keep settings, and faults that come now and then (used by peers.canopen301)."""

from collections.abc import Sequence

from drivers.emulator.canopen.objects import OK, SAVE
from gateway.conformance.peers.can_devices import NODE, Drive, Says, Tune, put
from gateway.conformance.peers.canopen301_frames import deaf, on
from gateway.conformance.peers.canopen301_history import (
    always_event,
    cleared_by_refusal,
    entries_stay,
    newest_only_first,
    oldest_first,
    refuses_one,
    short_aborts,
    starts_for_others,
    turned_aborts,
    two_as_four,
)
from protocols.base.machine import Frame
from protocols.canopen import cob_id as cobid
from protocols.canopen.dictionary import Key
from protocols.canopen.types import Value

PDOS = range(0x1400, 0x1C00)


def stores_no_pdos(drive: Drive) -> None:
    """Save keeps everything but the parameters of PDOs."""
    objects = drive.node.objects
    store = objects.checks[0x1010, 1]

    def stored(value: Value) -> int:
        code = store(value)
        put(objects, stored={key: held for key, held in objects.stored.items() if key[0] not in PDOS})
        return code

    objects.checks[0x1010, 1] = stored


def stores_once(drive: Drive) -> None:
    """Saved values are never replaced."""
    objects = drive.node.objects
    store = objects.checks[0x1010, 1]
    objects.checks[0x1010, 1] = lambda value: OK if value == SAVE and objects.stored else store(value)


def restores_no_pdos(drive: Drive) -> None:
    """Load forgets the parameters of PDOs."""
    objects = drive.node.objects
    reset = objects.reset

    def partly(node: int, application: bool) -> None:
        kept = {key: held for key, held in objects.stored.items() if key[0] in PDOS}
        reset(node, application)
        objects.stored.update(kept)
        objects.values.update(kept)

    put(objects, reset=partly)


def kept_over_reset(*keys: Key) -> Tune:
    """Reset communication leaves these objects as they are."""

    def tune(drive: Drive) -> None:
        objects = drive.node.objects
        reset = objects.reset

        def kept(node: int, application: bool) -> None:
            before = {key: objects.values[key] for key in keys if not application}
            reset(node, application)
            objects.values.update(before)

        put(objects, reset=kept)

    return tune


def takes_constants(drive: Drive) -> None:
    """The serial number can be written, which the data sheet states as constant."""
    objects = drive.node.objects
    download = objects.download
    put(objects, download=lambda key, data: OK if key == (0x1018, 4) else download(key, data))


def emcy_is_sync(drive: Drive) -> None:
    drive.node.objects.values[0x1014, 0] = drive.node.objects.factory[0x1014, 0] = cobid.SYNC


def watches_one(drive: Drive) -> None:
    """Only the first entry of 1016h counts."""
    consumer, objects = drive.node.consumer, drive.node.objects
    load = consumer.load

    def first() -> None:
        load()
        chosen = objects.whole((0x1016, 1)) >> 16 & 0x7F
        put(consumer, watched={node: watched for node, watched in consumer.watched.items() if node == chosen})

    put(consumer, load=first)


def _each(turn: int, identifier: int, change: Says) -> Says:
    """Every n-th frame on this identifier is changed."""

    def says(drive: Drive, frame: Frame) -> Sequence[Frame]:
        if frame.identifier != identifier:
            return [frame]
        drive.tally += 1
        return change(drive, frame) if drive.tally % turn == 0 else [frame]

    return says


def _wrong_state(drive: Drive, frame: Frame) -> Sequence[Frame]:
    return [frame._replace(data=b"\x7f")] if frame.data == b"\x05" else [frame]


def _wrong_toggle(drive: Drive, frame: Frame) -> Sequence[Frame]:
    beats = drive.node.objects.whole((0x1017, 0)) or frame.data == b"\0"
    return [frame] if beats else [frame._replace(data=bytes((frame.data[0] ^ 0x80,)))]


def last_bit(drive: Drive, frame: Frame) -> Sequence[Frame]:
    return [frame._replace(data=frame.data[:-1] + bytes((frame.data[-1] ^ 1,)))]


state_each_13th = _each(13, cobid.heartbeat(NODE), _wrong_state)
toggle_each_29th = _each(29, cobid.heartbeat(NODE), _wrong_toggle)
content_each_31st = _each(31, cobid.tpdo(1, NODE), last_bit)
rpdo_each_17th = _each(17, cobid.rpdo(1, NODE), lambda drive, frame: [])

SETTINGS: tuple[tuple[str, str, str, Tune | None, Says | None, Says | None], ...] = (
    ("stores-no-pdos", "save leaves out the parameters of PDOs", "STO_BV_03", stores_no_pdos, None, None),
    ("restores-no-pdos", "load leaves out the parameters of PDOs", "STO_BV_04", restores_no_pdos, None, None),
    ("stores-once", "what was saved is never replaced", "STO_BV_05", stores_once, None, None),
    ("keeps-rpdos", "reset communication keeps 1400h:02", "NMT_BV_10", kept_over_reset((0x1400, 2)), None, None),
    ("keeps-sync", "reset communication keeps 1005h", "NMT_BV_10", kept_over_reset((0x1005, 0)), None, None),
    ("other-server", "1200h names another identifier", "DIC_BV_07", lambda drive: drive.fixed((0x1200, 2), 0x601), None, None),
    ("emcy-is-sync", "1014h is the identifier of SYNC", "DIC_BV_08", emcy_is_sync, None, None),
    ("watches-one", "watches the node in 1016h:01 only", "ERR_BV_20", watches_one, None, None),
    ("state-13th", "one heartbeat in 13 shows another state", "ERR_ST_01", None, state_each_13th, None),
    ("toggle-29th", "one answer in 29 to guarding has a wrong toggle bit", "ERR_ST_02", None, toggle_each_29th, None),
    ("content-31st", "one TPDO in 31 has a wrong bit", "PDO_ST_02", None, content_each_31st, None),
    ("rpdo-17th", "one RPDO in 17 is lost", "PDO_ST_03", None, None, rpdo_each_17th),
    ("one-tpdo", "sends the first TPDO only", "PDO_BV_18", None, on(cobid.tpdo(2, NODE), lambda drive, frame: []), None),
    ("second-contents", "TPDO 2 holds a wrong bit", "PDO_BV_18", None, on(cobid.tpdo(2, NODE), last_bit), None),
    ("one-rpdo", "takes the first RPDO only", "PDO_BV_19", None, None, deaf(cobid.rpdo(2, NODE))),
    ("two-as-four", "two bytes are answered as four", "SDO_BV_14", None, two_as_four, None),
    ("abort-7", "aborts of seven bytes", "SDO_BI_12", None, short_aborts, None),
    ("abort-order", "abort codes with their high byte first", "SDO_BI_12", None, turned_aborts, None),
    ("starts-for-others", "start for another node acts", "NMT_BI_01", None, None, starts_for_others),
    ("oldest-first", "1003h:01 is the oldest error", "ERR_BV_21", oldest_first, None, None),
    ("overwrites", "a second error overwrites the first one in 1003h", "ERR_BV_21", newest_only_first, None, None),
    ("entries-stay", "1003h:01 can be read after 1003h was emptied", "ERR_BV_22", entries_stay, None, None),
    ("cleared-by-refusal", "a refused value empties 1003h", "ERR_BI_04", cleared_by_refusal, None, None),
    ("refuses-one", "1003h:00 refuses 1 and 2, greater values empty it", "ERR_BI_01", refuses_one, None, None),
    ("always-event", "a TPDO of type 0 comes with each SYNC", "PDO_BV_20", always_event, None, None),
)
