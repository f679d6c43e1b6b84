"""Dialogues written by hand, decoded: both wires, one wire, doubling, checks, RK512 telegrams, what breaks off."""

from gateway.pure.lines.decoder import LineDecoder, LineReport, telegram_of, telegram_text
from protocols.base.machine import Damage, ms

FETCH = bytes.fromhex("00004544050A0007FFFF10031A")  # serial-protocols 1.2, vector 8
REACTION_10 = bytes.fromhex("00000010101003 13".replace(" ", ""))  # vector 6: error 10h, doubled


def decode(*pieces: tuple[str, bytes], both: bool = True, step: int = ms(1)) -> list[LineReport]:
    decoder, now, told = LineDecoder(both), 0, list[LineReport]()
    for side, data in pieces:
        for byte in data:
            now += step
            told += decoder.take(now, side, byte)
    return told + decoder.flush(now + ms(1000))


def test_a_fetch_and_its_reaction() -> None:
    told = decode(
        ("A", b"\x02"), ("B", b"\x10"), ("A", FETCH), ("B", b"\x10"), ("B", b"\x02"), ("A", b"\x10"), ("B", REACTION_10), ("A", b"\x10")
    )
    assert [(one.side, one.kind) for one in told] == [
        ("A", "STX"), ("B", "DLE"), ("A", "BLOCK"), ("B", "DLE"), ("B", "STX"), ("A", "DLE"), ("B", "BLOCK"), ("A", "DLE")
    ]  # fmt: skip
    assert told[2].text == "FETCH DB5.DW10, 7 words"
    assert told[2].check_ok is True
    assert told[6].text == "reaction 10h header error"
    assert told[6].data == b"\0\0\0\x10"
    assert [told[1].text, told[3].text] == ["DLE: ready", "DLE: good"]


def test_one_wire_shows_its_sender_alone() -> None:
    told = decode(("A", b"\x02"), ("A", FETCH), ("A", b"\x02"), ("A", b"\x02AB\x10\x03\x12"), both=False)
    assert [one.kind for one in told] == ["STX", "BLOCK", "STX", "BLOCK"]
    assert told[3].data == b"\x02AB"


def test_on_one_wire_a_late_stx_is_a_repeat() -> None:
    told = decode(("A", b"\x02\x02\x15"), both=False, step=ms(550))
    assert [one.kind for one in told] == ["STX", "STX", "NAK"]


def test_a_check_off_by_02_names_the_mistake() -> None:
    told = decode(("A", b"\x02"), ("B", b"\x10"), ("A", b"AB\x10\x03" + bytes((0x41 ^ 0x42 ^ 0x13 ^ 2,))), ("B", b"\x15"))
    assert told[2].check_ok is False
    assert told[2].check_difference == 2
    assert "off by 02h (the sender includes STX)" in told[2].text


def test_a_conflict_is_named() -> None:
    told = decode(("A", b"\x02"), ("B", b"\x02"), ("B", b"\x10"), ("A", b"U\x10\x03F"))
    assert "conflict" in told[1].text
    assert told[3].kind == "BLOCK"


def test_a_block_that_stops_is_broken_off() -> None:
    told = decode(("A", b"\x02"), ("B", b"\x10"), ("A", b"ABC"))
    assert told[-1].kind == "BROKEN"
    assert told[-1].text == "block broken off (pause) after 3 characters: 41 42 43"


def test_nak_inside_a_block_ends_it() -> None:
    told = decode(("A", b"\x02"), ("B", b"\x10"), ("A", b"ABC"), ("B", b"\x15"), ("A", b"\x02"))
    assert [one.kind for one in told] == ["STX", "DLE", "BROKEN", "NAK", "STX"]


def test_spoiled_characters_are_counted_in_a_block_and_reported_outside() -> None:
    decoder = LineDecoder()
    assert decoder.take(1, "A", Damage.PARITY)[0].text == "a damaged character (parity)"
    decoder.take(2, "A", 0x02)
    decoder.take(3, "B", 0x10)
    told = [one for what in (0x41, Damage.FRAMING, 0x10, 0x03, 0x52) for one in decoder.take(4, "A", what)]
    assert "1 damaged characters" in told[0].text


def test_telegrams_in_words() -> None:
    assert telegram_text(bytes.fromhex("000041440A020002FFFF04B0FEA2")) == "SEND DB10.DW2, 2 words: 04B0 FEA2"
    assert telegram_text(bytes.fromhex("0000454D001000200604")) == "FETCH M16, amount 32"
    assert telegram_text(bytes.fromhex("FF004144DEADBEEF")) == "follow-on DB: DEAD BEEF"
    assert telegram_text(bytes.fromhex("00000032")) == "reaction 32h locked by coordination flag"
    assert telegram_text(b"HELLO") == "block of 5: 48 45 4c 4c 4f"
    assert telegram_of(b"\0\0") is None
