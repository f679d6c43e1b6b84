"""The wire model: who is sent first, how long it takes, what errors do to the counters (ISO 11898-1 12.1.4)."""

import pytest

from drivers.emulator.wire.cable import RECOVERY_BITS, Carried, Destroyed, Event, NodeState, StateChanged, Wire
from protocols.base.can_bits import frame_bits
from protocols.base.machine import Frame

US = 1000  # one bit at 1 Mbit/s


def two() -> tuple[Wire, int, int]:
    wire = Wire()
    return wire, wire.attach("gateway"), wire.attach("drive")


def carried(events: list[Event]) -> list[int]:
    return [event.frame.identifier for event in events if isinstance(event, Carried)]


def states(events: list[Event], node: int) -> list[NodeState]:
    return [event.state for event in events if isinstance(event, StateChanged) and event.node == node]


def test_one_frame_takes_its_bits() -> None:
    wire, gateway, _ = two()
    wire.offer(gateway, Frame(100), 5 * US)
    assert wire.advance(5 * US + 47 * US) == [], "51 bits less the interframe space are not over yet"
    (event,) = wire.advance(5 * US + 48 * US)
    assert isinstance(event, Carried) and (event.start_ns, event.end_ns, event.frame.stamp_ns) == (5 * US, 53 * US, 53 * US)
    assert (wire.load.frames, wire.load.bits, wire.load.busy_ns) == (1, 51, 51 * US)


def test_the_lowest_identifier_wins_but_never_interrupts() -> None:
    wire, gateway, drive = two()
    long = Frame(0x7FF, bytes(8))
    wire.offer(drive, long, 0)
    wire.offer(gateway, Frame(100), 1 * US)
    wire.offer(drive, Frame(5), 2 * US)
    events = [event for event in wire.advance(10**9) if isinstance(event, Carried)]
    assert [event.frame.identifier for event in events] == [0x7FF, 5, 100]
    assert events[1].start_ns == frame_bits(0x7FF, bytes(8)) * US, "back to back, behind the interframe space"
    assert wire.load.longest_wait_ns == events[2].start_ns - 1 * US


def test_a_burst_of_the_old_protocol_fills_the_share_of_can_md() -> None:
    """SYNC, six set values, six actual values: 1379 us unstuffed .. 1675 us worst."""
    wire, gateway, drive = two()
    for frame in [Frame(100)] + [Frame(200 + 10 * n, bytes([17 * n & 255, 3, n, 90, 200, n, 1, 255 - n])) for n in range(1, 7)]:
        wire.offer(gateway, frame, 0)
    for n in range(1, 7):
        wire.offer(drive, Frame(600 + 10 * n, bytes([7 * n, 3, n, 90, 200, n, 1, 255 - n])), 0)
    assert 1379 * US <= wire.backlog_ns(0) <= 1675 * US
    assert carried(wire.advance(10**9)) == [100, *range(210, 270, 10), *range(610, 670, 10)], "answers lose against set values"
    assert wire.backlog_ns(10**9) == 0 and 1379 <= wire.load.bits <= 1675


def test_each_node_sends_its_own_frames_in_order() -> None:
    wire, gateway, _ = two()
    for identifier in (300, 100, 200):
        wire.offer(gateway, Frame(identifier), 0)
    assert carried(wire.advance(10**9)) == [300, 100, 200]


def test_a_spoilt_frame_is_sent_again_and_counted() -> None:
    wire, gateway, drive = two()
    wire.spoil(1, gateway)
    wire.offer(gateway, Frame(100), 0)
    first, second = wire.advance(10**9)
    assert isinstance(first, Destroyed) and first.end_ns == (51 - 13 + 6 + 6 + 8) * US
    assert isinstance(second, Carried) and second.start_ns == first.end_ns + 3 * US
    assert (wire.nodes[gateway].tec, wire.nodes[drive].rec) == (8 - 1, 1 - 1)
    assert (wire.load.errors, wire.load.frames) == (1, 1)


