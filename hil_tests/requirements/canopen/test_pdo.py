"""CiA 301, 7.2.2 and 7.5.2.35..38: PDOs of the emulated device: mapping rules, transmission types, timers, SYNC counter."""

import pytest

from drivers.emulator.servo.settings import DriveSettings
from hil_tests.lab.virtual.canopen_bus import QUICK, AbortedError, CanopenBus, Master
from protocols.base.machine import Frame
from protocols.canopen import cob_id as cobid
from protocols.canopen import nmt
from protocols.canopen.sdo import Abort

TPDO1, TPDO2, RPDO1, RPDO2 = 0x181, 0x281, 0x201, 0x301


def ready() -> tuple[CanopenBus, Master]:
    bus = CanopenBus()
    bus.run(0.1)
    return bus, bus.node()


def code_of(node: Master, index: int, value: int, sub: int) -> int:
    """The abort code of a write, 0 when it was taken."""
    try:
        node.set(index, value, sub)
    except AbortedError as error:
        return error.code
    return 0


def remap(node: Master, number: int, transmit: bool, words: list[int], kind: int = 1) -> None:
    """As the standard wants it: invalid, count 0, entries, count, type, valid."""
    com, mapping = (0x1800, 0x1A00) if transmit else (0x1400, 0x1600)
    identifier = (cobid.tpdo if transmit else cobid.rpdo)(number, 1)
    node.set(com + number - 1, identifier | cobid.INVALID, 1)
    node.set(mapping + number - 1, 0, 0)
    for sub, word in enumerate(words, 1):
        node.set(mapping + number - 1, word, sub)
    node.set(mapping + number - 1, len(words), 0)
    node.set(com + number - 1, kind, 2)
    node.set(com + number - 1, identifier, 1)


# -- rules of mapping ---------------------------------------------------------------------------------


def test_a_map_is_changed_in_the_order_of_the_standard() -> None:
    bus, node = ready()
    remap(node, 2, True, [0x60410010, 0x60640020, 0x60770010])
    node.nmt(nmt.Command.START)
    (answer,) = [frame for frame in bus.hand(Frame(0x80)) if frame.identifier == TPDO2]
    assert len(answer.data) == 8 and int.from_bytes(answer.data[:2], "little") == node.status


def test_a_valid_pdo_keeps_its_map_and_its_identifier() -> None:
    _, node = ready()
    assert code_of(node, 0x1A00, 0x60410010, 1) == Abort.ACCESS
    assert code_of(node, 0x1A00, 0, 0) == Abort.ACCESS
    assert code_of(node, 0x1800, 0x40000182, 1) == Abort.VALUE
    assert code_of(node, 0x1800, 50, 3) == Abort.ACCESS
    assert code_of(node, 0x1800, 0xC0000182, 1) == 0, "invalid, with another identifier"


def test_entries_wait_until_the_count_is_0() -> None:
    _, node = ready()
    node.set(0x1800, 0xC0000181, 1)
    assert code_of(node, 0x1A00, 0x60410010, 1) == Abort.ACCESS
    node.set(0x1A00, 0, 0)
    assert code_of(node, 0x1A00, 0x60410010, 1) == 0


@pytest.mark.parametrize(
    ("word", "code"),
    [
        (0x60400010, 0),  # rw: into an RPDO or a TPDO
        (0x60410008, Abort.NOT_MAPPABLE),  # length is not the object's
        (0x60420010, Abort.NO_OBJECT),
        (0x607D0120, Abort.NOT_MAPPABLE),  # exists, is not mappable
        (0x20010720, Abort.NO_SUB),
        (0x00050008, Abort.NO_OBJECT),  # dummies belong into RPDOs
    ],
)
def test_what_may_be_in_a_tpdo(word: int, code: int) -> None:
    _, node = ready()
    node.set(0x1800, 0xC0000181, 1)
    node.set(0x1A00, 0, 0)
    assert code_of(node, 0x1A00, word, 1) == code


def test_what_may_be_in_an_rpdo() -> None:
    _, node = ready()
    node.set(0x1400, 0x80000201, 1)
    node.set(0x1600, 0, 0)
    assert code_of(node, 0x1600, 0x60410010, 1) == Abort.NOT_MAPPABLE, "read-only"
    assert code_of(node, 0x1600, 0x00050008, 1) == 0, "a dummy of 8 bits"
    assert code_of(node, 0x1600, 0x607A0020, 2) == 0


