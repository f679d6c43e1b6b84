"""A listener on both sides of the line names each turn as a person would.  Dialogues by hand, after serial-protocols 1.3 and 1.4."""

import pytest

from gateway.pure.lines.trace import Item
from gateway.pure.lines.turns import Flag, Kind, Turn, turns
from protocols.base.machine import Damage, ms


def heard(*said: str, gap_ms: float = 5.0) -> list[tuple[str, str, str]]:
    """ "A 02" one after the other -> (side, kind, hex)."""
    items = [Item(ms(gap_ms) * n, words[0], bytes.fromhex(words[2:])) for n, words in enumerate(said)]
    return [(turn.side, turn.kind.name, turn.data.hex(" ")) for turn in turns(items)]


GOOD = [("A", "STX", "02"), ("B", "DLE", "10"), ("A", "BLOCK", "41 10 03 52"), ("B", "DLE", "10")]


def test_a_block_character_by_character_and_in_one_go() -> None:
    assert heard("A 02", "B 10", "A 41", "A 10", "A 03", "A 52", "B 10") == GOOD
    assert heard("A 02", "B 10", "A 41100352", "B 10") == GOOD


def test_dle_inside_a_block_is_data_and_the_check_may_be_any_character() -> None:
    wire = "41 10 10 42 10 03 10"
    assert heard("A 02", "B 10", f"A {wire}", "B 10")[2] == ("A", "BLOCK", wire)
    assert heard("A 02", "B 10", "A 10 10 02 15 10 17 02", "B 15")[2:] == [("A", "BLOCK", "10 10 02 15 10 17 02"), ("B", "NAK", "15")]


def test_an_answer_and_the_own_wish_in_one_go() -> None:
    assert heard("A 02", "B 10", "A 41100352", "B 1002", "A 10", "B 42 10 03 51", "A 10") == [
        *GOOD, ("B", "STX", "02"), ("A", "DLE", "10"), ("B", "BLOCK", "42 10 03 51"), ("A", "DLE", "10"),
    ]  # fmt: skip


def test_both_want_to_send_and_the_one_who_says_dle_receives() -> None:
    told = heard("A 02", "B 02", "B 10", "A 41100352", "B 10", "B 02")
    assert told == [("A", "STX", "02"), ("B", "STX", "02"), *GOOD[1:], ("B", "STX", "02")]


def test_nak_inside_ends_a_block_and_strays_are_gathered() -> None:
    assert heard("A 02", "B 10", "A 41 42", "B 15", "A 43 44", "A 45") == [
        ("A", "STX", "02"), ("B", "DLE", "10"), ("A", "BROKEN", "41 42"), ("B", "NAK", "15"), ("A", "STRAY", "43 44 45"),
    ]  # fmt: skip


def test_silence_ends_a_block_and_an_unanswered_wish() -> None:
    items = [Item(ms(0), "A", b"\x02"), Item(ms(5), "B", b"\x10"), Item(ms(10), "A", b"A"), Item(ms(511), "A", b"B")]
    assert [(turn.kind, bytes(turn.data)) for turn in turns(items)][2:] == [(Kind.BROKEN, b"A"), (Kind.STRAY, b"B")]
    assert heard("A 02", "B 10", "A 41", "A 42", gap_ms=600)[2:] == [("A", "STRAY", "41"), ("A", "STRAY", "42")]
    assert heard("A 02", "B 10", "A 41", gap_ms=6000)[1:] == [("B", "DLE", "10"), ("A", "STRAY", "41")]


def test_six_wishes_and_the_nak_at_giving_up() -> None:
    assert [kind for _, kind, _ in heard(*["A 02"] * 6, "A 15")] == ["STX"] * 6 + ["NAK"]


def test_a_block_under_way_at_the_end_is_reported_and_one_that_never_began_is_not() -> None:
    assert heard("A 02", "B 10", "A 41")[2:] == [("A", "BROKEN", "41")]
    assert heard("A 02", "B 10") == GOOD[:2]


def test_the_second_side_speaks_while_a_block_runs() -> None:
    assert heard("A 02", "B 10", "A 41", "B 02", "A 10 03 52")[2:] == [("A", "BLOCK", "41 10 03 52"), ("B", "STRAY", "02")]


def test_flags_and_remarks_and_times() -> None:
    items = [
        Item(ms(1), "A", b"\x02", arrived=False, remark="SendRepeated"),
        Item(ms(2), "B", b"\x10", remark="one"),
        Item(ms(3), "A", b"A", damage=Damage.PARITY),
        Item(ms(4), "A", b"", damage=Damage.OVERRUN),
        Item(ms(9), "A", b"\x10\x03\x52", altered=b"\x10\x03\x53", remark="BlockRefused"),
        Item(ms(10), "B", b"\x15", remark="two"),
        Item(ms(11), "B", b"", damage=Damage.BREAK),
    ]
    told = turns(items)
    assert [turn.flags for turn in told] == [Flag.NOT_ARRIVED, 0, Flag.PARITY | Flag.OVERRUN | Flag.ALTERED, 0, Flag.BREAK]
    assert [turn.remarks for turn in told] == [["SendRepeated"], ["one"], ["BlockRefused"], ["two"], []]
    assert (told[2].first_ns, told[2].last_ns, bytes(told[2].data)) == (ms(3), ms(9), b"A\x10\x03\x52")
    assert told[4] == Turn(ms(11), ms(11), "B", Kind.STRAY, bytearray(), Flag.BREAK)


def test_3964_has_no_check_character() -> None:
    items = [
        Item(ms(n), side, data) for n, (side, data) in enumerate([("A", b"\x02"), ("B", b"\x10"), ("A", b"A\x10\x03"), ("B", b"\x10")])
    ]
    told = turns(items, block_check=False)
    assert [(turn.kind, turn.flags) for turn in told][2:] == [(Kind.BLOCK, Flag.NO_CHECK), (Kind.DLE, 0)]


@pytest.mark.parametrize("items", [[], [Item(0, "A", b"", remark="alone")]])
def test_nothing_is_lost_of_nothing(items: list[Item]) -> None:
    assert sum(len(turn.data) for turn in turns(items)) == 0
