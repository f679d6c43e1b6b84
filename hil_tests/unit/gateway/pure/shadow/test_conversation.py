"""Which telegram answers which: both sides of a line, refused blocks, repeats, long jobs."""

from gateway.pure.lines.decoder import LineReport
from gateway.pure.shadow.conversation import Answered, Asked, Conversation

FETCH = bytes.fromhex("0000 4544 0B00 0020 FFFF")
SEND = bytes.fromhex("0000 4144 0A00 0001 FFFF 1234")
LONG = bytes.fromhex("0000 4544 0B00 0050 FFFF")
FOLLOW = bytes.fromhex("FF00 4544")
GOOD = bytes(4)


def block(side: str, data: bytes, at: int, *, first: int = 0) -> LineReport:
    return LineReport(at, side, "BLOCK", "", data, True, first=first or at)


def dle(side: str, at: int) -> LineReport:
    return LineReport(at, side, "DLE", "")


def nak(side: str, at: int) -> LineReport:
    return LineReport(at, side, "NAK", "")


def played(*told: LineReport) -> list[object]:
    conversation = Conversation()
    return [exchange for each in told for exchange in conversation.take(each)]


def test_a_job_and_its_reaction() -> None:
    answer = GOOD + b"\x12\x34"
    assert played(block("A", FETCH, 10), dle("B", 11), block("B", answer, 30, first=25), dle("A", 31)) == [
        Asked("A", FETCH, 10),
        Answered("B", FETCH, 0, answer, 10, 25),
    ]


def test_a_block_counts_when_it_is_acknowledged() -> None:
    assert played(block("A", SEND, 10), nak("B", 11), block("A", FETCH, 20)) == []
    assert played(block("A", SEND, 10), nak("B", 11), block("A", SEND, 20), dle("B", 21)) == [Asked("A", SEND, 20)]


def test_a_block_with_a_wrong_check_is_none() -> None:
    assert played(LineReport(10, "A", "BLOCK", "", SEND, False), dle("B", 11)) == []


def test_a_repeat_before_its_reaction_is_one_job() -> None:
    told: tuple[LineReport, ...] = (
        block("A", SEND, 10),
        dle("B", 11),
        block("A", SEND, 20),
        dle("B", 21),
        block("B", GOOD, 30),
        dle("A", 31),
    )
    assert played(*told) == [Asked("A", SEND, 10), Answered("B", SEND, 0, GOOD, 10, 30)]


def test_both_sides_ask_at_once_and_each_gets_its_own() -> None:
    told: tuple[LineReport, ...] = (block("A", FETCH, 10), dle("B", 11), block("B", SEND, 20), dle("A", 21))
    told += (block("B", GOOD + b"\0\1", 30), dle("A", 31), block("A", GOOD, 40), dle("B", 41))
    assert [type(each).__name__ + str(getattr(each, "side", "")) for each in played(*told)] == [
        "AskedA",
        "AskedB",
        "AnsweredB",
        "AnsweredA",
    ]


def test_a_long_job_knows_how_much_went_before() -> None:
    told: tuple[LineReport, ...] = (block("A", LONG, 10), dle("B", 11), block("B", GOOD + bytes(128), 30), dle("A", 31))
    told += (block("A", FOLLOW, 40), dle("B", 41), block("B", GOOD + bytes(32), 60, first=50), dle("A", 61))
    last = played(*told)[-1]
    assert last == Answered("B", LONG, 128, GOOD + bytes(32), 40, 50)


def test_a_reaction_nobody_asked_for_is_none() -> None:
    assert played(block("B", GOOD, 10), dle("A", 11)) == []