def test_error_passive_then_bus_off_then_back_by_restart() -> None:
    wire, gateway, drive = two()
    wire.spoil(32, gateway)
    wire.offer(gateway, Frame(100), 0)
    events = wire.advance(10**9)
    assert len([event for event in events if isinstance(event, Destroyed)]) == 32
    assert states(events, gateway) == [NodeState.ERROR_PASSIVE, NodeState.BUS_OFF]
    assert not wire.offer(gateway, Frame(100), 10**9), "a bus-off controller takes nothing"
    wire.restart(gateway, 10**9)
    (back,) = wire.advance(2 * 10**9)
    assert back == StateChanged(gateway, NodeState.ERROR_ACTIVE, 10**9 + RECOVERY_BITS * US)
    assert wire.offer(gateway, Frame(100), 2 * 10**9) and carried(wire.advance(3 * 10**9)) == [100]
    assert wire.nodes[drive].state is NodeState.ERROR_ACTIVE


def test_an_error_passive_transmitter_lets_others_go_first() -> None:
    wire, gateway, drive = two()
    wire.spoil(16, gateway)
    wire.offer(gateway, Frame(1), 0)
    wire.offer(gateway, Frame(2), 0)
    passive = next(e for e in wire.advance(10**9) if isinstance(e, StateChanged))
    assert passive.state is NodeState.ERROR_PASSIVE and wire.nodes[gateway].tec == 128 - 2
    wire.nodes[gateway].tec = 200
    wire.nodes[gateway].state = NodeState.ERROR_PASSIVE
    wire.offer(gateway, Frame(1), 2 * 10**9)
    wire.offer(gateway, Frame(2), 2 * 10**9)
    wire.offer(drive, Frame(700), 2 * 10**9 + 10 * US)
    assert carried(wire.advance(3 * 10**9)) == [1, 700, 2], "suspend transmission: eight bits"


def test_alone_on_the_wire_a_node_gets_passive_and_stays() -> None:
    wire = Wire()
    node = wire.attach("alone")
    wire.offer(node, Frame(100), 0)
    events = wire.advance(50_000 * US)
    assert states(events, node) == [NodeState.ERROR_PASSIVE] and wire.nodes[node].tec == 128
    assert all(event.why == "no ACK" for event in events if isinstance(event, Destroyed)) and not carried(events)


def test_behind_a_cut_cable_a_node_does_not_disturb_the_others() -> None:
    wire, gateway, drive = two()
    third = wire.attach("third")
    wire.plug(drive, 0, plugged=False)
    wire.offer(drive, Frame(1, bytes(8)), 0)
    wire.offer(gateway, Frame(100), 0)
    events = wire.advance(100_000 * US)
    assert carried(events) == [100] and wire.load.errors == 0
    assert states(events, drive) == [NodeState.ERROR_PASSIVE] and wire.nodes[third].tec == 0
    wire.plug(drive, 100_000 * US)
    assert carried(wire.advance(10**9)) == [1], "good again as soon as the cable is"


def test_two_nodes_with_one_identifier_destroy_each_other() -> None:
    wire, gateway, drive = two()
    wire.attach("listener")
    wire.offer(gateway, Frame(100, b"\0"), 0)
    wire.offer(drive, Frame(100, b"\1"), 0)
    events = wire.advance(10**9)
    assert states(events, gateway)[-1] is NodeState.BUS_OFF and states(events, drive)[-1] is NodeState.BUS_OFF
    assert not carried(events)


def test_the_same_offers_give_the_same_bus() -> None:
    def play() -> list[Event]:
        wire, gateway, drive = two()
        wire.spoil(3)
        events: list[Event] = []
        for cycle in range(50):
            wire.offer(gateway, Frame(100), cycle * 1_000_000)
            wire.offer(drive, Frame(610, cycle.to_bytes(8, "little")), cycle * 1_000_000 + 60_000)
            events += wire.advance(cycle * 1_000_000 + 500_000)
        return events

    assert play() == play() != []


def test_a_bit_rate_that_is_no_whole_nanosecond_is_refused() -> None:
    with pytest.raises(ValueError, match="bit rate 3 bit/s"):
        Wire(3)
    assert Wire(125_000).bit_ns == 8000
