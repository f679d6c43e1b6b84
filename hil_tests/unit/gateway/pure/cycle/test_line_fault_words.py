"""What a line reports stands in words in the journal and on the page, whatever it is."""

from gateway.pure.lines.fault_texts import FAILED, REFUSED, STAGES, fault_words
from protocols.p3964r.events import (
    BlockRefused,
    Failure,
    LineBreak,
    ReceptionFailed,
    Refusal,
    SendFailed,
    SendRepeated,
    Stage,
    StrayCharacters,
)
from protocols.rk512.active import Denied, Failed, Trouble, Unasked
from protocols.rk512.passive import Refused


def test_every_reason_has_words() -> None:
    assert set(REFUSED) == set(Refusal) and set(FAILED) == set(Failure) and set(STAGES) == set(Stage)


def test_a_block_that_was_not_taken() -> None:
    words = fault_words(BlockRefused(Refusal.GAP, 57))
    assert (
        words == "a block of the partner was not accepted, 57 characters of it were received: "
        "silence inside the block, longer than the character delay"
    )
    assert (
        fault_words(ReceptionFailed(Refusal.CHECK, 6)) == "the partner gave up a block after 6 attempts, the first fault: wrong block check"
    )


def test_a_block_of_ours_and_what_is_beside_blocks() -> None:
    assert fault_words(SendRepeated(3, Failure.NAK, Stage.BLOCK)) == "a block is sent again: the partner answered NAK after the block"
    assert fault_words(SendFailed(3, Failure.SILENT, Stage.CONNECT)).endswith(
        "no answer within the acknowledgement delay at the connection"
    )
    assert fault_words(StrayCharacters(4)) == "4 characters outside any block"
    assert "BREAK" in fault_words(LineBreak())


def test_telegrams_that_were_refused_on_either_side() -> None:
    assert fault_words(Refused(0x14, "no such block", b"\x00\x00\x41\x44")).endswith("refused with error 14h (no such block): 00 00 41 44")
    assert fault_words(Denied(2, 0x0A)) == "job 2: the partner answered with error 0Ah"
    assert fault_words(Unasked(b"\x00")) == "a reaction was received without a request: 00"
    assert all("(" in fault_words(Failed(1, trouble)) for trouble in Trouble)
