"""Plays hil_tests/vectors/3964r_rho3_manual.txt: every byte, event and silence at its moment."""

from itertools import groupby
from pathlib import Path

import pytest

from hil_tests.lab.virtual.bench import Bench
from protocols.base.dialogue import Dialogue, Entry, describe, line_of, parse
from protocols.base.errors import DecodeError
from protocols.base.machine import Damage, Ns, ms
from protocols.p3964r.link import Link
from protocols.p3964r.profiles import PROFILES, Priority

FILE = Path(__file__).parents[2] / "vectors" / "3964r_rho3_manual.txt"
DIALOGUES = parse(FILE.read_text())


def station(dialogue: Dialogue) -> Link:
    settings = dialogue.station
    return Link(PROFILES[settings["profile"]], Priority[settings["priority"].upper()], settings.get("keep_one") == "yes")


def happen(line: Bench[Link], entry: Entry) -> None:
    """What comes from outside."""
    match entry.verb, entry.what.split():
        case "hears", _:
            line.hears(entry.data)
        case "damaged", [kind]:
            line.damaged(Damage[kind])
        case "does", ["send", *block]:
            line.does(lambda link, now: link.send(bytes.fromhex("".join(block)), now))
        case "does", ["read"]:
            line.does(lambda link, now: link.take_block(now))


def play(dialogue: Dialogue) -> None:
    line = Bench(station(dialogue))
    last: Ns = 0
    for moment, group in groupby(dialogue.entries, key=lambda entry: entry.time):
        entries = list(group)
        if moment > 0:
            line.at(moment - 1).says(b"").reports()
        line.at(moment)
        for entry in entries:
            happen(line, entry)
        line.says(b"".join(entry.data for entry in entries if entry.verb == "says"))
        assert [describe(event) for event in line.told()] == [entry.what for entry in entries if entry.verb == "reports"]
        last = moment
    line.at(last + ms(3_000)).says(b"").reports()  # and then nothing more


@pytest.mark.parametrize("dialogue", DIALOGUES, ids=lambda dialogue: dialogue.name)
@pytest.mark.requirement("RHO-SER-01", "RHO-SER-10", "RHO-SER-12", by="protocols.p3964r.link:Link.receive")
def test_dialogue_of_the_manual(dialogue: Dialogue) -> None:
    play(dialogue)


def test_the_file_is_whole_and_written_as_the_journal_writes() -> None:
    assert len(DIALOGUES) == 14
    text = "\n".join(["dialogue one", *map(line_of, DIALOGUES[0].entries)])
    assert parse(text)[0].entries == DIALOGUES[0].entries


@pytest.mark.parametrize("text", ["1.0 hears 02", "dialogue a\n1 shouts 02", "dialogue a\n2 hears 02\n1 hears 02", "dialogue a\nx hears"])
def test_a_file_with_a_wrong_line_names_it(text: str) -> None:
    with pytest.raises(DecodeError, match="line "):
        parse(text)
