"""One direction of the simulated cable: when characters leave and what happens to them.  Times are exact."""

import pytest

from drivers.ports.serial.cable import PENDING_LIMIT, Delivery, Direction, Fault

BIT_NS = 1_000_000_000 / 9600
ENDS = [-(-k * 11 * 1_000_000_000 // 9600) for k in range(1, 300)]  # end of character k, rounded up


def test_each_character_leaves_at_the_end_of_its_character_time() -> None:
    way = Direction(9600)
    way.offer(b"ABC", 0)
    for index, letter in enumerate((b"A", b"B", b"C")):
        assert way.due() == ENDS[index]
        assert way.take(ENDS[index] - 1) == []
        assert way.take(ENDS[index]) == [Delivery(letter, letter, "")]
    assert way.due() is None


@pytest.mark.parametrize("late_ns", [0, 1, 300_000, 1_145_833, 1_145_834, 7_000_000])
def test_lateness_is_caught_up_without_drift(late_ns: int) -> None:
    way = Direction(9600)
    way.offer(bytes(200), 0)
    taken = b""
    while (due := way.due()) is not None:
        for delivery in way.take(due + late_ns):
            taken += delivery.data
        if way.waiting:
            assert way.due() == ENDS[len(taken)], "the grid is absolute"
            assert ENDS[len(taken)] > due + late_ns, "everything that was due has left"
    assert taken == bytes(200)


def test_characters_written_while_the_line_is_busy_follow_without_a_gap_or_overlap() -> None:
    way = Direction(9600)
    way.offer(b"A", 0)
    way.offer(b"B", 500_000)
    assert [d.data for d in way.take(ENDS[1])] == [b"AB"]
    way.offer(b"C", ENDS[1] + 10)
    assert way.due() == ENDS[1] + 10 + ENDS[0]


def test_a_quiet_line_begins_when_it_is_written_to() -> None:
    way = Direction(9600)
    way.offer(b"A", 5_000_000)
    assert way.due() == 5_000_000 + ENDS[0]


def test_baud_0_leaves_at_once() -> None:
    way = Direction(0)
    way.offer(b"ABC\xff", 77)
    assert way.due() == 77
    assert way.take(77) == [Delivery(b"ABC\xff", b"ABC\xff\xff", "")]


def test_the_nth_character_is_spoiled_once() -> None:
    way = Direction(0)
    way.spoil_next(Fault.PARITY, 3)
    way.offer(b"ABCDE", 0)
    good, spoiled, rest = way.take(0)
    assert (good.data, rest.data) == (b"AB", b"DE")
    assert (spoiled.data, spoiled.mark) == (b"C", "parity")
    assert spoiled.wire[:2] == b"\xff\x00"
    assert bin(spoiled.wire[2] ^ ord("C")).count("1") == 1


@pytest.mark.parametrize(
    ("fault", "wire"),
    [(Fault.FRAMING, b"\xff\x01"), (Fault.OVERRUN, b"\xff\x02"), (Fault.BREAK, b"\xff\x00\x00"), (Fault.DROP, b"")],
)
def test_kinds_of_damage(fault: Fault, wire: bytes) -> None:
    way = Direction(0)
    way.spoil_next(fault)
    way.offer(b"A", 0)
    (spoiled,) = way.take(0)
    assert spoiled.mark == fault.value
    assert spoiled.wire[:3] == wire or (len(wire) == 2 and spoiled.wire[:2] == wire)


def test_a_flipped_character_arrives_wrong_and_unmarked() -> None:
    way = Direction(0)
    way.spoil_next(Fault.FLIP)
    way.offer(b"A", 0)
    (spoiled,) = way.take(0)
    assert spoiled.wire != b"A"
    assert spoiled.mark == f"flip={spoiled.wire.hex()}"


def test_a_damaged_nul_never_looks_like_break() -> None:
    way = Direction(0)
    way.spoil_some(Fault.PARITY, 1.0, 7)
    way.offer(b"\x01\x02\x04\x08\x10\x20\x40\x80" * 50, 0)
    assert all(delivery.wire[2] for delivery in way.take(0))


def test_a_plain_side_gets_wrong_characters_for_marks_and_single_ff() -> None:
    way = Direction(0, marks=lambda: False)
    way.spoil_next(Fault.PARITY, 2)
    way.offer(b"\xffB\xff", 0)
    first, spoiled, last = way.take(0)
    assert (first.wire, last.wire) == (b"\xff", b"\xff")
    assert len(spoiled.wire) == 1
    assert spoiled.wire != b"B"


def test_probability_is_kept_and_the_seed_repeats_it() -> None:
    def spoiled(seed: int) -> list[str]:
        way = Direction(0)
        way.spoil_some(Fault.DROP, 0.1, seed)
        way.offer(bytes(10_000), 0)
        return [f"{d.mark}{len(d.data)}" for d in way.take(0)]

    one = spoiled(1)
    assert one == spoiled(1)
    assert one != spoiled(2)
    assert 850 < sum(mark.startswith("drop") for mark in one) < 1150


def test_calm_ends_all_damage() -> None:
    way = Direction(0)
    way.spoil_some(Fault.DROP, 1.0, 1)
    way.spoil_next(Fault.BREAK)
    way.calm()
    way.offer(b"A", 0)
    assert way.take(0) == [Delivery(b"A", b"A", "")]


def test_it_says_when_it_takes_no_more() -> None:
    way = Direction(9600)
    way.offer(bytes(PENDING_LIMIT - 1), 0)
    assert way.full is False
    way.offer(b"x", 0)
    found = way.full
    way.forget()
    assert (found, way.due()) == (True, None)