def test_64_bits_are_the_most_and_the_count_is_judged_as_a_whole() -> None:
    _, node = ready()
    node.set(0x1800, 0xC0000181, 1)
    node.set(0x1A00, 0, 0)
    for sub, word in enumerate([0x60640020, 0x606C0020, 0x60410010], 1):
        node.set(0x1A00, word, sub)
    assert code_of(node, 0x1A00, 3, 0) == Abort.MAPPED_LENGTH
    assert code_of(node, 0x1A00, 9, 0) == Abort.MAPPED_LENGTH, "more entries than the object has"
    assert code_of(node, 0x1A00, 2, 0) == 0


@pytest.mark.parametrize("identifier", [0x000, 0x07F, 0x101, 0x180, 0x581, 0x601, 0x6E0, 0x701, 0x7FF])
def test_restricted_identifiers_are_refused(identifier: int) -> None:
    _, node = ready()
    node.set(0x1800, 0xC0000181, 1)
    assert code_of(node, 0x1800, 0x40000000 | identifier, 1) == Abort.VALUE
    assert code_of(node, 0x1800, 0x20000000 | 0x181, 1) == Abort.VALUE, "29 bits"


@pytest.mark.parametrize(("kind", "transmit", "receive"), [(241, 1, 1), (251, 1, 1), (252, 0, 1), (253, 0, 1), (0, 0, 0), (240, 0, 0)])
def test_reserved_transmission_types_are_refused(kind: int, transmit: int, receive: int) -> None:
    _, node = ready()
    assert bool(code_of(node, 0x1800, kind, 2)) is bool(transmit)
    assert bool(code_of(node, 0x1400, kind, 2)) is bool(receive)


def test_an_empty_pdo_is_silent() -> None:
    bus, node = ready()
    node.set(0x1800, 0xC0000181, 1)
    node.set(0x1A00, 0, 0)
    node.set(0x1800, 1, 2)
    node.set(0x1800, 0x40000181, 1)
    node.nmt(nmt.Command.START)
    assert not [frame for frame in bus.hand(Frame(0x80)) if frame.identifier == TPDO1]


# -- transmission types -------------------------------------------------------------------------------


@pytest.mark.parametrize("every", [1, 2, 5, 240])
def test_a_cyclic_tpdo_comes_with_every_nth_sync(every: int) -> None:
    bus, node = ready()
    node.set(0x1800, every, 2)
    node.nmt(nmt.Command.START)
    heard = [bool(bus.hand(Frame(0x80))) for _ in range(2 * every)]
    assert heard == [number % every == every - 1 for number in range(2 * every)]


def test_type_0_comes_with_the_next_sync_after_an_event() -> None:
    bus, node = ready()
    node.set(0x1800, 0, 2)
    node.nmt(nmt.Command.START)
    bus.hand(Frame(0x80))
    assert not [frame for frame in bus.hand(Frame(0x80)) if frame.identifier == TPDO1]
    node.control(6)
    assert not bus.heard(TPDO1)[1:], "not before SYNC"
    assert [frame.identifier for frame in bus.hand(Frame(0x80))] == [TPDO1]
    assert not bus.hand(Frame(0x80))


def test_an_event_driven_tpdo_reports_a_change_at_once_and_nothing_else() -> None:
    bus, node = ready()
    node.set(0x1800, 255, 2)
    node.set(0x1800, 0, 5)
    node.nmt(nmt.Command.START)
    assert len(bus.heard(TPDO1)) == 1, "how things stand"
    bus.run(1.0)
    bus.hand(Frame(0x80))
    assert len(bus.heard(TPDO1)) == 1
    node.control(6)
    assert bus.heard(TPDO1)[1].data[:2] == (0x231).to_bytes(2, "little")
    assert bus.heard(TPDO1)[1].stamp_ns == bus.now


