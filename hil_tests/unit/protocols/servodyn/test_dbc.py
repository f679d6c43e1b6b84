"""DBC text to layouts: what is refused names file, line, message, signal and what was expected; all faults at once."""

import cantools
import pytest

from gateway.files.find import find_config
from protocols.base.dbc import DbcError, compile_dbc

FILE = find_config("servodyn_gc.dbc", "drives")
HEAD = 'VERSION ""\nBU_: A B\nBO_ 210 SET_1: 8 A\n'


def faults(text: str) -> list[str]:
    with pytest.raises(DbcError) as caught:
        compile_dbc(text, "my.dbc")
    return list(caught.value.faults)


def test_every_message_and_signal_is_where_cantools_finds_it() -> None:
    ours, judge = compile_dbc(FILE.read_text(), FILE.name), cantools.database.can.Database()
    judge.add_dbc_file(str(FILE))
    assert {layout.name: (layout.identifier, layout.length) for layout in ours.values()} == {
        message.name: (message.frame_id, message.length) for message in judge.messages
    }
    for message in judge.messages:
        found = {(s.name, s.start, s.bits, s.signed, s.low, s.high, s.unit) for s in ours[message.name].signals}
        assert found == {(s.name, s.start, s.length, s.is_signed, s.minimum, s.maximum, s.unit or "") for s in message.signals}


@pytest.mark.parametrize(
    ("signal", "told"),
    [
        ('SG_ life : 8|8@0+ (1,0) [0|255] "" B', "byte order Motorola (@0); expected Intel (@1)"),
        ('SG_ life : 8|8@1+ (0.5,0) [0|127] "" B', "scale (0.5,0); expected raw counts (1,0)"),
        ('SG_ life : 60|8@1+ (1,0) [0|255] "" B', "bits 60..67; expected within 0..63 (8 bytes)"),
        ('SG_ life : 8|8@1+ (1,0) [0|256] "" B', "range 0..256 does not fit 8 bits; expected within 0..255"),
        ('SG_ life : 8|8@1- (1,0) [-129|0] "" B', "expected within -128..127"),
        ('SG_ life m0 : 8|8@1+ (1,0) [0|255] "" B', "multiplexed (m0)"),
        ('SG_ life : 8|0@1+ (1,0) [0|255] "" B', "0 bits; expected 1..64"),
        ("SG_ life 8|8", "signal line not understood"),
    ],
)
def test_a_signal_we_cannot_use_is_refused_with_its_place(signal: str, told: str) -> None:
    assert len(faults(HEAD + " " + signal)) == 1
    assert faults(HEAD + " " + signal)[0].startswith("my.dbc:4: message SET_1")
    assert told in faults(HEAD + " " + signal)[0]


def test_overlapping_and_double_signals_are_refused() -> None:
    good = ' SG_ life : 8|8@1+ (1,0) [0|255] "" B\n'
    assert "overlaps signal life (bits 8..15)" in faults(HEAD + good + ' SG_ more : 15|2@1+ (1,0) [0|3] "" B')[0]
    assert "defined twice" in faults(HEAD + good + good)[0]


def test_bad_messages_are_refused_and_all_faults_come_at_once() -> None:
    found = faults("BO_ 4000 FAR: 8 A\nBO_ 5 LONG: 9 A\nBO_ nonsense\nBO_ 7 GOOD: 1 A\nBO_ 8 GOOD: 1 A\n")
    assert [line.split(":")[1] for line in found] == ["1", "2", "3", "5"]
    assert "outside 0..2047" in found[0] and "outside 0..8 bytes" in found[1]


def test_a_text_that_is_no_dbc_says_so() -> None:
    assert faults("hello") == ["my.dbc:1: no message (BO_) found; is this a DBC file?"]
