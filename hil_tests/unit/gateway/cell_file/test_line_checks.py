"""What `check` says of a line, with figures: single times, roles, types, amounts, our own polling, numbers that overflow (issue 3)."""

import pathlib
import re

import pytest

from gateway.assembly.line_dialects import rk512_dialect
from gateway.cell_file.explain import word
from gateway.cell_file.load import CellFaults, Fault, load_cell
from gateway.checks.playable import not_playable
from gateway.pure.cell.cell import Cell, Notice
from gateway.pure.lines.line_profiles import link_profile
from gateway.services.sources.rk512 import compile_job
from protocols.base.machine import ms
from protocols.p3964r.profiles import PROFILES, BrokenPair, ConnectCounter, Stray, TooLong
from protocols.rk512.header import Flag

HEAD = """
format = 1
[cell]
name = "x"
[[line]]
name = "plc"
port = "sim"
"""
BLOCK = """
[[db]]
number = {number}
words = {words}
writer = "{writer}"
line = "plc"
{more}
"""


def block(number: int = 10, words: int = 8, writer: str = "axisgate", more: str = "") -> str:
    return BLOCK.format(number=number, words=words, writer=writer, more=more)


def cell(line: str = "", tables: str = "", blocks: str = "") -> Cell:
    return load_cell("c.toml", f"{HEAD}{line}\n{tables}\n{blocks}")


def faults(line: str = "", tables: str = "", blocks: str = "") -> dict[str, Fault]:
    try:
        cell(line, tables, blocks)
    except CellFaults as found:
        return {fault.key: fault for fault in found.faults}
    return {}


def notices(found: Cell, where: str) -> list[Notice]:
    return [notice for notice in found.notices if notice.where == where]


# ---- single times
@pytest.mark.parametrize("names", [("QVZ", "ZVZ"), ("ADT", "CDT")])
def test_single_times_win_over_the_profile_in_either_vocabulary(names: tuple[str, str]) -> None:
    times = f"[line.times]\n{names[0]} = 800\n{names[1]} = 100\nBWZ = 3000\nreaction = 7000\npause = 20\nno_buffer = 200\n"
    times += "connect_attempts = 3\nblock_attempts = 4\n"
    line = cell('profile = "siemens-cp341"', times).line[0]
    profile = link_profile(line)
    assert (profile.ack_delay, profile.char_delay, profile.block_wait) == (ms(800), ms(100), ms(3000))
    assert (profile.retry_pause, profile.no_buffer_wait) == (ms(20), ms(200))
    assert (profile.connect_attempts, profile.block_attempts) == (3, 4)
    assert rk512_dialect(line).waits(9600) == ms(7000)
    plain = link_profile(cell('profile = "siemens-cp341"').line[0])
    assert (plain.ack_delay, plain.char_delay, plain.connect_attempts) == (ms(2000), ms(220), 6)


def test_open_choices_are_settings() -> None:
    choices = 'connect_counter = "shared"\nstray = "silent"\nbroken_pair = "drop_dle"\ntoo_long = "nak_at_once"\n'
    choices += "nak_at_start = false\nnak_when_giving_up = false\nnesting = false\nyields_to_second_conflict = true\nsilence_ends = true\n"
    line = cell('profile = "siemens-cp341"', f"[line.choices]\n{choices}").line[0]
    profile = link_profile(line)
    assert (profile.connect_counter, profile.stray) == (ConnectCounter.SHARED, Stray.SILENT)
    assert (profile.broken_pair, profile.too_long) == (BrokenPair.DROP_DLE, TooLong.NAK_AT_ONCE)
    assert (profile.nak_at_start, profile.nak_when_giving_up, profile.silence_ends) == (False, False, True)
    assert profile.yields_to_second_conflict and not rk512_dialect(line).nesting
    assert rk512_dialect(cell('profile = "siemens-cp341"').line[0]).nesting