def test_the_event_timer_repeats_and_starts_again_with_each_transmission() -> None:
    bus, node = ready()
    node.set(0x1800, 50, 5)
    node.nmt(nmt.Command.START)
    start = bus.now
    bus.run(0.120)
    node.control(6)
    bus.run(0.060)
    times = [(frame.stamp_ns - start) // 1_000_000 for frame in bus.heard(TPDO1)]
    assert times == [0, 50, 100, 120, 170]


def test_the_inhibit_time_keeps_two_transmissions_apart_and_loses_nothing() -> None:
    bus, node = ready()
    node.set(0x1800, 0xC0000181, 1)
    node.set(0x1800, 200, 3)  # 20 ms
    node.set(0x1800, 0x40000181, 1)
    node.set(0x1800, 0, 5)
    node.nmt(nmt.Command.START)
    start = bus.now
    for word in (6, 7, 6, 7):
        bus.run(0.002)
        node.control(word)
    bus.run(0.1)
    told = [((frame.stamp_ns - start) // 1_000_000, frame.data[0]) for frame in bus.heard(TPDO1)]
    assert told == [(0, 0x50), (20, 0x33)], "the last state is told when the inhibit time ends"


@pytest.mark.parametrize("kind", [252, 253])
def test_a_remote_frame_asks_for_types_252_and_253(kind: int) -> None:
    bus, node = ready()
    node.set(0x1800, 0xC0000181, 1)
    node.set(0x1800, kind, 2)
    node.set(0x1800, 0x00000181, 1)
    node.nmt(nmt.Command.START)
    assert not bus.heard(TPDO1)
    remote = Frame(TPDO1 | cobid.REMOTE)
    if kind == 252:
        assert not bus.hand(remote), "nothing sampled yet"
        assert not bus.hand(Frame(0x80))
        node.control(6)
        (answer,) = bus.hand(remote)
        assert answer.data[:2] == (0x250).to_bytes(2, "little"), "what SYNC saw"
    else:
        node.control(6)
        (answer,) = bus.hand(remote)
        assert answer.data[:2] == (0x231).to_bytes(2, "little")


def test_a_remote_frame_is_answered_in_operational_only() -> None:
    bus, node = ready()
    node.set(0x1800, 0xC0000181, 1)
    node.set(0x1800, 253, 2)
    node.set(0x1800, 0x00000181, 1)
    assert not bus.hand(Frame(TPDO1 | cobid.REMOTE))
    node.nmt(nmt.Command.START)
    assert bus.hand(Frame(TPDO1 | cobid.REMOTE))


def test_a_tpdo_that_forbids_remote_frames_does_not_answer_them() -> None:
    bus, node = ready()
    node.nmt(nmt.Command.START)
    assert not bus.hand(Frame(TPDO1 | cobid.REMOTE))


def test_the_sync_counter_and_the_start_value() -> None:
    bus, node = ready()
    node.set(0x1019, 4)
    node.set(0x1800, 0xC0000181, 1)
    node.set(0x1800, 2, 2)
    node.set(0x1800, 3, 6)
    node.set(0x1800, 0x40000181, 1)
    node.nmt(nmt.Command.START)
    heard = [bool(bus.heard(TPDO1, before)) for before, _ in ((len(bus.said), bus.hand(Frame(0x80, bytes((n,))))) for n in (1, 2, 3, 4, 1))]
    assert heard == [False, False, True, False, True]
    bus.hand(Frame(0x80))
    assert bus.heard(0x81)[-1].data[:2] == (0x8240).to_bytes(2, "little"), "a SYNC of the wrong length"


def test_tpdos_come_as_late_after_sync_as_the_settings_say() -> None:
    bus = CanopenBus(DriveSettings(QUICK, tpdo_delay_us=300.0, tpdo_spread_us=200.0))
    bus.run(0.1)
    node = bus.node()
    node.set(0x1800, 1, 2)
    node.nmt(nmt.Command.START)
    delays = []
    for _ in range(50):
        bus.run(0.004)
        at = bus.now
        assert not bus.hand(Frame(0x80))
        bus.run(0.001)
        delays.append(bus.heard(TPDO1)[-1].stamp_ns - at)
    assert min(delays) >= 300_000 and max(delays) <= 500_000 and max(delays) - min(delays) > 100_000


def test_sdo_answers_and_emergencies_are_not_delayed() -> None:
    bus = CanopenBus(DriveSettings(QUICK, tpdo_delay_us=300.0))
    bus.run(0.1)
    assert bus.node().read(0x1000) == 0x20192


# -- RPDOs ----------------------------------------------------------------------------------------------


def test_a_synchronous_rpdo_acts_with_sync_an_event_driven_one_at_once() -> None:
    bus, node = ready()
    node.nmt(nmt.Command.START)
    bus.hand(Frame(RPDO1, bytes((6, 0, 1, 0, 0, 0))))
    assert node.status & 0x6F == 0x21 and node.read(0x607A) == 1
    node.set(0x1400, 1, 2)
    bus.hand(Frame(RPDO1, bytes((7, 0, 2, 0, 0, 0))))
    assert node.status & 0x6F == 0x21
    bus.hand(Frame(RPDO1, bytes((7, 0, 3, 0, 0, 0))))
    bus.hand(Frame(0x80))
    assert node.status & 0x6F == 0x23 and node.read(0x607A) == 3, "the last one before SYNC"


def test_a_synchronous_rpdo_is_taken_once() -> None:
    bus, node = ready()
    node.set(0x1400, 1, 2)
    node.nmt(nmt.Command.START)
    bus.hand(Frame(RPDO1, bytes((6, 0, 5, 0, 0, 0))))
    bus.hand(Frame(0x80))
    node.set(0x607A, 99)
    bus.hand(Frame(0x80))
    assert node.read(0x607A) == 99


def test_rpdos_count_in_operational_only() -> None:
    bus, node = ready()
    bus.hand(Frame(RPDO1, bytes((6, 0, 0, 0, 0, 0))))
    assert node.status & 0x6F == 0x40


def test_a_short_rpdo_is_not_processed_a_long_one_is_and_both_are_reported() -> None:
    bus, node = ready()
    node.nmt(nmt.Command.START)
    bus.hand(Frame(RPDO1, bytes((6, 0, 0, 0, 0))))
    assert node.status & 0x6F == 0x40 and bus.heard(0x81)[-1].data[:2] == (0x8210).to_bytes(2, "little")
    bus.hand(Frame(RPDO1, bytes((6, 0, 0, 0, 0, 0))))
    assert node.status & 0x6F == 0x21 and bus.heard(0x81)[-1].data[:2] == b"\0\0", "gone with the next good one"
    bus.hand(Frame(RPDO1, bytes((7, 0, 0, 0, 0, 0, 1))))
    assert node.status & 0x6F == 0x23 and bus.heard(0x81)[-1].data[:2] == (0x8220).to_bytes(2, "little")


def test_a_value_beyond_its_limits_is_left_aside_the_rest_is_taken() -> None:
    bus, node = ready()
    remap(node, 2, False, [0x60600008, 0x607A0020], 255)
    node.nmt(nmt.Command.START)
    bus.hand(Frame(RPDO2, bytes((2, 7, 0, 0, 0))))  # mode 2 is not supported
    assert node.read(0x6061) == 0 and node.read(0x607A) == 7


def test_the_event_timer_of_an_rpdo_watches_its_master() -> None:
    bus, node = ready()
    node.set(0x1400, 100, 5)
    node.nmt(nmt.Command.START)
    bus.run(1.0)
    assert not bus.heard(0x81), "it begins with the first PDO"
    for _ in range(5):
        bus.hand(Frame(RPDO1, bytes(6)))
        bus.run(0.09)
    assert not bus.heard(0x81)
    bus.run(0.02)
    assert [frame.data[:2] for frame in bus.heard(0x81)] == [(0x8250).to_bytes(2, "little")]


def test_dummies_fill_and_change_nothing() -> None:
    bus, node = ready()
    remap(node, 2, False, [0x00070020, 0x60710010], 255)
    node.nmt(nmt.Command.START)
    bus.hand(Frame(RPDO2, bytes((1, 2, 3, 4, 44, 0))))
    assert node.read(0x6071) == 44


def test_two_nodes_may_consume_the_same_pdo() -> None:
    bus = CanopenBus(DriveSettings(QUICK), DriveSettings(QUICK))
    bus.run(0.1)
    for number in (1, 2):
        node = bus.node(number)
        node.set(0x1400, cobid.INVALID | 0x205, 1)
        node.set(0x1400, 0x205, 1)
        node.nmt(nmt.Command.START)
    bus.hand(Frame(0x205, bytes((6, 0, 0, 0, 0, 0))))
    assert bus.node(1).status & 0x6F == bus.node(2).status & 0x6F == 0x21
