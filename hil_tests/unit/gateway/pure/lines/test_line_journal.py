"""The journal of a real line says what the hand-written dialogues say."""

import io
from itertools import groupby

import pytest

from gateway.links.serial.dialogue_log import Journaled
from hil_tests.requirements.p3964r.test_manual_dialogues import DIALOGUES, station
from protocols.base.dialogue import Dialogue, Entry, parse, write
from protocols.base.machine import Damage, Ns


class FullDisk(io.StringIO):
    def write(self, text: str) -> int:
        raise OSError("no space left")


def played(dialogue: Dialogue, out: io.StringIO, start: Ns = 0) -> bytes:
    """The dialogue's outside, at a journaled station; what it said."""
    clock = [start]
    link = station(dialogue)
    machine = Journaled(link, out, dialogue.name, dialogue.station, lambda: clock[0])
    said = b""
    for moment, group in groupby(dialogue.entries, key=lambda entry: entry.time):
        now = clock[0] = start + moment
        machine.wake(now)
        for entry in group:
            match entry.verb, entry.what.split():
                case "hears", _:
                    machine.receive(entry.data, now)
                case "damaged", [kind]:
                    machine.damaged(Damage[kind], now)
                case "does", ["send", *block]:
                    link.send(bytes.fromhex("".join(block)), now)
                case "does", _:
                    link.take_block(now)
        machine.wake(now)
        spoken = machine.take_output()
        said += spoken
        if spoken or machine.deadline() is None:
            machine.sent(now)
    return said


def outside(entries: list[Entry]) -> list[tuple[Ns, str, str]]:
    """(time, verb, bytes or event) without the owner's wishes, in an order of their own; bytes of one moment in one piece."""
    return sorted((entry.time, entry.verb, entry.what.upper()) for entry in entries if entry.verb != "does")


@pytest.mark.parametrize("dialogue", [each for each in DIALOGUES if "keep_one" not in each.station], ids=lambda each: each.name[:40])
def test_the_journal_holds_what_the_manual_s_dialogue_holds(dialogue: Dialogue) -> None:
    out = io.StringIO()
    played(dialogue, out, start=7_000_000)
    (journal,) = parse(out.getvalue())
    assert (journal.name, journal.station["start_ns"], journal.station["profile"]) == (dialogue.name, "7000000", "rho3")
    assert outside(journal.entries) == outside(dialogue.entries)
    assert write([journal]) == out.getvalue()


def test_a_full_disk_ends_the_journal_and_not_the_line() -> None:
    assert played(DIALOGUES[0], FullDisk()) == played(DIALOGUES[0], io.StringIO()) != b""