@pytest.mark.parametrize(
    ("line", "times", "key", "said"),
    [
        ('profile = "rho3"', "QVZ = 600\nADT = 700", "times.ADT", "two names of the acknowledgement delay: keep one"),
        ('profile = "rho3"', "ZVZ = 200\nCDT = 200", "times.CDT", "two names of the character delay"),
        ('profile = "siemens-cp341"', "QVZ = 10", "times.QVZ", "siemens-cp341 takes 20..65530 ms"),
        ('profile = "siemens-cp341"', "ADT = 555", "times.ADT", "counts in steps of 10 ms: 550 or 560"),
        ('profile = "vipa-cp240"', "ZVZ = 250", "times.ZVZ", "steps of 20 ms: 240 or 260"),
        ('profile = "vipa-cp240"', "BWZ = 6000", "times.BWZ", "0..5100"),
        ('profile = "rho3"\nformat = "300 8E1"', "CDT = 50", "times.CDT", "two characters take 73.3 ms at 300 8E1"),
        ('profile = "siemens-cp341"\nformat = "600 8E1"', "ZVZ = 30", "times.ZVZ", "the minimum of siemens-cp341 at 600 Bd is 40 ms"),
        ('profile = "rho3"', "QVZ = 5", "times.QVZ", "10..65530 ms"),
        ('profile = "rho3"', "QVS = 500", "times.QVS", "did you mean QVZ?"),
        ('profile = "rho3"', "connect_attempts = 0", "times.connect_attempts", "1..255"),
        ('profile = "rho3"\nQVZ = 500', "", "QVZ", "it belongs in times"),
    ],
)
def test_a_time_that_does_not_fit_is_reported_with_figures(line: str, times: str, key: str, said: str) -> None:
    found = faults(line, f"[line.times]\n{times}" if times else "")
    assert f"line.plc.{key}" in found, found
    assert said in str(found[f"line.plc.{key}"])


def test_a_time_a_station_cannot_follow_is_a_warning_with_both_figures() -> None:
    (said,) = notices(cell('profile = "rho3"', "[line.times]\nADT = 2000"), "line plc")
    assert said.level == "warning"
    assert said.text.startswith("times.ADT = 2000 ms instead of 550 ms: rho3 has fixed times")
    (noted,) = notices(cell('profile = "siemens-cp341"', "[line.times]\nQVZ = 550"), "line plc")
    assert (noted.level, noted.text) == ("note", "times.QVZ = 550 ms instead of 2000 ms: set the partner to the same")
    assert notices(cell('profile = "rho3"', "[line.times]\nQVZ = 550"), "line plc") == [], "the same value changes nothing"


def test_the_times_of_the_line_are_those_the_silence_note_counts_with() -> None:
    text = [n.text for n in notices(cell('profile = "rho3"', "[line.times]\nQVZ = 1000\nconnect_attempts = 3", block()), "line plc")]
    assert any("profile QVZ 1000 ms x 3 attempts = 3 s" in each for each in text)


# ---- profile
def test_an_unknown_profile_names_the_near_ones() -> None:
    said = str(faults('profile = "siemens-cp526"')["line.plc.profile"])
    assert "did you mean siemens-cp525 or siemens-cp524 or" in said
    assert "rho3 | " in said, "and all there are"
    assert "did you mean siemens-cp341" in str(faults('profile = "siemens-cp314-tcp"')["line.plc.profile"])


# ---- roles
@pytest.mark.parametrize(
    ("line", "blocks", "key", "said"),
    [
        ("", block(more="every_ms = 500"), "db.10.every_ms", 'role = "passive": it never sends unprompted'),
        ("", block(more="on_change = true"), "db.10.on_change", 'role = "passive"'),
        ('role = "active"', block(), "line.plc.role", "an active line would send nothing"),
        ('role = "both"', block(writer="plc", more="on_change = true"), "db.10.on_change", "the time of a change there is unknown"),
        ('role = "both"', block(more='at_partner = "DB20.DW0"'), "db.10.at_partner", "every_ms or on_change is missing"),
        ('role = "both"', block(more='every_ms = 500\nat_partner = "DB20"'), "db.10.at_partner", '"DB20.DW0"'),
        ('role = "both"', block(more='every_ms = 500\nat_partner = "DB256.DW0"'), "db.10.at_partner", "1..255"),
        ('role = "both"', block(more='every_ms = 500\nat_partner = "DB20.DW250"'), "db.10.at_partner", "end at DW 257"),
        ('role = "both"', block(more='every_ms = 500\nflag = "M6.9"'), "db.10.flag", '"M 6.4"'),
        (
            'role = "both"\nprofile = "siemens-cp341"',
            block(more='every_ms = 500\nat_partner = "DX20.DW0"'),
            "db.10.at_partner",
            "takes a SEND to D only, not to X",
        ),
        (
            'role = "both"\nprofile = "bosch-system350-3964r"',
            block(writer="plc", more="every_ms = 500"),
            "db.10.every_ms",
            "no reaction telegrams",
        ),
    ],
)
def test_own_jobs_that_cannot_be(line: str, blocks: str, key: str, said: str) -> None:
    found = faults(line, "", blocks)
    assert key in found, found
    assert said in str(found[key])


