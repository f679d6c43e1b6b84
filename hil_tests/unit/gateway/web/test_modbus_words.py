"""Modbus exchanges in words.  Vectors: MODBUS Application Protocol V1.1b3, the examples of section 6."""

import pytest

from gateway.pure.modbus.texts import exchange_text

EXAMPLES = [
    ("01 0013 0013", "01 03 CD6B05", "read coils 19..37", "10110011 11010110 101", True),  # 6.1
    ("03 006B 0003", "03 06 022B 0000 0064", "read holding registers 107..109", "022B 0000 0064", True),  # 6.3
    ("04 0008 0001", "04 02 000A", "read input registers 8", "000A", True),  # 6.4
    ("05 00AC FF00", "05 00AC FF00", "write coil 172: on", "done", True),  # 6.5
    ("06 0001 0003", "06 0001 0003", "write register 1: 0003h", "done", True),  # 6.6
    ("0F 0013 000A 02 CD01", "0F 0013 000A", "write coils 19..28: 10110011 10", "done", True),  # 6.11
    ("10 0001 0002 04 000A 0102", "10 0001 0002", "write registers 1..2: 000A 0102", "done", True),  # 6.12
    ("16 0004 00F2 0025", "16 0004 00F2 0025", "mask write register 4: and 00F2h, or 0025h", "done", True),  # 6.16
    ("17 0003 0006 000E 0003 06 00FF 00FF 00FF", "17 0C 00FE 0ACD 0001 0003 000D 00FF",
     "read and write registers: read 3..8, write 14..16: 00FF 00FF 00FF", "00FE 0ACD 0001 0003 000D 00FF", True),  # 6.17
    ("03 006B 0003", "83 02", "read holding registers 107..109", "exception 02 illegal data address", False),  # 7
]  # fmt: skip


@pytest.mark.parametrize("asked, answered, question, reply, good", EXAMPLES, ids=[example[2] for example in EXAMPLES])
def test_the_examples_of_the_standard(asked: str, answered: str, question: str, reply: str, good: bool) -> None:
    words = exchange_text(bytes.fromhex(asked), bytes.fromhex(answered))
    assert (words.asked, words.answered, words.ok) == (question, reply, good)


@pytest.mark.parametrize("asked", ["", "03", "03 00", "10 0001 0002 04", "0F 0013", "63 01 02", "05 00AC 1234"])
def test_what_is_cut_off_or_unknown_is_reported_all_the_same(asked: str) -> None:
    words = exchange_text(bytes.fromhex(asked), b"")
    assert words.asked
    assert words.answered == "no answer"


def test_long_answers_are_cut_visibly() -> None:
    words = exchange_text(bytes.fromhex("03 0000 0040"), b"\x03\x80" + bytes(128))
    assert words.answered.endswith(" ..")
    assert len(words.answered) < 80
