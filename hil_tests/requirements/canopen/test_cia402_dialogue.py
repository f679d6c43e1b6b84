"""hil_tests/vectors/cia402_dialogue.txt: the drive says exactly what the standard's tables want, and nothing else."""

import pathlib

import pytest

from drivers.emulator.servo.settings import DriveSettings, ServoSettings
from hil_tests.lab.virtual.canopen_bus import START, CanopenBus
from protocols.base.dialogue import Dialogue, Entry, parse
from protocols.base.machine import Frame

VECTORS = pathlib.Path(__file__).parents[2] / "vectors" / "cia402_dialogue.txt"
DIALOGUES = parse(VECTORS.read_text())


def frame_of(entry: Entry) -> Frame:
    identifier, _, data = entry.what.partition(" ")
    return Frame(int(identifier, 16), bytes.fromhex(data))


def play(dialogue: Dialogue) -> tuple[list[str], list[str]]:
    """What was said and what was to be said, as lines with times."""
    settings = ServoSettings(boot_s=float(dialogue.station["boot_ms"]) * 1e-3, charge_s=0.0, brake=False)
    bus = CanopenBus(DriveSettings(settings))
    expected = []
    for entry in dialogue.entries:
        bus.wake(START + entry.time)
        match entry.verb:
            case "hears":
                bus.hand(frame_of(entry))
            case "does":
                word, code = entry.what.split()
                assert word == "force_fault"
                bus.slave.force_fault(1, int(code, 16))
                bus.wake(bus.now)
            case "says":
                expected.append(line(frame_of(entry), entry.time))
    return [line(frame, frame.stamp_ns - START) for frame in bus.said], expected


def line(frame: Frame, time: int) -> str:
    return f"{time / 1e6:.3f} {frame.identifier:03X} {frame.data.hex(' ').upper()}"


@pytest.mark.parametrize("dialogue", DIALOGUES, ids=lambda dialogue: dialogue.name.split(":")[0])
def test_the_drive_says_what_the_standard_wants(dialogue: Dialogue) -> None:
    said, expected = play(dialogue)
    assert said == expected


def test_the_file_goes_through_every_transition_of_the_standard() -> None:
    """By the titles; what they promise, the bytes above prove."""
    titles = " ".join(dialogue.name for dialogue in DIALOGUES)
    numbers = {int(word) for word in titles.replace(",", " ").replace(":", " ").split() if word.isdigit()}
    assert set(range(17)) <= numbers