# ---- amounts, types
def test_an_amount_over_the_limit_is_reported_with_figures() -> None:
    found = faults('role = "both"\nprofile = "wago"', "", block(words=100, more="every_ms = 900"))
    assert "200 bytes, wago carries 128 in one job" in str(found["db.10.words"])
    assert "1..64 words" in str(found["db.10.words"])
    (said,) = notices(cell('profile = "wago"', "", block(words=100)), "db 10")
    assert said.text.startswith("100 words = 200 bytes; wago serves 124 bytes in one job") and "62 words at once" in said.text
    reach = faults('profile = "bosch-system350-rk512"', "", block(words=129))["db.10.words"]
    assert "reaches DW 127" in str(reach) and "1..128 words" in str(reach)
    assert faults('profile = "bosch-system350-rk512"', "", block(words=128)) == {}


def test_a_block_nobody_could_reach_and_a_type_without_blocks() -> None:
    found = faults("", "", block(more='kind = "X"'))
    assert 'serves types = ["D"] only: the block cannot be reached' in str(found["db.10.kind"])
    assert faults("", '[line.rk512]\ntypes = ["D", "X"]', block(more='kind = "X"')) == {}
    (said,) = notices(cell("", '[line.rk512]\ntypes = ["D", "T"]'), "line plc")
    assert said.text == 'types has "T" and no [[db]] has kind = "T": every job to it gets 14h'
    assert "number = 0" in str(faults("", '[line.rk512]\ntypes = ["M"]', block(3, more='kind = "M"'))["db.3.number"])
    assert "1..255" in str(faults("", "", block(0))["db.0.number"])
    assert "BUEP64 carries data modules only" in str(faults('layer = "buep64"', '[line.rk512]\ntypes = ["M"]')["line.plc.rk512.types"])


def test_a_block_without_a_line_is_of_the_only_line_that_serves_blocks() -> None:
    """A cell with one BUEP64 line was told that several lines could serve its blocks."""
    free = block().replace('line = "plc"\n', "")
    assert free != block() and faults('layer = "buep64"\nprofile = "bosch-buep64"', "", free) == {}
    told = faults('layer = "program"', "", free)["db.10.line"]
    assert "no [[line]] serves data blocks" in str(told) and "several" not in str(told)


def test_the_same_number_as_db_and_dx_is_no_double() -> None:
    both = block() + block(more='kind = "X"')
    assert faults("", '[line.rk512]\ntypes = ["D", "X"]', both) == {}
    assert "is defined twice" in str(faults("", "", block() + block())["db.10.number"])


def test_everything_a_line_can_serve_is_played() -> None:
    line = '[line.rk512]\ntypes = ["D", "X", "E", "A", "M"]\ncoordination_flag = "keep"'
    played = cell('role = "both"', line, block(more="every_ms = 900"))
    assert not_playable(played) == []
    assert any("stays until" in notice.text for notice in notices(played, "line plc"))


def test_the_english_letters_mean_the_same() -> None:
    found = cell('role = "both"', '[line.rk512]\ntypes = ["DB", "DX", "I", "Q", "F", "T", "C"]', block(more='every_ms = 900\nflag="F6.4"'))
    assert found.line[0].rk512.types == ("D", "X", "E", "A", "M", "T", "Z")
    assert compile_job(found.db[0]).flag == Flag(6, 4)
    assert cell("", '[line.rk512]\ntypes = ["C"]', block(0, more='kind = "C"')).db[0].kind == "Z"
    said = str(faults("", '[line.rk512]\ntypes = ["P"]')["line.plc.rk512.types[0]"])
    assert "reserved for a later version" in said and "D | X | E | A | M | T | Z" in said


# ---- polling
def test_our_own_polling_beyond_the_line_is_refused_with_figures() -> None:
    blocks = block(10, 32, "plc", "every_ms = 100") + block(11, 32, "axisgate", "every_ms = 300")
    said = str(faults('role = "both"', "", blocks)["db.10.every_ms"])
    assert "FETCH 32 words 103 ms + SEND 32 words 103 ms at 9600 Bd fill the line to 138 %: not reachable" in said
    assert "expect 206..258 ms" in said
    slower = block(10, 32, "plc", "every_ms = 300") + block(11, 32, "axisgate", "every_ms = 300")
    assert faults('role = "both"', "", slower) == {}


# ---- overflow
@pytest.mark.parametrize(
    ("entry", "said"),
    [
        ('at = "DW 0", type = "KF", from = "cell.override", unit = "0.001 %"', "ends at 32.767 %, cell.override goes to 100 %"),
        ('at = "DR 0", type = "KH", from = "cell.life"', "cell.life goes to 32767; KH at DR 0 ends at 255"),
        ('at = "DW 0", type = "BCD", from = "cell.life"', "ends at 9999"),
    ],
)
def test_a_number_that_outgrows_its_place_is_refused(entry: str, said: str) -> None:
    found = faults("", "", block(more=f"entries = [{{ {entry} }}]"))
    assert [fault for fault in found.values() if said in str(fault)], found


def test_numbers_that_fit_are_taken() -> None:
    entries = ['at = "DW 0", type = "KF", from = "cell.life"', 'at = "DR 1", type = "KH", from = "cell.override", unit = "1 %"']
    assert faults("", "", block(more=f"entries = [{{ {entries[0]} }}, {{ {entries[1]} }}]")) == {}


def test_the_page_on_lines_is_a_cell_that_check_takes() -> None:
    page = (pathlib.Path(__file__).resolve().parents[4] / "docs/guide/lines.md").read_text(encoding="utf-8")
    tables = "\n".join(re.findall(r"```toml\n(.*?)```", page, re.DOTALL))
    found = load_cell("lines.toml", f'format = 1\n[cell]\nname = "page"\n{tables}')
    line, sent, fetched = found.line[0], found.db[0], found.db[1]
    assert (link_profile(line).ack_delay, line.role, line.choices.stray) == (ms(1000), "both", "silent")
    assert (sent.every_ms, sent.on_change, sent.at_partner, sent.flag) == (500, True, "DB20.DW0", "M 6.4")
    assert (fetched.writer, fetched.every_ms) == ("plc", 500)


# ---- explain
@pytest.mark.parametrize("word_", ["QVZ", "ADT", "zvz", "CDT", "BWZ", "Blockwartezeit"])
def test_a_time_is_explained_in_both_vocabularies_with_every_meaning_and_every_station(word_: str) -> None:
    timed = cell('profile = "siemens-cp341"', "[line.times]\nADT = 800\nreaction = 7000")
    lines = word(word_, timed)
    pairs = {"Q": ("QVZ", "ADT"), "A": ("QVZ", "ADT"), "Z": ("ZVZ", "CDT"), "C": ("ZVZ", "CDT"), "B": ("BWZ", "")}
    german, english = pairs[word_[0].upper()]
    assert lines[0].key == (f"{german} = {english}" if english else german)
    assert [line.key for line in lines[1:3]] == [f"{lines[0].key} also"] * 2
    stations = {line.key.removeprefix("profile "): line for line in lines if line.key.startswith("profile ")}
    assert set(stations) == set(PROFILES)
    field = {"QVZ": "ack_delay", "ZVZ": "char_delay", "BWZ": "block_wait"}[german]
    for name, line in stations.items():
        assert (float(line.value) * 1e6, line.unit) == (getattr(PROFILES[name], field), "ms")
        assert ("no source names it [open]" in line.source) is (field in PROFILES[name].open_fields)
    ours = lines[-1]
    expected = {"QVZ": ("800", "times.ADT"), "ZVZ": ("220", 'profile = "siemens-cp341"'), "BWZ": ("4000", "reaction: 7000 ms")}[german]
    assert (ours.key, ours.value) == ("line.plc", expected[0]) and expected[1] in ours.source


def test_the_second_meanings_are_those_of_the_sources() -> None:
    assert any("STX of the reaction telegram" in line.value for line in word("BWZ", None))
    assert any("does not acknowledge an access" in line.value for line in word("QVZ", None))
    sources = {line.key: line.source for line in word("BWZ", None)}
    assert sources["profile vipa-cp240"].startswith("reaction: 2000 ms") and "0..5100, step 20" in sources["profile vipa-cp240"]
    assert sources["profile bosch-system350-3964r"].startswith("no reaction telegrams")
    assert word("QVX", None) == []
